"""What the tests hold the host against: the form of a bed, and where tool and drives are by the library's command.

Of both directions of travel the mean, as the shim takes it.

SPDX-License-Identifier: GPL-3.0-or-later
"""
import csv
import subprocess
import tempfile
from pathlib import Path

PASSES = 4  # of the inverse; each brings three digits
HOME = 60.0, 140.0


def height(x, y):
    """Of the bed, twisted and tilted, mm, 0 at HOME: the interpolation of a mesh meets it exactly."""
    dx, dy = x - HOME[0], y - HOME[1]
    return 4e-4 * dx - 3e-4 * dy + 1.5e-6 * dx * dy


def commands(trueaxis, machine, points):
    """p + c(p), mm, of every place p = (x, y, z) of the tool."""
    with tempfile.TemporaryDirectory() as folder:
        given, out = Path(folder) / "p.csv", Path(folder) / "q.csv"
        given.write_text("x_mm,y_mm,z_mm\n" + "".join("%.9f,%.9f,%.9f\n" % tuple(p) for p in points))
        both = []
        for way in ([], ["--reverse"]):
            subprocess.run([trueaxis, "compensate", machine, given, *way, "-o", out], check=True, stdout=subprocess.DEVNULL)
            with out.open() as file:
                both.append([[float(row[f"c{a}_mm"]) for a in "xyz"] for row in csv.DictReader(file)])
    return [[(a + b) / 2 for a, b in zip(*ways)] for ways in zip(*both)]


def tools(trueaxis, machine, drives):
    """Where the tool is, of every place of the drives: p of q = p + c(p)."""
    points = drives
    for _ in range(PASSES):
        sent = commands(trueaxis, machine, points)
        points = [[p + q - s for p, q, s in zip(*parts)] for parts in zip(points, drives, sent)]
    return points
