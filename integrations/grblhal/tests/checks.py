"""Compares the moves that the plugin planned with the exact machine: checks.py TRUEAXIS MACHINE MOVES...

The drives move in a straight line between two planner positions. Products of rigid transforms and the drives' directions of
travel then give the position of the tool (`trueaxis compensate --model exact`); they share no code with the plugin and its
library. SPDX-License-Identifier: MIT OR Apache-2.0
"""

import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

SAMPLES = 8  # of a stretch
# um: twice the chord tolerance of 0.5, plus 0.1 for the steps of 0.05, single precision and the first-order model.
BOUND_UM = 1.1
END_UM = 0.15  # where a line ends
HYSTERESIS_MM = 0.0004  # the plugin's 0.3 um and the rounding to steps, so that it is the one that turns first
TAKE_UP_MM = 0.02  # below this a stretch only takes up lost motion: within it the model's tool is on neither side


def read(path):
    """Returns the position before the first line, and [(end of the line, whether it is a feed move, [planner positions])], mm."""
    steps, before, lines = None, None, []
    for words in (line.split() for line in path.read_text().splitlines()):
        match words:
            case ["steps", value]:
                steps = float(value)
            case ["line" | "rapid" as kind, *point]:
                lines.append(([float(value) for value in point], kind == "line", []))
            case ["block", *point]:
                point = [int(value) / steps for value in point]
                if lines:
                    lines[-1][2].append(point)
                else:
                    before = point
    return before, lines


def errors(trueaxis, machine, positions, *direction):
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder) / "q.csv", Path(folder) / "e.csv"
        with given.open("w") as file:
            file.write("x_mm,y_mm,z_mm\n")
            file.writelines(",".join(f"{value:.7f}" for value in position) + "\n" for position in positions)
        command = [trueaxis, "compensate", machine, given, "--model", "exact", *direction, "-o", found]
        subprocess.run(command, check=True, capture_output=True)
        return [[1e-3 * float(row[f"e{axis}_um"]) for axis in "xyz"] for row in csv.DictReader(found.open())]


def tips(trueaxis, machine, positions):
    """Returns the positions of the tool while the drives pass through these positions. Only an axis' positioning error depends
    on the direction: that of its drive, which changes once the drive has moved back by more than the hysteresis."""
    both = errors(trueaxis, machine, positions), errors(trueaxis, machine, positions, "--reverse")
    found, negative, furthest = [], [0, 0, 0], list(positions[0])
    for position, *error in zip(positions, *both):
        for i, value in enumerate(position):
            back = value - furthest[i] if negative[i] else furthest[i] - value
            if back > HYSTERESIS_MM:
                negative[i] ^= 1
            if back > HYSTERESIS_MM or back < 0.0:
                furthest[i] = value
        found.append([value + error[negative[i]][i] for i, value in enumerate(position)])
    return found


def off_line(point, a, b):
    along = [y - x for x, y in zip(a, b)]
    square = sum(value * value for value in along)
    t = sum((p - x) * d for p, x, d in zip(point, a, along)) / square if square else 0.0
    return math.dist(point, [x + min(max(t, 0.0), 1.0) * d for x, d in zip(a, along)])


def check(trueaxis, machine, path):
    before, lines = read(path)
    positions, meaning = [before], [None]
    start = None
    for end, fed, blocks in lines:
        for block in blocks:
            take_up = math.dist(block, positions[-1]) < TAKE_UP_MM
            last = positions[-1]
            for i in range(1, SAMPLES + 1):
                positions.append([x + (y - x) * i / SAMPLES for x, y in zip(last, block)])
                meaning.append((start, end) if fed and start and not take_up else None)
        meaning[-1] = (end, end) if blocks else meaning[-1]
        start = end
    worst = {"on the way": 0.0, "at ends": 0.0, "uncompensated": 0.0}
    for tip, position, line in zip(tips(trueaxis, machine, positions), positions, meaning):
        if line:
            kind = "at ends" if line[0] is line[1] else "on the way"
            worst[kind] = max(worst[kind], 1e3 * off_line(tip, *line))
            if kind == "at ends":
                worst["uncompensated"] = max(worst["uncompensated"], 1e3 * math.dist(tip, position))
    stretches = sum(len(blocks) for *_, blocks in lines)
    print(f"{path.stem}: {len(lines)} lines, {stretches} stretches, tool off its line by at most "
          f"{worst['on the way']:.3f} um on the way, {worst['at ends']:.3f} um at ends; uncompensated {worst['uncompensated']:.1f} um")
    good = worst["on the way"] <= BOUND_UM and worst["at ends"] <= END_UM and worst["uncompensated"] > 10.0
    if not good or len(lines) < 100:
        print(f"FAILED {path.stem}: needed {BOUND_UM} um on the way, {END_UM} um at ends", file=sys.stderr)
    return good and len(lines) >= 100


if __name__ == "__main__":
    trueaxis, machine, *paths = sys.argv[1:]
    sys.exit(not all([check(trueaxis, machine, Path(path)) for path in paths]))
