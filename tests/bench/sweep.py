"""Sweeps at full size: the same bits in any sharding and in single runs, rate on two cores, memory, runs that are killed.

    pip install . pandas pyarrow && cargo build --release
    python tests/bench/sweep.py [--admire PATH] [--cases 10000] [--many 100000] [--rounds 5] [--kills 200]

Rates are those of interleaved runs, so that other work on the machine meets all alike; processor time is told beside the wall time.
"""

import argparse
import os
import statistics
import subprocess
import tempfile
import time

import numpy
import pandas

import admire

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
STUDY = os.path.join(ROOT, "corpus", "pseudo-mcpherson")
OWN = ["seconds"]


def plan(folder, cases):
    """The tolerances of the McPherson axle with so many cases, in a folder of its own."""
    with open(os.path.join(STUDY, "sweep.toml"), encoding="utf-8") as file:
        text = file.read()
    for name in ("model.adm", "lateral.acf"):
        with open(os.path.join(STUDY, name), "rb") as source, open(os.path.join(folder, name), "wb") as copy:
            copy.write(source.read())
    path = os.path.join(folder, f"sweep-{cases}.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text.replace("cases = 1000", f"cases = {cases}"))
    return path


def start(words):
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def wait(processes):
    """Seconds of processor time of processes that were started."""
    busy = 0.0
    for process in processes:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0, process.args
        busy += used.ru_utime + used.ru_stime
    return busy


def most_memory(process):
    """The largest memory of a process in MB, by what Linux tells of it; getrusage would count that of Python before its exec."""
    most = 0.0
    while process.poll() is None:
        try:
            with open(f"/proc/{process.pid}/status", encoding="ascii") as file:
                told = [line.split() for line in file]
        except FileNotFoundError:
            continue
        most = max([most, *(float(words[1]) / 1024 for words in told if words[0] == "VmHWM:")])
        time.sleep(0.005)
    assert process.returncode == 0, process.args
    return most


def table(folder):
    return pandas.read_parquet(os.path.join(folder, "results.parquet")).drop(columns=OWN)


def same(a, b):
    """The same bits, column by column; an empty place is like another."""
    if list(a.columns) != list(b.columns) or len(a) != len(b):
        return False
    for name in a.columns:
        left, right = a[name].to_numpy(), b[name].to_numpy()
        if left.dtype == numpy.float64:
            left, right = left.view(numpy.int64), right.view(numpy.int64)
        if left.dtype == object:
            left, right = a[name].fillna("").to_numpy(), b[name].fillna("").to_numpy()
        if not (left == right).all():
            return False
    return True


def shardings(program, path, folder, cases):
    whole = os.path.join(folder, "whole")
    wait([start([program, "sweep", path, "--out", whole, "--jobs", "2"])])
    expected = table(whole)
    for shards, jobs in ((2, 1), (7, 3), (64, 2)):
        out = os.path.join(folder, f"shards-{shards}")
        for number in range(shards, 0, -1):
            wait([start([program, "sweep", path, "--out", out, "--shard", f"{number}/{shards}", "--jobs", str(jobs)])])
        wait([start([program, "merge", out])])
        print(f"{cases} cases in {shards} shards, {jobs} at a time: the same bits as in one: {same(expected, table(out))}")
    return expected


def singles(expected):
    """Each case as a run of its own, from numbers of the table, by the package: another way through files, numbers and columns."""
    deck = admire.read(os.path.join(STUDY, "model.adm"))
    commands = os.path.join(STUDY, "lateral.acf")
    wrong = 0
    names = ["bushing_A_radial", "bushing_B_radial", "strut_mount", "arm_front_z", "rod_hardness"]
    kept = ["height_vertical", "psi_lateral", "shift_lateral"]
    numbers, answers = expected[names].to_numpy(), expected[kept].to_numpy()
    begin = time.perf_counter()
    for values, answer in zip(numbers, answers):
        a, b, mount, z, rod = (float(value) for value in values)
        variant = deck.copy()
        for address, factor in (("BUSHING/1.K.1", a), ("BUSHING/1.K.2", a), ("BUSHING/2.K.1", b), ("BUSHING/2.K.2", b), ("BUSHING/3.K.1", mount), ("BUSHING/3.K.2", mount), ("BUSHING/3.K.3", mount)):
            variant[address] = deck[address] * factor
        variant["MARKER/2.QP.3"] = deck["MARKER/2.QP.3"] + z
        variant["BUSHING/1.K.3"] = rod
        run = variant.solve(commands)
        height, psi, y = (run[f"KNUCKLE_XFORM.{name}"][1:] for name in ("Z", "PSI", "Y"))
        single = numpy.array([height[0], psi[-1], y.max() - y.min()])
        wrong += single.tobytes() != answer.tobytes()
    print(f"{len(numbers)} single runs by the package in {time.perf_counter() - begin:.0f} s: {len(numbers) - wrong} with the same bits, {wrong} with others")


def rates(program, path, folder, cases, rounds):
    """Two threads of one process against two processes of one thread, each with half of the cases."""
    both = []
    for k in range(rounds):
        one, two = os.path.join(folder, f"one-{k}"), os.path.join(folder, f"two-{k}")
        begin = time.perf_counter()
        busy = wait([start([program, "sweep", path, "--out", one, "--jobs", "2", "--shard", "1/1"])])
        middle = time.perf_counter()
        halves = wait([start([program, "sweep", path, "--out", two, "--shard", f"{half}/2", "--jobs", "1"]) for half in (1, 2)])
        both.append((middle - begin, busy, time.perf_counter() - middle, halves))
    wall, busy, apart, halves = (statistics.median(column) for column in zip(*both))
    print(f"{cases} cases, two threads: {cases / wall:.0f} a second, {1e3 * busy / cases:.3f} ms of processor a case")
    print(f"{cases} cases, two processes: {cases / apart:.0f} a second, {1e3 * halves / cases:.3f} ms of processor a case")
    print(f"rate of two threads over that of two processes: {apart / wall:.3f} by wall, {halves / busy:.3f} by processor time")


def memory(program, folder, few, many):
    found = []
    for cases in (few, many):
        out = os.path.join(folder, f"memory-{cases}")
        most = most_memory(start([program, "sweep", plan(folder, cases), "--out", out, "--jobs", "2"]))
        print(f"{cases} cases: {most:.1f} MB at most")
        found.append(most)
    print(f"{many} cases take {found[1] - found[0]:.1f} MB more than {few}")


def kills(program, folder, count):
    """A sweep that is killed at random moments and begun again, against one that is left alone."""
    cases = 250 * count
    path, out = plan(folder, cases), os.path.join(folder, "killed")
    wait([start([program, "sweep", path, "--out", out + "-not", "--jobs", "2"])])
    moments = numpy.random.default_rng(1)
    killed = 0
    while killed < count:
        process = start([program, "sweep", path, "--out", out, "--jobs", "2"])
        try:
            process.wait(moments.uniform(0.0, 0.25))
            break
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            killed += 1
    wait([start([program, "sweep", path, "--out", out, "--jobs", "2"])])
    print(f"{cases} cases, killed {killed} times: the same rows as in one run: {same(table(out + '-not'), table(out))}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--admire", default=os.path.join(ROOT, "target", "release", "admire"))
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--many", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--kills", type=int, default=200)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = plan(folder, options.cases)
        expected = shardings(options.admire, path, folder, options.cases)
        singles(expected)
        rates(options.admire, path, folder, options.cases, options.rounds)
        memory(options.admire, folder, 1000, options.many)
        kills(options.admire, folder, options.kills)


if __name__ == "__main__":
    main()
