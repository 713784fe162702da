#!/usr/bin/env python3
"""Writes cone-5axis.ngc beside this file: a tilted cone frustum, flank-milled with five axes.

In the manner of the cone frustum of NAS 979 and ISO 10791-7: half angle 15 degrees, lower circle 80 mm in diameter, its axis
tilted by 10 degrees. The tool lies along the generatrix (its flank cuts, half its diameter away from the surface), the
tip goes round the lower circle, clockwise seen from above (climb milling). Tool centre point mode: X Y Z are the tip.

Axes: tool direction in the workpiece = R_z(C) R_x(A) z = (sin A sin C, -sin A cos C, cos A), a trunnion A that carries a
table C, both turning by the negative angle: at polar angle p and azimuth f of the tool, A = -p and C = f - 90 degrees.
Plain Python, no packages; every run writes the same bytes.
"""

import math
from pathlib import Path

HALF_ANGLE = math.radians(15)
TILT = math.radians(10)
RADIUS = 40.0
TOOL_RADIUS = 6.0
STEPS = 720
LEAD = 30  # steps before and after the full turn, on the same circle
FEED = 1500


def tilted(v):
    """Turned about X by the tilt."""
    x, y, z = v
    c, s = math.cos(TILT), math.sin(TILT)
    return (x, c * y - s * z, s * y + c * z)


def place(step):
    """Tip and direction of the tool at a step round the cone."""
    f = -2 * math.pi * step / STEPS
    out = (math.cos(f), math.sin(f), 0.0)
    direction = tilted((-math.sin(HALF_ANGLE) * out[0], -math.sin(HALF_ANGLE) * out[1], math.cos(HALF_ANGLE)))
    normal = tilted((math.cos(HALF_ANGLE) * out[0], math.cos(HALF_ANGLE) * out[1], math.sin(HALF_ANGLE)))
    circle = tilted((RADIUS * out[0], RADIUS * out[1], 0.0))
    return tuple(c + TOOL_RADIUS * n for c, n in zip(circle, normal)), direction


def angles(direction, near):
    x, y, z = direction
    a = -math.degrees(math.atan2(math.hypot(x, y), z))
    c = math.degrees(math.atan2(y, x)) - 90
    return a, c + 360 * round((near - c) / 360)


def block(word, tip, a, c, feed=""):
    x, y, z = tip
    return f"{word} X{x:.5f} Y{y:.5f} Z{z:.5f} A{a:.6f} C{c:.6f}{feed}".replace("-0.00000 ", "0.00000 ")


def main():
    lines = [
        "; Tilted cone frustum in the manner of NAS 979 and ISO 10791-7: half angle 15, axis tilted by 10 degrees, lower circle",
        "; of 80, flank-milled with a tool of radius 6; X0 Y0 Z0 is its centre. Written by make_cone.py.",
        "G17 G21 G90 G94",
        "G43.4",
        "G0 Z100",
    ]
    c = 0.0
    for step in range(-LEAD, STEPS + LEAD + 1):
        tip, direction = place(step)
        a, c = angles(direction, c)
        if step == -LEAD:
            # Above the first point, along the tool, then straight down it.
            away = tuple(t + 50 * d for t, d in zip(tip, direction))
            lines.append(block("G0", away, a, c))
            lines.append(block("G1", tip, a, c, f" F{FEED}"))
        else:
            lines.append(block("G1", tip, a, c))
    away = tuple(t + 50 * d for t, d in zip(*place(STEPS + LEAD)))
    lines.append(block("G0", away, a, c))
    lines.append("G0 Z100")
    lines.append(f"G0 A0 C{360 * round(c / 360)}")
    lines.append("G49")
    lines.append("M2")
    Path(__file__).with_name("cone-5axis.ngc").write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
