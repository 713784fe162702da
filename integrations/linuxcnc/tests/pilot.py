#!/usr/bin/python3
"""Runs a simulated machine without a screen: LinuxCNC starts it in place of a user interface."""
import os
import subprocess
import sys
import threading
import time

import hal
import linuxcnc

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import rig
import scenarios
from recording import Recording

PINS_PER_SAMPLER = 20
HAL_TYPES = {1: "b", 2: "f", 3: "s", 4: "u"}


class Failed(Exception):
    pass


def halcmd(*words):
    """Runs one HAL command and returns its output."""
    done = subprocess.run(["halcmd", "-s", *words], capture_output=True, text=True, timeout=100)
    if done.returncode != 0:
        raise Failed("halcmd %s: %s" % (" ".join(words), done.stderr.strip()))
    return done.stdout


class Recorder:
    """Samples pins into memory in every servo cycle, after all other functions."""

    def __init__(self, component, pins):
        info = {pin["NAME"]: pin for pin in hal.get_info_pins()}
        groups = [pins[i : i + PINS_PER_SAMPLER] for i in range(0, len(pins), PINS_PER_SAMPLER)]
        shapes = ["".join(HAL_TYPES[info[pin]["TYPE"]] for pin in group) for group in groups]
        depth = ",".join("30000" for _ in groups)
        halcmd("loadrt", "sampler", "depth=" + depth, "cfg=" + ",".join(shapes))
        halcmd("newsig", "recording", "bit")
        for i, group in enumerate(groups):
            for k, pin in enumerate(group):
                words = halcmd("show", "pin", pin).split()
                signal = words[-1] if words[-2] in ("==>", "<==") else "recorded-%d-%d" % (i, k)
                halcmd("net", signal, pin, "sampler.%d.pin.%d" % (i, k))
            halcmd("net", "recording", "sampler.%d.enable" % i)
            # A signal takes the value of its first pin, here TRUE. Set it to 0, because all samplers must start in one
            # cycle.
            halcmd("sets", "recording", "0")
            halcmd("addf", "sampler.%d" % i, "servo-thread")
        self.pins = pins
        self.count = len(groups)
        self.streams = [hal.stream(component, hal.sampler_base + i, shape) for i, shape in enumerate(shapes)]
        self.parts = [[] for _ in groups]
        self.running = True
        self.thread = threading.Thread(target=self.drain, daemon=True)
        self.thread.start()
        halcmd("sets", "recording", "1")

    def drain(self):
        while self.running:
            self.empty()
            time.sleep(0.004)

    def empty(self):
        for stream, part in zip(self.streams, self.parts):
            while stream.readable:
                part.append(stream.read())

    def stop(self):
        halcmd("sets", "recording", "0")
        time.sleep(0.05)
        self.running = False
        self.thread.join()
        self.empty()
        for i in range(self.count):
            overruns = hal.get_value("sampler.%d.overruns" % i)
            if overruns:
                raise Failed("%d samples were lost" % overruns)
        rows = [sum(parts, ()) for parts in zip(*self.parts)]
        return Recording(self.pins, rows)


class Pilot:
    def __init__(self):
        self.component = hal.component("pilot")
        self.component.ready()
        self.command = linuxcnc.command()
        self.stat = linuxcnc.stat()
        self.errors = linuxcnc.error_channel()
        self.messages = []
        self.recorder = None
        self.joints = int(linuxcnc.ini(os.environ["INI_FILE_NAME"]).find("KINS", "JOINTS"))

    def poll(self):
        self.stat.poll()
        message = self.errors.poll()
        if message:
            self.messages.append(message[1])
            print("LinuxCNC:", message[1].strip(), flush=True)

    def wait(self, condition, what, seconds=20.0):
        end = time.time() + rig.PATIENCE * seconds
        while time.time() < end:
            self.poll()
            if condition():
                return
            time.sleep(0.005)
        raise Failed("no %s within %g s" % (what, seconds))

    def record(self, pins):
        self.recorder = Recorder(self.component, pins)

    def on(self):
        self.command.state(linuxcnc.STATE_ESTOP_RESET)
        self.command.wait_complete()
        self.wait(lambda: self.stat.task_state != linuxcnc.STATE_ESTOP, "estop reset")
        self.command.state(linuxcnc.STATE_ON)
        self.command.wait_complete()
        self.wait(lambda: self.stat.task_state == linuxcnc.STATE_ON, "machine on")

    def home(self):
        self.command.mode(linuxcnc.MODE_MANUAL)
        self.command.wait_complete()
        self.command.home(-1)
        self.wait(lambda: all(self.stat.homed[: self.joints]), "homing")
        self.command.teleop_enable(1)
        self.command.wait_complete()

    def start(self, path):
        self.command.mode(linuxcnc.MODE_AUTO)
        self.command.wait_complete()
        self.command.program_open(os.path.abspath(path))
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        self.wait(lambda: self.stat.interp_state != linuxcnc.INTERP_IDLE, "start of the program")

    def start_queued(self, path):
        """Like `start`, but nothing moves until the whole program is queued. The planner's accelerations depend on whether it
        already knows the next move, which otherwise depends on how busy the computer is."""
        halcmd("setp", "motion.feed-inhibit", "1")
        self.start(path)
        lengths = []

        def settled():
            lengths.append(self.stat.queue)
            return lengths[-1] > 0 and lengths[-200:] == [lengths[-1]] * 200

        self.wait(settled, "queue of the program")
        halcmd("setp", "motion.feed-inhibit", "0")

    def running(self):
        return self.stat.interp_state != linuxcnc.INTERP_IDLE

    def finish(self, seconds=60.0):
        self.wait(lambda: not self.running() and self.stat.inpos, "end of the program", seconds)
        time.sleep(0.3)
        self.poll()

    def mdi(self, line, seconds=20.0):
        self.command.mode(linuxcnc.MODE_MDI)
        self.command.wait_complete()
        self.command.mdi(line)
        self.command.wait_complete(seconds)
        self.wait(lambda: not self.running() and self.stat.inpos, "end of " + line, seconds)

    def save(self, name):
        recording = self.recorder.stop()
        recording.save(name)
        return recording


def main():
    name = os.environ["TRUEAXIS_SCENARIO"]
    pilot = Pilot()
    try:
        pilot.poll()
        scenarios.ALL[name](pilot)
    except Exception as failure:
        print("scenario %s: %s: %s" % (name, type(failure).__name__, failure), flush=True)
        with open("failed", "w") as f:
            f.write("%s\n" % failure)
        return 1
    with open("messages", "w") as f:
        f.writelines(message.strip() + "\n" for message in pilot.messages)
    with open("done", "w") as f:
        f.write("done\n")
    return 0


sys.exit(main())
