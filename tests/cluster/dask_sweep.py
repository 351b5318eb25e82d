"""A sweep under Dask: every shard is a call of the command, the last call joins them.

    python dask_sweep.py SWEEP.toml DIR SHARDS [ADDRESS OF A SCHEDULER]

Without an address a LocalCluster is started on this machine. A worker that dies takes nothing with it: Dask calls the shard again, and it goes
on from its journal. The program is that of the environment variable ADMIRE. Without it the Python package `admire` works in the process of
the worker, and where that is not installed the program is `admire` on the PATH.
"""

import os
import subprocess
import sys

from dask.distributed import Client, LocalCluster, as_completed


def package():
    """The Python package, or None."""
    if "ADMIRE" in os.environ:
        return None
    try:
        import admire
    except ImportError:
        return None
    return admire


def run_shard(plan, out, shard, shards):
    """Runs one shard to its end; gives its number."""
    admire = package()
    if admire is not None:
        admire.sweep(plan, out, shard=(shard, shards), jobs=1)
        return shard
    program = os.environ.get("ADMIRE", "admire")
    words = [program, "sweep", plan, "--out", out, "--shard", f"{shard}/{shards}", "--jobs", "1", "--quiet"]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"shard {shard}/{shards} ended with {done.returncode}: {done.stderr}")
    return shard


def join(out):
    """Joins all shards; the exit code."""
    admire = package()
    if admire is not None:
        print(admire.merge(out))
        return 0
    return subprocess.run([os.environ.get("ADMIRE", "admire"), "merge", out]).returncode


def main(plan, out, shards, address=None):
    """Runs all shards and joins them."""
    cluster = None
    if address is None:
        cluster = LocalCluster(n_workers=os.cpu_count(), threads_per_worker=1, dashboard_address=None)
    with Client(address or cluster) as client:
        numbers = range(1, shards + 1)
        futures = [client.submit(run_shard, plan, out, k, shards, pure=False, retries=2) for k in numbers]
        for future in as_completed(futures):
            print(f"shard {future.result()} of {shards} is finished", flush=True)
    if cluster is not None:
        cluster.close()
    return join(out)


if __name__ == "__main__":
    plan, out, shards = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), int(sys.argv[3])
    sys.exit(main(plan, out, shards, *sys.argv[4:5]))
