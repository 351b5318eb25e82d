"""Diagnoses studies and compares what is said with the truth: `python judge.py DIR --admire target/release/admire`.

Runs `admire diagnose` on every folder of DIR that has a NAME.truth.json beside it, unless its diagnosis is already there (--again), and
prints by kind: verdicts, causes named with their place, false names, intervals that hold the truth; then how often stated
probabilities come true.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

OF_MARKS = {"mark-outlier", "mark-place"}  # what marks tell by themselves
NOT_A_NAME = {"noise-level"}  # of the noise, which is no cause of an error
BINS = [(0.0, 0.02), (0.02, 0.1), (0.1, 0.3), (0.3, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 0.99), (0.99, 1.0001)]
EFFECTS = [(0, 0.05), (0.05, 0.2), (0.2, 0.5), (0.5, 1), (1, 2), (2, 1e9)]


def diagnose(study, out, options):
    """The diagnosis, its seconds and its exit code."""
    path = os.path.join(out, "diagnosis.json")
    clock = os.path.join(out, "seconds")
    if options.again or not os.path.exists(path):
        os.makedirs(out, exist_ok=True)
        begin = time.time()
        try:
            run = subprocess.run([options.admire, "diagnose", study, "--out", out], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                 timeout=options.timeout, env=os.environ | {"RAYON_NUM_THREADS": "1"})
        except subprocess.TimeoutExpired:
            return None, options.timeout, "timeout"
        if not os.path.exists(path):
            return None, time.time() - begin, run.stderr.strip().split("\n")[0]
        with open(clock, "w") as file:
            file.write(str(time.time() - begin))
    with open(path) as file, open(clock) as seconds:
        return json.load(file), float(seconds.read()), ""


def same(named, planted):
    """Whether a finding (cause, address and the other addresses of the same thing) is a planted cause."""
    if named["cause"] != planted["cause"]:
        return False
    if "form" in planted and named.get("form", planted["form"]) != planted["form"]:
        return False
    words = {w.replace(" ", "").upper() for w in [named["address"], *named.get("members", [])]}
    return any(a.replace(" ", "").upper() in words for a in planted["addresses"])


def beside_limit(planted, said):
    """How large a planted cause is beside the limit that the diagnosis prints for it, above which it is named with more than even odds;
    None where no limit is printed. Along the axes of a point ratios add up as squares."""
    words = {a.replace(" ", "").upper() for a in planted["addresses"]}
    is_at = lambda limit: any(a.replace(" ", "").upper() in words for a in [limit["address"], *limit.get("members", [])])
    if planted["cause"] == "hardpoint-error":
        limits = [limit["mm"] for limit in said.get("detection_limits", []) if is_at(limit)]
        return max((math.hypot(*(s / m for s, m in zip(planted["shift_mm"], mm) if m)) for mm in limits), default=None)
    sizes = {"force": planted.get("force"), "cubic": planted.get("cubic"), "play": planted.get("play")}
    if "stiffness" in planted:
        sizes["compliance"] = 1 / planted["stiffness"]
    for number, factor in (("gain", "gain"), ("change", "factor")):
        if factor in planted:
            sizes[number] = abs(planted[factor] - 1)
    if planted["cause"] == "load-point-error":
        sizes |= dict(zip("xyz", planted["shift_mm"]))
    limits = [limit for limit in said.get("cause_limits", []) if limit["cause"] == planted["cause"] and is_at(limit) and sizes.get(limit["number"])]
    return math.hypot(*(sizes[limit["number"]] / limit["size"] for limit in limits if limit["size"])) if limits else None


def judged(truth, said, seconds):
    """One line of the tables, as data."""
    planted = [c for c in truth["causes"] if c["cause"] not in OF_MARKS]
    wrong_marks = [c for c in truth["causes"] if c["cause"] in OF_MARKS]
    findings = [f for f in said["findings"] if f["cause"] not in NOT_A_NAME]
    names = [f for f in findings if f["cause"] not in OF_MARKS]
    listed = [f for f in findings if f["cause"] in OF_MARKS]
    hits = [any(same(f, c) for f in names) for c in planted]
    rivals = [any(same(f, c) or any(same(r, c) for r in f.get("indistinguishable_from", [])) for f in names) for c in planted]
    missed = [c for c, hit, rival in zip(planted, hits, rivals) if not (hit or rival)]
    beside = [(f"{c['cause']} {c['addresses'][0]}", beside_limit(c, said)) for c in missed]
    right = lambda f: any(same(f, c) or any(same(r, c) for r in f.get("indistinguishable_from", [])) for c in planted)
    groups = [(f["group_probability"], right(f)) for f in names if f.get("group_probability") is not None]
    false = [f for f in names if not f.get("minor") and not right(f)]
    statements = [(f["probability"], any(same(f, c) for c in planted)) for f in names if f.get("probability") is not None]
    for f in names:
        statements += [(r["probability"], any(same(r, c) for c in planted)) for r in f.get("indistinguishable_from", []) if r.get("probability") is not None]
    blind = [dict(zip(("cause", "address"), c.split(" ", 1))) for c in (said.get("hold_out") or {}).get("causes", [])]
    members = {(f["cause"], f["address"]): f.get("members", []) for f in names}
    blind = [f | {"members": members.get((f["cause"], f["address"]), [])} for f in blind]
    none = [(said["none_of_these"], not planted)] if said.get("none_of_these") is not None else []
    covered, widths, ratios, identified = [], [], [], 0
    for p in said.get("parameters", []):
        value = truth["stiffness"].get(p["address"])
        if value is None:
            continue
        low, high = p.get("interval95") or (None, None)
        covered.append((low is None or low <= value) and (high is None or value <= high))
        if p.get("status") == "identified" and low is not None and high is not None:
            identified += 1
            widths.append((high - low) / abs(p["value"]))
            least = truth.get("least_sd_of_ln", {}).get(p["address"])
            if least:
                ratios.append((high - low) / (2 * 1.96 * least * abs(p["value"])))
    return dict(verdict=said["verdict"], planted=len(planted), hits=sum(hits), with_rivals=sum(rivals), missed=beside, groups=groups, false=false, wrong_marks=len(wrong_marks),
                listed=sum(any(same(f, c) for f in listed) for c in wrong_marks), invented=sum(not any(same(f, c) for c in wrong_marks) for f in listed),
                statements=statements, none=none, blind=len(blind),
                blind_hits=sum(any(same(f, c) for f in blind) for c in planted), blind_false=sum(not any(same(f, c) for c in planted) for f in blind), effect=truth.get("effect_shift_mm_rms", 0.0) / (truth.get("sigma_mm") or 1.0), covered=covered, widths=widths, ratios=ratios, identified=identified, seconds=seconds,
                first=bool(planted) and bool(names) and any(same(names[0], c) for c in planted))


def percent(part, whole):
    return f"{100 * part / whole:.0f} %" if whole else ""


def reliability(statements, what):
    """How often stated probabilities come true, a table."""
    if not statements:
        return ["", f"No probabilities are stated of {what}."]
    out = ["", "| stated probability | times | mean stated | came true |", "|---|---|---|---|"]
    for low, high in BINS:
        group = [(p, t) for p, t in statements if low <= p < high]
        if group:
            out.append(f"| {low:g} to {min(high, 1):g} | {len(group)} | {sum(p for p, _ in group) / len(group):.2f} | {sum(t for _, t in group) / len(group):.2f} |")
    return [*out, "", f"Brier score {sum((p - t) ** 2 for p, t in statements) / len(statements):.4f} over {len(statements)} statements of {what}."]


def tables(lines, failed):
    by = {}
    for study, line in lines:
        by.setdefault((study["kind"], study["axle"]), []).append(line)
    out = ["| study | axle | n | verdict | planted named with place | or as a rival | studies with a false name | outliers listed, invented | "
           "95 % intervals hold | identified, median width | over the least width | s, median |", "|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for (kind, axle), group in by.items():
        verdicts = {}
        for line in group:
            verdicts[line["verdict"]] = verdicts.get(line["verdict"], 0) + 1
        total = lambda key: sum(line[key] for line in group)
        covered = [c for line in group for c in line["covered"]]
        widths = [w for line in group for w in line["widths"]]
        planted, wrong = total("planted"), total("wrong_marks")
        names = sorted({f["cause"] for line in group for f in line["false"]})
        false = sum(bool(line["false"]) for line in group)
        said = ", ".join(f"{v} {n}" for v, n in sorted(verdicts.items()))
        hit, rival = (f"{total(key)} of {planted}" if planted else "" for key in ("hits", "with_rivals"))
        named = f"{false} ({', '.join(names)})" if names else f"{false}"
        marks = f"{total('listed')} of {wrong}, {total('invented')}" if wrong or total("invented") else ""
        width = f", {statistics.median(widths):.2f}" if widths else ""
        numbers = f"{total('identified') / len(group):.1f} of {len(covered) / len(group):.0f}{width}"
        ratios = [r for line in group for r in line["ratios"]]
        least = f"{statistics.median(ratios):.2f}" if ratios else ""
        seconds = statistics.median(line["seconds"] for line in group)
        out.append(f"| {kind} | {axle} | {len(group)} | {said} | {hit} | {rival} | {named} | {marks} | {percent(sum(covered), len(covered))} | {numbers} | {least} | {seconds:.1f} |")
    every = [line for _, line in lines]
    planted, covered = sum(line["planted"] for line in every), [c for line in every for c in line["covered"]]
    if every:
        out += ["", f"{len(every)} studies: {percent(sum(line['hits'] for line in every), planted)} of {planted} planted causes named with place; a false name in "
                    f"{percent(sum(bool(line['false']) for line in every), len(every))} of the studies; 95 % intervals hold in {percent(sum(covered), len(covered))}."]
        missed = [(study, name, ratio) for study, line in lines for name, ratio in line["missed"]]
        if missed:
            below = [m for m in missed if m[2] is not None and m[2] < 1]
            named, rival = sum(line["hits"] for line in every), sum(line["with_rivals"] for line in every)
            out.append(f"{named} are named, {rival - named} are a rival of what is named, {len(below)} lie below the limit that the diagnosis prints for them.")
            out += [f"- missed: {name} of {study['kind']}-{study['axle']}-{study['seed']}, " + (f"{ratio:.2f} of its limit" if ratio else "no limit printed")
                    for study, name, ratio in missed if ratio is None or ratio >= 1]
        if any(line["blind"] for line in every):
            searched = [line for line in every if line["blind"]]
            out.append(f"The searches without the cases held out chose {sum(line['blind'] for line in searched)} causes in {len(searched)} studies: "
                       f"{sum(line['blind_hits'] for line in searched)} of the {sum(line['planted'] for line in searched)} planted there, and "
                       f"{sum(line['blind_false'] for line in searched)} others.")
    out += reliability([s for line in every for s in line["statements"]], "causes with their places, of rivals too")
    out += reliability([s for line in every for s in line["groups"]], "a cause or one of its rivals")
    none = [(line, *s) for line in every for s in line["none"]]
    if none:
        out += ["", "| what is planted moves the marks by, sigma rms | studies | named with place | mean probability that no cause acts |", "|---|---|---|---|"]
        groups = [("nothing planted", [g for g in none if g[2]])]
        for low, high in EFFECTS:
            groups.append((f"{low:g} to {high:g}" if high < 1e9 else f"beyond {low:g}", [g for g in none if not g[2] and low <= g[0]["effect"] < high]))
        for name, group in groups:
            if group:
                named = sum(g[0]["hits"] for g in group) if name != "nothing planted" else ""
                out.append(f"| {name} | {len(group)} | {named} | {sum(g[1] for g in group) / len(group):.2f} |")
    if failed:
        out += ["", f"{len(failed)} studies without a diagnosis:"] + [f"- {name}: {why}" for name, why in failed]
    return "\n".join(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("studies")
    parser.add_argument("--admire", default="target/release/admire")
    parser.add_argument("--out", help="where diagnoses are kept; STUDIES.diagnosed if not given")
    parser.add_argument("--only", default="", help="part of the names to be judged")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--timeout", type=float, default=600)
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--show", action="store_true", help="a line for each study")
    parser.add_argument("--json", help="also write what was judged to this file")
    options = parser.parse_args()
    kept = options.out or options.studies.rstrip("/") + ".diagnosed"
    suffix = ".truth.json"
    names = sorted(f[: -len(suffix)] for f in os.listdir(options.studies) if f.endswith(suffix) and options.only in f)
    if not names:
        parser.error(f"no studies with their truth in {options.studies}")

    def one(name):
        with open(os.path.join(options.studies, name + suffix)) as file:
            truth = json.load(file)
        truth.setdefault("kind", name.rsplit("-", 1)[0])
        truth.setdefault("axle", "")
        said, seconds, why = diagnose(os.path.join(options.studies, name), os.path.join(kept, name), options)
        return name, truth, said and judged(truth, said, seconds), said, why

    lines, failed = [], []
    with ThreadPoolExecutor(options.jobs) as pool:
        for name, truth, line, said, why in pool.map(one, names):
            if line is None:
                failed.append((name, why))
                continue
            lines.append((truth, line))
            if options.show:
                found = "; ".join(f"{f['cause']} {f['address']}" + (f" {f['probability']:.2f}" if f.get("probability") is not None else "")
                                  for f in said["findings"][:6])
                print(f"{name}: {line['verdict']}; planted {line['hits']} of {line['planted']}; {found or 'nothing found'}", flush=True)
    print(tables(lines, failed))
    if options.json:
        with open(options.json, "w") as file:
            json.dump([dict(kind=t["kind"], axle=t["axle"], **line) for t, line in lines], file, indent=1)
    return 0


if __name__ == "__main__":
    sys.exit(main())
