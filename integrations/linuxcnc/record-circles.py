#!/usr/bin/python3
"""Records circles of two axes on a running LinuxCNC and finds their friction.

    record-circles.py --axes X,Y --centre 0,0 -o record.csv
    record-circles.py --axes X,Y --centre 0,0 --machine mymill/machine.toml -o record.csv --friction friction.toml

The machine is on, homed and idle; nothing is in the way of circles of --radius-mm about --centre. The program moves to
the first point at feed, then twice round in either direction at each of two feeds, and leaves the axes there. Every servo
cycle, `sampler` records the drives' commands and the encoders' readings; `trueaxis friction` evaluates it.

RECORD.csv: t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm, in mm on a machine in inches too ([TRAJ]LINEAR_UNITS; `sampler` then resolves
25 nm). A reading is taken at the start of a cycle, before the new command: the rows
pair each command with the reading of the cycle after it. Exit code 0: done; 2: refused, with the value found and the value needed.
"""
import argparse
import fcntl
import glob
import math
import os
import subprocess
import sys
import tempfile
import time

import linuxcnc

START = 0.5  # rad: where the circles begin and end, no axis turns
DWELL_S = 0.3


class Refused(Exception):
    pass


def halcmd(*words):
    """Runs one HAL command and returns its output."""
    done = subprocess.run(["halcmd", "-s", *words], capture_output=True, text=True, timeout=20)
    if done.returncode != 0:
        raise Refused("halcmd %s: %s" % (" ".join(words), done.stderr.strip()))
    return done.stdout


def exists(pin):
    return any(line.split()[-1:] == [pin] or pin in line.split() for line in halcmd("show", "pin", pin).splitlines())


def pins_of(joint):
    """Returns the pins of a joint's drive command and encoder reading: trueaxis' pins if it is loaded, else motion's."""
    if exists("ta.joint.%d.motor-pos-cmd-out" % joint):
        return ["ta.joint.%d.motor-pos-cmd-out" % joint, "ta.joint.%d.motor-pos-fb-in" % joint]
    return ["joint.%d.motor-pos-cmd" % joint, "joint.%d.motor-pos-fb" % joint]


def servo_period_s():
    for line in halcmd("show", "thread").splitlines():
        words = line.split()
        if "servo-thread" in words:
            return 1e-9 * float(words[0])
    raise Refused("HAL: found no servo-thread, needed the thread of motion")


class Sampler:
    """Records pins into a file in every servo cycle, after all other functions."""

    def __init__(self, pins, path):
        if "sampler" in halcmd("list", "comp").split():
            raise Refused("HAL: found sampler loaded already, needed it for this record: unload it first")
        self.signals = []
        halcmd("loadrt", "sampler", "depth=20000", "cfg=" + "f" * len(pins))
        for i, pin in enumerate(pins):
            words = halcmd("show", "pin", pin).split()
            signal = words[-1] if words[-2] in ("==>", "<==") else "circles-%d" % i
            if signal.startswith("circles-"):
                halcmd("net", signal, pin)
                self.signals.append(signal)
            halcmd("net", signal, "sampler.0.pin.%d" % i)
        self.file = open(path, "w")
        self.program = subprocess.Popen(["halsampler", "-t"], stdout=self.file, stdin=subprocess.DEVNULL)
        halcmd("addf", "sampler.0", "servo-thread")

    def stop(self):
        try:
            halcmd("delf", "sampler.0", "servo-thread")
            time.sleep(0.3)
            overruns = int(halcmd("getp", "sampler.0.overruns"))
        finally:
            self.program.terminate()
            self.program.wait(10)
            self.file.close()
            halcmd("unloadrt", "sampler")
            for signal in self.signals:
                halcmd("delsig", signal)
        if overruns:
            raise Refused("sampler: found %d samples lost, needed none: a quieter computer" % overruns)


class Machine:
    def __init__(self):
        self.command = linuxcnc.command()
        self.stat = linuxcnc.stat()
        self.errors = linuxcnc.error_channel()

    def ready(self, joints):
        self.stat.poll()
        if self.stat.task_state != linuxcnc.STATE_ON:
            raise Refused("machine: found it off, needed it on")
        # Earlier messages do not concern this run.
        while self.errors.poll():
            pass
        if not all(self.stat.homed[joint] for joint in joints):
            raise Refused("machine: found joints that are not homed, needed all")
        if self.stat.interp_state != linuxcnc.INTERP_IDLE:
            raise Refused("machine: found a program under way, needed it idle")

    def mm_per_unit(self):
        """Scale of the pins: LinuxCNC gives the machine units per millimetre."""
        return 1.0 / self.stat.linear_units

    def mdi(self, line, seconds):
        self.command.mode(linuxcnc.MODE_MDI)
        self.command.wait_complete()
        self.command.mdi(line)
        end = time.time() + seconds
        time.sleep(0.05)
        while time.time() < end:
            self.stat.poll()
            message = self.errors.poll()
            if message:
                raise Refused("%s: %s" % (line, message[1].strip()))
            if self.stat.interp_state == linuxcnc.INTERP_IDLE and self.stat.inpos and not self.stat.queue:
                return
            time.sleep(0.02)
        self.command.abort()
        raise Refused("%s: found no end within %.0f s" % (line, seconds))


def circles(axes, centre, radius, feeds, turns):
    """Returns lines of G-code, and the time that each may take, s."""
    plane = {"XY": ("G17", "I", "J"), "ZX": ("G18", "K", "I"), "YZ": ("G19", "J", "K")}["".join(axes)]
    point = [centre[i] + radius * f(START) for i, f in enumerate((math.cos, math.sin))]
    to_centre = [-radius * math.cos(START), -radius * math.sin(START)]
    target = " ".join("%s%.6f" % pair for pair in zip(axes, point))
    arc = " ".join("%s%.6f" % pair for pair in zip(plane[1:], to_centre))
    yield "G21 G90 G94 G61 %s G1 %s F%g" % (plane[0], target, max(feeds)), 120.0
    for feed in feeds:
        for code in ("G3", "G2"):
            seconds = 60.0 * 2.0 * math.pi * radius * turns / feed
            yield "%s %s %s P%d F%g" % (code, target, arc, turns, feed), 2.0 * seconds + 20.0


def rows(path, columns, period_s, mm_per_unit):
    """Returns time, command and following reading of each axis, mm; refuses gaps."""
    samples, last = [], None
    with open(path) as f:
        for line in f:
            words = line.split()
            if len(words) != 1 + columns:
                raise Refused("halsampler: found %r, needed a number and %d values" % (line.strip(), columns))
            number = int(words[0])
            if last is not None and number != last + 1:
                raise Refused("halsampler: found sample %d after %d, needed every cycle" % (number, last))
            last = number
            samples.append([mm_per_unit * float(word) for word in words[1:]])
    for k in range(len(samples) - 1):
        row = ["%.6f" % (k * period_s)]
        for axis in range(columns // 2):
            row += ["%.6f" % samples[k][2 * axis], "%.6f" % samples[k + 1][2 * axis + 1]]
        yield row


def record(options):
    axes = options.axes.upper().split(",")
    if "".join(axes) not in ("XY", "ZX", "YZ"):
        raise Refused("--axes: found %s, needed X,Y, Z,X or Y,Z" % options.axes)
    feeds = [float(feed) for feed in options.feeds.split(",")]
    centre = [float(value) for value in options.centre.split(",")]
    joints = [int(j) for j in options.joints.split(",")] if options.joints else ["XYZ".index(a) for a in axes]
    for name, found in (("--feeds", feeds), ("--centre", centre), ("--joints", joints)):
        if len(found) != 2:
            raise Refused("%s: found %d values, needed two" % (name, len(found)))
    refuse_inputs(options)
    machine = Machine()
    machine.ready(joints)
    pins = [pin for joint in joints for pin in pins_of(joint)]
    period_s = servo_period_s()
    lines = list(circles(axes, centre, options.radius_mm, feeds, options.turns))
    machine.mdi(*lines[0])
    handle, raw = tempfile.mkstemp(prefix="circles-")
    os.close(handle)
    try:
        sampler = Sampler(pins, raw)
        try:
            time.sleep(DWELL_S)
            for line, seconds in lines[1:]:
                print("record-circles: %s" % line, file=sys.stderr, flush=True)
                machine.mdi(line, seconds)
                time.sleep(DWELL_S)
        finally:
            sampler.stop()
        names = ["%s%s_mm" % (a.lower(), what) for a in axes for what in ("_cmd", "")]
        text = ",".join(["t_s"] + names) + "\n"
        text += "".join(",".join(row) + "\n" for row in rows(raw, len(pins), period_s, machine.mm_per_unit()))
    finally:
        os.remove(raw)
    write(options.output, text)


def write(output, text):
    """Writes a file atomically: beside its destination, flushed, renamed, the folder flushed. A failure leaves the old one."""
    target = os.path.realpath(output)
    if os.path.exists(target) and not os.path.isfile(target):
        with open(target, "w") as device:
            device.write(text)
        return
    folder = os.path.dirname(target)
    sweep(target)
    beside = "%s.%06d.trueaxis-tmp" % (target, os.getpid() % 1000000)
    try:
        with open(beside, "w") as f:
            fcntl.flock(f, fcntl.LOCK_EX | fcntl.LOCK_NB)
            f.write(text)
            f.flush()
            os.fsync(f.fileno())
        os.replace(beside, target)
    except BaseException:
        if os.path.exists(beside):
            os.remove(beside)
        raise
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def sweep(target):
    """Removes files that a killed command left beside the target. A command that is still writing holds a lock."""
    for left in glob.glob(glob.escape(target) + ".??????.trueaxis-tmp"):
        try:
            with open(left, "r+") as f:
                fcntl.flock(f, fcntl.LOCK_EX | fcntl.LOCK_NB)
                os.remove(left)
        except OSError:
            pass


def refuse_inputs(options):
    """Refuses to overwrite a file that the evaluation reads."""
    outputs = [options.output, options.friction]
    for output in filter(None, outputs):
        if options.machine and os.path.exists(output) and os.path.exists(options.machine):
            if os.path.samefile(output, options.machine):
                raise Refused("%s: found the input %s, needed another file" % (output, options.machine))


def evaluate(options):
    words = [options.trueaxis, "friction", options.output, "--axes", options.axes.upper()]
    words += ["--machine", options.machine] if options.machine else []
    words += ["-o", options.friction] if options.friction else []
    words += ["--report", options.report] if options.report else []
    return subprocess.run(words).returncode


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--axes", default="X,Y", help="plane of the circles: X,Y (default), Z,X or Y,Z")
    parser.add_argument("--joints", help="joints of the axes (default: X 0, Y 1, Z 2)")
    parser.add_argument("--centre", required=True, help="centre of the circles, mm, in the work coordinates in force")
    parser.add_argument("--radius-mm", type=float, default=25.0037, help="default 25.0037: not a multiple of a scale's period")
    parser.add_argument("--feeds", default="1500,600", help="mm/min, two (default 1500,600)")
    parser.add_argument("--turns", type=int, default=2, help="turns of each circle (default 2)")
    parser.add_argument("--machine", help="machine.toml that states the drives' figures")
    parser.add_argument("--friction", help="TOML file for the friction found")
    parser.add_argument("--report", help="folder for a page with the spikes")
    parser.add_argument("--trueaxis", default="trueaxis", help="the program trueaxis (default: found in PATH)")
    parser.add_argument("--no-evaluation", action="store_true", help="only record")
    parser.add_argument("-o", "--output", required=True, help="the record, CSV")
    options = parser.parse_args()
    try:
        record(options)
    except (Refused, OSError, ValueError) as refused:
        print("record-circles: %s" % refused, file=sys.stderr)
        return 2
    return 0 if options.no_evaluation else evaluate(options)


if __name__ == "__main__":
    sys.exit(main())
