#!/usr/bin/env python3
"""Counts instructions under callgrind and compares them with budgets.toml.

check-budgets.py [--commit | --build] [base|v3 ...]     both targets where none is named

Fails (exit 1) where a count is above the committed one by more than 0.5 %. A committed count above its limit is shown
as "limit missed" in every run. --commit writes the counts measured into the file, limits as they are. --build builds the
counted programs and counts nothing.
"""

import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
# What compiles the workspace's crates for a target: those of others are built once, for all of them.
WRAPPER = {"base": None, "v3": HERE / "rustc-v3"}
COUNTS = ["--profile", "counted", "-p", "trueaxis-benches", "--features", "counts", "--bench", "counts"]
GROWTH = 1.005
# Whole steps along the butterfly: geometry alone; with friction, with feedback, with all of the dynamic correction; with a
# grid over two axes, over three.
WALKS = ["walk", "walk-friction", "walk-feedback", "walk-dynamic", "walk-bilinear", "walk-trilinear"]
# The adversarial cycles that cost most on a Cortex-M7, which computes in the host's scalar.
ADVERSARIAL = HERE.parent / "firmware-sim/cortex-m/adversarial.toml"


def instructions(summary):
    """Executed instructions of a benchmark's summary."""
    for profile in summary["profiles"]:
        if profile["tool"] == "Callgrind":
            return profile["data"]["total"]["metrics"]["Ir"]["values"]["new"]
    sys.exit("no callgrind profile in the summary")


def build(target):
    """Builds the counts for a target; the environment and the folder that they run in."""
    environment = dict(os.environ, RUSTFLAGS="", GUNGRAUN_HOME=str(TARGET / "gungraun" / target))
    root = TARGET
    if WRAPPER[target]:
        # Only programs: all else is in the folder for building, which the targets share.
        root = TARGET / target
        environment |= {"CARGO_TARGET_DIR": str(root), "CARGO_BUILD_BUILD_DIR": str(TARGET), "RUSTC_WORKSPACE_WRAPPER": str(WRAPPER[target])}
    subprocess.run(["cargo", "build", "-q", *COUNTS, "--bin", "counted"], env=environment, cwd=ROOT, check=True)
    return environment, root


def measure(target):
    """Builds the counts for a target and runs them; a count for every part."""
    environment, root = build(target)
    command = ["cargo", "bench", "-q", *COUNTS, "--", "--save-summary=json"]
    done = subprocess.run(command, env=environment, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"the counts did not run:\n{done.stdout}")
    counts = {}
    for path in (TARGET / "gungraun" / target).rglob("summary.json"):
        summary = json.loads(path.read_text())
        counts[f"{summary['function_name']}.{summary['id']}"] = instructions(summary)
    return counts | steps(root / "counted/counted")


def steps(program):
    """Counts of whole steps, each cycle alone: all along the butterfly, and the dearest adversarial ones."""
    walks = {name: each(program, "counted_walk", name) for name in WALKS}
    dearest = tomllib.loads(ADVERSARIAL.read_text())["m7"]["dearest"]
    hard = each(program, "counted_adversarial", "adversarial", *map(str, dearest))
    counts = {"adversarial.worst": max(hard)}
    for name, walk in walks.items():
        counts |= {
            f"{name}.typical": int(statistics.median(walk)),
            f"{name}.mean": int(statistics.mean(walk)),
            f"{name}.worst": max(walk),
        }
    return counts


def each(program, function, *arguments):
    """Instructions of every call of a function."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        # Two different patterns: callgrind accepts a name for one option only.
        options = [f"--toggle-collect=counted::{function}*", f"--dump-after=*{function}*", "--combine-dumps=yes"]
        command = ["valgrind", "--tool=callgrind", *options, f"--callgrind-out-file={out}", program, *arguments]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{function} did not run:\n{done.stderr}")
        totals = [int(line.split()[1]) for line in out.read_text().splitlines() if line.startswith("totals:")]
    # The last dump is empty.
    counts = [count for count in totals if count]
    if len(counts) < 100:
        sys.exit(f"{function}: found {len(counts)} calls, needed each of them counted alone")
    return counts


def commit(path, target, counts):
    """Rewrites the `count` lines of a target."""
    head, *blocks = path.read_text().split("[[budget]]")

    def rewritten(block):
        thing, of = (re.search(rf'^{key} = "(.*)"$', block, re.M) for key in ("thing", "target"))
        budget = tomllib.loads(block)
        if of[1] != target or thing[1] not in counts:
            return block
        count = counts[thing[1]] // budget.get("calls", 1) - counts.get(budget.get("frame"), 0)
        block = re.sub(r"^count = .*\n", "", block, flags=re.M)
        return block.replace(of[0], f"{of[0]}\ncount = {count}", 1)

    path.write_text("[[budget]]".join([head, *map(rewritten, blocks)]))


def main():
    targets = [name for name in WRAPPER if name in sys.argv] or list(WRAPPER)
    if "--build" in sys.argv:
        for target in targets:
            build(target)
        return 0
    # Side by side: while one runs under callgrind, on one core, the other is built.
    with ThreadPoolExecutor() as both:
        counts_of = dict(zip(targets, both.map(measure, targets)))
    path = HERE / "budgets.toml"
    if "--commit" in sys.argv:
        for target, counts in counts_of.items():
            commit(path, target, counts)
    budgets = tomllib.loads(path.read_text())["budget"]
    failed = False
    print(f"{'thing':34} {'target':6} {'measured':>8} {'committed':>9} {'limit':>6} {'goal':>6}")
    for target in targets:
        counts = counts_of[target]
        for budget in (b for b in budgets if b["target"] == target):
            measured = counts.get(budget["thing"])
            frame = counts.get(budget.get("frame"), 0)
            if measured is not None:
                measured = measured // budget.get("calls", 1) - frame
            committed, limit, goal = (budget.get(k) for k in ("count", "limit", "goal"))
            verdict = []
            if measured is None:
                verdict.append("NOT MEASURED")
                failed = True
            else:
                # A difference to a frame may grow by a share of the whole, as counts repeat to a share of the whole.
                if committed is None or measured > committed + (GROWTH - 1) * (committed + frame):
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
