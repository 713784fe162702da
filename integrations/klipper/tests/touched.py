"""Simulates a machine with a ball and a ring on it, and where its probe triggers.

The drives' positions follow from their steps since homing. The tip deviates by scale and squareness, by the formula below,
and meets a ball from outside or a ring from inside.

SPDX-License-Identifier: GPL-3.0-or-later
"""
import json
import math
import shutil
import subprocess

SCALE_X, SCALE_Y, SQUARENESS = 60e-6, -40e-6, 150e-6  # C0Y: X moves by -C0Y y
TIP = 3.0 - 0.008  # mm, effective
BALL, BALL_DIAMETER = (40.0, 40.0, -150.0), 25.0
RING, RING_DIAMETER = (130.0, 120.0, -100.0), 100.0
OFF = (0.21, -0.34, 0.15)  # a person places them
MACHINE = 'name = "router"\nchain = "w Y\' b Z X t"\n' + "".join(
    f"\n[axis.{axis}]\ntravel_mm = [{low}.0, {high}.0]\n" for axis, low, high in (("X", 0, 200), ("Y", 0, 200), ("Z", -300, 0)))
TASK = f"""machine = "router"
dialect = "klipper"
[probe]
tip_radius_mm = 3.0
tip_uncertainty_um = 20.0
repeats = 1
[[artefact]]
name = "ball"
kind = "ball"
diameter_mm = {BALL_DIAMETER}
uncertainty_um = 0.2
[[artefact.place]]
at_mm = {list(BALL)}
[[artefact]]
name = "ring"
kind = "ring"
diameter_mm = {RING_DIAMETER}
uncertainty_um = 0.2
points = 24
[[artefact.place]]
at_mm = {list(RING)}
"""
SECTIONS = "[pause_resume]\n[trueaxis_probe]\npin: ^PA30\n[touched]\n"
ABSENT = "TRUEAXIS_PROBE ID=1 X=101 F=60\n"
WITHIN = "G1 X60 Y40 Z-150 F3000\nTRUEAXIS_PROBE ID=1 X=30 F=6000\nTRUEAXIS_PROBE ID=2 X=29 F=60\n"
START = "SET_KINEMATIC_POSITION X=100 Y=100 Z=-50\nG90\n"


def program(trueaxis, folder):
    """Returns the planned program; writes its machine and task into the folder."""
    (folder / "router").mkdir(parents=True, exist_ok=True)
    (folder / "router/machine.toml").write_text(MACHINE)
    (folder / "task.toml").write_text(TASK)
    subprocess.run([trueaxis, "calibrate", "plan", folder / "task.toml", "-o", folder / "program.gcode"], check=True, stdout=subprocess.DEVNULL)
    return START + (folder / "program.gcode").read_text()


def check(trueaxis, folder, log):
    """Solves the log; returns, for each scale and squareness, name, value, standard error and truth, ppm and urad."""
    shutil.rmtree(folder / "solved", ignore_errors=True)
    run = subprocess.run([trueaxis, "calibrate", "solve", folder / "task.toml", log, "-o", folder / "solved", "--json"], check=True, capture_output=True, text=True)
    truth = {"squareness C0Y": SQUARENESS, "scale of X": SCALE_X, "scale of Y": SCALE_Y}
    terms = [term for term in json.loads(run.stdout)["terms"] if term["name"] in truth]
    return [(term["name"], term["value"], term["standard_error"], 1e6 * truth[term["name"]]) for term in terms]


class Touched:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.printer.register_event_handler("klippy:connect", self.connect)
        self.zero = None

    def connect(self):
        self.toolhead = self.printer.lookup_object("toolhead")
        self.kin = self.toolhead.get_kinematics()
        endstop = self.printer.lookup_object("trueaxis_probe").endstop
        self.home_start, self.home_wait = endstop.home_start, endstop.home_wait
        endstop.home_start, endstop.home_wait = self.start, self.trip

    def start(self, print_time, *args, **kwargs):
        self.begun = print_time
        if self.zero is None:
            self.zero = {s.get_name(): s.get_commanded_position() - s.get_mcu_position() * s.get_step_dist() for s in self.kin.get_steppers()}
        return self.home_start(print_time, *args, **kwargs)

    def gap(self, time):
        """Returns the gap between the tip and the nearest surface, mm."""
        at = {s.get_name(): s.get_past_mcu_position(time) * s.get_step_dist() + self.zero[s.get_name()] for s in self.kin.get_steppers()}
        x, y, z = type(self.kin).calc_position(self.kin, at)
        tip = (1 + SCALE_X) * x - SQUARENESS * y, (1 + SCALE_Y) * y, z
        ball = math.dist(tip, [q + off for q, off in zip(BALL, OFF)]) - BALL_DIAMETER / 2 - TIP
        across = math.dist(tip[:2], [q + off for q, off in zip(RING, OFF)][:2])
        ring = RING_DIAMETER / 2 - across - TIP if abs(z - RING[2]) < 10.0 and across < RING_DIAMETER / 2 + 5 else math.inf
        return min(ball, ring)

    def trip(self, end):
        self.home_wait(end)
        self.toolhead.flush_step_generation()
        low, high = self.begun, end
        if self.gap(high) > 0.0:
            return 0.0  # nothing was touched
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (low, middle) if self.gap(middle) <= 0.0 else (middle, high)
        return high


def load_config(config):
    return Touched(config)
