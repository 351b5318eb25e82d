"""Hidden causes by the curves of a K&C rig and by marks: how often each is named, on the same axle under the same loads.

    cargo build --release
    python tests/bench/kc_causes.py [--admire PATH] [--seeds 4] [--first 1]

Each seed draws for every cause its place and size, and the stiffnesses of the rubber beside it. Two virtual rigs measure the same axle in the same
three loops: one reads toe, camber, caster, travel, base and track of the wheel, the other four marks on each part. A cause is named if a
finding of this cause at this place, or at one that nothing tells from it, has a probability above one half. It can be seen if it is larger than
the limit that the diagnosis states for it. For friction that limit assumes that it slips.
"""

import argparse
import csv
import json
import os
import random
import subprocess
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
RIG = os.path.join(ROOT, "corpus", "rigs", "kc-curves")
MARKS = os.path.join(ROOT, "corpus", "pseudo-mcpherson", "marks_on_parts.csv")
TOLERANCES = "hardpoints=0.2,load_gain=0.003,load_direction_deg=0.057,assembly_offset=0.05,bushing_axis_deg=0.1,preload=0.003"
RUBBER = [f"BUSHING/{bushing}.{kind}.{k}" for bushing in (1, 2) for kind in ("K", "KT") for k in (1, 2, 3)]
RATE = 60.0  # of SPRINGDAMPER/1, in N/mm
LOADS = {"Fz [N]": "SFORCE/3", "Fy [N]": "SFORCE/2", "Fx [N]": "SFORCE/1"}


def causes(draw):
    """Cause, address and the rest of the effect, each drawn anew."""
    sign = lambda: draw.choice((-1, 1))
    between = draw.uniform
    hardpoint = draw.choice(("MARKER/16", "MARKER/14", "MARKER/7", "MARKER/9"))
    bushing = draw.choice(("BUSHING/1.K.1", "BUSHING/2.K.1", "BUSHING/2.K.3"))
    gain = draw.choice(tuple(LOADS.values()))
    return [
        ("hardpoint-error", hardpoint, f"form=point,{draw.choice('yz')}={sign() * between(3, 8):.2f}"),
        ("dry-friction", "JOINT/3", f"force={between(60, 250):.0f},stiffness=3000"),
        ("dry-friction", bushing, f"force={between(100, 300):.0f},stiffness={between(1500, 4000):.0f}"),
        ("link-compliance", "PART/6", f"stiffness={between(2000, 8000):.0f}"),
        ("progressive-stiffness", bushing, f"cubic={between(30, 200):.0f}"),
        ("element-parameter", "SPRINGDAMPER/1.K", f"factor={1 + sign() * between(0.06, 0.15):.3f}"),
        ("stop-contact", "JOINT/3", f"clearance={between(5, 25):.1f},stiffness={between(50, 300):.0f}"),
        ("body-compliance", "BUSHING/3", f"stiffness={between(1000, 5000):.0f}"),
        ("load-gain", gain, f"gain={1 + sign() * between(0.03, 0.08):.3f}"),
        ("free-play", "PART/6", f"gap={between(0.1, 0.5):.2f}"),
    ]


def with_marks(folder):
    """The study of the rig with marks in the place of curves."""
    os.makedirs(folder)
    text = open(os.path.join(RIG, "study.toml")).read()
    head, rest = text.split("[kc]")
    marks = '[marks]\non_parts = "marks_on_parts.csv"\nmeasured = "marks_measured.csv"\nsigma = 0.05\n\n'
    text = head.replace("kc.csv", "load_cases.csv") + marks + "[identify]" + rest.split("[identify]")[1]
    for name, content in (
        ("study.toml", text),
        ("model.adm", open(os.path.join(RIG, "model.adm")).read()),
        ("marks_on_parts.csv", open(MARKS).read()),
    ):
        with open(os.path.join(folder, name), "w") as out:
            out.write(content)
    with open(os.path.join(RIG, "kc.csv")) as rows, open(os.path.join(folder, "load_cases.csv"), "w", newline="") as out:
        table = csv.DictReader(rows)
        out.write(",".join(["case", *LOADS]) + "\n")
        for row in table:
            out.write(",".join([row["case"], *(row[load] for load in LOADS)]) + "\n")


def size(rest):
    """What the limits of a planted effect are of, and its size: a name of findings[].parameters."""
    given = dict(word.split("=") for word in rest.split(","))
    for key in ("x", "y", "z"):
        if key in given:
            return key, abs(float(given[key]))
    if "force" in given:
        return "force", float(given["force"])
    if "factor" in given:
        return "change", abs(float(given["factor"]) - 1) * RATE
    if "gain" in given:
        return "gain", abs(float(given["gain"]) - 1)
    if "cubic" in given:
        return "cubic", float(given["cubic"])
    if "gap" in given:
        return "play", float(given["gap"])
    if "clearance" in given:
        return "stiffness", float(given["stiffness"])
    return "compliance", 1 / float(given["stiffness"])


def is_seen(diagnosis, cause, address, rest):
    """Whether the planted effect is above the limit that a diagnosis states; None if it states none."""
    number, planted = size(rest)
    for limit in diagnosis["detection_limits"]:
        if cause == "hardpoint-error" and address in limit["members"]:
            least = limit["mm"]["xyz".index(number)]
            return least is not None and planted > least
    for limit in diagnosis["cause_limits"]:
        if (limit["cause"], limit["address"], limit["number"]) == (cause, address, number):
            return limit["size"] is not None and planted > limit["size"]
    return None


def named(program, study, out, cause, address, rest):
    """Whether a diagnosis names the cause, whether it could be seen, and what it names."""
    words = [program, "diagnose", study, "--out", out, "--check-gain", "quick", "--format", "json", "--force"]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        return False, None, [f"exit code {done.returncode}: {done.stderr.strip()[:120]}"]
    diagnosis = json.loads(done.stdout)
    findings = diagnosis["findings"]
    seen = is_seen(diagnosis, cause, address, rest)
    shown = [f"{f['cause']}@{f['address']} {f['probability']:.2f}" for f in findings]
    for found in findings:
        if found["probability"] <= 0.5:
            continue
        same = [(found["cause"], found["address"])]
        same += [(found["cause"], member) for member in found.get("members", [])]
        same += [(other["cause"], other["address"]) for other in found.get("indistinguishable_from", [])]
        if (cause, address) in same:
            return True, True, shown
    return False, seen, shown


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--admire", default=os.path.join(ROOT, "target", "release", "admire"))
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first", type=int, default=1)
    options = parser.parse_args()
    counts = {}
    for seed in range(options.first, options.first + options.seeds):
        draw = random.Random(seed)
        rubber = [f"element-parameter@{address}:factor={draw.uniform(0.8, 1.25):.3f}" for address in RUBBER]
        for number, (cause, address, rest) in enumerate(causes(draw)):
            hidden = f"{cause}@{address}:{rest}"
            line = []
            with tempfile.TemporaryDirectory() as folder:
                marks = os.path.join(folder, "marks")
                with_marks(marks)
                for kind, rig in (("curves", RIG), ("marks", marks)):
                    study, out = os.path.join(folder, kind + "-study"), os.path.join(folder, kind + "-out")
                    words = [options.admire, "rig", rig, "--out", study, "--seed", str(100 * seed + number), "--tolerances", TOLERANCES]
                    for effect in [hidden, *rubber]:
                        words += ["--effect", effect]
                    subprocess.run(words, capture_output=True, check=True)
                    right, seen, shown = named(options.admire, study, out, cause, address, rest)
                    told = counts.setdefault((cause, address.split("/")[0]), {}).setdefault(kind, [0, 0, 0])
                    told[0] += right
                    told[1] += bool(seen)
                    told[2] += 1
                    word = "named" if right else "not named" if seen else "cannot be seen"
                    line.append(f"{kind}: {word} ({', '.join(shown) or 'nothing'})")
            print(f"{seed} {hidden} | {' | '.join(line)}", flush=True)
    total = {}
    for (cause, where), kinds in counts.items():
        told = (f"{kind} {right} of {seen} that can be seen, {count} planted" for kind, (right, seen, count) in kinds.items())
        print(f"{cause} at {where}: " + "; ".join(told))
        for kind, of in kinds.items():
            total[kind] = [a + b for a, b in zip(total.get(kind, [0, 0, 0]), of)]
    print("all: " + "; ".join(f"{kind} {a} of {b} that can be seen, {c} planted" for kind, (a, b, c) in total.items()))


if __name__ == "__main__":
    main()
