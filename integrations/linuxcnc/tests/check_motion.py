"""Tests a whole simulated machine of three axes that runs a program."""
import json
import os
import subprocess

import limits
import machines
import rig
from machines import DEFAULT_LIMITS, mill
from recording import Recording
from rig import Broken, expect

REPLAY = os.environ["TRUEAXIS_REPLAY"]


def replayed(folder, tables, joints, name="run"):
    return subprocess.run([REPLAY, "replay", tables, name, "--joints", joints], cwd=folder, capture_output=True,
                          text=True, timeout=60 * rig.PATIENCE)


def replay(folder, tables, joints):
    done = replayed(folder, tables, joints)
    expect(done.returncode == 0, "replay", done.stdout, done.stderr)
    return json.loads(done.stdout)


def controls(folder, run):
    """Checks that both checkers detect the smallest violation in a single sample."""
    spoiled = Recording(run.names, [list(row) for row in run.rows])
    middle = len(spoiled.rows) // 2
    spoiled.rows[middle][run.place["ta.joint.1.motor-pos-cmd-out"]] += 1e-11
    spoiled.save(os.path.join(folder, "spoiled"))
    expect(replayed(folder, "mill-3axis.tcomp", "XYZ", "spoiled").returncode != 0, "replay does not see 1e-11 mm")
    spoiled.rows[middle][run.place["ta.joint.1.motor-pos-cmd-out"]] += 1e-2
    try:
        limits.all_kept(spoiled, 3, [DEFAULT_LIMITS] * 3)
    except Broken:
        return
    raise Broken("the check of the limits does not see 10 um")


def largest(recording, pin):
    return max(abs(value) for value in recording.column(pin))


def from_first_motion(recording, joints):
    """Returns the rows from the first change of a command after homing."""
    commands = recording.columns(*("joint.%d.pos-cmd" % j for j in range(joints)))
    active = recording.column("ta.active")
    first = next(n for n in range(1, len(commands)) if active[n - 1] and commands[n] != commands[n - 1])
    return recording.cut(first - 1)


def program(folder):
    """A whole machine runs a program: the library's own result, no following error, limits kept, repeatable bit for bit."""
    mill(folder, machines.geometry_alone)
    runs = []
    for again in range(2):
        rig.linuxcnc(folder, "mill-3axis.ini", "program")
        run = Recording.load(os.path.join(folder, "run"))
        if not again:
            agreement = replay(folder, "mill-3axis.tcomp", "XYZ")
        os.remove(os.path.join(folder, "done"))
        runs.append(run)
    first = runs[0]
    controls(folder, runs[1])
    expect(agreement["samples"] > 10000 and agreement["largest_correction"] > 0.01, "nothing was corrected", agreement)
    expect(max(first.column("ta.fault-code")) == 0, "faults in an ordinary run")
    ferror = max(largest(first, "joint.%d.f-error" % j) for j in range(3))
    expect(ferror < 1e-9, "following error %g mm" % ferror)
    used = limits.all_kept(first, 3, [DEFAULT_LIMITS] * 3)
    streams = [from_first_motion(run, 3) for run in runs]
    names = [n for n in first.names if n != "ta.sequence"]
    length = min(len(s.rows) for s in streams)
    expect(length > 5000, "only %d samples in motion" % length)
    for a, b in zip(streams[0].columns(*names)[:length], streams[1].columns(*names)[:length]):
        expect(a == b, "two runs differ", a, b)
    return "%d samples, %.0e mm from the library (%.3f %% same bits), f-error %.0e mm, limits used %s" % (
        agreement["samples"], agreement["largest_difference"], 100.0 * agreement["same_bits"] / agreement["samples"],
        ferror, " ".join("%.2f" % u for u in used))


def homing_offset(folder):
    """Homed 37 mm from the motor's zero, with dynamic correction, the result at the same position is the same."""
    mill(folder)
    for j in (0, 1):
        rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(text, "JOINT_%d" % j, "HOME_OFFSET", 37))
    rig.linuxcnc(folder, "mill-3axis.ini", "homing_offset")
    run = Recording.load(os.path.join(folder, "run"))
    offset = run.column("joint.0.motor-pos-cmd")[-1] - run.column("joint.0.pos-cmd")[-1]
    expect(abs(abs(offset) - 37.0) < 1e-9, "the homing offset is %g" % offset)
    agreement = replay(folder, "mill-3axis.tcomp", "XYZ")
    expect(agreement["largest_dynamic"] > 0.01, "nothing dynamic was corrected", agreement)
    ferror = max(largest(from_first_motion(run, 3), "joint.%d.f-error" % j) for j in range(3))
    expect(ferror < 1e-9, "following error %g mm" % ferror)
    return "motor at %+g mm, %.0e mm from the library, f-error %.0e mm" % (
        offset, agreement["largest_difference"], ferror)


def homing(folder):
    """Inactive until homed, whatever is jogged; homing and unhoming move no drive, apart from the fading correction."""
    mill(folder, machines.geometry_alone)
    for key, value in (("HOME", 200), ("HOME_OFFSET", 250), ("HOME_FINAL_VEL", 100)):
        rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(text, "JOINT_0", key, value))
    rig.linuxcnc(folder, "mill-3axis.ini", "homing")
    run = Recording.load(os.path.join(folder, "run"))
    expect(max(run.column("ta.fault-code")) == 0 and max(run.column("ta.stop-request")) == 0, "faults",
           set(run.column("ta.fault-code")))
    ferror = max(largest(run, "joint.%d.f-error" % j) for j in range(3))
    expect(ferror < 1e-9, "following error %g mm" % ferror)
    used = limits.all_kept(run, 3, [DEFAULT_LIMITS] * 3)
    homed = [all(row) for row in run.columns(*("joint.%d.homed" % j for j in range(3)))]
    expect([bool(a) for a in run.column("ta.active")] == homed, "active is not homed")
    turns = [n for n in range(1, len(homed)) if homed[n] != homed[n - 1]]
    expect(len(turns) == 3, "homed, unhomed, homed", turns)
    cmd, out = run.column("joint.0.motor-pos-cmd"), run.column("ta.joint.0.motor-pos-cmd-out")
    expect(max(run.column("joint.0.pos-cmd")[: turns[0]]) > 399.0 and out[: turns[0]] == cmd[: turns[0]],
           "corrected before homing")
    expect(abs(out[turns[1] - 1] - cmd[turns[1] - 1]) > 0.005, "no correction to fade")
    expect(out[turns[2] - 1] == cmd[turns[2] - 1], "the correction did not go when unhomed")
    jump = max(abs(b - a) for a, b in zip(out, out[1:]))
    expect(jump < 0.201, "a drive was sent %g mm in a cycle" % jump)
    return "nothing before homing, limits used %s" % " ".join("%.2f" % u for u in used)


TESTS = (program, homing_offset, homing)
