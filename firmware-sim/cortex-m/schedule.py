#!/usr/bin/env python3
"""Tables made from the committed counts: schedule.py counts.toml --check PAGE... | --write PAGE...

Between the markers `schedule` of a page stand the servo rates that the counts allow,

    load = rate · (worst + overhead) · cycles per instruction / clock

between the markers `counts` the counts themselves, `limits` the whole step against its limits, `growth` those of thermal
growth, `cycles` the estimates of cycles.toml, `stack` the bounds of proofs/budgets.toml, `host` and `budgets` the counts of
benches/budgets.toml. A row of the README follows too. --check fails (exit 1) where a page holds another table, --write puts
them there.
"""

import sys
import tomllib
from pathlib import Path

# Core, clock, bound of the mean cycles an instruction.
CORES = [("m4f", "Cortex-M4F, f32", 168e6, 2.0), ("m7", "Cortex-M7, f64", 480e6, 2.0)]
# Entry and exit of the interrupt, hand-over of tables, the record into its queue: instructions.
OVERHEAD = 400
# Name, counts over the recording, counts over adversarial cycles.
CONFIGURATIONS = [
    ("three axes, nine terms", "step", ["adversarial", "climb"]),
    ("three axes, nine terms, gauge of 1024 points", "step_gauge", ["adversarial_gauge"]),
    ("three axes, volumetric, cubic tables", "step_volumetric", ["adversarial_volumetric"]),
]
RATES = [1_000, 2_000, 4_000, 10_000, 20_000]
# Share of the period: the host has the rest.
SHARE = 0.5
# What the stages of the step do.
STAGES = {
    "sample": "plausibility of commands and readings",
    "compensation": "tables, inverse, estimated tip",
    "contour": "contour error of tip and encoder position",
    "output": "limiter and output",
    "telemetry": "telemetry record",
}
# Rows of the counts table.
SHOWN = [
    ("whole step, three axes: typical; mean; worst", "step.typical", "step.mean", "step.worst"),
    ("with a gauge of 1024 points: typical; mean; worst", "step_gauge.typical", "step_gauge.mean", "step_gauge.worst"),
    (
        "three axes, volumetric, cubic tables: typical; mean; worst",
        "step_volumetric.typical",
        "step_volumetric.mean",
        "step_volumetric.worst",
    ),
    (
        "worst of 100,000 adversarial cycles: nine terms; with a gauge; volumetric",
        "adversarial.worst",
        "adversarial_gauge.worst",
        "adversarial_volumetric.worst",
    ),
    (STAGES["sample"], "stage_sample.mean"),
    (STAGES["compensation"], "stage_compensation.mean"),
    (STAGES["contour"] + ": mean; worst", "stage_contour.mean", "stage_contour.worst"),
    (STAGES["output"] + ": mean; worst", "stage_output.mean", "stage_output.worst"),
    (STAGES["telemetry"], "stage_telemetry.worst"),
    ("nine-term look-up, equidistant linear tables", "nine_terms.worst"),
    ("volumetric errors, three axes; five", "volumetric_3.worst", "volumetric_5.worst"),
    ("kernel of the contour search, rational cubic; polynomial", "kernel_rational.worst", "kernel_polynomial.worst"),
    ("limiter, three axes, nothing binding; all", "limiter_free.worst", "limiter_binding.worst"),
    ("unit of the gauge's work: worst; mean", "slice.worst", "slice.mean"),
]


def counts_of(budgets):
    return {(b["target"], b["thing"]): b["count"] for b in budgets if "count" in b}


def seconds(count, per_instruction, clock):
    return (count + OVERHEAD) * per_instruction / clock


def servo_rates(budgets):
    """Loads by the worst cycle of all; the highest rate by that, and by the worst of the recording."""
    counts = counts_of(budgets)
    rates = "".join(f" {rate / 1000:g} kHz |" for rate in RATES)
    lines = [
        f"| core | configuration | typical | worst, recording; adversarial | time, worst |{rates} highest rate, by the recording; by all |",
        "|---" * (6 + len(RATES)) + "|",
    ]
    for target, core, clock, per_instruction in CORES:
        for name, recorded, adversarial in CONFIGURATIONS:
            typical, usual = (counts[target, f"{recorded}.{figure}"] for figure in ("typical", "worst"))
            hard = max(counts[target, f"{kind}.worst"] for kind in adversarial)
            took, longest = (seconds(count, per_instruction, clock) for count in (usual, max(usual, hard)))
            loads = "".join(f" {100 * longest * rate:.0f} % |" if longest * rate <= SHARE else " – |" for rate in RATES)
            lines.append(
                f"| {core}, {clock / 1e6:.0f} MHz | {name} | {typical:.0f} | {usual:.0f}; {hard:.0f} | {1e6 * longest:.1f} µs |{loads}"
                f" {SHARE / took / 1000:.1f}; {SHARE / longest / 1000:.1f} kHz |"
            )
    return "\n".join(lines) + "\n"


# Rows of the table of the thermal task.
GROWTH = [
    ("the task's update, 16 sensors of 8 knots, six axes, spindle", "thermal_update.worst"),
    ("the interrupt, nothing to do; readings due", "growth_none.worst", "growth_read.worst"),
    ("the interrupt, a growth waits, not due; lines of three axes set", "growth_waiting.worst", "growth_taken.worst"),
]

# Rows of the table of limits.
LIMITED = [
    ("typical cycle of the recording", "step.typical"),
    ("mean over the recording", "step.mean"),
    ("worst of the recording", "step.worst"),
    ("worst of 100,000 adversarial cycles", "adversarial.worst"),
    ("worst that hill climbing finds in a million", "climb.worst"),
    ("with a gauge: typical", "step_gauge.typical"),
    ("with a gauge: worst of the recording", "step_gauge.worst"),
]


def verdict(budget):
    """Limit and goal, and whether the count meets them."""
    met = lambda name, bound, no: f"{name}{bound} " + ("met" if budget["count"] <= bound else no)
    limit, goal = budget.get("limit"), budget.get("goal")
    parts = [] if limit is None else [met("", limit, "**not met**")]
    parts += [] if goal is None else [met("goal ", goal, "not met")]
    return ", ".join(parts) or "–"


def limits(budgets):
    by_name = {(b["target"], b["thing"]): b for b in budgets}
    head = "| instructions of the whole step, three axes, nine terms |" + "".join(f" {core} | limit |" for _, core, *_ in CORES)
    cell = lambda budget: f" {budget['count']:.0f} | {verdict(budget)} |"
    rows = (f"| {name} |" + "".join(cell(by_name[target, thing]) for target, *_ in CORES) for name, thing in LIMITED)
    return "\n".join([head, "|---" * (1 + 2 * len(CORES)) + "|", *rows]) + "\n"


def figures(budgets, what, shown):
    counts = counts_of(budgets)
    cell = lambda target, things: "; ".join(f"{counts[target, thing]:.0f}" for thing in things)
    head = f"| {what} | Cortex-M4F, f32 | Cortex-M7, f64 |\n|---|---|---|\n"
    return head + "".join(f"| {name} | {cell('m4f', things)} | {cell('m7', things)} |\n" for name, *things in shown)


def cycles(estimates):
    """Estimated cycles beside the assumed ones."""
    head = (
        "| servo cycle | core | instructions | pipeline | branches | waiting for flash | cycles an instruction | time | assumed:"
        " cycles an instruction, time |\n" + "|---" * 9 + "|\n"
    )
    rows = ""
    for target, core, clock, per_instruction in CORES:
        for found in (e for e in estimates["cycle"] if e["target"] == target):
            executed, extra = found["executed"], [found.get(key) for key in ("branches", "flash")]
            total = found["model"] + sum(filter(None, extra))
            us = lambda cycles: f"{1e6 * cycles / clock:.1f} µs"
            cells = "".join(f" {x} |" if x else " – |" for x in extra)
            rows += (
                f"| {found['what']} ({found['number']}) | {core}, {clock / 1e6:.0f} MHz | {executed} | {found['model']} |{cells}"
                f" {total / executed:.2f} | {us(total)} | {per_instruction:g}, {us(per_instruction * executed)} |\n"
            )
    return head + rows


# Rows of the stack table: symbol, and what it excludes.
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


def bound(budgets):
    """The stages' own maxima, their sum, and the dearest cycle found."""
    counts = counts_of(budgets)
    cores = [target for target, *_ in CORES]
    row = lambda name, cells: f"| {name} |" + "".join(f" {cell} |" for cell in cells) + "\n"
    text = row("the dearest cycle of each stage by itself", [core for _, core, *_ in CORES]) + "|---" * (1 + len(cores)) + "|\n"
    sums = dict.fromkeys(cores, 0)
    for stage, name in STAGES.items():
        found = {target: counts[target, f"adversarial_{stage}.worst"] for target in cores}
        text += row(name, [f"{found[target]:.0f}" for target in cores])
        sums = {target: sums[target] + found[target] for target in cores}
    worst = {target: max(counts[target, "adversarial.worst"], counts[target, "climb.worst"]) for target in cores}
    text += row("sum", [f"**{sums[target]:.0f}**" for target in cores])
    text += row("dearest cycle found", [f"{worst[target]:.0f}" for target in cores])
    return text + row("the sum is above it by", [f"{100 * (sums[target] / worst[target] - 1):.1f} %" for target in cores])


# Rows of the table of a host's counts, plain x86-64.
ON_HOST = [
    ("nine-term look-up, equidistant linear tables", "nine_terms.equidistant"),
    (
        "volumetric errors at a position, equidistant linear tables, three axes; five",
        "volumetric.three_axis",
        "volumetric_rotary.five_axis",
    ),
    ("contour error, one point, rational cubic; its kernel", "contour.rational_cubic", "kernel.rational_cubic"),
    ("limiter, three axes, nothing binding", "limiter.free"),
    ("kinematics of five axes, forward; inverse with both branches", "kinematics.forward", "kinematics.inverse"),
    ("whole step, three axes, all along the butterfly: typical; mean; worst", "walk.typical", "walk.mean", "walk.worst"),
    ("the most expensive adversarial cycle", "adversarial.worst"),
    ("three-probe gauge, a cycle's readings; at one of 1024 points", "gauge_sampling.between_points", "gauge_sampling.at_a_point"),
]


def host(budgets):
    counts = counts_of(budgets)
    cell = lambda things: "; ".join(f"{counts['base', thing]:.0f}" for thing in things)
    head = "| cost in a cycle, host, f64 | instructions |\n|---|---|\n"
    return head + "".join(f"| {name} | {cell(things)} |\n" for name, *things in ON_HOST)


def all_on_host(budgets):
    """Every budget of the host, for both builds."""
    by_name = {(b["target"], b["thing"]): b for b in budgets}
    cell = lambda budget: f" {budget['count']:.0f} | {verdict(budget)} |" if budget and "count" in budget else " – | – |"
    things = dict.fromkeys(b["thing"] for b in budgets)
    rows = (f"| {thing} |" + "".join(cell(by_name.get((target, thing))) for target in ("base", "v3")) for thing in things)
    return "\n".join(["| instructions | base | limit | x86-64-v3 | limit |", "|---|---|---|---|---|", *rows]) + "\n"


def row(budgets):
    """The README's row: its beginning, and all of it."""
    counts = counts_of(budgets)
    beginning = "| whole step, three axes, Cortex-M4F in f32; Cortex-M7 in f64 |"
    return beginning, f"{beginning} {counts['m4f', 'step.typical']:.0f}; {counts['m7', 'step.typical']:.0f} instructions |"


def main():
    path = Path(sys.argv[1])
    read = lambda file: tomllib.loads(file.read_text(encoding="utf-8"))
    budgets = read(path)["budget"]
    on_host = read(path.parent / "../../benches/budgets.toml")["budget"]
    made = {"schedule": servo_rates(budgets), "limits": limits(budgets)}
    made["bound"] = bound(budgets)
    made["counts"] = figures(budgets, "cost in a cycle, bare metal, in QEMU: instructions, not cycles", SHOWN)
    made["growth"] = figures(budgets, "thermal growth, instructions", GROWTH)
    made |= {"host": host(on_host), "budgets": all_on_host(on_host)}
    made["stack"] = stack(read(path.parent / "proofs/budgets.toml")["stack"])
    if (estimates := path.parent / "cycles.toml").exists():
        made["cycles"] = cycles(read(estimates))
    beginning, line = row(budgets)
    mode, *pages = sys.argv[2:]
    for path in pages:
        page = held = open(path, encoding="utf-8").read()
        for name, text in made.items():
            begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->\n"
            if begin in page:
                before, rest = page.split(begin)
                page = before + begin + text + end + rest.split(end)[1]
        page = "".join(line + "\n" if text.startswith(beginning) else text for text in page.splitlines(keepends=True))
        if mode == "--write":
            open(path, "w", encoding="utf-8").write(page)
        elif held != page:
            sys.exit(f"{path}: found other figures than the committed counts, needed {sys.argv[0]} {sys.argv[1]} --write {path}")


main()
