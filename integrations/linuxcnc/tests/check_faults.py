"""Tests faults during motion, and the operator's actions."""
import json
import math
import os

import limits
import machines
import rig
from machines import DEFAULT_LIMITS, SAMPLES, compile_tables, mill
from recording import Recording
from rig import expect


def marks_of(folder):
    with open(os.path.join(folder, "marks.json")) as f:
        return json.load(f)


def switching(folder):
    """Enables, disables, and reloads good and bad files in motion; limits are kept in every sample, and the path is never left."""
    mill(folder)
    source = os.path.join(SAMPLES, "mill-3axis")
    with open(os.path.join(folder, "mill-3axis.tcomp"), "rb") as f:
        first = f.read()
    for name, data in (("first.tcomp", first), ("damaged.tcomp", first[:700] + bytes([first[700] ^ 1]) + first[701:])):
        with open(os.path.join(folder, name), "wb") as f:
            f.write(data)
    machines.edited_tables(folder, source, "other", machines.scaled(0.2))
    machines.edited_tables(folder, source, "stranger", lambda text: text.replace('"mill-3axis"', '"stranger"'), None)
    rig.copy(folder, rig.HERE, "shuttle.ngc")
    printed = rig.linuxcnc(folder, "mill-3axis.ini", "switching")
    run, marks = Recording.load(os.path.join(folder, "run")), marks_of(folder)
    expect(not any("standing" in mark for mark in marks), "the machine did not move", marks)
    expect(marks["running"] == 1, "the program did not go on", marks)
    expect(marks["code of damaged"] == 6 and marks["code of stranger"] == 7, "codes of refused files", marks)
    expect(marks["failed after first"] == 0, "a good reload must clear the pin", marks)
    expect(marks["tables-ok"] == 0, "limits that are not accepted", marks)
    expect(max(run.column("ta.reloads")) == 4, "reloads", max(run.column("ta.reloads")))
    lines = [line for line in printed.splitlines() if line.startswith("LinuxCNC: trueaxis: ta: reload: ")]
    expect(len(lines) == 2, "two refusals, one message to the operator each", printed[-3000:])
    expect(max(run.column("ta.fault-code")) == 0, "faults")
    crcs = set(run.column("ta.tables-crc"))
    expect(len(crcs - {0.0}) == 2, "two tables were in force", crcs)
    used = limits.all_kept(run, 3, [DEFAULT_LIMITS] * 3)
    # Switched off, the correction must really disappear, and return when it is switched on.
    x = [out - cmd for cmd, out in run.columns("joint.0.motor-pos-cmd", "ta.joint.0.motor-pos-cmd-out")]
    active = run.column("ta.active")
    gone = sum(1 for c, a in zip(x, active) if not a and c == 0.0)
    expect(gone > 300 and max(abs(c) for c in x) > 0.01, "correction in motion", gone, max(map(abs, x)))
    return "2 reloads, 2 refused, limits used %s" % " ".join("%.2f" % u for u in used)


SPOILED = """
loadrt mux2 names=spoil-fb,spoil-cmd
loadrt oneshot names=dropout,alarm,break
addf dropout servo-thread 1
addf alarm servo-thread 2
addf break servo-thread 3
addf spoil-fb servo-thread 4
addf spoil-cmd servo-thread 8
setp dropout.width 0.02
setp alarm.width 0.02
setp break.width 0.0005
setp spoil-cmd.in1 nan
net dropout dropout.out => spoil-fb.sel
net alarm alarm.out => ta.joint.0.alarm
net break break.out => spoil-cmd.sel
net x-drive ta.joint.0.motor-pos-cmd-out => spoil-fb.in0
net x-encoder spoil-fb.out => ta.joint.0.motor-pos-fb-in
net y-drive ta.joint.1.motor-pos-cmd-out => ta.joint.1.motor-pos-fb-in
net z-drive ta.joint.2.motor-pos-cmd-out => ta.joint.2.motor-pos-fb-in
net x-pos-cmd => spoil-cmd.in0
net x-spoiled spoil-cmd.out => ta.joint.0.pos-cmd
"""


def faults(folder):
    """Bad readings freeze the correction and the path continues; a command that is not a number stops the machine."""
    mill(folder, machines.geometry_alone)
    rig.copy(folder, rig.HERE, "shuttle.ngc")
    for key in ("FERROR", "MIN_FERROR"):
        rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(text, "JOINT_0", key, 2000))
    rig.edit(folder, "trueaxis.hal", lambda text: text.replace(
        "net x-pos-cmd  joint.0.pos-cmd       => ta.joint.0.pos-cmd\n", "net x-pos-cmd  joint.0.pos-cmd\n"))
    with open(os.path.join(folder, "drives.hal"), "w") as f:
        f.write(SPOILED)
    rig.linuxcnc(folder, "mill-3axis.ini", "faults")
    run, marks = Recording.load(os.path.join(folder, "run")), marks_of(folder)
    expect(all(value for mark, value in marks.items() if "running" in mark), "the program stopped", marks)
    expect(marks["held"] == 1 and marks["released"] == 0, "stop and reset", marks)
    code = [int(c) for c in run.column("ta.fault-code")]
    for wanted, what in ((1, "not a number"), (2, "jump"), (4, "alarm"), (16, "command")):
        expect(wanted in code, "no fault %d, %s" % (wanted, what), sorted(set(code)))
    stop = code.index(16)
    expect(set(code[:stop]) <= {0, 1, 2, 4}, "other faults", sorted(set(code)))
    frozen = frozen_on_the_path(run, code[:stop])
    held = held_until_reset(run, stop)
    expect(run.column("ta.active")[-1] == 1 and code[-1] == 0, "not corrected again after the reset")
    return "%d samples frozen on the path, %d held" % (frozen, held)


def frozen_on_the_path(run, code):
    frozen = run.column("ta.frozen")
    cmd, out = run.column("joint.0.motor-pos-cmd"), run.column("ta.joint.0.motor-pos-cmd-out")
    back = run.column("ta.joint.0.motor-pos-fb-out")
    expect(all(math.isfinite(b) for b in back), "motion saw a reading that is not a number")
    count = 0
    for n in range(1, len(code)):
        if code[n] in (1, 2, 4):
            change = (out[n] - cmd[n]) - (out[n - 1] - cmd[n - 1])
            expect(frozen[n] and abs(change) < 1e-12, "not frozen in sample %d" % n)
            expect(cmd[n] != cmd[n - 1], "the machine left its path in sample %d" % n)
            count += 1
    return count


def held_until_reset(run, stop):
    requested = run.column("ta.stop-request")
    expect(math.isnan(run.column("ta.joint.0.pos-cmd")[stop]), "the stop has another reason")
    over = next(n for n in range(stop, len(requested)) if not requested[n])
    for j in range(3):
        sent = run.column("ta.joint.%d.motor-pos-cmd-out" % j)
        expect(all(math.isfinite(v) for v in sent), "a drive was sent a value that is not a number")
        expect(len(set(sent[stop - 1 : over])) == 1, "joint %d moved during the stop" % j)
        jump = abs(sent[over] - sent[over - 1])
        expect(jump < 0.051, "joint %d jumped by %g mm at the reset" % (j, jump))
    return over - stop


POWERED = """
loadrt mux2 names=power-x,power-y,power-z,spoil-cmd
loadrt lowpass names=drive-x,drive-y,drive-z
loadrt oneshot names=break
loadrt not names=unstopped
loadrt and2 names=power
addf break servo-thread 1
addf spoil-cmd servo-thread 6
addf unstopped servo-thread
addf power servo-thread
net stop-request => unstopped.in
net unstopped unstopped.out => power.in0
net amplifiers joint.0.amp-enable-out => power.in1
net power power.out => power-x.sel power-y.sel power-z.sel
setp break.width 0.0005
setp spoil-cmd.in1 nan
net break break.out => spoil-cmd.sel
net x-pos-cmd => spoil-cmd.in0
net x-spoiled spoil-cmd.out => ta.joint.0.pos-cmd
"""
for _j, _axis in enumerate("xyz"):
    POWERED += """addf power-{0} servo-thread
addf drive-{0} servo-thread
setp drive-{0}.gain 0.2
net {0}-drive ta.joint.{1}.motor-pos-cmd-out => power-{0}.in1
net {0}-wanted power-{0}.out => drive-{0}.in
net {0}-encoder drive-{0}.out => power-{0}.in0 ta.joint.{1}.motor-pos-fb-in
""".format(_axis, _j)


def switched_off(folder):
    """Without power, LinuxCNC's command jumps to the drives' position, which is no fault and causes no permanent stop."""
    mill(folder, machines.geometry_alone)
    rig.copy(folder, rig.HERE, "shuttle.ngc")
    for j in range(3):
        rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(text, "JOINT_%d" % j, "MIN_FERROR", 3))
    rig.edit(folder, "trueaxis.hal", lambda text: text.replace(
        "net x-pos-cmd  joint.0.pos-cmd       => ta.joint.0.pos-cmd\n", "net x-pos-cmd  joint.0.pos-cmd\n"))
    with open(os.path.join(folder, "drives.hal"), "w") as f:
        f.write(POWERED)
    rig.linuxcnc(folder, "mill-3axis.ini", "switched_off")
    run, marks = Recording.load(os.path.join(folder, "run")), marks_of(folder)
    expect(not marks["stop requested after off"] and not marks["stop requested after estop"], "a stop for nothing", marks)
    expect(marks["stop requested after bad command"] and marks["lag after bad command"] > 0.1, "no stop", marks)
    expect(not any(value for mark, value in marks.items() if "on again" in mark), "still held", marks)
    expect(set(run.column("ta.fault-code")) == {0, 16}, "faults", set(run.column("ta.fault-code")))
    expect(run.column("ta.active")[-1] == 1, "not corrected again", marks)
    cmd = run.column("joint.0.motor-pos-cmd")
    jump = max(abs(b - a) for a, b in zip(cmd, cmd[1:]))
    expect(jump > 0.375, "the command never jumped by more than the tables permit", jump)
    return "command jumped by %.2f mm; left a stop %.2f mm away" % (jump, marks["lag after bad command"])


TRUTH = """
loadrt scale names=truth
loadrt comp names=touch
addf truth servo-thread
addf touch servo-thread
setp truth.gain 1.0001
setp touch.in0 40.0
net x-drive => truth.in
net x-true truth.out => touch.in1
net touched touch.out => motion.probe-input
"""


def probing(folder):
    """The position that G38 measures and a touch-off sets is the tool's true one; the plant's error is known in closed form."""
    mill(folder)
    compile_tables(folder, os.path.join(rig.MACHINES, "stream", "machine.toml"), "mill-3axis.tcomp")
    rig.edit(folder, "drives.hal", lambda text: text + TRUTH)
    rig.edit(folder, "mill-3axis.ini", machines.narrow)
    rig.linuxcnc(folder, "mill-3axis.ini", "probing")
    marks = marks_of(folder)
    expect(marks["tripped with"] and marks["tripped without"], "no contact", marks)
    found, bare = marks["probed with"], marks["probed without"]
    # 6 mm/min is 0.1 um per cycle, and the contact is detected up to two cycles late.
    expect(abs(found - 40.0) < 4e-4, "probed %r, the surface is at 40" % found)
    expect(abs(bare - 40.0 / 1.0001) < 4e-4, "without correction %r" % bare)
    expect(abs(marks["work offset"] - marks["true position"]) < 1e-9, "touch-off", marks)
    expect(abs(marks["motor position"] - marks["true position"]) > 0.01, "nothing was corrected", marks)
    return "surface at 40 mm: %.4f with, %.4f without correction; touch-off within %.0e mm" % (
        found, bare, abs(marks["work offset"] - marks["true position"]))


TESTS = (switching, faults, switched_off, probing)
