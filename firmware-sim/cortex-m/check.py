#!/usr/bin/env python3
"""Compares counts of the image with the committed ones: check.py [--commit] counts.toml m4f=FILE m7=FILE host=FILE

Fails (exit 1) where a count is above the committed one by more than 0.5 %, or where the image's outputs over the
adversarial cycles are not the host's, bit for bit. A committed count above its limit is shown as "limit missed" in every
run. --commit writes the counts measured into the file, limits as they are, and the dearest adversarial cycles into
adversarial.toml beside it.
"""

import json
import re
import sys
import tomllib
from pathlib import Path

GROWTH = 1.005
SCALAR = {"m4f": "f32", "m7": "f64"}
# Least number of adversarial cycles, of 100,000, in which each state must occur.
MET = {"active": 50_000, "frozen": 2_000, "stopped": 1_000, "limited": 10_000, "bracketed": 5_000, "undisturbed": 50_000}
# Lines that are not counts.
NO_COUNTS = ("digests", "dearest", "replay", "dynamic")


def counts(target, path):
    """`scalar name worst A mean B calls C sum D` lines as {"name.worst": A, ...} of the target's scalar."""
    found = {}
    for line in open(path, encoding="ascii"):
        words = line.split()
        if words and words[0] == "PANIC":
            sys.exit(f"{path}: {line}")
        if words and words[0] == SCALAR[target] and words[1] not in NO_COUNTS:
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


def after(path, beginning):
    """The rest of every line with this beginning."""
    lines = open(path, encoding="ascii").read().splitlines()
    return [line.removeprefix(beginning).strip() for line in lines if line.startswith(beginning)]


def commit_dearest(path, files):
    """The dearest adversarial cycles of every target, and a description of the first."""
    text = "# Adversarial cycles that cost most, nine terms, dearest first, with a description of the first. Written by count.sh --commit;\n"
    text += "# `count.sh --replay CYCLE` runs one. benches/check-budgets.sh counts those of the M7 on the host.\n"
    for target, file in files.items():
        scalar = SCALAR[target]
        [cycle, *rest] = after(file, f"{scalar} replay ")
        text += f"\n[{target}]\n"
        text += f"worst = {json.dumps(cycle)}\n"
        for line in rest:
            name, value = re.match(r"(\w+):? (.*)", line).groups()
            text += f"{name} = {json.dumps(value)}\n"
        [dearest] = after(file, f"{scalar} dearest ")
        numbers = dearest.split()
        rows = [", ".join(numbers[k : k + 16]) for k in range(0, len(numbers), 16)]
        text += "dearest = [\n" + "".join(f"    {row},\n" for row in rows) + "]\n"
    path.write_text(text, encoding="utf-8")


def differ(files, host):
    """Whether an image's digests of the adversarial outputs are other than the host's."""
    bad = False
    for target, file in files.items():
        for kind, what, done in (
            ("digests of ", "digests of the adversarial outputs", "adversarial cycles bit for bit as on the host, in all three forms"),
            ("dynamic digest of ", "digest of the dynamic outputs", "cycles with dynamic correction bit for bit as on the host"),
        ):
            image, on_host = (after(text, f"{SCALAR[target]} {kind}") for text in (file, host))
            if image != on_host or not image:
                print(f"{target}: found {what} {image}, needed the host's: {on_host}")
                bad = True
            else:
                print(f"{target}: outputs of {image[0].split()[0]} {done}")
    return bad


def main():
    arguments = sys.argv[1:]
    committing = arguments[:1] == ["--commit"]
    path, *files = arguments[committing:]
    files = dict(argument.split("=", 1) for argument in files)
    host = files.pop("host")
    measured = {target: counts(target, file) for target, file in files.items()}
    if committing:
        commit(path, measured)
        commit_dearest(Path(path).with_name("adversarial.toml"), files)
    budgets = tomllib.load(open(path, "rb"))["budget"]
    failed = differ(files, host)
    print("instructions, not cycles")
    print(f"{'thing':31} {'target':6} {'measured':>9} {'committed':>9} {'limit':>7} {'goal':>6}")
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
            print(f"{budget['thing']:31} {target:6} {row[0]:>9} {row[1]:>9} {row[2]:>7} {row[3]:>6}  {verdict}".rstrip())
        worst, mean = found.get("slice.worst"), found.get("slice.mean")
        if worst and mean and worst > 1.4 * mean:
            print(f"{target}: the worst slice takes {worst / mean:.2f} of the mean, needed at most 1.4")
            failed = True
        # The recording over which the whole step is counted must not become easier unnoticed.
        if found.get("recording.cycles", 0) < 10_000 or found.get("recording.revolutions", 0) < 1:
            print(f"{target}: found {found.get('recording.cycles')} cycles and {found.get('recording.revolutions')} revolutions, "
                  "needed 10000 and a whole one")
            failed = True
        # Nor must the adversarial cycles: every state has to occur often.
        rare = {name: found.get(f"met.{name}", 0) for name in MET if found.get(f"met.{name}", 0) < MET[name]}
        if rare:
            print(f"{target}: found {rare} adversarial cycles, needed at least {MET}")
            failed = True
    return int(failed)


sys.exit(main())
