#!/usr/bin/env python3
"""Margins of the contour feedback at resonances, from the equations of motion: writes resonances.json beside this file.

Plain Python, no packages. Independent of the crate: no transfer function is multiplied out; the motor and the load are
solved for each frequency as complex numbers, whether a drive is stable by itself is counted from the angle that its
characteristic determinant turns along the imaginary axis (Cremer, Leonhard, Mikhailov), and peaks come from 500
frequencies and then by golden section. Units: 1/s, s, Hz; margins in dB.

    motor     (1 - m) s^2 x_M = F - (c s + k) (x_M - x_L)          k = m (1 - m) w_r^2,  c = 2 m (1 - m) z w_r
    load           m  s^2 x_L = (c s + k) (x_M - x_L) - h x_L       h: friction that holds the load
    drive     F (1 + s t_c) = K_vp (1 + 1/(tau s)) (K_v (r - y) + k_ff s r - s x_M),  y = x_L (scale) or x_M (encoder)
    feedback  |L| = |K_p + K_i/s| |F_notch| |y/r|, the notch as it is at four times its frequency
"""

import cmath
import json
import math
import random
from pathlib import Path

HERE = Path(__file__).resolve().parent
GAINS = [(1, 1), (1.1, 1.1), (0.9, 0.9), (1.1, 0.9), (0.9, 1.1)]
POINTS = 500


def reading(drive, plant, s, feed_forward):
    """y for r = 1."""
    m, w, z = plant["share"], plant["omega"], plant["damping"]
    spring = 2 * m * (1 - m) * z * w * s + m * (1 - m) * w * w
    load = spring / (m * s * s + spring + plant["held"])
    force = (1 - m) * s * s + spring * (1 - load)
    y = load if plant["scale"] else 1
    loop = drive["velocity_gain_per_s"] * (1 + 1 / (drive["reset_time_s"] * s)) / (1 + s * drive["current_loop_s"])
    motor = loop * (drive["position_gain_per_s"] + feed_forward * s)
    return y * motor / (force + loop * (drive["position_gain_per_s"] * y + s))


def determinant(drive, plant, s):
    """Of the unknowns x_M, x_L, F, made a polynomial of degree 6 by tau s and 1 + s t_c."""
    m, w, z = plant["share"], plant["omega"], plant["damping"]
    spring = 2 * m * (1 - m) * z * w * s + m * (1 - m) * w * w
    motor, load = (1 - m) * s * s + spring, m * s * s + spring + plant["held"]
    tau, kv = drive["reset_time_s"], drive["position_gain_per_s"]
    free = tau * s * (1 + s * drive["current_loop_s"])
    control = drive["velocity_gain_per_s"] * (tau * s + 1)
    back = control * s * load + control * kv * (spring if plant["scale"] else load)
    return free * (motor * load - spring * spring) + back


def is_stable(drive, plant):
    """The angle of a polynomial of degree 6 with all roots on the left turns by three half turns from 0 to infinity."""
    grid = [10 ** (0.5 + 5 * i / 6_000) for i in range(6_001)]
    values = [determinant(drive, plant, 1j * w) for w in grid]
    turned = sum(cmath.phase(b / a) for a, b in zip(values, values[1:]))
    return abs(turned + cmath.phase(values[0]) - 3 * math.pi) < 0.5


def peak(gain, low, high):
    """The largest value between two frequencies."""
    ratio = (high / low) ** (1 / POINTS)
    best = max(range(POINTS + 1), key=lambda i: gain(low * ratio**i))
    a, b = low * ratio ** (best - 1), low * ratio ** (best + 1)
    a, b = max(a, low), min(b, high * ratio)
    for _ in range(40):
        left, right = a + 0.381966 * (b - a), b - 0.381966 * (b - a)
        a, b = (left, b) if gain(left) < gain(right) else (a, right)
    return max(gain((a + b) / 2), gain(low))


def largest(drive, feedback, held, resonances, damping, only_sound, notch, period):
    """The largest |L| over the family."""
    worst = 0
    for hz in resonances:
        for share in (0.2, 0.5, 0.8):
            forms = [(0, True, GAINS)] + ([(held, True, GAINS)] if held else []) + [(0, False, [(1.1, 1.1)])]
            for stiffness, scale, gains in forms:
                for kv, kvp in gains:
                    plant = {"omega": math.tau * hz, "damping": damping, "share": share, "held": stiffness, "scale": scale}
                    own = dict(drive)
                    own["position_gain_per_s"] *= kv
                    own["velocity_gain_per_s"] *= kvp
                    low, high = 0.5 * plant["omega"] * math.sqrt(1 - share), 4 * plant["omega"]
                    if not is_stable(own, plant):
                        if only_sound:
                            continue
                        return math.inf
                    if only_sound and peak(lambda w: abs(reading(own, plant, 1j * w, 0)), low, high) > 2:
                        continue
                    controlled = lambda w: abs(feedback["proportional"] + feedback["integral_per_s"] / (1j * w))
                    filtered = lambda w: abs(filter_at(notch, w, period)) if notch else 1
                    forward = drive["velocity_feed_forward"]
                    loop = lambda w: controlled(w) * filtered(w) * abs(reading(own, plant, 1j * w, forward))
                    worst = max(worst, peak(loop, low, high))
    return worst


def filter_at(hz, w, period):
    """A notch of damping 1 and bottom 0.2 in z = e^(j w T), s = w_n/tan(w_n T/2) (z - 1)/(z + 1)."""
    if w * period >= math.pi:
        return 1
    z, own = cmath.exp(1j * w * period), math.tau * hz
    s = own / math.tan(own * period / 2) * (z - 1) / (z + 1)
    return (s * s + 2 * 0.2 * own * s + own * own) / (s * s + 2 * own * s + own * own)


def main():
    draw = random.Random(38)
    cases = []
    while len(cases) < 16:
        kv = draw.uniform(25, 80)
        kvp = kv * draw.uniform(5, 9)
        drive = {
            "position_gain_per_s": kv,
            "velocity_gain_per_s": kvp,
            "reset_time_s": draw.uniform(4, 10) / kvp,
            "velocity_feed_forward": draw.choice([0, draw.random(), 0.93]),
            "current_loop_s": draw.uniform(0.05, 0.2) / kvp,
            "dead_time_s": draw.uniform(0, 0.002),
        }
        feedback = {"proportional": 0.3, "integral_per_s": draw.uniform(0, 30)}
        coulomb = draw.choice([0, draw.uniform(0.2, 0.8)])
        # k = F_c (1 + s)/z with F_c = K_vp F_c/K_vp and s = 0, z = 0.006 mm.
        held = kvp * coulomb / 0.006
        period = draw.choice([0.0001, 0.001])
        known = len(cases) % 2 == 0
        hz, damping = (draw.uniform(60, 300), draw.uniform(0.01, 0.1)) if known else (draw.uniform(60, 300), 0.02)
        if known:
            around, only_sound = [hz, 0.9 * hz, 1.1 * hz], False
        else:
            around, only_sound = [hz * 1.25**i for i in range(12)], True
        bare = largest(drive, feedback, held, around, damping, only_sound, None, period)
        # A notch is narrowest at the slowest servo that has it: four times its frequency.
        notched = largest(drive, feedback, held, around, damping, only_sound, hz, 1 / (4 * hz)) if known else None
        cases.append({
            "drive": drive, "feedback": feedback, "coulomb_per_s": coulomb, "period_s": period, "known": known,
            "resonance_hz": hz, "resonance_damping": damping,
            "gain": None if bare == math.inf else bare,
            "notched_gain": None if notched in (None, math.inf) else notched,
        })
    text = json.dumps(cases, indent=1) + "\n"
    (HERE / "resonances.json").write_text(text, encoding="utf-8", newline="\n")


main()
