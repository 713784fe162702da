#!/usr/bin/env bash
# Counts the instructions of the step's parts and compares them with budgets.toml. Needs valgrind and gungraun-runner.
set -euo pipefail
exec python3 "$(dirname "${BASH_SOURCE[0]}")/check-budgets.py" "$@"
