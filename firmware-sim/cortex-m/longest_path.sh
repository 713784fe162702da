#!/usr/bin/env bash
# Bounds the instructions of the servo step from the M4F's program (longest_path.py) for the machine of the counts, and follows
# the worst cycle of the recording and the worst adversarial one along the graph: both must be paths of it within the bound.
# Takes seconds; after count.sh, whose program, recording and worst cycles it uses. Arguments go to longest_path.py:
#
#   longest_path.sh --calls --loops --lines        also the calls, the loops and the lines of the path
#
# Installs QEMU and LLVM where root may; needs a C compiler.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

target=${CARGO_TARGET_DIR:-$PWD/target}
../../.ci/install qemu-system-arm llvm rustup:target:thumbv7em-none-eabihf
python3 test_longest_path.py "$target/longest-path"
source trace.sh

# What machine/machine.toml has none of, and spans without length, which only a turning tool has.
without=(volumetric grids dynamic lookup crowded_tables many_passes periods rotary_axes turning_spans far bisection)
traces=()
while read -r kind number; do
    file=$target/cycles/m4f-path-$kind-$number
    trace m4f "$kind" "$number" "$file"
    traces+=(--trace "$file")
done <<CYCLES
1 $(counted m4f f32 recording worst_at)
2 $(counted m4f f32 adversarial at)
CYCLES
python3 longest_path.py "$(elf m4f)" count::forms::bare "${without[@]/#/--without=}" --let N=3 \
    --seen "$(counted m4f f32 adversarial worst)" "${traces[@]}" "$@"
