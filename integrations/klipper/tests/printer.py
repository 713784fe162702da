"""Writes the machine for the probing tests, a printer with errors of up to a tenth of a millimetre: printer.py OUT.

Z rises from 0 at the bed. The errors are smooth and without lost motion; the figures are synthetic.
SPDX-License-Identifier: GPL-3.0-or-later
"""
import math
import sys
from pathlib import Path

out = Path(sys.argv[1])
out.mkdir(exist_ok=True)
# Each term: amplitude (um, urad), wavelength (mm), phase.
TERMS = {
    "X": {"EXX": (30, 310, 0.1), "EYX": (40, 500, 0.2), "EZX": (55, 420, 0.15), "EAX": (60, 600, 0.3), "EBX": (80, 560, 0.1),
          "ECX": (75, 480, 0.7)},
    "Y": {"EXY": (35, 380, 0.4), "EYY": (25, 260, 0.6), "EZY": (45, 300, 0.9), "EAY": (90, 420, 0.2), "EBY": (50, 380, 0.8),
          "ECY": (70, 520, 0.5)},
    "Z": {"EXZ": (25, 520, 0.3), "EYZ": (30, 610, 0.7), "EZZ": (20, 310, 0.2), "EAZ": (80, 700, 0.6), "EBZ": (60, 640, 0.4),
          "ECZ": (30, 800, 0.1)},
}
text = 'name = "printer"\nchain = "w Y\' b Z X t"\ntool_mm = [0.0, 0.0, 0.0]\n\n[compensation]\nmodel = "volumetric"\n\n'
text += "[location]\nA0Z_urad = 100.0\nB0Z_urad = -120.0\nC0Y_urad = 160.0\n"
for axis, terms in TERMS.items():
    low, high = (-10, 200) if axis == "Z" else (0, 200)
    head = [f"{axis}_mm"] + [f"{term}_{'urad' if term[1] in 'ABC' else 'um'}" for term in terms]
    rows = [",".join([str(at)] + ["%g" % round(0.4 * a * math.sin(2 * math.pi * (at / length + phase)), 3) for a, length, phase in terms.values()])
            for at in range(low, high + 1, 10)]
    (out / f"{axis.lower()}.csv").write_text("\n".join([",".join(head)] + rows) + "\n")
    text += f'\n[axis.{axis}]\ntable = "{axis.lower()}.csv"\ninterpolation = "cubic"\ntravel_mm = [{low}.0, {high}.0]\n'
(out / "machine.toml").write_text(text)
