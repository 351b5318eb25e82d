"""Time of all standard K&C tests of the multilink axle, 13 points each.

    cargo build --release
    python tests/bench/kc_speed.py [--admire PATH] [--rounds 7]

Driven by `admire kc` with ten more decks to compare against one run without, over ten: reading the study, the results files and the
report of the first deck fall out. Processor time of the command, its fastest and its middle round, with one branch and with both.
"""

import argparse
import os
import resource
import statistics
import subprocess
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
AXLE = os.path.join(ROOT, "corpus", "multilink")
MORE = 10


def spent(words):
    """Processor time of a command, seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--admire", default=os.path.join(ROOT, "target", "release", "admire"))
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    deck = os.path.join(AXLE, "model.adm")
    with open(os.path.join(AXLE, "kc.toml")) as text:
        shipped = text.read()
    for name, branches in (("one branch, 13 points a test", "up"), ("both branches, 26 points a test", "both")):
        one, whole = [], []
        with tempfile.TemporaryDirectory() as folder:
            config = os.path.join(folder, "kc.toml")
            with open(config, "w") as out:
                out.write(shipped.replace("[choices]", f'[choices]\nbranches = "{branches}"'))
            assert "[choices]" in shipped
            words = [options.admire, "kc", deck, "--config", config, "--force", "--out", os.path.join(folder, "out")]
            for _ in range(options.rounds):
                alone = spent(words)
                many = spent([*words, "--compare", *[deck] * MORE])
                one.append(1e3 * (many - alone) / MORE)
                whole.append(1e3 * alone)
        print(f"{name}: {min(one):.1f} ms fastest, {statistics.median(one):.1f} ms middle; the whole command {min(whole):.0f} ms fastest")


if __name__ == "__main__":
    main()
