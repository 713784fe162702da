#!/bin/sh
# Long fuzzing: fuzz/run.sh SECONDS [TARGET…] runs each target [all] for SECONDS, one after the other.
# Uses libFuzzer if a nightly toolchain is installed (NIGHTLY=nightly-2026-01-01 chooses one), else the
# seeded loop. RUNS=N ends a target after N executions, SEED=N starts from another seed, KEEP=1 adds the inputs that
# libFuzzer kept to the corpus. Prints a table at the end; exit 1 if a target failed (fuzz/findings/TARGET).
set -eu
[ $# -gt 0 ] || { sed -n '2,5s/^# //p' "$0"; exit 2; }
seconds=$1
shift
here=$(cd "$(dirname "$0")" && pwd)
nightly=${NIGHTLY:-nightly}
seed=${SEED:-1}
# All inputs of a target's corpus together, bytes.
most_corpus=8000

cargo build -q --manifest-path "$here/Cargo.toml" --profile fuzz
built=$(cargo metadata --manifest-path "$here/Cargo.toml" --format-version 1 --no-deps |
    sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
fuzz=$built/fuzz/trueaxis-fuzz
[ $# -gt 0 ] || set -- $("$fuzz" list | cut -d' ' -f1)

if ! cargo "+$nightly" --version >/dev/null 2>&1; then
    echo "no toolchain $nightly: the seeded loop, without coverage"
    if [ -n "${RUNS:-}" ]; then
        exec "$fuzz" "$@" --executions "$RUNS" --seed "$seed"
    fi
    exec "$fuzz" "$@" --seconds "$seconds" --seed "$seed"
fi

host=$(rustc -vV | sed -n 's/^host: //p')
flags="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters"
flags="$flags -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares"
RUSTFLAGS="$flags" cargo "+$nightly" build -q --profile fuzz --manifest-path "$here/Cargo.toml" --target "$host" \
    --features libfuzzer --bin attack
attack=$built/$host/fuzz/attack

work=$here/findings/work
rm -rf "$work/seeds"
mkdir -p "$work/seeds"
"$fuzz" seeds "$work/seeds" "$@"
# libFuzzer reads folders, so the archives are unpacked for it.
corpus=$built/fuzz-corpus
rm -rf "$corpus"
"$fuzz" unpack "$corpus" "$@"
table=$work/table
: > "$table"
found=0
for target in "$@"; do
    mkdir -p "$work/inputs/$target" "$here/findings/$target"
    export TRUEAXIS_FUZZ=$target
    log=$work/$target.log
    status=0
    "$attack" -max_total_time="$seconds" -runs="${RUNS:--1}" -seed="$seed" -timeout=10 -rss_limit_mb=2048 \
        -max_len="$(cat "$work/seeds/$target.longest")" -dict="$work/seeds/$target.dict" \
        -artifact_prefix="$here/findings/$target/" -print_final_stats=1 \
        "$work/inputs/$target" "$corpus/$target" "$work/seeds/$target" > "$log" 2>&1 || status=$?
    findings=$(find "$here/findings/$target" -type f ! -name '*.txt' ! -name 'slow-unit-*' | wc -l)
    [ $status -eq 0 ] || found=1
    if [ -n "${KEEP:-}" ] && [ $status -eq 0 ]; then
        rm -rf "$work/merged"
        mkdir "$work/merged"
        "$attack" -set_cover_merge=1 "$work/merged" "$work/inputs/$target" "$corpus/$target" > "$log.merge" 2>&1
        # The smallest first, up to the limit; former findings stay whatever they cover.
        find "$corpus/$target" -type f ! -name 'finding-*' -delete
        kept=$(cat "$corpus/$target"/* 2>/dev/null | wc -c)
        for file in $(ls -Sr "$work/merged"); do
            kept=$((kept + $(wc -c < "$work/merged/$file")))
            [ $kept -le $most_corpus ] || break
            cp "$work/merged/$file" "$corpus/$target/$file"
        done
        "$fuzz" pack "$corpus" "$target"
    fi
    stat() { sed -n "s/^stat::$1: *//p" "$log" | tail -1; }
    edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -1)
    echo "$target $(stat number_of_executed_units) $(stat average_exec_per_sec) ${edges:-0} $(ls "$work/inputs/$target" | wc -l) $findings" >> "$table"
done
{ echo "target executions exec/s edges corpus findings"; cat "$table"; } |
    awk '{ printf "%-20s %12s %8s %8s %8s %8s\n", $1, $2, $3, $4, $5, $6 }'
exit $found
