#!/usr/bin/env bash
# Runs the C programs of the interface under the sanitizers of addresses, leaks, undefined behaviour (the C side) and
# threads; the Rust side, standard library included, is built with the same one by the nightly compiler. Each sanitizer has
# a planted defect that it must report. Installs what is missing.
#
#   sanitize.sh [address|thread]
#   sanitize.sh --quick                             address, leaks, undefined behaviour; the standard library as it is
#   sanitize.sh [--quick] --library address|thread  builds the library only, prints where it is
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

quick=
if [[ ${1-} == --quick ]]; then
    quick=quick-
    shift
fi
root=$(cd ../.. && pwd)
"$root/.ci/install" gcc libc6-dev python3 rustup:nightly:rust-src
target=${CARGO_TARGET_DIR:-$root/target}
out=$target/sanitize
mkdir -p "$out"
triple=x86_64-unknown-linux-gnu
first=$root/crates/trueaxis/mill-3axis.tcomp
second=$out/second.tcomp
five=$out/five.tcomp
make_tables() {
    # With the features of `cargo test --workspace`, so that nothing is built twice.
    (cd "$root" && CARGO_TARGET_DIR=$target cargo build --quiet --workspace --exclude trueaxis-fuzz --example halved_tables --example combinations)
    "$target/debug/examples/halved_tables" "$first" "$second"
    "$target/debug/examples/combinations" "$five" >"$out/combinations.rust"
}
export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:halt_on_error=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1

compile() { # sanitizer of both sides, name, source, further flags
    local sanitizer=$1 name=$2 source=$3 flags
    shift 3
    flags=(-fsanitize="$sanitizer")
    # Undefined behaviour is the C compiler's own matter: Rust's side of it is Miri's.
    [[ $sanitizer != address ]] || flags=(-fsanitize=address,undefined -fno-sanitize-recover=all)
    gcc -std=c11 -O1 -g -Wall -Wextra -Werror -Iinclude "${flags[@]}" "$@" "$source" \
        "$out/$quick$sanitizer.a" -lpthread -ldl -lm -o "$out/$sanitizer-$name"
}
library() { # sanitizer
    local std=()
    [[ -n $quick ]] || std=(-Zbuild-std=std)
    CARGO_TARGET_DIR=$out/$quick$1 RUSTFLAGS="-Zsanitizer=$1" \
        cargo +nightly build --quiet -p trueaxis-capi "${std[@]}" --target "$triple"
    cp "$out/$quick$1/$triple/debug/libtrueaxis_capi.a" "$out/$quick$1.a"
    [[ $1 == thread ]] || return 0
    # LLVM's names of what gcc's runtime has as its interceptors of the C functions.
    {
        echo '#include <string.h>'
        for name in memcpy memmove; do
            echo "__attribute__((weak)) void *__tsan_$name(void *to, const void *from, size_t n) { return $name(to, from, n); }"
        done
        echo '__attribute__((weak)) void *__tsan_memset(void *to, int byte, size_t n) { return memset(to, byte, n); }'
    } >"$out/names.c"
    gcc -O1 -fno-builtin -c "$out/names.c" -o "$out/names.o"
    ar r "$out/$1.a" "$out/names.o" 2>/dev/null
}
must_fail() { # words that must be in what it says, command
    local words=$1
    shift
    if timeout 120 "$@" >"$out/control.log" 2>&1 || ! grep -q "$words" "$out/control.log"; then
        echo "sanitize.sh: the planted defect was not found: needed '$words' of $*" >&2
        exit 1
    fi
    echo "planted defect found: $words"
}

address() {
    library address
    compile address step examples/c/step_trace.c
    compile address combinations examples/c/combinations.c
    timeout 120 "$out/address-step" "$first" "$second" | tee "$out/step.txt"
    timeout 120 "$out/address-combinations" "$five" >"$out/combinations.c"
    diff "$out/combinations.rust" "$out/combinations.c"
    # Damaged at a byte, cut short, empty: refused without a byte read beyond the end.
    python3 - "$first" "$out" <<'END'
import sys
data = open(sys.argv[1], "rb").read()
for name, bytes_ in (("flipped", data[:99] + bytes([data[99] ^ 1]) + data[100:]), ("cut", data[:-7]), ("empty", b"")):
    open(f"{sys.argv[2]}/{name}.tcomp", "wb").write(bytes_)
END
    for name in flipped cut empty; do timeout 120 "$out/address-step" "$out/$name.tcomp" "$second" | grep refused; done
    # The last eight bytes of the memory that the program says is there are not: the library writes beyond it.
    local needed
    needed=$(sed -n 's/.*memory \([0-9]*\) bytes$/\1/p' "$out/step.txt")
    sed "s/sizeof memory\[which\], &error/sizeof memory[which] + 8, \&error/; s/MEMORY_BYTES 65536/MEMORY_BYTES $((needed - 8))/" \
        examples/c/step_trace.c >"$out/overrun.c"
    compile address overrun "$out/overrun.c"
    must_fail 'AddressSanitizer: ' "$out/address-overrun" "$first" "$second"
    printf '#include <stdlib.h>\nvoid *volatile kept;\nint main(void) { kept = malloc(9); kept = 0; return 0; }\n' >"$out/leak.c"
    compile address leak "$out/leak.c"
    must_fail 'LeakSanitizer: detected memory leaks' "$out/address-leak"
    printf 'int main(void) { volatile int n = 1; n += 2147483647; return n != 0; }\n' >"$out/undefined.c"
    compile address undefined "$out/undefined.c"
    must_fail 'signed integer overflow' "$out/address-undefined"
}
thread() {
    library thread
    compile thread exchange tests/exchange_threads.c
    timeout 300 "$out/thread-exchange" "$first" "$second"
    compile thread race tests/exchange_threads.c -DRACE
    must_fail 'ThreadSanitizer: data race' "$out/thread-race" "$first" "$second"
}
case $quick${1-}${2+ $2} in
'')
    make_tables
    address
    thread
    ;;
address | thread)
    make_tables
    "$1"
    ;;
quick-)
    make_tables
    address
    ;;
'--library address' | '--library thread' | 'quick---library address')
    library "$2"
    echo "$out/$quick$2.a"
    ;;
*) sed -n '6,8s/^# *//p' "${BASH_SOURCE[0]##*/}" >&2; exit 2 ;;
esac
