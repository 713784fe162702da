#!/usr/bin/env bash
# Builds the plugin against the double of grblHAL's core for the host, for Cortex-M4F (single precision) and for
# Cortex-M7 (double precision), and runs its tests on all three (under QEMU). Compares the planned moves with the exact
# machine, tries tables that must be refused, and compares cost and size with figures.toml (`test.sh --commit` writes
# it).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

mcu=thumbv7em-none-eabihf
root=$(cd ../.. && pwd)
"$root/.ci/install" "rustup:target:$mcu" gcc libc6-dev python3 qemu-system-arm gcc-arm-none-eabi libnewlib-arm-none-eabi
target=${CARGO_TARGET_DIR:-$root/target}
out=$target/grblhal
mkdir -p "$out"
export CARGO_TARGET_DIR=$target

# The three-axis libraries for the microcontrollers are built where the tests of the C interface build theirs, the small one
# where flash is measured.
"$root/tests/hosts/recording.sh"
library() { # folder, profile, name, further arguments of cargo
    local folder=$target/$1 profile=$2 name=$3
    shift 3
    CARGO_TARGET_DIR=$folder cargo rustc --quiet --lib --crate-type staticlib --profile "$profile" -p trueaxis-capi --target "$mcu" "$@"
    cp "$folder/$mcu/$profile/libtrueaxis_capi.a" "$out/$name.a"
}
library capi-mcu image m4f --features single,three
CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS='-Ctarget-cpu=cortex-m7' library capi-mcu image m7 --features fp64,three
trueaxis=$target/release/trueaxis

# Tables for the tests: good ones, and some that must be refused.
python3 tests/tables.py "$root/compensation-tables/mill-3axis" "$out"
for machine in mill kinked lost beside nine; do
    "$trueaxis" tables compile "$out/$machine" -o "$out/$machine.tcomp" 2>"$out/compile.log" || { cat "$out/compile.log" >&2; exit 1; }
done
"$trueaxis" tables compile "$root/compensation-tables/mill-5axis" -o "$out/five.tcomp" 2>"$out/compile.log"
python3 - "$out" <<'PYTHON'
import sys
from pathlib import Path

out = Path(sys.argv[1])
data = (out / "mill.tcomp").read_bytes()
(out / "damaged.tcomp").write_bytes(data[:5000] + bytes([data[5000] ^ 1]) + data[5001:])
(out / "cut.tcomp").write_bytes(data[:5000])
(out / "erased.tcomp").write_bytes(b"\xff" * 4096)
PYTHON

board=$root/crates/trueaxis-capi/examples/c/cortex-m
flags=(-std=c11 -O2 -Wall -Wextra -Werror -ffp-contract=off -ffunction-sections -fdata-sections
    "-I$root/crates/trueaxis-capi/include" -Icorrection -Idouble -Iplugin)
plugin=(correction/trueaxis_correction.c plugin/*.c)

# Builds a program for host, m4f or m7. Arguments: target, name, tables, then sources and flags. Writes
# $out/NAME-TARGET.elf.
build() {
    local core=$1 name=$2 tables=$3
    shift 3
    local all=("${flags[@]}" "-DTRUEAXIS_TABLES=\"$out/$tables.tcomp\"" tables.S double/core.c "$@")
    case $core in
    host)
        cc "${all[@]}" "$target/release/libtrueaxis_capi.a" -Wl,--gc-sections -lpthread -ldl -lm -o "$out/$name-host.elf"
        return
        ;;
    m4f) all+=(-mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -DTRUEAXIS_SINGLE) ;;
    m7) all+=(-mcpu=cortex-m7 -mfpu=fpv5-d16) ;;
    esac
    arm-none-eabi-gcc "${all[@]}" -mthumb -mfloat-abi=hard '-DFIRST="/dev/null"' '-DSECOND="/dev/null"' "$board/startup.c" \
        "$out/$core.a" --specs=rdimon.specs -nostartfiles "-T$board/mps2.ld" \
        -Wl,--gc-sections,-z,noexecstack,--no-warn-rwx-segments -lm -o "$out/$name-$core.elf"
}
run() { # for, name: its output to $out/NAME-FOR.txt
    case $1 in
    host) timeout 300 "$out/$2-host.elf" ;;
    m4f) qemu mps2-an386 cortex-m4 "$out/$2-m4f.elf" ;;
    m7) qemu mps2-an500 cortex-m7 "$out/$2-m7.elf" ;;
    esac >"$out/$2-$1.txt" || { tail -5 "$out/$2-$1.txt" >&2; exit 1; }
}
qemu() {
    timeout 600 qemu-system-arm -M "$1" -cpu "$2" -nographic -monitor none -serial none \
        -icount shift=7,align=off,sleep=off -semihosting-config enable=on,target=native -kernel "$3"
}

for core in host m4f m7; do
    build "$core" mill mill "${plugin[@]}" tests/tests.c
    build "$core" kinked kinked "${plugin[@]}" tests/tests.c -DMOVES_ONLY
    for tables in mill kinked; do
        run "$core" "$tables"
        grep -vE '^(steps|line|rapid|block) ' "$out/$tables-$core.txt" | sed "s/^/$tables, $core: /"
    done
done
build host fourth mill "${plugin[@]}" tests/tests.c -DN_AXIS=4
run host fourth
python3 tests/checks.py "$trueaxis" "$out/mill" "$out"/mill-{host,m4f,m7}.txt
python3 tests/checks.py "$trueaxis" "$out/kinked" "$out"/kinked-{host,m4f,m7}.txt

# Dropped queues, parking and limits, on a machine with lost motion. Under QEMU, which executes every step, there are
# fewer of them.
for core in host m4f m7; do
    [[ $core == host ]] && less=() || less=(-DSEQUENCES=3 -DFINEST=400.0f)
    build "$core" dropped lost "${plugin[@]}" tests/dropped.c ${less[@]+"${less[@]}"}
    run "$core" dropped
    sed "s/^/dropped, $core: /" "$out/dropped-$core.txt"
done

# Replays the recording common to all hosts: the motors' positions after rapids to every tenth command.
cp "$target/hosts/machine.tcomp" "$out/hosts.tcomp"
python3 - "$target/hosts/run.csv" "$out/points.csv" <<'PYTHON'
import csv, sys

with open(sys.argv[1]) as given, open(sys.argv[2], "w") as points:
    # Start from the second command, because the first cycle sends its command unchanged.
    for row in list(csv.DictReader(given))[1::10]:
        if row["limited"] == row["fault"] == "0":
            points.write(",".join(row[f"{axis}_{of}_mm"] for of in ("cmd", "drive") for axis in "xyz") + "\n")
PYTHON
for core in host m4f m7; do
    build "$core" replay hosts "${plugin[@]}" tests/replay.c "-DPOINTS=\"$out/points.csv\""
    run "$core" replay
    sed "s/^/replay, $core: positions, largest difference mm: /" "$out/replay-$core.txt"
done
cat "$out"/replay-{host,m4f,m7}.txt | awk '{ samples += $1; if ($2 > largest) largest = $2 }
    END { printf "{\"host\": \"grblhal\", \"samples\": %d, \"same\": null, \"largest_mm\": %g}\n", samples, largest }' >"$target/hosts/grblhal.json"

# Each refusal is reported in one line before anything moves, and the machine runs as without the plugin.
refused() { # core, name, message; tables and flags
    local core=$1 name=$2 told=$3
    shift 3
    build "$core" "$name" "$@" "${plugin[@]}" tests/refused.c
    run "$core" "$name"
    printf '[MSG:Warning: trueaxis: %s; running uncompensated]\r\n[TRUEAXIS:uncompensated, %s]\r\nmoved, 1 block to -48000 -32000 -24000\n' \
        "$told" "$told" >"$out/needed.txt"
    diff "$out/needed.txt" "$out/$name-$core.txt"
    head -1 "$out/$name-$core.txt"
}
for core in host m4f; do
    refused "$core" damaged 'table file: the file is damaged (its CRC-32 is wrong)' damaged
    refused "$core" cut 'table file: the file is shorter than its header says' cut
    refused "$core" erased 'table file: not a compiled table file (it does not start with TRUEAXIS)' erased
    refused "$core" foreign 'table file: the file was made for another machine' mill -DTRUEAXIS_MACHINE_ID=0x12345678u
    refused "$core" five 'the tables are for axes XYZAC, the controller has XYZ' five
    refused "$core" small "memory: found 8192 bytes, needed $([[ $core == m4f ]] && echo 24336 || echo 48672) bytes" mill -DTRUEAXIS_MEMORY_BYTES=8192
    refused "$core" beside "the tables' travel of X has nothing in common with the machine's" beside
    refused "$core" header 'header and library differ in version or precision' mill -DTRUEAXIS_ABI_MAJOR=9
done

# The core's own tool centre point control would remove the correction in the middle of a program.
if cc "${flags[@]}" -DRTCP_AC=1 -fsyntax-only plugin/trueaxis_kinematics.c 2>"$out/rtcp_ac.log" ||
    ! grep 'trueaxis cannot wrap RTCP_AC' "$out/rtcp_ac.log"; then
    echo "test.sh: found that the plugin builds with RTCP_AC, needed a refusal, see $out/rtcp_ac.log" >&2
    exit 1
fi

# A part with 256 KiB of flash and 64 KiB of RAM: nine terms, contour error against lines, records.
library flash flash small --no-default-features --features single,three
arm-none-eabi-gcc "${flags[@]}" "-DTRUEAXIS_TABLES=\"$out/nine.tcomp\"" -DTRUEAXIS_MEMORY_BYTES=6656 -DBLOCKS=36 -DTRUEAXIS_SINGLE \
    -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mthumb -mfloat-abi=hard tables.S double/core.c "${plugin[@]}" tests/small.c \
    "$board/startup.c" "$out/small.a" --specs=rdimon.specs -nostartfiles \
    -Ttests/small.ld -Wl,--gc-sections,-z,noexecstack,--no-warn-rwx-segments -lm -o "$out/part256-m4f.elf"
run m4f part256
arm-none-eabi-size "$out/part256-m4f.elf" |
    awk 'NR > 1 { print "flash " $1 + $2 " of 262144 bytes, static RAM " $2 + $3 " of 65536" }' >>"$out/part256-m4f.txt"
sed 's/^/256 kB, m4f: /' "$out/part256-m4f.txt"

# Cost and size; the size is that of an image with the plugin minus one without it.
for core in m4f m7; do
    build "$core" cost mill "${plugin[@]}" tests/cost.c
    run "$core" cost
    build "$core" with mill "${plugin[@]}" tests/refused.c
    build "$core" without mill tests/without.c tests/refused.c
    arm-none-eabi-size "$out/with-$core.elf" "$out/without-$core.elf" |
        awk -v tables="$(stat -c %s "$out/mill.tcomp")" 'NR > 1 { text[NR] = $1 + $2; ram[NR] = $2 + $3 }
            END { print "flash " text[2] - text[3] - tables; print "ram " ram[2] - ram[3] }' >>"$out/cost-$core.txt"
done
exec python3 tests/figures.py "$@" figures.toml "m4f=$out/cost-m4f.txt" "m7=$out/cost-m7.txt"
