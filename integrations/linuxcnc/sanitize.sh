#!/usr/bin/env bash
# Runs the component under sanitizers for addresses, leaks, undefined behaviour and threads, with the library built with the
# same sanitizer: in one process, on a double of HAL (tests/sanitize), with attacks on every input, files exchanged and
# damaged in operation, and HAL calls failing one at a time. Each sanitizer must report some planted defects.
#
#   sanitize.sh
#   sanitize.sh --quick    addresses, leaks and undefined behaviour; fewer cycles; Rust's standard library not instrumented
#
# The component is built with the headers of LinuxCNC 2.9 and, for the address sanitizer, also with a double of those of 2.10
# (tests/linuxcnc-2.10). Both must give the same outputs, bit for bit.
#
# If run by root, installs LinuxCNC's headers from Debian.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

bursts=100 every=5 quick=()
case ${1-} in
'') ;;
--quick) bursts=10 every=29 quick=(--quick) ;;
*) sed -n "6,7s/^# *//p" "${BASH_SOURCE[0]##*/}" >&2; exit 2 ;;
esac
root=$(cd ../.. && pwd)
"$root/.ci/install" linuxcnc-uspace-dev gcc libc6-dev
target=${CARGO_TARGET_DIR:-$root/target}
out=$target/linuxcnc-sanitize
mkdir -p "$out"
library=$root/crates/trueaxis-capi/sanitize.sh
"$root/.ci/commands"
tables() { # name, machine
    "$target/release/trueaxis" tables compile "$2" -o "$out/$1.tcomp" >"$out/$1.txt" 2>&1
}
tables mill "$root/compensation-tables/mill-3axis/machine.toml"
for name in stream gantry gauge trt; do tables "$name" "machines/$name/machine.toml"; done
for name in left right; do tables "$name" "machines/gantry/$name.toml"; done
# The same machine with larger errors, whose tables replace the first ones.
rm -rf "$out/other"
cp -r machines/gantry "$out/other"
sed -i 's/^C0Y_urad = .*/C0Y_urad = 30.0/' "$out/other/machine.toml"
tables other "$out/other/machine.toml"

export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:halt_on_error=1
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 TSAN_OPTIONS=halt_on_error=1
build_library() { # sanitizer
    built=$("$library" "${quick[@]}" --library "$1")
}
hal=()
compile() { # sanitizer of the library that was built last, program, folder of the component
    local flags=(-fsanitize="$1")
    [[ $1 != address ]] || flags=(-fsanitize=address,undefined -fno-sanitize-recover=all)
    # The flags in LinuxCNC's Makefile.modinc that affect the code.
    gcc -std=gnu11 -O1 -g -Wall -Wextra -Werror -fPIC -DRTAPI -DUSPACE -DSIM -D_GNU_SOURCE -Drealtime -D__MODULE__ \
        -fno-fast-math -fno-builtin-sin -fno-builtin-cos "${hal[@]}" -I/usr/include/linuxcnc \
        -I"$root/crates/trueaxis-capi/include" -I"$3" "${flags[@]}" "$3"/*.c tests/sanitize/*.c "$built" -lpthread -ldl -lm -o "$out/$2"
}
period=1000000 # of the threads, ns
drive() { # program, cycles, call of HAL that fails, words of loadrt, files to exchange
    local program=$1 cycles=$2 fails=$3
    shift 3
    timeout 300 "$out/$program" "$cycles" 1 "$fails" "$period" "$@"
}
gantry=(units=mm tables="$out/live.tcomp" joints=XYYZ joint_tables="1=$out/left.tcomp,2=$out/right.tcomp")
exchanged=(-- "$out/gantry.tcomp" "$out/other.tcomp" "$out/mill.tcomp")
put_gantry() {
    rm -rf "$out/live.tcomp"
    cp "$out/gantry.tcomp" "$out/live.tcomp"
}
run_gantry() { # program, cycles
    put_gantry
    drive "$1" "$2" 0 "${gantry[@]}" "${exchanged[@]}"
}
must_fail() { # name, sanitizer, words needed, file of the component, change of it
    local name=$1 sanitizer=$2 words=$3 file=$4 change=$5
    rm -rf "$out/$name.c"
    cp -r component "$out/$name.c"
    sed -i "$change" "$out/$name.c/"$file
    if diff -rq component "$out/$name.c" >/dev/null; then
        echo "sanitize.sh: found nothing to change by '$change' in $file, needed a planted defect" >&2
        exit 1
    fi
    compile "$sanitizer" "$name" "$out/$name.c"
    # Leave out function names, because looking them up takes longer than the program runs.
    if ASAN_OPTIONS="$ASAN_OPTIONS:symbolize=0" run_gantry "$name" 4000 >"$out/$name.log" 2>&1 ||
        ! grep -q "$words" "$out/$name.log"; then
        echo "sanitize.sh: the planted defect '$name' was not found: needed '$words', see $out/$name.log" >&2
        exit 1
    fi
    echo "planted defect found: $name, $words"
}

machines() { # sanitizer of the library that was built last, program
    local cycles=$((200 * bursts))
    compile "$1" "$2" component
    run_gantry "$2" "$cycles"
    {
        drive "$2" "$cycles" 0 units=mm names=left,right tables="$out/stream.tcomp,$out/gantry.tcomp" joints=XYZ,XYYZ \
            joint_tables="right:1=$out/left.tcomp"
        drive "$2" "$cycles" 0 tables="$out/gauge.tcomp" inch=1
        drive "$2" "$cycles" 0 tables="$out/trt.tcomp" units=mm angular_units=degree
        # The thread's period differs from the stated one.
        drive "$2" 200 0 units=mm tables="$out/mill.tcomp" servo_period_nsec=500000
        # The thread's period differs, but its lower 32 bits equal the stated one.
        period=4295967296 drive "$2" 2000 0 units=mm tables="$out/mill.tcomp"
        period=-4293967296 drive "$2" 2000 0 units=mm tables="$out/mill.tcomp"
    } >"$out/$2.txt" || { cat "$out/$2.txt"; return 1; }
    cat "$out/$2.txt"
}
refused() { # words of loadrt
    local result=0
    drive address 200 0 "$@" >"$out/refused.txt" || result=$?
    [[ $result == 3 ]] || { cat "$out/refused.txt"; echo "sanitize.sh: $*: found result $result, needed 3" >&2; exit 1; }
}

build_library address
machines address address
hal=(-DTRUEAXIS_HAL_HANDLES -Itests/linuxcnc-2.10)
machines address handles
hal=()
# The two differ only in how they create a pin and its value, so the counts of HAL calls differ.
diff <(grep digest "$out/address.txt") <(grep digest "$out/handles.txt")
echo 'against 2.9 and against the double of 2.10: the same outputs'
head -c 3000 "$out/mill.tcomp" >"$out/cut.tcomp"
refused tables="$out/mill.tcomp"
refused tables="$out/mill.tcomp" units=mm inch=1
refused tables="$out/trt.tcomp" units=mm
refused count=5 tables=x
refused units=mm tables="$out/cut.tcomp"
refused units=mm tables="$out/none.tcomp"
refused units=mm tables="$(printf '%01024d' 7)"
refused units=mm names="$(printf '%022d' 7)" tables="$out/mill.tcomp"
refused units=mm tables="$out/mill.tcomp" joints=XYZABCXYZA
refused units=mm tables="$out/mill.tcomp" joints=XXYYZZABC
refused units=mm tables="$out/mill.tcomp" joints=XYZ joint_tables="9=$out/left.tcomp"
refused units=mm tables="$out/gantry.tcomp" joints=XYYZ joint_tables="1=$out/mill.tcomp"
# Makes the first seven HAL calls, and then every so many of the others, fail in one run each.
put_gantry
calls=$(drive address 2000 0 "${gantry[@]}" | sed -n 's/ calls of HAL.*//p')
for ((n = 1; n <= calls; n += n < 8 ? 1 : every)); do
    result=0
    drive address 200 "$n" "${gantry[@]}" >"$out/fails.txt" || result=$?
    [[ $result == 3 ]] || { echo "sanitize.sh: call $n of HAL fails: found result $result, needed 3" >&2; exit 1; }
done
echo "of $calls calls of HAL the first seven and every ${every}th of the others failed, one in each run"
must_fail short-memory address 'AddressSanitizer: heap-buffer-overflow' pins.c 's/hal_malloc(sizeof \*pins)/hal_malloc(sizeof pins)/'
must_fail late-thread address 'AddressSanitizer: heap-use-after-free' reload.c '/pthread_join(thread, NULL);/d; /atomic_store(&ending, true);/d'
must_fail wide-shift address 'shift exponent' show.c 's/record->limited >> a/record->limited >> (a + 31)/'
# A handle that is dereferenced instead of read must not compile against 2.10.
sed 's/hal_get_bool(p->alarm)/*p->alarm/' component/steps.c >"$out/followed.c"
if gcc -std=gnu11 -c -DRTAPI -DUSPACE -DTRUEAXIS_HAL_HANDLES -Itests/linuxcnc-2.10 -I/usr/include/linuxcnc -Icomponent \
    -I"$root/crates/trueaxis-capi/include" "$out/followed.c" -o "$out/followed.o" 2>/dev/null; then
    echo 'sanitize.sh: found that a handle can be followed on 2.10, needed a refusal' >&2
    exit 1
fi
[[ ${#quick[@]} == 0 ]] || exit 0
build_library thread
machines thread thread
must_fail loose-order thread 'ThreadSanitizer: data race' '*.c' 's/memory_order_\(release\|acquire\|acq_rel\)/memory_order_relaxed/'
