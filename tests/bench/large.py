"""Memory and processor time of the commands on a deck of about 1 GB, and of 10,000 load cases on another one.

    cargo build --release && python3 tests/bench/large.py [--megabytes 1000] [--cases 10000] [--only get,check,set,solve]

`get`, `check` and `set` read the deck of `cargo bench --bench decks`, which is nothing but parts on bushings: all of it are equations.
`solve` runs the pseudo McPherson, filled up to the size with what such decks hold besides: markers, graphics and splines that
nothing refers to; then `mdi` sweeps so many load cases on it. Files are made below target/large and removed at the end.
"""

import argparse
import os
import shutil
import subprocess
import time

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PROGRAMS = os.path.join(ROOT, "target", "release")


def measured(what, command, folder):
    """Prints what a process took; its exit code must be 0."""
    print(f"{what:34}", end="", flush=True)
    begin = time.perf_counter()
    with open(os.path.join(folder, "said.txt"), "wb") as said:
        child = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0, (command, child.returncode, open(os.path.join(folder, "said.txt")).read()[-2000:])
    wall, busy = time.perf_counter() - begin, used.ru_utime + used.ru_stime
    print(f"{used.ru_maxrss * 1024 / 1e9:6.2f} GB at most, {busy:7.1f} s of processor, {wall:7.1f} s by the clock")


def filler(number):
    """Statements that no equation holds."""
    x, marker = (number * 0.37) % 1000, 1_000_000 + 10 * number
    markers = "".join(
        f"!                             adams_view_name='outline_{number}_{k}'\nMARKER/{marker + k}\n, PART = 1\n"
        f", QP = {x:.9f}, {x / 7:.9f}, {k * 12.5}\n, REULER = {x / 3:.6f}D, 0D, 90D\n"
        for k in range(4)
    )
    outline = ", ".join(str(marker + k) for k in range(4))
    abscissae = "".join(f", {k * 0.25:.6f}\n" for k in range(40))
    ordinates = "".join(f", {k * k * 0.37 + x:.6f}\n" for k in range(40))
    return (
        f"{markers}GRAPHICS/{1000 + number}\n, OUTLINE = {outline}\n!\n"
        f"SPLINE/{1000 + number}\n, X = -1\n{abscissae}, Y = 0\n{ordinates}!\n"
    )


def filled(path, size):
    """The pseudo McPherson with as much beside it as makes up the size."""
    with open(os.path.join(ROOT, "corpus/pseudo-mcpherson/reference.adm")) as file:
        deck = file.read()
    at = deck.rindex("ACCGRAV/")
    with open(path, "w") as file:
        file.write(deck[:at])
        number = 0
        while file.tell() < size:
            file.write("".join(filler(k) for k in range(number, number + 1000)))
            number += 1000
        file.write(deck[at:])


def load_cases(path, count):
    with open(path, "w") as file:
        file.write("\nfile/model=filled\n")
        for case in range(count):
            file.write(f"SFORCE/3, FUNCTION = {1500 + case % 97 * 30}\nSFORCE/2, FUNCTION = {case % 89 * 20 - 800}\nSIMULATE/STATIC\n")
        file.write("STOP\n")


def shown(path):
    return f"{os.path.basename(path)}, {os.path.getsize(path) / 1e9:.2f} GB"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--megabytes", type=int, default=1000)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--only", default="get,check,set,solve")
    options = parser.parse_args()
    wanted = options.only.split(",")
    admire, mdi = (os.path.join(PROGRAMS, name) for name in ("admire", "mdi"))
    folder = os.path.join(ROOT, "target", "large")
    os.makedirs(folder, exist_ok=True)
    try:
        if {"get", "check", "set"} & set(wanted):
            deck = os.path.join(folder, "parts.adm")
            bench = ["cargo", "bench", "-q", "--bench", "decks", "--", str(options.megabytes), "--write", deck]
            subprocess.run(bench, cwd=ROOT, check=True)
            print(shown(deck))
            if "get" in wanted:
                measured("  get BUSHING/1000.K.1", [admire, "get", deck, "BUSHING/1000.K.1"], folder)
            if "check" in wanted:
                measured("  check", [admire, "check", "--quiet", deck], folder)
            if "set" in wanted:
                new = os.path.join(folder, "new.adm")
                measured("  set BUSHING/1000.K.1=1.5E+04 -o", [admire, "set", deck, "BUSHING/1000.K.1=1.5E+04", "-o", new], folder)
                compared = subprocess.run(["cmp", "-l", deck, new], capture_output=True, text=True)
                changed = compared.stdout.count("\n")
                print(f"  {changed} bytes differ, sizes by {os.path.getsize(new) - os.path.getsize(deck)}")
                assert 0 < changed < 10, compared
                os.remove(new)
            os.remove(deck)
        if "solve" in wanted:
            deck = os.path.join(folder, "filled.adm")
            filled(deck, options.megabytes << 20)
            print(shown(deck))
            measured("  solve", [admire, "solve", deck], folder)
            for cases in (min(100, options.cases), options.cases):
                load_cases(os.path.join(folder, "run.acf"), cases)
                measured(f"  mdi, {cases} load cases", [mdi, "-c", "ru-standard", "i", "run.acf", "exit"], folder)
                results = os.path.join(folder, "filled.res")
                with open(results, "rb") as file:
                    steps = sum(line.count(b'"static">') for line in file)
                print(f"  {shown(results)}, {steps} steps")
                assert steps == cases, steps
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
