"""Tests friction that adapts and parts on trial, on drives whose friction and lag change in motion."""
import json
import os

import machines
import rig
from recording import Recording
from rig import expect

# The values of tests/dahl.comp.
DRIVE = """
[axis.%(axis)s.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
velocity_feed_forward = %(fed)g
lowest_resonance_hz = 1200

[axis.%(axis)s.friction]
coulomb_mm_per_s = 0.5
presliding_um = 6
stribeck_share = 0.3
stribeck_velocity_mm_per_s = 2
%(more)s
"""
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


def circles(folder, scenario, feed, *axes):
    """Runs a scenario on the mill with these drives of X and Y; returns its recording, its marks and the rows of the marks."""
    machines.mill(folder, lambda text: machines.geometry_alone(text) + "".join(DRIVE % axis for axis in axes))
    rig.copy(folder, rig.HERE, "circles.ngc")
    rig.edit(folder, "circles.ngc", lambda text: text.replace("F(feed)", "F%g" % feed))
    for j in range(2):
        rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(text, "JOINT_%d" % j, "MIN_FERROR", 3))
    with open(os.path.join(folder, "drives.hal"), "w") as f:
        f.write(DRIVES)
    rig.linuxcnc(folder, "mill-3axis.ini", scenario, 100)
    run = Recording.load(os.path.join(folder, "run"))
    with open(os.path.join(folder, "marks.json")) as f:
        marks = json.load(f)
    expect(marks.pop("running") == 1, "the program did not go on", marks)
    expect(max(run.column("ta.stop-request")) == 0, "a stop was requested")
    sequences = {int(sequence): n for n, sequence in enumerate(run.column("ta.sequence"))}
    return run, {name: sequences[sequence] for name, sequence in marks.items()}


def adaptation(folder):
    """Friction that rises by 30 % is followed, frozen, freed and reset; one of the wrong sign is a fault until a reset."""
    axes = [{"axis": axis, "fed": 0.93, "more": "adapt = 0.5"} for axis in "XY"]
    run, rows = circles(folder, "adaptation", 4800, *axes)
    pins = ["ta.joint.%d.%s-factor" % (j, of) for of in ("friction", "presliding") for j in range(3)]
    factors = list(zip(*(run.column(pin) for pin in pins)))
    expect(factors[0] == (1.0,) * 6, "factors at the start", factors[0])
    expect(all(row[2] == row[5] == 1.0 for row in factors), "Z does not adapt, and its factors change")
    levels = [row[:2] for row in factors]
    steps = max(abs(now - before) for one, other in zip(levels, levels[1:])
                for before, now in zip(one, other) if other != (1.0, 1.0))
    expect(steps < 0.0501, "a factor moves by %g in a reversal" % steps)
    followed = levels[rows["frozen"]]
    expect(min(followed) > 1.15 and max(followed) < 1.45, "30 %% more friction: factors %s" % (followed,))
    still = set(factors[rows["frozen"] + 2:rows["free"]])
    expect(len(still) == 1 and rows["free"] - rows["frozen"] > 3000, "frozen, and they change", still)
    lower = levels[rows["reset"]]
    expect(max(lower) < min(followed) - 0.1, "free again: factors %s, before %s" % (lower, followed))
    # The reset acts in the cycle in which its pin rises; a reversal may follow at once.
    expect((1.0,) * 4 in [row[:2] + row[3:5] for row in factors[rows["reset"]:rows["reset"] + 100]], "not reset")
    faults = list(zip(run.column("ta.fault-code"), run.column("ta.fault-axis")))
    expect(max(faults[:rows["reversed"]]) == (0, -1), "faults", set(faults[:rows["reversed"]]))
    found = set(faults[rows["reversed"]:]) - {(0, -1)}
    expect(found == {(13, 0)}, "the wrong sign of friction: faults", found)
    expect(faults[-1] == (0, -1), "the fault stays after the reset", faults[-1])
    return "30 %% more friction: factors %.2f and %.2f; wrong sign: fault 13 of X until a reset" % followed


def on_trial(folder):
    """On trial, lag and friction act once they have shown that they help; where they harm they are led out, and said so."""
    lag = "[axis.X.dynamic]\nlag = true"
    run, rows = circles(folder, "on_trial", 1500, {"axis": "X", "fed": 0.93, "more": lag},
                        {"axis": "Y", "fed": 1.0, "more": ""})
    x, error = run.column("ta.joint.0.feed-forward"), run.column("ta.contour.tip.error")
    friction, lag = run.column("ta.friction-out"), run.column("ta.lag-out")

    def largest(column, start, stop):
        return max(abs(value) for value in column[start:stop])

    def turn_before(name):
        return rows[name] - 5000, rows[name]

    plain = largest(x, len(x) - 5000, len(x))
    untried, shown = largest(x, *turn_before("lag helps")), largest(x, *turn_before("lag harms"))
    expect(plain > 0.012 and untried < 0.4 * plain, "the lag part does not help and acts: %g of %g mm" % (untried, plain))
    expect(shown > 0.6 * plain, "the lag part helps and acts with %g of %g mm" % (shown, plain))
    expect(max(lag[rows["lag helps"] + 100:rows["lag harms"]]) == 0, "the lag part helps and was led out")
    expect(max(lag[rows["lag harms"]:rows["friction harms"]]) == 1, "the lag part harms and stays")
    led_out = largest(error, *turn_before("friction harms"))
    expect(led_out < 0.5 * plain, "the lag part harms: an error of %g mm is left" % led_out)
    expect(max(friction[:rows["friction harms"]]) == 0, "friction was led out before it harmed")
    expect(max(friction[rows["friction harms"]:rows["full"]]) == 1, "the friction part harms and stays")
    expect(max(friction[-200:]) == max(lag[-200:]) == 0, "without the trial something is still led out")
    expect(max(run.column("ta.fault-code")) == 0, "faults", set(run.column("ta.fault-code")))
    return "lag part: %.1f um before it helps, %.1f once shown, in full %.1f" % tuple(1e3 * v for v in (untried, shown, plain))


TESTS = (adaptation, on_trial)
