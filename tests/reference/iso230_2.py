#!/usr/bin/env python3
"""ISO 230-2:2014 evaluation of a measurement CSV, independent of the Rust code: plain Python, exact sums.

Usage: iso230_2.py MEASUREMENT.csv > RESULT.json
iso230_2.json beside it was made from compensation-tables/mill-3axis/x-iso230-2.csv.
Means and variances come from the `statistics` module, which sums exactly in rationals.
"""

import json
import statistics
import sys
from collections import defaultdict


def read(path):
    groups = defaultdict(list)
    with open(path, encoding="utf-8") as file:
        lines = [line.strip() for line in file if line.strip() and not line.startswith("#")]
    for line in lines[1:]:
        position, _run, direction, deviation = line.split(",")
        groups[direction, float(position)].append(float(deviation))
    return groups


def evaluate(groups):
    positions = sorted({position for _, position in groups})
    mean = {key: statistics.fmean(values) for key, values in groups.items()}
    s = {key: statistics.stdev(values) for key, values in groups.items()}
    at = []
    for p in positions:
        up, down = ("+", p), ("-", p)
        reversal = mean[up] - mean[down]
        at.append({
            "position": p, "mean_up": mean[up], "mean_down": mean[down], "s_up": s[up], "s_down": s[down],
            "mean": (mean[up] + mean[down]) / 2, "B": reversal,
            "R": max(2 * s[up] + 2 * s[down] + abs(reversal), 4 * s[up], 4 * s[down]),
        })
    axis = {
        "B": max(abs(a["B"]) for a in at),
        "B_mean": statistics.fmean(a["B"] for a in at),
        "M": max(a["mean"] for a in at) - min(a["mean"] for a in at),
        "R": max(a["R"] for a in at),
    }
    for name, signs in (("_up", "+"), ("_down", "-"), ("", "+-")):
        keys = [key for key in groups if key[0] in signs]
        axis["E" + name] = max(mean[k] for k in keys) - min(mean[k] for k in keys)
        axis["A" + name] = max(mean[k] + 2 * s[k] for k in keys) - min(mean[k] - 2 * s[k] for k in keys)
        if name:
            axis["R" + name] = 4 * max(s[k] for k in keys)
    return {"axis": axis, "positions": at}


if __name__ == "__main__":
    json.dump(evaluate(read(sys.argv[1])), sys.stdout, indent=1)
    print()
