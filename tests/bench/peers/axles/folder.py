"""Writes an axle as a dataset of ADAMS and a measurement as a study folder."""

import os

import numpy as np

from parts import GROUND, Ball, Bushing, Cylinder, Spring, Universal, euler313, frame_along, from313

PER_DEGREE = 180 / np.pi


class Deck:
    """Numbers of everything in the dataset of an axle, and its text."""

    def __init__(self, axle, unknown=None):
        """`unknown` is what the deck gives for stiffnesses that are sought: per mm and per degree."""
        self.axle = axle
        self.part = {GROUND: 1} | {n: k + 2 for k, n in enumerate(axle.bodies)}
        self.R = {GROUND: np.eye(3)} | {n: from313(b.frame) for n, b in axle.bodies.items()}
        self.origin = {GROUND: np.zeros(3)} | {n: b.origin for n, b in axle.bodies.items()}
        self.markers = {n: [] for n in self.part}  # by part: (id, name, place, axes)
        self.count = 0
        self.sides = {}  # (connection, side) -> marker
        self.address = {}  # connection -> JOINT/3
        statements = []
        numbers = {}

        def statement(kind, name, *lines):
            numbers[kind] = numbers.get(kind, 0) + 1
            statements.append((kind, numbers[kind], name, lines))
            return f"{kind}/{numbers[kind]}"

        for c in axle.connections:
            frames = self.frames(c)
            for side, body, (place, axes) in (("i", c.i, frames[0]), ("j", c.j, frames[1])):
                self.sides[c.name, side] = self.marker(body, f"{c.name}_{side.upper()}", place, axes)
            i, j = (f"{s.upper()} = {self.sides[c.name, s]}" for s in "ij")
            if isinstance(c, Bushing):
                K, KT = c.K, c.KT
                if unknown and c.sought:
                    K, KT = np.full(3, unknown[0]), np.full(3, unknown[1] * PER_DEGREE)
                lines = [i, j, "C = 0.0, 0.0, 0.0", "K = " + listed(K), "CT = 0.0, 0.0, 0.0", "KT = " + listed(KT)]
                self.address[c.name] = statement("BUSHING", c.name, *lines)
            elif isinstance(c, Spring):
                lines = [i, j, "C = 0.0", f"K = {number(c.K)}", f"FORCE = {number(c.force)}", f"LENGTH = {number(c.length)}", "TRANSLATION"]
                self.address[c.name] = statement("SPRINGDAMPER", c.name, *lines)
            else:
                kind = {Ball: "SPHERICAL", Universal: "UNIVERSAL", Cylinder: "CYLINDRICAL"}[type(c)]
                self.address[c.name] = statement("JOINT", c.name, kind, i, j)
        for load in axle.loads:
            if ("load", load.at) not in self.sides:
                self.sides["load", load.at] = self.marker(load.body, load.at, axle.points[load.at], np.eye(3))
            towards = self.marker(GROUND, load.column.upper() + "_AXIS", np.zeros(3), frame_along(load.direction))
            lines = ["TRANSLATIONAL", f"I = {self.sides['load', load.at]}", f"J = {towards}", "ACTIONONLY", "FUNCTION = 0.0"]
            self.address[load.column] = statement("SFORCE", "F_" + load.column.upper(), *lines)
        body, centre, spin = axle.wheel
        axes = frame_along(spin)
        self.wheel = self.marker(body, "WHEEL_CENTRE", axle.points[centre], np.column_stack([axes[:, 1], axes[:, 2], axes[:, 0]]))
        self.centres = {n: self.marker(n, "", b.centre, self.R[n]) for n, b in axle.bodies.items()}
        self.text = self.write(statements)

    def frames(self, c):
        """Place and axes of both markers of a connection."""
        p = self.axle.points
        if isinstance(c, Spring):
            axes = frame_along(p[c.at_i] - p[c.at_j])
            return (p[c.at_i], axes), (p[c.at_j], axes)
        if isinstance(c, Bushing):
            return ((p[c.at], c.axes),) * 2
        if isinstance(c, Universal):
            return (p[c.at], frame_along(c.z_i)), (p[c.at], frame_along(c.z_j))
        if isinstance(c, Cylinder):
            a, b = (p[n] for n in c.line)
            axes = frame_along(b - a)
            return (p[c.at] + c.reach * axes[:, 2], axes), (p[c.at], axes)
        return ((p[c.at], np.eye(3)),) * 2

    def marker(self, body, name, place, axes):
        self.count += 1
        self.markers[body].append((self.count, name, place, axes))
        return self.count

    def on_part(self, body, place):
        return self.R[body].T @ (place - self.origin[body])

    def write(self, statements):
        lines = [f"Suspension, {len(self.axle.bodies)} parts", "!", "! mm, N, kg; KT is N.mm per radian", "!",
                 "UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND"]

        def put(kind, id_, name, arguments):
            lines.append("!" if not name else f"!                 adams_view_name='{name}'")
            lines.append(f"{kind}/{id_}")
            lines.extend(", " + a for a in arguments)

        for name, id_ in self.part.items():
            if name == GROUND:
                put("PART", id_, "ground", ["GROUND"])
            else:
                b = self.axle.bodies[name]
                put("PART", id_, name, ["QG = " + listed(b.origin), "REULER = " + degrees(b.frame), f"MASS = {number(b.mass)}", f"CM = {self.centres[name]}",
                                        "IP = 1.0E+04, 1.0E+04, 1.0E+04"])
            for marker, own, place, axes in self.markers[name]:
                put("MARKER", marker, own, [f"PART = {id_}", "QP = " + listed(self.on_part(name, place)), "REULER = " + degrees(euler313(self.R[name].T @ axes))])
        for kind, id_, name, arguments in statements:
            put(kind, id_, name, arguments)
        lines += ["!", "ACCGRAV/", ", KGRAV = -9806.65", "!", "OUTPUT/REQSAVE", "RESULTS/XRF", "!", "END", ""]
        return "\n".join(lines)

    def meeting(self, point):
        """Markers of the connections that meet at a point of the car."""
        found = []
        for c in self.axle.connections:
            places = {"i": c.at_i, "j": c.at_j} if isinstance(c, Spring) else {"i": c.at, "j": c.at}
            if isinstance(c, Cylinder):
                places.pop("i")
            found += [f"MARKER/{self.sides[c.name, s]}" for s, at in places.items() if at == point]
        return found


def number(x):
    return f"{x:.14g}" if "." in f"{x:.14g}" or "e" in f"{x:.14g}" else f"{x:.14g}.0"


def listed(values):
    return ", ".join(number(v) for v in values)


def degrees(values):
    return ", ".join(number(v) + "D" for v in values)


def write_study(path, deck, measured, digits=6):
    """`measured`: marks (cases, parts, marks, 3) or None, wheel (cases, 5) or None, declared sigmas. `digits` after the point of lengths."""
    fixed = lambda values: [f"{v:.{digits}f}" for v in values]
    axle = deck.axle
    os.makedirs(path, exist_ok=True)
    columns = ", ".join(f'{load.column} = "{deck.address[load.column]}"' for load in axle.loads)
    toml = ['[model]', 'deck = "model.adm"', "", "[loads]", 'file = "load_cases.csv"', f"columns = {{ {columns} }}", ""]
    files = {"model.adm": deck.text}
    labels = [str(k + 1) for k in range(len(axle.cases))]
    files["load_cases.csv"] = rows(["case"] + [load.column for load in axle.loads], ([c, *map("{:g}".format, row)] for c, row in zip(labels, axle.cases)))
    if measured.get("marks") is not None:
        on_parts = ([n, str(k + 1), *fixed(deck.on_part(n, p))] for n, b in axle.bodies.items() for k, p in enumerate(b.marks))
        files["marks_on_parts.csv"] = rows(["part", "mark", "x", "y", "z"], on_parts)
        read = ([c, n, str(k + 1), *fixed(x)] for c, case in zip(labels, measured["marks"]) for n, part in zip(axle.bodies, case) for k, x in enumerate(part))
        files["marks_measured.csv"] = rows(["case", "part", "mark", "x", "y", "z"], read)
        toml += ["[marks]", 'on_parts = "marks_on_parts.csv"', 'measured = "marks_measured.csv"']
        toml += [f"sigma = {measured['sigma']:g}", ""] if measured["sigma"] else [""]
    if measured.get("wheel") is not None:
        files["wheel.csv"] = rows(["case", "x", "y", "z", "camber_deg", "steer_deg"], ([c, *fixed(w)] for c, w in zip(labels, measured["wheel"])))
        sigmas = f"{{ position = {measured['sigma_wheel'][0]:g}, angle_deg = {measured['sigma_wheel'][1]:g} }}"
        toml += ["[wheel]", f'marker = "MARKER/{deck.wheel}"', 'axis = "y"', 'measured = "wheel.csv"', f"sigma = {sigmas}", ""]
    sought = ", ".join(f'"{deck.address[c.name]}"' for c in axle.of(Bushing) if c.sought)
    toml += ["[identify]", f"bushings = [{sought}]", 'method = "gauss-newton"', ""]
    if measured.get("tolerances"):
        toml += ["[tolerances]"] + [f"{name} = {size:g}" for name, size in measured["tolerances"].items()] + [""]
    files["study.toml"] = "\n".join(toml)
    for name, text in files.items():
        with open(os.path.join(path, name), "w") as file:
            file.write(text)


def rows(header, body):
    return "\n".join(",".join(row) for row in [header, *body]) + "\n"
