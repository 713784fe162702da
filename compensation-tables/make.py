#!/usr/bin/env python3
"""Writes the tables, the servo settings and the measurement of the sample machines beside this file.

The rest of each machine.toml is written by hand.

Plain Python, no packages. Every run writes the same bytes: the error curves are closed formulas, the scatter of the
measurement comes from `random.Random(SEED).random()`, whose sequence Python guarantees, and everything is rounded.
Units inside: mm, degrees, micrometres, microradians. Signs: error = actual - ideal, tool relative to workpiece.
"""

import math
import random
from pathlib import Path

HERE = Path(__file__).resolve().parent
SEED = 23_02_2014
TAU = 2 * math.pi


def wave(q, period, phase):
    """Sine of unit amplitude that is zero at q = 0, so that the tables are zero at machine zero."""
    return math.sin(TAU * q / period + phase) - math.sin(phase)


def grid(first, last, step):
    count = round((last - first) / step)
    return [first + i * step for i in range(count + 1)]


def number(value, digits=3):
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def write_table(path, title, header, positions, columns):
    lines = [f"# {line}" for line in title] + [",".join(header)]
    for q in positions:
        lines.append(",".join([number(q)] + [number(column(q)) for column in columns]))
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


# --- mill-3axis: C-frame, saddle Y on the bed, table X on the saddle, quill Z -------------------------------------


def exx(x):
    """Lead error of the screw: 44 um/m, long waves of 200 and 75 mm (the v300p of ISO 3408-3)."""
    return -0.044 * x - 3.4 * wave(x, 200, 0.2) + 1.1 * wave(x, 75, 1.9)


def exx_reversal(x):
    """Reverse minus forward: elastic lost motion, larger where the screw is worn (mid travel)."""
    return 1.5 + 0.7 * math.exp(-((x / 140) ** 2))


# Servo of a sample machine: what its plant in the simulator has (gains of the position and velocity loop, 1/s; Coulomb
# friction, mm/s2; viscous friction, 1/s; pre-sliding, um), and by how much the figures in its machine.toml are off.
PLANT = {"position": 110, "velocity": 800, "coulomb": 420, "viscous": 4, "presliding": 6}
OFF = {"gains": 1.05, "friction": 0.9, "presliding": 1.2}
# Gains and friction of each axis over the common ones.
VARIATION = {"X": (1, 1), "Y": (0.97, 1.12), "Z": (1.02, 1.25), "A": (0.94, 0.9), "C": (1.01, 0.8)}


def servo(axis):
    """Sections of drive, friction and dynamic correction. Forces are given over the velocity gain, as velocities.

    The plant of a rotary axis has the same figures in degrees.
    """
    unit, micro, scale = ("deg", "urad", math.radians(1000)) if axis in "ABC" else ("mm", "um", 1)
    gains, friction = VARIATION[axis]
    position, velocity = (PLANT[loop] * gains * OFF["gains"] for loop in ("position", "velocity"))
    coulomb = PLANT["coulomb"] * friction * OFF["friction"] / velocity
    # The plant's drives are rigid; the contour feedback is that of the linear axes.
    resonance = "" if axis in "ABC" else "lowest_resonance_hz = 1200\n"
    return f"""
[axis.{axis}.drive]
position_gain_per_s = {number(position, 1)}
velocity_gain_per_s = {number(velocity, 1)}
reset_time_s = 0.006
velocity_feed_forward = 0.93
{resonance}
[axis.{axis}.friction]
coulomb_{unit}_per_s = {number(coulomb)}
presliding_{micro} = {number(PLANT["presliding"] * OFF["presliding"] * scale)}
stribeck_share = 0.3
stribeck_velocity_{unit}_per_s = 2
viscous = {number(PLANT["viscous"] * OFF["friction"] / velocity, 5)}

[axis.{axis}.dynamic]
lag = true
acceleration = true
take_up = true
"""


OFF_BY = """
# Drives, friction and what the step adds to the commands. A machine's figures are never known exactly: against the drives
# of the simulator friction is 10 % too low, the gains are 5 % and pre-sliding is 20 % too high. Those drives are rigid; a real
# machine of this kind has its lowest resonance far below 1200 Hz, and its feedback needs smaller gains.
"""

FEEDBACK = """
[contour.feedback]
proportional = 0.3
integral_per_s = 10.0
"""


def write_servos(path, axes):
    """Replaces everything of a machine that acts on the servo; what comes before is written by hand."""
    by_hand, _, _ = path.read_text(encoding="utf-8").partition(OFF_BY)
    servos = OFF_BY + "".join(servo(axis) for axis in axes) + FEEDBACK
    path.write_text(by_hand + servos, encoding="utf-8", newline="\n")


def mill_3axis():
    folder = HERE / "mill-3axis"
    write_servos(folder / "machine.toml", "XYZ")
    write_table(
        folder / "x.csv",
        ["X of mill-3axis, laser interferometer and electronic level, line at Y 0, Z -200; zero at machine zero",
         "equidistant, 10 mm; forward: approached in positive direction"],
        ["X_mm", "EXX_fwd_um", "EXX_rev_um", "EYX_um", "EZX_um", "EAX_urad", "EBX_urad", "ECX_urad"],
        grid(-300, 300, 10),
        [exx,
         lambda x: exx(x) + exx_reversal(x),
         lambda x: 4.6 * ((x / 300) ** 2) - 1.6 * wave(x, 240, 0.0),
         lambda x: -5.4 * ((x / 300) ** 2) + 1.2 * wave(x, 180, 0.7),
         lambda x: 11 * math.sin(x / 340) + 2 * wave(x, 250, 0.3),
         lambda x: -17 * math.sin(x / 300) + 2.5 * wave(x, 210, 1.1),
         lambda x: 13 * math.sin(x / 320) - 2 * wave(x, 270, 0.9)])
    write_table(
        folder / "y.csv",
        ["Y of mill-3axis, line at X 0, Z -200; zero at machine zero", "equidistant, 10 mm"],
        ["Y_mm", "EXY_um", "EYY_um", "EZY_um", "EAY_urad", "EBY_urad", "ECY_urad"],
        grid(-200, 200, 10),
        [lambda y: -3.8 * ((y / 200) ** 2) + 1.3 * wave(y, 160, 0.2),
         lambda y: 0.062 * y + 2.9 * wave(y, 190, 0.2) - 0.9 * wave(y, 65, 0.5),
         lambda y: -4.9 * ((y / 200) ** 2) + 1.0 * wave(y, 140, 1.3),
         lambda y: -17 * math.sin(y / 230) + 2 * wave(y, 190, 0.1),
         lambda y: 9 * math.sin(y / 260) - 1.5 * wave(y, 150, 0.8),
         lambda y: -12 * math.sin(y / 240) + 1.5 * wave(y, 220, 2.0)])
    # Finer where most work is done: a free grid.
    z_grid = ([-400, -380, -360, -340, -320, -300] + grid(-290, -150, 5)
              + [-140, -125, -110, -95, -80, -60, -40, -20, 0])
    write_table(
        folder / "z.csv",
        ["Z of mill-3axis, line at X 0, Y 0; zero at machine zero", "free grid: 5 mm between -290 and -150, wider outside"],
        ["Z_mm", "EXZ_um", "EYZ_um", "EZZ_um", "EAZ_urad", "EBZ_urad", "ECZ_urad"],
        z_grid,
        [lambda z: 3.1 * math.sin(math.pi * z / 400) + 1.1 * wave(z, 180, 0.6),
         lambda z: -3.6 * math.sin(math.pi * z / 400) - 0.9 * wave(z, 210, 1.5),
         lambda z: -0.034 * z + 2.6 * wave(z, 190, 1.0),
         lambda z: 10 * math.sin(z / 300) + 1.5 * wave(z, 230, 0.4),
         lambda z: -14 * math.sin(z / 330) - 2 * wave(z, 200, 1.7),
         lambda z: 6 * math.sin(z / 310)])
    measurement(folder / "x-iso230-2.csv")


def measurement(path):
    """ISO 230-2 test of X: 21 targets p(i - 1) + r, five runs in both directions, standard cycle."""
    generator = random.Random(SEED)

    def scatter(sigma):
        # Sum of twelve uniforms: variance 1; needs nothing but random(), the one sequence Python guarantees.
        return sigma * (sum(generator.random() for _ in range(12)) - 6)

    targets = [round(-292 + 29 * i + 3 * (generator.random() - 0.5), 3) for i in range(21)]
    lines = ["# X of mill-3axis before compensation, ISO 230-2:2014 standard test cycle, laser interferometer, 20 C",
             "# deviation = actual - target; run 1 to 5; + approached in positive direction, - in negative direction",
             "X_mm,run,direction,deviation_um"]
    for run in range(1, 6):
        drift = -0.25 * (run - 3)
        for x in targets:
            lines.append(f"{number(x)},{run},+,{number(exx(x) + drift + scatter(0.45), 2)}")
        for x in reversed(targets):
            lines.append(f"{number(x)},{run},-,{number(exx(x) + exx_reversal(x) + drift + scatter(0.5), 2)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


# --- mill-5axis: trunnion A on Y, table C in the trunnion, spindle on Z on X ---------------------------------------


def cyclic(amplitude, harmonic, phase_deg):
    return lambda deg: amplitude * math.cos(math.radians(harmonic * deg - phase_deg))


def total(*terms):
    return lambda q: sum(term(q) for term in terms)


def mill_5axis():
    folder = HERE / "mill-5axis"
    write_servos(folder / "machine.toml", "XYZAC")
    write_table(
        folder / "x.csv", ["X of mill-5axis, line at Y 0, Z 0"],
        ["X_mm", "EXX_um", "EYX_um", "EZX_um", "EAX_urad", "EBX_urad", "ECX_urad"],
        grid(-250, 250, 12.5),
        [lambda x: 0.021 * x + 1.8 * wave(x, 160, 0.5),
         lambda x: 3.2 * ((x / 250) ** 2) + 0.7 * wave(x, 190, 0.4),
         lambda x: -2.9 * ((x / 250) ** 2) + 0.8 * wave(x, 150, 1.0),
         lambda x: 9 * math.sin(x / 280),
         lambda x: -13 * math.sin(x / 260) + 1.5 * wave(x, 200, 0.2),
         lambda x: 11 * math.sin(x / 300)])
    write_table(
        folder / "y.csv", ["Y of mill-5axis, line at X 0, Z 0"],
        ["Y_mm", "EXY_um", "EYY_um", "EZY_um", "EAY_urad", "EBY_urad", "ECY_urad"],
        grid(-250, 250, 12.5),
        [lambda y: -2.7 * ((y / 250) ** 2) + 0.6 * wave(y, 170, 0.9),
         lambda y: -0.026 * y + 1.6 * wave(y, 140, 1.4),
         lambda y: 3.4 * ((y / 250) ** 2) - 0.7 * wave(y, 210, 0.3),
         lambda y: 12 * math.sin(y / 270) + 1.2 * wave(y, 180, 0.6),
         lambda y: 8 * math.sin(y / 290),
         lambda y: -10 * math.sin(y / 280)])
    write_table(
        folder / "z.csv", ["Z of mill-5axis, line at X 0, Y 0"],
        ["Z_mm", "EXZ_um", "EYZ_um", "EZZ_um", "EAZ_urad", "EBZ_urad", "ECZ_urad"],
        grid(-100, 400, 12.5),
        [lambda z: 2.6 * math.sin(math.pi * z / 500) + 0.6 * wave(z, 160, 0.7),
         lambda z: -2.3 * math.sin(math.pi * z / 500) + 0.5 * wave(z, 180, 0.1),
         lambda z: 0.017 * z + 1.4 * wave(z, 130, 2.1),
         lambda z: -9 * math.sin(z / 350),
         lambda z: 10 * math.sin(z / 330) + 1.0 * wave(z, 240, 1.2),
         lambda z: 5 * math.sin(z / 300)])
    write_table(
        folder / "a.csv",
        ["A of mill-5axis (trunnion), -120 to 30 degrees, 2.5 degrees; forward: turned in positive direction"],
        ["A_deg", "EXA_um", "EYA_um", "EZA_um", "EAA_fwd_urad", "EAA_rev_urad", "EBA_urad", "ECA_urad"],
        grid(-120, 30, 2.5),
        [total(cyclic(1.6, 1, 40), cyclic(0.5, 3, 10)),
         total(cyclic(3.4, 1, 95), cyclic(0.8, 2, 60)),
         total(cyclic(3.9, 1, 15), cyclic(0.7, 2, 130)),
         lambda a: 0.19 * a + 7.5 * math.sin(math.radians(4 * a)),
         lambda a: 0.19 * a + 7.5 * math.sin(math.radians(4 * a)) + 9 + 0.02 * a,
         total(cyclic(8.0, 1, 75), cyclic(2.0, 2, 20)),
         total(cyclic(9.0, 1, 160), cyclic(1.5, 2, 35))])
    write_table(
        folder / "c.csv",
        ["C of mill-5axis (rotary table), full circle, 5 degrees; wraps: first and last line agree"],
        ["C_deg", "EXC_um", "EYC_um", "EZC_um", "EAC_urad", "EBC_urad", "ECC_urad"],
        grid(0, 360, 5),
        [total(cyclic(3.1, 1, 30), cyclic(0.9, 2, 75), cyclic(0.4, 3, 0)),
         total(cyclic(2.8, 1, 122), cyclic(1.0, 2, 160), cyclic(0.3, 3, 45)),
         total(cyclic(1.1, 1, 200), cyclic(1.4, 2, 15)),
         total(cyclic(12, 1, 65), cyclic(3, 2, 140)),
         total(cyclic(11, 1, 152), cyclic(3.5, 2, 50)),
         total(cyclic(21, 1, 250), cyclic(8, 2, 100), cyclic(4, 6, 20))])


# --- router: gantry with a sagging cross rail, and a surface that was probed ---------------------------------------


def write_grid(path, comments, columns, xs, ys, functions):
    """A line for every node of a grid over X and Y."""
    lines = [f"# {comment}" for comment in comments] + [",".join(columns)]
    for x in xs:
        for y in ys:
            lines.append(",".join([number(x), number(y)] + [number(f(x, y), 2) for f in functions]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def router():
    folder = HERE / "router"
    write_table(
        folder / "x.csv", ["X of router (the carriage on the cross rail), rack and pinion"],
        ["X_mm", "EXX_um"], grid(-400, 400, 40),
        [lambda x: 0.06 * x + 9 * wave(x, 310, 0.4) + 3 * wave(x, 94, 1.1)])
    write_table(
        folder / "y.csv", ["Y of router (the gantry on both side rails), rack and pinion"],
        ["Y_mm", "EYY_um"], grid(-300, 300, 40),
        [lambda y: -0.05 * y + 8 * wave(y, 280, 1.2)])

    def sag(x, y):
        # The rail hangs between the sides, deeper where the side rails are soft, in the middle of their length.
        return -70 * (1 - (x / 400) ** 2) * (1 + 0.35 * math.cos(math.pi * y / 600))

    write_grid(
        folder / "rail.csv", ["Cross rail of router over X and Y: sag, roll into the cut, racking of the gantry", "nodes 50 mm apart"],
        ["X_mm", "Y_mm", "EX_um", "EY_um", "EZ_um"], grid(-400, 400, 50), grid(-300, 300, 50),
        [lambda x, y: 0.00012 * x * y + 4 * wave(y, 500, 0.3),
         lambda x, y: 14 * math.sin(x / 260) * (1 + y / 900),
         sag])
    write_grid(
        folder / "surface.csv", ["Spoilboard of router as probed: where the surface is high, the tool stands low in it"],
        ["X_mm", "Y_mm", "EZ_um"], grid(-400, 400, 80), grid(-300, 300, 75),
        [lambda x, y: -35 * math.exp(-((x - 120) ** 2 + (y + 60) ** 2) / 180 ** 2) + 0.03 * x - 0.02 * y])


# --- head-5axis: fork head, A in C, C on the ram Z on the cross slide Y; the table X carries the workpiece ----------


def from_zero(curve):
    """The curve less its value at 0: the other rotary axis stands at 0 and without error while this one is measured."""
    return lambda q: curve(q) - curve(0)


def head_5axis():
    folder = HERE / "head-5axis"
    write_servos(folder / "machine.toml", "XYZAC")
    write_table(
        folder / "x.csv", ["X of head-5axis (table), line at Y 0, Z 0; zero at machine zero"],
        ["X_mm", "EXX_um", "EYX_um", "EZX_um", "EAX_urad", "EBX_urad", "ECX_urad"],
        grid(-1000, 1000, 50),
        [lambda x: 0.011 * x + 2.4 * wave(x, 700, 0.5),
         lambda x: 6.5 * ((x / 1000) ** 2) + 1.1 * wave(x, 600, 0.4),
         lambda x: -5.5 * ((x / 1000) ** 2) + 1.0 * wave(x, 500, 1.0),
         lambda x: 14 * math.sin(x / 900),
         lambda x: -18 * math.sin(x / 950) + 2 * wave(x, 800, 0.2),
         lambda x: 15 * math.sin(x / 1000)])
    write_table(
        folder / "y.csv", ["Y of head-5axis (cross slide), line at X 0, Z 0; zero at machine zero"],
        ["Y_mm", "EXY_um", "EYY_um", "EZY_um", "EAY_urad", "EBY_urad", "ECY_urad"],
        grid(-600, 600, 50),
        [lambda y: -4.2 * ((y / 600) ** 2) + 0.8 * wave(y, 500, 0.9),
         lambda y: -0.014 * y + 2.0 * wave(y, 400, 1.4),
         lambda y: 5.0 * ((y / 600) ** 2) - 0.9 * wave(y, 450, 0.3),
         lambda y: 16 * math.sin(y / 600) + 1.5 * wave(y, 400, 0.6),
         lambda y: 11 * math.sin(y / 650),
         lambda y: -13 * math.sin(y / 700)])
    write_table(
        folder / "z.csv", ["Z of head-5axis (ram), line at X 0, Y 0; zero at machine zero"],
        ["Z_mm", "EXZ_um", "EYZ_um", "EZZ_um", "EAZ_urad", "EBZ_urad", "ECZ_urad"],
        grid(-400, 400, 25),
        [lambda z: 3.4 * math.sin(math.pi * z / 800) + 0.8 * wave(z, 400, 0.7),
         lambda z: -3.1 * math.sin(math.pi * z / 800) + 0.7 * wave(z, 350, 0.1),
         lambda z: 0.013 * z + 1.6 * wave(z, 300, 2.1),
         lambda z: -12 * math.sin(z / 500),
         lambda z: 13 * math.sin(z / 480) + 1.5 * wave(z, 400, 1.2),
         lambda z: 6 * math.sin(z / 450)])
    write_table(
        folder / "a.csv", ["A of head-5axis (fork), -100 to 100 degrees, 2.5 degrees; zero at A 0"],
        ["A_deg", "EXA_um", "EYA_um", "EZA_um", "EAA_urad", "EBA_urad", "ECA_urad"],
        grid(-100, 100, 2.5),
        [from_zero(total(cyclic(4.5, 1, 40), cyclic(0.7, 3, 10))),
         from_zero(total(cyclic(7.5, 1, 95), cyclic(1.2, 2, 60))),
         from_zero(total(cyclic(8.0, 1, 15), cyclic(1.0, 2, 130))),
         from_zero(total(lambda a: 0.35 * a, cyclic(6, 4, 90))),
         from_zero(total(cyclic(24, 1, 75), cyclic(4, 2, 20))),
         from_zero(total(cyclic(28, 1, 160), cyclic(3, 2, 35)))])
    write_table(
        folder / "c.csv", ["C of head-5axis, full circle, 5 degrees; wraps: first and last line agree; zero at C 0"],
        ["C_deg", "EXC_um", "EYC_um", "EZC_um", "EAC_urad", "EBC_urad", "ECC_urad"],
        grid(0, 360, 5),
        [from_zero(total(cyclic(6.2, 1, 30), cyclic(1.4, 2, 75), cyclic(0.5, 3, 0))),
         from_zero(total(cyclic(5.6, 1, 122), cyclic(1.6, 2, 160), cyclic(0.4, 3, 45))),
         from_zero(total(cyclic(2.4, 1, 200), cyclic(1.8, 2, 15))),
         from_zero(total(cyclic(26, 1, 65), cyclic(5, 2, 140))),
         from_zero(total(cyclic(23, 1, 152), cyclic(6, 2, 50))),
         from_zero(total(cyclic(45, 1, 250), cyclic(14, 2, 100), cyclic(5, 4, 20)))])


# --- grinder: wheel head X on the table Z, work head on the bed, three probes on an arm that follows the crankpin ----


def grinder():
    folder = HERE / "grinder"
    write_table(
        folder / "x.csv", ["X of grinder (wheel head), 5 mm; zero at machine zero, positive away from the workpiece"],
        ["X_mm", "EXX_um", "EZX_um", "EBX_urad"],
        grid(-60, 60, 5),
        [lambda x: 0.012 * x + 0.4 * wave(x, 50, 0.4),
         lambda x: 0.5 * ((x / 60) ** 2) + 0.2 * wave(x, 40, 1.2),
         lambda x: 3 * math.sin(x / 90)])


# --- mill-turn: table C on the bed, head A on Z on Y on X; the helicoid's machine in its vertical form ------------------


def mill_turn():
    folder = HERE / "mill-turn"
    write_servos(folder / "machine.toml", "XYZAC")
    write_table(
        folder / "x.csv", ["X of mill-turn, line at Y 0, Z 0"],
        ["X_mm", "EXX_um", "EYX_um", "EZX_um", "EAX_urad", "EBX_urad", "ECX_urad"],
        grid(-400, 400, 20),
        [lambda x: 0.018 * x + 1.5 * wave(x, 210, 0.9),
         lambda x: 3.6 * ((x / 400) ** 2) + 0.6 * wave(x, 260, 0.2),
         lambda x: -4.1 * ((x / 400) ** 2) + 0.7 * wave(x, 220, 1.4),
         lambda x: 10 * math.sin(x / 420),
         lambda x: -14 * math.sin(x / 390) + 1.4 * wave(x, 260, 0.5),
         lambda x: 12 * math.sin(x / 450)])
    write_table(
        folder / "y.csv", ["Y of mill-turn, line at X 0, Z 0"],
        ["Y_mm", "EXY_um", "EYY_um", "EZY_um", "EAY_urad", "EBY_urad", "ECY_urad"],
        grid(-400, 400, 20),
        [lambda y: -3.3 * ((y / 400) ** 2) + 0.5 * wave(y, 230, 0.3),
         lambda y: -0.022 * y + 1.3 * wave(y, 180, 1.1),
         lambda y: 3.8 * ((y / 400) ** 2) - 0.6 * wave(y, 250, 0.8),
         lambda y: 13 * math.sin(y / 410) + 1.1 * wave(y, 240, 0.1),
         lambda y: -9 * math.sin(y / 430),
         lambda y: 11 * math.sin(y / 400)])
    write_table(
        folder / "z.csv", ["Z of mill-turn, line at X 0, Y 0"],
        ["Z_mm", "EXZ_um", "EYZ_um", "EZZ_um", "EAZ_urad", "EBZ_urad", "ECZ_urad"],
        grid(-400, 400, 20),
        [lambda z: 2.9 * math.sin(math.pi * z / 800) + 0.5 * wave(z, 200, 1.6),
         lambda z: -2.6 * math.sin(math.pi * z / 800) + 0.6 * wave(z, 240, 0.4),
         lambda z: 0.015 * z + 1.2 * wave(z, 170, 1.9),
         lambda z: -11 * math.sin(z / 440),
         lambda z: 12 * math.sin(z / 420) + 0.9 * wave(z, 280, 0.7),
         lambda z: -6 * math.sin(z / 400)])
    write_table(
        folder / "a.csv",
        ["A of mill-turn (head), -100 to 100 degrees, 2.5 degrees; forward: turned in positive direction"],
        ["A_deg", "EXA_um", "EYA_um", "EZA_um", "EAA_fwd_urad", "EAA_rev_urad", "EBA_urad", "ECA_urad"],
        grid(-100, 100, 2.5),
        [total(cyclic(1.2, 1, 60), cyclic(0.4, 3, 25)),
         total(cyclic(2.9, 1, 110), cyclic(0.7, 2, 40)),
         total(cyclic(3.2, 1, 20), cyclic(0.6, 2, 150)),
         lambda a: 0.17 * a + 6.5 * math.sin(math.radians(4 * a)),
         lambda a: 0.17 * a + 6.5 * math.sin(math.radians(4 * a)) + 8,
         total(cyclic(7.0, 1, 85), cyclic(1.8, 2, 30)),
         total(cyclic(8.0, 1, 170), cyclic(1.4, 2, 55))])
    write_table(
        folder / "c.csv",
        ["C of mill-turn (rotary table), full circle, 5 degrees; wraps: first and last line agree"],
        ["C_deg", "EXC_um", "EYC_um", "EZC_um", "EAC_urad", "EBC_urad", "ECC_urad"],
        grid(0, 360, 5),
        [total(cyclic(2.7, 1, 50), cyclic(0.8, 2, 95), cyclic(0.3, 3, 20)),
         total(cyclic(2.5, 1, 142), cyclic(0.9, 2, 180), cyclic(0.3, 3, 65)),
         total(cyclic(1.0, 1, 220), cyclic(1.2, 2, 35)),
         total(cyclic(10, 1, 85), cyclic(2.5, 2, 160)),
         total(cyclic(9, 1, 172), cyclic(3, 2, 70)),
         total(cyclic(18, 1, 270), cyclic(7, 2, 120), cyclic(3, 6, 40))])


if __name__ == "__main__":
    mill_3axis()
    mill_5axis()
    head_5axis()
    grinder()
    mill_turn()
    router()
