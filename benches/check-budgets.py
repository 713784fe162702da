#!/usr/bin/env python3
"""Counts instructions under callgrind and holds them against budgets.toml.

check-budgets.py [base|v3 ...]     both targets where none is named

Fails (exit 1) where a count is above the committed one by more than 0.5 %. A committed count above its limit is shown
as "limit missed" in every run.
"""

import json
import os
import pathlib
import subprocess
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
FLAGS = {"base": "", "v3": "-Ctarget-cpu=x86-64-v3"}
GROWTH = 1.005


def instructions(summary):
    """Executed instructions of a benchmark's summary."""
    for profile in summary["profiles"]:
        if profile["tool"] == "Callgrind":
            return profile["data"]["total"]["metrics"]["Ir"]["values"]["new"]
    sys.exit("no callgrind profile in the summary")


def measure(target):
    """Runs the counts built for a target; a count for every thing."""
    environment = dict(os.environ, RUSTFLAGS=FLAGS[target])
    root = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", HERE.parent / "target"))
    if target != "base":
        root = root / target
    environment["CARGO_TARGET_DIR"] = str(root)
    command = ["cargo", "bench", "-q", "-p", "trueaxis-benches", "--features", "counts", "--bench", "counts", "--", "--save-summary=json"]
    done = subprocess.run(command, env=environment, cwd=HERE.parent, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"the counts did not run:\n{done.stdout}")
    counts = {}
    for path in (root / "gungraun").rglob("summary.json"):
        summary = json.loads(path.read_text())
        counts[f"{summary['function_name']}.{summary['id']}"] = instructions(summary)
    return counts


def main():
    targets = [name for name in FLAGS if name in sys.argv] or list(FLAGS)
    budgets = tomllib.loads((HERE / "budgets.toml").read_text())["budget"]
    failed = False
    print(f"{'thing':34} {'target':6} {'measured':>8} {'committed':>9} {'limit':>6} {'goal':>6}")
    for target in targets:
        counts = measure(target)
        for budget in (b for b in budgets if b["target"] == target):
            measured = counts.get(budget["thing"])
            if measured is not None:
                measured = measured // budget.get("calls", 1) - counts.get(budget.get("frame"), 0)
            committed, limit, goal = (budget.get(k) for k in ("count", "limit", "goal"))
            verdict = []
            if measured is None:
                verdict.append("NOT MEASURED")
                failed = True
            else:
                if committed is None or measured > committed * GROWTH:
                    verdict.append("NOT COMMITTED" if committed is None else "GREW")
                    failed = True
                if limit is not None and measured > limit:
                    verdict.append("limit missed")
                elif goal is not None and measured <= goal:
                    verdict.append("goal reached")
            row = [str(x) if x is not None else "-" for x in (measured, committed, limit, goal)]
            print(f"{budget['thing']:34} {target:6} {row[0]:>8} {row[1]:>9} {row[2]:>6} {row[3]:>6}  {' '.join(verdict)}")
    return int(failed)


sys.exit(main())
