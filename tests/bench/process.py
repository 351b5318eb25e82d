"""Wall time of whole processes: `mdi` on the 13 load cases of the pseudo McPherson, all files written, beside `true`.

    cargo build --release && python3 tests/bench/process.py [--mdi PATH] [--repeats 51]

The two are started in turn, so that both see the same machine; medians and quartiles of each, and of the difference. Processor
time is shown too: on a machine that has other work it says more than the clock.
"""

import argparse
import csv
import os
import resource
import shutil
import statistics
import subprocess
import tempfile
import time

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))

# The deck of the corpus writes .res and .msg; this asks for .req, .gra and .out besides.
EVERY_FILE = "REQUEST/1\n, DISPLACEMENT\n, I = 20\n, J = 48\nOUTPUT/REQSAVE, GRSAVE"


def load_cases():
    """The command file of the study."""
    lines = ["", "file/model=run"]
    with open(os.path.join(ROOT, "corpus/pseudo-mcpherson/load_cases.csv"), newline="") as file:
        for row in csv.DictReader(file):
            for sforce, column in ((1, "longitudinal"), (2, "lateral"), (3, "vertical")):
                lines.append(f"SFORCE/{sforce}, FUNCTION = {row[column]}")
            lines.append("SIMULATE/STATIC")
    return "\n".join(lines + ["STOP"]) + "\n"


def seconds(command, folder):
    """Wall time and processor time of a process."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, cwd=folder, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def shown(name, values):
    low, middle, high = (1e3 * v for v in statistics.quantiles(values, n=4))
    print(f"{name:12} median {middle:7.2f} ms, quartiles {low:.2f} to {high:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mdi", default=os.path.join(ROOT, "target", "release", "mdi"))
    parser.add_argument("--repeats", type=int, default=51)
    options = parser.parse_args()
    mdi, true = [os.path.abspath(options.mdi), "-c", "ru-standard", "i", "run.acf", "exit"], [shutil.which("true")]
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(ROOT, "corpus/pseudo-mcpherson/reference.adm")) as file:
            deck = file.read().replace("OUTPUT/REQSAVE", EVERY_FILE)
        with open(os.path.join(folder, "run.adm"), "w") as file:
            file.write(deck)
        with open(os.path.join(folder, "run.acf"), "w") as file:
            file.write(load_cases())
        seconds(mdi, folder), seconds(true, folder)
        with open(os.path.join(folder, "run.res")) as file:
            steps = file.read().count('"static">')
        assert steps == 13, steps
        pairs = [(seconds(mdi, folder), seconds(true, folder)) for _ in range(options.repeats)]
        files = sorted(name for name in os.listdir(folder) if name not in ("run.adm", "run.acf"))
    for what, k in (("wall time", 0), ("processor time", 1)):
        print(what)
        shown("mdi", [a[k] for a, _ in pairs])
        shown("true", [b[k] for _, b in pairs])
        shown("difference", [a[k] - b[k] for a, b in pairs])
    print("files written:", ", ".join(files))


if __name__ == "__main__":
    main()
