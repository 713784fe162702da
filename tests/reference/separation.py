#!/usr/bin/env python3
"""Readings of three and of five probes on a pin with a following arm, from first principles; what is to be found in them.

Usage: separation.py probes > separation_probes.csv
       separation.py truth > separation_truth.csv
       separation.py five-probes > separation_five_probes.csv
       separation.py five-truth > separation_five_truth.csv
       separation.py check                                  standard library only

N = 64, harmonics 2..12, phi2 = 66.1 degrees, phi3 = 125.4 degrees (no whole slots), crank throw 60 mm, wheel radius
300 mm, pin radius 30 mm; two revolutions. Nothing here is shared with the Rust code: the arm is solved for its crank
angle by bisection, the probes read the sum of cosines at the place where they stand plus the motion of the centre along
their own direction, and `check` takes the readings apart again with a discrete Fourier transform as a plain double sum,
and evaluates the spindle by its definitions. Every number is the shortest decimal of its double, µm.

Five probes stand at 0, 39.2, 101.3, 158.9 and 243.3 degrees and read with noise of up to 0.2 µm. Their truth is what least
squares over all readings of a revolution find, with the mean radius, two unknowns for each harmonic and two for the place
of the centre at every theta: normal equations of all 151 unknowns at once, by elimination.
"""

import cmath
import math
import random
import sys

N, REVOLUTIONS = 64, 2
FIRST, LAST = 2, 12
PHI2, PHI3 = math.radians(66.1), math.radians(125.4)
CRANK, WHEEL, PIN = 60.0, 300.0, 30.0
# Amplitude in µm and phase in rad of harmonics 2, 3, ...; the same in both revolutions.
PROFILE = [(3.0, 0.3), (1.75, -2.0), (0.5, 1.0), (2.25, 3.0), (0.0, 0.0), (1.0, -0.7), (0.25, 2.2), (0.75, 0.1),
           (0.6, -1.9), (0.3, 2.9), (0.9, -3.0)]


def profile(theta):
    return sum(a * math.cos(k * theta + phase) for k, (a, phase) in enumerate(PROFILE, FIRST))


def arm_angle(theta):
    """beta at theta = alpha + beta, R sin(alpha) = (R_S + R_W) sin(beta): alpha by bisection."""
    low, high = theta - 1.0, theta + 1.0
    for _ in range(100):
        alpha = 0.5 * (low + high)
        if alpha + math.asin(CRANK * math.sin(alpha) / (WHEEL + PIN)) < theta:
            low = alpha
        else:
            high = alpha
    return theta - 0.5 * (low + high)


def motion():
    """R_X and R_Y of every row: eccentricity of 50 µm, a third and a half harmonic, noise that does not repeat."""
    generator = random.Random(4)
    rows = []
    for row in range(N * REVOLUTIONS):
        turn = 2.0 * math.pi * row / N
        x = 50.0 * math.cos(turn + 0.4) + 2.0 * math.cos(3.0 * turn) + 0.8 * math.cos(0.5 * turn)
        y = -4.0 + 50.0 * math.sin(turn + 0.4) + 1.5 * math.cos(2.0 * turn - 1.0)
        rows.append((x + generator.uniform(-0.3, 0.3), y + generator.uniform(-0.3, 0.3)))
    return rows


def readings():
    rows = []
    for row, (x, y) in enumerate(motion()):
        theta = 2.0 * math.pi * (row % N) / N
        beta = arm_angle(theta)
        rows.append([profile(theta + phi) + y * math.cos(phi + beta) + x * math.sin(phi + beta)
                     for phi in (0.0, PHI2, PHI2 + PHI3)])
    return rows


def separated(rows):
    """r of one revolution from its readings, by a double sum."""
    k2, k3 = -math.sin(PHI2 + PHI3) / math.sin(PHI3), math.sin(PHI2) / math.sin(PHI3)
    found = [0.0] * N
    for k in range(FIRST, LAST + 1):
        total = sum((h1 + k2 * h2 + k3 * h3) * cmath.exp(-2j * math.pi * k * i / N)
                    for i, (h1, h2, h3) in enumerate(rows)) / N
        gain = 1.0 + k2 * cmath.exp(1j * k * PHI2) + k3 * cmath.exp(1j * k * (PHI2 + PHI3))
        for i in range(N):
            found[i] += 2.0 * (total / gain * cmath.exp(2j * math.pi * k * i / N)).real
    return found


def spindle(values):
    """Synchronous, asynchronous, total, once per revolution (amplitude, phase in degrees)."""
    mean = [sum(values[i::N]) / REVOLUTIONS for i in range(N)]
    position = sum(mean) / N
    first = 2.0 / N * sum(m * cmath.exp(-2j * math.pi * i / N) for i, m in enumerate(mean))
    setting = [position + (first * cmath.exp(2j * math.pi * i / N)).real for i in range(N)]
    rest = [m - s for m, s in zip(mean, setting)]
    points = [value - setting[row % N] for row, value in enumerate(values)]
    asynchronous = max(max(values[i::N]) - min(values[i::N]) for i in range(N))
    return (max(rest) - min(rest), asynchronous, max(points) - min(points), abs(first),
            math.degrees(cmath.phase(first)))


FIVE = [math.radians(degrees) for degrees in (0.0, 39.2, 101.3, 158.9, 243.3)]


def five_readings():
    generator = random.Random(7)
    rows = []
    for row, (x, y) in enumerate(motion()):
        theta = 2.0 * math.pi * (row % N) / N
        beta = arm_angle(theta)
        rows.append([profile(theta + phi) + y * math.cos(phi + beta) + x * math.sin(phi + beta) + generator.uniform(-0.2, 0.2)
                     for phi in FIVE])
    return rows


def solved(matrix, right):
    """Unknowns of a symmetric positive definite system, by elimination."""
    count = len(right)
    rows = [row[:] + [value] for row, value in zip(matrix, right)]
    for i in range(count):
        for j in range(i + 1, count):
            factor = rows[j][i] / rows[i][i]
            if factor != 0.0:
                rows[j] = [a - factor * b for a, b in zip(rows[j], rows[i])]
    found = [0.0] * count
    for i in reversed(range(count)):
        found[i] = (rows[i][count] - sum(rows[i][j] * found[j] for j in range(i + 1, count))) / rows[i][i]
    return found


def least_squares(rows):
    """r, R_X and R_Y of one revolution at every theta."""
    shape = 1 + 2 * (LAST - FIRST + 1)
    count = shape + 2 * N
    matrix, right = [[0.0] * count for _ in range(count)], [0.0] * count
    harmonics = range(FIRST, LAST + 1)
    for i, readings_here in enumerate(rows):
        theta = 2.0 * math.pi * i / N
        beta = arm_angle(theta)
        for phi, reading in zip(FIVE, readings_here):
            entries = [(0, 1.0)]
            for place, k in enumerate(harmonics):
                entries.append((1 + 2 * place, math.cos(k * (theta + phi))))
                entries.append((2 + 2 * place, math.sin(k * (theta + phi))))
            entries.append((shape + 2 * i, math.sin(phi + beta)))
            entries.append((shape + 2 * i + 1, math.cos(phi + beta)))
            for a, one in entries:
                right[a] += one * reading
                for b, other in entries:
                    matrix[a][b] += one * other
    found = solved(matrix, right)
    result = []
    for i in range(N):
        theta = 2.0 * math.pi * i / N
        r = sum(found[1 + 2 * place] * math.cos(k * theta) + found[2 + 2 * place] * math.sin(k * theta)
                for place, k in enumerate(harmonics))
        result.append((r, found[shape + 2 * i], found[shape + 2 * i + 1]))
    return result


def main():
    what = sys.argv[1]
    if what == "probes":
        print("# separation.py probes")
        print("h1_um,h2_um,h3_um")
        for row in readings():
            print(",".join(repr(h) for h in row))
    elif what == "truth":
        print("# separation.py truth")
        for name, axis in (("x", 0), ("y", 1)):
            figures = spindle([row[axis] for row in motion()])
            print(f"# spindle {name} " + " ".join(repr(figure) for figure in figures))
        print("theta_deg,r_um,rx_um,ry_um")
        for row, (x, y) in enumerate(motion()):
            i = row % N
            print(f"{360.0 * i / N!r},{profile(2.0 * math.pi * i / N)!r},{x!r},{y!r}")
    elif what == "five-probes":
        print("# separation.py five-probes")
        print("h1_um,h2_um,h3_um,h4_um,h5_um")
        for row in five_readings():
            print(",".join(repr(h) for h in row))
    elif what == "five-truth":
        print("# separation.py five-truth")
        print("theta_deg,r_um,rx_um,ry_um")
        rows = five_readings()
        for start in range(0, len(rows), N):
            for i, values in enumerate(least_squares(rows[start:start + N])):
                print(f"{360.0 * i / N!r}," + ",".join(repr(value) for value in values))
    elif what == "check":
        rows = readings()
        worst = 0.0
        for start in range(0, len(rows), N):
            found = separated(rows[start:start + N])
            worst = max([worst] + [abs(r - profile(2.0 * math.pi * i / N)) for i, r in enumerate(found)])
        print(f"largest difference {worst:.1e} µm")
        sys.exit(worst > 1e-9)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
