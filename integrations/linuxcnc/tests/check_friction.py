"""Tests circles recorded on a machine whose drives have friction, and the friction identified from them."""
import json
import os
import subprocess

import rig
from machines import TRUEAXIS, geometry_alone, mill
from rig import expect

# The values of tests/dahl.comp.
TRUTH = {"coulomb_mm_per_s": 0.5, "presliding_um": 6.0, "stribeck_share": 0.3}

DRIVES = """loadrt dahl count=2
# First in the cycle, like a driver that reads encoders: the position one period after the command.
addf dahl.0 servo-thread 1
addf dahl.1 servo-thread 2
net x-drive ta.joint.0.motor-pos-cmd-out => dahl.0.cmd
net x-encoder dahl.0.pos => ta.joint.0.motor-pos-fb-in
net y-drive ta.joint.1.motor-pos-cmd-out => dahl.1.cmd
net y-encoder dahl.1.pos => ta.joint.1.motor-pos-fb-in
net z-drive ta.joint.2.motor-pos-cmd-out => ta.joint.2.motor-pos-fb-in
"""


def friction(folder):
    """record-circles.py on a running LinuxCNC gives a complete record, and the machine's friction and drive figures."""
    # The machine as it is before its friction is known.
    mill(folder, geometry_alone)
    with open(os.path.join(folder, "drives.hal"), "w") as f:
        f.write(DRIVES)
    rig.linuxcnc(folder, "mill-3axis.ini", "friction", 150)
    with open(os.path.join(folder, "record.csv")) as f:
        lines = f.read().splitlines()
    expect(lines[0] == "t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm", "header of the record", lines[0])
    expect(len(lines) > 15000, "only %d samples" % len(lines))
    done = subprocess.run([TRUEAXIS, "friction", "record.csv", "--axes", "X,Y", "--json", "-o", "friction.toml"],
                          cwd=folder, capture_output=True, text=True, timeout=120 * rig.PATIENCE)
    expect(done.returncode == 0, "trueaxis friction", done.stderr)
    said = []
    for axis in json.loads(done.stdout)["axes"]:
        for key, truth in TRUTH.items():
            found, error = axis["friction"][key], axis["standard_errors"][key]
            expect(abs(found - truth) < max(4.0 * error, 0.1 * truth), "%s of %s" % (key, axis["axis"]), found, error)
        expect(abs(axis["drive"]["position_gain_per_s"] - 110.0) < 15.0, "position gain", axis["drive"])
        before, after = axis["glitch_um"]["before"]["max"], axis["glitch_um"]["after"]["max"]
        expect(before > 1.0 and after < 0.25 * before, "spikes of %s" % axis["axis"], before, after)
        said.append("%s %.2f to %.2f um" % (axis["axis"], before, after))
    with open(os.path.join(folder, "friction.toml")) as f:
        expect("[axis.Y.friction]" in f.read(), "no settings in friction.toml")
    return "%d samples, spikes %s" % (len(lines) - 1, ", ".join(said))


TESTS = (friction,)
