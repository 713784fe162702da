#!/usr/bin/env python3
"""Runs steps on three lanes and reports what each one cost.

A lane takes the first step whose requirements have passed; a fourth lane takes steps that mostly wait. Three lanes keep two
cores busy: every step waits now and then, for a browser, a package or the disk. Each step writes a log, which is printed when
the step ends. The first failure ends the run. At the end all steps are listed by processor time and compared with the
committed times: a step that has grown by half fails the run.
"""

import os
import signal
import statistics
import subprocess
import sys
import threading
import time
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

# A step fails when it takes this many times the committed processor time, at the speed of this machine, and at least this
# many seconds more. Smaller differences depend on what else the processor does.
GROWTH, NOISE_S = 1.5, 60.0


@dataclass
class Step:
    """A bash script, the steps that must pass before it (`after`), whether it mostly waits (`waits`), and whether its time
    depends on the change or on what is installed (`varies`)."""

    name: str
    script: str
    after: tuple = ()
    waits: bool = False
    varies: bool = False
    wall: float = 0.0
    processor: float = 0.0
    state: str = "waiting"
    process: object = field(default=None, repr=False)


def show(text):
    print(text, flush=True)


class Run:
    """Lanes over a list of steps."""

    def __init__(self, steps, logs):
        self.steps, self.logs = steps, logs
        self.changed = threading.Condition()
        self.failed = None
        self.started = time.monotonic()
        logs.mkdir(parents=True, exist_ok=True)
        names = {step.name for step in steps}
        for step in steps:
            unknown = set(step.after) - names
            if unknown:
                sys.exit(f"{step.name} needs {sorted(unknown)}, found no such step")

    def next(self, waits):
        """The next step for a lane; nothing when all are taken or one has failed."""
        with self.changed:
            while True:
                left = [step for step in self.steps if step.state == "waiting" and step.waits == waits]
                if self.failed or not left:
                    return None
                passed = {step.name for step in self.steps if step.state == "passed"}
                for step in left:
                    if passed.issuperset(step.after):
                        step.state = "running"
                        return step
                self.changed.wait()

    def lane(self, waits):
        while step := self.next(waits):
            self.take(step)
            with self.changed:
                self.changed.notify_all()

    def take(self, step):
        log = self.logs / (step.name.replace(" ", "-") + ".log")
        show(f"--- {time.strftime('%T')} begins: {step.name}")
        begun = time.monotonic()
        with log.open("wb") as out:
            with self.changed:
                step.process = subprocess.Popen(
                    ["bash", "-euo", "pipefail", "-c", step.script],
                    stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, start_new_session=True,
                )
                if self.failed:
                    self.end(step)
            _, status, usage = os.wait4(step.process.pid, 0)
        step.wall = time.monotonic() - begun
        step.processor = usage.ru_utime + usage.ru_stime
        code = os.waitstatus_to_exitcode(status)
        with self.changed:
            ended = self.failed
            step.state = "passed" if code == 0 else "failed"
            if code != 0 and not ended:
                self.failed = step
                for other in self.steps:
                    if other.state == "running":
                        self.end(other)
        if ended:
            return
        text = log.read_text(errors="replace").rstrip()
        show(f"\n=== {step.name}: {step.wall:.0f} s, {step.processor:.0f} s of processor\n{text}\n=== {step.name}: "
             + ("passed" if code == 0 else f"FAILED with {code}") + "\n")

    def end(self, step):
        """Ends a step with everything that it has started."""
        if step.process is not None:
            try:
                os.killpg(step.process.pid, signal.SIGTERM)
            except ProcessLookupError:
                pass

    def interrupted(self, *_):
        for step in self.steps:
            if step.state == "running":
                self.end(step)
        sys.exit(130)

    def all(self):
        signal.signal(signal.SIGINT, self.interrupted)
        signal.signal(signal.SIGTERM, self.interrupted)
        lanes = [threading.Thread(target=self.lane, args=[waits]) for waits in (False, False, False, True)]
        for lane in lanes:
            lane.start()
        for lane in lanes:
            lane.join()
        return self.failed is None


def grown(steps, committed):
    """What each step takes, dearest first, beside the committed figures; the names of those that have grown."""
    shared = [step for step in steps if committed.get(step.name, 0) >= NOISE_S and not step.varies]
    # The median ratio is how much slower or busier this machine is. A faster machine does not lower the limits.
    speed = max(1.0, statistics.median(step.processor / committed[step.name] for step in shared)) if shared else 1.0
    names = []
    show(f"{'step':<32}{'s':>7}{'processor s':>13}{'committed':>11}")
    for step in sorted(steps, key=lambda step: -step.processor):
        before = committed.get(step.name)
        allowed = None if before is None else max(GROWTH * speed * before, speed * before + NOISE_S)
        mark = ""
        if before is None:
            mark = "  new"
        elif step.processor > allowed and not step.varies:
            mark = f"  GROWN: {allowed:.0f} s allowed"
            names.append(step.name)
        show(f"{step.name:<32}{step.wall:7.0f}{step.processor:13.0f}{'' if before is None else f'{before:.0f}':>11}{mark}")
    show(f"{'all':<32}{'':7}{sum(step.processor for step in steps):13.0f}      {speed:.2f} times the committed processor time")
    return names


def write(path, steps):
    lines = ["# Processor time of each step of .ci/run from nothing, s: `.ci/run --commit` writes it.", ""]
    lines += [f'"{step.name}" = {step.processor:.0f}' for step in sorted(steps, key=lambda step: step.name)]
    path.write_text("\n".join(lines) + "\n")


def run(steps, logs, times, cold, commit):
    """Runs all steps; the exit code. Times are compared only from nothing (`cold`): a warm run builds less."""
    whole = Run(steps, logs)
    passed = whole.all()
    took = time.monotonic() - whole.started
    if not passed:
        show(f"=== FAILED in: {whole.failed.name}, after {took:.0f} s; the log is {logs / whole.failed.name.replace(' ', '-')}.log")
        return 1
    committed = tomllib.loads(times.read_text()) if times.exists() else {}
    names = grown(steps, committed if cold else {})
    if commit:
        write(times, steps)
    elif cold and names:
        show(f"=== FAILED: {', '.join(names)} took half as long again as committed in {times}")
        return 1
    show(f"=== all passed in {took:.0f} s")
    return 0
