#!/usr/bin/env bash
# Builds the shim against the headers of the host that will load it: build.sh KLIPPY_FOLDER LIBTRUEAXIS_CAPI.A OUT.SO
# SPDX-License-Identifier: GPL-3.0-or-later
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if (($# != 3)); then
    echo "usage: build.sh KLIPPY_FOLDER LIBTRUEAXIS_CAPI.A OUT.SO; found $# arguments" >&2
    exit 2
fi
klippy=$1 library=$2 out=$3
for name in itersolve trapq list; do
    [[ -f $klippy/chelper/$name.h ]] || { echo "build.sh: this version of the host has no chelper/$name.h in $klippy, which the shim needs" >&2; exit 1; }
done
headers=$(python3 -c 'import sys, zlib; crc = 0
for name in sys.argv[1:]: crc = zlib.crc32(open(name, "rb").read(), crc)
print(f"0x{crc:08x}u")' "$klippy"/chelper/{itersolve,trapq,list}.h)
gcc -std=gnu11 -O2 -Wall -Wextra -Wno-unused-parameter -Wno-sign-compare -fPIC -shared -fvisibility=hidden "-DTRUEAXIS_HEADERS=$headers" \
    "-I$klippy/chelper" "-I$here/../../crates/trueaxis-capi/include" "$here/shim/trueaxis_shim.c" "$library" \
    -Wl,--gc-sections,--exclude-libs,ALL -lpthread -ldl -lm -o "$out"
