#!/usr/bin/env bash
# The bare-metal image from end to end: builds it for a Cortex-M4F (f32) and a Cortex-M7 (f64), runs recordings in QEMU
# and checks its messages: the host's outputs bit for bit, the same in a second run, a refusal for every bad input,
# its size and stack; then the counts of instructions and the longest path.
#
# Installs the target and defmt-print, and QEMU where root may.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

repository=$(cd ../.. && pwd)
on_host=${CARGO_TARGET_DIR:-$repository/target}
target=${CARGO_TARGET_DIR:-$PWD/target}
export PATH="$("$repository/.ci/install" --where)/bin:${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"
mcu=thumbv7em-none-eabihf
cores=(m4f m7)

say() {
    printf -- '--- %s [%d s]\n' "$1" "$SECONDS"
}

say 'what is needed'
"$repository/.ci/install" "rustup:target:$mcu" qemu-system-arm cargo:defmt-print@1.2.0

say 'host'
# In the repository's folder: the configuration of this folder builds for the processor.
CARGO_TARGET_DIR=$on_host "$repository/tests/hosts/recording.sh"
simulator=$on_host/release/firmware-sim
trueaxis=$on_host/release/trueaxis

say 'images'
source flags.sh
mkdir -p "$target/images"
elf() { # core, or another name
    echo "$target/images/$1.elf"
}
build() { # name, core, further arguments of cargo
    local name=$1 core=$2
    shift 2
    CARGO_TARGET_DIR="$(built "$core")" CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS="$(flags "$core")" \
        cargo build --quiet --release --bin image "$@"
    cp "$(built "$core")/$mcu/release/image" "$(elf "$name")"
}
build hurried m4f --features hurried
build m4f m4f
build m7 m7 --features double

# Runs something for both cores at a time: `both NAME ARGUMENTS`, with the core as first argument.
both() {
    local core failed=0 jobs=()
    for core in "${cores[@]}"; do
        "$1" "$core" "${@:2}" &
        jobs+=($!)
    done
    for job in "${jobs[@]}"; do
        wait "$job" || failed=1
    done
    return "$failed"
}

work=$target/test
rm -rf "$work"
mkdir -p "$work"

say 'against the host, bit for bit, twice'
# The growth of machine/thermal.toml for a machine.
grow() {
    "$trueaxis" thermal compile machine/thermal.toml --machine "$1" -o "$2" 2>>"$work/compile.log"
}
grow machine "$work/good.ttherm"
compare() {
    local core=$1 run=$2 with=(--machine machine --exchange-at 12000 --second machine/warm.toml
        --growth "$work/good.ttherm" --temperatures machine/temperatures.csv)
    # Friction, feedback and everything else that acts on the servo: fewer cycles suffice. Single precision is not compared
    # with double there: a reversal seen a cycle apart starts lost motion a cycle apart, in more than one of 1,000 cycles.
    [[ $run != dynamic ]] || with=(--machine machine/dynamic.toml --cycles 6000)
    timeout 900 "$simulator" compare --json --core "$core" "--image-$core" "$(elf "$core")" --output "$work/$run" \
        --program short-tour --rate-hz 1000 --drill "${with[@]}" >"$work/$run-$core.json" || [[ $run == dynamic ]]
    defmt-print -e "$(elf "$core")" <"$work/$run/$core/defmt.bin" >"$work/$run/$core/log.txt"
}
for run in first second dynamic; do
    mkdir -p "$work/$run"
    both compare "$run"
done
for core in "${cores[@]}"; do
    for file in frames.bin outputs.bin defmt.bin; do
        cmp "$work/first/$core/$file" "$work/second/$core/$file"
    done
    python3 - "$work/first-$core.json" "$work/first/$core/log.txt" <<'PYTHON'
import json, re, sys

[core] = json.load(open(sys.argv[1]))["cores"]
log = open(sys.argv[2]).read()
if not (core["equal"] and core["within_2_nm"] and core["cycles"] > 10000 and core["revolutions"]):
    sys.exit(f"found {core}, needed all cycles equal, double precision within 2 nm, and a revolution")
if core["exchange_at"] is None or f"in force from cycle {core['exchange_at']}" not in log:
    sys.exit(f"found no exchange of tables in:\n{log}")
if f"end: {core['cycles']} cycles, 0 overruns, 0 records dropped" not in log:
    sys.exit(f"found cycles that were late or not reported in:\n{log}")
grown, came = core["growth"], re.search(r"growth: (\d+) times in force, 0 late, 0 readings left out", log)
if not (came and int(came[1]) == grown["in_force"] >= 17 and grown["not_good"] >= 8 and grown["largest_um"] > 20):
    sys.exit(f"found growth {grown}, needed 17 times or more, with a sensor missing in 8, above 20 µm, and none late, in:\n{log}")
if "growth: sensor 1 Missing from row 9 on" not in log:
    sys.exit(f"found no sensor missing in:\n{log}")
begun = {int(code) for code in re.findall(r"fault (\d+) ", log)}
if begun != {fault["code"] for fault in core["faults"]} or len(begun) < 5:
    sys.exit(f"found faults {begun} in the log, needed those of the drill")
print(f"{core['core']}: {core['cycles']} cycles bit for bit as on the host; against double precision", core["against_double_nm"])
PYTHON
    python3 - "$work/dynamic-$core.json" <<'PYTHON'
import json, sys

[dynamic] = json.load(open(sys.argv[1]))["cores"]
if not (dynamic["equal"] and dynamic["cycles"] >= 6000):
    sys.exit(f"found {dynamic}, needed all cycles equal with dynamic correction")
print(f"{dynamic['core']}: {dynamic['cycles']} cycles with dynamic correction bit for bit as on the host")
PYTHON
    python3 sizes.py sizes.toml "$core" "$(elf "$core")" "$work/first/$core/log.txt"
done

say 'the recording that every host replays'
hosts=$repository/tests/hosts
for core in "${cores[@]}"; do
    timeout 900 "$simulator" compare --json --core "$core" "--image-$core" "$(elf "$core")" --output "$work/hosts" \
        --machine "$hosts/machine" --program "$hosts/path.ngc" --origin-mm 0,0,0 --rate-hz 1000 >"$work/hosts-$core.json" ||
        # Only the contour error may differ: near this path's corners single precision finds another foot.
        [[ $? == 1 ]]
    cmp "$work/hosts/recording.rec" "$on_host/hosts/run.rec"
    python3 - "$core" "$work/hosts-$core.json" "$on_host/hosts" <<'PYTHON'
import json, sys
from pathlib import Path

core, found, results = sys.argv[1], json.load(open(sys.argv[2])), Path(sys.argv[3])
[one] = found["cores"]
samples = 3 * one["cycles"]
assert one["equal"] and one["frames_damaged"] == one["frames_contradicting"] == 0, one


def result(host, **more):
    text = json.dumps({"host": host, "samples": samples, **more})
    (results / f"{host}.json").write_text(text + "\n")
    print(text)


# A cycle that differs anywhere counts with all of its axes.
result(core, same=samples - 3 * one["differing"], largest_mm=0.0)
if core == "m4f":
    result("m4f-double", same=None, largest_mm=1e-6 * one["against_double_nm"]["correction_max"])
PYTHON
done

say 'bad input'
bad=$work/bad
mkdir -p "$bad"
python3 refusals.py machines machine/machine.toml "$bad/machines"
compile() {
    "$trueaxis" tables compile "$1" -o "$bad/$2.tcomp" 2>>"$bad/compile.log"
}
compile machine good
compile "$repository/compensation-tables/mill-3axis" mill
compile "$bad/machines/wide" wide
compile "$bad/machines/points" points
grow machine "$bad/good.ttherm"
grow "$repository/compensation-tables/mill-3axis" "$bad/mill.ttherm"
"$simulator" record --machine machine --program short-tour --rate-hz 1000 --cycles 600 --exchange-at 100 -o "$bad/small.rec"
read -ra cases < <(python3 refusals.py make "$bad")
# Runs an image with the files of a folder, and leaves there its records and log: core, ELF, folder, where to
run() {
    local core=$1 elf=$2 inputs=$3 to=$4 board file flash=() code=0
    case $core in
        m4f) board=(-M mps2-an386 -cpu cortex-m4) ;;
        m7) board=(-M mps2-an500 -cpu cortex-m7) ;;
    esac
    mkdir -p "$to"
    for file in a.tcomp=0x00110000 b.tcomp=0x00140000 warming.bin=0x00178000 run.rec=0x00180000; do
        if [[ -f $inputs/${file%=*} ]]; then
            flash+=(-device "loader,file=${inputs//,/,,}/${file%=*},addr=${file#*=},force-raw=on")
        fi
    done
    timeout 600 qemu-system-arm "${board[@]}" -nographic -monitor none -serial "file:${to//,/,,}/frames.bin" \
        -serial "file:${to//,/,,}/outputs.bin" -icount shift=7,align=off,sleep=off \
        -semihosting-config enable=on,target=native -kernel "$elf" "${flash[@]}" >"$to/defmt.bin" || code=$?
    echo "$code" >"$to/exit"
    defmt-print -e "$elf" <"$to/defmt.bin" >"$to/log.txt"
}
refuse() {
    local core=$1 case
    for case in "${cases[@]}"; do
        run "$core" "$(elf "$core")" "$bad/$case" "$bad/$case/$core"
        python3 refusals.py check "$case" "$bad/$case" "$core"
    done
}
both refuse

say 'too little time'
run m4f "$(elf hurried)" "$bad/exchange" "$work/hurried"
python3 - "$work/hurried" <<'PYTHON'
import re, sys
from pathlib import Path

folder = Path(sys.argv[1])
log = (folder / "log.txt").read_text()
end = re.search(r"end: (\d+) cycles, (\d+) overruns, (\d+) records dropped", log)
cycles, overruns, dropped = map(int, end.groups()) if end else (0, 0, 0)
sent = (folder / "frames.bin").read_bytes().count(0)
if int((folder / "exit").read_text()) or not cycles == overruns == dropped + sent or not dropped:
    sys.exit(f"found {sent} records, needed every cycle counted as late, and as sent or dropped, in:\n{log}")
if not re.search(r"growth: 0 times in force, 0 late, [1-9]\d* readings left out", log):
    sys.exit(f"found no readings that the thermal task could not take, in:\n{log}")
print(f"{overruns} of {cycles} cycles late, {dropped} records dropped, {sent} sent: all counted")
PYTHON

say 'counts'
./count.sh
say 'longest path'
./longest_path.sh
if [[ -x proofs/run.sh ]]; then
    say 'proofs'
    proofs/run.sh
fi
say 'all good'
