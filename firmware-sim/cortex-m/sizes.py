"""Compares an image's flash, memory and stack with sizes.toml: sizes.py sizes.toml CORE ELF LOG"""

import re
import struct
import sys
import tomllib
from pathlib import Path

RAM = 0x2000_0000
EMPTY, ALLOCATED = 8, 2
# A committed figure that exceeds the measured one by more than this is too loose a limit.
STALE = 0.95


def sections(elf):
    (offset,) = struct.unpack_from("<I", elf, 32)
    size, count = struct.unpack_from("<HH", elf, 46)
    for i in range(count):
        _, kind, flags, address, _, length = struct.unpack_from("<6I", elf, offset + i * size)
        if flags & ALLOCATED:
            yield kind, address, length


def main(limits, core, elf, log):
    limits = tomllib.loads(Path(limits).read_text())[core]
    parts = list(sections(Path(elf).read_bytes()))
    stack = re.search(r"stack of the servo interrupt: (\d+) bytes on entry, (\d+) bytes of the step", Path(log).read_text())
    if not stack:
        sys.exit(f"{log}: found no line about the stack")
    found = {
        "flash": sum(length for kind, _, length in parts if kind != EMPTY),
        "ram": sum(length for _, address, length in parts if address >= RAM),
        "stack_on_entry": int(stack[1]),
        "stack_of_step": int(stack[2]),
    }
    wrong = False
    for name, bytes_ in found.items():
        limit = limits[name]
        bad = not STALE * limit <= bytes_ <= limit
        wrong |= bad
        print(f"{core} {name}: {bytes_} bytes of {limit}{'  <-- not the committed figure' if bad else ''}")
    if wrong:
        sys.exit("sizes.toml: needed figures that the image keeps to, at most 5 % above the measured ones")


main(*sys.argv[1:])
