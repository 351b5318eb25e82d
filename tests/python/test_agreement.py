"""The package and the command line give the same answers, bit for bit."""

import contextlib
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import admire

Command = Callable[..., "subprocess.CompletedProcess[str]"]

CASES = [
    ("double-wishbone", "states.acf", "model"),
    ("pseudo-mcpherson", "run.acf", "model"),
    ("multilink", "run.acf", "model"),
]


def without_dates(text: bytes) -> bytes:
    """When and where a run was is its own."""
    for name in (b"URI", b"publicationDate", b"executionDate"):
        text = re.sub(name + b'="[^"]*"', name + b'=""', text, count=1)
    return text


def without_time(page: str) -> str:
    """A report says when it was made."""
    return re.sub(r"\d\d:\d\d:\d\d UTC", "", page)


@pytest.mark.parametrize(("study", "commands", "stem"), CASES)
def test_the_results_file_is_the_same(study: str, commands: str, stem: str, corpus: Path, tmp_path: Path, command: Command) -> None:
    shutil.copytree(corpus / study, tmp_path / "study")
    folder = tmp_path / "study"
    if not (folder / commands).exists():
        (folder / commands).write_text(f"\nfile/model={stem}\nSIMULATE/STATICS\nSFORCE/1, FUNCTION=300\nSIMULATE/STATICS\n")
    deck = (folder / f"{stem}.adm").read_text(encoding="latin-1")
    if "RESULTS/" not in deck.upper():
        end = deck.upper().rindex("\nEND")
        (folder / f"{stem}.adm").write_text(deck[:end] + "\nRESULTS/XRF" + deck[end:], encoding="latin-1")
    done = command("solve", commands, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    (theirs,) = folder.glob("*.res")
    run = admire.read(folder / f"{stem}.adm").solve(file=folder / commands)
    run.write(tmp_path / "ours.res")
    assert without_dates((tmp_path / "ours.res").read_bytes()) == without_dates(theirs.read_bytes())
    for extension in run.files:
        written = theirs.with_suffix(f".{extension}")
        if extension == "req":
            assert run.file(extension).splitlines()[1:] == written.read_bytes().splitlines()[1:]


def test_values_and_differences_are_the_same(deck: admire.Deck, command: Command, tmp_path: Path) -> None:
    pattern = "BUSHING/*.K"
    told = json.loads(command("get", deck.name, pattern, "--format", "json").stdout)
    assert {address: list(value) for address, value in deck[pattern].items()} == told
    command("set", deck.name, "BUSHING/1.K.1=12345.678", "-o", tmp_path / "set.adm")
    deck["BUSHING/1.K.1"] = 12345.678
    assert bytes(deck) == (tmp_path / "set.adm").read_bytes()


def test_sensitivities_are_the_same(deck: admire.Deck, command: Command) -> None:
    words = ("sensitivity", deck.name, "--of", "BUSHING/1", "--by", "BUSHING/1", "--format", "json")
    told = json.loads(command(*words).stdout)
    table = deck.sensitivity(of="BUSHING/1", by="BUSHING/1")
    assert table.of == told["of"] and table.by == [row["by"] for row in told["rows"]]
    assert table.values.tolist() == [row["derivatives"] for row in told["rows"]]


def test_complaints_are_the_same(corpus: Path, command: Command) -> None:
    for path in sorted((corpus / "lint").glob("*.adm"))[::6]:
        told = json.loads(command("check", path, "--format", "json").stdout)
        found = admire.read(path).check()
        assert [(c.code, c.message) for c in found] == [(t["code"], t["message"]) for t in told], path


@pytest.mark.parametrize("method", ["direct", "gauss-newton"])
def test_an_identification_is_the_same(method: str, corpus: Path, command: Command, tmp_path: Path) -> None:
    study = corpus / "pseudo-mcpherson"
    done = command("identify", study, "--out", tmp_path / "out", "--method", method, "--format", "json")
    found = admire.identify(study, method=method)
    assert found.json == json.loads(done.stdout)
    assert bytes(found.deck) == (tmp_path / "out" / "identified.adm").read_bytes()
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert without_time(found.html) == without_time(report)


def test_repeats_of_a_fit_are_the_same(corpus: Path, command: Command, tmp_path: Path) -> None:
    study, out = corpus / "pseudo-mcpherson", tmp_path / "out"
    done = command("identify", study, "--out", out, "--bootstrap", 104, "--posterior", 104, "--seed", 3, "--format", "json")
    stages: list[str] = []
    found = admire.identify(
        study, bootstrap=104, posterior=104, seed=3, jobs=1, progress=lambda stage, *rest: stages.append(stage)
    )
    assert found.json == json.loads(done.stdout)
    report = (out / "report.html").read_text(encoding="utf-8")
    assert without_time(found.html) == without_time(report)
    first = found.parameters[0]
    assert first.profile95 is not None and first.posterior is not None and first.posterior.r_hat is not None
    assert found.bootstrap is not None and found.bootstrap.shape == (104, len(found.parameters))
    assert found.posterior is not None and found.posterior.shape == (104, len(found.parameters))
    assert first.bootstrap is not None and first.bootstrap.median == pytest.approx(np.median(found.bootstrap[:, 0]), rel=1e-3)
    assert {"bootstrap", "posterior"} & set(stages)
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    table = pandas.read_parquet(out / "bootstrap.parquet")
    assert table["BUSHING/1.K.1"].to_numpy().tobytes() == np.ascontiguousarray(found.bootstrap[:, 0]).tobytes()


def test_repeats_that_cannot_be_are_refused(corpus: Path) -> None:
    with pytest.raises(ValueError, match="from 100 to"):
        admire.identify(corpus / "pseudo-mcpherson", bootstrap=5)
    with pytest.raises(admire.DeckError, match="gauss-newton"):
        admire.identify(corpus / "pseudo-mcpherson", method="direct", posterior=200)
    with pytest.raises(ValueError, match="quick, held-out or folds"):
        admire.diagnose(corpus / "pseudo-mcpherson", check_gain="none")


def test_a_plan_is_the_same(corpus: Path, command: Command, tmp_path: Path) -> None:
    study, out = corpus / "pseudo-mcpherson", tmp_path / "out"
    done = command("plan", study, "--for", "stiffnesses", "--count", 6, "--out", out, "--format", "json")
    found = admire.plan(study, aim="stiffnesses", count=6)
    assert found.json == json.loads(done.stdout)
    assert found.suggested == (out / "suggested.csv").read_text(encoding="utf-8")
    first = found.candidates[0]
    assert first.sd_log[0] < found.sd_log[0] and first.what == found.json["candidates"][0]["what"]
    with pytest.raises(ValueError, match="stiffnesses, curves or causes"):
        admire.plan(study, aim="marks")


def test_an_axle_beside_others_is_the_same(corpus: Path, command: Command, tmp_path: Path) -> None:
    deck, config = corpus / "multilink" / "model.adm", corpus / "multilink" / "kc.toml"
    other = corpus / "multilink" / "reference.adm"
    alone = admire.kc(deck, config)
    (tmp_path / "measured.csv").write_text("test;value;toe_angle.left [deg]\nbounce;-10;0,02\nbounce;0;0,01\nbounce;10;0,00\n")
    words = ("kc", deck, "--config", config, "--out", tmp_path / "out", "--compare", other, "--measured", tmp_path / "measured.csv")
    assert command(*words).returncode == 0
    found = admire.kc(deck, config, compare=admire.read(other), measured=tmp_path / "measured.csv")
    assert found.values == alone.values and found.html != alone.html
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert without_time(found.html) == without_time(report)
    assert "softer" in admire.kc(deck, config, compare={"softer": admire.read(other)}).html
    (tmp_path / "wrong.csv").write_text("a,b\n1,2\n")
    with pytest.raises(admire.DeckError, match="column `test`"):
        admire.kc(deck, config, measured=tmp_path / "wrong.csv")
    assert command("convert-units", other, "--to", "mks", "-o", tmp_path / "metres.adm").returncode == 0
    scaled = admire.read(tmp_path / "metres.adm")
    with pytest.raises(admire.DeckError, match="the units of"):
        admire.kc(deck, config, compare=[scaled])


def test_axle_tests_are_the_same(corpus: Path, command: Command, tmp_path: Path) -> None:
    deck, config = corpus / "multilink" / "model.adm", corpus / "multilink" / "kc.toml"
    done = command("kc", deck, "--config", config, "--out", tmp_path / "out", "--format", "json")
    found = admire.kc(deck, config)
    assert found.values == json.loads(done.stdout)
    assert found.curves_csv == (tmp_path / "out" / "curves.csv").read_text(encoding="utf-8")


def without_seconds(summary: dict[str, object]) -> dict[str, object]:
    """A summary of a sweep but for the time that it took."""
    return {key: value for key, value in summary.items() if key != "seconds"}


def test_a_sweep_is_that_of_the_command(corpus: Path, tmp_path: Path, command: Command) -> None:
    shutil.copytree(corpus / "pseudo-mcpherson", tmp_path / "study")
    plan = tmp_path / "study" / "sweep.toml"
    plan.write_text(plan.read_text().replace("cases = 1000", "cases = 12"))
    answer = admire.sweep(plan, tmp_path / "package", jobs=2)
    assert answer is not None
    command("sweep", str(plan), "--out", str(tmp_path / "command"))
    own = without_seconds(answer.summary)
    assert own == without_seconds(json.loads((tmp_path / "command" / "summary.json").read_text()))
    assert answer.summary["statuses"] == {"ok": 12}
    # In shards, the second first.
    for number in (2, 1):
        assert admire.sweep(plan, tmp_path / "shards", shard=(number, 2)) is None
        with pytest.raises(admire.DeckError) if number == 2 else contextlib.nullcontext():
            assert admire.merge(tmp_path / "shards").summary["statuses"] == {"ok": 12}
    assert "<iframe" in answer._repr_html_()
    assert without_seconds(json.loads((tmp_path / "shards" / "summary.json").read_text())) == own
    with pytest.raises(admire.DeckError, match="changed since"):
        plan.write_text(plan.read_text().replace("seed = 1", "seed = 2"))
        admire.sweep(plan, tmp_path / "package")
