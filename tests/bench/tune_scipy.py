"""Design to a target beside scipy: `admire.tune` with exact derivatives, and `scipy.optimize.least_squares` with differences.

    pip install . scipy
    python tests/bench/tune_scipy.py [--draws 5]

Both move 12 coordinates of the double wishbone (left and right as mirror images), which were moved by up to 10 mm, until toe and camber over
80 mm of travel to both sides are those of the original, to 0.001 degrees rms. Of each: runs of the tests, seconds, and the rms miss at the end.
scipy is stopped where it first meets that, or after `--most` Jacobians; `admire` goes on to its own convergence. A run of scipy is `Deck.kc`, which
also writes its report.
"""

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import admire

ROOT = Path(__file__).resolve().parents[2]
TESTS = ("roll", "steering", "lateral", "lateral_opposed", "braking", "traction", "aligning", "aligning_opposed")
KC = """[deck]
axes = "adams-car"
without = ["MOTION/2", "MOTION/3"]
[wheels]
left = { centre = "MARKER/130", spin = "MARKER/134" }
right = { centre = "MARKER/230", spin = "MARKER/234" }
[tests]
bounce = { range = [-80, 80], points = 17 }
""" + "".join(f"{name} = {{ run = false }}\n" for name in TESTS)
BOUND = 15.0
TOLERANCE = 1e-3
STUDY = f"""[model]
deck = "model.adm"
[target]
restarts = 0
[[target.unknown]]
numbers = ["MARKER/112.QP", "MARKER/122.QP", "MARKER/142.QP", "MARKER/141.QP"]
bounds = [-{BOUND}, {BOUND}]
symmetric = true
""" + "".join(
    f'[[target.goal]]\ntest = "bounce"\nof = "{name}.left"\ncurve = "wanted.csv"\ntolerance = {TOLERANCE}\n'
    for name in ("toe_angle", "camber_angle")
)
COLUMNS = ["toe_angle.left [deg]", "camber_angle.left [deg]"]


class Met(Exception):
    """the curves are as wanted."""


def curves(deck, config):
    """Toe and camber over the travel, in degrees, and the travel."""
    table = deck.kc(config).curves()
    table = table[(table["test"] == "bounce") & (table["branch"] == "up")]
    return table["value"].to_numpy(), table[COLUMNS].to_numpy()


def write(folder, deck, wanted):
    (folder / "model.adm").write_bytes(bytes(deck))
    (folder / "kc.toml").write_text(KC)
    (folder / "study.toml").write_text(STUDY)
    rows = [",".join(["value", *COLUMNS])]
    rows += [",".join(map(repr, map(float, row))) for row in wanted]
    (folder / "wanted.csv").write_text("\n".join(rows) + "\n")


def moved(deck, factors, x):
    """The deck with its hardpoints moved, in mm."""
    new = admire.Deck.from_string(deck.text)
    change = {}
    for own, move in zip(factors, x):
        for address, factor in own.items():
            change[address] = change.get(address, 0.0) + factor * move
    for address, value in change.items():
        new[address] = deck[address] + value
    return new


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=5)
    parser.add_argument("--most", type=int, default=50)
    options = parser.parse_args()
    original = admire.read(ROOT / "corpus" / "double-wishbone" / "model.adm")
    results = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "kc.toml").write_text(KC)
        config = folder / "kc.toml"
        travel, wanted = curves(original, config)
        # Which numbers of the deck a coordinate moves, and how far, as a search for another curve shows.
        write(folder, original, np.column_stack([travel, wanted + 0.1 * travel[:, None] / 80.0]))
        found = admire.tune(folder)
        factors = [
            {address: (after - before) / unknown.value for address, (before, after) in unknown.numbers.items()}
            for unknown in found.unknowns
        ]
        for draw in range(options.draws):
            x = np.random.default_rng(draw).uniform(-10.0, 10.0, len(factors))
            start = moved(original, factors, x)
            write(folder, start, np.column_stack([travel, wanted]))
            began = time.perf_counter()
            found = admire.tune(folder)
            ours = time.perf_counter() - began
            rms = max(goal.rms_after for goal in found.goals)

            runs, left = 0, np.inf

            def misses(u):
                nonlocal runs, left
                runs += 1
                _, now = curves(moved(start, factors, BOUND * (u - 1.0)), config)
                off = now - wanted
                left = min(left, np.sqrt((off**2).mean(axis=0)).max())
                if left <= TOLERANCE:
                    raise Met
                return (off / (TOLERANCE * np.sqrt(len(travel)))).ravel()

            began = time.perf_counter()
            try:
                least_squares(misses, np.ones(len(factors)), bounds=(0.0, 2.0), diff_step=1e-4, max_nfev=options.most)
            except Met:
                pass
            theirs = time.perf_counter() - began
            results.append((found.json["evaluations"], ours, rms, runs, theirs, left))
            print(
                f"draw {draw}: admire {found.json['evaluations']} evaluations with derivatives, {ours:.2f} s, rms {rms:.1e} deg; "
                f"scipy {runs} runs, {theirs:.2f} s, rms {left:.1e} deg",
                flush=True,
            )
    for k, what in ((0, "admire, evaluations"), (1, "admire, s"), (3, "scipy, runs"), (4, "scipy, s")):
        print(f"{what}: median {statistics.median(row[k] for row in results):.3g}")


if __name__ == "__main__":
    main()
