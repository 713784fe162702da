#!/usr/bin/env bash
# Counts the instructions of the gauge on a Cortex-M4F (f32) and a Cortex-M7 (f64) in QEMU and holds them against
# counts.toml. Installs the target, and QEMU where root may.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

mcu=thumbv7em-none-eabihf
rustc --print target-libdir --target "$mcu" | xargs test -d || rustup target add "$mcu"
if ! command -v qemu-system-arm >/dev/null; then
    if [[ $(id -u) != 0 ]]; then
        echo 'qemu-system-arm is missing, and only root can install it: apt-get install qemu-system-arm' >&2
        exit 1
    fi
    export DEBIAN_FRONTEND=noninteractive
    apt-get -o DPkg::Lock::Timeout=300 -q update
    apt-get -o DPkg::Lock::Timeout=300 -q -y install --no-install-recommends qemu-system-arm
fi

target=${CARGO_TARGET_DIR:-$PWD/target}
# board, processor, name, build
count() {
    local board=$1 processor=$2 name=$3
    shift 3
    CARGO_TARGET_DIR="$target/$name" cargo build --quiet --release --bin count "$@"
    timeout 300 qemu-system-arm -M "$board" -cpu "$processor" -nographic -monitor none -serial none \
        -icount shift=7,align=off,sleep=off -semihosting-config enable=on,target=native \
        -kernel "$target/$name/$mcu/release/count" >"$target/$name.txt"
}
mkdir -p "$target"
count mps2-an386 cortex-m4 m4f
CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS='-Ctarget-cpu=cortex-m7' \
    count mps2-an500 cortex-m7 m7 --features double
exec python3 check.py counts.toml "m4f=$target/m4f.txt" "m7=$target/m7.txt"
