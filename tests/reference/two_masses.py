#!/usr/bin/env python3
"""Following a ramp with motor and load: values for crates/trueaxis-metrology/src/friction/resonance/plant.rs.

Positions and velocities of both masses, the velocity loop's integrator and the current loop as one linear system, solved
exactly (exponential of its matrix, 30 digits) for a command that is linear between its samples. No friction but viscous.

    (1 - s) x_M'' = F - p,   s x_L'' = p - d x_L',   p = k (x_M - x_L) + c (x_M' - x_L')
    k = s (1 - s) w^2,   c = 2 s (1 - s) z w

It also prints the poles of the closed loops about the resonance, as frequency and damping: what a decaying sinusoid fitted to the
ringing would find, instead of the 120 Hz and 3 % of the mechanics. Needs mpmath.
"""

from mpmath import mp, matrix, expm, mpf, pi, eig

mp.dps = 30
KV, KVP, TAU, FF, TC, D = map(mpf, ("60", "350", "0.012", "0.7", "0.00025", "3.5"))
W, Z, S = 2 * pi * 120, mpf("0.03"), mpf("0.4")
PERIOD, SPEED = mpf("0.001"), mpf("25")


def system(scale):
    """States x_M, v_M, x_L, v_L, q, F, then command and its rate."""
    k, c = S * (1 - S) * W**2, 2 * S * (1 - S) * Z * W
    a = matrix(8)
    spring = {0: k, 2: -k, 1: c, 3: -c}
    a[0, 1] = a[2, 3] = a[6, 7] = 1
    for column, value in spring.items():
        a[1, column] -= value / (1 - S)
        a[3, column] += value / S
    a[1, 5] = 1 / (1 - S)
    a[3, 3] -= D / S
    error = {6: KV, 7: FF, (2 if scale else 0): -KV}
    for row, factor in ((4, 1 / TAU), (5, KVP / TC)):
        for column, value in error.items():
            a[row, column] += factor * value
        a[row, 1] -= factor
    a[5, 4] += KVP / TC
    a[5, 5] -= 1 / TC
    return a


for scale in (False, True):
    a = system(scale)
    next_state = expm(a * PERIOD)
    state, out = matrix(8, 1), []
    for k in range(60):
        # At rest for two samples, 20 at 25 mm/s, then at rest again.
        state[7] = SPEED if 2 <= k < 22 else 0
        state = next_state * state
        out.append(state[2] if scale else state[0])
    print("scale" if scale else "motor", [mp.nstr(out[k - 1], 15) for k in (4, 8, 21, 26, 31, 60)])
    poles = [p for p in eig(a[:6, :6])[0] if p.imag > 300]
    print([f"{mp.nstr(abs(p) / (2 * pi), 6)} Hz, {mp.nstr(-100 * p.real / abs(p), 4)} %" for p in poles])
