#!/usr/bin/env bash
# Runs the tests of the C interface under Miri, which sees every access through a pointer: out of bounds, misaligned, to
# memory that was freed, not initialised or borrowed by someone else. Long tests have smaller twins here. Installs what is
# missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

if ! rustup component list --toolchain nightly --installed 2>/dev/null | grep -q '^miri'; then
    rustup toolchain install nightly --profile minimal --component miri,rust-src
fi
root=$(cd ../.. && pwd)
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}/miri
# Files are read (the header and its source) by a test that is left out; strict provenance holds for all of the interface.
export MIRIFLAGS="${MIRIFLAGS:-} -Zmiri-strict-provenance"
timeout 600 cargo +nightly miri test -p trueaxis-capi --lib --test refusals --test same_as_rust --test paths --test gauge
