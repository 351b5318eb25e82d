#!/bin/bash
# Fuzzes one reader, led by the coverage of each input (libFuzzer). Needs g++ besides Rust; any toolchain serves.
#
#   tests/fuzz/guided.sh dataset                         until it finds something, or Ctrl-C
#   tests/fuzz/guided.sh dataset -max_total_time=600     options of libFuzzer
#   tests/fuzz/guided.sh all -max_total_time=60          every reader in turn
#   tests/fuzz/guided.sh                                 lists the readers
#
# Inputs are kept below target/guided/READER/inputs and go on from there the next time; what is found, below target/guided/READER/found.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=$(rustc -vV | sed -n 's/^host: //p')
work=$PWD/target/guided
mkdir -p "$work"
FUZZ_SEEDS=$work cargo test -q --test fuzz >/dev/null
(($#)) || {
    (cd "$work" && ls -d */seeds | cut -d/ -f1)
    exit 0
}
# Coverage of every edge and of comparisons, as cargo-fuzz asks for it; the readers have no unsafe code that a sanitizer could watch.
flags="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters"
flags+=" -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares"
# Programs that are built along have no fuzzer in them, and are not run.
flags+=" -Clink-arg=-Wl,--unresolved-symbols=ignore-all"
built=$(RUSTFLAGS="$flags" CARGO_TARGET_DIR=$work/build cargo build --target "$target" --bench guided --message-format=json-render-diagnostics |
    sed -n 's/.*"name":"guided".*"executable":"\([^"]*\)".*/\1/p')
readers=("$1")
shift
[ "${readers[0]}" != all ] || mapfile -t readers < <(cd "$work" && ls -d */seeds | cut -d/ -f1)
failed=0
for reader in "${readers[@]}"; do
    echo "==== $reader"
    here=$work/$reader
    mkdir -p "$here/inputs" "$here/found"
    FUZZ_READER=$reader "$built" -dict="$here/words" -max_len=24000 -timeout=20 -rss_limit_mb=4096 -artifact_prefix="$here/found/" \
        "$@" "$here/inputs" "$here/seeds" 2>&1 || failed=1
done
exit $failed
