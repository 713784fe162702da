"""Reference for the tests of the host: the form of a bed, and the positions of tool and drives by the library's command.

They are the mean of both directions of travel, as the shim uses it.

SPDX-License-Identifier: GPL-3.0-or-later
"""
import csv
import subprocess
import tempfile
from pathlib import Path

PASSES = 4  # of the inverse; each brings three digits
HOME = 60.0, 140.0


def height(x, y):
    """Returns the height of the bed, mm, 0 at HOME. It is twisted and tilted, so a mesh's interpolation meets it exactly."""
    dx, dy = x - HOME[0], y - HOME[1]
    return 4e-4 * dx - 3e-4 * dy + 1.5e-6 * dx * dy


def commands(trueaxis, machine, points):
    """Returns the drive positions p + c(p), mm, for tool positions p = (x, y, z)."""
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
    """Returns the tool positions p with q = p + c(p), for drive positions q."""
    points = drives
    for _ in range(PASSES):
        sent = commands(trueaxis, machine, points)
        points = [[p + q - s for p, q, s in zip(*parts)] for parts in zip(points, drives, sent)]
    return points
