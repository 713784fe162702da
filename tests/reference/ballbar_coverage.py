#!/usr/bin/env python3
"""Coverage of the bands of a circle's causes where spikes at reversals are of a width that is not known: ways that were tried.

    python3 tests/reference/ballbar_coverage.py

Printed for spikes of several heights and widths: of how many intervals of 95 % the truth is held, for scale mismatch and both
backlashes, and what `docs/uncertainty.md` says of it. Needs numpy; a minute.
"""

import numpy as np

RADIUS, SIGMA, CIRCLES = 100.0, 0.5e-3, 4000
STUDENT = 1.967  # 342 degrees of freedom, 95 %
SHOWN = [3, 5, 6]  # scale mismatch, backlash of X and Y
PRESET, SEEN = 0.15, 5.0

theta = np.radians(np.tile(2 * np.arange(180) + 1, 2))
way = np.repeat([1.0, -1.0], 180)
sin, cos = np.sin(theta), np.cos(theta)


def spikes(width):
    since = [np.mod(way * (theta - at), np.pi) / width for at in (0, np.pi / 2)]
    return np.array([u * np.exp(1 - u) for u in since]).T


def without_spikes():
    columns = [np.ones(360), cos, sin, 0.5 * RADIUS * np.cos(2 * theta), -0.5 * RADIUS * np.sin(2 * theta)]
    columns += [0.5 * way * np.sign(sin) * cos, -0.5 * way * np.sign(cos) * sin, cos * cos * sin, sin * sin * cos]
    columns += [0.5 * way * np.sin(2 * theta), 0.5 * way * abs(sin), -0.5 * way * abs(cos)]
    for along in (cos, sin):
        columns += [along * part(2 * np.pi * RADIUS * along / 10) for part in (np.cos, np.sin)]
    return np.array(columns).T


class Model:
    def __init__(self, matrix):
        self.matrix, self.solve = matrix, np.linalg.pinv(matrix)
        self.diagonal = np.diag(np.linalg.inv(matrix.T @ matrix))[SHOWN]

    def fit(self, readings):
        """Values, variances, sums of squares that are left."""
        values = readings @ self.solve.T
        left = ((readings - values @ self.matrix.T) ** 2).sum(1)
        freedom = len(theta) - self.matrix.shape[1]
        return values[:, SHOWN], left[:, None] / freedom * self.diagonal, left


BARE = without_spikes()
LOW, HIGH = 2 * np.pi * 2 / 360 / 3, 0.26
NONE = Model(BARE)
WIDTHS = [Model(np.hstack([BARE, spikes(w)])) for w in np.geomspace(LOW, HIGH, 24)]
PRESETS = Model(np.hstack([BARE, spikes(PRESET)]))


def count(height, width):
    truth = np.zeros(BARE.shape[1])
    truth[[3, 4, 5]] = 30e-6, 40e-6, 4e-3
    random = np.random.default_rng(1)
    made = BARE @ truth + height * spikes(width).sum(1)
    readings = made + SIGMA * random.standard_normal((CIRCLES, len(theta)))
    values, variances, left = (np.array(part) for part in zip(*(model.fit(readings) for model in WIDTHS)))
    best, circles = left.argmin(0), np.arange(CIRCLES)
    likely = np.exp(-171 * np.log(left / left.min(0)))
    weight = (likely / likely.sum(0))[:, :, None]
    found, known = values[best, circles], variances[best, circles]
    about = (weight * (variances + (values - found) ** 2)).sum(0)
    mean = (weight * values).sum(0)
    about_mean = (weight * (variances + (values - mean) ** 2)).sum(0)
    _, _, bare = NONE.fit(readings)
    f = (bare - left.min(0)) / 2 / (left.min(0) / 342)
    preset, preset_variance, _ = PRESETS.fit(readings)
    hidden = (f <= SEEN)[:, None]
    for name, value, variance in [
        ("best width, as if known", found, known),
        ("best width, variances over all", found, about),
        ("mean over all widths", mean, about_mean),
        ("seen or preset", np.where(hidden, preset, found), np.where(hidden, preset_variance, about)),
    ]:
        off = value - truth[SHOWN]
        held = 100 * (abs(off) <= STUDENT * np.sqrt(variance)).mean(0)
        ratio = np.sqrt(variance.mean(0)) / off.std(0)
        print(f"{1e3 * height:4.2f} µm {width:4.2f} rad  {name:32}", held.round(1), " u/s", ratio.round(2))
    print(f"    F above {SEEN}: {100 * (f > SEEN).mean():.1f} %")


for case in [(0.0, 0.12), (0.15e-3, 0.12), (0.3e-3, 0.12), (0.6e-3, 0.12), (3e-3, 0.12), (0.3e-3, 0.04), (0.45e-3, 0.2)]:
    count(*case)
