"""The tests run on an installed wheel, from the root of the project: see README.md."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import admire

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.fixture
def corpus() -> Path:
    return ROOT / "corpus"


@pytest.fixture
def deck(corpus: Path) -> admire.Deck:
    return admire.read(corpus / "pseudo-mcpherson" / "model.adm")


@pytest.fixture(scope="session")
def command() -> Callable[..., "subprocess.CompletedProcess[str]"]:
    """Runs the command line beside the package."""
    program = os.environ.get("ADMIRE", str(ROOT / "target" / "debug" / "admire"))
    if not shutil.which(program):
        if os.environ.get("CI"):
            pytest.fail(f"the command line is not built: {program}")
        pytest.skip(f"the command line is not built: {program}")

    def run(*words: object, **options: object) -> "subprocess.CompletedProcess[str]":
        texts = [program, *map(str, words)]
        return subprocess.run(texts, capture_output=True, text=True, stdin=subprocess.DEVNULL, **options)  # type: ignore[call-overload,no-any-return]

    return run
