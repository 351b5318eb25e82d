#!/bin/bash
# A sweep on a real Dask LocalCluster: 8 shards, one of their processes killed, against the same sweep in one process.
#
#   tests/cluster/dask.sh [FOLDER OF admire]
#
# Needs Python with `distributed`; says SKIPPED where it is not. PYTHON names the interpreter.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
programs=$(cd "${1:-$root/target/debug}" && pwd)
python=${PYTHON:-python3}
"$python" -c 'import distributed' 2>/dev/null || {
    echo "SKIPPED: Dask: there is no package distributed for $python"
    exit 0
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$root"/corpus/pseudo-mcpherson/{model.adm,lateral.acf,sweep.toml} "$work"
sed -i "s/^cases = .*/cases = ${CASES:-6000}/" "$work/sweep.toml"
export ADMIRE=$programs/admire
"$ADMIRE" sweep "$work/sweep.toml" --out "$work/alone" --quiet >/dev/null
"$python" "$root/tests/cluster/dask_sweep.py" "$work/sweep.toml" "$work/dask" 8 &
run=$!
# The first shard that works is killed once.
for _ in $(seq 300); do
    victim=$(pgrep -f "^$ADMIRE sweep $work/sweep.toml" | head -n 1) || true
    [ -n "$victim" ] && [ -n "$(ls "$work/dask/shards" 2>/dev/null)" ] && break
    sleep 0.1
done
sleep 0.3
if [ -n "$victim" ] && kill -9 "$victim" 2>/dev/null; then
    echo "process $victim of a shard killed"
fi
wait $run
diff <(grep -v '"seconds"' "$work/alone/summary.json") <(grep -v '"seconds"' "$work/dask/summary.json")
if "$python" -c 'import pandas, pyarrow' 2>/dev/null; then
    "$python" - "$work" <<'END'
import sys
import pandas
alone, dask = (pandas.read_parquet(f"{sys.argv[1]}/{name}/results.parquet") for name in ("alone", "dask"))
assert list(alone.case) == list(range(len(alone))) and (alone.status == "ok").all()
pandas.testing.assert_frame_equal(alone.drop(columns="seconds"), dask.drop(columns="seconds"), check_exact=True)
print(f"pandas reads the same {len(alone)} rows from both")
END
fi
echo "8 shards under Dask and one process: the same answer of ${CASES:-6000} cases"
echo "passed"
