"""Compares the module with the same work in NumPy and prints a table: `python speed.py`.

Both evaluate the sample mill's nine-term model, with monotone cubics (PCHIP), at a million random positions. The NumPy
version computes whole columns: per axis one binary search for the cells, shared by its three curves, and one cubic per
curve. A test requires both to compute the same numbers. Contour errors and roundness have no counterpart in NumPy. Besides the
shortest time, the table states the processor time of all cores, which other work of the computer changes less.
"""

import json
import re
import time
from pathlib import Path

import numpy as np

import trueaxis

MACHINE = Path(__file__).resolve().parents[2] / "compensation-tables" / "mill-3axis"
COUNT = 1_000_000
ROUNDS = 5


def slopes(x, y):
    """Slopes of the monotone piecewise cubic by Fritsch and Butland (1984), with end slopes by Moler (2004)."""
    h, d = np.diff(x), np.diff(y) / np.diff(x)
    w0, w1 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = np.where(d[:-1] * d[1:] > 0, (w0 + w1) / (w0 / d[:-1] + w1 / d[1:]), 0.0)

    def end(h0, d0, h1, d1):
        m = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1)
        if m * d0 <= 0:
            return 0.0
        return 3 * d0 if d0 * d1 <= 0 and abs(m) > 3 * abs(d0) else m

    return np.concatenate([[end(h[0], d[0], h[1], d[1])], inner, [end(h[-1], d[-1], h[-2], d[-2])]])


class Mill:
    """The sample mill in positive travel: nine terms and squareness."""

    def __init__(self, folder):
        section = (folder / "machine.toml").read_text().split("\n[location]\n")[1].split("\n[")[0]
        location = dict(re.findall(r"^([ABC]0[YZ])_urad = (\S+)", section, re.M))
        self.a0z, self.b0z, self.c0y = (float(location[name]) * 1e-6 for name in ("A0Z", "B0Z", "C0Y"))
        self.axes = [self.curves(folder / f"{letter}.csv", letter.upper()) for letter in "xyz"]

    @staticmethod
    def curves(file, letter):
        header, *rows = [line for line in file.read_text().splitlines() if not line.startswith("#")]
        columns = dict(zip(header.split(","), np.array([row.split(",") for row in rows], float).T))
        x = columns[f"{letter}_mm"]
        curves = []
        for component in "XYZ":
            name = f"E{component}{letter}"
            y = 1e-3 * columns[f"{name}_um" if f"{name}_um" in columns else f"{name}_fwd_um"]
            m, h, d = slopes(x, y), np.diff(x), np.diff(y) / np.diff(x)
            curves.append((y[:-1], m[:-1], (3 * d - 2 * m[:-1] - m[1:]) / h, (m[:-1] + m[1:] - 2 * d) / h**2))
        return x, curves

    def error(self, at):
        """Error at each position, mm."""
        error = np.empty_like(at)
        for axis, (x, curves) in enumerate(self.axes):
            q = np.clip(at[:, axis], x[0], x[-1])
            cell = np.searchsorted(x[1:-1], q, side="right")
            t = q - x[cell]
            for component, (a, b, c, d) in enumerate(curves):
                value = ((d[cell] * t + c[cell]) * t + b[cell]) * t + a[cell]
                if axis == 0:
                    error[:, component] = value
                else:
                    error[:, component] += value
        y, z = at[:, 1], at[:, 2]
        error[:, 0] += self.b0z * z - self.c0y * y
        error[:, 1] -= self.a0z * z
        return error

    def correction(self, at, passes):
        correction = np.zeros_like(at)
        for _ in range(passes):
            correction = -self.error(at + correction)
        return correction


def positions(count):
    return np.random.default_rng(1).uniform([-300, -200, -400], [300, 200, 0], (count, 3))


def best(call, rounds=ROUNDS):
    """Shortest elapsed and processor time of several runs: other work of the computer can only lengthen a run."""
    times = []
    for _ in range(rounds):
        begun = time.perf_counter(), time.process_time()
        call()
        times.append((time.perf_counter() - begun[0], time.process_time() - begun[1]))
    return tuple(map(min, zip(*times)))


def contour_queries(count):
    """A path of lines and half circles, and positions some micrometres beside its lines."""
    segments = []
    for x in range(0, 1500, 15):
        segments += [{"type": "line", "start": [x, 0, 0], "end": [x + 5, 0, 0]},
                     {"type": "arc", "start": [x + 5, 0, 0], "end": [x + 15, 0, 0], "center": [x + 10, 0, 0]}]
    random = np.random.default_rng(2)
    of, u = random.integers(0, 100, count), random.random(count)
    at = np.column_stack([15 * of + 5 * u, np.zeros(count), np.zeros(count)]) + random.normal(0, 0.005, (count, 3))
    return trueaxis.Path.from_json(json.dumps({"segments": segments})), 2 * of, u, at


def readings(revolutions, n):
    """Three probes on a round with two and five lobes, µm."""
    theta = np.arange(revolutions * n) * (2 * np.pi / n)
    return np.column_stack([np.cos(2 * (theta - at)) + 0.3 * np.cos(5 * (theta - at)) for at in 2 * np.pi * np.array([0, 100, 237]) / n])


def main():
    machine, mill, at = trueaxis.Machine.load(MACHINE), Mill(MACHINE), positions(COUNT)
    print(f"{COUNT} positions, best of {ROUNDS}\n")
    print("| | trueaxis, s | of processors, s | NumPy, s | factor |\n|---|---|---|---|---|")
    cases = [("error", machine.error, mill.error)]
    for passes in (2, 3):
        cases.append((
            f"correction, {passes} passes",
            lambda at, passes=passes: machine.correction(at, inverse_passes=passes),
            lambda at, passes=passes: mill.correction(at, passes),
        ))
    for name, ours, theirs in cases:
        (seconds, used), (numpy_seconds, _) = best(lambda: ours(at)), best(lambda: theirs(at), 3)
        print(f"| {name} | {seconds:.3f} | {used:.3f} | {numpy_seconds:.2f} | {numpy_seconds / seconds:.0f} |", flush=True)
    path, *asked = contour_queries(100_000)
    traces = readings(1000, 512)
    for name, call in [("100000 contour errors", lambda: path.contour_error(*asked)),
                       ("1000 revolutions of 512 points", lambda: trueaxis.roundness(traces, n=512, p=100, q=137))]:
        seconds, used = best(call)
        print(f"| {name} | {seconds:.3f} | {used:.3f} | | |", flush=True)


if __name__ == "__main__":
    main()
