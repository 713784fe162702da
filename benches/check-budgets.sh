#!/bin/sh
# For CI: gets valgrind and gungraun's runner where they are missing, then counts.
set -eu
cd "$(dirname "$0")/.."
tools="${CARGO_TARGET_DIR:-$PWD/target}/tools"
PATH="$PATH:$tools/bin"
export PATH
command -v valgrind >/dev/null || { sudo apt-get update && sudo apt-get install -y valgrind; }
command -v gungraun-runner >/dev/null || cargo install gungraun-runner --version 0.20.0 --locked --root "$tools"
exec benches/check-budgets.py "$@"
