#!/usr/bin/env python3
"""Writes the tables of the machines here; every run writes the same bytes. The figures are synthetic.

    python3 make.py
"""
import math
import os

HERE = os.path.dirname(os.path.realpath(__file__))


def table(path, axis, positions, columns, comment):
    """Writes a table. columns: name without unit -> function of the position; µm, for rotations µrad."""
    unit = {"E" + c + axis: "urad" if c in "ABC" else "um" for c in "XYZABC"}
    position = "deg" if axis in "ABC" else "mm"
    lines = ["# " + comment, ",".join(["%s_%s" % (axis, position)] + [column(n, unit) for n in columns])]
    for p in positions:
        lines.append(",".join(["%g" % p] + ["%g" % (round(f(p), 3) + 0.0) for f in columns.values()]))
    full = os.path.join(HERE, path)
    os.makedirs(os.path.dirname(full), exist_ok=True)
    with open(full, "w") as f:
        f.write("\n".join(lines) + "\n")


def column(name, unit):
    base, _, direction = name.partition("_")
    return "_".join(part for part in (base, direction, unit[base]) if part)


def steps(low, high, step):
    return [low + step * i for i in range(round((high - low) / step) + 1)]


def wave(amplitude, length, phase=0.0):
    return lambda p: amplitude * math.sin(2.0 * math.pi * (p / length + phase))


def plus(*functions):
    return lambda p: sum(f(p) for f in functions)


def slope(per_unit, datum=0.0):
    return lambda p: per_unit * (p - datum)


def stream():
    """Writes straight lines, for which the result is known in closed form."""
    table("stream/x.csv", "X", [-200, 200], {"EXX": slope(0.1), "EZX": slope(0.05)}, "0.1 and 0.05 um per mm")


def comp():
    """Writes positioning errors alone, as for LinuxCNC's own compensation: nominal, trim in positive and negative travel, mm."""
    lines = []
    for x in steps(-280, 280, 5):
        forward = plus(wave(9.0, 370.0, 0.1), wave(2.0, 40.0))(x)
        reverse = forward - 1.5 - wave(0.5, 200.0)(x)
        lines.append("%g %.6f %.6f" % (x, forward / 1000.0, reverse / 1000.0))
    os.makedirs(os.path.join(HERE, "comp"), exist_ok=True)
    with open(os.path.join(HERE, "comp", "x.comp"), "w") as f:
        f.write("\n".join(lines) + "\n")


def gantry():
    ys = steps(-200, 200, 25)
    beam = {"EXX": wave(8.0, 500.0), "EYX": wave(3.0, 700.0)}
    table("gantry/x.csv", "X", steps(-300, 300, 50), beam, "cross beam")
    both = {"EYY": plus(slope(0.05), wave(4.0, 300.0)), "EXY": wave(3.0, 450.0)}
    table("gantry/y.csv", "Y", ys, both, "mean of both sides")
    left, right = plus(slope(-0.02), wave(2.0, 220.0)), plus(slope(0.02), wave(-2.0, 220.0))
    table("gantry/left.csv", "Y", ys, {"EYY": left}, "left side against the mean, joint 1")
    table("gantry/right.csv", "Y", ys, {"EYY": right}, "right side against the mean, joint 2")


def gauge():
    table("gauge/x.csv", "X", [-60, 60], {"EXX": slope(0.02)}, "0.02 um per mm")


# For every axis: its positions, its own slope (0: none), and waves (amplitude, length, phase) in EX, EY, EZ, EA, EB,
# EC.
TRT = {
    "X": (steps(-200, 200, 20), 0.04, [(3, 260), (3, 420), (4, 390), (9, 400), (12, 500), (11, 450)]),
    "Y": (steps(-200, 200, 20), -0.03, [(3, 410), (4, 300), (3, 430), (13, 450), (8, 420), (9, 380)]),
    "Z": (steps(-200, 200, 20), 0.02, [(3, 400), (4, 430), (3, 280), (9, 420), (10, 410), (5, 500)]),
    "A": (steps(-100, 60, 10), 0.0, [(3, 200), (4, 180), (5, 220), (40, 170), (10, 190), (12, 210)]),
    "C": (steps(-180, 180, 15), 0.0, [(5, 360), (5, 360, 0.25), (3, 180), (12, 360, 0.1), (11, 360, 0.3), (45, 360)]),
}


def trt():
    for axis, (positions, own, waves) in TRT.items():
        columns = {"E%s%s" % (c, axis): wave(*w) for c, w in zip("XYZABC", waves)}
        columns["E" + 2 * axis] = plus(slope(own), columns["E" + 2 * axis])
        table("trt/%s.csv" % axis.lower(), axis, positions, columns, "%s of trt" % axis)


stream()
comp()
gantry()
gauge()
trt()
