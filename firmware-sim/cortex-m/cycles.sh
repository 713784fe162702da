#!/usr/bin/env bash
# Estimates the cycles of a typical cycle of the recording, its worst and the worst adversarial one on both cores: the
# instructions that QEMU executes go through llvm-mca's models of the cores. Written into cycles.toml, from which the tables
# of docs/bare-metal.md follow (schedule.py). Run by hand after count.sh, whose images, recording and worst cycles it uses:
#
#   cycles.sh             all of them
#   cycles.sh --where     also prints where the instructions go and where the models wait, by function and by line
#
# Installs QEMU and LLVM where root may; needs a C compiler.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

target=${CARGO_TARGET_DIR:-$PWD/target}
../../.ci/install qemu-system-arm llvm
[[ -s $target/m7.txt ]] || ./count.sh
work=$target/cycles
source trace.sh

{
    echo '# Cycles of single servo cycles as LLVM models the cores, written by cycles.sh. executed: instructions, the call and its'
    echo '# frame included; model: cycles without wait states; branches: refill of the pipeline after those taken, which the'
    echo '# model of the M4F leaves out; flash: waiting for code behind five wait states.'
    echo
} >"$work/cycles.toml"
for core in m4f m7; do
    [[ $core == m4f ]] && scalar=f32 || scalar=f64
    while read -r kind number what; do
        name=recorded
        [[ $kind == 1 ]] || name=adversarial
        trace "$core" "$kind" "$number" "$work/$core-$name-$number"
        python3 cycles.py "$core" "$what" "$name" "$number" "$(elf "$core")" "$work/$core-$name-$number" >>"$work/cycles.toml"
        if [[ ${1-} == --where ]]; then
            echo "--- $core, $what"
            python3 cycles.py --where "$core" "$(elf "$core")" "$work/$core-$name-$number"
        fi
    done <<CYCLES
1 $(counted "$core" "$scalar" recording typical_at) typical cycle of the recording
1 $(counted "$core" "$scalar" recording worst_at) worst of the recording
2 $(counted "$core" "$scalar" adversarial at) worst adversarial cycle
CYCLES
done
mv "$work/cycles.toml" cycles.toml
cat cycles.toml
