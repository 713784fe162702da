#!/usr/bin/env python3
"""Servo rates that the committed counts allow: schedule.py counts.toml [--check PAGE | --write PAGE]

    load = rate · (worst + overhead) · cycles per instruction / clock

Prints the table; --check fails (exit 1) where the page does not hold it between its markers, --write puts it there.
"""

import sys
import tomllib

# Core, clock, bound of the mean cycles an instruction.
CORES = [("m4f", "Cortex-M4F, f32", 168e6, 2.0), ("m7", "Cortex-M7, f64", 480e6, 2.0)]
# Entry and exit of the interrupt, hand-over of tables, the record into its queue: instructions.
OVERHEAD = 400
CONFIGURATIONS = [("three axes", "step"), ("three axes, gauge of 1024 points", "step_gauge")]
RATES = [1_000, 2_000, 4_000, 10_000, 20_000]
# Of the period: the rest is the host's own.
SHARE = 0.5
BEGIN, END = "<!-- schedule -->\n", "<!-- /schedule -->\n"


def table(budgets):
    counts = {(b["target"], b["thing"]): b["count"] for b in budgets}
    rates = "".join(f" {rate / 1000:g} kHz |" for rate in RATES)
    lines = [f"| core | configuration | typical | worst | time, worst |{rates} highest rate |", "|---" * (6 + len(RATES)) + "|"]
    for target, core, clock, per_instruction in CORES:
        for name, thing in CONFIGURATIONS:
            typical, worst = (counts[target, f"{thing}.{figure}"] for figure in ("typical", "worst"))
            seconds = (worst + OVERHEAD) * per_instruction / clock
            loads = "".join(f" {100 * seconds * rate:.0f} % |" if seconds * rate <= SHARE else " – |" for rate in RATES)
            lines.append(
                f"| {core}, {clock / 1e6:.0f} MHz | {name} | {typical:.0f} | {worst:.0f} | {1e6 * seconds:.1f} µs |{loads}"
                f" {SHARE / seconds / 1000:.1f} kHz |"
            )
    return "\n".join(lines) + "\n"


def main():
    text = table(tomllib.load(open(sys.argv[1], "rb"))["budget"])
    print(text, end="")
    if len(sys.argv) < 4:
        return
    mode, path = sys.argv[2:4]
    page = open(path, encoding="utf-8").read()
    before, rest = page.split(BEGIN)
    held, after = rest.split(END)
    if mode == "--write":
        open(path, "w", encoding="utf-8").write(before + BEGIN + text + END + after)
    elif held != text:
        sys.exit(f"{path}: found another table than the committed counts give, needed {sys.argv[0]} {sys.argv[1]} --write {path}")


main()
