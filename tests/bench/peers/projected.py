"""What ERROR means, against a reference of its own: `python projected.py --admire target/release/admire`. See README.md.

Two rigid bodies on ball joints, one below the other, under gravity. The reference integrates Newton's and Euler's equations of free bodies
with the accelerations that keep the joints closed, by SciPy's DOP853. After each step it projects places and velocities onto the joints.
"""

import argparse
import csv
import os
import subprocess
import tempfile

import numpy as np
from scipy.integrate import DOP853

GRAVITY = np.array([0.0, 0.0, -9.81])
MASS = np.array([2.0, 1.5])
INERTIA = np.array([[0.20, 0.30, 0.12], [0.10, 0.25, 0.18]])
# Mass centres at the start, and the joints in the axes of the bodies, which are those of the world then.
CENTRES = np.array([[0.4, 0.1, -0.3], [1.0, 0.5, -0.5]])
TOP = np.array([-CENTRES[0], [-0.2, -0.3, 0.1]])
BELOW = CENTRES[1] + TOP[1] - CENTRES[0]
SPIN = np.array([[0.5, -1.0, 2.0], [-1.5, 0.7, 3.0]])
END, OUTPUTS = 2.0, 20


def cross(a):
    """The matrix of the product a x."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def rotation(q):
    """Of the quaternion (scalar first)."""
    s, v = q[0], q[1:]
    return (s * s - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * s * cross(v)


def parts(y):
    """Places, quaternions, velocities, and spins in body axes."""
    return y[:6].reshape(2, 3), y[6:14].reshape(2, 4), y[14:20].reshape(2, 3), y[20:26].reshape(2, 3)


def joints(r, q):
    """Gaps of the joints, and their gradient by small motions: of both places, then of both turns in body axes."""
    R = [rotation(q[0]), rotation(q[1])]
    gap = np.concatenate([r[0] + R[0] @ TOP[0], r[1] + R[1] @ TOP[1] - r[0] - R[0] @ BELOW])
    J = np.zeros((6, 12))
    J[:3, :3] = np.eye(3)
    J[:3, 6:9] = -R[0] @ cross(TOP[0])
    J[3:, :3], J[3:, 3:6] = -np.eye(3), np.eye(3)
    J[3:, 6:9] = R[0] @ cross(BELOW)
    J[3:, 9:12] = -R[1] @ cross(TOP[1])
    return gap, J


WEIGHT = np.concatenate([np.repeat(MASS, 3), INERTIA.ravel()])


def rate(_, y):
    r, q, v, w = parts(y)
    _, J = joints(r, q)
    R = [rotation(q[0]), rotation(q[1])]
    turning = lambda k, a: R[k] @ np.cross(w[k], np.cross(w[k], a))
    # What the gaps are accelerated by without accelerations of the bodies.
    c = np.concatenate([turning(0, TOP[0]), turning(1, TOP[1]) - turning(0, BELOW)])
    load = np.concatenate([np.outer(MASS, GRAVITY).ravel(), *(-np.cross(w[k], INERTIA[k] * w[k]) for k in (0, 1))])
    free = load / WEIGHT
    force = np.linalg.solve(J / WEIGHT @ J.T, -(J @ free + c))
    a = free + (J.T @ force) / WEIGHT
    turn = lambda q, w: 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
    return np.concatenate([v.ravel(), turn(q[0], w[0]), turn(q[1], w[1]), a])


def projected(y):
    """The nearest state with closed joints, distances weighed by masses."""
    y = y.copy()
    r, q, v, w = parts(y)
    q /= np.linalg.norm(q, axis=1)[:, None]
    for _ in range(3):
        gap, J = joints(r, q)
        step = -(J.T / WEIGHT[:, None]) @ np.linalg.solve(J / WEIGHT @ J.T, gap)
        r += step[:6].reshape(2, 3)
        for k in (0, 1):
            small = step[6 + 3 * k:9 + 3 * k]
            q[k] += 0.5 * np.concatenate([[-q[k][1:] @ small], q[k][0] * small + np.cross(q[k][1:], small)])
            q[k] /= np.linalg.norm(q[k])
    _, J = joints(r, q)
    u = np.concatenate([v.ravel(), w.ravel()])
    u -= (J.T / WEIGHT[:, None]) @ np.linalg.solve(J / WEIGHT @ J.T, J @ u)
    v[:], w[:] = u[:6].reshape(2, 3), u[6:].reshape(2, 3)
    return y


def reference(tolerance):
    """Mass centres, their velocities, and spins in world axes at the outputs."""
    r, q, v, w = CENTRES, np.array([[1.0, 0, 0, 0]] * 2), np.zeros((2, 3)), SPIN
    v = np.array([np.cross(SPIN[0], -TOP[0]), np.cross(SPIN[0], BELOW - TOP[0]) - np.cross(SPIN[1], TOP[1])])
    y, out, t, h = projected(np.concatenate([r.ravel(), q.ravel(), v.ravel(), w.ravel()])), [], 0.0, 1e-3
    for k in range(OUTPUTS):
        end = END * (k + 1) / OUTPUTS
        while t < end:
            solver = DOP853(rate, t, y, end, rtol=tolerance, atol=tolerance, first_step=min(h, end - t))
            solver.step()
            y, t, h = projected(solver.y), solver.t, solver.h_abs
        r, q, v, w = parts(y)
        world = [rotation(q[k]) @ w[k] for k in (0, 1)]
        out.append(np.concatenate([r.ravel(), v.ravel(), *world]))
    return np.array(out)


def ours(admire, error):
    place = lambda p: ",".join(repr(float(x)) for x in p)
    v = [np.cross(SPIN[0], -TOP[0]), np.cross(SPIN[0], BELOW - TOP[0]) - np.cross(SPIN[1], TOP[1])]
    deck = ["two bodies", "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND", f"ACCGRAV/KGRAV={GRAVITY[2]}", "PART/1, GROUND", "MARKER/10, PART=1"]
    for k in (0, 1):
        speeds = ", ".join(f"{name}={float(x)!r}" for name, x in zip(("VX", "VY", "VZ", "WX", "WY", "WZ"), (*v[k], *SPIN[k])))
        deck.append(f"PART/{k + 2}, QG={place(CENTRES[k])}, MASS={MASS[k]}, CM={k + 2}0, IP={place(INERTIA[k])}")
        deck.append(f", {speeds}")
        deck += [f"MARKER/{k + 2}0, PART={k + 2}", f"MARKER/{k + 2}1, PART={k + 2}, QP={place(TOP[k])}"]
    deck.append(f"MARKER/22, PART=2, QP={place(BELOW)}")
    deck += ["JOINT/1, SPHERICAL, I=21, J=10", "JOINT/2, SPHERICAL, I=31, J=22", f"INTEGRATOR/GSTIFF, ERROR={error}", "RESULTS/XRF", "END"]
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("m.adm", "\n".join(deck)), ("m.acf", f"m\nm\nSIMULATE/DYNAMIC, END={END}, STEPS={OUTPUTS}\nSTOP")):
            with open(os.path.join(folder, name), "w") as file:
                file.write(text + "\n")
        subprocess.run([admire, "solve", "m.acf", "--csv", "m.csv"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        with open(os.path.join(folder, "m.csv"), newline="") as file:
            rows = list(csv.reader(file))
    columns = {name.split(" ")[0]: k for k, name in enumerate(rows[0])}
    of = lambda names: [columns[f"PART_{k}_XFORM.{name}"] for k in (2, 3) for name in names]
    at = of(("X", "Y", "Z")) + of(("VX", "VY", "VZ")) + of(("WX", "WY", "WZ"))
    return np.array([[float(row[k]) for k in at] for row in rows[-OUTPUTS:]])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--admire", default="target/release/admire")
    admire = os.path.abspath(parser.parse_args().admire)
    exact, coarse = reference(1e-13), reference(1e-11)
    print(f"The reference at 1e-11 differs by {np.abs(exact - coarse).max():.1e}.\n")
    print("| ERROR | places | velocities | spins |\n|---|---|---|---|")
    for k in range(2, 9):
        error = 10.0**-k
        off = np.abs(ours(admire, error) - exact)
        kinds = [off[:, part].max() / max(1.0, np.abs(exact[:, part]).max()) / error for part in (slice(0, 6), slice(6, 12), slice(12, 18))]
        print(f"| 1e-{k} |" + "".join(f" {ratio:.2g} |" for ratio in kinds))


if __name__ == "__main__":
    main()
