"""Decks for both solvers: reads the kind of deck that ADAMS/View writes, and writes chains."""

import math
import re


class Statement(dict):
    """Arguments of one statement by name, each a list of words; a flag has an empty list."""

    def __init__(self, kind, id_, name):
        super().__init__()
        self.kind, self.id, self.name = kind, id_, name

    def numbers(self, argument, count):
        return [number(word) for word in self[argument]] if argument in self else [0.0] * count

    def number(self, argument):
        return self.numbers(argument, 1)[0]


def number(word):
    return math.radians(float(word[:-1])) if word[-1] in "Dd" else float(word)


def read(path):
    """Statements by kind and id. One argument per line, as ADAMS/View writes."""
    deck, name, current = {}, "", None
    with open(path, encoding="latin-1") as file:
        for line in file.read().splitlines()[1:]:
            named = re.match(r"!.*adams_view_name='([^']*)'", line)
            name = named.group(1) if named else name
            text = line.split("!")[0].strip()
            head = re.match(r"([A-Za-z_]+)/(\d*)\s*,?", text)
            if head:
                id_ = int(head.group(2) or 0)
                current = Statement(head.group(1).upper(), id_, name)
                deck.setdefault(current.kind, {})[id_] = current
                name, text = "", text[head.end() :]
            if not text or current is None or text == "END":
                continue
            argument = None
            for word in re.split(r"\s*,\s*", text.lstrip(", ")):
                assigned = re.match(r"([A-Za-z]+)\s*=\s*(.*)", word)
                if assigned:
                    argument, word = assigned.group(1).upper(), assigned.group(2)
                    current[argument] = []
                if argument is None:
                    current[word.upper()] = []
                else:
                    current[argument].append(word)
    return deck


def rotation(psi, theta, phi):
    """Body 3-1-3, rows of the matrix."""
    (c1, s1), (c2, s2), (c3, s3) = ((math.cos(a), math.sin(a)) for a in (psi, theta, phi))
    return [
        [c1 * c3 - s1 * c2 * s3, -c1 * s3 - s1 * c2 * c3, s1 * s2],
        [s1 * c3 + c1 * c2 * s3, -s1 * s3 + c1 * c2 * c3, -c1 * s2],
        [s2 * s3, s2 * c3, c2],
    ]


def write_chain(path, bodies):
    """Rigid links in a row along x, joined by bushings, the first one and every tenth held to ground by a bushing as well; gravity
    and a force at the free end bend it in one plane.

    Equal translational stiffnesses and one rotation axis: there the bushing laws of ADAMS and of Exudyn are the same. The force
    is along the deflection, so that delta x F vanishes, and projected angles are Cardan angles. The supports keep the equations
    well conditioned at any length.
    """
    length, out = 100.0, ["Chain of %d bodies joined by bushings" % bodies]
    out += ["UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = MILLIMETER, TIME = SECOND"]
    out += ["PART/1", ", GROUND", "MARKER/1, PART = 1", "MARKER/2, PART = 1", ", REULER = 0.0D, -90.0D, 0.0D"]
    for k in range(bodies):
        part, start, end, cm, support = k + 2, *(4 * k + 11 + m for m in range(4))
        out += [f"PART/{part}", f", QG = {length * k!r}, 0.0, 0.0", ", MASS = 1.0", f", CM = {cm}", ", IP = 1000.0, 1000.0, 1000.0"]
        out += [f"MARKER/{start}", f", PART = {part}", f"MARKER/{end}", f", PART = {part}", f", QP = {length!r}, 0.0, 0.0"]
        out += [f"MARKER/{cm}", f", PART = {part}", f", QP = {length / 2!r}, 0.0, 0.0"]
        out += bushing(2 * k + 1, start, 1 if k == 0 else 4 * (k - 1) + 12)
        if k % 10 == 9:
            out += [f"MARKER/{support}", ", PART = 1", f", QP = {length * (k + 1)!r}, 0.0, 0.0"]
            out += bushing(2 * k + 2, end, support)
    tip = 4 * (bodies - 1) + 12
    out += ["SFORCE/1", ", TRANSLATIONAL", f", I = {tip}", ", J = 2", ", ACTIONONLY", ", FUNCTION = 20.0"]
    out += ["ACCGRAV/", ", JGRAV = -9806.65", "RESULTS/XRF", "END"]
    with open(path, "w") as file:
        file.write("\n".join(out) + "\n")


def bushing(id_, i, j):
    stiffness = [", K = 1.0E+04, 1.0E+04, 1.0E+04", ", KT = 1.0E+06, 1.0E+06, 1.0E+06"]
    return [f"BUSHING/{id_}", f", I = {i}", f", J = {j}", ", C = 0.0, 0.0, 0.0", ", CT = 0.0, 0.0, 0.0", *stiffness]


def write_with_equal_stiffnesses(deck, copy):
    """The same deck with K = kx, kx, kx in every bushing: there the force is along the deflection, and delta x F vanishes."""
    with open(deck, encoding="latin-1") as file:
        text = file.read()
    text = re.sub(r"(?m)^, K = ([^,\s]+), [^,\s]+, [^,\s]+", r", K = \1, \1, \1", text)
    with open(copy, "w", encoding="latin-1") as file:
        file.write(text)
