"""The least standard deviations that marks allow (Cramer-Rao), with tolerances of known sizes marginalised."""

import copy

import numpy as np

from parts import Bushing
from statics import World


def change(axle, reality, poses, alter, step):
    """How the marks change with a number, by a central difference."""
    found = []
    for sign in (1, -1):
        altered = copy.deepcopy(reality)
        alter(altered, sign * step)
        world = World(axle, altered)
        loads = np.array(axle.cases, float) @ altered.load_matrix.T
        found.append(world.marks(world.solve(loads, poses)))
    return ((found[0] - found[1]) / (2 * step)).ravel()


def bound(axle, deck, reality, sizes, how, sigma):
    """Sd of ln K by address. Friction is left out: its history has no derivative."""
    reality = copy.deepcopy(reality)
    reality.friction = {}
    world = World(axle, reality)
    poses = world.sweep()
    marks = world.marks(poses)
    of = lambda alter, step: change(axle, reality, poses, alter, step)
    sought, columns = [], []
    for c in axle.of(Bushing):
        for k in range(6 if c.sought else 0):

            def stiffer(real, step, c=c, k=k):
                both = [np.array(v, float) for v in real.stiffness.get(c.name, (c.K, c.KT))]
                both[k // 3][k % 3] *= np.exp(step)
                real.stiffness[c.name] = tuple(both)

            sought.append(f"{deck.address[c.name]}.{('K', 'KT')[k // 3]}.{k % 3 + 1}")
            columns.append(of(stiffer, 1e-3))
    nuisance = []
    if sizes.get("hardpoints"):
        for name in axle.hardpoints():
            for k in range(3):

                def shifted(real, step, name=name, k=k):
                    real.points[name] = real.points.get(name, 0.0) + step * np.eye(3)[k]

                nuisance.append(sizes["hardpoints"] * of(shifted, 1e-2))
    count = len(axle.loads)
    for a in range(count):
        for b in range(count):
            size = sizes.get("load_gain", 0.0) if a == b else np.radians(sizes.get("load_direction_deg", 0.0))

            def turned(real, step, a=a, b=b):
                real.load_matrix[a, b] += step

            if size:
                nuisance.append(size * of(turned, 1e-3))
    if sizes.get("preload"):

        def tighter(real, step):
            rate, force = real.springs["COIL"]
            real.springs["COIL"] = (rate, force + step)

        nuisance.append(sizes["preload"] * of(tighter, 1e-3))
    if how.get("marks_on_parts"):
        for part in range(len(axle.bodies)):
            for mark in range(marks.shape[2]):
                for k in range(3):
                    column = np.zeros(marks.shape)
                    column[:, part, mark] = poses[1][:, part, :, k]
                    nuisance.append(how["marks_on_parts"] * column.ravel())
    scale = sigma * np.sqrt(3.0 if how.get("tails") == 3.0 else 1.0)
    J, N = np.stack(columns, 1) / scale, np.stack(nuisance, 1) / scale if nuisance else np.zeros((marks.size, 0))
    if how.get("pose"):
        J, N = whitened(marks, how["pose"] / scale, J, N)
    inner = np.eye(N.shape[1]) + N.T @ N
    information = J.T @ J - J.T @ N @ np.linalg.solve(inner, N.T @ J)
    # As weak a prior as the studies have: 3 in ln K.
    sd = np.sqrt(np.diag(np.linalg.inv(information + np.eye(len(sought)) / 9)))
    return dict(zip(sought, map(float, sd)))


def whitened(marks, tau, J, N):
    """Rows freed of the rigid errors of each part in each case."""
    cases, parts, count, _ = marks.shape
    J, N = (M.reshape(cases, parts, 3 * count, -1).copy() for M in (J, N))
    for case in range(cases):
        for part in range(parts):
            arm = marks[case, part] - marks[case, part].mean(0)
            turns = np.stack([np.cross(np.eye(3)[k], arm).ravel() / 200.0 for k in range(3)], 1)
            B = np.concatenate([np.tile(np.eye(3), (count, 1)), turns], 1) * tau
            L = np.linalg.cholesky(np.eye(3 * count) + B @ B.T)
            J[case, part], N[case, part] = np.linalg.solve(L, J[case, part]), np.linalg.solve(L, N[case, part])
    return J.reshape(marks.size, -1), N.reshape(marks.size, -1)
