"""Axles of random geometry: McPherson, double wishbone, five links, trailing arm. Left side, x to the rear, y to the right, z up."""

import numpy as np

from parts import GROUND, Axle, Ball, Body, Bushing, Cylinder, Load, Spring, Universal, frame_along

COLUMNS = ("vertical", "lateral", "longitudinal")
DIRECTIONS = (np.array([0.0, 0, 1]), np.array([0.0, 1, 0]), np.array([1.0, 0, 0]))


def programme(stand):
    """31 cases: each load up and down around the standing load, then all together."""
    v, step = stand, stand / 3
    rows = [(k * step, 0, 0) for k in (1, 2, 3, 4, 5, 4, 3, 2)]
    rows += [(v, y, 0) for y in (1000, 2000, 3000, 4000, 2000, 0, -2000, -4000, -2000, 0)]
    rows += [(v, 0, x) for x in (1000, 2000, 4000, 2000, 0, -2000, -4000, -2000, 0)]
    rows += [(v + step, 1500, -1500), (v - step, -1500, 1500), (v + step, -1500, -1500), (v - step, 1500, 1500)]
    return rows


class Drawing:
    """Collects an axle; all that is random comes from one generator."""

    def __init__(self, kind, rng, points, spread):
        self.kind, self.rng = kind, rng
        self.points = {n: np.array(p, float) + (rng.uniform(-spread, spread, 3) if n != "WC" else 0.0) for n, p in points.items()}
        if "WC" in points:
            self.points["WC"] = self.points["CP"] + np.array([0, 0, 310.0]) + rng.uniform(-5, 5, 3)
        self.bodies, self.connections, self.links = {}, [], {}

    def body(self, name, mass, *at):
        """A part that spans some points, with four marks near them."""
        rng, places = self.rng, np.array([self.points[n] for n in at])
        frame = tuple(np.round(rng.uniform([-170, 5, -170], [170, 40, 170])))
        marks = []
        for k in range(4):
            weight = rng.dirichlet(np.full(len(places), 0.7))
            marks.append(weight @ places + rng.uniform(20, 55) * direction(rng))
        marks = np.array(marks)
        # Four marks in one plane would say little of one rotation.
        while np.linalg.svd(marks - marks.mean(0))[1][1] < 40:
            marks = places.mean(0) + rng.uniform(-90, 90, (4, 3))
        self.bodies[name] = Body(places[0].copy(), mass, places.mean(0), frame, marks)

    def bushing(self, name, body, at, axis, K, KT, sought=True, about=None):
        rng = self.rng
        axes = frame_along(self.tilted(axis), rng.uniform(-0.5, 0.5) if about is None else about)
        K, KT = (np.array(v, float) * np.exp(rng.normal(0, 0.35, 3)) for v in (K, KT))
        self.connections.append(Bushing(name, body, GROUND, at, axes, K, KT, sought))

    def tilted(self, axis):
        v = np.array(axis, float) + self.rng.normal(0, 0.05, 3)
        return v / np.linalg.norm(v)

    def rod(self, name, inner, outer, carrier, ball):
        """A link from ground to the carrier: universal inside, ball outside."""
        self.body(name, 0.9, inner, outer)
        line = self.points[outer] - self.points[inner]
        line /= np.linalg.norm(line)
        up = np.cross(np.cross(line, self.tilted([0, 0, 1])), line)
        self.connections.append(Ball(ball, name, carrier, outer))
        side = np.cross(line, up)
        self.connections.append(Universal(name + "_INNER", name, GROUND, inner, up / np.linalg.norm(up), side / np.linalg.norm(side)))
        self.links[name] = (inner, outer, ball)

    def spring(self, body, at, top, K, force, reach_i=None):
        length = np.linalg.norm(self.points[at] - self.points[top])
        K, force = K * np.exp(self.rng.normal(0, 0.1)), force * self.rng.uniform(0.93, 1.07)
        self.connections.append(Spring("COIL", body, GROUND, at, top, round(K, 3), round(force, 1), length))

    def axle(self, carrier, cases):
        spin = -np.array([0.0, 1, 0]) + self.rng.normal(0, 0.02, 3)
        loads = [Load(c, carrier, "CP", d) for c, d in zip(COLUMNS, DIRECTIONS)]
        return Axle(self.kind, self.points, self.bodies, self.connections, loads, (carrier, "WC", spin / np.linalg.norm(spin)), cases, self.links)


def direction(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


RADIAL, ANGLE = (9000, 9000, 1800), (6e5, 6e5, 2e5)


def mcpherson(rng):
    points = dict(A=(35, -365, 208), B=(-310, -385, 212), FRONT=(-22, -708, 192), REAR=(14, -702, 188), LOW=(10, -640, 450), TOP=(38, -572, 865),
                  SEAT=(34, -580, 800), TI=(135, -345, 236), TO=(132, -690, 228), CP=(2, -762, 0), WC=(0, 0, 0))
    d = Drawing("mcpherson", rng, points, 14)
    # The coil stands on the strut's line.
    low, top = d.points["LOW"], d.points["TOP"]
    d.points["SEAT"] = low + 0.86 * (top - low)
    d.body("FRONT_ARM", 1.8, "B", "FRONT")
    d.body("REAR_ARM", 2.3, "A", "REAR")
    d.body("KNUCKLE", 14.0, "FRONT", "REAR", "LOW", "TO", "WC")
    d.body("ROD", 1.2, "TOP", "LOW")
    d.bushing("A", "REAR_ARM", "A", (1, 0.1, 0.1), (12000, 12000, 1600), ANGLE)
    d.bushing("B", "FRONT_ARM", "B", (0.2, 0.1, 1), (700, 4000, 500), (2e5, 6e4, 9e4), about=0.0)
    d.bushing("TOP_MOUNT", "ROD", "TOP", (0, 0.1, 1), (3500, 3500, 1500), (1.4e5, 1.4e5, 3.4e4), sought=False)
    d.connections += [Ball("FRONT_BALL", "FRONT_ARM", "KNUCKLE", "FRONT"), Ball("REAR_BALL", "REAR_ARM", "KNUCKLE", "REAR")]
    d.connections.append(Cylinder("STRUT", "ROD", "KNUCKLE", "LOW", ("LOW", "TOP"), 160.0))
    d.rod("TIE_ROD", "TI", "TO", "KNUCKLE", "TIE_BALL")
    d.spring("KNUCKLE", "LOW", "SEAT", 58.0, 4600.0)
    return d.axle("KNUCKLE", programme(4500))


def double_wishbone(rng):
    points = dict(LF=(-190, -372, 196), LR=(205, -380, 192), LB=(4, -722, 182), UF=(-125, -448, 482), UR=(142, -452, 476), UB=(12, -688, 468),
                  FOOT=(8, -585, 200), SEAT=(14, -508, 585), TI=(150, -392, 252), TO=(142, -702, 240), CP=(0, -765, 0), WC=(0, 0, 0))
    d = Drawing("double-wishbone", rng, points, 14)
    d.body("LOWER_ARM", 3.1, "LF", "LR", "LB", "FOOT")
    d.body("UPPER_ARM", 1.9, "UF", "UR", "UB")
    d.body("KNUCKLE", 12.0, "LB", "UB", "TO", "WC")
    d.bushing("LOWER_FRONT", "LOWER_ARM", "LF", (1, 0, 0), RADIAL, ANGLE)
    d.bushing("LOWER_REAR", "LOWER_ARM", "LR", (1, 0, 0), (6000, 6000, 1200), ANGLE)
    d.bushing("UPPER_FRONT", "UPPER_ARM", "UF", (1, 0, 0), RADIAL, ANGLE, sought=False)
    d.bushing("UPPER_REAR", "UPPER_ARM", "UR", (1, 0, 0), RADIAL, ANGLE, sought=False)
    d.connections += [Ball("LOWER_BALL", "LOWER_ARM", "KNUCKLE", "LB"), Ball("UPPER_BALL", "UPPER_ARM", "KNUCKLE", "UB")]
    d.rod("TIE_ROD", "TI", "TO", "KNUCKLE", "TIE_BALL")
    d.spring("LOWER_ARM", "FOOT", "SEAT", 120.0, 7300.0)
    return d.axle("KNUCKLE", programme(4200))


def five_link(rng):
    points = dict(LFI=(-155, -352, 203), LFO=(-42, -704, 188), LRI=(118, -302, 207), LRO=(58, -708, 186), UFI=(-112, -424, 432), UFO=(-22, -684, 442),
                  URI=(92, -432, 424), URO=(38, -678, 446), TI=(196, -338, 232), TO=(152, -702, 236), FOOT=(84, -560, 196), SEAT=(86, -530, 520),
                  CP=(0, -768, 0), WC=(0, 0, 0))
    d = Drawing("five-link", rng, points, 12)
    d.body("KNUCKLE", 13.0, "LFO", "LRO", "UFO", "URO", "TO", "WC")
    for name, inner, outer, axis in (("LOWER_FRONT", "LFI", "LFO", (1, 0.3, 0)), ("LOWER_REAR", "LRI", "LRO", (1, -0.1, 0)),
                                     ("UPPER_FRONT", "UFI", "UFO", (1, 0.3, 0)), ("UPPER_REAR", "URI", "URO", (1, -0.2, 0))):
        d.body(name, 1.6, inner, outer, *(["FOOT"] if name == "LOWER_REAR" else []))
        d.bushing(name + "_BUSH", name, inner, axis, RADIAL, ANGLE, sought=name.startswith("LOWER"))
        d.connections.append(Ball(name + "_BALL", name, "KNUCKLE", outer))
    d.rod("TOE_LINK", "TI", "TO", "KNUCKLE", "TOE_BALL")
    d.spring("LOWER_REAR", "FOOT", "SEAT", 130.0, 6800.0)
    return d.axle("KNUCKLE", programme(4200))


def trailing_arm(rng):
    points = dict(P=(-345, -425, 252), LI=(55, -255, 232), LO=(38, -628, 226), UI=(10, -300, 462), UO=(2, -610, 470), FOOT=(14, -565, 222),
                  SEAT=(18, -548, 545), CP=(0, -742, 0), WC=(0, 0, 0))
    d = Drawing("trailing-arm", rng, points, 12)
    d.body("ARM", 16.0, "P", "LO", "UO", "WC")
    d.bushing("PIVOT", "ARM", "P", (0.2, 1, 0), (2500, 2500, 900), (4e5, 4e5, 1.2e5))
    d.rod("LOWER_LINK", "LI", "LO", "ARM", "LOWER_BALL")
    d.rod("UPPER_LINK", "UI", "UO", "ARM", "UPPER_BALL")
    d.spring("ARM", "FOOT", "SEAT", 70.0, 4300.0)
    return d.axle("ARM", [(4000, 0, 0), (6000, 0, 0), (4000, 2000, 0), (4000, -2000, 0), (4000, 0, 1500), (4000, 0, -1500)])


KINDS = {"mcpherson": mcpherson, "double-wishbone": double_wishbone, "five-link": five_link, "trailing-arm": trailing_arm}
