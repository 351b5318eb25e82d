"""Ctrl-C, the lock of the interpreter, other processes, types, documents."""

import doctest
import importlib
import importlib.util
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import admire

LONG = """
import os, signal, sys, threading, time
import admire
# A shell that runs the tests in the background has its children ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
deck = admire.read("corpus/pseudo-mcpherson/model.adm")
commands = "SIMULATE/STATICS, END=1, STEPS=100000\\n"
threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT)).start()
began = time.monotonic()
try:
    {work}
except KeyboardInterrupt:
    print(time.monotonic() - began - 0.7)
    # The next work begins at once.
    deck.solve()
    print(time.monotonic() - began - 0.7)
    os._exit(0)
print("ended by itself")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize("work", ["deck.solve(commands=commands)", "admire.diagnose('corpus/kc-experiment')"])
def test_ctrl_c_is_heard_within_a_second(work: str) -> None:
    done = subprocess.run([sys.executable, "-c", LONG.format(work=work)], capture_output=True, text=True, timeout=120)
    after, _ = map(float, done.stdout.split())
    assert after < 1.0


def test_other_threads_run_meanwhile(deck: admire.Deck) -> None:
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    deck.solve(commands="SIMULATE/STATICS, END=1, STEPS=1000\n")
    done.set()
    counter.join()
    assert counted > 10


def test_progress_is_told() -> None:
    told: list[tuple[str, str, int, int | None]] = []
    admire.identify("corpus/multilink", progress=lambda *words: told.append(words))
    assert told and all(isinstance(stage, str) for stage, *_ in told)
    with pytest.raises(ZeroDivisionError):
        admire.identify("corpus/multilink", progress=lambda *words: 1 / 0)


def variant(deck: admire.Deck, k: float) -> bytes:
    deck = deck.copy()
    deck["BUSHING/1.K.1"] = k
    return deck.solve().values.tobytes()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_children_of_fork_work_too(deck: admire.Deck) -> None:
    alone = [variant(deck, k) for k in (9000.0, 10000.0)]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.starmap_async(variant, [(deck, 9000.0), (deck, 10000.0)]).get(timeout=60) == alone


def test_joblib_is_bitwise_a_serial_loop(deck: admire.Deck) -> None:
    joblib = pytest.importorskip("joblib")
    values = [8000.0 + 10.0 * k for k in range(200)]
    alone = [variant(deck, k) for k in values]
    found = joblib.Parallel(n_jobs=2)(joblib.delayed(variant)(deck, k) for k in values)
    assert found == alone


def test_dask_is_bitwise_a_serial_loop(deck: admire.Deck) -> None:
    distributed = pytest.importorskip("dask.distributed")
    values = [8000.0 + 10.0 * k for k in range(100)]
    alone = [variant(deck, k) for k in values]
    with distributed.LocalCluster(n_workers=2, threads_per_worker=2, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            assert client.gather(client.map(variant, [deck] * len(values), values)) == alone


def test_the_documents_of_every_module_run() -> None:
    for name in ("admire", "admire._deck", "admire._run", "admire._study", "admire._tools"):
        found = doctest.testmod(importlib.import_module(name))
        assert found.attempted and not found.failed, name


def test_types_are_strict(tmp_path: Path) -> None:
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("mypy is not installed")
    user = tmp_path / "user.py"
    user.write_text(
        "import numpy as np\nfrom numpy.typing import NDArray\nimport admire\n"
        "def f(path: str) -> NDArray[np.float64]:\n"
        "    deck = admire.read(path)\n    deck['BUSHING/1.K.1'] = 1.0\n    deck['BUSHING/1.K'] = np.ones(3)\n"
        "    found = admire.identify('study')\n    text: str = found.parameters[0].status\n"
        "    return deck.solve({'SFORCE/3': 1.0})['KNUCKLE.X']\n"
    )
    words = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports"]
    words += ["-p", "admire", "--cache-dir", str(tmp_path / "cache")]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    words = [*words[:5], str(user), "--cache-dir", str(tmp_path / "cache")]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_the_walk_through_the_tutorial_runs() -> None:
    script = Path(__file__).with_name("tutorial.py")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_change_is_not_taken_for_a_number(tmp_path: Path) -> None:
    study = tmp_path / "study"
    shutil.copytree("corpus/pseudo-mcpherson", study)
    with (study / "study.toml").open("a") as settings:
        settings.write('\n[[identify.unknown]]\nnumbers = ["MARKER/16.QP.3"]\nsd = "3 mm"\n')
    found = admire.identify(str(study))
    change = found["MARKER/16.QP.3"]
    assert change.form == "change" and change.initial == 0.0 and found["BUSHING/1.K.1"].form is None
    assert "MARKER/16.QP.3" in change.numbers and len(change.numbers) > 1
    for address, (before, after) in change.numbers.items():
        assert after != before and found.deck[address] == pytest.approx(after)
    before, after = change.numbers["MARKER/16.QP.3"]
    assert after - before == pytest.approx(change.value)
