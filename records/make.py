#!/usr/bin/env python3
"""Writes those sample records beside this file that no command simulates.

Plain Python, no packages. Every run writes the same bytes: closed formulas, scatter from `random.Random(SEED).random()`,
whose sequence Python guarantees, and rounded values. Errors are actual - ideal.
"""

import json
import math
import random
from pathlib import Path

HERE = Path(__file__).resolve().parent
SEED = 10_360


def number(value, digits):
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def write(name, comment, header, rows, digits=3):
    lines = [f"# {comment}", header]
    lines += [",".join(cell if isinstance(cell, str) else number(cell, digits) for cell in row) for row in rows]
    (HERE / name).write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def noise(source, width):
    """Scatter between -width and width."""
    return width * (2 * source.random() - 1)


def turn(degrees):
    return math.sin(math.radians(degrees)), math.cos(math.radians(degrees))


def positions():
    rows = [[20.5, 10, -200], [-120, 80, -300], [240, -150, -50], [0, 0, -390]]
    write("positions.csv", "Commanded positions of compensation-tables/mill-3axis.", "x_mm,y_mm,z_mm", rows)


def axes():
    rows = [[10, 20, 30, -40, 15], [10, 20, 30, -30, 20], [-60, 45, 80, -20, 25], [-60, 45, 80, -10, 30]]
    write("axes.csv", "Axis positions of compensation-tables/mill-5axis.", "x_mm,y_mm,z_mm,a_deg,c_deg", rows)


def circle():
    """Points on a bore of 20 mm radius with three lobes of 3 um."""
    source, rows = random.Random(SEED), []
    for k in range(36):
        sin, cos = turn(10 * k)
        radius = 20 + 0.003 * math.cos(math.radians(30 * k)) + noise(source, 0.0005)
        rows.append([5 + radius * cos, -3 + radius * sin])
    write("points.csv", "Points on a bore.", "x_mm,y_mm", rows, 5)


def contour():
    """A line and a quarter of a circle, and positions up to 11 um beside them."""
    path = [
        {"type": "line", "start": [0, 0, 0], "end": [40, 0, 0]},
        {"type": "arc", "start": [40, 0, 0], "end": [60, 20, 0], "center": [40, 20, 0], "normal": [0, 0, 1], "turns": 0},
    ]
    text = ",\n  ".join(json.dumps(segment) for segment in path)
    (HERE / "path.json").write_text(f'{{"segments": [\n  {text}\n]}}\n', encoding="utf-8", newline="\n")
    source, rows = random.Random(SEED), []
    for segment in range(2):
        for k in range(21):
            u = k / 20
            sin, cos = turn(90 * u)
            x, y = (40 * u, 0.0) if segment == 0 else (40 + 20 * sin, 20 - 20 * cos)
            off = [0.004 * math.sin(6 * u), 0.010 * u, 0.002]
            at = [value + add + noise(source, 0.0005) for value, add in zip((x, y, 0.0), off)]
            rows.append([str(segment), number(u, 3)] + at)
    write("actual.csv", "Measured positions along path.json.", "segment,u,x_mm,y_mm,z_mm", rows, 5)


def ball_of_c():
    """Six errors of a head's axis C, read at a ball in three set-ups."""
    source, rows = random.Random(SEED), []
    for k in range(24):
        sin, cos = turn(15 * k)
        x, y, z = 6 * math.sin(math.radians(15 * k) + 1), 4 * cos, 2 * math.sin(math.radians(30 * k))
        alpha, beta, gamma = 12e-6 * cos, 9e-6 * sin + 5e-6, 15e-6 * sin
        for low, beside in ((250, 60), (250, 160), (350, 60)):
            moved = [
                x + 1e3 * (-low * beta - beside * cos * gamma),
                y + 1e3 * (low * alpha - beside * sin * gamma),
                z + 1e3 * (beside * cos * alpha + beside * sin * beta),
            ]
            rows.append([str(15 * k), str(low), str(beside)] + [value + noise(source, 0.2) for value in moved])
    write("ball-c.csv", "A ball under RTCP while C of a head turns.", "angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um", rows)


def r_test():
    """A ball on the table of trunnion/, whose centre line is 10 um off in X."""
    source, rows = random.Random(SEED), []
    for k in range(16):
        sin, cos = turn(-22.5 * k)
        rows.append([60 * cos, 60 * sin, -80, 0, 22.5 * k] + [off + noise(source, 0.1) for off in (10, 0, 0)])
    header = "x_mm,y_mm,z_mm,a_deg,c_deg,dx_um,dy_um,dz_um"
    write("r-test.csv", "An R-test of trunnion/.", header, rows, 6)


if __name__ == "__main__":
    positions()
    axes()
    circle()
    contour()
    ball_of_c()
    r_test()
