"""Plots, datasets, units of frames, completion of keys, lists of objects, and what matplotlib and xarray are needed for."""

import sys
from pathlib import Path

import numpy as np
import pytest

import admire

COMMANDS = "SIMULATE/STATICS\nSFORCE/3, FUNCTION=2000\nSIMULATE/STATICS\n"


def test_frames_and_datasets_carry_units(deck: admire.Deck, tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    run = deck.solve(commands=COMMANDS)
    frame = run.to_pandas("BUSHING/1.FX", "KNUCKLE.X")
    units = frame.attrs["units"]
    assert sorted(units.values()) == ["mm", "newton", "sec"] and set(frame.columns) - {"step"} < set(units)
    run.write(tmp_path / "run.res")
    assert admire.results(tmp_path / "run.res").to_pandas("BUSHING/1.FX", "KNUCKLE.X").attrs["units"] == units
    pytest.importorskip("xarray")
    data = run.to_xarray("BUSHING/1.FX")
    (name,) = data.data_vars
    assert data[name].attrs["units"] == "newton" and list(data["kind"].values) == run.kinds
    assert np.array_equal(data[name].values, run["BUSHING/1.FX"])


def test_curves_of_an_axle_are_plotted_with_their_units(deck: admire.Deck, corpus: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    tests = deck.kc(corpus / "pseudo-mcpherson" / "kc.toml")
    toe, camber = tests.plot(["toe_angle", "camber_angle"], test="roll")
    assert toe.get_ylabel() == "toe_angle [deg]" and camber.get_xlabel() == "roll [mm]"
    assert [line.get_label() for line in toe.get_lines()] == ["toe_angle.left", "toe_angle.right"]
    one = tests.plot("toe_angle.left", test="roll")
    drawn = one.get_lines()[0].get_ydata()
    assert np.array_equal(drawn, toe.get_lines()[0].get_ydata()) and len(drawn) > 10
    for test, characteristic in (("nothing", "toe_angle"), ("roll", "nothing")):
        with pytest.raises(KeyError):
            tests.plot(characteristic, test=test)
    if pytest.importorskip("xarray"):
        data = tests.to_xarray("roll")
        assert data["toe_angle.left"].attrs["units"] == "deg" and data["value"].attrs["units"] == "mm"
        assert np.array_equal(data["toe_angle.left"].values, drawn)


def test_columns_of_a_run_have_a_chart_for_each_unit(deck: admire.Deck) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    run = deck.solve(commands=COMMANDS)
    axes = run.plot("BUSHING/1.F?", "KNUCKLE.X", x="SFORCE/3.FZ")
    assert len(axes) == 2 and axes[1].get_xlabel().endswith("FZ [newton]")
    alone = run.plot("KNUCKLE.X", ax=axes[0])
    assert alone is axes[0]
    with pytest.raises(ValueError, match="2 axes"):
        run.plot("BUSHING/1.FX", "KNUCKLE.X", ax=axes[0])


def test_answers_of_studies_are_plotted(corpus: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    found = admire.identify(corpus / "pseudo-mcpherson", method="direct")
    labels = [label.get_text() for label in found.plot().get_yticklabels()]
    assert labels == [parameter.address for parameter in found.parameters]
    assert found._ipython_key_completions_() == labels


def test_what_is_missing_is_said(deck: admire.Deck, monkeypatch: pytest.MonkeyPatch) -> None:
    run = deck.solve()
    for module, work, extra in (
        ("matplotlib.pyplot", lambda: run.plot("KNUCKLE.X"), "plot"),
        ("xarray", run.to_xarray, "xarray"),
        ("pandas", run.to_pandas, "pandas"),
    ):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(ImportError, match=rf"pip install admire\[{extra}\]"):
            work()


def test_objects_are_listed_and_completed(deck: admire.Deck) -> None:
    assert deck.bushings == ["BUSHING/1", "BUSHING/2", "BUSHING/3"]
    assert deck.objects("bushing") == deck.bushings and deck.objects("BEAM") == []
    assert set(deck.forces) == {"SFORCE/1", "SFORCE/2", "SFORCE/3"} and "PART/1" in deck.parts
    keys = deck._ipython_key_completions_()
    assert "BUSHING/2.KT" in keys and "SFORCE/3" in keys
    for key in keys:
        assert deck[key] is not None, key
    run = deck.solve()
    names = run._ipython_key_completions_()
    assert len(names) > 100 and all(name in run for name in names)
    pytest.importorskip("pandas")
    frame = deck.bushings.to_pandas("K.1", "KT")
    assert frame.loc["BUSHING/2", "K.1"] == deck["BUSHING/2.K.1"]


def test_a_deck_is_made_of_its_text(deck: admire.Deck) -> None:
    again = admire.Deck.from_string(deck.text, name="copy.adm")
    assert again == deck and again.name == "copy.adm"
    assert again.solve().values.tobytes() == deck.solve().values.tobytes()
    broken = admire.Deck.from_string(b"title\nBUSHING/1, K=\nEND\n")
    assert broken.check()


def test_solve_takes_each_by_its_keyword(deck: admire.Deck, tmp_path: Path) -> None:
    file = tmp_path / "run.acf"
    file.write_text("\n" + COMMANDS)
    by_file, by_text = deck.solve(file=file), deck.solve(commands=COMMANDS)
    assert by_file.values.tobytes() == by_text.values.tobytes()
    # Values count in the commands, too, and the deck stays as it is.
    loaded = deck.solve({"SFORCE/1": 500.0}, commands=COMMANDS)
    assert loaded.values.tobytes() != by_text.values.tobytes() and deck["SFORCE/1"] != 500.0
    for wrong in ("run.acf", COMMANDS, file):
        with pytest.raises(TypeError, match="file="):
            deck.solve(wrong)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="not both"):
        deck.solve(file=file, commands=COMMANDS)
