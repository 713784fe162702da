#!/usr/bin/env python3
"""Writes s-shape.ngc beside this file: an S-shaped flank, milled with the side of the tool on five axes.

In the manner of the S-shaped test piece of ISO 10791-7:2020 (Annex A): two uniform cubic B-spline curves in two parallel planes 40 mm
apart are the edges of a ruled surface that turns its inclination over along the S, so that it cannot be developed: a cylindrical
tool of radius 10 along the rulings touches it only in between. THE CONTROL POINTS ARE OURS AND NOT THOSE OF THE STANDARD, which are
not public: an S of about 200 x 100 mm whose flank leans by up to some 15 degrees either way. The part is 40 mm high as the
standard's; what its machining shows (rotary axes that reverse and speed up where the S turns) is of the same kind, its figures are not
those of the standard's test.

The tool's direction runs along the ruling, its axis is offset by its radius along the surface's normal at the ruling's middle, its tip
stands in the lower plane's tool position. X0 Y0 Z0 is the middle of the S in the lower plane; tool centre point mode: X Y Z are the tip.

Axes: tool direction in the workpiece = R_z(C) R_x(A) z = (sin A sin C, -sin A cos C, cos A), as in make_cone.py; of both branches the
pose nearest to the one before.
Plain Python, no packages; every run writes the same bytes.
"""

import math
from pathlib import Path

HEIGHT = 40.0
TOOL_RADIUS = 10.0
STEPS = 900
FEED = 1200
# Control points of the lower and the upper edge, x and y in mm.
LOWER = [
    (-118, -60), (-104, -6), (-76, 42), (-36, 52), (-8, 22), (8, -22), (36, -52), (76, -42), (104, 6), (118, 60),
]
# How far the upper edge leans, mm: to the left of the S's way, and along it. The flank turns over in the middle.
SIDEWAYS = [9, 9, 8, 6, 2.5, -2.5, -6, -8, -9, -9]
ALONG = [2, 2, 3, 4, 5, 5, 4, 3, 2, 2]


def upper():
    points = []
    for i, (x, y) in enumerate(LOWER):
        (x0, y0), (x1, y1) = LOWER[max(i - 1, 0)], LOWER[min(i + 1, len(LOWER) - 1)]
        length = math.hypot(x1 - x0, y1 - y0)
        tx, ty = (x1 - x0) / length, (y1 - y0) / length
        points.append((x - SIDEWAYS[i] * ty + ALONG[i] * tx, y + SIDEWAYS[i] * tx + ALONG[i] * ty))
    return points


UPPER = upper()


def spline(points, t):
    """Uniform cubic B-spline, t from 0 to 1 over all its pieces: the point and its derivative by t."""
    pieces = len(points) - 3
    s = min(max(t, 0.0), 1.0) * pieces
    k = min(int(s), pieces - 1)
    u = s - k
    value = ((1 - u) ** 3 / 6, (3 * u**3 - 6 * u**2 + 4) / 6, (-3 * u**3 + 3 * u**2 + 3 * u + 1) / 6, u**3 / 6)
    slope = (-((1 - u) ** 2) / 2, (3 * u**2 - 4 * u) / 2, (-3 * u**2 + 2 * u + 1) / 2, u**2 / 2)
    four = points[k : k + 4]
    at = tuple(sum(w * p[c] for w, p in zip(value, four)) for c in (0, 1))
    along = tuple(pieces * sum(w * p[c] for w, p in zip(slope, four)) for c in (0, 1))
    return at, along


def unit(v):
    length = math.sqrt(sum(c * c for c in v))
    return tuple(c / length for c in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def place(t):
    """Tip and direction of the tool."""
    (x0, y0), (dx0, dy0) = spline(LOWER, t)
    (x1, y1), (dx1, dy1) = spline(UPPER, t)
    ruling = unit((x1 - x0, y1 - y0, HEIGHT))
    along = (0.5 * (dx0 + dx1), 0.5 * (dy0 + dy1), 0.0)
    normal = unit(cross(along, ruling))
    return (x0 + TOOL_RADIUS * normal[0], y0 + TOOL_RADIUS * normal[1], TOOL_RADIUS * normal[2]), ruling


def angles(direction, near):
    """A and C; of both branches and all turns of C the pose nearest to the one before."""
    x, y, z = direction
    tilt = math.degrees(math.atan2(math.hypot(x, y), z))
    azimuth = math.degrees(math.atan2(y, x))
    found = []
    for a, c in ((-tilt, azimuth - 90), (tilt, azimuth + 90)):
        c += 360 * round((near[1] - c) / 360)
        found.append((abs(a - near[0]) + abs(c - near[1]), a, c))
    return min(found)[1:]


def block(word, tip, a, c, feed=""):
    x, y, z = tip
    return f"{word} X{x:.5f} Y{y:.5f} Z{z:.5f} A{a:.6f} C{c:.6f}{feed}".replace("-0.00000 ", "0.00000 ")


def main():
    lines = [
        "; S-shaped flank in the manner of ISO 10791-7:2020, Annex A: two cubic B-splines 40 apart, flank-milled with a tool of",
        "; radius 10. The control points are ours, not the standard's. Written by make_s_shape.py.",
        "G17 G21 G90 G94",
        "G43.4",
        "G0 Z120",
    ]
    pose = angles(place(0.0)[1], (-10.0, 0.0))
    for step in range(STEPS + 1):
        tip, direction = place(step / STEPS)
        pose = angles(direction, pose)
        if step == 0:
            away = tuple(t + 60 * d for t, d in zip(tip, direction))
            lines.append(block("G0", away, *pose))
            lines.append(block("G1", tip, *pose, f" F{FEED}"))
        else:
            lines.append(block("G1", tip, *pose))
    away = tuple(t + 60 * d for t, d in zip(*place(1.0)))
    lines.append(block("G0", away, *pose))
    lines.append("G0 Z120")
    lines.append(f"G0 A0 C{360 * round(pose[1] / 360)}")
    lines.append("G49")
    lines.append("M2")
    Path(__file__).with_name("s-shape.ngc").write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
