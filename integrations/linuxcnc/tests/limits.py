"""Checks the limits of every recorded correction, whatever was requested: magnitude, slope, acceleration, in every sample."""
from rig import expect

PERIOD_S = 1e-3
# Tolerance as a share of a limit: differences of doubles of several hundred millimetres.
ROUNDING = 1e-6
NOISE = 2e-13


def kept(corrections, magnitude, slope, acceleration, what):
    """Returns the largest share of each limit that a column of corrections uses; 1 is the limit."""
    a = acceleration * PERIOD_S * PERIOD_S
    used = [0.0, 0.0, 0.0]
    before, velocity = corrections[0], 0.0
    for n, c in enumerate(corrections):
        v = c - before
        shares = (abs(c) / magnitude, abs(v) / (slope * PERIOD_S), abs(v - velocity) / a)
        noise = (NOISE / magnitude, 2 * NOISE / (slope * PERIOD_S), 4 * NOISE / a)
        for k in range(3):
            expect(shares[k] <= 1.0 + ROUNDING + noise[k], "%s: %s exceeded in sample %d: %g of the limit"
                   % (what, ("magnitude", "slope", "acceleration")[k], n, shares[k]))
            used[k] = max(used[k], shares[k])
        before, velocity = c, v
    return used


def all_kept(recording, joints, limits):
    """Checks the corrections of all joints: position sent minus position commanded by motion."""
    most = [0.0, 0.0, 0.0]
    for j in range(joints):
        sent = recording.columns("joint.%d.motor-pos-cmd" % j, "ta.joint.%d.motor-pos-cmd-out" % j)
        used = kept([out - cmd for cmd, out in sent], *limits[j], "joint %d" % j)
        most = [max(pair) for pair in zip(most, used)]
    return most
