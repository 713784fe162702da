"""Scenarios of the simulated machine; run by pilot.py inside LinuxCNC. The checks have the expected results."""
import json
import os
import shutil
import subprocess
import time

import hal
import linuxcnc
import rig


def joints(count, *what):
    return [w % j for w in what for j in range(count)]


STREAM = ("joint.%d.pos-cmd", "joint.%d.motor-pos-cmd", "ta.joint.%d.motor-pos-cmd-out", "ta.joint.%d.motor-pos-fb-out",
          "joint.%d.f-error")
WHOLE = ["ta.active", "ta.limited", "ta.fault-code", "ta.stop-request", "ta.sequence"]


def program(pilot):
    """A program with arcs, lines and reversals, from power-on to its end."""
    pilot.record(joints(pilot.joints, *STREAM) + WHOLE)
    pilot.on()
    pilot.home()
    pilot.start_queued("program.ngc")
    pilot.finish()
    pilot.save("run")


def five_axes(pilot):
    """Like `program`, with the tip that LinuxCNC's kinematics want."""
    pilot.record(joints(5, *STREAM) + WHOLE + ["axis.x.pos-cmd", "axis.y.pos-cmd", "axis.z.pos-cmd"])
    pilot.on()
    pilot.home()
    pilot.start("program.ngc")
    pilot.finish()
    pilot.save("run")


def homing_offset(pilot):
    """Like `program`, but the joints are homed at a motor position that differs from the joint's."""
    program(pilot)


def break_off(pilot, marks):
    """Ends a program that is still running, and writes the recording and the marks."""
    marks["running"] = int(pilot.running())
    pilot.command.abort()
    pilot.wait(lambda: not pilot.running(), "abort")
    time.sleep(0.2)
    pilot.save("run")
    with open("marks.json", "w") as f:
        json.dump(marks, f)


def switching(pilot):
    """Enable, disable, reloads of good, damaged and missing files, and limits of the integrator, all in motion."""
    pilot.record(joints(3, *STREAM[:3]) + ["ta.active", "ta.limited", "ta.fault-code", "ta.reload-failed", "ta.tables-ok",
                                           "ta.reloads", "ta.tables-crc", "motion.current-vel"])
    pilot.on()
    pilot.home()
    pilot.start("shuttle.ngc")
    time.sleep(1.0)
    marks = {}

    def mark(name):
        pilot.poll()
        marks[name] = hal.get_value("ta.sequence")
        if hal.get_value("motion.current-vel") == 0.0:
            marks["standing at " + name] = 1

    def reload(name, source):
        shutil.copy(source, "mill-3axis.new")
        os.replace("mill-3axis.new", "mill-3axis.tcomp")
        mark(name)
        done = hal.get_value("ta.reloads")
        hal.set_p("ta.reload", "1")
        pilot.wait(lambda: hal.get_value("ta.reloads") != done, "reload", 10)
        time.sleep(0.02)
        hal.set_p("ta.reload", "0")
        time.sleep(0.5)

    hal.set_p("ta.enable", "0")
    mark("disable")
    time.sleep(0.6)
    hal.set_p("ta.enable", "1")
    mark("enable")
    time.sleep(0.6)
    reload("other tables", "other.tcomp")
    reload("damaged file", "damaged.tcomp")
    marks["code of damaged"] = hal.get_value("ta.reload-code")
    reload("another machine", "stranger.tcomp")
    marks["code of stranger"] = hal.get_value("ta.reload-code")
    reload("first tables", "first.tcomp")
    marks["failed after first"] = hal.get_value("ta.reload-failed")
    hal.set_p("ta.x.max-magnitude", "0.05")
    mark("limits not accepted")
    time.sleep(0.6)
    marks["tables-ok"] = hal.get_value("ta.tables-ok")
    hal.set_p("ta.x.max-magnitude", "0.1")
    mark("limits accepted")
    time.sleep(0.6)
    break_off(pilot, marks)


def dynamics(pilot):
    """Each part of the dynamic correction off and on again in motion, then all of them."""
    pins = ("joint.%d.motor-pos-cmd", "ta.joint.%d.motor-pos-cmd-out", "ta.joint.%d.dynamic", "ta.joint.%d.feed-forward",
            "ta.joint.%d.contour-feedback", "ta.joint.%d.crosstalk", "ta.joint.%d.learned")
    pilot.record(joints(3, *pins) + ["ta.fault-code", "ta.feedback-out", "ta.sequence"])
    pilot.on()
    pilot.home()
    pilot.mdi("G0 X-20 Y0 Z-20")
    hal.set_p("ta.x.learned", "0.002")
    hal.set_p("ta.y.learned", "-0.001")
    pilot.start("dynamics.ngc")
    time.sleep(1.5)
    marks = {}

    def switch(name, parts):
        for value, mark in (("0", "off"), ("1", "on")):
            marks["%s %s" % (name, mark)] = hal.get_value("ta.sequence")
            for part in parts:
                hal.set_p("ta.enable-" + part, value)
            time.sleep(0.6)

    feed_forward = ("friction", "lag", "acceleration")
    switch("feed-forward", feed_forward)
    for part in feed_forward + ("take-up",):
        switch(part, (part,))
    switch("contour-feedback", ("feedback",))
    switch("crosstalk", ("crosstalk",))
    switch("learned", ("learned",))
    switch("all", feed_forward + ("feedback", "crosstalk", "learned", "take-up"))
    pilot.poll()
    break_off(pilot, marks)


def circling(pilot, pins, seconds):
    """Begins to record, goes to the circles and turns on them; returns marks, and a function that adds one."""
    pilot.record(pins + ["ta.fault-code", "ta.fault-axis", "ta.stop-request", "ta.sequence"])
    pilot.on()
    pilot.home()
    pilot.mdi("G0 X20 Y0 Z-20")
    pilot.start("circles.ngc")
    time.sleep(seconds)
    marks = {}

    def mark(name):
        pilot.poll()
        marks[name] = hal.get_value("ta.sequence")

    return marks, mark


def adaptation(pilot):
    """Friction that adapts: the drives' friction rises, falls while it is frozen, and gets the wrong sign."""
    pins = joints(3, "ta.joint.%d.friction-factor", "ta.joint.%d.presliding-factor")
    marks, mark = circling(pilot, pins, 0.5)

    def drives(coulomb):
        for j in range(2):
            hal.set_p("dahl.%d.coulomb" % j, str(coulomb))

    def levels():
        return [hal.get_value("ta.joint.%d.friction-factor" % j) for j in range(2)]

    drives(0.65)
    pilot.wait(lambda: min(levels()) > 1.2, "adaptation", 30)
    hal.set_p("ta.adapt-freeze", "1")
    time.sleep(0.1)
    mark("frozen")
    drives(0.4)
    time.sleep(4)
    mark("free")
    hal.set_p("ta.adapt-freeze", "0")
    pilot.wait(lambda: max(levels()) < 1.0, "adaptation downwards", 30)
    mark("reset")
    hal.set_p("ta.adapt-reset", "1")
    time.sleep(0.2)
    hal.set_p("ta.adapt-reset", "0")
    drives(0.5)
    time.sleep(3)
    mark("reversed")
    hal.set_p("dahl.0.coulomb", "-0.4")
    pilot.wait(lambda: hal.get_value("ta.fault-code") != 0, "fault", 30)
    time.sleep(1)
    hal.set_p("dahl.0.coulomb", "0.5")
    time.sleep(1)
    hal.set_p("ta.adapt-reset", "1")
    time.sleep(0.5)
    break_off(pilot, marks)


def on_trial(pilot):
    """Parts on trial: X does not lag at first, then does as stated, then does not; then neither drive has friction."""
    pins = ["ta.joint.0.feed-forward", "ta.contour.tip.error", "ta.friction-out", "ta.lag-out"]
    for j in range(2):
        hal.set_p("dahl.%d.feed-forward" % j, "1")
    hal.set_p("ta.on-trial", "1")
    marks, mark = circling(pilot, pins, 8)
    # The trial starts again.
    mark("lag helps")
    hal.set_p("ta.on-trial", "0")
    hal.set_p("dahl.0.feed-forward", "0.93")
    time.sleep(0.1)
    hal.set_p("ta.on-trial", "1")
    time.sleep(8)
    mark("lag harms")
    hal.set_p("dahl.0.feed-forward", "1")
    time.sleep(8)
    mark("friction harms")
    for j in range(2):
        hal.set_p("dahl.%d.coulomb" % j, "0")
    time.sleep(8)
    mark("full")
    hal.set_p("ta.on-trial", "0")
    time.sleep(6)
    break_off(pilot, marks)


FAULTS = ["ta.joint.0.pos-cmd", "ta.active", "ta.frozen", "ta.fault-code", "ta.fault-axis", "ta.stop-request"]


def faults(pilot):
    """Dropouts, jumps and alarms of an encoder in motion; then a command that is not a number."""
    marks = {}
    pilot.record(joints(3, *STREAM[:4]) + FAULTS)
    pilot.on()
    pilot.home()
    pilot.start("shuttle.ngc")
    time.sleep(1.5)
    for value, pin in (("nan", "dropout.in"), ("inf", "dropout.in"), ("1000", "dropout.in"), ("0", "alarm.in")):
        hal.set_p("spoil-fb.in1", value)
        hal.set_p(pin, "1")
        time.sleep(0.2)
        hal.set_p(pin, "0")
        time.sleep(0.1)
        pilot.poll()
        marks["running after %s %s" % (pin, value)] = int(pilot.running())
    hal.set_p("break.in", "1")
    pilot.wait(lambda: pilot.stat.task_state == linuxcnc.STATE_ESTOP, "emergency stop", 5)
    hal.set_p("break.in", "0")
    time.sleep(0.3)
    marks["held"] = hal.get_value("ta.stop-request")
    pilot.on()
    marks["released"] = hal.get_value("ta.stop-request")
    pilot.command.teleop_enable(1)
    pilot.mdi("G1 X20 Y20 Z-20 F6000")
    time.sleep(0.3)
    pilot.save("run")
    with open("marks.json", "w") as f:
        json.dump(marks, f)


def homing(pilot):
    """A joint jogged before homing, homed with a move, unhomed where its correction is large, and homed again."""
    pilot.record(joints(3, *STREAM, "joint.%d.homed") + WHOLE)
    pilot.on()
    pilot.command.mode(linuxcnc.MODE_MANUAL)
    pilot.command.wait_complete()
    # Beyond the travel of the tables; before homing, positions mean nothing.
    pilot.command.jog(linuxcnc.JOG_INCREMENT, True, 0, 150, 400)
    pilot.wait(lambda: pilot.stat.joint_actual_position[0] > 399.999, "jog", 15)
    pilot.home()
    time.sleep(0.5)
    pilot.mdi("G0 X-250")
    time.sleep(0.3)
    pilot.command.mode(linuxcnc.MODE_MANUAL)
    pilot.command.wait_complete()
    pilot.command.teleop_enable(0)
    pilot.command.wait_complete()
    pilot.command.unhome(0)
    pilot.wait(lambda: not pilot.stat.homed[0], "unhoming")
    time.sleep(0.5)
    pilot.command.home(0)
    pilot.wait(lambda: all(pilot.stat.homed[:3]), "homing again")
    time.sleep(0.5)
    pilot.save("run")


def switched_off(pilot):
    """Drives that lag and keep their position without power: off, emergency stop and a bad command at full speed."""
    marks = {}
    pilot.record(joints(3, *STREAM[:3]) + ["ta.active", "ta.fault-code", "ta.stop-request", "motion.motion-enabled"])
    pilot.on()
    pilot.home()
    for name, stop in (("off", lambda: pilot.command.state(linuxcnc.STATE_OFF)),
                       ("estop", lambda: pilot.command.state(linuxcnc.STATE_ESTOP)),
                       ("bad command", lambda: hal.set_p("break.in", "1"))):
        pilot.start("shuttle.ngc")
        pilot.wait(lambda: hal.get_value("ta.active") and hal.get_value("motion.current-vel") > 140, "speed")
        stop()
        pilot.wait(lambda: pilot.stat.task_state != linuxcnc.STATE_ON, "stop after " + name, 5)
        hal.set_p("break.in", "0")
        time.sleep(0.4)
        pilot.poll()
        marks["stop requested after " + name] = hal.get_value("ta.stop-request")
        marks["lag after " + name] = abs(hal.get_value("ta.joint.0.motor-pos-cmd-out") - hal.get_value("drive-x.out"))
        pilot.on()
        marks["held when on again after " + name] = hal.get_value("ta.stop-request")
        pilot.command.teleop_enable(1)
        pilot.mdi("G1 X0 Y0 Z-20 F6000")
    time.sleep(0.3)
    pilot.save("run")
    with open("marks.json", "w") as f:
        json.dump(marks, f)


def probing(pilot):
    """A surface is at a true X of 40 mm; probed with and without correction, then touched off."""
    marks = {}
    pilot.on()
    pilot.home()
    for name, enable in (("with", "1"), ("without", "0")):
        hal.set_p("ta.enable", enable)
        # LinuxCNC refuses to move a probe that touches.
        hal.set_p("touch.in0", "1000")
        pilot.mdi("G0 X39.9")
        time.sleep(0.4)
        hal.set_p("touch.in0", "40")
        pilot.mdi("G38.2 X40.2 F6", 20)
        pilot.poll()
        marks["probed " + name] = pilot.stat.probed_position[0]
        marks["tripped " + name] = pilot.stat.probe_tripped
    hal.set_p("ta.enable", "1")
    hal.set_p("touch.in0", "1000")
    pilot.mdi("G0 X150")
    pilot.mdi("G10 L20 P1 X0")
    time.sleep(0.5)
    pilot.poll()
    marks["work offset"] = pilot.stat.g5x_offset[0]
    marks["true position"] = hal.get_value("truth.out")
    marks["motor position"] = hal.get_value("truth.in")
    with open("marks.json", "w") as f:
        json.dump(marks, f)


def calibration(pilot):
    """Runs a probing program, solves it, exchanges the tables while the machine is on, and runs the program again."""
    pilot.on()
    pilot.home()

    def probe(log):
        pilot.start("probe.ngc")
        # M0: the program waits until the artefact is set up.
        pilot.wait(lambda: pilot.stat.interp_state == linuxcnc.INTERP_PAUSED, "pause for the artefact")
        pilot.command.auto(linuxcnc.AUTO_RESUME)
        pilot.finish(100.0)
        logs = [name for name in os.listdir(".") if name.startswith("trueaxis-") and name.endswith(".log")]
        os.rename(logs[0], log)

    probe("first.log")
    words = [os.environ["TRUEAXIS"]]
    with open("first.json", "w") as f:
        subprocess.run(words + ["calibrate", "solve", "first.toml", "first.log", "-o", "machine", "--json"], check=True, stdout=f)
    subprocess.run(words + ["tables", "compile", "machine", "-o", "new.tcomp"], check=True)
    os.replace("new.tcomp", "mill-3axis.tcomp")
    done = hal.get_value("ta.reloads")
    hal.set_p("ta.reload", "1")
    pilot.wait(lambda: hal.get_value("ta.reloads") != done, "reload")
    if hal.get_value("ta.reload-failed"):
        raise RuntimeError("reload refused with %d" % hal.get_value("ta.reload-code"))
    probe("second.log")
    if hal.get_value("ta.fault-code"):
        raise RuntimeError("fault %d" % hal.get_value("ta.fault-code"))


STANDS = ((100, 50, -100), (-120, 80, -200), (40, -150, -20), (0, 0, 0))


def stands(pilot):
    """At several positions, in mm: commands, outputs to the drives and corrections once the machine is at rest."""
    pilot.on()
    pilot.home()
    found = []
    for place in STANDS:
        pilot.mdi("G21 G90 G0 X%g Y%g Z%g" % place)
        since = hal.get_value("ta.sequence")
        pilot.wait(lambda: not hal.get_value("ta.limited") and hal.get_value("ta.sequence") > since + 200, "rest")
        found.append({pin: [hal.get_value(pin % j) for j in range(3)]
                      for pin in ("joint.%d.pos-cmd", "ta.joint.%d.motor-pos-cmd-out", "ta.joint.%d.correction")})
    with open("stands.json", "w") as f:
        json.dump({"stands": found, "fault": hal.get_value("ta.fault-code")}, f)


def side_by_side(pilot):
    """LinuxCNC's own compensation and ours on the same table, in the same cycles."""
    pilot.record(["joint.0.pos-cmd", "joint.0.vel-cmd", "joint.0.backlash-corr", "joint.0.motor-pos-cmd", "ta.x.correction",
                  "ta.x.limited", "ta.active", "ta.fault-code", "joint.0.f-error"])
    pilot.on()
    pilot.home()
    pilot.start("comp.ngc")
    pilot.finish()
    pilot.save("run")


def contour(pilot):
    """Arcs and lines on drives that lag."""
    pilot.record(joints(3, "joint.%d.pos-cmd", "ta.joint.%d.motor-pos-fb-in") +
                 ["ta.contour.%s.%s" % (of, what)
                  for of in ("tip", "encoder") for what in ("error", "normal", "lag", "found", "searching")] +
                 ["ta.active", "ta.fault-code"])
    pilot.on()
    pilot.home()
    pilot.start("contour.ngc")
    pilot.finish()
    pilot.save("run")


def circles_in_inches(pilot):
    """record-circles.py on a machine in inches."""
    pilot.on()
    pilot.home()
    script = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "record-circles.py")
    words = ["--centre", "0,0", "--radius-mm", "10.0037", "--feeds", "6000,4000", "--turns", "1", "-o", "record.csv"]
    subprocess.run([script, *words, "--no-evaluation"], check=True, timeout=140 * rig.PATIENCE)


def friction(pilot):
    """Circles recorded by record-circles.py, as a user calls it."""
    pilot.on()
    pilot.home()
    script = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "record-circles.py")
    words = [script, "--centre", "0,0", "--radius-mm", "10.0037", "--feeds", "1200,500", "--turns", "1", "-o", "record.csv",
             "--no-evaluation"]
    # A circle beyond the travel is refused, and HAL stays as it was.
    far = subprocess.run([*words, "--radius-mm", "400"], capture_output=True, text=True, timeout=60 * rig.PATIENCE)
    if far.returncode != 2 or os.path.exists("record.csv"):
        raise RuntimeError("circles beyond the travel: exit code %d, %s" % (far.returncode, far.stderr))
    subprocess.run(words, check=True, timeout=140 * rig.PATIENCE)


ALL = {name: value for name, value in globals().items() if callable(value) and name not in ("joints", "circling")}
