"""Tests other machines: LinuxCNC's own compensation beside trueaxis, drives that lag, a gantry, five axes."""
import csv
import math
import os
import subprocess

import limits
import machines
import rig
from check_motion import largest, replay
from machines import DEFAULT_LIMITS, TRUEAXIS, compile_tables, mill
from recording import Recording
from rig import expect

# LinuxCNC's trims, up to 12 um, are in single precision: the rounding of one of them, and of two in the slope of a
# segment.
TRIM_ROUNDING = 3.0 * 2.0**-24 * 0.012


def trims(path):
    with open(path) as f:
        return [tuple(float(word) for word in line.split()) for line in f]


def slope_at(table, position, column):
    """Returns the slope of the table's straight pieces, or None within 50 um of a point."""
    for low, high in zip(table, table[1:]):
        if low[0] + 0.05 < position < high[0] - 0.05:
            return (high[column] - low[column]) / (high[0] - low[0])
    return None


def as_linuxcnc_reads_it(text):
    """Three axes, and linear between the points, as LinuxCNC is: an imported table is cubic."""
    expect('interpolation = "cubic"' in text, "an imported table is not cubic", text)
    return text.replace("w b X t", "w b X Y Z t").replace('interpolation = "cubic"', 'interpolation = "linear"')


def side_by_side(folder):
    """COMP_FILE and trueaxis on the same table in the same cycles; tables that LinuxCNC would truncate are refused."""
    source = os.path.join(rig.MACHINES, "comp", "x.comp")
    truncated(folder, source)
    mill(folder)
    rig.copy(folder, os.path.dirname(source), "x.comp")
    rig.copy(folder, rig.HERE, "comp.ngc")
    imported = os.path.join(folder, "imported")
    subprocess.run([TRUEAXIS, "tables", "import", "--from", "linuxcnc", "--unit", "mm", "--comp-file-type", "1", "--axis", "X",
                    source, "-o", imported], check=True, capture_output=True, timeout=60 * rig.PATIENCE)
    rig.edit(imported, "machine.toml", as_linuxcnc_reads_it)
    compile_tables(folder, os.path.join(imported, "machine.toml"), "mill-3axis.tcomp")
    rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(
        rig.with_ini(text, "JOINT_0", "COMP_FILE", "x.comp"), "JOINT_0", "COMP_FILE_TYPE", 1))
    rig.linuxcnc(folder, "mill-3axis.ini", "side_by_side")
    run = Recording.load(os.path.join(folder, "run"))
    expect(max(run.column("ta.fault-code")) == 0, "faults")
    expect(largest(run, "joint.0.f-error") < 1e-9, "following error", largest(run, "joint.0.f-error"))
    return compared(run, trims(source))


def compared(run, table):
    moving, standing, worst, worst_standing, skipped = 0, 0, 0.0, 0.0, 0
    direction, turned, still, arrived = 0, 0.0, 0, None
    rows = run.columns("joint.0.pos-cmd", "joint.0.vel-cmd", "joint.0.backlash-corr", "joint.0.motor-pos-cmd",
                       "ta.x.correction", "ta.x.limited", "ta.active")
    for position, velocity, theirs, motor, ours, limited, active in rows:
        sign = (velocity > 0) - (velocity < 0)
        if sign and sign != direction:
            direction, turned = sign, position
        still = 0 if sign else still + 1
        slope = slope_at(table, position, 1 if direction > 0 else 2)
        if not active or not direction or limited or slope is None or abs(position - turned) < 0.05:
            skipped += active != 0 and direction != 0 and sign != 0
            continue
        # trueaxis looks up at the motor's target, LinuxCNC at the command. On a straight segment they differ by the
        # slope.
        same = ours * (1.0 - slope)
        if sign:
            worst, moving, arrived = max(worst, abs(theirs - same)), moving + 1, same
        elif still > 200 and arrived is not None:
            # LinuxCNC looks up for the last time in the last cycle with a velocity, just before the end.
            worst_standing, standing = max(worst_standing, abs(motor - position - arrived)), standing + 1
            expect(abs(ours - (motor - position)) < 1e-5, "at standstill the inverse is not the only difference")
    expect(moving > 5000 and standing > 500 and skipped < 0.1 * moving, "too little compared", moving, standing, skipped)
    # The step looks up at the drive positions of the previous cycle, in cells that extend slightly beyond their ends.
    # That costs up to 1e-3 um; a fifth of it is permitted here.
    expect(worst <= TRIM_ROUNDING + 2e-7, "in motion %g mm apart" % worst)
    expect(worst_standing <= TRIM_ROUNDING + 1e-12, "at standstill %g mm apart" % worst_standing)
    return "in motion %.1e mm (%d samples), at standstill %.1e mm (%d)" % (worst, moving, worst_standing, standing)


def truncated(folder, source):
    with open(source) as f:
        lines = f.read().splitlines()
    spoiled = {
        "comment": lines[:40] + ["# second half"] + lines[40:],
        "blank": lines[:40] + [""] + lines[40:],
        "header": ["nominal forward reverse"] + lines,
        "comma": [line.replace(" ", ", ") for line in lines],
        "many": ["%d 0.001 0.001" % n for n in range(300)],
        "order": lines[:40] + lines[30:],
    }
    for name, text in spoiled.items():
        path = os.path.join(folder, name + ".comp")
        with open(path, "w") as f:
            f.write("\n".join(text) + "\n")
        target = os.path.join(folder, name + ".imported")
        done = subprocess.run([TRUEAXIS, "tables", "import", "--from", "linuxcnc", "--unit", "mm", "--comp-file-type", "1",
                               "--axis", "X", path, "-o", target], capture_output=True, text=True, timeout=60 * rig.PATIENCE)
        expect(done.returncode == 2 and not os.path.exists(target), "%s was not refused" % name, done.stdout, done.stderr)


LAGGING = """
loadrt lowpass names=drive-x,drive-y,drive-z
"""
for _j, _axis in enumerate("xyz"):
    LAGGING += """setp drive-{0}.gain 0.2
addf drive-{0} servo-thread
net {0}-drive ta.joint.{1}.motor-pos-cmd-out => drive-{0}.in
net {0}-encoder drive-{0}.out => ta.joint.{1}.motor-pos-fb-in
""".format(_axis, _j)


def contour(folder):
    """Contour error from the commanded stream, on drives that lag, compared with circle and plant in closed form."""
    mill(folder)
    compile_tables(folder, os.path.join(rig.MACHINES, "stream", "machine.toml"), "mill-3axis.tcomp")
    rig.copy(folder, rig.HERE, "contour.ngc")
    rig.edit(folder, "mill-3axis.ini", machines.narrow)
    for j in range(3):
        rig.edit(folder, "mill-3axis.ini", lambda text: rig.with_ini(text, "JOINT_%d" % j, "MIN_FERROR", 2))
    with open(os.path.join(folder, "drives.hal"), "w") as f:
        f.write(LAGGING)
    rig.linuxcnc(folder, "mill-3axis.ini", "contour")
    run = Recording.load(os.path.join(folder, "run"))
    expect(max(run.column("ta.fault-code")) == 0, "faults", set(run.column("ta.fault-code")))
    commands = run.columns(*("joint.%d.pos-cmd" % j for j in range(3)))
    # The drives run last, so the reading in a cycle is that of the previous cycle.
    readings = run.columns(*("ta.joint.%d.motor-pos-fb-in" % j for j in range(3)))
    measured = run.columns("ta.contour.tip.error", "ta.contour.encoder.error", "ta.contour.tip.found",
                           "ta.contour.tip.searching")
    # LinuxCNC interpolates arcs between trajectory points: 33 nm inside the programmed radius.
    radius = math.hypot(*commands[len(commands) // 3][:2])
    expect(abs(radius - 50.0) < 1e-4, "not on the circle", radius)
    on_arc, count, worst, largest_tip, biggest = 0, 0, 0.0, 0.0, 0.0
    for n in range(1, len(commands)):
        x, y, z = commands[n]
        round_ = abs(math.hypot(x, y) - radius) < 1e-8 and abs(z + 20.0) < 1e-9 and commands[n] != commands[n - 1]
        on_arc = on_arc + 1 if round_ else 0
        if on_arc < 60:
            continue
        fx, fy, fz = readings[n - 1]
        encoder = math.hypot(math.hypot(fx, fy) - radius, fz + 20.0)
        tip = math.hypot(math.hypot(1.0001 * fx, fy) - radius, fz + 5e-5 * fx + 20.0)
        expect(measured[n][2] == 1 and measured[n][3] == 0, "not found in sample %d" % n)
        worst = max(worst, abs(measured[n][0] - tip), abs(measured[n][1] - encoder))
        largest_tip, biggest = max(largest_tip, tip), max(biggest, encoder)
        count += 1
    expect(count > 6000, "only %d samples on the circle" % count)
    expect(largest_tip > 1e-3 and biggest > 2e-3, "nothing to measure", largest_tip, biggest)
    expect(worst < 2e-7, "%g mm from the truth" % worst)
    return "%d samples, tip up to %.2f um, encoder up to %.2f um, pins within %.0e mm of the truth" % (
        count, 1e3 * largest_tip, 1e3 * biggest, worst)


GANTRY = """G21 G90 G64 P0.001
F6000
G1 X200 Y150 Z-20
G4 P0.2
G1 X-200 Y-150
G4 P0.2
G2 X-200 Y-150 I30 J0
G1 X0 Y0
M2
"""


def gantry(folder):
    """Two joints on one axis: the axis' table for both, and a separate table for each."""
    machine = os.path.join(rig.MACHINES, "gantry")
    mill(folder)
    compile_tables(folder, os.path.join(machine, "machine.toml"), "mill-3axis.tcomp")
    for side in ("left", "right"):
        compile_tables(folder, os.path.join(machine, side + ".toml"), side + ".tcomp")
    travel = {"X": (-295, 295), "Y": (-195, 195), "Z": (-195, 45)}
    with open(os.path.join(folder, "mill-3axis.ini"), "w") as f:
        f.write(machines.ini_of("XYYZ", "trivkins coordinates=XYYZ kinstype=BOTH", travel))
    with open(os.path.join(folder, "trueaxis.hal"), "w") as f:
        f.write(machines.hal_of("XYYZ").replace("joints=", "joint_tables=1=left.tcomp,2=right.tcomp joints=", 1))
    with open(os.path.join(folder, "program.ngc"), "w") as f:
        f.write(GANTRY)
    rig.linuxcnc(folder, "mill-3axis.ini", "program")
    run = Recording.load(os.path.join(folder, "run"))
    expect(max(run.column("ta.fault-code")) == 0, "faults", set(run.column("ta.fault-code")))
    ferror = max(largest(run, "joint.%d.f-error" % j) for j in range(4))
    expect(ferror < 1e-9, "following error", ferror)
    sides = (0.03, 0.5, 100.0)
    both = tuple(a + b for a, b in zip(DEFAULT_LIMITS, sides))
    used = limits.all_kept(run, 4, [DEFAULT_LIMITS, both, both, DEFAULT_LIMITS])
    names = ["joint.%d.motor-pos-cmd" % j for j in (1, 2)] + ["ta.joint.%d.motor-pos-cmd-out" % j for j in (1, 2)]
    racking = [(out1 - cmd1) - (out2 - cmd2) for cmd1, cmd2, out1, out2 in run.columns(*names)]
    # The difference between the sides is that of their own tables, however the axis is corrected.
    at = run.column("joint.1.pos-cmd")
    left, right = (side_error(os.path.join(machine, side + ".csv")) for side in ("left", "right"))
    worst, count, places = 0.0, 0, set()
    for y, difference, limited, active in zip(at, racking, run.column("ta.limited"), run.column("ta.active")):
        if active and not limited and y in left:
            worst, count = max(worst, abs(difference + left[y] - right[y])), count + 1
            places.add(y)
    expect(places == {-150.0, 0.0, 150.0}, "never at the table's points", places)
    expect(worst < 1e-5, "sides are %g mm off their tables" % worst)
    expect(max(abs(r) for r in racking) > 0.005, "the sides were not corrected apart")
    return "sides apart by up to %.1f um, within %.0e mm of their tables at %d samples, limits used %s" % (
        1e3 * max(abs(r) for r in racking), worst, count, " ".join("%.2f" % u for u in used))


def side_error(path):
    """Returns the errors at the table's points, mm."""
    with open(path) as f:
        rows = [line.split(",") for line in f if line[0] in "-0123456789"]
    return {float(position): float(error) / 1000.0 for position, error in rows}


FIVE = """G21 G90 G64 P0.001
F4000
G1 X40 Y30 Z20
G4 P0.1
G1 A-20 C30 F3000
G4 P0.1
G93
G1 X-40 Y-20 Z30 A-35 C120 F12
G4 P0.1
G1 X20 Y-30 Z10 A10 C-60 F12
G4 P0.1
G94
G2 X20 Y-30 I-20 J0 F4000
G93
G1 X0 Y0 Z0 A0 C0 F12
M2
"""


def five_axes(folder):
    """xyzac-trt-kins with its tool centre point and volumetric tables: the true tip by exact transforms."""
    mill(folder)
    compile_tables(folder, os.path.join(rig.MACHINES, "trt", "machine.toml"), "mill-3axis.tcomp")
    travel = {"X": (-195, 195), "Y": (-195, 195), "Z": (-195, 195), "A": (-95, 55), "C": (-3600, 3600)}
    with open(os.path.join(folder, "mill-3axis.ini"), "w") as f:
        f.write(machines.ini_of("XYZAC", "xyzac-trt-kins", travel))
    with open(os.path.join(folder, "trueaxis.hal"), "w") as f:
        f.write(machines.hal_of("XYZAC", "setp xyzac-trt-kins.y-offset 20\nsetp xyzac-trt-kins.z-offset 10\n"))
    with open(os.path.join(folder, "program.ngc"), "w") as f:
        f.write(FIVE)
    rig.linuxcnc(folder, "mill-3axis.ini", "five_axes")
    run = Recording.load(os.path.join(folder, "run"))
    expect(max(run.column("ta.fault-code")) == 0, "faults", set(run.column("ta.fault-code")))
    agreement = replay(folder, "mill-3axis.tcomp", "XYZAC")
    ferror = max(largest(run, "joint.%d.f-error" % j) for j in range(5))
    expect(ferror < 1e-9, "following error", ferror)
    linear, rotary = (0.2, 1.5, 5000.0), (math.degrees(2000e-6), 5.0, 5000.0)
    limits.all_kept(run, 5, [linear] * 3 + [rotary] * 2)
    return "%.0e mm from the library, f-error %.0e, %s" % (agreement["largest_difference"], ferror, tip_truth(folder, run))


def tip_truth(folder, run):
    """Returns the uncorrected and corrected error of the tip in the workpiece, and whether both kinematics agree."""
    machine = os.path.join(rig.MACHINES, "trt")
    commands = run.columns(*("joint.%d.pos-cmd" % j for j in range(5)))
    drives = run.columns(*("ta.joint.%d.motor-pos-cmd-out" % j for j in range(5)))
    tips = run.columns("axis.x.pos-cmd", "axis.y.pos-cmd", "axis.z.pos-cmd")
    limited, active = run.column("ta.limited"), run.column("ta.active")
    chosen = [n for n in range(1, len(commands), 37) if active[n] and not limited[n] and commands[n] != commands[n - 1]]
    expect(len(chosen) > 50, "only %d samples in motion" % len(chosen))
    bare = errors(folder, machine, [commands[n] for n in chosen])
    held = errors(folder, machine, [drives[n] for n in chosen])
    before = max(math.dist(e, (0, 0, 0)) for e in bare)
    after = 0.0
    for n, e in zip(chosen, held):
        after = max(after, math.dist([d + x / 1000.0 for d, x in zip(drives[n], e)], commands[n][:3]) * 1000.0)
    expect(before > 20.0 and after < 0.1, "true tip: %g um before, %g um after" % (before, after))
    # In motion the joints are interpolated and lag the tip, so the kinematics are compared at rest.
    poses = [n for n in range(100, len(commands)) if len(set(commands[n - 50 : n])) == 1 and commands[n] != commands[n - 1]]
    forward = table_of(folder, ["kinematics", "forward", "--machine", machine], [commands[n - 1] for n in poses])
    apart = max(math.dist([float(row[k]) for k in ("tip_x_mm", "tip_y_mm", "tip_z_mm")], tips[n - 20])
                for n, row in zip(poses, forward))
    expect(len(poses) >= 4 and apart < 1e-9, "kinematics of LinuxCNC and of the tables are %g mm apart" % apart, poses)
    return "true tip off by %.1f um without, %.3f um with correction; kinematics agree within %.0e mm" % (
        before, after, apart)


def table_of(folder, words, positions):
    path = os.path.join(folder, "positions.csv")
    with open(path, "w") as f:
        f.write("x_mm,y_mm,z_mm,a_deg,c_deg\n")
        f.writelines(",".join(map(repr, p)) + "\n" for p in positions)
    done = subprocess.run([TRUEAXIS] + words + [path], check=True, capture_output=True, text=True, timeout=120 * rig.PATIENCE)
    return list(csv.DictReader(done.stdout.splitlines()))


def errors(folder, machine, positions):
    rows = table_of(folder, ["compensate", "--model", "exact", machine], positions)
    return [[float(row[k]) for k in ("ex_um", "ey_um", "ez_um")] for row in rows]


TESTS = (side_by_side, contour, gantry, five_axes)
