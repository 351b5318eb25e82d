"""Runs in memory, results files, sensitivities."""

import pickle
import threading
from pathlib import Path

import numpy as np
import pytest

import admire

ACF = "SFORCE/3, FUNCTION=1000\nSIMULATE/STATICS\nSFORCE/3, FUNCTION=2000\nSIMULATE/STATICS\n"


def test_columns_are_lent_and_read_only(deck: admire.Deck) -> None:
    run = deck.solve()
    column = run["BUSHING/1.FX"]
    assert column.base is not None and np.shares_memory(column, run.values)
    with pytest.raises(ValueError):
        column[0] = 1.0
    del run
    assert np.isfinite(column).all()
    with pytest.raises(KeyError, match="did you mean"):
        deck.solve()["BUSHING/1.FQ"]


def test_loads_are_given_without_changing_the_deck(deck: admire.Deck) -> None:
    before = bytes(deck)
    loaded = deck.solve({"SFORCE/3": 1000.0})
    assert bytes(deck) == before
    by_commands = deck.solve(commands=ACF)
    assert by_commands.kinds == ["input", "static", "static"]
    other = deck.copy()
    other["SFORCE/3"] = 1000.0
    assert loaded.values.tobytes() == other.solve().values.tobytes()
    assert np.allclose(loaded.values[-1], by_commands.values[1], rtol=1e-7, atol=1e-7)
    assert not np.allclose(by_commands.values[1], by_commands.values[2])


def test_what_has_no_answer_raises_and_keeps_its_run(deck: admire.Deck) -> None:
    with pytest.raises(admire.SolveError) as caught:
        deck.solve({"SFORCE/3": 1e12})
    assert "converge" in str(caught.value)
    assert caught.value.run.exit_code == 3
    run = deck.solve(commands="SFORCE/3, FUNCTION=1e12\nSIMULATE/STATICS\n", check=False)
    assert run.exit_code == 3 and run.complaints
    with pytest.raises(admire.DeckError, match="NONSENSE"):
        deck.solve(commands="NONSENSE/3\nSIMULATE/STATICS\n")


def test_runs_pickle_whole(deck: admire.Deck, tmp_path: Path) -> None:
    run = deck.solve(commands=ACF)
    again = pickle.loads(pickle.dumps(run))
    assert again.values.tobytes() == run.values.tobytes()
    assert (again.columns, again.units, again.kinds) == (run.columns, run.units, run.kinds)
    run.write(tmp_path / "a.res")
    first = (tmp_path / "a.res").read_bytes()
    again.write(tmp_path / "a.res", overwrite=True)
    assert (tmp_path / "a.res").read_bytes() == first


def test_results_are_read_back(deck: admire.Deck, tmp_path: Path) -> None:
    run = deck.solve(commands=ACF)
    path = tmp_path / "run.res"
    run.write(path)
    with pytest.raises(FileExistsError):
        run.write(path)
    results = admire.results(path)
    assert results.columns == run.columns and results.units == run.units
    # 17 decimals are written.
    assert np.allclose(results["BUSHING/1.FX"], run["BUSHING/1.FX"], rtol=1e-15, atol=1e-16)
    some = results.select("BUSHING/1.F?", steps="last")
    assert len(some) >= 3 and all(len(column) == 1 for column in some.values())
    assert results.select("BUSHING/1.FX", kind="static")[list(some)[0]].shape == (2,)
    with pytest.raises(KeyError):
        results["nothing"]
    with pytest.raises(ValueError):
        results.select("*", steps="0")


def test_a_cut_off_file_is_read_up_to_its_last_step(deck: admire.Deck, tmp_path: Path) -> None:
    path = tmp_path / "run.res"
    deck.solve(commands=ACF).write(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: whole.rindex(b"<Step") + 400])
    assert len(admire.results(path).time) == 2
    path.write_bytes(b"not results")
    with pytest.raises(admire.DeckError):
        admire.results(path)


def test_frames_have_time_and_kind(deck: admire.Deck) -> None:
    pandas = pytest.importorskip("pandas")
    frame = deck.solve(commands=ACF).to_pandas("BUSHING/1.F?")
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame["step"]) == ["input", "static", "static"]


def test_sensitivities_are_those_of_differences(deck: admire.Deck) -> None:
    table = deck.sensitivity(of="BUSHING/1", by="BUSHING/1.K")
    assert table.values.shape == (len(table.by), 6) and np.asarray(table) is table.values
    k = deck["BUSHING/1.K.1"]
    step = 1e-4 * k
    high = deck.solve({"BUSHING/1.K.1": k + step})["BUSHING/1.FX"][-1]
    low = deck.solve({"BUSHING/1.K.1": k - step})["BUSHING/1.FX"][-1]
    numeric = (high - low) / (2 * step)
    exact = table[table.by[0], table.of[0]]
    assert exact != 0.0 and abs(numeric - exact) <= 1e-3 * abs(exact) + 1e-9


def test_threads_share_a_deck(deck: admire.Deck) -> None:
    alone = {load: deck.solve({"SFORCE/3": load}).values.tobytes() for load in range(0, 800, 100)}
    found: dict[float, bytes] = {}

    def solve(load: float) -> None:
        found[load] = deck.solve({"SFORCE/3": load}).values.tobytes()

    threads = [threading.Thread(target=solve, args=(load,)) for load in alone]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == alone
