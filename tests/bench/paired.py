"""Statics now against an earlier commit: `cargo bench --bench statics` of both in turns, ratios of times now over then.

    python3 tests/bench/paired.py [COMMIT] [--rounds 15]
    python3 tests/bench/paired.py --builds OLD NEW

The commit (bc3cee8, the last before motion was added, if none is given) is built in a git worktree below `target/paired`, which is removed
afterwards; its build is kept. `--builds` takes two executables of the bench instead. Each round starts both processes one after the other,
the order alternating; of every time the least counts, and the median of the rounds' own ratios is shown beside. Set-up is reading, compiling
and the solver; a sweep goes through all load cases.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tests/bench/peers"))

from deck import write_chain  # noqa: E402

AXLES = ("pseudo-mcpherson", "multilink")
TIMES = {"setup_s": "set-up", "first_sweep_s": "first sweep", "best_s": "sweep"}


def built(folder, target):
    """The executable of the bench of a checkout."""
    command = ["cargo", "bench", "--bench", "statics", "--no-run", "--message-format=json", "--target-dir", target]
    done = subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True)
    for line in done.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message["target"]["name"] == "statics":
            return message["executable"]
    sys.exit(f"no bench was built in {folder}")


def of_commit(commit, target):
    """The executable of the bench as a commit has it."""
    with tempfile.TemporaryDirectory(dir=target) as folder:
        tree = os.path.join(folder, "tree")
        subprocess.run(["git", "worktree", "add", "--quiet", "--detach", tree, commit], cwd=ROOT, check=True)
        try:
            return built(tree, os.path.join(target, "then"))
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", tree], cwd=ROOT, check=True)


def jobs(folder, bodies):
    """Both axles in the load cases of their studies, and a chain."""
    out = []
    for name in AXLES:
        corpus = os.path.join(ROOT, "corpus", name)
        with open(os.path.join(corpus, "load_cases.csv")) as file:
            cases = [[float(word) for word in row.split(",")[1:]] for row in file.read().splitlines()[1:]]
        loads = ["SFORCE/3", "SFORCE/2", "SFORCE/1"]
        out.append(dict(name=name, deck=os.path.join(corpus, "reference.adm"), loads=loads, cases=cases, repeats=31, last_part_only=True))
    deck = os.path.join(folder, "chain.adm")
    write_chain(deck, bodies)
    loose = dict(imbalance=1e-6 * bodies, error=1e-4)
    out.append(dict(name=f"chain of {bodies}", deck=deck, loads=["SFORCE/1"], cases=[[20.0]], repeats=5, last_part_only=True, **loose))
    return out


def times(executable, job):
    done = subprocess.run([executable, job], check=True, stdout=subprocess.PIPE, text=True)
    return {result["name"]: result for result in json.loads(done.stdout)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", nargs="?", default="bc3cee8")
    parser.add_argument("--builds", nargs=2, metavar=("OLD", "NEW"), help="two executables of the bench")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--bodies", type=int, default=1000, help="of the chain")
    arguments = parser.parse_args()
    if arguments.builds:
        builds = [os.path.abspath(path) for path in arguments.builds]
    else:
        target = os.path.join(ROOT, "target/paired")
        os.makedirs(target, exist_ok=True)
        builds = [of_commit(arguments.commit, target), built(ROOT, os.path.join(target, "now"))]
    seen = []
    with tempfile.TemporaryDirectory() as folder:
        job = os.path.join(folder, "jobs.json")
        with open(job, "w") as file:
            json.dump(jobs(folder, arguments.bodies), file)
        for number in range(arguments.rounds):
            turn = [0, 1] if number % 2 == 0 else [1, 0]
            found = {which: times(builds[which], job) for which in turn}
            seen.append((found[0], found[1]))
    print("| model | | then, ms | now, ms | now over then | median of rounds |\n|---|---|---|---|---|---|")
    for name in seen[0][0]:
        for key, what in TIMES.items():
            pairs = [(then[name][key], now[name][key]) for then, now in seen]
            then, now = (1e3 * min(column) for column in zip(*pairs))
            median = statistics.median(b / a for a, b in pairs)
            print(f"| {name} | {what} | {then:.3f} | {now:.3f} | {now / then:.3f} | {median:.3f} |")


if __name__ == "__main__":
    main()
