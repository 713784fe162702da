#!/usr/bin/env python3
"""Reference circles of small point sets by full enumeration with 60 digits: tests/reference/circles.py > circles.json

Standard library only. Coordinates are floats taken as the exact numbers they are.
mzc: smallest max-min over every centre that two pairs of points, or three points, determine; none where a straight
     strip is at least as narrow.
mcc: smallest circle on two or three points that holds all.
mic: largest empty circle on three points with an acute triangle; none where half a turn or more around the
     least-squares centre is open.
lsc: Newton's method on sum (d - mean d)^2 from the algebraic centre, until 50 digits stand.
"""
import json
import math
import random
from decimal import Decimal as D, getcontext
from itertools import combinations

getcontext().prec = 60


def distances(points, c):
    return [((p[0] - c[0]) ** 2 + (p[1] - c[1]) ** 2).sqrt() for p in points]


def equal(a, b, c, d):
    """Centre equally far from a and b, and from c and d."""
    x1, y1, x2, y2 = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    h1 = (x1 * (a[0] + b[0]) + y1 * (a[1] + b[1])) / 2
    h2 = (x2 * (c[0] + d[0]) + y2 * (c[1] + d[1])) / 2
    det = x1 * y2 - x2 * y1
    if abs(det) < D(10) ** -45:
        return None
    return ((h1 * y2 - h2 * y1) / det, (x1 * h2 - x2 * h1) / det)


def strip(points):
    best = None
    for a, b in combinations(points, 2):
        x, y = b[0] - a[0], b[1] - a[1]
        length = (x * x + y * y).sqrt()
        if length:
            across = [(p[0] * y - p[1] * x) / length for p in points]
            width = max(across) - min(across)
            best = width if best is None else min(best, width)
    return best


def mzc(points):
    best = None
    pairs = list(combinations(points, 2))
    for first, second in combinations(pairs, 2):
        c = equal(*first, *second)
        if c is not None:
            d = distances(points, c)
            zone = max(d) - min(d)
            if best is None or zone < best[0]:
                best = (zone, c, (max(d) + min(d)) / 2)
    return best if best[0] < strip(points) else None


def mcc(points):
    centres = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in combinations(points, 2)]
    centres += [equal(a, b, a, c) for a, b, c in combinations(points, 3)]
    best = None
    for c in centres:
        if c is not None:
            d = distances(points, c)
            if best is None or max(d) < best[2]:
                best = (max(d) - min(d), c, max(d))
    return best


def mic(points, centre):
    angles = sorted(math.atan2(p[1] - centre[1], p[0] - centre[0]) for p in points)
    gaps = [b - a for a, b in zip(angles, angles[1:])] + [angles[0] + math.tau - angles[-1]]
    if max(gaps) >= math.pi:
        return None
    best = None
    for a, b, c in combinations(points, 3):
        acute = all(
            (q[0] - p[0]) * (r[0] - p[0]) + (q[1] - p[1]) * (r[1] - p[1]) > 0
            for p, q, r in ((a, b, c), (b, c, a), (c, a, b))
        )
        centre = equal(a, b, a, c)
        if acute and centre is not None:
            d = distances(points, centre)
            radius = distances([a], centre)[0]
            if min(d) > radius - D(10) ** -45 and (best is None or min(d) > best[2]):
                best = (max(d) - min(d), centre, min(d))
    return best


def lsc(points):
    n = len(points)
    mean = [sum(p[k] for p in points) / n for k in (0, 1)]
    q = [(p[0] - mean[0], p[1] - mean[1]) for p in points]
    # Algebraic start: x^2 + y^2 = 2 a x + 2 b y + constant.
    xx, xy, yy = (sum(u * v for u, v in zip(*pair)) for pair in
                  (([p[0] for p in q],) * 2, ([p[0] for p in q], [p[1] for p in q]), ([p[1] for p in q],) * 2))
    xz, yz = (sum(p[k] * (p[0] ** 2 + p[1] ** 2) for p in q) / 2 for k in (0, 1))
    det = xx * yy - xy * xy
    c = [(xz * yy - yz * xy) / det, (yz * xx - xz * xy) / det]

    def cost_and_step(c):
        d = distances(q, c)
        r = sum(d) / n
        u = [((p[0] - c[0]) / e, (p[1] - c[1]) / e) for p, e in zip(q, d)]
        su = [sum(v[k] for v in u) for k in (0, 1)]
        g = [sum(v[k] * (e - r) for v, e in zip(u, d)) for k in (0, 1)]
        h = [[sum(v[i] * v[j] for v in u) - su[i] * su[j] / n
              + sum((e - r) / e * ((i == j) - v[i] * v[j]) for v, e in zip(u, d)) for j in (0, 1)] for i in (0, 1)]
        return sum((e - r) ** 2 for e in d), g, h

    damping = D(0)
    cost, g, h = cost_and_step(c)
    for _ in range(400):
        a, b, d = h[0][0] + damping, h[0][1], h[1][1] + damping
        det = a * d - b * b
        if det <= 0 or a <= 0:
            damping = max(damping * 4, D("0.01"))
            continue
        step = ((d * g[0] - b * g[1]) / det, (a * g[1] - b * g[0]) / det)
        trial = [c[0] + step[0], c[1] + step[1]]
        if abs(trial[0]) + abs(trial[1]) > 1000000:
            return None
        new = cost_and_step(trial)
        if new[0] <= cost:
            c, (cost, g, h) = trial, new
            damping = damping / 10 if damping > D("1e-12") else D(0)
            if abs(step[0]) + abs(step[1]) < D(10) ** -50:
                break
        else:
            if abs(step[0]) + abs(step[1]) < D(10) ** -45:
                break
            damping = max(damping * 4, D("0.01"))
    d = distances(q, c)
    return max(d) - min(d), (mean[0] + c[0], mean[1] + c[1]), sum(d) / n


def polar(r, a, x=0.0, y=0.0):
    return (x + r * math.cos(a), y + r * math.sin(a))


def sets():
    rng = random.Random(12181)
    angles = lambda n, turn=math.tau: [turn * (i + rng.uniform(-0.3, 0.3)) / n for i in range(n)]
    for n in (5, 6, 7, 8, 9, 10, 11, 12):
        yield f"near-round 1e-2, {n}", [polar(10 + 0.1 * rng.uniform(-1, 1), a) for a in angles(n)]
        yield f"near-round 1e-6 far away, {n}", [polar(13 + 1e-5 * rng.uniform(-1, 1), a, -560, 34) for a in angles(n)]
        yield f"cloud, {n}", [(rng.uniform(-3, 3), rng.uniform(-2, 2)) for _ in range(n)]
        yield f"ellipse, {n}", [(7 * math.cos(a), 4 * math.sin(a)) for a in angles(n)]
    for lobes in (2, 3, 4, 5):
        yield f"{lobes} lobes", [polar(20 + 0.3 * math.cos(lobes * a) + 0.02 * rng.uniform(-1, 1), a) for a in angles(12)]
    for n in (6, 9, 12):
        yield f"near-round 1e-10 far away, {n}", [polar(13 + 1e-9 * rng.uniform(-1, 1), a, -560, 34) for a in angles(n)]
    for turn in (0.4, 1.5, 2.5, 3.0, 4.5):
        yield f"arc of {turn} rad", [polar(50 + 0.05 * rng.uniform(-1, 1), a, 5, -7) for a in angles(11, turn)]
    yield "dented square", [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (0.0, 0.75), (0.125, -0.8125)]


def main():
    cases = []
    for name, points in sets():
        exact = [(D(x), D(y)) for x, y in points]
        fit = lsc(exact)
        found = {"lsc": fit, "mzc": mzc(exact), "mcc": mcc(exact), "mic": mic(exact, fit[1]) if fit else None}
        case = {"name": name, "points": [[repr(v) for v in point] for point in points]}
        for key, circle in found.items():
            case[key] = circle and {k: f"{v:.40g}" for k, v in
                                    (("zone", circle[0]), ("cx", circle[1][0]), ("cy", circle[1][1]), ("r", circle[2]))}
        cases.append(case)
    print("[" + ",\n".join(json.dumps(case) for case in cases) + "]")


if __name__ == "__main__":
    main()
