"""Tests a machine in inches: correction, recording and probing follow the units of its INI file."""
import csv
import json
import math
import os

import rig
from machines import geometry_alone, in_inches, mill
from rig import expect

INCH = 25.4


def stands(folder, change):
    os.makedirs(folder)
    mill(folder, geometry_alone)
    rig.edit(folder, "mill-3axis.ini", change)
    rig.linuxcnc(folder, "mill-3axis.ini", "stands")
    with open(os.path.join(folder, "stands.json")) as f:
        found = json.load(f)
    expect(found["fault"] == 0, "fault %d" % found["fault"])
    return found["stands"]


def inches(folder):
    """The sample configuration in inches has the same positions and corrections as the one in mm."""
    metric = stands(os.path.join(folder, "mm"), lambda text: text)
    imperial = stands(os.path.join(folder, "inch"), in_inches)
    largest = 0.0
    for mm, inch in zip(metric, imperial):
        for pin, values in mm.items():
            for a, b in zip(values, inch[pin]):
                expect(abs(a / INCH - b) < 1e-10, "%s: %.9g mm and %.9g in" % (pin, a, b), mm, inch)
        largest = max(largest, *map(abs, mm["ta.joint.%d.correction"]))
    expect(largest > 0.005, "nothing was corrected", metric)
    return "corrections up to %.2f um, in inches the same within 3 nm" % (1e3 * largest)


def circles_in_inches(folder):
    """record-circles.py on a machine in inches: the record is in mm, as its columns say."""
    mill(folder, geometry_alone)
    rig.edit(folder, "mill-3axis.ini", in_inches)
    rig.linuxcnc(folder, "mill-3axis.ini", "circles_in_inches")
    with open(os.path.join(folder, "record.csv")) as f:
        rows = list(csv.DictReader(f))
    expect(len(rows) > 2000, "only %d samples" % len(rows))
    radii = [math.hypot(float(row["x_cmd_mm"]), float(row["y_cmd_mm"])) for row in rows]
    # The commands contain the correction, here up to 30 um.
    expect(all(abs(radius - 10.0037) < 0.05 for radius in radii), "radii of %g to %g mm" % (min(radii), max(radii)))
    return "%d samples, radius %.4f mm" % (len(rows), sum(radii) / len(radii))


TESTS = (inches, circles_in_inches)
