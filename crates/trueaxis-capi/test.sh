#!/usr/bin/env bash
# Builds the C example with the system's compiler and into images for a Cortex-M4F (single precision) and a Cortex-M7
# (double precision), runs all of them (the images in QEMU), and holds their results against each other. Installs what is
# missing where root may.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

mcu=thumbv7em-none-eabihf
root=$(cd ../.. && pwd)
"$root/.ci/install" "rustup:target:$mcu" gcc libc6-dev g++ python3 qemu-system-arm gcc-arm-none-eabi libnewlib-arm-none-eabi
target=${CARGO_TARGET_DIR:-$root/target}
out=$target/capi
mkdir -p "$out"
export CARGO_TARGET_DIR=$target

# The library: host, Cortex-M4F (for three axes, as grblHAL's plugin links it), Cortex-M7. Both are built in one folder, so
# that what runs on the host is built once.
"$root/.ci/commands"
host=$target/release/libtrueaxis_capi.a
thumb() { # name, further arguments of cargo
    local name=$1
    shift
    CARGO_TARGET_DIR=$target/capi-mcu cargo rustc --quiet --lib --crate-type staticlib --profile image -p trueaxis-capi --target "$mcu" "$@"
    cp "$target/capi-mcu/$mcu/image/libtrueaxis_capi.a" "$out/$name.a"
}
thumb m4f --features single,three
CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS='-Ctarget-cpu=cortex-m7' thumb m7 --features fp64

# Tables: the sample machine's, the same with half the errors, and a damaged file.
first=$root/crates/trueaxis/mill-3axis.tcomp
second=$out/second.tcomp
damaged=$out/damaged.tcomp
# With the features of `cargo test --workspace`, so that nothing is built twice.
(cd "$root" && cargo build --quiet --workspace --exclude trueaxis-fuzz --example halved_tables --example combinations --example tables_of_parts)
"$target/debug/examples/halved_tables" "$first" "$second"
python3 - "$first" "$damaged" <<'END'
import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[len(data) // 2] ^= 1
open(sys.argv[2], "wb").write(data)
END

# FMA would round once where the host rounds twice.
strict=(-O2 -Wall -Wextra -Wpedantic -Werror -ffp-contract=off -Iinclude)
source=examples/c/step_trace.c

on_host() { # name, first tables, further flags; text to $out/NAME.txt
    local name=$1 tables=$2
    shift 2
    cc -std=c99 "${strict[@]}" "$@" "$source" "$host" -Wl,--gc-sections -lpthread -ldl -lm -o "$out/$name"
    timeout 300 "$out/$name" "$tables" "$second" >"$out/$name.txt"
}
in_qemu() { # name, core (m4f or m7), first tables, further flags
    local name=$1 core=$2 tables=$3 board cpu flags
    shift 3
    case $core in
    m4f) board=mps2-an386 cpu=cortex-m4 flags=(-mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -DTRUEAXIS_SINGLE) ;;
    m7) board=mps2-an500 cpu=cortex-m7 flags=(-mcpu=cortex-m7 -mfpu=fpv5-d16) ;;
    esac
    arm-none-eabi-gcc -std=c99 "${strict[@]}" "${flags[@]}" -mthumb -mfloat-abi=hard -ffunction-sections -DBARE_METAL "$@" \
        "-DFIRST=\"$tables\"" "-DSECOND=\"$second\"" "$source" examples/c/cortex-m/startup.c examples/c/cortex-m/tables.S \
        "$out/$core.a" \
        --specs=rdimon.specs -nostartfiles -Texamples/c/cortex-m/mps2.ld -Wl,--gc-sections,-z,noexecstack -o "$out/$name.elf"
    timeout 600 qemu-system-arm -M "$board" -cpu "$cpu" -nographic -monitor none -serial none \
        -semihosting-config enable=on,target=native -kernel "$out/$name.elf" >"$out/$name.txt"
}

on_host host "$first"
in_qemu m4f m4f "$first"
in_qemu m7 m7 "$first"
# Refused: damaged tables, too little memory, a header of another version.
on_host host-damaged "$damaged"
on_host host-memory "$first" -DMEMORY_BYTES=8192
on_host host-abi "$first" -DTRUEAXIS_ABI_MAJOR=9
for core in m4f m7; do
    in_qemu "$core-damaged" "$core" "$damaged"
    in_qemu "$core-abi" "$core" "$first" -DTRUEAXIS_ABI_MAJOR=9
done

# Every measure with and without a gauge: the sums of the C program are those of the Rust interface.
"$target/debug/examples/combinations" "$out/five.tcomp" >"$out/combinations.rust"
cc -std=c99 "${strict[@]}" examples/c/combinations.c "$host" -Wl,--gc-sections -lpthread -ldl -lm -o "$out/combinations"
timeout 300 "$out/combinations" "$out/five.tcomp" >"$out/combinations.c"
cat "$out/combinations.c"
diff "$out/combinations.rust" "$out/combinations.c"
if [[ $(sed 's/.*: //' "$out/combinations.c" | sort -u | wc -l) != 8 ]]; then
    echo 'test.sh: found combinations of the same sum, needed eight different ones' >&2
    exit 1
fi

# The recording that every host replays: drive positions are the library's to the last bit.
"$root/tests/hosts/recording.sh"
cc -std=c99 "${strict[@]}" examples/c/replay.c "$host" -Wl,--gc-sections -lpthread -ldl -lm -o "$out/replay"
timeout 300 "$out/replay" "$target/hosts/machine.tcomp" "$target/hosts/run.csv" | tee "$target/hosts/c.json"

# Without its parts the library refuses what needs them, by numbers, or by name in a build with texts. With the parts that
# the recording needs, it replays to the same bit.
"$target/debug/examples/tables_of_parts" "$out"
parts=$target/capi-parts/debug/libtrueaxis_capi.a
part_library() { # features
    CARGO_TARGET_DIR=$target/capi-parts cargo rustc --quiet -p trueaxis-capi --lib --crate-type staticlib \
        --no-default-features --features "$1"
}
left_out() { # files; what is refused to $out/left_out.txt
    cc -std=c99 "${strict[@]}" examples/c/left_out.c "$parts" -Wl,--gc-sections -lpthread -ldl -lm -o "$out/left_out"
    timeout 60 "$out/left_out" "${@/#/$out/}" | tee "$out/left_out.txt"
}
part_library ''
left_out {grids,volumetric,rotary,dynamic,gauge}.tcomp
code=0
for part in grids volumetric rotary dynamic gauge; do
    code=$((code + 1))
    grep -Eq "^$part.tcomp: code $code, field #[0-9]+, $" "$out/left_out.txt"
done
part_library text,volumetric
left_out {grids,rotary,dynamic,gauge}.tcomp
for part in grids rotary dynamic gauge; do
    grep -q "^$part.tcomp: code [1-6], field [A-Z].* needs the part $part, which this build leaves out$" "$out/left_out.txt"
done
cc -std=c99 "${strict[@]}" examples/c/replay.c "$parts" -Wl,--gc-sections -lpthread -ldl -lm -o "$out/replay_parts"
timeout 300 "$out/replay_parts" "$target/hosts/machine.tcomp" "$target/hosts/run.csv" | diff "$target/hosts/c.json" -

# The example of the README compiles.
{
    printf '#define AXES 3\n#include <string.h>\n#include "trueaxis.h"\nvoid log_line(const char *);\n'
    printf 'void point_of_path(double, double *);\n'
    printf 'void read_machine(double *, double *, uint8_t *, uint8_t *);\nvoid write_drives(const double *);\n'
    printf 'void start(const uint8_t *, size_t);\nvoid servo_interrupt(void);\n'
    sed -n '/^```c$/,/^```$/{/^```/d;p}' README.md
} >"$out/readme.c"
cc -std=c99 "${strict[@]}" -c "$out/readme.c" -o "$out/readme.o"

# The program of docs/embed/c.md prints the lines shown there.
cc -std=c99 "${strict[@]}" examples/c/first_cycle.c "$host" -Wl,--gc-sections -lpthread -ldl -lm -o "$out/first_cycle"
timeout 60 "$out/first_cycle" "$first" >"$out/first_cycle.txt"
diff <(sed -n 's/^    \(X commanded \)/\1/p' "$root/docs/embed/c.md") "$out/first_cycle.txt"

# The header from C++.
printf '#include "trueaxis.h"\nint main() { return trueaxis_check_abi(TRUEAXIS_ABI_VERSION); }\n' >"$out/header.cpp"
c++ -std=c++11 "${strict[@]}" "$out/header.cpp" "$host" -Wl,--gc-sections -lpthread -ldl -o "$out/header"
timeout 60 "$out/header"

arm-none-eabi-size "$out/m4f.elf" "$out/m7.elf"
exec python3 test.py "$out"
