"""Simulates a control with a probe, a ball and a ring: runs a LinuxCNC probing program and prints its log.

`python3 probing.py PROGRAM.ngc > LOG`, with the program that `trueaxis calibrate plan` writes for records/probing/task.toml.
With three offsets, µm, as arguments, the machine has no other errors, and the program is that of `trueaxis keep plan`.
"""

import random
import sys
from pathlib import Path

HERE = Path(__file__).parents[3] / "records/probing"
TASK = (HERE / "task.toml").read_text(encoding="utf-8")
KEEP = (HERE / "keep.toml").read_text(encoding="utf-8")
MACHINE = (HERE / "mill" / "machine.toml").read_text(encoding="utf-8")
TIP = 3.0 - 0.008  # effective radius, mm


def actual(at, reverse, count):
    """Actual position of the tip: C0Y 50 µrad, X 40 and Y −30 ppm too long, 6 µm lost motion in X, a drift."""
    x, y, z = at
    return (x + 40e-6 * x - 50e-6 * y + (0.006 if reverse[0] else 0.0) + 2e-6 * count, y - 30e-6 * y, z)


def moved(*offsets_um):
    """A machine without errors except these offsets."""
    return lambda at, reverse, count: tuple(a + 1e-3 * offset for a, offset in zip(at, offsets_um))


def gap(at, in_ring):
    """Distance from the tip to the nearest surface: the ball's, or the ring's if it is set up."""
    ball = sum((a - b) ** 2 for a, b in zip(at, (40.1, 39.8, -250.2))) ** 0.5 - 12.5 - TIP
    u, v, along = at[0] - 250.2, at[1] - 200.1, at[2] + 149.9
    ring = 75.0 - TIP - (u * u + v * v) ** 0.5 if in_ring and abs(along) < 12.0 else 5.0
    return min(ball, ring)


def run(program, actual=actual, seed=3):
    """Runs a program; returns its log."""
    noise = random.Random(seed)
    log, at, reverse, trip, pauses, count = [], [0.0] * 3, [False] * 3, [0.0] * 3, 0, 0
    for line in program.splitlines():
        if line.startswith("(LOG,"):
            text = line[5:].rstrip(")").replace("#5070", "1.000000")
            for k in range(3):
                text = text.replace(f"#{5061 + k}", f"{trip[k]:.6f}")
            log.append(text)
        pauses += line == "M0"
        code, *words = line.split(" ")
        if code not in ("G0", "G1", "G38.2"):
            continue
        end = list(at)
        for word in words:
            if word[0] in "XYZ":
                end["XYZ".index(word[0])] = float(word[1:])
        reverse = [e < a if abs(e - a) > 0.01 else r for a, e, r in zip(at, end, reverse)]
        if code == "G38.2":
            low, high = 0.0, 1.0
            for _ in range(60):
                share = 0.5 * (low + high)
                on = [a + share * (e - a) for a, e in zip(at, end)]
                low, high = (share, high) if gap(actual(on, reverse, count), pauses > 1) > 0 else (low, share)
            far = sum((e - a) ** 2 for a, e in zip(at, end)) ** 0.5
            low += noise.gauss(0.0, 0.0005) / far
            trip = end = [a + low * (e - a) for a, e in zip(at, end)]
            count += 1
        at = end
    return "\n".join(log) + "\n"


if __name__ == "__main__":
    of = [float(offset) for offset in sys.argv[2:]]
    with open(sys.argv[1], encoding="utf-8") as file:
        text = file.read()
    sys.stdout.write(run(text, moved(*of), seed=4 + any(of)) if of else run(text))
