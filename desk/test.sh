#!/usr/bin/env bash
# Builds the desk and drives it in Debian's Chromium: `desk/test.sh [TEST...]`, a test being a file in desk/tests without its ending.
#
# Compares what it shows with the programs of this workspace; leaves pictures in desk/shots. Installs what is missing:
# Chromium by apt-get, as root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

.ci/install chromium
if [[ -z ${TRUEAXIS_DESK:-} ]]; then
    desk/build.sh
    # Here the packages of the page lie unpacked.
    .ci/third-party --check
fi
# Optimised: a simulation is compared with the page's.
export TRUEAXIS_PROFILE=release
.ci/commands
# The page in the program: served to this computer alone, and written.
# With the features that `cargo test --workspace` has built.
cargo test --workspace --features trueaxis-cli/desk --test cli desk::served

tests=(desk/tests/*.test.mjs)
if [[ $# != 0 ]]; then
    tests=("${@/#/desk/tests/}")
    tests=("${tests[@]/%/.test.mjs}")
fi
node --test --test-concurrency=1 --test-reporter=spec "${tests[@]}"
