#!/usr/bin/env python3
"""Holds counts of the image against the committed ones: check.py [--commit] counts.toml m4f=FILE m7=FILE

Fails (exit 1) where a count is above the committed one by more than 0.5 %. A committed count above its limit is shown
as "limit missed" in every run. --commit writes the counts measured into the file, limits as they are.
"""

import re
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


def commit(path, measured):
    """Rewrites the `count` line of every budget."""
    text = open(path, encoding="utf-8").read()

    def rewritten(block):
        thing, target = (re.search(rf'^{key} = "(.*)"$', block, re.M) for key in ("thing", "target"))
        if not (thing and target):
            return block
        count = measured[target[1]].get(thing[1])
        if count is None:
            sys.exit(f"{path}: {thing[1]} is not measured on {target[1]}")
        block = re.sub(r"^count = .*\n", "", block, flags=re.M)
        return block.replace(target[0], f"{target[0]}\ncount = {count:g}" if count < 1e6 else f"{target[0]}\ncount = {count:.0f}", 1)

    head, *blocks = text.split("[[budget]]")
    open(path, "w", encoding="utf-8").write("[[budget]]".join([head, *map(rewritten, blocks)]))


def main():
    arguments = sys.argv[1:]
    committing = arguments[:1] == ["--commit"]
    path, *files = arguments[committing:]
    measured = {target: counts(target, file) for target, file in (argument.split("=", 1) for argument in files)}
    if committing:
        commit(path, measured)
    budgets = tomllib.load(open(path, "rb"))["budget"]
    failed = False
    print("instructions, not cycles")
    print(f"{'thing':28} {'target':6} {'measured':>9} {'committed':>9} {'limit':>7} {'goal':>6}")
    for target, found in measured.items():
        for budget in (b for b in budgets if b["target"] == target):
            count, committed, limit = found.get(budget["thing"]), budget.get("count"), budget.get("limit")
            verdict = ""
            if count is None:
                verdict, failed = "NOT MEASURED", True
            elif committed is None or count > committed * GROWTH:
                verdict, failed = "NOT COMMITTED" if committed is None else "GREW", True
            elif limit is not None and count > limit:
                verdict = "limit missed"
            row = (count, committed, limit, budget.get("goal"))
            row = ["-" if x is None else f"{x:g}" if x < 1e6 else f"{x:.0f}" for x in row]
            print(f"{budget['thing']:28} {target:6} {row[0]:>9} {row[1]:>9} {row[2]:>7} {row[3]:>6}  {verdict}".rstrip())
        worst, mean = found.get("slice.worst"), found.get("slice.mean")
        if worst and mean and worst > 1.4 * mean:
            print(f"{target}: the worst slice takes {worst / mean:.2f} of the mean, needed at most 1.4")
            failed = True
        # The recording over which the whole step is counted must not become easier unnoticed.
        if found.get("recording.cycles", 0) < 10_000 or found.get("recording.revolutions", 0) < 1:
            print(f"{target}: found {found.get('recording.cycles')} cycles and {found.get('recording.revolutions')} revolutions, "
                  "needed 10000 and a whole one")
            failed = True
    return int(failed)


sys.exit(main())
