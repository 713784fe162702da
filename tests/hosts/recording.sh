#!/usr/bin/env bash
# Makes the recording that every host replays, in target/hosts: machine.tcomp, run.rec, and run.csv with the library's
# drive positions. Every test script of a host calls it, then leaves its result there for table.py.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

root=$(cd ../.. && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
"$root/.ci/commands"
mkdir -p "$target/hosts"
out=$(mktemp -d "$target/hosts/making.XXXXXX")
trap 'rm -rf "$out"' EXIT
"$target/release/trueaxis" tables compile machine -o "$out/machine.tcomp" 2>"$out/log" || { cat "$out/log" >&2; exit 1; }
{
    "$target/release/firmware-sim" record --machine machine --program path.ngc --origin-mm 0,0,0 --rate-hz 1000 -o "$out/run.rec" &&
        "$target/release/firmware-sim" replay "$out/run.rec" "$out/machine.tcomp" -o "$out/run.csv"
} >"$out/log" 2>&1 || { cat "$out/log" >&2; exit 1; }
# Two scripts may run at a time and make the same files.
mv "$out/machine.tcomp" "$out/run.rec" "$out/run.csv" "$target/hosts"
