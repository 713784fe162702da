#!/usr/bin/env bash
# Lints the example that uses ethercrab, runs the cycle against a process image of simulated drives, and tries a damaged
# table.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

../../.ci/install gcc libc6-dev python3
cargo fmt --check
cargo clippy --quiet --all-targets -- -D warnings
cargo test --quiet --test faults
cargo build --quiet --example servo
target=${CARGO_TARGET_DIR:-$PWD/target}
python3 - ../../crates/trueaxis/mill-3axis.tcomp "$target/damaged.tcomp" <<'PYTHON'
import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[len(data) // 2] ^= 1
open(sys.argv[2], "wb").write(data)
PYTHON
# The interface does not exist, but the example refuses the table before it accesses any interface.
timeout 120 "$target/debug/examples/servo" no-such-interface "$target/damaged.tcomp" 2>"$target/refused.txt" && exit 1
head -1 "$target/refused.txt"
grep -qx 'trueaxis: the file is damaged (its CRC-32 is wrong); running uncompensated' "$target/refused.txt"
