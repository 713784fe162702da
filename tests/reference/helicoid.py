#!/usr/bin/env python3
"""Five-axis stands on helical gear flanks with 50 digits: tests/reference/helicoid.py > tests/reference/helicoid.json

Standard library only. Nothing is taken from the closed formulas: the involute is a taut string unwound from the base
circle and screwed up by the lead; its normal is the cross product of central differences (step 1e-15, so about 28 digits
stand), turned to the tooth's outside; C is the turn that brings the normal into the plane x = 0, A the turn that brings
the spindle onto it, both as arguments of vectors; the tip's place follows from rotation matrices.
Gear data by relations of the generating rack: base pitch pi m_n cos(alpha_n) in the normal section, sin(beta_b) =
sin(beta) cos(alpha_n), lead = pi m_n z / sin(beta).
C is reduced to (-180, 180] degrees.
"""
import json
from decimal import Decimal as D, getcontext

getcontext().prec = 50


def arctan_small(x):
    total, power, k = D(0), x, 0
    while abs(power) > D(10) ** -55:
        total += power / (2 * k + 1) * (-1) ** k
        power *= x * x
        k += 1
    return total


PI = 4 * (4 * arctan_small(D(1) / 5) - arctan_small(D(1) / 239))


def cos_sin(x):
    x = x % (2 * PI)
    halved = x / 64
    c, s, term, k = D(0), D(0), D(1), 0
    while abs(term) > D(10) ** -55:
        c, s = (c + term, s) if k % 4 == 0 else (c, s + term) if k % 4 == 1 else (c - term, s) if k % 4 == 2 else (c, s - term)
        k += 1
        term = term * halved / k
    for _ in range(6):
        c, s = c * c - s * s, 2 * s * c
    return c, s


def argument(x, y):
    """Angle of (x, y) in (-pi, pi], by halving the angle until the series is fast."""
    r = (x * x + y * y).sqrt()
    x, y = x / r, y / r
    n = 0
    while n < 6:
        if x < 0 and y == 0:
            return PI
        x, y = ((1 + x) / 2).sqrt(), y / (2 * (1 + x)).sqrt() if x > -1 else D(1)
        n += 1
    return arctan_small(y / x) * 2 ** n


def degrees(x):
    return x * 180 / PI


def radians(x):
    return x * PI / 180


def about_x(a, v):
    c, s = cos_sin(a)
    return [v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]]


def about_z(a, v):
    c, s = cos_sin(a)
    return [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]]


def surface(rb, p, u, theta):
    """Start of the string on the base circle, unwound by u, then screwed by theta."""
    c, s = cos_sin(u)
    contact, tangent = [rb * c, rb * s], [-s, c]
    x, y = contact[0] - rb * u * tangent[0], contact[1] - rb * u * tangent[1]
    return about_z(theta, [x, y, p * theta])


def outward(rb, p, u, theta):
    h = D(10) ** -15
    du = [a - b for a, b in zip(surface(rb, p, u + h, theta), surface(rb, p, u - h, theta))]
    dt = [a - b for a, b in zip(surface(rb, p, u, theta + h), surface(rb, p, u, theta - h))]
    n = [du[1] * dt[2] - du[2] * dt[1], du[2] * dt[0] - du[0] * dt[2], du[0] * dt[1] - du[1] * dt[0]]
    length = sum(x * x for x in n).sqrt()
    # Outside of an external tooth: away from the gear's axis.
    f = surface(rb, p, u, theta)
    side = 1 if n[0] * f[0] + n[1] * f[1] > 0 else -1
    return [side * x / length for x in n]


def place(rb, p, u, theta, form, branch, pivot, w, direction_a, direction_c):
    n = outward(rb, p, u, theta)
    assert n[2] > 0, "faces away from the tool"
    # Branch 1 leaves the tool leaning to -y for a right-hand helix, to +y for a left-hand one; branch 2 the other way.
    lean = (-1 if branch == 1 else 1) * (1 if p > 0 else -1)
    c = PI / 2 * lean - argument(n[0], n[1])
    turned = about_z(c, n)
    assert abs(turned[0]) < D(10) ** -25 and turned[1] * lean > 0
    rest = [D(0), D(0), D(1)] if form == "vertical" else [D(0), D(1), D(0)]
    a = argument(turned[1], turned[2]) - argument(rest[1], rest[2])
    spindle = about_x(a, rest)
    tip = about_z(c, [x + y for x, y in zip(surface(rb, p, u, theta), w)])
    xyz = [t + pivot * (s - r) for t, s, r in zip(tip, spindle, rest)]
    c_deg = direction_c * degrees(c)
    c_deg -= 360 * ((c_deg - 180) / 360).to_integral_value(rounding="ROUND_CEILING")
    return [float(x) for x in xyz] + [float(direction_a * degrees(a)), float(c_deg)]


def gear(module, teeth, alpha_n, beta):
    cos_alpha, _ = cos_sin(radians(alpha_n))
    _, sin_beta = cos_sin(radians(beta))
    sin_beta_b = sin_beta * cos_alpha
    cos_beta_b = (1 - sin_beta_b ** 2).sqrt()
    rb = teeth * module * cos_alpha / (2 * cos_beta_b)
    lead = PI * module * teeth / sin_beta
    return rb, lead / (2 * PI)


def values(start, stop, count):
    return [start if count == 1 else start + (stop - start) * i / (count - 1) for i in range(count)]


def case(surface_arguments, rb, p, u, theta, form="horizontal", branch=1, pivot="150", w=("0", "0", "0"), a=1, c=1):
    arguments = surface_arguments + ["--u-rad", ":".join(map(str, u)), "--theta-rad", ":".join(map(str, theta))]
    arguments += ["--form", form, "--branch", str(branch), "--pivot-mm", pivot, "--work-offset-mm", ",".join(w)]
    arguments += ["--direction-a", str(a), "--direction-c", str(c), "--flank", "right" if p > 0 else "left"]
    rows = []
    for uu in values(D(u[0]), D(u[1]), u[2]):
        for tt in values(D(theta[0]), D(theta[1]), theta[2]):
            rows.append([float(uu), float(tt)] + place(rb, p, uu, tt, form, branch, D(pivot), [D(x) for x in w], a, c))
    return {"arguments": arguments, "base_radius_mm": float(rb), "lead_parameter_mm_per_rad": float(p), "rows": rows}


def main():
    cases = []
    for form in ("vertical", "horizontal"):
        for branch in (1, 2):
            base = ["--base-radius-mm", "36.25", "--lead-parameter-mm-per-rad", "130.5"]
            args = dict(form=form, branch=branch, pivot="187.5", w=("-12.5", "3.25", "-40"))
            cases.append(case(base, D("36.25"), D("130.5"), ("0.25", "0.75", 3), ("-0.5", "0.5", 3), **args))
            teeth = ["--module-mm", "3", "--teeth", "24", "--pressure-angle-deg", "20", "--helix-angle-deg"]
            rb, p = gear(D(3), 24, D(20), D(15))
            cases.append(case(teeth + ["15"], rb, p, ("0.125", "0.5", 4), ("0", "0.25", 2), form, branch, a=-1))
            rb, p = gear(D(3), 24, D(20), D(-15))
            cases.append(case(teeth + ["-15"], rb, p, ("-0.5", "-0.125", 2), ("-1", "2", 7), form, branch, c=-1))
    # Several turns of a worm, C beyond 360 degrees.
    worm = ["--base-radius-mm", "12", "--lead-parameter-mm-per-rad", "4"]
    cases.append(case(worm, D(12), D(4), ("1", "1", 1), ("0", "16", 33), branch=2, pivot="0"))
    print('{"cases": [\n' + ",\n".join(json.dumps(c) for c in cases) + "\n]}")


main()
