#!/usr/bin/env bash
# Runs the tests of the C interface under Miri, which sees every access through a pointer: out of bounds, misaligned, to
# memory that was freed, not initialised or borrowed by someone else. Long tests have smaller twins here. Installs what is
# missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

root=$(cd ../.. && pwd)
"$root/.ci/install" rustup:nightly:miri rustup:nightly:rust-src
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}/miri
# 32-bit pointers, as on the Cortex-M; and no inline assembly in libm, which Miri cannot interpret. Test header reads
# files and has no pointer of the interface in it. Tests leak what Rust loops borrow; the interface allocates nothing.
export MIRIFLAGS="${MIRIFLAGS:-} -Zmiri-strict-provenance -Zmiri-ignore-leaks"
tests=(storage refusals same_as_rust paths gauge combinations tool query)
timeout 2700 cargo +nightly miri test -p trueaxis-capi --target armv7-unknown-linux-gnueabihf --test capi -- "${tests[@]/%/::}"
