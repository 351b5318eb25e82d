"""Holds the solver of this folder against two others: `python verify.py --admire target/release/admire`.

Clean axles of every kind are written as datasets and solved by `admire` and by Exudyn; laws the dataset does not know (a
yielding link, rubber that grows, sliders that slip) by Exudyn alone, from its own objects. Prints the largest distance of any mark.
"""

import argparse
import copy
import csv
import os
import subprocess
import sys
import tempfile

sys.path.insert(1, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))

import numpy as np

import exudyn_model
from exudyn import SolverError
from folder import Deck, write_study
from geometry import KINDS
from parts import Body, Bushing, Cylinder, frame_along
from statics import NoEquilibrium, Reality, Sliders, World

SAME = 1e-6  # mm


def by_admire(admire, axle, folder):
    """Marks of all cases, as its solver has them: a rig without errors and noise reads the dataset."""
    some = np.zeros((len(axle.cases), len(axle.bodies), 4, 3))
    write_study(folder, Deck(axle), dict(marks=some, sigma=0.02), digits=13)
    out = os.path.join(folder, "read")
    subprocess.run([admire, "rig", folder, "--sigma", "0", "--out", out], check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(out, "marks_measured.csv"), newline="") as file:
        rows = [[float(row[k]) for k in "xyz"] for row in csv.DictReader(file)]
    return np.array(rows).reshape(some.shape)


def by_exudyn(axle, folder, more=None, settle=None):
    """`more`: forces besides by bushing and component; `settle` is told the displacement of each of them after every case."""
    deck = Deck(axle)
    path = os.path.join(folder, "exudyn.adm")
    with open(path, "w") as file:
        file.write(deck.text)
    laws, watched = {}, []
    for (name, axis), function in (more or {}).items():
        laws.setdefault(int(deck.address[name].split("/")[1]), {})[axis] = function
        watched.append((next(c for c in axle.connections if c.name == name), axis))
    model = exudyn_model.Model(path, adams_law=True, more=laws)

    def after(poses):
        for c, axis in watched:
            pose = np.array(poses[str(deck.part[c.i])])
            place = pose[:3] + pose[3:].reshape(3, 3) @ deck.on_part(c.i, axle.points[c.at])
            settle(c.name, axis, (c.axes.T @ (place - axle.points[c.at]))[axis])  # J is on ground

    names = [deck.address[load.column] for load in axle.loads]
    try:
        _, _, parts = model.sweep(names, axle.cases, 1e-5, keep=True, after=after if settle else None)
    except SolverError:
        return None
    marks = np.zeros((len(axle.cases), len(axle.bodies), 4, 3))
    for k, case in enumerate(parts):
        for b, (name, body) in enumerate(axle.bodies.items()):
            pose = np.array(case[str(deck.part[name])])
            marks[k, b] = pose[:3] + ((body.marks - body.origin) @ deck.R[name]) @ pose[3:].reshape(3, 3).T
    return marks


def split(axle, link, stiffness):
    """The axle with a link made of two halves that slide on each other against a spring: what a yielding link is for solvers that do not
    know one. The outer half weighs nothing."""
    axle = copy.deepcopy(axle)
    inner, outer, ball = axle.links[link]
    half = link + "_HALF"
    own = axle.bodies[link]
    axle.bodies[half] = Body(axle.points[outer].copy(), 1e-9, axle.points[outer].copy(), own.frame, own.marks)
    connection = next(c for c in axle.connections if c.name == ball)
    connection.i = half
    axle.connections.append(Cylinder("HALVES", half, link, outer, (inner, outer), 0.0))
    line = axle.points[outer] - axle.points[inner]
    K, KT = np.array([0.0, 0.0, stiffness]), np.array([0.0, 0.0, 1e5])
    axle.connections.append(Bushing("YIELDING", half, link, outer, frame_along(line), K, KT, False))
    return axle


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--admire", default="target/release/admire")
    parser.add_argument("--seeds", type=int, default=2, help="axles of each kind")
    options = parser.parse_args()
    failed = False

    def show(name, here, *others):
        nonlocal failed
        apart = [np.abs(here - there).max() if there is not None else np.nan for there in others]
        failed |= any(a > SAME for a in apart)
        print(f"{name:32} " + " ".join(f"{a:12.1e}" if a == a else f"{'-':>12}" for a in apart), flush=True)

    print(f"{'largest distance of a mark':32} {'admire mm':>12} {'Exudyn mm':>12}")
    with tempfile.TemporaryDirectory() as folder:
        for kind, build in KINDS.items():
            for seed in range(options.seeds):
                axle = build(np.random.default_rng([seed, 77]))
                name = f"{kind} {seed}"
                try:
                    poses = World(axle).sweep()
                except NoEquilibrium as why:
                    print(f"{name:32} {why}")
                    continue
                show(name, World(axle).marks(poses), by_admire(options.admire, axle, folder), by_exudyn(axle, folder))
                if seed:
                    continue
                link = next(iter(axle.links))
                inner, _, ball = axle.links[link]
                real = World(axle, Reality(compliance={ball: (link, inner, 1e-4)}))
                halves, n = split(axle, link, 1e4), len(axle.bodies)
                there = [by_admire(options.admire, halves, folder), by_exudyn(halves, folder)]
                show(name + ", link yields", real.marks(real.sweep()), *(None if t is None else t[:, :n] for t in there))
                bushing = next(c for c in axle.of(Bushing) if c.sought)
                key, low_high = (bushing.name, 0), World(axle).ranges(poses)[bushing.name]
                width, k = (low_high[1] - low_high[0])[0], bushing.K[0]
                real = World(axle, Reality(growing={key: width}))
                grown = by_exudyn(axle, folder, {key: lambda u: k * width * np.sinh(u / width) - k * u})
                show(name + ", rubber grows", real.marks(real.sweep()), None, grown)
                law = (0.02 * k * width, 0.03 * width)
                real, slider = World(axle, Reality(friction={key: law})), Sliders(*law)
                slipped = by_exudyn(axle, folder, {key: slider.force}, lambda name, axis, u: slider.settle(u))
                show(name + ", friction", real.marks(real.sweep()), None, slipped)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
