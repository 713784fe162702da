#!/usr/bin/env bash
# Builds the component trueaxis and installs it beside LinuxCNC's own; --uninstall removes it.
#
#   install.sh              build and install (the module, its man page); calls sudo unless run by root
#   install.sh --build      build only; prints the path of trueaxis.so
#   install.sh --where      print the path of the installed module
#   install.sh --uninstall
#
# Needs LinuxCNC 2.9 or 2.10 with its development files (linuxcnc-uspace, linuxcnc-uspace-dev), gcc, make and cargo.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

manual=/usr/local/share/man/man9/trueaxis.9

as_root() {
    if [[ $(id -u) == 0 ]]; then "$@"; else sudo -- "$@"; fi
}

if ! command -v halcompile >/dev/null; then
    echo 'install.sh: found no halcompile; needed: the packages linuxcnc-uspace and linuxcnc-uspace-dev' >&2
    exit 1
fi
modinc=$(halcompile --print-modinc)
modules=$(sed -n 's/^RTLIBDIR *:= *\(.*linuxcnc.*\)$/\1/p' "$modinc" | tail -n 1)
if [[ ! -d $modules ]]; then
    echo "install.sh: found no module directory in $modinc ('$modules'); needed: that of an installed LinuxCNC" >&2
    exit 1
fi

# Installs a file atomically: writes it beside its destination, flushes it, renames it. LinuxCNC loads either the old or
# the new file, never a partial one.
place() {
    as_root install -D -m 0644 "$1" "$2.trueaxis-tmp"
    as_root sync "$2.trueaxis-tmp"
    as_root mv -f "$2.trueaxis-tmp" "$2"
    as_root sync "$(dirname "$2")"
}

build() {
    local root target
    root=$(cd ../.. && pwd)
    target=${CARGO_TARGET_DIR:-$root/target}
    (cd "$root" && cargo build --quiet --release --package trueaxis-cli --package trueaxis-capi)
    build=$target/linuxcnc
    mkdir -p "$build"
    cp component/*.c component/*.h component/Makefile "$build"
    make --silent -C "$build" modules MODINC="$modinc" \
        LIBRARY="$target/release/libtrueaxis_capi.a" INCLUDE="$root/crates/trueaxis-capi/include"
}

case ${1-} in
--where)
    echo "$modules/trueaxis.so"
    ;;
--uninstall)
    as_root rm -f "$modules/trueaxis.so" "$manual" "$modules/trueaxis.so.trueaxis-tmp" "$manual.trueaxis-tmp"
    echo "removed $modules/trueaxis.so"
    ;;
--build)
    build
    echo "$build/trueaxis.so"
    ;;
'')
    build
    place "$build/trueaxis.so" "$modules/trueaxis.so"
    place trueaxis.9 "$manual"
    echo "installed $modules/trueaxis.so"
    ;;
*)
    sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]##*/}" >&2
    exit 2
    ;;
esac
