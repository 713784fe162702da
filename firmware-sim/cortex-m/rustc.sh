#!/usr/bin/env bash
# RUSTC_WRAPPER of the images: gives the crates of this repository the same symbol names in every clone. Cargo hashes the
# folder of a crate outside its workspace into them, and link-time optimisation takes functions in the order of their names,
# so the counts would differ from folder to folder.
set -euo pipefail
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
if [[ ${CARGO_MANIFEST_DIR-} == "$repository"/* ]]; then
    set -- "${@/#metadata=*/metadata=$CARGO_PKG_NAME-$CARGO_CRATE_NAME}"
fi
exec "$@"
