#!/bin/bash
# A sweep on a real SLURM: controller, node daemon and munge on this machine's loopback, an array of 8 shards with one task killed and
# requeued, and the job that joins them. Then a script in the style of aview_hpc that calls `mdi`.
#
#   tests/cluster/slurm.sh [FOLDER OF admire AND mdi]
#
# Needs root and Debian's packages slurm-wlm and munge; says SKIPPED where they cannot start. Stops what it started.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
programs=$(cd "${1:-$root/target/debug}" && pwd)

skip() {
    echo "SKIPPED: SLURM: $*"
    exit 0
}
[ "$(id -u)" = 0 ] || skip "its daemons are started by root"
for program in slurmctld slurmd sbatch munged; do
    command -v $program >/dev/null || skip "there is no $program here"
done
[ -x "$programs/admire" ] && [ -x "$programs/mdi" ] || {
    echo "there is no admire and mdi in $programs"
    exit 1
}

work=$(mktemp -d)
pids=()
stop() {
    code=$?
    [ $code = 0 ] || tail -n 20 "$work"/*.log || true
    # Children first: tasks of jobs end with the node daemon's word.
    scancel --user root >/dev/null 2>&1 || true
    for pid in "${pids[@]}"; do
        kill "$pid" 2>/dev/null || true
    done
    wait 2>/dev/null || true
    rm -rf "$work"
    exit $code
}
trap stop EXIT

host=$(hostname -s)
export SLURM_CONF=$work/slurm.conf
cpus=$(nproc)
dd if=/dev/urandom of="$work/munge.key" bs=1024 count=1 status=none
chmod 400 "$work/munge.key"
mkdir "$work/state" "$work/spool"
cat >"$SLURM_CONF" <<END
ClusterName=loopback
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmctldPort=16817
SlurmdPort=16818
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
SchedulerParameters=sched_interval=2
JobRequeue=1
KillWait=2
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
munged --foreground --force --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munged.pid" \
    --log-file="$work/munged.log" --seed-file="$work/munge.seed" >"$work/munged.out.log" 2>&1 &
pids+=($!)
slurmctld -D -c >"$work/slurmctld.out.log" 2>&1 &
pids+=($!)
for _ in $(seq 30); do
    [ -S "$work/munge.socket" ] && break
    sleep 0.2
done
slurmd -D -N "$host" >"$work/slurmd.out.log" 2>&1 &
pids+=($!)
for _ in $(seq 60); do
    sinfo -h -o %T 2>/dev/null | grep -q idle && break
    sleep 1
done
sinfo -h -o %T 2>/dev/null | grep -q idle || {
    tail -n 5 "$work"/*.log
    trap - EXIT
    for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
    rm -rf "$work"
    skip "the node does not come up"
}
echo "SLURM $(sinfo --version | cut -d' ' -f2): one node, $cpus cores"

# The sweep without SLURM, and with it.
cp "$root"/corpus/pseudo-mcpherson/{model.adm,lateral.acf,sweep.toml} "$work"
sed -i "s/^cases = .*/cases = ${CASES:-6000}/" "$work/sweep.toml"
"$programs/admire" sweep "$work/sweep.toml" --out "$work/alone" --quiet >/dev/null
merge=$("$programs/admire" sweep "$work/sweep.toml" --out "$work/array" --slurm --shards 8 --sbatch=--ntasks=1)
array=$((merge - 1))
for _ in $(seq 200); do
    task=$(squeue -h -r -t RUNNING -o %i | grep "^${array}_" | head -n 1) || true
    [ -n "$task" ] && break
    sleep 0.1
done
[ -n "$task" ] || {
    echo "no task of the array was seen running"
    exit 1
}
sleep 0.5
journal=$work/array/shards/$(printf '%04d' "${task#*_}")-of-0008.journal
before=$(stat -c %s "$journal" 2>/dev/null || echo 0)
scontrol requeue "$task"
echo "task $task killed and requeued; its journal had $before bytes"
for _ in $(seq 600); do
    state=$(squeue -h -j "$merge" -o %T 2>/dev/null || true)
    [ -z "$state" ] && break
    # A job that waits for a task that failed waits for ever.
    reason=$(squeue -h -j "$merge" -o %r 2>/dev/null || true)
    [ "$reason" != DependencyNeverSatisfied ] || {
        tail -n 5 "$work"/array/slurm/*.log
        exit 1
    }
    sleep 1
done
[ -f "$work/array/results.parquet" ] || {
    tail -n 5 "$work"/array/slurm/*.log
    exit 1
}
grep -h "finished by an earlier run" "$work/array/slurm/shard-${task#*_}.log" || echo "(the task had finished no case when it was killed)"
# Every quantile, mean and count to the last bit; only times differ.
diff <(grep -v '"seconds"' "$work/alone/summary.json") <(grep -v '"seconds"' "$work/array/summary.json")
echo "array of 8 and one process: the same answer of ${CASES:-6000} cases"

# A batch script that knows nothing of admire: only PATH is changed.
mkdir "$work/hpc"
cp "$root"/corpus/pseudo-mcpherson/{model.adm,lateral.acf} "$work/hpc"
cat >"$work/hpc/run.sh" <<'END'
#!/bin/bash
#SBATCH --job-name=lateral
#SBATCH --ntasks=1
cd "$SLURM_SUBMIT_DIR"
mdi -c ru-s i lateral.acf exit
END
(cd "$work/hpc" && PATH=$programs:$PATH sbatch --wait --output=run.log run.sh)
grep -q 'runStatus="Successful"' "$work/hpc/model.res"
echo "a batch script that calls mdi -c ru-s i lateral.acf exit: results are there"
echo "passed"
