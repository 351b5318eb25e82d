"""The Python package beside what is inside of it, beside the command line, and beside other readers of results.

    pip install . && cargo build --release
    python tests/bench/python.py [--admire PATH] [--megabytes 500] [--variants 10000]

Prints the overhead of a small solve over the time inside of the library; the rate of reading a column of a large results file, by the
package and by `admire results`, started in turn; the rate of adamspy beside ours on a file of 50 MB, where it is installed (pyadams is
on no package index); and many variants by joblib and Dask against a serial loop, bit for bit.
"""

import argparse
import os
import statistics
import subprocess
import tempfile
import time

import admire

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
DECK = os.path.join(ROOT, "corpus", "pseudo-mcpherson", "model.adm")
COLUMN = "KNUCKLE_XFORM.X"
# Megabytes of the file that other readers are given.
OTHERS = 50.0


def overhead(deck, repeats):
    """Wall time of a call over the time that the library itself measures in it."""
    pairs = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run = deck.solve()
        pairs.append((time.perf_counter() - begin, run.seconds))
        del run
    for name, share in (("median", 0.5), ("fastest twentieth", 0.05)):
        outer, inner = (sorted(values)[int(share * repeats)] for values in zip(*pairs))
        percent = 100 * (outer / inner - 1)
        print(f"small solve, {name} of {repeats}: {1e3 * outer:.3f} ms, inside {1e3 * inner:.3f} ms, overhead {percent:.1f} percent")


def large(deck, path, megabytes):
    """A results file of this size: the steps of a run, again and again."""
    commands = "SIMULATE/STATICS, END=1, STEPS=100\n"
    deck.solve(commands).write(path, overwrite=True)
    with open(path, "rb") as file:
        text = file.read()
    first = text.index(b"<Step type=\"quasiStatic\">")
    last = text.rindex(b"</Step>") + len(b"</Step>\n")
    times = max(1, int(megabytes * 1e6 / (last - first)))
    with open(path, "wb") as file:
        file.write(text[:first])
        for _ in range(times):
            file.write(text[first:last])
        file.write(text[last:])
    return os.path.getsize(path) / 1e6


def seconds(work):
    begin = time.perf_counter()
    found = work()
    return time.perf_counter() - begin, found


def processor(work):
    """Processor time of this process and its children: what other work on the machine disturbs little."""
    before = sum(os.times()[:4])
    work()
    return sum(os.times()[:4]) - before


def reading(program, path, size, repeats):
    def by_command():
        words = [program, "results", path, "--get", COLUMN, "--plain"]
        return subprocess.run(words, check=True, capture_output=True).stdout

    def by_package():
        return admire.results(path)[COLUMN]

    by_package()
    pairs = [(seconds(by_command)[0], seconds(by_package)[0]) for _ in range(repeats)]
    command, package = (statistics.median(values) for values in zip(*pairs))
    busy = [(processor(by_command), processor(by_package)) for _ in range(repeats)]
    ratio = statistics.median(a for a, _ in busy) / statistics.median(b for _, b in busy)
    text = by_command().decode().split()
    assert [float(word) for word in text[1:]] == by_package().tolist()
    print(f"{size:.0f} MB .res, one column: command {size / command:.0f} MB/s, package {size / package:.0f} MB/s, ratio {command / package:.2f}, by processor time {ratio:.2f}")


def others(path, size):
    took, found = seconds(lambda: admire.results(path)[COLUMN])
    print(f"{size:.0f} MB .res, one column: admire {size / took:.1f} MB/s")
    try:
        from adamspy.postprocess import xml
    except ImportError:
        print("adamspy is not installed")
    else:
        took, values = seconds(lambda: xml.get_component(path, COLUMN))
        assert values == found.tolist()
        print(f"{size:.0f} MB .res, one column: adamspy {size / took:.1f} MB/s")


def variant(deck, k):
    return deck.solve({"BUSHING/1.K.1": k})["BUSHING/1.FX"].tobytes()


def variants(deck, count):
    values = [8000.0 + 0.5 * k for k in range(count)]
    took, alone = seconds(lambda: [variant(deck, k) for k in values])
    print(f"{count} variants, serial: {took:.1f} s")
    try:
        import joblib
    except ImportError:
        print("joblib is not installed")
    else:
        took, found = seconds(lambda: joblib.Parallel(n_jobs=-1)(joblib.delayed(variant)(deck, k) for k in values))
        print(f"{count} variants, joblib: {took:.1f} s, the same bits: {found == alone}")
    try:
        from dask.distributed import Client, LocalCluster
    except ImportError:
        print("dask.distributed is not installed")
    else:
        with LocalCluster(dashboard_address=None) as cluster, Client(cluster) as client:
            sent = client.scatter(deck, broadcast=True)

            def work():
                return client.gather(client.map(variant, [sent] * count, values))

            took, found = seconds(work)
            print(f"{count} variants, dask.distributed: {took:.1f} s, the same bits: {found == alone}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--admire", default=os.path.join(ROOT, "target", "release", "admire"))
    parser.add_argument("--megabytes", type=float, default=500.0)
    parser.add_argument("--variants", type=int, default=10000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    deck = admire.read(DECK)
    overhead(deck, 50 * options.repeats)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "large.res")
        size = large(deck, path, options.megabytes)
        reading(options.admire, path, size, options.repeats)
        # Others hold the whole file as a tree, many times its size.
        others(path, large(deck, path, min(options.megabytes, OTHERS)))
    variants(deck, options.variants)


if __name__ == "__main__":
    main()
