"""Tests the dynamic correction in motion: each part is switched, shown on its pins, and nothing jumps."""
import json
import os

import limits
import machines
import rig
from machines import DEFAULT_LIMITS, mill
from recording import Recording
from rig import expect

# Limits of the dynamic correction alone, the defaults of machine.toml: mm, mm/s, mm/s^2.
DYNAMIC_LIMITS = (0.05, 5.0, 5000.0)
CROSSTALK = """
[[crosstalk]]
tip = "X"
from = "Y"
k_um_per_m_per_s2 = 1.2
"""
# Drives with a lag of 4.5 ms, so that the feedback has a contour error.
LAGGING = "loadrt lowpass names=drive-x,drive-y,drive-z\n"
for _j, _axis in enumerate("xyz"):
    LAGGING += """addf drive-{0} servo-thread
setp drive-{0}.gain 0.2
net {0}-drive ta.joint.{1}.motor-pos-cmd-out => drive-{0}.in
net {0}-encoder drive-{0}.out => ta.joint.{1}.motor-pos-fb-in
""".format(_axis, _j)
# Each pin that shows a part alone, and the parts that it shows. Friction, lag and acceleration share a pin.
PARTS = {"feed-forward": ("friction", "lag", "acceleration"), "contour-feedback": ("feedback",),
         "crosstalk": ("crosstalk",), "learned": ("learned",)}


def largest(run, pin, start, stop):
    return max(abs(value) for j in range(3) for value in run.column("ta.joint.%d.%s" % (j, pin))[start:stop])


def dynamics(folder):
    """Switches each part of the dynamic correction off and on in motion; limits are kept in every sample."""
    mill(folder, lambda text: text + CROSSTALK)
    rig.copy(folder, rig.HERE, "dynamics.ngc")
    for j in range(3):
        rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(text, "JOINT_%d" % j, "MIN_FERROR", 3))
    with open(os.path.join(folder, "drives.hal"), "w") as f:
        f.write(LAGGING)
    rig.linuxcnc(folder, "mill-3axis.ini", "dynamics")
    run = Recording.load(os.path.join(folder, "run"))
    with open(os.path.join(folder, "marks.json")) as f:
        marks = json.load(f)
    expect(marks["running"] == 1, "the program did not go on", marks)
    expect(max(run.column("ta.fault-code")) == 0, "faults", set(run.column("ta.fault-code")))
    expect(max(run.column("ta.feedback-out")) == 0, "the feedback was ramped out")
    rows = {int(sequence): n for n, sequence in enumerate(run.column("ta.sequence"))}
    for pin, parts in PARTS.items():
        off, on = rows[marks[pin + " off"]], rows[marks[pin + " on"]]
        expect(on - off > 300, "%s was off for %d samples" % (pin, on - off))
        # The last fifth only: after switching off, the part fades over several reset times.
        left = largest(run, pin, on - (on - off) // 5, on)
        before, after = largest(run, pin, off - 400, off), largest(run, pin, on, on + 400)
        expect(left < 1e-7 and min(before, after) > 1e-6, "%s: %g mm, off %g, on again %g" % (pin, before, left, after))
    used = limits.all_kept(run, 3, [DEFAULT_LIMITS] * 3)
    own = [limits.kept(run.column("ta.joint.%d.dynamic" % j), *DYNAMIC_LIMITS, "dynamic, joint %d" % j) for j in range(3)]
    largest_sent = largest(run, "dynamic", 0, len(run.rows))
    expect(largest_sent > 0.005, "only %g mm were sent" % largest_sent)
    off = rows[marks["all on"]]
    expect(largest(run, "dynamic", off - 50, off) < 1e-7, "something is sent with all parts off")
    control(run)
    return "%d parts, up to %.1f um, limits used %s, its own %s" % (
        sum(map(len, PARTS.values())) + 1, 1e3 * largest_sent, " ".join("%.2f" % u for u in used),
        " ".join("%.2f" % max(u) for u in zip(*own)))


def control(run):
    """Checks that the check of the limits detects a jump of 10 um in a single sample."""
    column = run.column("ta.joint.0.dynamic")
    column[len(column) // 2] += 0.01
    try:
        limits.kept(column, *DYNAMIC_LIMITS, "control")
    except rig.Broken:
        return
    raise rig.Broken("the check of the limits does not see 10 um")


TESTS = (dynamics,)
