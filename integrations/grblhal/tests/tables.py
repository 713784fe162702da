"""Writes the machines of the tests: tables.py MILL OUT. SPDX-License-Identifier: MIT OR Apache-2.0

OUT/mill: the sample mill MILL with levers and the default hysteresis. OUT/kinked: lines that bend by 8 mm/m every 5 mm, the
worst case for a stretch of 2 mm. OUT/nine: such lines on nine terms. OUT/lost: straight lines and lost motion, with a correction limit far above them.
OUT/beside: a mill measured from 0 upwards, while its controller counts from 0 downwards.
"""

import re
import shutil
import sys
from pathlib import Path

mill, out = map(Path, sys.argv[1:])

shutil.rmtree(out / "mill", ignore_errors=True)
shutil.copytree(mill, out / "mill")
settings = out / "mill/machine.toml"
text = re.sub(r"^(hysteresis_um|encoder_resolution_um).*\n", "", settings.read_text(), flags=re.M)
settings.write_text(text + '\n[compensation]\nmodel = "volumetric"\n')


def machine(name, travel, value, model="volumetric"):
    folder = out / name
    folder.mkdir(exist_ok=True)
    lines = [f'name = "mill-3axis"\nchain = "w X\' Y\' b Z t"\n[compensation]\nmodel = "{model}"\n']
    for axis, (low, high) in zip("XYZ", travel):
        lines.append(f"[axis.{axis}]\ntable = '{axis.lower()}.csv'\ninterpolation = 'linear'\ntravel_mm = [{low:.1f}, {high:.1f}]\n")
        lines.append(f"max_feed_mm_per_min = 1000.0\n[axis.{axis}.limits]\nmagnitude_um = 100.0\n")
        others = [other for other in "XYZ" if other != axis]
        rows = [f"{axis}_mm,E{axis}{axis}_um," + ",".join(f"E{other}{axis}_um" for other in others)]
        rows += [f"{at},{value(at)},{-value(at)},{0.5 * value(at)}" for at in range(low, high + 1, 5)]
        (folder / f"{axis.lower()}.csv").write_text("\n".join(rows) + "\n")
    (folder / "machine.toml").write_text("".join(lines))


def lost():
    """Writes the machine of tests/dropped.c."""
    ends = {"X": (-300, 24, 12, -18, 30), "Y": (-200, 10, -16, 6, 25), "Z": (-400, -20, 8, 30, 20)}
    folder = out / "lost"
    folder.mkdir(exist_ok=True)
    lines = ['name = "lost"\nchain = "w X\' Y\' b Z t"\n']
    for axis, (low, x, y, z, backlash) in ends.items():
        lines.append(f"[axis.{axis}]\ntable = '{axis.lower()}.csv'\ntravel_mm = [{low:.1f}, 0.0]\nbacklash_um = {backlash:.1f}\n")
        rows = f"{axis}_mm,EX{axis}_um,EY{axis}_um,EZ{axis}_um\n{low},{x},{y},{z}\n0,0,0,0\n"
        (folder / f"{axis.lower()}.csv").write_text(rows)
    (folder / "machine.toml").write_text("".join(lines))


lost()
machine("kinked", [(-300, 0), (-200, 0), (-400, 0)], lambda at: 20 * (1 - at // 5 % 2))
machine("nine", [(-300, 0), (-200, 0), (-400, 0)], lambda at: 20 * (at // 5 % 2), "nine")
machine("beside", [(0, 300), (0, 200), (0, 400)], lambda at: 0.01 * at)
