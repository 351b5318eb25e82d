"""Random models solved by admire and by Exudyn, where their laws coincide: positions and axes of all parts compared. See README.md."""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

import exudyn as exu
import numpy as np
from exudyn_model import Model

import deck as decks

SAME = 1e-6  # mm, and entries of rotation matrices times 1 mm
IMBALANCE = 1e-7  # newton and newton.mm


def turned(random, size):
    return list(random.uniform(-size, size, 3))


def angles(R):
    """3-1-3 of a rotation matrix."""
    if math.hypot(R[0][2], R[1][2]) < 1e-9:
        return [math.atan2(R[1][0], R[0][0]), 0.0, 0.0]
    return [math.atan2(R[0][2], -R[1][2]), math.acos(max(-1.0, min(1.0, R[2][2]))), math.atan2(R[2][0], R[2][1])]


class Draw:
    """One to six parts in a tree with loops: joints closed in the design position, every part on a bushing to ground, forces and
    springs. Bushings with J on ground meet nothing with the torque that Exudyn's connector leaves out."""

    def __init__(self, seed):
        self.random = random = np.random.default_rng(seed)
        self.frames = [(np.zeros(3), np.eye(3))]
        self.lines = [f"Random model {seed}", "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND", "PART/1", ", GROUND"]
        self.markers, self.statements = [], []
        count = random.integers(1, 7)
        for part in range(2, count + 2):
            p, e = random.uniform(-200, 200, 3), turned(random, 3.0)
            R = np.array(decks.rotation(*e))
            self.frames.append((p, R))
            cm = self.marker(part, p + random.uniform(-50, 50, 3), R)
            self.lines += [f"PART/{part}", f", QG={self.numbers(p)}", f", REULER={self.numbers(e)}"]
            self.lines += [f", MASS={random.uniform(1, 20)!r}", f", CM={cm}", ", IP=1E4, 1E4, 1E4"]
        self.count = {}
        parts = range(2, count + 2)
        for part in parts:
            if random.random() < 0.8:
                self.joint(part, int(random.integers(1, part)))
            self.bushing(part)
        for _ in range(random.integers(0, 3) if count > 1 else 0):
            a, b = random.choice(np.arange(1, count + 2), 2, replace=False)
            self.joint(int(a), int(b))
        for _ in range(random.integers(1, 5)):
            self.load(int(random.choice(parts)))

    def numbers(self, values):
        return ", ".join(repr(float(value)) for value in values)

    def id(self, kind):
        self.count[kind] = self.count.get(kind, 0) + 1
        return self.count[kind]

    def marker(self, part, p, R):
        """A marker of a part where a frame of ground is."""
        place, axes = self.frames[part - 1]
        id_ = len(self.markers) + 1
        self.markers.append([f"MARKER/{id_}", f", PART={part}", f", QP={self.numbers(axes.T @ (p - place))}", f", REULER={self.numbers(angles(axes.T @ R))}"])
        return id_

    def near(self, part):
        return self.frames[part - 1][0] + self.random.uniform(-100, 100, 3), np.array(decks.rotation(*turned(self.random, 3.0)))

    def joint(self, a, b):
        kind = self.random.choice(["SPHERICAL", "SPHERICAL", "REVOLUTE", "TRANSLATIONAL", "CYLINDRICAL", "UNIVERSAL", "FIXED"])
        p, R = self.near(b)
        turn = np.array(decks.rotation(self.random.uniform(-1, 1), 0, 0))
        shift = R[:, 2] * self.random.uniform(-50, 50)
        i = {
            "SPHERICAL": (p, np.array(decks.rotation(*turned(self.random, 1.0))) @ R),
            "REVOLUTE": (p, R @ turn),
            "TRANSLATIONAL": (p + shift, R),
            "CYLINDRICAL": (p + shift, R @ turn),
            "UNIVERSAL": (p, R @ np.array(decks.rotation(self.random.uniform(-1, 1), math.pi / 2, self.random.uniform(-1, 1)))),
            "FIXED": (p, R),
        }[kind]
        mi, mj = self.marker(a, *i), self.marker(b, p, R)
        self.statements += [f"JOINT/{self.id('JOINT')}", f", {kind}", f", I={mi}", f", J={mj}"]

    def bushing(self, part):
        p, R = self.near(part)
        k, kt = self.random.uniform(300, 2000, 3), self.random.uniform(2e6, 1e7, 3)
        mi, mj = self.marker(part, p, R), self.marker(1, p, R)
        self.statements += [f"BUSHING/{self.id('BUSHING')}", f", I={mi}", f", J={mj}", f", K={self.numbers(k)}", f", KT={self.numbers(kt)}"]

    def load(self, part):
        p, R = self.near(part)
        if self.random.random() < 0.5:
            force = self.random.uniform(-1500, 1500)
            mi, mj = self.marker(part, p, np.eye(3)), self.marker(1, np.zeros(3), R)
            self.statements += [f"SFORCE/{self.id('SFORCE')}", ", TRANSLATIONAL", ", ACTIONONLY", f", I={mi}", f", J={mj}", f", FUNCTION={force!r}"]
            return
        others = [other for other in range(1, len(self.frames) + 1) if other != part]
        other = int(self.random.choice(others))
        q, _ = self.near(other)
        length = float(np.linalg.norm(p - q)) * self.random.uniform(0.8, 1.2)
        mi, mj = self.marker(part, p, R), self.marker(other, q, R)
        self.statements += [f"SPRINGDAMPER/{self.id('SPRING')}", ", TRANSLATION", f", I={mi}", f", J={mj}"]
        self.statements += [f", K={self.random.uniform(5, 50)!r}", ", C=0.0", f", FORCE={self.random.uniform(-300, 300)!r}", f", LENGTH={length!r}"]

    def text(self):
        markers = [line for marker in self.markers for line in marker]
        end = ["ACCGRAV/", ", IGRAV=0.0", ", JGRAV=0.0", ", KGRAV=-9806.65"]
        end += [f"EQUILIBRIUM/ERROR=1E-10, IMBALANCE={IMBALANCE}, MAXIT=100", "RESULTS/XRF", "END"]
        return "\n".join(self.lines + markers + self.statements + end) + "\n"


def ours(admire, path):
    """Position and rotation matrix of every part, or what was said."""
    solved = subprocess.run([admire, "solve", path, "--format", "json"], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if solved.returncode != 0:
        return None, (solved.stdout + solved.stderr).strip()
    found = json.loads(solved.stdout)
    poses = {}
    for part in found["parts"]:
        R = decks.rotation(*(math.radians(angle) for angle in part["psi_theta_phi_deg"]))
        poses[part["name"].removeprefix("PART_").removeprefix("PART/")] = np.array(list(part["position"]) + [x for row in R for x in row])
    return poses, found


def theirs(path):
    """Loops have equations that say nothing new: where the sparse solver gives up, the dense one may pass over them."""
    for dense in (False, True):
        try:
            model = Model(path, adams_law=True)
            model.settings.staticSolver.newton.maxIterations = 100
            if dense:
                model.settings.linearSolverType = exu.LinearSolverType.EigenDense
                model.settings.linearSolver.ignoreSingularJacobian = True
            poses = model.sweep([], [[]], 100 * IMBALANCE, keep=True)[2][0]
            axes = [np.reshape(pose[3:], (3, 3)) for pose in poses.values()]
            # Where an iteration was given up without a word, not even the axes are of unit length.
            if all(np.abs(R.T @ R - np.eye(3)).max() < 1e-9 for R in axes):
                return poses
            why = "no rotation"
        except Exception as error:  # its solver raises plain exceptions
            why = str(error)
    return why


def begun_at(text, poses):
    """The deck with its parts where they are in these poses."""
    lines, part = text.split("\n"), None
    for k, line in enumerate(lines):
        if line.startswith("PART/"):
            part = line.split("/")[1]
        elif line.startswith("MARKER/"):
            break
        elif part in poses and line.startswith(", QG="):
            lines[k] = ", QG=" + ", ".join(repr(float(x)) for x in poses[part][:3])
        elif part in poses and line.startswith(", REULER="):
            lines[k] = ", REULER=" + ", ".join(repr(float(x)) for x in angles(np.reshape(poses[part][3:], (3, 3))))
    return "\n".join(lines)


def apart(mine, other):
    return max(float(np.abs(mine[part] - np.array(there)).max()) for part, there in other.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=int, default=500)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--admire", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../target/release/admire"))
    options = parser.parse_args()
    same, worst, several, unanswered, refused, differ = 0, 0.0, [], [], [], []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "model.adm")
        for seed in range(options.first, options.first + options.models):
            with open(path, "w") as file:
                file.write(Draw(seed).text())
            mine, told = ours(options.admire, path)
            if mine is None:
                refused.append((seed, told.splitlines()[:2]))
                continue
            other = theirs(path)
            if isinstance(other, str):
                unanswered.append(seed)
                continue
            distance = apart(mine, other)
            if distance <= SAME:
                same, worst = same + 1, max(worst, distance)
                continue
            # Begun where Exudyn ends, admire stays there: the model has more than one equilibrium.
            with open(path, "w") as file:
                file.write(begun_at(Draw(seed).text(), other))
            there, _ = ours(options.admire, path)
            if there is not None and apart(there, other) <= SAME:
                several.append(seed)
            else:
                differ.append((seed, distance, told["stability"]))
    print(f"{options.models} models: {same} the same, {worst:.1e} mm apart at most; Exudyn without an answer {len(unanswered)}, at another equilibrium {len(several)}")
    for seed, why in refused:
        print(f"admire without an answer, seed {seed}: {why}")
    for seed, distance, stability in differ:
        print(f"STATES DIFFER, seed {seed}: {distance:.2e} mm, ours is {stability}")
    return 1 if differ or refused else 0


if __name__ == "__main__":
    sys.exit(main())
