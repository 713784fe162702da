#!/usr/bin/env python3
"""Flash and RAM of an image against committed sizes: size.py sizes.toml IMAGE ELF

Flash holds every allocated section that has contents, the initial values of variables among them; RAM every writable
one, without the stack. Fails (exit 1) where a size is above the committed one by more than 0.5 %.

    [[size]]
    image = "m4f"
    flash = 123456
    ram = 4096
"""

import struct
import sys
import tomllib

GROWTH = 1.005
NOBITS, WRITE, ALLOCATED = 8, 1, 2


def sections(path):
    """(name, type, flags, size) of a 32-bit little-endian ELF."""
    data = open(path, "rb").read()
    if data[:6] != b"\x7fELF\x01\x01":
        sys.exit(f"{path}: found {data[:6]!r}, needed a 32-bit little-endian ELF")
    start = struct.unpack_from("<I", data, 0x20)[0]
    entry, count, names = struct.unpack_from("<HHH", data, 0x2E)
    headers = [struct.unpack_from("<10I", data, start + i * entry) for i in range(count)]
    for header in headers:
        name = headers[names][4] + header[0]
        yield data[name : data.index(b"\0", name)].decode(), header[1], header[2], header[5]


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    committed_path, image, elf = sys.argv[1:]
    flash = ram = 0
    for name, kind, flags, size in sections(elf):
        if flags & ALLOCATED and size:
            flash += size if kind != NOBITS else 0
            ram += size if flags & WRITE else 0
    sizes = tomllib.load(open(committed_path, "rb"))["size"]
    committed = next((s for s in sizes if s["image"] == image), None)
    if committed is None:
        print(f"{image}: flash {flash}, RAM {ram} bytes; not in {committed_path}")
        return 1
    failed = False
    for what, measured in (("flash", flash), ("ram", ram)):
        grew = measured > committed[what] * GROWTH
        failed |= grew
        print(f"{what:26} {image:4} {measured:9} {'-':>9} {committed[what]:9} {'-':>7}  {'GREW' if grew else ''}".rstrip())
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
