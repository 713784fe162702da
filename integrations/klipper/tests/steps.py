"""Compares every step of a program with the planned moves and `trueaxis compensate`: steps.py TRUEAXIS MACHINE RECORD DUMP [RESULT.json].

The program follows SET_KINEMATIC_POSITION or G28. SPDX-License-Identifier: GPL-3.0-or-later
"""
import bisect
import json
import sys
from pathlib import Path

from truth import commands

trueaxis, machine, record, dump, *result = sys.argv[1:]
FREQUENCY = 20e6
runs = []
for line in map(json.loads, open(record)):
    if "move" in line:
        runs[-1][1].append(line["move"])
    else:
        runs.append((line, []))
# Homing sets positions several times, and switching off at the end sets one more. Use the last run that has moves.
sync, moves = [run for run in runs if run[1]][-1]
assert sync["on"]
phases = []
for t, accel_t, cruise_t, decel_t, x, y, z, rx, ry, rz, start_v, cruise_v, accel in moves:
    for length, v, a in ((accel_t, start_v, accel), (cruise_t, cruise_v, 0.0), (decel_t, cruise_v, -accel)):
        if length:
            phases.append((t, v, 0.5 * a, (x, y, z), (rx, ry, rz), length))
            way = (v + 0.5 * a * length) * length
            t, x, y, z = t + length, x + rx * way, y + ry * way, z + rz * way
starts = [phase[0] for phase in phases]


def at(time):
    t, v, half_a, start, r, length = phases[max(0, bisect.bisect_right(starts, time) - 1)]
    d = min(max(time - t, 0.0), length)
    way = (v + half_a * d) * d
    return [s + k * way for s, k in zip(start, r)]


# Position of a motor with the axes at x, y, z.
if sync["kinematics"] == "CoreXYKinematics":
    MOTORS = {"x": lambda p: p[0] + p[1], "y": lambda p: p[0] - p[1], "z": lambda p: p[2]}
else:
    MOTORS = {"x": lambda p: p[0], "y": lambda p: p[1], "z": lambda p: p[2]}
steppers = {oid: dict(motor=MOTORS[name.split("_")[1][0]], n=mcu, offset=mcu * step - cmd, step=step, clock=0, up=1)
            for name, oid, mcu, cmd, step in sync["steppers"]}
# A motor's position is its step count times its step, minus a constant offset.
steps = []
for line in open(dump):
    words = dict(w.split("=") for w in line.split() if "=" in w)
    s = steppers.get(int(words["oid"])) if "oid" in words else None
    if s is None:
        continue
    if "reset_step_clock" in line:
        s["clock"] = int(words["clock"])
    elif "set_next_step_dir" in line:
        s["up"] = 1 if words["dir"] == "1" else -1
    elif "queue_step" in line:
        interval = int(words["interval"])
        for _ in range(int(words["count"])):
            s["clock"] += interval
            interval += int(words["add"])
            if s["clock"] / FREQUENCY < starts[0]:
                continue
            # The host takes a step when the motor should be half-way.
            steps.append((s["motor"], s["clock"] / FREQUENCY, (s["n"] + 0.5 * s["up"]) * s["step"] - s["offset"], s["step"]))
            s["n"] += s["up"]
points = [at(time) for _, time, _, _ in steps]
finals = [(s["motor"], s["n"] * s["step"] - s["offset"], s["step"]) for s in steppers.values()]
points.append(at(1e9))
needed = commands(trueaxis, machine, points)
off = [abs(q - motor(needed[i])) / step for i, (motor, _, q, step) in enumerate(steps)]
without = [abs(q - motor(points[i])) / step for i, (motor, _, q, step) in enumerate(steps)]
net = [abs(q - motor(needed[-1])) / step for motor, q, step in finals]
print("%d steps, off by at most %.3f microsteps when taken (%.1f against the uncorrected moves), net %.3f"
      % (len(steps), max(off), max(without), max(net)))
for file in result:
    largest = max(part * step for part, (*_, step) in zip(off, steps))
    Path(file).write_text(json.dumps({"host": "klipper", "samples": len(steps), "same": None, "largest_mm": largest}) + "\n")
sys.exit(0 if len(steps) > 1000 and max(off) < 0.5 and max(net) <= 0.501 else 1)
