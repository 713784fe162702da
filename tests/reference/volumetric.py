"""Tip and orientation errors of three machines by products of 4 x 4 homogeneous transforms; plain Python 3.

From the bed outwards on either side an axis contributes T(offset) . E . motion: E the axis' errors in its carrier's
directions before its own motion, motion a shift by +-q or a turn by direction * q. Tables state the tool relative to the
workpiece: a carriage on the workpiece side moves by -q (linear) and errs by (-e, -w). Translations hold on the line
measured_at (rotary axes at zero): e = e_table - w x l, l = sum of m_j n_j over the linear axes between the moved frame and
the tool, with q_i for the axis i itself; without measured_at (zero) at the origin of the axis' moved frame.

    python3 volumetric.py > volumetric.json
"""

import json
import math
import random


def mul(a, b):
    return [[math.fsum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def shift(x, y, z):
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def inverse(t):
    r = [[t[j][i] for j in range(3)] for i in range(3)]
    p = [-math.fsum(r[i][k] * t[k][3] for k in range(3)) for i in range(3)]
    return [r[0] + [p[0]], r[1] + [p[1]], r[2] + [p[2]], [0, 0, 0, 1]]


def turn(vector):
    """Rodrigues' rotation about a rotation vector."""
    angle = math.sqrt(math.fsum(v * v for v in vector))
    if angle == 0:
        return shift(0, 0, 0)
    x, y, z = (v / angle for v in vector)
    c, s = math.cos(angle), math.sin(angle)
    d = 2 * math.sin(angle / 2) ** 2
    return [
        [c + x * x * d, x * y * d - z * s, x * z * d + y * s, 0],
        [y * x * d + z * s, c + y * y * d, y * z * d - x * s, 0],
        [z * x * d - y * s, z * y * d + x * s, c + z * z * d, 0],
        [0, 0, 0, 1],
    ]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(axis):
    return [1.0 if "XYZABC".index(axis) % 3 == k else 0.0 for k in range(3)]


def table_at(rows, q):
    """Linear, held at the ends; six errors in um and urad."""
    if q <= rows[0][0]:
        return rows[0][1:]
    for low, high in zip(rows, rows[1:]):
        if q <= high[0]:
            t = (q - low[0]) / (high[0] - low[0])
            return [a + t * (b - a) for a, b in zip(low[1:], high[1:])]
    return rows[-1][1:]


def chain_of(code):
    """[(axis, on the workpiece side)], from the workpiece to the tool."""
    links, workpiece = [], True
    for part in code.split()[1:-1]:
        if part == "b":
            workpiece = False
        else:
            links.append((part[0], workpiece))
    return links


def twist(machine, links, place, q):
    axis, workpiece = links[place]
    own = machine["axes"][axis]
    errors = table_at(own["table"], q[axis]) if "table" in own else [0.0] * 6
    e, w = [v / 1e3 for v in errors[:3]], [v / 1e6 for v in errors[3:]]
    lever = [0.0, 0.0, 0.0]
    between = [(a, own.get("measured_at_mm", [0, 0, 0])["XYZ".index(a)]) for a, _ in links[place + 1 :] if a in "XYZ"]
    if axis in "XYZ" and workpiece and any(own.get("measured_at_mm", [0, 0, 0])):
        between.append((axis, q[axis]))
    for a, m in between:
        lever = [v + m * n for v, n in zip(lever, unit(a))]
    e = [a - b for a, b in zip(e, cross(w, lever))]
    location = machine.get("location", {})
    if axis == "Y":
        e[0] -= location.get("C0Y_urad", 0) / 1e6 * q["Y"]
    if axis == "Z":
        e[0] += location.get("B0Z_urad", 0) / 1e6 * q["Z"]
        e[1] -= location.get("A0Z_urad", 0) / 1e6 * q["Z"]
    if axis in "ABC":
        e = [v + location.get(f"E{d}0{axis}_um", 0) / 1e3 for v, d in zip(e, "XYZ")]
        w = [v + location.get(f"E{d}0{axis}_urad", 0) / 1e6 for v, d in zip(w, "ABC")]
    return e, w


def side(machine, q, workpiece, with_errors):
    links = chain_of(machine["chain"])
    outwards = [k for k, (_, on) in enumerate(links) if on == workpiece]
    if workpiece:
        outwards.reverse()
    pose = shift(0, 0, 0)
    for place in outwards:
        axis, _ = links[place]
        sign = -1 if workpiece else 1
        pose = mul(pose, shift(*machine["axes"][axis].get("offset_mm", [0, 0, 0])))
        motion = [q[axis] * v for v in unit(axis)]
        if axis in "ABC":
            direction = machine["axes"][axis].get("direction", sign)
            motion = turn([math.radians(direction * v) for v in motion])
        else:
            motion = shift(*(sign * v for v in motion))
        if with_errors:
            e, w = twist(machine, links, place, q)
            error = mul(shift(*(sign * v for v in e)), turn([sign * v for v in w]))
            # The errors of a linear axis act about its moved frame's origin, those of a rotary one before its own turn.
            pose = mul(pose, mul(error, motion) if axis in "ABC" else mul(motion, error))
        else:
            pose = mul(pose, motion)
    return pose


def errors(machine, q):
    """Tip error, mm, and rotation vector of the orientation error, rad, in machine directions."""
    tool = shift(*machine["tool_mm"])
    ideal, actual = (
        mul(inverse(side(machine, q, True, on)), mul(side(machine, q, False, on), tool)) for on in (False, True)
    )
    workpiece = side(machine, q, True, False)
    bed = lambda v: [math.fsum(workpiece[i][k] * v[k] for k in range(3)) for i in range(3)]
    tip = bed([actual[i][3] - ideal[i][3] for i in range(3)])
    rotated = lambda t: [row[:3] + [0] for row in t[:3]] + [[0, 0, 0, 1]]
    r = mul(rotated(actual), inverse(rotated(ideal)))
    half = [(r[2][1] - r[1][2]) / 2, (r[0][2] - r[2][0]) / 2, (r[1][0] - r[0][1]) / 2]
    sine = math.sqrt(math.fsum(v * v for v in half))
    scale = math.asin(sine) / sine if sine else 1.0
    return tip, bed([v * scale for v in half])


def table(rng, low, high, points):
    span = (high - low) / (points - 1)
    size = [12, 8, 8, 25, 25, 25]
    return [[low + span * k] + [round(rng.uniform(-s, s), 3) for s in size] for k in range(points)]


def rotary_table(rng, low, high, points):
    rows = table(rng, low, high, points)
    if high - low == 360:
        rows[-1][1:] = rows[0][1:]
    return rows


def machines():
    rng = random.Random(20)
    three = {
        "name": "three",
        "chain": "w X' Y' b Z t",
        "tool_mm": [3.0, -2.0, -120.0],
        "axes": {
            "X": {"table": table(rng, -300, 300, 7), "measured_at_mm": [0, 50, -150]},
            "Y": {"table": table(rng, -200, 200, 5), "offset_mm": [10, 20, 30]},
            "Z": {"table": table(rng, -400, 0, 5), "measured_at_mm": [20, -30, 0]},
        },
        "location": {"A0Z_urad": 32, "B0Z_urad": -25, "C0Y_urad": 18},
    }
    rotary = lambda axis: {f"E{d}0{axis}_{'um' if d in 'XYZ' else 'urad'}": v for d, v in zip("XYZABC", [5, -4, 3, 12, -9, 7])}
    tables = {
        "name": "tables",
        "chain": "w C' A' Y' b X Z t",
        "tool_mm": [0.0, 0.0, -80.0],
        "axes": {
            "X": {"table": table(rng, -250, 250, 6)},
            "Y": {"table": table(rng, -250, 250, 6), "measured_at_mm": [0, 0, 100]},
            "Z": {"table": table(rng, -100, 400, 6)},
            "A": {"table": rotary_table(rng, -120, 30, 6), "offset_mm": [0, 12, -40]},
            "C": {"table": rotary_table(rng, 0, 360, 9), "offset_mm": [1, -2, 60]},
        },
        "location": {"C0Y_urad": 14, **rotary("A"), **rotary("C")},
    }
    heads = {
        "name": "heads",
        "chain": "w X' b Y Z C A t",
        "tool_mm": [2.0, -3.0, -210.0],
        "axes": {
            "X": {"table": table(rng, -500, 500, 6)},
            "Y": {"table": table(rng, -400, 400, 5)},
            "Z": {"table": table(rng, -600, 100, 8), "measured_at_mm": [0, 0, 0]},
            "A": {"table": rotary_table(rng, -100, 100, 5), "offset_mm": [0, 30, -20]},
            "C": {"table": rotary_table(rng, 0, 360, 7), "direction": -1},
        },
        "location": {"B0Z_urad": 21, **rotary("C")},
    }
    return rng, [three, tables, heads]


def main():
    rng, all_machines = machines()
    document = []
    for machine in all_machines:
        links = [axis for axis in "XYZABC" if axis in machine["axes"]]
        rows = []
        for _ in range(25):
            q = {}
            for axis in links:
                low, high = machine["axes"][axis]["table"][0][0], machine["axes"][axis]["table"][-1][0]
                q[axis] = round(rng.uniform(low, high), 4)
            tip, orientation = errors(machine, q)
            rows.append({
                "at": [q[axis] for axis in links],
                "tip_um": [v * 1e3 for v in tip],
                "orientation_urad": [v * 1e6 for v in orientation],
            })
        document.append({**machine, "positions": rows})
    print(json.dumps(document))


main()
