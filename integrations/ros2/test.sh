#!/usr/bin/env bash
# Builds the filter's example, and the controller in a chain on doubles of ros2_control as in Humble, in Jazzy before
# 4.44 and in current releases. Runs them and compares their outputs at standstill with `trueaxis compensate`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

root=$(cd ../.. && pwd)
"$root/.ci/install" g++ libc6-dev python3
target=${CARGO_TARGET_DIR:-$root/target}
out=$target/ros2
mkdir -p "$out"
"$root/.ci/commands"
machine=$root/compensation-tables/mill-3axis
"$target/release/trueaxis" tables compile "$machine" -o "$out/machine.tcomp" 2>"$out/compile.log"
head -c 3000 "$out/machine.tcomp" >"$out/cut.tcomp"
build() { # source, program, flags
    local source=$1 program=$2
    shift 2
    # ros2_control itself also treats -Wconversion and -Wshadow as errors.
    c++ -std=c++17 -O2 -Wall -Wextra -Wpedantic -Woverloaded-virtual -Wconversion -Wshadow -Werror "$@" \
        "-I$root/crates/trueaxis-capi/include" "$source" \
        "$target/release/libtrueaxis_capi.a" -Wl,--gc-sections -lpthread -ldl -o "$out/$program"
}
run() { # program, arguments; leaves its compensated positions at standstill
    local program=$1
    shift
    timeout 120 "$out/$program" "$@" "$out/$program.csv" | tee "$out/$program.txt"
    "$target/release/trueaxis" compensate "$machine" "$out/$program.csv" -o "$out/$program-corrected.csv"
}
build example.cpp example
run example "$out/machine.tcomp"
build chain.cpp humble -Idouble/humble -Idouble
build chain.cpp jazzy-4.43 -Idouble/jazzy -Idouble -DDOUBLE_MINOR=43
build chain.cpp jazzy -Idouble/jazzy -Idouble
for release in humble jazzy-4.43 jazzy; do
    run "$release" "$out/machine.tcomp" "$out/cut.tcomp"
done
exec python3 - "$out" <<'PYTHON'
import csv, sys
from pathlib import Path

out = Path(sys.argv[1])
for name in ("example", "humble", "jazzy-4.43", "jazzy"):
    text = (out / f"{name}.txt").read_text()
    drive = [float(value) for value in next(line for line in text.splitlines() if line.startswith("drive ")).split()[1:]]
    row = next(csv.DictReader((out / f"{name}-corrected.csv").open()))
    off = [1e3 * (value - float(row[f"c{axis}_mm"])) for value, axis in zip(drive, "xyz")]
    shift = [1e3 * (float(row[f"c{axis}_mm"]) - float(row[f"{axis}_mm"])) for axis in "xyz"]
    print(f"{name}: correction", *(f"{value:.3f}" for value in shift), "um; off it by", *(f"{value:.4f}" for value in off), "um")
    if max(map(abs, off)) > 0.002 or max(map(abs, shift)) < 5:
        sys.exit(f"{name}: found other drive positions than those of trueaxis compensate, needed the same within 0.002 um")
PYTHON
