"""Equilibria by a Newton iteration over part motions and joint forces, many load cases at once.

Unknowns of each part: a displacement and a rotation, made on top of the last rotation matrix; of each joint equation: its reaction.
Derivatives are differences of the imbalance. Laws are written here from the definitions of the elements: a bushing's force along the axes
of J, its torque from the projected angles atan2(-R12, R22), atan2(R02, R22), atan2(R10, R00), its reaction at the place of I.
"""

from dataclasses import dataclass, field

import numpy as np

from parts import GROUND, Bushing, Cylinder, Spring, Universal

STEP, TURN = 1e-5, 1e-7  # of the differences: mm, rad


class NoEquilibrium(Exception):
    pass


def cross(a, b):
    return np.stack(
        [a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1], a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2], a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]], -1
    )


def dot(a, b):
    return np.sum(a * b, -1)


def exp(v):
    """Rotation matrices of rotation vectors (..., 3)."""
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    K = np.zeros(v.shape[:-1] + (3, 3))
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    K -= np.swapaxes(K, -1, -2)
    small = angle < 1e-6
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle**2 / 6, np.sin(safe) / safe)
    b = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    return np.eye(3) + a * K + b * (K @ K)


@dataclass
class Reality:
    """How the axle that is measured differs from its deck."""

    points: dict = field(default_factory=dict)  # shift of points of the car, on all parts
    sides: dict = field(default_factory=dict)  # (connection, "i" or "j") -> shift of that side alone
    load_points: dict = field(default_factory=dict)  # point -> shift of the loads that act there
    tilts: dict = field(default_factory=dict)  # bushing -> rotation matrix of both sides
    growing: dict = field(default_factory=dict)  # (bushing, component) -> length u0: K u0 sinh(u / u0)
    friction: dict = field(default_factory=dict)  # (bushing, component) -> (force, displacement at which half has slipped)
    compliance: dict = field(default_factory=dict)  # ball -> (body, other point, mm/N) along the line of the two
    play: tuple = None  # (ball, body, other point, half the play in mm, force of its law): along the line half * tanh(force / that)
    load_matrix: np.ndarray = None  # acting loads = matrix @ (stated loads + their errors)
    load_errors: np.ndarray = 0.0  # of each load in each case
    springs: dict = field(default_factory=dict)  # spring -> (factor of K, factor of force)
    stiffness: dict = field(default_factory=dict)  # bushing -> (K, KT) instead of the axle's own


class World:
    """An axle as it really is."""

    def __init__(self, axle, reality=None):
        self.axle, self.reality = axle, reality or Reality()
        self.names = [n for n in axle.bodies]
        self.index = {n: k for k, n in enumerate(self.names)}
        self.origins = np.array([axle.bodies[n].origin for n in self.names])
        real = self.reality
        self.points = {n: np.asarray(p, float) + real.points.get(n, 0.0) for n, p in axle.points.items()}
        self.elements = [(c, self.resolve(c)) for c in axle.connections]
        self.sliders = {key: Sliders(*law) for key, law in real.friction.items()}

    def place(self, connection, side, point):
        return self.points[point] + self.reality.sides.get((connection.name, side), 0.0)

    def resolve(self, c):
        """Places of both sides and axes at design."""
        if isinstance(c, Spring):
            return dict(p_i=self.place(c, "i", c.at_i), p_j=self.place(c, "j", c.at_j))
        found = dict(p_i=self.place(c, "i", c.at), p_j=self.place(c, "j", c.at))
        if isinstance(c, Cylinder):
            a, b = (self.points[n] for n in c.line)
            z = (b - a) / np.linalg.norm(b - a)
            x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
            x /= np.linalg.norm(x)
            found.update(p_i=found["p_i"] + c.reach * z, z=z, x=x, y=np.cross(z, x))
        if isinstance(c, Bushing):
            found["axes"] = self.reality.tilts.get(c.name, np.eye(3)) @ c.axes
            found["K"], found["KT"] = self.reality.stiffness.get(c.name, (c.K, c.KT))
        return found

    # The motion of a part: c (..., parts, 3) and R (..., parts, 3, 3).

    def at(self, body, p, c, R):
        if body == GROUND:
            return np.broadcast_to(p, c.shape[:-2] + (3,))
        k = self.index[body]
        return c[..., k, :] + (R[..., k, :, :] @ (p - self.origins[k]))

    def along(self, body, v, R):
        if body == GROUND:
            return np.broadcast_to(v, R.shape[:-3] + (3,))
        return R[..., self.index[body], :, :] @ v

    def turned(self, body, A, R):
        if body == GROUND:
            return np.broadcast_to(A, R.shape[:-3] + (3, 3))
        return R[..., self.index[body], :, :] @ A

    def deflection(self, c, e, cs, R):
        """Of a bushing, in the axes of J: three displacements, three angles; and J's axes and the place of I."""
        r_i, r_j = self.at(c.i, e["p_i"], cs, R), self.at(c.j, e["p_j"], cs, R)
        A_i, A_j = self.turned(c.i, e["axes"], R), self.turned(c.j, e["axes"], R)
        d = np.einsum("...ji,...j->...i", A_j, r_i - r_j)
        S = np.swapaxes(A_j, -1, -2) @ A_i
        angles = np.stack([np.arctan2(-S[..., 1, 2], S[..., 2, 2]), np.arctan2(S[..., 0, 2], S[..., 2, 2]), np.arctan2(S[..., 1, 0], S[..., 0, 0])], -1)
        return np.concatenate([d, angles], -1), A_j, r_i

    def force_of(self, c, e, u):
        """Of a bushing: minus the six components of force and torque on I in the axes of J."""
        k = np.concatenate([e["K"], e["KT"]])
        f = k * u
        for axis in range(6):
            key = (c.name, axis)
            if key in self.reality.growing:
                u0 = self.reality.growing[key]
                f[..., axis] = k[axis] * u0 * np.sinh(u[..., axis] / u0)
            if key in self.sliders:
                f[..., axis] += self.sliders[key].force(u[..., axis])
        return f

    def imbalance(self, cs, R, loads, reaction):
        """Forces on the parts (..., parts, 6) with the reactions of the joints (..., m), and the gaps of the joints (..., m). `reaction`
        None: what reactions of one do (..., parts, 6, m) and their yielding besides."""
        batch = cs.shape[:-2]
        Q = np.zeros(batch + (len(self.names), 6))
        gaps, rows, yields = [], [], []

        def act(body, r, f, t=None, onto=Q):
            if body == GROUND:
                return
            k = self.index[body]
            m = cross(r - cs[..., k, :], f)
            onto[..., k, :3] += f
            onto[..., k, 3:] += m if t is None else m + t

        def row(c, gap, r_i, r_j, f, t=None, give=0.0):
            gaps.append(gap), yields.append(give)
            if reaction is None:
                w = np.zeros_like(Q)
                act(c.i, r_i, f, t, w)
                act(c.j, r_j, -f, None if t is None else -t, w)
                rows.append(w)
            else:
                size = reaction[..., len(gaps) - 1, None]
                f, t = size * f, None if t is None else size * t
                act(c.i, r_i, f, t)
                act(c.j, r_j, -f, None if t is None else -t)

        for c, e in self.elements:
            r_i, r_j = self.at(c.i, e["p_i"], cs, R), self.at(c.j, e["p_j"], cs, R)
            if isinstance(c, Spring):
                line = r_i - r_j
                length = np.sqrt(dot(line, line))
                of_rate, of_force = self.reality.springs.get(c.name, (1.0, 1.0))
                push = ((of_force * c.force - of_rate * c.K * (length - c.length)) / length)[..., None] * line
                act(c.i, r_i, push), act(c.j, r_j, -push)
            elif isinstance(c, Bushing):
                u, A_j, r_i = self.deflection(c, e, cs, R)
                f = self.force_of(c, e, u)
                F, T = -(A_j @ f[..., :3, None])[..., 0], -(A_j @ f[..., 3:, None])[..., 0]
                act(c.i, r_i, F, T), act(c.j, r_i, -F, -T)
            elif isinstance(c, Cylinder):
                z, none = self.along(c.i, e["z"], R), np.zeros(batch + (3,))
                for name in ("x", "y"):
                    across = self.along(c.j, e[name], R)
                    row(c, dot(across, r_i - r_j), r_i, r_i, across)
                    row(c, dot(z, across), r_i, r_i, none, cross(z, across))
            else:
                basis, give = self.directions(c, batch, R)
                if self.reality.play and self.reality.play[0] == c.name:
                    self.playing = len(gaps)
                for k in range(3):
                    # Where a link gives, its end is where the ball of the carrier is.
                    row(c, dot(basis[..., k, :], r_i - r_j), r_j, r_j, basis[..., k, :], None, give if k == 0 else 0.0)
                if isinstance(c, Universal):
                    z_i, z_j = self.along(c.i, c.z_i, R), self.along(c.j, c.z_j, R)
                    row(c, dot(z_i, z_j), r_i, r_i, np.zeros(batch + (3,)), cross(z_i, z_j))
        for name in self.names:
            body = self.axle.bodies[name]
            weight = np.broadcast_to([0.0, 0.0, -9.80665 * body.mass], batch + (3,))
            act(name, self.at(name, body.centre, cs, R), weight)
        for k, load in enumerate(self.axle.loads):
            place = self.points[load.at] + self.reality.load_points.get(load.at, 0.0)
            act(load.body, self.at(load.body, place, cs, R), loads[..., k, None] * load.direction)
        gaps = np.stack(gaps, -1)
        return (Q, gaps) if reaction is not None else (Q, gaps, np.stack(rows, -1), np.array(yields))

    def directions(self, c, batch, R):
        """Along which a ball or a cross holds: ground's axes, or the line of a link that gives and two across."""
        soft = self.reality.compliance.get(c.name)
        if self.reality.play and self.reality.play[0] == c.name:
            soft = (*self.reality.play[1:3], 0.0)
        if not soft:
            return np.broadcast_to(np.eye(3), batch + (3, 3)), 0.0
        body, other, give = soft
        line = self.points[c.at] - self.points[other]
        line /= np.linalg.norm(line)
        second = np.cross(line, np.eye(3)[np.argmin(np.abs(line))])
        second /= np.linalg.norm(second)
        own = (line, second, np.cross(line, second))
        return np.stack([self.along(body, v, R) for v in own], -2), give

    def taken(self, force):
        """How far a joint with play has moved, and its derivative."""
        half, of = self.reality.play[3:]
        x = np.clip(force / of, -50.0, 50.0)
        return half * np.tanh(x), half / of / np.cosh(x) ** 2

    def solve(self, loads, start=None):
        """Poses (cases, parts): origins and rotation matrices. `loads` (cases, loads) are those that act."""
        n, cases = len(self.names), len(loads)
        if start is None:
            cs, R = np.tile(self.origins, (cases, 1, 1)), np.tile(np.eye(3), (cases, n, 1, 1))
        else:
            cs, R = start[0].copy(), start[1].copy()
        reaction, factor = None, None
        scale_q = np.tile([1.0, 1.0, 1.0, 1e-2, 1e-2, 1e-2], n)
        scale_f = np.tile([1e-4, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6], n)
        h = np.tile([STEP] * 3 + [TURN] * 3, n)
        small = [exp(TURN * np.eye(3)[k]) for k in range(3)]
        last = np.inf
        for _ in range(100):
            Q, g, W, give = self.imbalance(cs, R, loads, None)
            m = g.shape[-1]
            Q, W = Q.reshape(cases, 6 * n), W.reshape(cases, 6 * n, m)
            if reaction is None:
                reaction = np.stack([np.linalg.lstsq(w * scale_f[:, None], -q * scale_f, rcond=None)[0] for q, w in zip(Q, W)])
            columns = np.concatenate([scale_q, np.full(m, 1e4)])
            rows = np.concatenate([scale_f, np.ones(m)])
            total = Q + (W @ reaction[..., None])[..., 0]
            if last > 1e-2 or factor is None:
                many_c, many_R = np.repeat(cs[:, None], 6 * n, 1), np.repeat(R[:, None], 6 * n, 1)
                for part in range(n):
                    for k in range(3):
                        many_c[:, 6 * part + k, part, k] += STEP
                        many_R[:, 6 * part + k + 3, part] = small[k] @ R[:, part]
                moved, gaps = self.imbalance(many_c, many_R, loads[:, None], reaction[:, None])
                J = np.zeros((cases, 6 * n + m, 6 * n + m))
                J[:, : 6 * n, : 6 * n] = np.swapaxes(moved.reshape(cases, 6 * n, 6 * n) - total[:, None], 1, 2) / h
                J[:, 6 * n :, : 6 * n] = np.swapaxes(gaps - g[:, None], 1, 2) / h
                J[:, : 6 * n, 6 * n :] = W
                J[:, 6 * n :, 6 * n :] += np.diag(give)
                if self.reality.play:
                    k = self.playing
                    J[:, 6 * n + k, 6 * n + k] += self.taken(reaction[:, k])[1]
                try:
                    factor = np.linalg.inv(J * rows[:, None] * columns)
                except np.linalg.LinAlgError as error:
                    raise NoEquilibrium(str(error)) from error
            gap = g + give * reaction
            if self.reality.play:
                gap[:, self.playing] += self.taken(reaction[:, self.playing])[0]
            residual = np.concatenate([total, gap], 1)
            step = -(factor @ (residual * rows)[..., None])[..., 0] * columns
            motion = step[:, : 6 * n].reshape(cases, n, 6)
            far = np.maximum(np.abs(motion[..., :3]).max((1, 2)) / 30.0, np.abs(motion[..., 3:]).max((1, 2)) / 0.1)
            if not np.all(np.isfinite(far)):
                raise NoEquilibrium("the iteration diverges")
            share = 1.0 / np.maximum(far, 1.0)
            cs += share[:, None, None] * motion[..., :3]
            R = exp(share[:, None, None] * motion[..., 3:]) @ R
            reaction = reaction + share[:, None] * step[:, 6 * n :]
            slow = far.max() > 0.1 * last  # the old derivatives no longer do
            last = far.max()
            if last < 1e-9:
                return cs, R
            if slow:
                factor = None
        raise NoEquilibrium("no equilibrium in 100 steps")

    def sweep(self):
        """All load cases: at once, or one after the other where the past matters."""
        matrix = self.reality.load_matrix
        loads = np.array(self.axle.cases, float) + self.reality.load_errors
        loads = loads if matrix is None else loads @ np.asarray(matrix).T
        if not self.sliders:
            return self.solve(loads)
        friction = dict(self.sliders)
        self.sliders = {}
        first = self.solve(loads[:1])
        self.sliders = friction
        here, found = first, []
        for row in loads:
            here = self.solve(row[None], here)
            for (name, axis), slider in self.sliders.items():
                c, e = next((c, e) for c, e in self.elements if c.name == name)
                slider.settle(self.deflection(c, e, *here)[0][0, axis])
            found.append(here)
        return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])

    def ranges(self, poses):
        """Smallest and largest of each component of each bushing's deflection."""
        found = {}
        for c, e in self.elements:
            if isinstance(c, Bushing):
                u = self.deflection(c, e, *poses)[0]
                found[c.name] = (u.min(0), u.max(0))
        return found

    def marks(self, poses, places=None):
        """(cases, parts, marks, 3); `places` by part instead of the axle's."""
        cs, R = poses
        out = []
        for k, name in enumerate(self.names):
            p = self.axle.bodies[name].marks if places is None else places[name]
            out.append(cs[:, k, None, :] + (p - self.origins[k]) @ np.swapaxes(R[:, k], -1, -2))
        return np.stack(out, 1)


class Sliders:
    """Dry friction as many small sliders side by side, which slip one after the other (Iwan): half of the force has slipped at `reach`,
    all of it at twice that. Starts without force at the place of the first look."""

    def __init__(self, force, reach, count=6):
        limits = 2.0 * reach * (np.arange(count) + 0.5) / count
        self.stiffness = force / limits.sum() * np.ones(count)
        self.limits, self.anchors = limits, np.zeros(count)

    def force(self, u):
        stretch = np.asarray(u)[..., None] - self.anchors
        return np.sum(self.stiffness * np.clip(stretch, -self.limits, self.limits), -1)

    def settle(self, u):
        self.anchors = u - np.clip(u - self.anchors, -self.limits, self.limits)
