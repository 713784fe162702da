#!/usr/bin/env python3
"""A cubic NURBS through the NACA 2415 profile as G-code: naca2415.py > naca2415.ngc

Standard library only. The four-digit section (Jacobs, Ward, Pinkerton, NACA report 460): camber 2 % at 40 % of the chord,
thickness 15 %, the last coefficient 0.1036 so that the trailing edge is closed. From the trailing edge over the upper
side, the nose and the lower side back. The parameter is the square root of x with the sign of the side: the profile is
smooth in it through the nose. Least squares over equidistant samples, ends held, uniform clamped knots as G5.2 has them.
"""

import math

CHORD_MM = 100.0
THICKNESS = 0.15
CAMBER = 0.02
PLACE = 0.4
FEED_MM_PER_MIN = 12000
POINTS = 48
DEGREE = 3
SAMPLES = 2000


def profile(root):
    """Point of the section, mm; `root` from -1 to 1, positive on the upper side."""
    x, size = root * root, abs(root)
    y = 0.2969 * size - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4
    y = 5 * THICKNESS * math.copysign(y, root)
    side = PLACE if x < PLACE else 1 - PLACE
    camber = CAMBER / side**2 * ((0 if x < PLACE else 1 - 2 * PLACE) + 2 * PLACE * x - x * x)
    slope = math.atan(2 * CAMBER / side**2 * (PLACE - x))
    return (CHORD_MM * (x - y * math.sin(slope)), CHORD_MM * (camber + y * math.cos(slope)))


def basis(u):
    """Index of the first control point with weight at u, and the weights of DEGREE + 1 (Cox and de Boor)."""
    last = POINTS - DEGREE
    knot = lambda i: min(max(i - DEGREE, 0), last)
    span = min(int(u), last - 1) + DEGREE
    values = [1.0]
    for d in range(1, DEGREE + 1):
        raised = [0.0] * (d + 1)
        for r, value in enumerate(values):
            left, right = knot(span + r + 1 - d), knot(span + r + 1)
            share = (u - left) / (right - left)
            raised[r] += (1 - share) * value
            raised[r + 1] += share * value
        values = raised
    return span - DEGREE, values


def solved(matrix, right):
    """Solves by Gaussian elimination; the normal equations are positive definite and need no pivot."""
    n = len(matrix)
    for i in range(n):
        for j in range(i + 1, min(i + DEGREE + 1, n)):
            factor = matrix[j][i] / matrix[i][i]
            for k in range(i, min(i + DEGREE + 1, n)):
                matrix[j][k] -= factor * matrix[i][k]
            right[j] = [a - factor * b for a, b in zip(right[j], right[i])]
    for i in reversed(range(n)):
        for k in range(i + 1, min(i + DEGREE + 1, n)):
            right[i] = [a - matrix[i][k] * b for a, b in zip(right[i], right[k])]
        right[i] = [a / matrix[i][i] for a in right[i]]
    return right


def fitted():
    ends = [profile(1.0), profile(-1.0)]
    n = POINTS - 2
    matrix = [[0.0] * n for _ in range(n)]
    right = [[0.0, 0.0] for _ in range(n)]
    for i in range(1, SAMPLES):
        first, values = basis((POINTS - DEGREE) * i / SAMPLES)
        at = list(profile(1 - 2 * i / SAMPLES))
        inner = []
        for r, value in enumerate(values):
            point = first + r
            if point in (0, POINTS - 1):
                end = ends[point > 0]
                at = [a - value * e for a, e in zip(at, end)]
            else:
                inner.append((point - 1, value))
        for j, value in inner:
            right[j] = [a + value * c for a, c in zip(right[j], at)]
            for k, other in inner:
                matrix[j][k] += value * other
    return [ends[0], *solved(matrix, right), ends[1]]


def deviation(points):
    """Largest distance of the curve from the profile across it, mm."""
    worst = 0.0
    for i in range(1, 8 * SAMPLES):
        share = i / (8 * SAMPLES)
        first, values = basis((POINTS - DEGREE) * share)
        at = [sum(v * points[first + r][k] for r, v in enumerate(values)) for k in (0, 1)]
        root = 1 - 2 * share
        before, here, after = profile(root - 1e-6), profile(root), profile(root + 1e-6)
        along = [after[0] - before[0], after[1] - before[1]]
        across = (at[0] - here[0]) * along[1] - (at[1] - here[1]) * along[0]
        worst = max(worst, abs(across) / math.hypot(*along))
    return worst


def main():
    points = [tuple(round(c, 6) + 0.0 for c in point) for point in fitted()]
    print("(NACA 2415, chord 100 mm, as a cubic NURBS; made by naca2415.py)")
    print(f"(within {1000 * deviation(points):.2f} um of the profile)")
    print(f"G21 G17 G90 F{FEED_MM_PER_MIN}")
    # In along the tangent and to rest; out along it, so that the end of the profile is passed and not braked into.
    lead_in, lead_out = (
        " ".join(f"{axis}{a + 2 * (a - b):.6f}" for axis, a, b in zip("XY", end, beside))
        for end, beside in ((points[0], points[1]), (points[-1], points[-2]))
    )
    print(f"G0 {lead_in}\nG0 X{points[0][0]} Y{points[0][1]}\nG4 P0")
    for i, (x, y) in enumerate(points[1:]):
        print(f"{f'G5.2 L{DEGREE + 1} ' if i == 0 else ''}X{x} Y{y} P1")
    print(f"G5.3\nG0 {lead_out}\nM2")


if __name__ == "__main__":
    main()
