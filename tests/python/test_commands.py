"""The commands `admire` and `mdi` that the wheel installs beside the interpreter."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import admire

CORPUS = Path("corpus/pseudo-mcpherson").resolve()
FOLDER = Path(sys.executable).parent


def run(name: str, *arguments: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    program = shutil.which(name, path=str(FOLDER))
    assert program, f"{name} is not in {FOLDER}"
    return subprocess.run(
        [program, *arguments],
        cwd=folder,
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        encoding="utf-8",
    )


def test_the_commands_answer_as_the_package_does(tmp_path: Path) -> None:
    shutil.copytree(CORPUS, tmp_path, dirs_exist_ok=True)
    assert admire.__version__ in run("admire", "--version", folder=tmp_path).stdout
    said = run("admire", "get", "model.adm", "BUSHING/1.K.1", folder=tmp_path)
    assert said.returncode == 0
    assert float(said.stdout.split("=")[-1]) == admire.read(tmp_path / "model.adm")["BUSHING/1.K.1"]
    # The codes of a problem in the input and of a wrong command line.
    assert run("admire", "get", "model.adm", "BUSHING/99.K.1", folder=tmp_path).returncode == 1
    assert run("admire", "no-such-command", folder=tmp_path).returncode == 2
    solved = run("mdi", "-c", "ru-standard", "i", "lateral.acf", "exit", folder=tmp_path)
    assert solved.returncode == 0
    assert admire.results(tmp_path / "model.res").kinds


def test_shims_and_completion_find_the_commands_of_the_wheel(tmp_path: Path) -> None:
    made = run("admire", "install-shims", "shims", "--names", "mdi", folder=tmp_path)
    assert made.returncode == 0, made.stderr
    assert str(FOLDER.resolve()) in (tmp_path / "shims" / "mdi.bat").read_text()
    words = ["--", "admire", "ident"]
    found = run("admire", *words, folder=tmp_path, COMPLETE="bash", _CLAP_COMPLETE_INDEX="1", _CLAP_IFS="\n")
    assert found.stdout.split() == ["identify"], found


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_ends_a_command_at_once(tmp_path: Path) -> None:
    # Without commands on the way, `mdi` waits for them.
    program = shutil.which("mdi", path=str(FOLDER))
    assert program
    waiting = subprocess.Popen([program], cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    time.sleep(2)
    waiting.send_signal(signal.SIGINT)
    assert waiting.wait(10) == -signal.SIGINT
