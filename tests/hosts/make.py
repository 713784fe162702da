#!/usr/bin/env python3
"""Writes the machine that every host corrects for the table of docs/hosts.md; every run writes the same bytes.

Nine terms of a mill with travels that any controller takes, smooth and without lost motion: some hosts know no direction of
travel. The figures are synthetic. SPDX-License-Identifier: MIT OR Apache-2.0
"""
import math
from pathlib import Path

HERE = Path(__file__).resolve().parent / "machine"
TRAVEL = {"X": (-300, 0), "Y": (-200, 0), "Z": (-400, 0)}
STEP = 10


def wave(amplitude, length, phase):
    return lambda at: amplitude * math.sin(2.0 * math.pi * (at / length + phase))


def sum_of(*parts):
    return lambda at: sum(part(at) for part in parts)


TERMS = {
    "X": {"EXX": sum_of(lambda at: 0.06 * at, wave(3.0, 240.0, 0.1)), "EYX": wave(4.0, 500.0, 0.2), "EZX": wave(5.0, 420.0, 0.0),
          "EAX": wave(12.0, 600.0, 0.3), "EBX": wave(18.0, 560.0, 0.1), "ECX": wave(15.0, 480.0, 0.7)},
    "Y": {"EXY": wave(3.5, 380.0, 0.4), "EYY": sum_of(lambda at: -0.05 * at, wave(2.5, 160.0, 0.6)), "EZY": wave(3.0, 300.0, 0.9),
          "EAY": wave(20.0, 420.0, 0.2), "EBY": wave(10.0, 380.0, 0.8), "ECY": wave(14.0, 520.0, 0.5)},
    "Z": {"EXZ": wave(2.5, 520.0, 0.3), "EYZ": wave(3.0, 610.0, 0.7), "EZZ": sum_of(lambda at: 0.03 * at, wave(2.0, 310.0, 0.2)),
          "EAZ": wave(16.0, 700.0, 0.6), "EBZ": wave(12.0, 640.0, 0.4), "ECZ": wave(6.0, 800.0, 0.1)},
}
SETTINGS = """# Written by make.py.
name = "every-host"
chain = "w X' Y' b Z t"
tool_mm = [0.0, 0.0, 0.0]

[compensation]
model = "volumetric"

[location]
A0Z_urad = 25.0
B0Z_urad = -30.0
C0Y_urad = 40.0
"""

HERE.mkdir(exist_ok=True)
for axis, (low, high) in TRAVEL.items():
    terms = TERMS[axis]
    head = [f"{axis}_mm"] + [f"{term}_{'urad' if term[1] in 'ABC' else 'um'}" for term in terms]
    rows = [",".join([str(at)] + [f"{round(error(at), 3) + 0.0:g}" for error in terms.values()]) for at in range(low, high + 1, STEP)]
    (HERE / f"{axis.lower()}.csv").write_text("\n".join([",".join(head)] + rows) + "\n")
    SETTINGS += f"""
[axis.{axis}]
table = "{axis.lower()}.csv"
interpolation = "cubic"
travel_mm = [{low:.1f}, {high:.1f}]
max_feed_mm_per_min = 12000.0
"""
(HERE / "machine.toml").write_text(SETTINGS)
