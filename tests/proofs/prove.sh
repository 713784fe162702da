#!/usr/bin/env bash
# Proves the bounds of the limiter, on the compiler's code of it and in real arithmetic, and of the friction that adapts, and
# checks that each proof fails on planted defects. Installs its Python packages into target/proofs/venv.
#
#   prove.sh           single precision on the host; a minute of one core
#   prove.sh adapt     only the friction that adapts; seconds
#   prove.sh --full    double precision, any velocity, and the code of a Cortex-M, too; each claim MINUTES [30] at the longest
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

full=${1-}
[[ -z $full || $full == --full || $full == adapt ]] || { echo 'usage: prove.sh [adapt | --full]' >&2; exit 2; }
root=$(cd ../.. && pwd)
target=${CARGO_TARGET_DIR:-$root/target}/proofs
mkdir -p "$target"
python=$target/venv/bin/python
packages=(bitwuzla==0.9.1 z3-solver==5.4.1.0)
if ! "$python" -c 'import bitwuzla, z3' 2>/dev/null; then
    python3 -m venv "$target/venv"
    "$python" -m pip install --quiet --disable-pip-version-check "${packages[@]}"
fi

# Manifest, name of the crate, further flags: its LLVM code and the layout of its types, to $target/NAME.{ll,sizes}.
# Without vector instructions, which the reader does not know; they change no number.
emit() {
    local manifest=$1 name=$2 folder=$target/$2
    shift 2
    rm -f "$folder"/*/deps/"$name"-*.ll "$folder"/*/*/deps/"$name"-*.ll
    # Always recompiled: the compiler prints the layout only then.
    touch "$(dirname "$manifest")/src/lib.rs"
    CARGO_TARGET_DIR=$folder RUSTC_BOOTSTRAP=1 cargo rustc --quiet --release --lib --manifest-path "$manifest" "$@" -- \
        --emit=llvm-ir -Cno-vectorize-slp -Cno-vectorize-loops -Cdebuginfo=0 -Zprint-type-sizes >"$folder.sizes"
    [[ -s $folder.sizes ]]
    find "$folder" -name "$name-*.ll" -exec cp {} "$folder.ll" \;
}
mkdir -p "$target"/trueaxis_{limiter,adapt}_{ir,controls}

emit adapt/Cargo.toml trueaxis_adapt_ir
"$python" adapt.py "$target"/trueaxis_adapt_ir.{ll,sizes}
"$python" adapt_controls.py "$target/adapt-controls" >"$target/adapt-controls.txt"
emit "$target/adapt-controls/Cargo.toml" trueaxis_adapt_controls
mapfile -t defects <"$target/adapt-controls.txt"
"$python" adapt.py --must-fail "$target"/trueaxis_adapt_controls.{ll,sizes} "${defects[@]}"
[[ $full != adapt ]] || exit 0

emit limiter/Cargo.toml trueaxis_limiter_ir
host=("$target/trueaxis_limiter_ir.ll" "$target/trueaxis_limiter_ir.sizes")
"$python" limiter.py "${host[@]}" follow_f32 freeze_f32 hold_f32

"$python" controls.py "$target/controls" >"$target/controls.txt"
emit "$target/controls/Cargo.toml" trueaxis_limiter_controls
mapfile -t defects <"$target/controls.txt"
"$python" limiter.py --must-fail "$target"/trueaxis_limiter_controls.{ll,sizes} "${defects[@]}"

"$python" magnitude.py
# The proof is of exact numbers; the part that rounding adds at the ends is measured and compared with its bound.
CARGO_TARGET_DIR=$target/trueaxis_limiter_ir cargo run --quiet --release --manifest-path limiter/Cargo.toml --bin extremes
[[ -n $full ]] || exit 0

longest=${MINUTES:-30}
open=0
"$python" limiter.py --full --minutes "$longest" "${host[@]}" || open=1
"$python" rounding.py
"$root/.ci/install" rustup:target:thumbv7em-none-eabihf
emit limiter/Cargo.toml trueaxis_limiter_ir --target thumbv7em-none-eabihf
"$python" limiter.py --full --minutes "$longest" "${host[@]}" || open=1
exit $open
