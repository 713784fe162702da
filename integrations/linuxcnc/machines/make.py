#!/usr/bin/env python3
"""Writes the tables of the machines here; every run writes the same bytes. The figures are synthetic.

    python3 make.py
"""
import math
import os

HERE = os.path.dirname(os.path.realpath(__file__))


def table(path, axis, positions, columns, comment):
    """columns: name without unit -> function of the position; µm, for rotations µrad."""
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
    """Straight lines: what must come out is known in closed form."""
    table("stream/x.csv", "X", [-200, 200], {"EXX": slope(0.1), "EZX": slope(0.05)}, "0.1 and 0.05 um per mm")


def comp():
    """Positioning alone, as LinuxCNC's own compensation knows it: nominal, trim in positive and in negative travel, mm."""
    lines = []
    for x in steps(-280, 280, 5):
        forward = plus(wave(9.0, 370.0, 0.1), wave(2.0, 40.0))(x)
        reverse = forward + 1.5 + wave(0.5, 200.0)(x)
        lines.append("%g %.6f %.6f" % (x, forward / 1000.0, reverse / 1000.0))
    os.makedirs(os.path.join(HERE, "comp"), exist_ok=True)
    with open(os.path.join(HERE, "comp", "x.comp"), "w") as f:
        f.write("\n".join(lines) + "\n")


def gantry():
    ys = steps(-200, 200, 25)
    table("gantry/x.csv", "X", steps(-300, 300, 50), {"EXX": wave(8.0, 500.0), "EYX": wave(3.0, 700.0)}, "cross beam")
    table("gantry/y.csv", "Y", ys, {"EYY": plus(slope(0.05), wave(4.0, 300.0)), "EXY": wave(3.0, 450.0)}, "mean of both sides")
    table("gantry/left.csv", "Y", ys, {"EYY": plus(slope(-0.02), wave(2.0, 220.0))}, "left side against the mean, joint 1")
    table("gantry/right.csv", "Y", ys, {"EYY": plus(slope(0.02), wave(-2.0, 220.0))}, "right side against the mean, joint 2")


def gauge():
    table("gauge/x.csv", "X", [-60, 60], {"EXX": slope(0.02)}, "0.02 um per mm")


def trt():
    line = steps(-200, 200, 20)
    table("trt/x.csv", "X", line, {"EXX": plus(slope(0.04), wave(3.0, 260.0)), "EYX": wave(3.0, 420.0), "EZX": wave(4.0, 390.0),
                                   "EAX": wave(9.0, 400.0), "EBX": wave(12.0, 500.0), "ECX": wave(11.0, 450.0)}, "X of trt")
    table("trt/y.csv", "Y", line, {"EXY": wave(3.0, 410.0), "EYY": plus(slope(-0.03), wave(4.0, 300.0)), "EZY": wave(3.0, 430.0),
                                   "EAY": wave(13.0, 450.0), "EBY": wave(8.0, 420.0), "ECY": wave(9.0, 380.0)}, "Y of trt")
    table("trt/z.csv", "Z", line, {"EXZ": wave(3.0, 400.0), "EYZ": wave(4.0, 430.0), "EZZ": plus(slope(0.02), wave(3.0, 280.0)),
                                   "EAZ": wave(9.0, 420.0), "EBZ": wave(10.0, 410.0), "ECZ": wave(5.0, 500.0)}, "Z of trt")
    tilt = steps(-100, 60, 10)
    table("trt/a.csv", "A", tilt, {"EXA": wave(3.0, 200.0), "EYA": wave(4.0, 180.0), "EZA": wave(5.0, 220.0),
                                   "EAA": wave(40.0, 170.0), "EBA": wave(10.0, 190.0), "ECA": wave(12.0, 210.0)}, "A of trt, trunnion")
    turn = steps(-180, 180, 15)
    table("trt/c.csv", "C", turn, {"EXC": wave(5.0, 360.0), "EYC": wave(5.0, 360.0, 0.25), "EZC": wave(3.0, 180.0),
                                   "EAC": wave(12.0, 360.0, 0.1), "EBC": wave(11.0, 360.0, 0.3), "ECC": wave(45.0, 360.0)}, "C of trt, rotary table")


stream()
comp()
gantry()
gauge()
trt()
