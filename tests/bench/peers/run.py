"""Static equilibria by admire and by Exudyn: the same decks, states compared, times side by side. See README.md."""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import deck
from exudyn_model import Model

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
LOADS = ["SFORCE/3", "SFORCE/2", "SFORCE/1"]
COLUMNS = ["vertical", "lateral", "longitudinal"]
IMBALANCE = 1e-5  # newton and newton.mm: the largest residual on our side, its norm on Exudyn's
CHAIN_IMBALANCE = 1e-6  # per body: far from the origin of ground, round-off alone leaves that much
SAME = 1e-6  # mm


def jobs(folder, bodies, repeats):
    """What is solved: name, deck, loads, cases, and whether Exudyn's own bushing law is that of ADAMS there."""
    found = []
    for axle, own_law in (("pseudo-mcpherson", False), ("multilink", False)):
        corpus = os.path.join(ROOT, "corpus", axle)
        path = os.path.join(corpus, "reference.adm")
        name = axle
        if axle == "multilink":
            path, name = os.path.join(folder, "multilink.adm"), "multilink, K equal"
            deck.write_with_equal_stiffnesses(os.path.join(corpus, "reference.adm"), path)
        with open(os.path.join(corpus, "load_cases.csv"), newline="") as file:
            cases = [[float(row[c]) for c in COLUMNS] for row in csv.DictReader(file)]
        found.append(dict(name=name, deck=path, loads=LOADS, cases=cases, repeats=repeats, own_law=own_law))
    for n in bodies:
        path = os.path.join(folder, f"chain-{n}.adm")
        deck.write_chain(path, n)
        few = max(3, min(repeats, 20000 // n))
        found.append(dict(name=f"chain of {n}", deck=path, loads=["SFORCE/1"], cases=[[20.0]], repeats=few, own_law=True))
        found[-1]["imbalance"] = max(IMBALANCE, CHAIN_IMBALANCE * n)
    for job in found:
        job.setdefault("imbalance", IMBALANCE)
        job["error"] = 1e-4
    return found


def ours(found, folder, statics):
    """Results of tests/bench/statics.rs for all jobs, in one process."""
    path = os.path.join(folder, "jobs.json")
    with open(path, "w") as file:
        json.dump(found, file)
    command = [statics, path] if statics else ["cargo", "bench", "-q", "--bench", "statics", "--", path]
    output = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)
    return json.loads(output.stdout)


def theirs(job):
    """States under the BUSHING law, times under Exudyn's own law."""
    law = Model(job["deck"], adams_law=not job["own_law"])
    _, iterations, parts = law.sweep(job["loads"], job["cases"], job["imbalance"], keep=True)
    begin = time.perf_counter()
    model = law if job["own_law"] else Model(job["deck"])
    setup = time.perf_counter() - begin if model is not law else law.setup_s
    _, iterations, own_parts = model.sweep(job["loads"], job["cases"], job["imbalance"], keep=True)
    seconds = [model.sweep(job["loads"], job["cases"], job["imbalance"])[0] for _ in range(job["repeats"])]
    return dict(setup_s=setup, sweep_s=statistics.median(seconds), best_s=min(seconds), iterations=iterations, parts=parts, own_parts=own_parts)


def difference(a, b):
    """Largest difference of a part position in millimetres, and of an entry of a rotation matrix."""
    position = rotation = 0.0
    for case_a, case_b in zip(a, b):
        for part, there in case_b.items():
            apart = np.abs(np.array(case_a[part]) - np.array(there))
            position, rotation = max(position, apart[:3].max()), max(rotation, apart[3:].max())
    return position, rotation


def milliseconds(seconds):
    return f"{seconds * 1e3:.3g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", default="10,100,1000,10000", help="lengths of the chains")
    parser.add_argument("--repeats", type=int, default=21)
    parser.add_argument("--statics", help="the compiled bench, where cargo is not to build it")
    parser.add_argument("--json", help="also write the numbers to this file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = jobs(folder, [int(n) for n in options.bodies.split(",") if n], options.repeats)
        mine = ours(found, folder, options.statics)
        rows, failed = [], False
        print(f"{'model':20} {'apart mm':>9} {'own law':>9} {'admire ms':>10} {'Exudyn ms':>10} {'ratio':>7} {'of best':>7} {'iterations':>11} "
              f"{'per iteration':>13} {'set-up ms':>15}")
        for job, a in zip(found, mine):
            b = theirs(job)
            apart, turned = difference(a["parts"], b["parts"])
            own, _ = difference(a["parts"], b["own_parts"])
            n_a, n_b = sum(a["iterations"]), sum(b["iterations"])
            ratio = b["sweep_s"] / a["sweep_s"]
            best = b["best_s"] / a["best_s"]
            per_iteration = ratio * n_a / n_b
            wrong = apart > SAME or turned > 1e-8
            failed |= wrong
            print(f"{job['name']:20} {apart:9.1e} {own:9.1e} {milliseconds(a['sweep_s']):>10} {milliseconds(b['sweep_s']):>10} "
                  f"{ratio:7.1f} {best:7.1f} {n_a:>5}/{n_b:<5} {per_iteration:13.1f} {milliseconds(a['setup_s']):>7}/{milliseconds(b['setup_s']):<7}"
                  f"{'  STATES DIFFER' if wrong else ''}", flush=True)
            rows.append(dict(model=job["name"], apart_mm=apart, own_law_apart_mm=own, admire_s=a["sweep_s"], exudyn_s=b["sweep_s"],
                             ratio=ratio, ratio_of_best=best, admire_iterations=n_a, exudyn_iterations=n_b, ratio_per_iteration=per_iteration))
    if options.json:
        with open(options.json, "w") as file:
            json.dump(rows, file, indent=1)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
