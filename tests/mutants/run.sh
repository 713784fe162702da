#!/usr/bin/env bash
# Mutation of the core: all mutants in one build, each switched on for the tests that reach it. Survivors of an earlier
# run are tried again, killed ones stay killed (--fresh forgets them). Options: run.sh --help.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$(cd "$here/../.." && pwd)"
target="${CARGO_TARGET_DIR:-$root/target}"
export PATH="$("$root/.ci/install" --where)/bin:${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"
"$root/.ci/install" cargo:cargo-mutants@27.1.0
# Long tests run a part of their cases: few mutants slip through, and every mutant runs them.
export TRUEAXIS_TEST_SHARE="${TRUEAXIS_TEST_SHARE:-40}"
CARGO_TARGET_DIR="$target/mutants/tool" cargo build --quiet --locked --manifest-path "$here/Cargo.toml"
export CARGO_PROFILE_TEST_OPT_LEVEL="${CARGO_PROFILE_TEST_OPT_LEVEL:-1}"
# The core's own tests, and those that check its results to the last bit.
killers=(--package trueaxis --package trueaxis-recording --tests=--lib)
for test in plugin recording; do killers+=(--tests=--test "--tests=$test"); done
[[ " $* " == *" --tests="* ]] && killers=()
exec "$target/mutants/tool/debug/trueaxis-mutants" "${killers[@]}" "$@"
