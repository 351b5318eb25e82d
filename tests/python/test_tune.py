"""Design to a target: the answers of ``admire tune``, as objects."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import admire

STUDY = "corpus/double-wishbone"


def test_a_study_with_a_target_alone_is_tuned() -> None:
    study = admire.Study(STUDY)
    found = study.tune(restarts=1, draws=20, pareto=(1, "bounce camber_angle.left, gradient"))
    assert found.converged and found.met and found.agreeing == 2
    assert found.goals[0].rms_after < found.goals[0].rms_before
    goal = found.json["goals"][0]
    assert goal["name"] == found.goals[0].name == "bounce toe_angle.left"
    np.testing.assert_array_equal(found.goals[0].after, [row["after"] for row in goal["rows"]])
    assert found.front is not None and len(found.front) == len(found.json["pareto"]["points"])
    # Along the front one miss grows and the other falls.
    assert (np.diff(found.front[:, 0]) >= 0).all() and (np.diff(found.front[:, 1]) <= 0).all()
    assert found.share is not None and found.share_drawn is not None and 0 <= found.share <= 1
    assert found.goals[0].share == found.json["robust"]["goals"][0]["share"]
    # What moved is in the deck, and in nothing else of it.
    for unknown in found.unknowns:
        for address, (before, after) in unknown.numbers.items():
            assert study.deck[address] == pytest.approx(before)
            assert found.deck[address] == pytest.approx(after)
    assert [change.address for change in study.deck.diff(found.deck)] != []
    with pytest.raises(admire.DeckError, match="only a target"):
        admire.identify(study)


def test_the_command_gives_the_same(tmp_path: Path, command: Callable[..., object]) -> None:
    found = admire.tune(STUDY, restarts=0, draws=10)
    ran = command("tune", STUDY, "--restarts", 0, "--draws", 10, "--out", tmp_path)
    assert ran.returncode == 0, ran.stderr  # type: ignore[attr-defined]
    assert json.loads((tmp_path / "tuning.json").read_text()) == found.json
    assert (tmp_path / "tuned.adm").read_text() == found.deck.text


def test_what_is_wrong_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(admire.AdmireError, match="not a goal of this target") as caught:
        admire.tune(STUDY, restarts=0, draws=0, pareto=("toe", 2))
    assert "1 \"bounce toe_angle.left\"" in str(caught.value)
    with pytest.raises(admire.AdmireError, match="same goal"):
        admire.tune(STUDY, restarts=0, draws=0, pareto=(1, "1"))
    with pytest.raises(admire.DeckError, match="no section"):
        admire.tune("corpus/pseudo-mcpherson")
    for name in ("model.adm", "kc.toml", "wanted.csv", "study.toml"):
        shutil.copy(Path(STUDY) / name, tmp_path)
    text = (tmp_path / "study.toml").read_text().replace("MARKER/141.QP", "MARKER/941.QP")
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(admire.DeckError, match="MARKER/941") as located:
        admire.tune(tmp_path)
    place = located.value.complaints[0].places[0]
    assert place.file.endswith("study.toml") and place.line is not None


def test_curves_are_plotted_before_and_after() -> None:
    pytest.importorskip("matplotlib").use("Agg")
    found = admire.tune(STUDY, restarts=0, draws=0)
    axes = found.plot()
    labels = [line.get_label() for line in axes.get_lines()]
    assert labels[:2] == ["before", "tuned"] and len(labels) == 3
    assert axes.get_ylabel() == "bounce toe_angle.left [deg]"
    # Limits have two lines.
    assert len(found.plot("bounce toe_angle.left, limits").get_lines()) == 4
    with pytest.raises(KeyError):
        found.plot("bounce toe")
    table = found.to_pandas()
    assert list(table.index) == [unknown.name for unknown in found.unknowns]
