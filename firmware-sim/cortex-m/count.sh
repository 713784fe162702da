#!/usr/bin/env bash
# Counts the instructions of the step and its parts on a Cortex-M4F (f32) and a Cortex-M7 (f64) in QEMU, over a recording
# with reversals, corners, faults, an exchange of tables and a whole revolution at the gauge, and over 100,000 adversarial
# cycles, whose outputs must be the host's bit for bit. Compares the counts with counts.toml.
#
#   count.sh --commit                      writes the counts into counts.toml and adversarial.toml instead
#   count.sh --replay CYCLE                runs an adversarial cycle: events, stages, inputs
#   count.sh --replay-recorded CYCLE       runs a cycle of the recording
#   count.sh --climb CLIMBS                searches for dearer cycles in CLIMBS climbs of 20,000 cycles (climb.rs repeats the best of 50)
#
# Installs the target, and QEMU where root may.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

repository=$(cd ../.. && pwd)
on_host=${CARGO_TARGET_DIR:-$repository/target}
target=${CARGO_TARGET_DIR:-$PWD/target}
mcu=thumbv7em-none-eabihf
"$repository/.ci/install" "rustup:target:$mcu" qemu-system-arm

# In the repository's folder: the configuration of this folder builds for the processor.
CARGO_TARGET_DIR=$on_host "$repository/.ci/commands"
# With the flags of the host's budgets, which have built it already.
(cd "$repository" && CARGO_TARGET_DIR=$on_host cargo build --quiet --profile counted -p trueaxis-benches --features counts --bin counted)
inputs=$target/count
mkdir -p "$inputs"
"$on_host/release/trueaxis" tables compile machine -o "$inputs/a.tcomp" 2>"$inputs/compile.log"
"$on_host/release/trueaxis" tables compile machine/warm.toml -o "$inputs/b.tcomp" 2>>"$inputs/compile.log"
"$on_host/release/firmware-sim" record --machine machine --program short-tour --rate-hz 1000 --drill --exchange-at 12000 \
    -o "$inputs/run.rec" >"$inputs/record.log" 2>&1
"$on_host/counted/counted" digest >"$target/host.txt"

request=()
case ${1-} in
--replay-recorded) kind=1 ;;
--replay) kind=2 ;;
--climb) kind=3 ;;
*) kind= ;;
esac
replay=${kind:+-replay}
if [[ -n $kind ]]; then
    # Where regions.rs looks for it.
    request=(-device "loader,addr=0x003ffff8,data=$kind,data-len=4" -device "loader,addr=0x003ffffc,data=$2,data-len=4")
fi
source flags.sh
build() { # core, further arguments of cargo
    local core=$1
    shift
    CARGO_TARGET_DIR="$(built "$core")" CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS="$(flags "$core")" \
        cargo build --quiet --release --bin count "$@"
    cp "$(built "$core")/$mcu/release/count" "$inputs/$core.elf"
}
count() { # board, processor, core
    local board=$1 processor=$2 name=$3
    local flash=() file
    for file in a.tcomp=0x00110000 b.tcomp=0x00140000 run.rec=0x00180000; do
        # QEMU separates options by commas and doubles those in names.
        flash+=(-device "loader,file=${inputs//,/,,}/${file%=*},addr=${file#*=},force-raw=on")
    done
    timeout 1800 qemu-system-arm -M "$board" -cpu "$processor" -nographic -monitor none -serial none \
        -icount shift=7,align=off,sleep=off -semihosting-config enable=on,target=native "${flash[@]}" "${request[@]}" \
        -kernel "$inputs/$name.elf" >"$target/$name$replay.txt" || {
        tail -3 "$target/$name$replay.txt" >&2
        return 1
    }
}
build m4f
count mps2-an386 cortex-m4 m4f &
first=$!
build m7 --features double
count mps2-an500 cortex-m7 m7 &
second=$!
wait "$first"
wait "$second"
if [[ -n $kind ]]; then
    exec cat "$target/m4f$replay.txt" "$target/m7$replay.txt"
fi
exec python3 check.py "$@" counts.toml "m4f=$target/m4f.txt" "m7=$target/m7.txt" "host=$target/host.txt"
