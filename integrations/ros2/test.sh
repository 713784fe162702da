#!/usr/bin/env bash
# Builds the filter and its example without ROS, runs it, and holds what it sends at standstill against `trueaxis compensate`.
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
c++ -std=c++17 -O2 -Wall -Wextra -Wpedantic -Werror "-I$root/crates/trueaxis-capi/include" example.cpp \
    "$target/release/libtrueaxis_capi.a" -Wl,--gc-sections -lpthread -ldl -o "$out/example"
timeout 120 "$out/example" "$out/machine.tcomp" "$out/at.csv" | tee "$out/example.txt"
"$target/release/trueaxis" compensate "$machine" "$out/at.csv" -o "$out/corrected.csv"
exec python3 - "$out" <<'PYTHON'
import csv, sys
from pathlib import Path

out = Path(sys.argv[1])
text = (out / "example.txt").read_text()
drive = [float(value) for value in next(line for line in text.splitlines() if line.startswith("drive ")).split()[1:]]
row = next(csv.DictReader((out / "corrected.csv").open()))
off = [1e3 * (value - float(row[f"c{axis}_mm"])) for value, axis in zip(drive, "xyz")]
shift = [1e3 * (float(row[f"c{axis}_mm"]) - float(row[f"{axis}_mm"])) for axis in "xyz"]
print("correction", *(f"{value:.3f}" for value in shift), "um; off it by", *(f"{value:.4f}" for value in off), "um")
if max(map(abs, off)) > 0.002 or max(map(abs, shift)) < 5:
    sys.exit("the filter's drive positions are not those of trueaxis compensate")
PYTHON
