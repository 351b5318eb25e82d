"""Readers of ADAMS results that other people wrote, on files that `mdi` wrote: see README.md.

usage: check.py FOLDER STUDY [EXPECTED]

FOLDER holds run.adm and run.acf; STUDY holds the marks of the same load cases; EXPECTED is a JSON file with part poses and
bushing forces of the same equilibria.
"""

import csv
import json
import math
import os
import sys
import xml.etree.ElementTree as ElementTree

import lxml.etree
from adamspy import adamspy
from adamspy.postprocess import msg, xml

NAMESPACE = "{http://www.mscsoftware.com/:xrf10}"


def columns(parse, path):
    """All columns by 'entity.component', and the kind of each step, through an ElementTree-like parser."""
    root = parse(path).getroot()
    assert root.tag == NAMESPACE + "Results", root.tag
    ids = {}
    for entity in root.iter(NAMESPACE + "Entity"):
        for component in entity:
            ids[entity.get("name") + "." + component.get("name")] = int(component.get("id"))
    kinds, rows = [], []
    for step in root.iter(NAMESPACE + "Step"):
        kinds.append(step.get("type"))
        rows.append([float(word) for word in step.text.split()])
    assert all(len(row) == max(ids.values()) for row in rows), "steps of different lengths"
    status = root.find(f"{NAMESPACE}Analysis/{NAMESPACE}TerminationStatus")
    assert status.get("runStatus") == "Successful"
    return kinds, ids, {name: [row[i - 1] for row in rows] for name, i in ids.items()}


def rotation(psi, theta, phi):
    """Body 3-1-3, rows of the matrix."""
    (c1, s1), (c2, s2), (c3, s3) = ((math.cos(a), math.sin(a)) for a in (psi, theta, phi))
    return [
        [c1 * c3 - s1 * c2 * s3, -c1 * s3 - s1 * c2 * c3, s1 * s2],
        [s1 * c3 + c1 * c2 * s3, -s1 * s3 + c1 * c2 * c3, -c1 * s2],
        [s2 * s3, s2 * c3, c2],
    ]


def worst(pairs):
    return max(abs(a - b) for a, b in pairs)


def part(values, name, step):
    position = [values[f"{name}_XFORM.{c}"][step] for c in ("X", "Y", "Z")]
    return position, rotation(*(values[f"{name}_XFORM.{c}"][step] for c in ("PSI", "THETA", "PHI")))


def compare_with_marks(values, equilibria, study):
    """The largest distance, along one axis, between marks where the parts carry them and marks as an independent program had them."""
    with open(os.path.join(study, "marks_on_parts.csv"), newline="") as file:
        on_part = {(r["part"], r["mark"]): [float(r[c]) for c in "xyz"] for r in csv.DictReader(file)}
    with open(os.path.join(study, "load_cases.csv"), newline="") as file:
        step_of = {r["case"]: step for r, step in zip(csv.DictReader(file), equilibria)}
    pairs = []
    with open(os.path.join(study, "marks_noise_free.csv"), newline="") as file:
        for row in csv.DictReader(file):
            p, R = part(values, row["part"], step_of[row["case"]])
            local = on_part[row["part"], row["mark"]]
            for axis in range(3):
                now = p[axis] + sum(R[axis][k] * local[k] for k in range(3))
                pairs.append((now, float(row["xyz"[axis]])))
    assert len(pairs) == 13 * 20 * 3, len(pairs)
    return worst(pairs)


def compare_with_expected(values, equilibria, path):
    """Largest differences of part positions, rotation matrices and bushing forces along the global axes."""
    with open(path) as file:
        cases = json.load(file)["cases"]
    assert len(cases) == len(equilibria)
    positions, rotations, forces = [], [], []
    for case, step in zip(cases, equilibria):
        for name, expected in case["parts"].items():
            p, R = part(values, name, step)
            positions += zip(p, expected["pos"])
            for row, expected_row in zip(R, expected["A"]):
                rotations += zip(row, expected_row)
        for name, expected in case["bushings"].items():
            force = [values[f"{name}.{c}"][step] for c in ("FX", "FY", "FZ")]
            forces += zip(force, expected["F_on_I_ground"])
    return worst(positions), worst(rotations), worst(forces)


def main(folder, study, expected=None):
    process = adamspy.solve(os.path.join(folder, "run.acf"), wait=True)
    assert process.returncode == 0, process.returncode
    results, messages = os.path.join(folder, "run.res"), os.path.join(folder, "run.msg")

    kinds, ids, values = columns(ElementTree.parse, results)
    equilibria = [i for i, kind in enumerate(kinds) if kind in ("static", "quasiStatic", "equilibrium")]
    assert kinds[0] == "input" and len(equilibria) == 13, kinds
    assert columns(lxml.etree.parse, results) == (kinds, ids, values), "lxml reads otherwise than ElementTree"

    assert xml.get_stepmap_dictionary(results) == ids
    for name in ("time.TIME", "KNUCKLE_XFORM.Z", "TIE_ROD_XFORM.PSI", "A.FX", "B.TZ", "STRUT.FY"):
        assert xml.get_component(results, name) == values[name], name
    assert xml.get_results(results)["time"] == [], "adamspy.get_results has learnt to see statics: say so in README.md"

    assert msg.check_if_finished(messages)
    assert not msg.check_for_errors(messages)
    assert msg.get_errors(messages) == []
    assert int(msg.get_process_id(messages)) == process.pid
    assert not msg.uses_fortran_solver(messages)
    elapsed, cpu, load = msg.get_runtime_summary(messages)
    assert elapsed >= 0 and cpu >= 0 and load >= 0

    mark = compare_with_marks(values, equilibria, study)
    print(f"marks: {mark:.1e} mm")
    assert mark < 1e-6, mark
    if expected:
        position, matrix, force = compare_with_expected(values, equilibria, expected)
        print(f"positions: {position:.1e} mm, rotation matrices: {matrix:.1e}, bushing forces: {force:.1e} N")
        assert position < 1e-6 and matrix < 1e-8 and force < 1e-3
    print(f"{len(ids)} columns of {len(equilibria)} equilibria: adamspy, lxml and ElementTree agree")


if __name__ == "__main__":
    main(*sys.argv[1:])
