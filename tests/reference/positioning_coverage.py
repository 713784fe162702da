#!/usr/bin/env python3
"""Why the bands of ISO 230-2 figures are drawn as they are: how often three plain forms hold the truth.

Needs numpy. 1,000 axes: 21 positions, five runs both ways, scatter 0.5 um, reversal 1.5 um; an instrument with 0.6 um/m and
0.3 um a reading. The truth is the figure of the same runs without the instrument. Intervals of 95 %, from 300 draws:
  again      the central interval of the figure with new errors on top of what was read
  reflected  the same, reflected about the figure as measured
  2 s        the figure as measured +- 1.96 standard deviations of the draws
"""
import numpy as np

rng = np.random.default_rng(1)
M, N = 21, 5
POSITIONS = np.linspace(-300, 300, M)
SCALE, READING, SCATTER = 0.6e-3, 0.3, 0.5
NAMES = ("A", "E", "R", "M", "B", "R_up")


def figures(x):
    """A, E, R, M, B, R_up of deviations [..., position, direction, run]."""
    mean, s = x.mean(-1), x.std(-1, ddof=1)
    up, down, s_up, s_down = mean[..., 0], mean[..., 1], s[..., 0], s[..., 1]
    reversal, middle = up - down, (up + down) / 2
    spread = np.maximum(2 * s_up + 2 * s_down + abs(reversal), np.maximum(4 * s_up, 4 * s_down))
    return np.stack([
        (mean + 2 * s).max((-1, -2)) - (mean - 2 * s).min((-1, -2)), mean.max((-1, -2)) - mean.min((-1, -2)),
        spread.max(-1), middle.max(-1) - middle.min(-1), abs(reversal).max(-1), 4 * s_up.max(-1)], -1)


def errors(count=()):
    return (SCALE * rng.standard_normal(count + (1, 1, 1)) * POSITIONS[:, None, None]
            + READING * rng.standard_normal(count + (M, 2, N)))


held = np.zeros((3, len(NAMES)))
REPEATS = 1000
for _ in range(REPEATS):
    own = 10 * np.sin(POSITIONS / 100) + 0.02 * POSITIONS
    there = own[:, None, None] + np.array([0, -1.5])[None, :, None] + SCATTER * rng.standard_normal((M, 2, N))
    read = there + errors()
    truth, measured, drawn = figures(there), figures(read), figures(read + errors((300,)))
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    held[0] += (low <= truth) & (truth <= high)
    held[1] += (2 * measured - high <= truth) & (truth <= 2 * measured - low)
    held[2] += abs(truth - measured) <= 1.96 * drawn.std(0)
print("%, of 1,000 ", *(f"{name:>6}" for name in NAMES))
for name, row in zip(("again", "reflected", "2 s"), held):
    print(f"{name:12}", *(f"{100 * share / REPEATS:6.1f}" for share in row))
