#!/usr/bin/env bash
# Builds and installs the component, runs LinuxCNC with it as an ordinary user without a screen, and removes it again.
#
#   test.sh            all tests
#   test.sh NAME...    some of them (names: tests/checks.py, and interpreter)
#
# If run by root, installs LinuxCNC 2.9 from Debian. Takes some eight minutes. TRUEAXIS_KEEP=DIR keeps recordings in DIR.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

root=$(cd ../.. && pwd)
"$root/.ci/install" linuxcnc-uspace linuxcnc-uspace-dev gcc make
target=${CARGO_TARGET_DIR:-$root/target}
# Compares the simulator's G-code with LinuxCNC's own interpreter, posts' programs and random ones.
if [[ $# == 0 || " $* " == *' interpreter '* ]]; then
    (cd "$root" && TRUEAXIS_LINUXCNC=1 cargo test --quiet --workspace --test simulator linuxcnc::)
    if [[ $* == interpreter ]]; then exit; fi
fi
names=("$@")
for index in "${!names[@]}"; do
    if [[ ${names[index]} == interpreter ]]; then unset "names[index]"; fi
done
"$root/tests/hosts/recording.sh"

# The ordinary user may not be able to read this folder, so copy the files that the tests need.
work=$(mktemp -d /tmp/trueaxis-linuxcnc.XXXXXX)
user=
module=$(./install.sh --where)
clean_up() {
    if [[ -e $work/installed.so ]]; then
        install -m 0644 "$work/installed.so" "$module"
    else
        ./install.sh --uninstall >/dev/null
    fi
    rm -f "$(dirname "$module")"/{dahl,ballplate}.so
    if [[ -n $user ]]; then
        timeout 20 runuser -u "$user" -- halrun -U >/dev/null 2>&1 || true
        userdel "$user" 2>/dev/null || true
    fi
    rm -rf "$work"
}
trap clean_up EXIT
if [[ -e $module ]]; then cp "$module" "$work/installed.so"; fi
mkdir -p "$work/repository/integrations/linuxcnc" "$work/bin" "$work/runs"
cp -r tests config machines record-circles.py "$work/repository/integrations/linuxcnc"
cp -r "$root/compensation-tables" "$work/repository"
cp "$target/release/trueaxis" "$target/release/linuxcnc-recording" "$work/bin"
mkdir "$work/hosts"
cp "$target/hosts/machine.tcomp" "$target/hosts/run.csv" "$work/hosts"
chmod -R a+rX "$work"

./install.sh
# The drive with friction and the ball plate for the tests.
for name in dahl ballplate; do
    (cd "$work" && cp "repository/integrations/linuxcnc/tests/$name.comp" . && halcompile --install "$name.comp" >/dev/null)
done
# The realtime part may call only the library and memory functions: no allocation, no file, no print.
own='(steps|gauge|thermal|show)_[a-z_]+|pins_parts_off'
others=$(nm -u "$target/linuxcnc/"{cycle,steps,gauge,thermal,show}.o |
    grep -vE "^$|:$|U (trueaxis_[a-z_]+|$own|memset|memcpy|__stack_chk_fail|_GLOBAL_OFFSET_TABLE_)$" || true)
if [[ -n $others ]]; then
    printf 'test.sh: the realtime functions call %s\n' "$others" >&2
    exit 1
fi
# Builds the same source with headers like those of 2.10, which its Makefile detects. The HAL calls must then be those
# of 2.10.
rm -rf "$target/linuxcnc-2.10"
cp -r component "$target/linuxcnc-2.10"
make --silent -C "$target/linuxcnc-2.10" modules CC="gcc -I$PWD/tests/linuxcnc-2.10" \
    LIBRARY="$target/release/libtrueaxis_capi.a" INCLUDE="$root/crates/trueaxis-capi/include"
asked=$(nm -u "$target/linuxcnc-2.10/"*.o | grep -oE 'hal_(pin|param)_[a-z0-9_]+' | sort -u | paste -sd ' ')
if [[ $asked != 'hal_param_new_real hal_pin_new_bool hal_pin_new_real hal_pin_new_si32 hal_pin_new_ui32' ]]; then
    echo "test.sh: found $asked, needed only functions that LinuxCNC 2.10 does not deprecate" >&2
    exit 1
fi
as_user=(env -i)
if [[ $(id -u) == 0 ]]; then
    user=trueaxis-test
    id "$user" >/dev/null 2>&1 || useradd --system --no-create-home --shell /usr/sbin/nologin "$user"
    chown -R "$user" "$work/runs"
    as_user=(runuser -u "$user" -- env -i)
fi
(
    cd "$work"
    timeout --kill-after=20 1500 "${as_user[@]}" HOME="$work/runs" PATH=/usr/bin:/bin PYTHONDONTWRITEBYTECODE=1 \
        TRUEAXIS="$work/bin/trueaxis" TRUEAXIS_REPLAY="$work/bin/linuxcnc-recording" TRUEAXIS_HOSTS="$work/hosts" \
        /usr/bin/python3 "$work/repository/integrations/linuxcnc/tests/run.py" "$work/runs" "${names[@]}"
)
if [[ -e $work/runs/one_proof/linuxcnc.json ]]; then
    cp "$work/runs/one_proof/linuxcnc.json" "$target/hosts"
fi
if [[ -n ${TRUEAXIS_KEEP-} ]]; then
    mkdir -p "$TRUEAXIS_KEEP"
    cp -r "$work/runs/." "$TRUEAXIS_KEEP"
fi
./install.sh --uninstall
if [[ -e $module ]]; then
    echo "test.sh: found $module after install.sh --uninstall" >&2
    exit 1
fi
