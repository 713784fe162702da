#!/usr/bin/env bash
# Proves on the host, on a Cortex-M4F (f32) and on a Cortex-M7 (f64) that no function of the step can panic or allocate,
# with negative controls that must not link; bounds the stack and compares bounds and sizes with budgets.toml.
# Installs the target, the LLVM tools, and QEMU where root may.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

mcu=thumbv7em-none-eabihf
host=$(rustc -vV | sed -n 's/^host: //p')
tools=$(rustc --print sysroot)/lib/rustlib/$host/bin
../../../.ci/install "rustup:target:$mcu" qemu-system-arm
[[ -x $tools/llvm-objdump ]] || rustup component add llvm-tools
# Built beside the images, which need the same of the host.
built=${CARGO_TARGET_DIR:-$(cd .. && pwd)/target}
export RUSTC_WRAPPER=$(cd .. && pwd)/rustc.sh
target=$built/proofs
mkdir -p "$target"

# name of the program, triple, features, flags of all crates, flags of the program's own
build() {
    local name=$1 triple=$2 features=$3 flags=$4
    shift 4
    CARGO_TARGET_DIR=$built CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS=$flags timeout 1800 \
        cargo rustc --quiet --release --locked --target "$triple" --features "$features" -- "$@" &&
        cp "$built/$triple/release/trueaxis-proofs" "$target/$name.elf"
}

# core, triple, features, flags
prove() {
    local core=$1 triple=$2 features=$3 flags=$4 control needed symbols symbol
    build "$core" "$triple" "$features" "$flags"
    symbols=$("$tools/llvm-nm" "$target/$core.elf")
    for symbol in step step_with_gauge step_with_tool step_rtcp step_following bypass take_into \
        $([[ $features != *decoders* ]] || echo table_row learned_parse learned_at); do
        grep -q " [Tt] proved_$symbol\$" <<<"$symbols" || {
            echo "$core: proved_$symbol is not in the program, so nothing is proved" >&2
            exit 1
        }
    done
    # Symbols that a panic or an allocation needs; the host's C library, linked at run time, is not searched for either.
    if grep -E 'panicking|__rust_alloc|__rg_alloc|[UT] (malloc|calloc|realloc)' <<<"$symbols"; then
        echo "$core: a panic or an allocation is in the program" >&2
        exit 1
    fi
    printf '%-26s %-4s no panic, no allocation\n' "$(grep -c ' [Tt] proved_' <<<"$symbols") functions" "$core"
    # The linker and the handler are the same for every core: the controls, which are whole builds, are tried on one.
    [[ $core == m4f ]] || return 0
    for control in variable-index variable-division allocation; do
        needed='undefined symbol: a_panic_can_be_reached'
        [[ $control != allocation ]] || needed='no global memory allocator found'
        if build control "$triple" "$features,$control" "$flags" >"$target/control.log" 2>&1; then
            echo "$core: $control links, and must not" >&2
            exit 1
        fi
        grep -qF "$needed" "$target/control.log" || {
            echo "$core: $control fails, but not with \"$needed\":" >&2
            cat "$target/control.log" >&2
            exit 1
        }
    done
    printf '%-26s %-4s refused by the linker\n' '3 controls' "$core"
}

# core, features, flags, board, processor
bound() {
    local core=$1 features=$2 flags=$3 board=$4 processor=$5 elf=$target/$1-painted.elf
    # Fat LTO generates all code in the last step: the program's own flags suffice for every frame.
    RUSTC_BOOTSTRAP=1 build "$core-painted" "$mcu" "$features" "$flags" \
        -Zemit-stack-sizes "-Clink-arg=-L$PWD" -Clink-arg=-Tstack-sizes.ld
    timeout 600 qemu-system-arm -M "$board" -cpu "$processor" -nographic -monitor none -serial none \
        -semihosting-config enable=on,target=native -kernel "$elf" >"$target/$core-painted.txt"
    python3 stack.py --tools "$tools" --budgets budgets.toml --target "$core" --painted "$target/$core-painted.txt" "$elf" ||
        failed=1
}

# On the host also the decoders of tables and learned corrections, for any bytes of any length.
prove host "$host" double,decoders ''
prove m4f "$mcu" '' ''
prove m7 "$mcu" double,fp64 '-Ctarget-cpu=cortex-m7'
printf '%-26s %-4s %9s %9s %9s %7s\n' bytes core bound painted committed limit
failed=0
bound m4f painted '' mps2-an386 cortex-m4
bound m7 painted,double,fp64 '-Ctarget-cpu=cortex-m7' mps2-an500 cortex-m7
python3 size.py budgets.toml m4f "$target/m4f.elf" || failed=1
python3 size.py budgets.toml m7 "$target/m7.elf" || failed=1
exit "$failed"
