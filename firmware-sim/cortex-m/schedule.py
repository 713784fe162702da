#!/usr/bin/env python3
"""Tables made from the committed counts: schedule.py counts.toml --check PAGE... | --write PAGE...

Between the markers `schedule` of a page stand the servo rates that the counts allow,

    load = rate · (margin · worst + overhead) · cycles per instruction / clock

between the markers `counts` the counts themselves, between the markers `stack` the bounds of proofs/budgets.toml. --check fails (exit 1) where a page holds another table, --write puts
them there.
"""

import sys
import tomllib
from glob import glob
from os.path import dirname

# Core, clock, bound of the mean cycles an instruction.
CORES = [("m4f", "Cortex-M4F, f32", 168e6, 2.0), ("m7", "Cortex-M7, f64", 480e6, 2.0)]
# Entry and exit of the interrupt, hand-over of tables, the record into its queue: instructions.
OVERHEAD = 400
# Over the worst cycle of the recording.
MARGIN = 1.1
CONFIGURATIONS = [
    ("three axes, nine terms", "step"),
    ("three axes, nine terms, gauge of 1024 points", "step_gauge"),
    ("three axes, volumetric, cubic tables", "step_volumetric"),
]
RATES = [1_000, 2_000, 4_000, 10_000, 20_000]
# Of the period: the rest is the host's own.
SHARE = 0.5
# Rows of the counts table.
SHOWN = [
    ("whole step, three axes: typical; worst", "step.typical", "step.worst"),
    ("with a gauge of 1024 points: typical; worst", "step_gauge.typical", "step_gauge.worst"),
    ("three axes, volumetric, cubic tables: typical; worst", "step_volumetric.typical", "step_volumetric.worst"),
    ("plausibility of commands and readings", "stage_sample.mean"),
    ("tables, inverse, estimated tip", "stage_compensation.mean"),
    ("contour error of tip and encoder position: mean; worst", "stage_contour.mean", "stage_contour.worst"),
    ("limiter and output: mean; worst", "stage_output.mean", "stage_output.worst"),
    ("telemetry record", "stage_telemetry.worst"),
    ("nine-term look-up, equidistant linear tables", "nine_terms.worst"),
    ("volumetric errors, three axes; five", "volumetric_3.worst", "volumetric_5.worst"),
    ("kernel of the contour search, rational cubic; polynomial", "kernel_rational.worst", "kernel_polynomial.worst"),
    ("limiter, three axes, nothing binding; all", "limiter_free.worst", "limiter_binding.worst"),
    ("unit of the gauge's work: worst; mean", "slice.worst", "slice.mean"),
]


def servo_rates(budgets):
    counts = {(b["target"], b["thing"]): b["count"] for b in budgets}
    rates = "".join(f" {rate / 1000:g} kHz |" for rate in RATES)
    lines = [f"| core | configuration | typical | worst | time, worst |{rates} highest rate |", "|---" * (6 + len(RATES)) + "|"]
    for target, core, clock, per_instruction in CORES:
        for name, thing in CONFIGURATIONS:
            typical, worst = (counts[target, f"{thing}.{figure}"] for figure in ("typical", "worst"))
            seconds = (MARGIN * worst + OVERHEAD) * per_instruction / clock
            loads = "".join(f" {100 * seconds * rate:.0f} % |" if seconds * rate <= SHARE else " – |" for rate in RATES)
            lines.append(
                f"| {core}, {clock / 1e6:.0f} MHz | {name} | {typical:.0f} | {worst:.0f} | {1e6 * seconds:.1f} µs |{loads}"
                f" {SHARE / seconds / 1000:.1f} kHz |"
            )
    return "\n".join(lines) + "\n"


def figures(budgets):
    counts = {(b["target"], b["thing"]): b["count"] for b in budgets}
    cell = lambda target, things: "; ".join(f"{counts[target, thing]:.0f}" for thing in things)
    head = "| cost in a cycle, bare metal, in QEMU: instructions, not cycles | Cortex-M4F, f32 | Cortex-M7, f64 |\n|---|---|---|\n"
    return head + "".join(f"| {name} | {cell('m4f', things)} | {cell('m7', things)} |\n" for name, *things in SHOWN)


# Rows of the stack table: symbol, and what is left out.
STACKS = [
    ("step, nine terms only", "proved_step", "volumetric"),
    ("step, any model", "proved_step", None),
    ("step with a gauge", "proved_step_with_gauge", None),
    ("step following its commands", "proved_step_following", None),
    ("step with tool, five axes", "proved_step_with_tool", None),
    ("step with tool commanded, five axes", "proved_step_rtcp", None),
    ("bypass", "proved_bypass", None),
]


def stack(budgets):
    bytes_of = {(b["target"], b["symbol"], b.get("without")): b["bytes"] for b in budgets}
    rows = "".join(f"| {name} | {bytes_of['m4f', *key]} | {bytes_of['m7', *key]} |\n" for name, *key in STACKS)
    return "| stack, bytes, bound | Cortex-M4F, f32 | Cortex-M7, f64 |\n|---|---|---|\n" + rows


def main():
    budgets = tomllib.load(open(sys.argv[1], "rb"))["budget"]
    made = {"schedule": servo_rates(budgets), "counts": figures(budgets)}
    if stacks := glob(f"{dirname(sys.argv[1])}/proofs/budgets.toml"):
        made["stack"] = stack(tomllib.load(open(stacks[0], "rb"))["stack"])
    mode, *pages = sys.argv[2:]
    for path in pages:
        page = held = open(path, encoding="utf-8").read()
        for name, text in made.items():
            begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->\n"
            if begin in page:
                before, rest = page.split(begin)
                page = before + begin + text + end + rest.split(end)[1]
        if mode == "--write":
            open(path, "w", encoding="utf-8").write(page)
        elif held != page:
            sys.exit(f"{path}: found other figures than the committed counts, needed {sys.argv[0]} {sys.argv[1]} --write {path}")


main()
