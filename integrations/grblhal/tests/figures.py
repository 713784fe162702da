"""Compares cost and size with figures.toml: figures.py [--commit] figures.toml m4f=FILE m7=FILE

A count may grow by 0.5 %, a size by 3 % (compilers differ). Counts are instructions in QEMU, not cycles, without the two
readings of the timer. SPDX-License-Identifier: MIT OR Apache-2.0
"""

import sys
import tomllib
from pathlib import Path


def read(path):
    found = {name: int(value) for name, value in (line.split() for line in Path(path).read_text().splitlines())}
    timer = found.pop("timer.mean")
    found.pop("timer.worst")
    counts = ("forward", "inverse", "position", "line", "stretch", "sample")
    return {name: value - timer if name.split(".")[0] in counts else value for name, value in found.items()}


commit = "--commit" in sys.argv
path, *images = [argument for argument in sys.argv[1:] if argument != "--commit"]
measured = {name: read(file) for name, file in (image.split("=") for image in images)}
if commit:
    text = "# Instructions (mean and worst), stack, flash and RAM of the plugin with its library; written by test.sh --commit.\n"
    for target, found in measured.items():
        text += f"\n[{target}]\n" + "".join(f'"{name}" = {value}\n' for name, value in found.items())
    Path(path).write_text(text)
committed = tomllib.loads(Path(path).read_text())
failed = False
for target, figures in committed.items():
    for name, value in figures.items():
        now = measured[target].get(name)
        allowed = value * (1.005 if name.endswith((".mean", ".worst")) else 1.03)
        print(f"{target} {name}: {now}")
        if now is None or now > allowed:
            print(f"FAILED {target} {name}: found {now}, committed {value}", file=sys.stderr)
            failed = True
sys.exit(failed)
