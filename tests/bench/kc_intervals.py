"""Stiffnesses from the curves of a K&C rig alone: how many 95 percent intervals hold the truth, over seeds.

    cargo build --release
    python tests/bench/kc_intervals.py [--admire PATH] [--seeds 100] [--scale 0.25 [--stated]]

Every stiffness is drawn from the prior that the study states (its deck's value, half an e-fold), hardpoints, loads, assembly, axes and
preload with the sizes that an identification takes for usual, times `--scale`. With `--stated` the study says these sizes, as far as a
study can: without it the identification has to guess them. Each seed is a rig of its own.
"""

import argparse
import json
import math
import os
import random
import subprocess
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
RIG = os.path.join(ROOT, "corpus", "rigs", "kc-curves")
TOLERANCES = {
    "hardpoints": 0.2,
    "load_gain": 0.003,
    "load_direction_deg": 0.057,
    "assembly_offset": 0.05,
    "bushing_axis_deg": 0.1,
    "preload": 0.003,
}
# Those of `[tolerances]`.
STATED = ("hardpoints", "load_gain", "load_direction_deg")
SPREAD = 0.5
SOUGHT = ["BUSHING/1", "BUSHING/2"]


def answer(program, *words):
    """What a command prints as JSON."""
    done = subprocess.run([program, *words, "--format", "json"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--admire", default=os.path.join(ROOT, "target", "release", "admire"))
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--stated", action="store_true")
    options = parser.parse_args()
    sizes = {name: size * options.scale for name, size in TOLERANCES.items()}
    tolerances = ",".join(f"{name}={size:g}" for name, size in sizes.items())
    deck = os.path.join(RIG, "model.adm")
    nominal = {}
    for bushing in SOUGHT:
        for name in ("K", "KT"):
            values = answer(options.admire, "get", deck, f"{bushing}.{name}")[f"{bushing}.{name}"]
            nominal.update({f"{bushing}.{name}.{k + 1}": value for k, value in enumerate(values)})
    held = {"all": [0, 0], "known to 20 percent": [0, 0]}
    for seed in range(1, options.seeds + 1):
        draw = random.Random(seed)
        truth = {address: value * math.exp(draw.gauss(0.0, SPREAD)) for address, value in nominal.items()}
        effects = []
        for address, value in truth.items():
            effects += ["--effect", f"element-parameter@{address}:factor={value / nominal[address]}"]
        with tempfile.TemporaryDirectory() as folder:
            study, out = os.path.join(folder, "study"), os.path.join(folder, "out")
            words = ["rig", RIG, "--out", study, "--seed", str(seed), "--tolerances", tolerances, *effects]
            subprocess.run([options.admire, *words], capture_output=True, check=True)
            if options.stated:
                with open(os.path.join(study, "study.toml"), "a") as text:
                    text.write("\n[tolerances]\n" + "".join(f"{name} = {sizes[name]:g}\n" for name in STATED))
            found = answer(options.admire, "identify", study, "--out", out)
        for parameter in found["parameters"]:
            low, high = parameter["interval95"]
            value = truth[parameter["address"]]
            inside = (low is None or low <= value) and (high is None or value <= high)
            kinds = ["all"]
            if parameter["std_error"] and parameter["std_error"] < 0.2 * parameter["value"]:
                kinds.append("known to 20 percent")
            for kind in kinds:
                held[kind][0] += inside
                held[kind][1] += 1
    for kind, (inside, count) in held.items():
        print(f"{kind}: {inside} of {count} intervals hold the truth, {100 * inside / max(count, 1):.1f} %")


if __name__ == "__main__":
    main()
