#!/usr/bin/env python3
"""Writes the sample records beside this file: one for each command of `trueaxis` that reads a measurement.

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


def ballbar():
    """A bar of 100 mm: C0Y 50 urad, lost motion of 5 um in X, the pivot 20 um off centre."""
    source, rows = random.Random(SEED), []
    for direction in (1, -1):
        for k in range(180):
            sin, cos = turn(2 * k + 1)
            x, y = 100 * cos, 100 * sin
            x += -50e-6 * y + 0.0025 * math.copysign(1, direction * sin) + 0.02
            deviation = 1e3 * (math.hypot(x, y) - 100) + noise(source, 0.2)
            rows.append([str(2 * k + 1), deviation, str(direction)])
    write("ballbar.csv", "Circles of a ballbar, radius 100 mm.", "angle_deg,deviation_um,direction", rows)


def screw():
    """A screw of 5 mm over nine turns: two harmonics, a slow error, 4 um of lost motion."""
    source, rows = random.Random(SEED), []
    for direction in (1, -1):
        for step in range(226) if direction > 0 else range(225, -1, -1):
            position = 0.2 * step
            sin, cos = turn(72 * position)
            double = 2 * sin * cos
            wave = 1.3 * cos - 0.6 * sin + 0.3 * (1 - 2 * sin * sin) + 0.2 * double
            slow = 0.03 * position - 0.0006 * position**2 - (4 if direction < 0 else 0)
            rows.append([number(position, 1), wave + slow + noise(source, 0.1), str(direction)])
    write("screw.csv", "A fine scan of an axis with a screw of 5 mm.", "position_mm,error_um,direction", rows)


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


def step_diagonal():
    """A diagonal test of a machine out of square by C0Y = 50 urad."""
    source, rows = random.Random(SEED), []
    signs = [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)]
    length = 100 * math.sqrt(14)
    for diagonal, (sx, sy, sz) in enumerate(signs, 1):
        for direction in (1, -1):
            for step in range(6):
                t = (step if direction > 0 else 5 - step) / 5
                at = [300 * sx * t, 200 * sy * t, 100 * sz * t]
                deviation = 1e3 * (-50e-6 * at[1]) * 300 * sx / length
                rows.append([str(diagonal), str(direction)] + at + [deviation + noise(source, 0.3)])
    header = "diagonal,direction,x_mm,y_mm,z_mm,deviation_um"
    write("step-diagonal.csv", "Displacements along the body diagonals of a mill.", header, rows)


def tracer():
    """Points of compensation-tables/mill-3axis, whose axes are 30, -20 and 40 ppm too long and out of square."""
    source, rows = random.Random(SEED), []
    levels = range(5)
    for i in levels:
        for j in levels:
            for k in levels:
                x, y, z = -280 + 140 * i, -180 + 90 * j, -380 + 90 * k
                actual = [x + 30e-6 * x - 45e-6 * y - 25e-6 * z, y - 20e-6 * y, z + 40e-6 * z]
                rows.append([x, y, z] + [value + noise(source, 0.0005) for value in actual])
    header = "x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm"
    write("tracer.csv", "Points that a tracer measured on a mill.", header, rows, 5)


def r_test():
    """A ball on the table of trunnion/, whose centre line is 10 um off in X."""
    source, rows = random.Random(SEED), []
    for k in range(16):
        sin, cos = turn(-22.5 * k)
        rows.append([60 * cos, 60 * sin, -80, 0, 22.5 * k] + [off + noise(source, 0.1) for off in (10, 0, 0)])
    header = "x_mm,y_mm,z_mm,a_deg,c_deg,dx_um,dy_um,dz_um"
    write("r-test.csv", "An R-test of trunnion/.", header, rows, 6)


def spindle():
    """Two hours of a rotating spindle, a reading every two minutes."""
    source, rows = random.Random(SEED), []
    for k in range(61):
        minute = 2 * k
        warm = 1 - math.exp(-minute / 40)
        drift = [6 * warm, 24 * warm, 8 * warm]
        drift = [value + noise(source, 0.1) for value in drift]
        rows.append([str(60 * minute)] + drift + [20 + 0.4 * minute / 120 + noise(source, 0.05)])
    write("spindle.csv", "Drift while the spindle turns.", "t_s,x1_um,z_um,x2_um,ambient_c", rows)


def ring():
    """A ring of 50 mm, probed at 36 points with a tip of 6 mm."""
    source, rows = random.Random(SEED), []
    for k in range(36):
        sin, cos = turn(10 * k)
        radius = 22 + 0.001 * math.cos(math.radians(20 * k)) + noise(source, 0.0003)
        rows.append([radius * cos, radius * sin])
    write("ring.csv", "A calibrated ring probed at 36 points.", "x_mm,y_mm", rows, 5)


if __name__ == "__main__":
    positions()
    axes()
    circle()
    contour()
    ballbar()
    screw()
    ball_of_c()
    step_diagonal()
    tracer()
    r_test()
    spindle()
    ring()
