"""Makes corpus/adams-car-axle from the folder that `admire rebuild` writes for the lateral test of a real axle.

    admire rebuild NRAC_G023_Lat_static_load.res --out out/rebuilt
    python3 corpus/rigs/adams-car-axle/make.py out/rebuilt corpus/adams-car-axle

The results are those of Quan-Rong/KinBenchTool2025_neu (Adams/Car 2020). Only figures that follow from them enter the folder. The deck
is the left side of the rebuilt one with four changes: tables and jacks of the rig are left out, the tyre forces are loads of the study,
bushings with curves become linear with their stiffness at the design position, and figures are rounded. The readings are the places of parts in the results,
with the noise of a measuring arm.
"""

import csv
import random
import re
import sys
from pathlib import Path

SEED = 67
NOISE = 0.02  # mm, of a coordinate
EVERY = 4  # of the 101 states
MEASURED = ["gel_arm", "gel_lower_strut", "gel_upper_strut"]
LOADS = ["fx", "fy", "fz", "tx", "ty", "tz"]
# The rig, and the right side: nothing but ground connects both.
LEFT_OUT = ["_cv_part", "table", "jack", "steering", "ger_", "whr_"]
NUMBER = r"-?[\d.]+(?:E[+-]?\d+)?"


class Statement:
    """One statement of the rebuilt deck: kind, id, view name, and its arguments in order."""

    def __init__(self, text, name):
        head, *rest = [line.strip() for line in text.split("\n, ")]
        self.kind, _, number = head.partition("/")
        self.id = int(number) if number.isdigit() else None
        self.name = name
        self.arguments = {}
        last = None
        for piece in rest:
            word = re.match(r"([A-Z]+) = ", piece)
            if word:
                last = word[1]
                self.arguments[last] = piece[word.end() :]
            elif re.fullmatch(r"[A-Z_]+", piece):
                self.arguments[piece] = None
            else:
                joint = ", " if self.kind in ("SPLINE", "MARKER", "PART", "BUSHING") else ""
                self.arguments[last] += joint + piece
        for word, value in self.arguments.items():
            self.arguments[word] = value and value.rstrip("\\").replace("\n", "")

    def numbers(self, word):
        return [float(n) for n in self.arguments[word].split(",")]

    def reference(self, word):
        return int(self.arguments[word])

    def write(self):
        name = f"! adams_view_name='{self.name}'\n" if self.name else ""
        head = self.kind if self.id is None else f"{self.kind}/{self.id}"
        end = "\\" if self.kind == "GFORCE" else ""
        given = [w if v is None else f"{w} = {v}" for w, v in self.arguments.items()]
        for k, text in enumerate(given[:-1]):
            if end and text[:2] in ("FX", "FY", "FZ", "TX", "TY", "TZ"):
                given[k] = text + end
        return name + "\n, ".join([head] + given) + "\n"


def statements(text):
    """Yields the statements of the deck between UNITS and ACCGRAV."""
    name = None
    for block in re.split(r"\n(?!,)", text):
        view = re.match(r"!\s+adams_view_name='(.*)'", block)
        if view:
            name = view[1].split(".", 1)[1] if "." in view[1] else view[1]
        elif re.match(r"[A-Z_]+/\d+", block):
            yield Statement(block, name)
            name = None


def tidy(values, digits):
    """Numbers without the round-off that a rebuilt deck carries."""
    words = [f"{round(value, digits) + 0.0:.{digits}f}".rstrip("0") for value in values]
    return ", ".join(word + "0" if word.endswith(".") else word for word in words)


def linear(axis, law, splines):
    """Preload and stiffness at the design position of one axis of a bushing with curves."""
    radial = re.match(rf"({NUMBER})-AKISPL\(SQRT\(.*?\),0,(\d+)\)", law)
    if radial:
        x, y = splines[int(radial[2])]
        at = next(k for k in range(len(x)) if x[k] > 0.0)
        return float(radial[1]), y[at] / x[at]
    curve = re.match(r"AKISPL\(D[XYZ]\(.*?\),0,(\d+)\)", law)
    if curve:
        x, y = splines[int(curve[1])]
        at = next(k for k in range(len(x)) if x[k] > 0.0)
        slope = (y[at] - y[at - 1]) / (x[at] - x[at - 1])
        return y[at] - slope * x[at], -slope
    line = re.match(rf"({NUMBER})-\(?({NUMBER})\)?\*", law)
    return float(line[1]), float(line[2])


def main(source, target):
    text = (source / "model.adm").read_text()
    all_of = list(statements(text))
    splines = {s.id: (s.numbers("X"), s.numbers("Y")) for s in all_of if s.kind == "SPLINE"}
    parts = {s.id: s for s in all_of if s.kind == "PART"}
    markers = {s.id: s for s in all_of if s.kind == "MARKER"}
    gone = {k for k, s in parts.items() if any(word in (s.name or "") for word in LEFT_OUT)}
    part_of = lambda marker: markers[marker].reference("PART")
    kept = []
    last = max(s.id for s in all_of if s.kind == "BUSHING")
    for s in all_of:
        ends = [s.reference(w) for w in ("I", "J") if s.kind != "MARKER" and s.arguments.get(w)]
        if s.kind == "SPLINE" or s.kind == "PART" and s.id in gone or any(part_of(m) in gone for m in ends):
            continue
        if s.kind == "MOTION":
            continue
        if s.kind == "GFORCE" and "AKISPL(TIME" in s.arguments["FZ"]:
            s.id = 1
            markers[s.reference("JFLOAT")].arguments["PART"] = "1"
            for word in ("FX", "FY", "FZ", "TX", "TY", "TZ"):
                s.arguments[word] = "0.0"
        elif s.kind == "GFORCE":
            last += 1
            words = ("FX", "FY", "FZ", "TX", "TY", "TZ")
            laws = [linear(k, s.arguments[word], splines) for k, word in enumerate(words)]
            s.kind, s.id = "BUSHING", last
            s.arguments = {
                "I": s.arguments["I"],
                "J": s.arguments["RM"],
                "K": tidy((k for _, k in laws[:3]), 3),
                "KT": tidy((k for _, k in laws[3:]), 1),
                "FORCE": tidy((p for p, _ in laws[:3]), 3),
                "TORQUE": tidy((p for p, _ in laws[3:]), 3),
            }
        elif s.kind == "BUSHING":
            for word, digits in (("K", 3), ("KT", 1), ("FORCE", 3), ("TORQUE", 3)):
                s.arguments[word] = tidy(s.numbers(word), digits)
            del s.arguments["C"], s.arguments["CT"]
        elif s.kind == "SPRINGDAMPER":
            for word in ("K", "LENGTH"):
                s.arguments[word] = tidy(s.numbers(word), 6)
        kept.append(s)
    used = {m for s in kept if s.kind != "MARKER" for w in ("I", "J", "JFLOAT", "RM", "CM") if s.arguments.get(w) for m in [s.reference(w)]}
    kept = [s for s in kept if s.kind != "MARKER" or s.id in used and s.reference("PART") not in gone]
    for s in kept:
        if s.kind in ("MARKER", "PART"):
            for word, digits in (("QP", 6), ("QG", 6), ("REULER", 12), ("MASS", 6), ("IP", 3)):
                if s.arguments.get(word):
                    s.arguments[word] = tidy(s.numbers(word), digits)
    # In a deck, the markers of a part follow it.
    order = {s.id: k for k, s in enumerate(kept) if s.kind == "PART"}
    place = lambda s: (order.get(s.id), 0) if s.kind == "PART" else (order[s.reference("PART")], 1) if s.kind == "MARKER" else (10**6, 0)
    kept.sort(key=place)
    head = (
        "Left side of a rear axle of Adams/Car, rebuilt from its results of a lateral test, with linear bushings\n!\n"
        "! Made by corpus/rigs/adams-car-axle/make.py. Figures follow from results of Quan-Rong/KinBenchTool2025_neu.\n!\n"
        "UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = MILLIMETER, TIME = SECOND\n!\n"
    )
    tail = "ACCGRAV/IGRAV = 0.0, JGRAV = 0.0, KGRAV = -9806.65\nEQUILIBRIUM/ERROR = 1.0E-10, IMBALANCE = 1.0E-7, MAXIT = 200\nEND\n"
    target.mkdir(parents=True, exist_ok=True)
    (target / "model.adm").write_text(head + "".join(s.write() for s in kept) + tail)

    names = {k: s.name for k, s in parts.items()}
    rows = list(csv.DictReader(open(source / "load_cases.csv")))
    chosen = [row["case"] for row in rows[::EVERY]]
    columns = {f"tire_{w}": f"testrig_til_wheel_force_{w}" for w in LOADS}
    lines = ["case," + ",".join(columns)]
    for row in rows[::EVERY]:
        lines.append(row["case"] + "," + ",".join(tidy([float(row[c])], 6) for c in columns.values()))
    (target / "load_cases.csv").write_text("\n".join(lines) + "\n")
    measured = {k for k, name in names.items() if name in MEASURED}
    number = lambda row: int(row["part"].split("/")[1])
    lines = ["part,mark,x,y,z"]
    for row in csv.DictReader(open(source / "marks_on_parts.csv")):
        if number(row) in measured:
            lines.append(f"{row['part']},{row['mark']},{row['x']},{row['y']},{row['z']}")
    (target / "marks_on_parts.csv").write_text("\n".join(lines) + "\n")
    noise = random.Random(SEED)
    lines = ["case,part,mark,x,y,z"]
    for row in csv.DictReader(open(source / "marks_measured.csv")):
        if row["case"] in chosen and number(row) in measured:
            at = [float(row[w]) + noise.gauss(0.0, NOISE) for w in "xyz"]
            lines.append(f"{row['case']},{row['part']},{row['mark']}," + ",".join(f"{v:.4f}" for v in at))
    (target / "marks_measured.csv").write_text("\n".join(lines) + "\n")
    loads = {f"tire_{w}": f"GFORCE/1.{w.upper()}" for w in LOADS}
    arms = [f'"BUSHING/{s.id}"' for s in kept if s.kind == "BUSHING" and "arm" in s.name]
    study = (
        "# The left side of a rear axle of Adams/Car under lateral forces. The deck has linear bushings; the axle has not.\n"
        '[model]\ndeck = "model.adm"\n\n[loads]\nfile = "load_cases.csv"\n\n[loads.columns]\n'
        + "".join(f'{name} = "{address}"\n' for name, address in loads.items())
        + '\n[marks]\non_parts = "marks_on_parts.csv"\nmeasured = "marks_measured.csv"\nsigma = 0.02\n'
        + f'\n[identify]\nbushings = [{", ".join(arms)}]\ninitial = "deck"\n'
        + "prior_log_sd = 0.7                # the stiffness in the deck is right to a factor of two\n"
    )
    (target / "study.toml").write_text(study)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
