"""Comparisons, pages of mechanisms, virtual rigs and new studies."""

from collections.abc import Callable
from pathlib import Path

import pytest

import admire


def test_results_are_compared_as_on_the_command_line(
    deck: admire.Deck, tmp_path: Path, command: Callable[..., object]
) -> None:
    first, second = deck.solve(), deck.solve({"SFORCE/3": 1000.0})
    assert admire.compare(first, first)
    found = admire.compare(first, second)
    assert not found and found.json["columns"]
    assert admire.compare(first, second, atol=1e9)
    first.write(tmp_path / "a.res")
    second.write(tmp_path / "b.res")
    assert admire.compare(tmp_path / "a.res", admire.results(tmp_path / "b.res")).json == found.json
    printed = command("compare", tmp_path / "a.res", tmp_path / "b.res", "--format", "json")
    import json

    assert json.loads(printed.stdout) == found.json  # type: ignore[attr-defined]


def test_a_mechanism_is_a_page(deck: admire.Deck, tmp_path: Path) -> None:
    page = admire.view(deck, deck.solve({"SFORCE/3": 1000.0}), highlight=["BUSHING/1"])
    still = admire.view(deck)
    assert "srcdoc" in page._repr_html_() and len(page.html) > len(still.html)
    page.save(tmp_path / "view.html")
    with pytest.raises(FileExistsError):
        page.save(tmp_path / "view.html")
    page.save(tmp_path / "view.html", overwrite=True)
    assert "srcdoc" in deck._repr_html_()
    with pytest.raises(admire.AdmireError, match="BUSHING/99"):
        admire.view(deck, highlight=["BUSHING/99"])


def test_a_virtual_rig_delivers_what_the_command_line_does(
    corpus: Path, tmp_path: Path, command: Callable[..., object]
) -> None:
    effect = "dry-friction@JOINT/3:force=120,stiffness=3000"
    made = admire.rig(corpus / "kc-curves", tmp_path / "python", seed=3, effects=effect)
    assert "dry-friction" in made.truth
    command("rig", corpus / "kc-curves", "--out", tmp_path / "cli", "--seed", "3", "--effect", effect)
    assert (tmp_path / "python" / "kc.csv").read_bytes() == (tmp_path / "cli" / "kc.csv").read_bytes()
    with pytest.raises(FileExistsError):
        admire.rig(made.study, tmp_path / "python")
    with pytest.raises(ValueError, match="nonsense"):
        admire.rig(made.study, tmp_path / "other", effects="nonsense")
    assert not (tmp_path / "other").exists()


def test_a_study_begins(deck: admire.Deck, tmp_path: Path) -> None:
    written = admire.new(tmp_path / "axle", deck, measured=["marks", "curves"], bushings=["BUSHING/1"])
    names = {Path(path).name for path in written}
    assert {"study.toml", "load_cases.csv", "kc.csv", "marks_measured.csv", "model.adm"} <= names
    text = (tmp_path / "axle" / "study.toml").read_text()
    assert 'bushings = ["BUSHING/1"]' in text and (tmp_path / "axle" / "model.adm").read_bytes() == bytes(deck)
    with pytest.raises(FileExistsError):
        admire.new(tmp_path / "axle", deck)
    with pytest.raises(ValueError, match="marks"):
        admire.new(tmp_path / "other", deck, measured="everything")
