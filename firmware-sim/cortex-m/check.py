#!/usr/bin/env python3
"""Holds counts of the image against the committed ones: check.py counts.toml m4f=FILE m7=FILE

Fails (exit 1) where a count is above the committed one by more than 0.5 %. A committed count above its limit is shown
as "limit missed" in every run.
"""

import sys
import tomllib

GROWTH = 1.005
SCALAR = {"m4f": "f32", "m7": "f64"}


def counts(target, path):
    """`scalar name worst A mean B calls C sum D` lines as {"name.worst": A, ...} of the target's scalar."""
    found = {}
    for line in open(path, encoding="ascii"):
        words = line.split()
        if words and words[0] == "PANIC":
            sys.exit(f"{path}: {line}")
        if words and words[0] == SCALAR[target]:
            figures = dict(zip(words[2::2], words[3::2]))
            found |= {f"{words[1]}.{figure}": float(value) for figure, value in figures.items()}
    return found


def main():
    budgets = tomllib.load(open(sys.argv[1], "rb"))["budget"]
    failed = False
    print(f"{'thing':26} {'target':6} {'measured':>9} {'committed':>9} {'limit':>7}")
    for argument in sys.argv[2:]:
        target, path = argument.split("=", 1)
        found = counts(target, path)
        for budget in (b for b in budgets if b["target"] == target):
            measured, committed, limit = found.get(budget["thing"]), budget.get("count"), budget.get("limit")
            verdict = ""
            if measured is None:
                verdict, failed = "NOT MEASURED", True
            elif committed is None or measured > committed * GROWTH:
                verdict, failed = "NOT COMMITTED" if committed is None else "GREW", True
            elif limit is not None and measured > limit:
                verdict = "limit missed"
            row = ["-" if x is None else f"{x:g}" if x < 1e6 else f"{x:.0f}" for x in (measured, committed, limit)]
            print(f"{budget['thing']:26} {target:6} {row[0]:>9} {row[1]:>9} {row[2]:>7}  {verdict}".rstrip())
        worst, mean = found.get("slice.worst"), found.get("slice.mean")
        if worst and mean and worst > 1.4 * mean:
            print(f"{target}: the worst slice takes {worst / mean:.2f} of the mean, needed at most 1.4")
            failed = True
    return int(failed)


sys.exit(main())
