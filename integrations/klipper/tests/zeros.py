"""Checks that setting one axis never moves the motor zero of another: check(RECORD).

SPDX-License-Identifier: GPL-3.0-or-later
"""
import json

from truth import HOME

ALLOWED = 1e-6  # mm
STEP = 0.0016  # mm
# Operations after Z is homed by a probe: name, program, and the axes whose zero it may move.
DONE = (
    ("nothing", "", ""),
    ("set-z", "SET_KINEMATIC_POSITION Z=180\n", "z"),
    ("homed-z", "G28 Z\n", "z"),
    ("homed-z again", "G28 Z\n", "z"),
    ("homed-z elsewhere", "G1 Z8 F1200\nG1 X150.0007 Y40.0009 F6000\nG28 Z\n", "z"),
    ("set-x", "G1 Z8 F1200\nSET_KINEMATIC_POSITION X=20\n", "x"),
    ("set-y", "SET_KINEMATIC_POSITION Y=20\n", "y"),
    ("sought", "G1 Z100 F1200\nZERO_SEEK Z=-5\n", "z"),
    ("set-z-and-y", "SET_KINEMATIC_POSITION Y=150 Z=100\n", "yz"),
    ("set-z-twice", "ZERO_TWICE Z=40\n", "z"),
    ("off", "M84\n", ""),
)


def program():
    text = "G28 X Y\nG90\nG1 X%g Y%g F6000\nG28 Z\nG1 Z150 F1200\n" % HOME
    return text + "".join(f"{what}ZERO NAME='{name}'\n" for name, what, _ in DONE)


def check(record):
    """Returns (name, largest shift of a zero that must not move) for each entry of DONE, and the error of the position sought, mm."""
    looks = list(map(json.loads, open(record)))
    assert len(looks) == len(DONE)
    sought, looks = looks[-1]["sought"], [look["zero"] for look in looks]
    found = []
    for (name, _, axes), before, after in zip(DONE[1:], looks, looks[1:]):
        found.append((name, max(abs(a - b) for a, b, axis in zip(after, before, "xyz") if axis not in axes)))
    return found, sought
