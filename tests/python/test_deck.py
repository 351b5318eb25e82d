"""Values of decks by address."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import admire


def test_values_are_read_and_set_by_address(deck: admire.Deck) -> None:
    before = bytes(deck)
    assert deck["BUSHING/1.K.1"] == 10000.0
    assert "BUSHING/1" in deck and "BUSHING/99" not in deck and "BUSHING/1.KK" not in deck
    assert isinstance(deck["BUSHING/1.K"], np.ndarray)
    deck["BUSHING/1.K.1"] = 12000.0
    assert deck["BUSHING/1.K.1"] == 12000.0
    deck["BUSHING/1.K.1"] = 10000.0
    assert deck["BUSHING/1.K.1"] == 10000.0
    assert len(bytes(deck)) == len(before)
    deck["BUSHING/1.K"] = np.array([1.0, 2.5, 1e7])
    assert list(deck["BUSHING/1.K"]) == [1.0, 2.5, 1e7]
    deck["TITLE"] = "another"
    assert deck.title == "another"


def test_patterns_name_many(deck: admire.Deck) -> None:
    before = deck["BUSHING/*.K.1"]
    assert len(before) > 1 and all(address.startswith("BUSHING/") for address in before)
    deck["BUSHING/*.K.1"] *= 1.25
    after = deck["BUSHING/*.K.1"]
    assert {a: after[a] / before[a] for a in before} == dict.fromkeys(before, 1.25)
    deck["BUSHING/*.K.1"] = 5000.0
    assert set(deck["BUSHING/*.K.1"].values()) == {5000.0}


def test_many_are_set_all_or_none(deck: admire.Deck) -> None:
    before = bytes(deck)
    with pytest.raises(admire.AddressError):
        deck.update({"BUSHING/1.K.1": 1.0, "BUSHING/99.K.1": 1.0})
    assert bytes(deck) == before


def test_what_means_nothing_is_a_key_error_that_helps(deck: admire.Deck) -> None:
    with pytest.raises(KeyError) as caught:
        deck["BUSHING/1.KK"]
    assert "BUSHING has no argument KK" in str(caught.value)
    assert isinstance(caught.value, admire.AdmireError)
    assert caught.value.complaints[0].code == "unknown-argument"
    with pytest.raises(FileNotFoundError):
        admire.read("no such deck.adm")


def test_a_value_that_breaks_the_deck_is_refused(deck: admire.Deck) -> None:
    before = bytes(deck)
    for value in ["1, 2, 3\nEND", "2*TIME)"]:
        with pytest.raises(admire.AdmireError):
            deck["SFORCE/3.FUNCTION"] = value
    with pytest.raises(admire.AdmireError):
        deck["BUSHING/1.K.1"] = float("nan")
    assert bytes(deck) == before


def test_errors_have_places(tmp_path: Path) -> None:
    path = tmp_path / "bad.adm"
    path.write_text("title\nPART/1, GROUND\nMARKER/2, PART=7\nEND\n")
    deck = admire.read(path)
    found = [c for c in deck.check() if c.code == "undefined-id"]
    assert found[0].severity == "error" and found[0].places[0].line == 3
    with pytest.raises(admire.DeckError) as caught:
        deck.solve()
    assert ":3:" in str(caught.value)
    file, start, end = caught.value.spans[0]
    assert file == str(path) and path.read_bytes()[start:end].startswith(b"7")
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.spans == caught.value.spans


def test_saving_replaces_nothing_by_accident(deck: admire.Deck, tmp_path: Path) -> None:
    mine, other = tmp_path / "mine.adm", tmp_path / "other.adm"
    deck.save(mine)
    deck["BUSHING/1.K.1"] = 7.0
    deck.save()
    assert admire.read(mine)["BUSHING/1.K.1"] == 7.0
    other.write_text("not ours")
    with pytest.raises(FileExistsError):
        deck.save(other)
    assert other.read_text() == "not ours"
    deck.save(other, overwrite=True)
    assert other.read_bytes() == bytes(deck)
    # Somebody else writes the file meanwhile.
    other.write_bytes(bytes(deck).replace(b"END", b"! a remark\nEND"))
    deck["BUSHING/1.K.1"] = 8.0
    with pytest.raises(FileExistsError):
        deck.save()
    # A fault that the file had not.
    fresh = admire.read(mine)
    fresh["BUSHING/1.K.1"] = -8.0
    with pytest.raises(admire.DeckError):
        fresh.save()
    assert admire.read(mine)["BUSHING/1.K.1"] == 7.0
    fresh.save(force=True)
    assert admire.read(mine)["BUSHING/1.K.1"] == -8.0


def test_decks_differ_by_what_was_set(deck: admire.Deck) -> None:
    other = copy.deepcopy(deck)
    assert other == deck and deck.diff(other) == []
    other["BUSHING/1.K.2"] = 11000.0
    (change,) = deck.diff(other)
    assert (change.address, change.kind, change.before, change.after) == ("BUSHING/1.K.2", "number", 10000.0, 11000.0)
    assert deck.diff(other, rtol=0.2) == []


def test_decks_pickle_with_their_bytes(deck: admire.Deck) -> None:
    deck["BUSHING/1.K.1"] = 0.1
    again = pickle.loads(pickle.dumps(deck))
    assert bytes(again) == bytes(deck) and again.name == deck.name
    assert again.solve().values.tobytes() == deck.solve().values.tobytes()
