#!/usr/bin/env bash
# Builds the desk: desk/dist/desk.html, one file without any outside resource.
#
#   desk/build.sh          as released
#   desk/build.sh --dev    the module less optimised, in a fraction of the time
#
# Needs rustup, Node 18 or later with npm, and the package registries; installs what is missing of them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

profile=page
folder=page
if [[ ${1:-} == --dev ]]; then
    profile=dev
    folder=debug
elif [[ $# != 0 ]]; then
    echo 'usage: desk/build.sh [--dev]' >&2
    exit 2
fi
../.ci/install rustup:target:wasm32-unknown-unknown
command -v npm >/dev/null || ../.ci/install nodejs npm
command -v xz >/dev/null || ../.ci/install xz-utils
target=${CARGO_TARGET_DIR:-$PWD/../target}

# Panics name their files: not where the packages lie on this machine.
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS="--remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}/registry/src="
cargo build -p trueaxis-desk --profile "$profile" --target wasm32-unknown-unknown
../.ci/install crate:desk/bindgen
"$(../.ci/install --where)/bin/desk-bindgen" "$target/wasm32-unknown-unknown/$folder/trueaxis_desk.wasm" pkg

# Once for each state of the lock file.
if ! cmp -s package-lock.json node_modules/.installed; then
    npm ci --no-audit --no-fund --ignore-scripts
    cp package-lock.json node_modules/.installed
fi
npx tsc --noEmit
node build.mjs
