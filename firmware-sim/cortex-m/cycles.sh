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
mkdir -p "$work"
cc -O2 -shared -fPIC -o "$work/executed.so" executed.c

# core, kind of request, number, file for the addresses
trace() {
    local core=$1 kind=$2 number=$3 to=$4 board file place options
    case $core in
        m4f) board=(-M mps2-an386 -cpu cortex-m4) ;;
        m7) board=(-M mps2-an500 -cpu cortex-m7) ;;
    esac
    options=(-device "loader,addr=0x003ffff8,data=$kind,data-len=4" -device "loader,addr=0x003ffffc,data=$number,data-len=4")
    for file in a.tcomp=0x00110000 b.tcomp=0x00140000 run.rec=0x00180000; do
        options+=(-device "loader,file=${target//,/,,}/count/${file%=*},addr=${file#*=},force-raw=on")
    done
    # The bare step, in each scalar that the image has.
    local plugin=$work/executed.so,out=$to
    for place in $(llvm-nm --demangle "$(elf "$core")" | awk '$3 ~ /^count::forms::bare/ { print $1 }'); do
        plugin+=,from=0x$place
    done
    timeout 600 qemu-system-arm "${board[@]}" -nographic -monitor none -serial none -icount shift=7,align=off,sleep=off \
        -semihosting-config enable=on,target=native "${options[@]}" -plugin "$plugin" -kernel "$(elf "$core")" >"$to.log"
}
elf() {
    echo "$target/count/$1.elf"
}

{
    echo '# Cycles of single servo cycles as LLVM models the cores, written by cycles.sh. executed: instructions, the call and its'
    echo '# frame included; model: cycles without wait states; branches: refill of the pipeline after those taken, which the'
    echo '# model of the M4F leaves out; flash: waiting for code behind five wait states.'
    echo
} >"$work/cycles.toml"
for core in m4f m7; do
    [[ $core == m4f ]] && scalar=f32 || scalar=f64
    at() {
        awk -v s="$scalar" -v n="$1" -v k="$2" '$1 == s && $2 == n { for (i = 3; i < NF; i++) if ($i == k) print $(i + 1) }' "$target/$core.txt"
    }
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
1 $(at recording typical_at) typical cycle of the recording
1 $(at recording worst_at) worst of the recording
2 $(at adversarial at) worst adversarial cycle
CYCLES
done
mv "$work/cycles.toml" cycles.toml
cat cycles.toml
