"""Runs the host without a board, with the extra and without: run.py KLIPPY OUT TRUEAXIS MACHINE TABLES.tcomp HOSTS_MACHINE HOSTS.

KLIPPY: the folder of the host (Kalico or Klipper's main line), with the extras in its `extras`; the host's Python runs this
script. OUT: also contains printer/ and printer.tcomp, written by printer.py. HOSTS_MACHINE and HOSTS: machine, tables and
recording common to all hosts.

SPDX-License-Identifier: GPL-3.0-or-later
"""
import ast
import csv
import subprocess
import sys
from pathlib import Path

import probing
import touched
import zeros

HERE = Path(__file__).resolve().parent
klippy, out, trueaxis, machine, tables, hosts_machine, hosts = map(Path, sys.argv[1:])
main_line = not (klippy / "__init__.py").exists()
AS_IF = ("",) if main_line else ("", "klipper_20260807")  # unchanged, and with a double of another version's calls
STEPPER = """
[stepper_{name}]
step_pin: PA{pin}
dir_pin: PA{dir}
enable_pin: !PA{enable}
microsteps: 16
rotation_distance: 5
"""
LIMITS = {
    "x": "position_min: 0\nposition_max: 200\n",
    "y": "position_min: 0\nposition_max: 200\n",
    "z": "position_min: -300\nposition_max: 0\n",
}
SHAPER = "[input_shaper]\nshaper_type: mzv\nshaper_freq_x: 40\nshaper_freq_y: 35\n"
HOME = "G28\nG90\nG1 X10 Y10 Z-100 F3000\n"
START = "SET_KINEMATIC_POSITION X=10 Y=10 Z=-100\nG90\n"
# Lines with reversals of every axis, one slow line, and arcs.
MOVES = """G1 X120 Y80 Z-50 F6000
G1 X10 F3000
G1 X60 Y150 Z-60
G1 Y20 F600
G2 X100 Y20 I20 J0 F3000
G3 X60 Y60 I-40 J0 Z-61
M400
"""


def config(kinematics, extra, limits):
    # The host's own compression of steps would otherwise add half a microstep and hide the effect.
    text = "[exact]\n[mcu]\nserial: /dev/null\n" if main_line else "[mcu]\nserial: /dev/null\nmax_stepper_error: 0.000001\n"
    text += f"[printer]\nkinematics: {kinematics}\nmax_velocity: 300\nmax_accel: 3000\n"
    text += "max_z_velocity: 50\nmax_z_accel: 500\n[gcode_arcs]\nresolution: 0.5\n[force_move]\nenable_force_move: True\n[drain]\n"
    # Two motors lift Z if each axis has its own motors.
    for i, name in enumerate(["x", "y", "z"] + ["z1"] * (kinematics == "cartesian")):
        text += STEPPER.format(name=name, pin=4 * i, dir=4 * i + 1, enable=4 * i + 2)
        if name in limits:
            text += f"endstop_pin: ^PA{4 * i + 3}\nposition_endstop: 0\n" * ("endstop_pin" not in limits[name]) + limits[name]
    return text + extra


def host(name, kinematics, program, extra="", limits=LIMITS, refused=False, steps=True):
    """Runs the host; returns the steps that it sends, as text, and its messages. A program that must be refused ends the host.
    Without `steps`, those are not parsed."""
    cfg, ngc, sent, log = (out / f"{name}.{kind}" for kind in ("cfg", "gcode", "serial", "log"))
    log.unlink(missing_ok=True)  # the host adds to it
    cfg.write_text(config(kinematics, extra, limits))
    ngc.write_text(program + "DRAIN\n")
    run = subprocess.run([sys.executable, klippy / "klippy.py", cfg, "-i", ngc, "-o", sent, "-d", out / "board.dict", "-l", log],
                         timeout=600, capture_output=True, text=True)
    text = run.stdout + run.stderr + (log.read_text() if log.exists() else "")
    if bool(run.returncode) != refused:
        sys.exit(f"{name}: the host ended with {run.returncode}:\n{text[-2000:]}")
    if refused or not steps:
        return None, text
    parse = [klippy / "parsedump.py"] if main_line else ["-m", "klippy.parsedump"]
    dump = subprocess.run([sys.executable, *parse, out / "board.dict", sent], check=True, capture_output=True, text=True).stdout
    lines = [line for line in dump.splitlines() if any(word in line for word in ("queue_step", "set_next_step_dir", "reset_step_clock"))]
    (out / f"{name}.steps").write_text("\n".join(lines))
    # Drop the message number and time, which belong to the message and not to the step.
    return [line.split(": ", 1)[-1] for line in lines], text


def own(tables):
    return f"[trueaxis]\nshim: {out / 'trueaxis.so'}\ntables: {tables}\n"


def calls():
    """Returns HOST of the extra: the calls it makes, by kind."""
    tree = ast.parse((HERE.parent / "extra/trueaxis.py").read_text())
    return next(ast.literal_eval(node.value) for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "HOST")


def net(steps):
    """Returns, for every motor number, the steps forward minus the steps back."""
    found, way = {}, {}
    for line in steps:
        words = dict(word.split("=") for word in line.split() if "=" in word)
        motor = int(words["oid"])
        if "set_next_step_dir" in line:
            way[motor] = 1 if words["dir"] == "1" else -1
        elif "queue_step" in line:
            found[motor] = found.get(motor, 0) + way[motor] * int(words["count"])
    return found


def same(what, one, other):
    if one != other:
        at = next((i for i, (a, b) in enumerate(zip(one, other)) if a != b), min(len(one), len(other)))
        sys.exit(f"{what}: {len(one)} and {len(other)} messages of steps, from {at} on they differ")
    print(f"{what}: {len(one)} messages of steps, the same")


subprocess.run([sys.executable, HERE / "dictionary.py", out / "board.dict"], check=True)
for kinematics in ("cartesian", "corexy"):
    record = out / f"{kinematics}.jsonl"
    corrected, told = host(kinematics, kinematics, START + MOVES, own(tables) + f"[record]\nfile: {record}\n")
    subprocess.run([sys.executable, HERE / "steps.py", trueaxis, machine, record, out / f"{kinematics}.steps"], check=True)

    # The same moves after homing by switches, which are found uncorrected.
    record = out / f"{kinematics}-homed.jsonl"
    host(f"{kinematics}-homed", kinematics, HOME + MOVES, own(tables) + f"[record]\nfile: {record}\n")
    subprocess.run([sys.executable, HERE / "steps.py", trueaxis, machine, record, out / f"{kinematics}-homed.steps"], check=True)

    # Input shaping moves the same motors by the same steps, at other times.
    shaped, _ = host(f"{kinematics}-shaped", kinematics, START + MOVES, own(tables) + SHAPER)
    if shaped == corrected or net(shaped) != net(corrected):
        sys.exit(f"shaped: found net steps {net(shaped)}, needed {net(corrected)} at other times")
    print(f"{kinematics}, input shaper: the same net steps, {net(shaped)}")

    # Switching and reloading at standstill adds no step.
    switched = "TRUEAXIS ENABLE=0\nTRUEAXIS ENABLE=1\n" * 3 + f"TRUEAXIS_LOAD FILE={tables}\nM400\n"
    again, told = host(f"{kinematics}-switched", kinematics, START + MOVES + switched, own(tables))
    same(f"{kinematics}, switched at standstill", corrected, again)

    # A refusal is reported in one line, and the machine runs as without the extra.
    plain, _ = host(f"{kinematics}-plain", kinematics, START + MOVES)
    if plain == corrected:
        sys.exit("the correction changes no step")
    data = tables.read_bytes()
    damaged = out / "damaged.tcomp"
    damaged.write_bytes(data[:5000] + bytes([data[5000] ^ 1]) + data[5001:])
    for name, settings, words in (
        ("damaged", own(damaged), f"{damaged}: table file: the file is damaged (its CRC-32 is wrong); running uncompensated"),
        ("missing", own(out / "none.tcomp"), f"{out / 'none.tcomp'}: No such file or directory; running uncompensated"),
        ("steep", own(tables) + "max_slope: 0.00001\n", "needed at most 0.00001 (max_slope); running uncompensated"),
        ("large", own(tables) + "max_correction: 0.001\n", "needed at most 0.0010 (max_correction); running uncompensated"),
        ("foreign", own(tables) + "machine_id: 12345678\n", "the file was made for another machine; running uncompensated"),
    ):
        steps, told = host(f"{kinematics}-{name}", kinematics, START + MOVES, settings)
        if words not in told:
            sys.exit(f"{name}: needed {words!r} in\n{told[-3000:]}")
        same(f"{kinematics}, {name}", plain, steps)
    # RESTART sets up the extra again; the host then reaches the end of the program.
    _, told = host(f"{kinematics}-restarted", kinematics, START + "RESTART\n", own(tables), steps=False)
    if told.count("uncompensated until homed") != 2:
        sys.exit(f"restarted: needed the extra twice in\n{told[-3000:]}")
    # After a refusal other tables can be loaded, and the refusal has no further effect.
    late, _ = host(f"{kinematics}-late", kinematics, f"TRUEAXIS_LOAD FILE={tables}\n" + START + MOVES, own(damaged))
    same(f"{kinematics}, loaded after a refusal", corrected, late)
    for name, settings, command, words in (
        ("none", own(damaged), "TRUEAXIS ENABLE=1", "CRC-32 is wrong); running uncompensated"),
        ("no-others", own(damaged), f"TRUEAXIS_LOAD FILE={out / 'none.tcomp'}", "No such file or directory; running uncompensated"),
        ("stay", own(tables), f"TRUEAXIS_LOAD FILE={damaged}", "CRC-32 is wrong); the tables stay as they are"),
        ("no-shim", own(tables) + f"shim: {out / 'none.so'}\n", f"TRUEAXIS_LOAD FILE={tables}", "needed: a restart of the host"),
    ):
        _, told = host(f"{kinematics}-{name}", kinematics, command + "\n", settings, refused=True)
        if words not in told:
            sys.exit(f"{name}: needed {words!r} in\n{told[-3000:]}")
    off, _ = host(f"{kinematics}-off", kinematics, START + MOVES, own(tables) + "enable: False\n")
    same(f"{kinematics}, switched off", plain, off)

    # Probing a bed and its mesh: exact to a step with the correction, far off without it.
    limits = {**LIMITS, "z": "endstop_pin: probe:z_virtual_endstop\nposition_min: -5\nposition_max: 200\nhoming_speed: 20\n"}
    for with_extra, as_if in [(False, "")] + [(True, as_if) for as_if in AS_IF]:
        name, record = f"{kinematics}-probing-{'on' if with_extra else 'off'}{as_if and '-' + as_if}", out / f"{kinematics}-probing.jsonl"
        bed = f"[bed]\ncommand: {trueaxis}\nmachine: {out / 'printer'}\nfile: {record}\n"
        _, told = host(name, kinematics, probing.program(), f"[{as_if}]\n" * bool(as_if) + probing.SECTIONS + bed + own(out / "printer.tcomp") * with_extra, limits, steps=False)
        found = probing.check(trueaxis, out / "printer", record)
        print(f"{name}: off by at most, in microsteps: " + ", ".join(f"{what} {off:.2f}" for what, off in found.items()))
        if not all(off < probing.ALLOWED if with_extra else off > 10 * probing.ALLOWED for off in found.values()):
            sys.exit(f"{name}: needed less than {probing.ALLOWED} with the correction, and without far more")

    # Setting one axis never moves the motor zero of another; M84 switches the correction off.
    for as_if in AS_IF:
        name = kinematics + (as_if and "-" + as_if)
        record, bed = out / f"{name}-zeros.jsonl", f"[bed]\ncommand: {trueaxis}\nmachine: {out / 'printer'}\nfile: {out / 'zeros-bed.jsonl'}\n"
        settings = f"[{as_if}]\n" * bool(as_if) + probing.SECTIONS + bed + f"[zero]\nfile: {record}\n" + own(out / "printer.tcomp")
        _, told = host(f"{name}-zeros", kinematics, zeros.program(), settings, limits, steps=False)
        found, sought = zeros.check(record)
        print(f"{name}: zeros of other axes moved by at most, in mm: " + ", ".join(f"{what} {moved:.6f}" for what, moved in found) +
              f"; the place sought is off by {sought:.4f}")
        if not all(moved <= zeros.ALLOWED for _, moved in found):
            sys.exit(f"{name}: needed at most {zeros.ALLOWED}")
        if abs(sought) > zeros.STEP:
            sys.exit(f"{name}: needed the place sought to a step, {zeros.STEP}")
        if told.count("trueaxis: correction on") < 4 or not told.rstrip().split("trueaxis: correction ")[-1].startswith("off"):
            sys.exit(f"{name}: needed the correction on after every homing and off with the motors in\n{told[-3000:]}")

# The extra refuses a host that lacks a call, in one line, and the machine runs as without the extra.
plain = None
for kind, names in calls().items():
    for name in names:
        words = f"trueaxis: this version of the host has no {kind}.{name}, which the extra calls; running uncompensated"
        steps, told = host("lacking", "cartesian", START + "G1 X20 Y30 Z-90 F3000\nM400\n", f"[lacking]\ncall: {kind}.{name}\n" + own(tables))
        if told.count(words) < 1 or "Traceback" in told:
            sys.exit(f"lacking: needed {words!r} in\n{told[-3000:]}")
        plain = plain or host("lacking-plain", "cartesian", START + "G1 X20 Y30 Z-90 F3000\nM400\n")[0]
        if steps != plain:
            sys.exit(f"lacking {kind}.{name}: other steps than without the extra")
print(f"a host that lacks a call of {', '.join(calls())}: refused")

for name in ("homing_move", "stepper_positions"):
    words = f"trueaxis_probe: this version of the host has no homing.HomingMove.{name}, which the extra uses"
    _, told = host("lacking-probe", "cartesian", START, f"[lacking]\ncall: homing.HomingMove.{name}\n[trueaxis_probe]\npin: ^PA30\n", refused=True)
    if words not in told:
        sys.exit(f"lacking-probe: needed {words!r} in\n{told[-3000:]}")

# A calibration program with a touch probe, and its log.
for kinematics in ("cartesian", "corexy"):
    folder, name = out / "touched", f"{kinematics}-touched"
    _, told = host(name, kinematics, touched.program(trueaxis, folder), touched.SECTIONS, steps=False)
    for term, value, error, truth in touched.check(trueaxis, folder, out / f"{name}.log"):
        print(f"{name}: {term} found {value:.1f} for {truth:.0f}, standard error {error:.1f}")
        if abs(value - truth) > 4 * error or error > 5:
            sys.exit(f"{name}: needed {term} within four standard errors, and these at most 5")
    for what, moves, words in (("absent", touched.ABSENT, "No trigger on probe after full movement"), ("within", touched.WITHIN, "Probe triggered prior to movement")):
        _, told = host(f"{name}-{what}", kinematics, touched.START + moves, touched.SECTIONS, refused=True)
        if words not in told:
            sys.exit(f"{name}, {what}: needed {words!r} in\n{told[-3000:]}")

# Tables that cover less than the machine's travel are reported.
wide = {**LIMITS, "x": "position_min: 0\nposition_max: 400\n"}
_, told = host("partial", "cartesian", START + MOVES, own(tables), wide, steps=False)
words = "trueaxis: the tables cover X -300 to 300 of 0 to 400 mm; beyond, their value at the end holds"
if words not in told:
    sys.exit(f"partial: needed {words!r} in\n{told[-3000:]}")

# Cost of solving for a step: the least of several runs. Klipper's main line solves in C and reports no time.
for kinematics in ("cartesian", "corexy")[: 0 if main_line else 2]:
    spent = {}
    for name, extra in (("plain", ""), ("corrected", own(tables))):
        cost = out / f"{kinematics}-{name}.cost"
        for _ in range(3):
            steps, _ = host(f"{kinematics}-{name}-cost", kinematics, START + "COST\n" + MOVES + "COST\n", extra + f"[cost]\nfile: {cost}\n")
            count = sum(int(line.split("count=")[1].split()[0]) for line in steps if "queue_step" in line)
            spent[name] = min(spent.get(name, 1e9), int(cost.read_text()) / count)
    print(f"{kinematics}: solving for a step takes {spent['plain']:.0f} ns, with the correction {spent['corrected']:.0f} ns")

# Moves through every tenth command of the recording common to all hosts, starting where all axes are well within their
# travel: with motors at an end, the tool would be beyond it.
with (hosts / "run.csv").open() as file:
    points = [tuple(float(row[f"{axis}_cmd_mm"]) for axis in "xyz") for row in csv.DictReader(file)][::10]
points = points[next(k for k, point in enumerate(points) if max(point) < -1.0):]
# Without exponents, because an E would be read as the extruder's word.
words = ["X=%.9f Y=%.9f Z=%.9f" % points[0]] + ["G1 X%.9f Y%.9f Z%.9f F3000" % point for point in points[1:]]
travel = {axis: f"position_min: {low}\nposition_max: 0\n" for axis, low in (("x", -300), ("y", -200), ("z", -400))}
record = out / "hosts.jsonl"
host("hosts", "cartesian", f"SET_KINEMATIC_POSITION {words[0]}\nG90\n" + "\n".join(words[1:]) + "\nM400\n",
     own(hosts / "machine.tcomp") + f"[record]\nfile: {record}\n", travel)
subprocess.run([sys.executable, HERE / "steps.py", trueaxis, hosts_machine, record, out / "hosts.steps",
                hosts / "klipper.json"], check=True)
