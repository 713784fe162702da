#!/usr/bin/env python3
"""Margins of the contour feedback, from the block diagram: writes margins.json beside this file.

Plain Python, no packages. Independent of the crate: no polynomials but the blocks themselves, solved for each frequency as
complex numbers (velocity loop inside position loop); a phase that is followed from frequency to frequency in place of
sectors of the plane; crossings from 200,000 frequencies and then by bisection. Units: 1/s, s; margins in degrees and dB.

    current loop       a = f/(1 + s t_c)
    velocity loop      f = K_vp (1 + 1/(tau s)) (v_ref - v)
    mass, spring       s v = a - k x,   v = s x
    position loop      v_ref = K_v (u - x) + k_ff s u
    contour feedback   L = (K_p + K_i/s) e^(-s t_d) x/u
"""

import cmath
import json
import math
import random
from pathlib import Path

HERE = Path(__file__).resolve().parent
COUNT = 20_000


def answer(drive, spring, s):
    """x for u = 1: one linear equation, a (1 + s t_c) = K_vp (1 + 1/(tau s)) (v_ref - s x) with a = (s^2 + k) x."""
    loop = drive["velocity_gain_per_s"] * (1 + 1 / (drive["reset_time_s"] * s)) / (1 + s * drive["current_loop_s"])
    reference = drive["position_gain_per_s"] + drive["velocity_feed_forward"] * s
    return loop * reference / (s * s + spring + loop * (drive["position_gain_per_s"] + s))


def gains_alone(drive, s):
    lag = 1 / drive["velocity_gain_per_s"] + drive["current_loop_s"]
    gain = drive["position_gain_per_s"]
    return gain / (s + gain) / (1 + s * lag)


def root(low, high, holds):
    """First frequency of an interval where a condition holds that does not at its low end."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def margins(loop):
    """Least phase margin, gain margin where the lag first is 180 degrees, and the factor by which the gain may grow until
    60 degrees or 12 dB are left; of a loop whose gain falls with the frequency from the first lag of 120 degrees on."""
    at = lambda w: loop(1j * w)
    grid = [10 ** (-3 + 10 * i / COUNT) for i in range(COUNT + 1)]
    values = [at(w) for w in grid]
    phases = [cmath.phase(values[0])]
    for before, value in zip(values, values[1:]):
        phases.append(phases[-1] + cmath.phase(value / before))
    follow = lambda i, w: phases[i] + cmath.phase(at(w) / values[i])
    phase = math.inf
    found = {}
    for i, (low, high) in enumerate(zip(grid, grid[1:])):
        above = abs(values[i]) >= 1
        if above != (abs(values[i + 1]) >= 1):
            w = root(low, high, lambda w: (abs(at(w)) >= 1) != above)
            phase = min(phase, 180 + math.degrees(follow(i, w)))
        for lag in (120, 180):
            if lag not in found and phases[i + 1] <= -math.radians(lag):
                w = root(low, high, lambda w: follow(i, w) <= -math.radians(lag))
                found[lag] = (w, abs(at(w)))
                rest = [abs(value) for value, other in zip(values, grid) if other > w]
                assert all(b <= a * (1 + 1e-12) for a, b in zip(rest, rest[1:])), "the gain rises again"
    factor = min([1 / found[120][1] if 120 in found else math.inf, 10 ** (-12 / 20) / found[180][1] if 180 in found else math.inf])
    gain = -20 * math.log10(found[180][1]) if 180 in found else math.inf
    return phase, gain, factor


def case(drive, friction, feedback, delay):
    spring = 0.0
    if friction:
        force = drive["velocity_gain_per_s"] * friction["coulomb_per_s"] * (1 + friction["stribeck_share"])
        spring = force / friction["presliding"]
    control = lambda s: (feedback["proportional"] + feedback["integral_per_s"] / s) * cmath.exp(
        -s * (drive["dead_time_s"] + delay))
    forms = [lambda s: gains_alone(drive, s), lambda s: answer(drive, 0.0, s)]
    if friction:
        forms.append(lambda s: answer(drive, spring, s))
    all_forms = [margins(lambda s, form=form: control(s) * form(s)) for form in forms]
    phase, gain, factor = (min(column) for column in zip(*all_forms))
    plain = lambda value: None if math.isinf(value) else float(f"{value:.9g}")
    return {"drive": drive, "friction": friction, "feedback": feedback, "delay_s": delay,
            "phase_deg": plain(phase), "gain_db": plain(gain), "factor": plain(factor)}


def main():
    generator = random.Random(20260715)
    cases = []
    for number in range(40):
        pick = lambda low, high: float(f"{low * (high / low) ** generator.random():.4g}")
        drive = {
            "position_gain_per_s": pick(20, 300), "velocity_gain_per_s": pick(400, 3000), "reset_time_s": pick(0.003, 0.1),
            "velocity_feed_forward": [0.0, 0.5, 0.93, 1.0][number % 4], "current_loop_s": pick(5e-5, 5e-4),
            "dead_time_s": 0.0 if number % 3 == 0 else pick(1e-4, 3e-3)}
        friction = None if number % 5 == 0 else {
            "coulomb_per_s": pick(0.1, 2), "stribeck_share": 0.3, "presliding": pick(0.001, 0.05)}
        feedback = {"proportional": 0.0 if number % 7 == 0 else pick(0.05, 2), "integral_per_s": pick(1, 60)}
        try:
            cases.append(case(drive, friction, feedback, 1.5 * [1e-4, 1e-3][number % 2]))
        except AssertionError:
            pass  # A resonance: no case for these definitions.
    (HERE / "margins.json").write_text(json.dumps(cases, indent=1) + "\n", encoding="utf-8")
    print(len(cases), "cases")


if __name__ == "__main__":
    main()
