#!/usr/bin/env python3
"""Estimated cycles of executed instructions, by LLVM's models of both cores.

cycles.py CORE WHAT KIND NUMBER ELF TRACE      one cycle for cycles.toml
cycles.py --where CORE ELF TRACE               where the instructions go, and where the model waits

A trace is a list of addresses, as executed.c writes them. They are disassembled and put through llvm-mca in the order in
which they ran, branches as the model has them: always predicted, without wait states of any memory.
"""

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

PROCESSOR = {"m4f": "cortex-m4", "m7": "cortex-m7"}
TRIPLE = "thumbv7em-none-eabihf"
# Instructions per run of the model if single ones are printed: its output grows with the square.
CHUNK = 300
# Conditions and their opposites.
PAIRS = ["eq ne", "hs lo", "mi pl", "vs vc", "hi ls", "ge lt", "gt le"]
OTHERWISE = {a: b for pair in map(str.split, PAIRS) for a, b in (pair, pair[::-1])}
BRANCH = re.compile(r"bl?|b(eq|ne|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)|cbn?z")
# Cycles in which an M4F fills its pipeline after a taken branch: 1 to 3, by alignment and width.
REFILL = 2
# Flash: wait states, bytes of a line, lines kept.
WAIT_STATES, LINE, LINES = 5, 16, 64


def disassembled(elf, processor):
    """Text and function of every address."""
    command = ["llvm-objdump", "-d", "--no-show-raw-insn", "--demangle", f"--mcpu={processor}", elf]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    found, function = {}, "?"
    for line in listing.splitlines():
        if head := re.match(r"[0-9a-f]+ <(.*)>:", line):
            # Data and code within a function have separate symbols.
            function = function if head[1].startswith("$") else re.sub(r"::h[0-9a-f]{16}$", "", head[1])
        elif body := re.match(r"\s*([0-9a-f]+):\s+(\S.*)", line):
            found[int(body[1], 16)] = (body[2].split("@")[0].strip(), function)
    return found


def executed(trace, listing):
    """Executed instructions of the call and their addresses, up to its return into the counter."""
    run, addresses = [], []
    for line in Path(trace).read_text().split():
        address = int(line, 16)
        if address not in listing:
            sys.exit(f"{trace}: found no instruction at {address:#x}")
        if listing[address][1].endswith("timer::timed"):
            return run, addresses
        run.append(listing[address])
        addresses.append(address)
    sys.exit(f"{trace}: the call does not return")


def assembled(instructions):
    """Lines as llvm-mca reads them.

    Places of branches and of literals do not matter. A call is a branch: the model would take a hundred cycles for what is
    called, which follows here. It knows no conditional blocks: their head passes for a move, what was executed in them
    for the same without its condition.
    """
    lines, conditions = [], []
    for text, _ in instructions:
        text = re.sub(r"\s*<.*", "", text)
        name, _, operands = text.partition("\t")
        if re.fullmatch(r"it[te]*", name):
            conditions = [operands] + [operands if then == "t" else OTHERWISE[operands] for then in name[2:]]
            lines.append("mov\tr8, r8")
            continue
        stem, dot, width = name.partition(".")
        if conditions and stem.endswith(conditions[0]):
            conditions.pop(0)
            stem = stem[:-2]
            name = stem + dot + width
        elif conditions:
            conditions = []
        if BRANCH.fullmatch(stem):
            name, operands = ("b.w", "#64") if stem == "bl" else (name, re.sub(r"0x[0-9a-f]+$", "#64", operands))
        elif stem == "blx":
            name = "bx"
        elif stem.startswith("vcmp") and operands.endswith("#0"):
            operands = re.sub(r"(\S+), #0", r"\1, \1", operands)
        lines.append(f"{name}\t{operands}")
    return lines


def model(instructions, processor, *options):
    """llvm-mca's answer for one pass over the instructions."""
    command = ["llvm-mca", f"-mtriple={TRIPLE}", f"-mcpu={processor}", "-iterations=1", "--json", *options]
    source = "\n".join(assembled(instructions)) + "\n"
    done = subprocess.run(command, input=source, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr)
    [region] = json.loads(done.stdout[done.stdout.index("{") :])["CodeRegions"]
    return region


def taken(addresses, lengths):
    """Taken branches."""
    return sum(after != before + lengths[before] for before, after in zip(addresses, addresses[1:]))


def flash_waits(addresses, lengths, per_instruction):
    """Cycles of waiting for code in flash of five wait states behind lines of 16 bytes, the next one read ahead, the last
    64 kept, as the accelerators of controllers at 168 MHz have it."""
    waits, kept, since, last = 0.0, {}, 0.0, None
    for address in addresses:
        for line in {address // LINE, (address + lengths[address] - 1) // LINE}:
            if line == last:
                continue
            if line not in kept:
                waits += max(0.0, WAIT_STATES - since) if last is not None and line == last + 1 else WAIT_STATES
            kept.pop(line, None)
            kept[line] = True
            if len(kept) > LINES:
                kept.pop(next(iter(kept)))
            last, since = line, 0.0
        since += per_instruction
    return waits


def waits(instructions, addresses, processor):
    """Waiting cycles of every address, as the model issues it."""
    late = Counter()
    for start in range(0, len(instructions), CHUNK):
        part = instructions[start : start + CHUNK]
        region = model(part, processor, "-timeline", "-timeline-max-iterations=1", "-timeline-max-cycles=100000")
        issued = [entry["CycleIssued"] for entry in region["TimelineView"]["TimelineInfo"]]
        for place, (before, now) in enumerate(zip(issued, issued[1:]), start + 1):
            late[addresses[place]] += max(0, now - before - 1)
    return late


def sources(addresses, elf):
    """Function and line of every address; inlined functions separately."""
    command = ["llvm-symbolizer", f"--obj={elf}", "--functions=short", "--demangle", "--inlines"]
    asked = "".join(f"{address:#x}\n" for address in addresses)
    answer = subprocess.run(command, input=asked, capture_output=True, text=True, check=True).stdout
    for address, block in zip(addresses, answer.split("\n\n")):
        lines = block.strip().splitlines()
        frames = list(zip(lines[::2], lines[1::2])) or [("?", "?")]
        # Ours, not the operator of the language that it uses.
        function, place = next((frame for frame in frames if "/crates/" in frame[1]), frames[0])
        yield address, function, "/".join(place.rsplit(":", 1)[0].split("/")[-3:])


def show_where(core, elf, trace):
    """Where the instructions go, and where the model waits."""
    instructions, addresses = executed(trace, disassembled(elf, PROCESSOR[core]))
    times, late = Counter(addresses), waits(instructions, addresses, PROCESSOR[core])
    functions, lines = (Counter(), Counter()), (Counter(), Counter())
    for address, function, line in sources(list(times), elf):
        for name, (ran, waited) in ((function, functions), (line, lines)):
            ran[name] += times[address]
            waited[name] += late[address]
    print(f"{len(instructions)} instructions, {sum(late.values())} cycles of waiting")
    for ran, waited in (functions, lines):
        print("executed  waiting")
        for name, _ in (ran + waited).most_common(25):
            print(f"{ran[name]:8} {waited[name]:8}  {name}")


def lengths_of(listing):
    """Bytes of every instruction."""
    addresses = sorted(listing)
    return {a: min(b - a, 4) for a, b in zip(addresses, addresses[1:])} | {addresses[-1]: 4}


def estimate(core, elf, trace):
    """Model, branches and flash for the call that a trace is of."""
    listing = disassembled(elf, PROCESSOR[core])
    instructions, addresses = executed(trace, listing)
    summary = model(instructions, PROCESSOR[core])["SummaryView"]
    lengths, cycles = lengths_of(listing), summary["TotalCycles"]
    jumps = taken(addresses, lengths)
    # The model of the M7 includes its branch prediction, whose misses are not known here.
    branches = REFILL * jumps if core == "m4f" else 0
    found = {"executed": len(instructions), "model": cycles, "taken": jumps, "branches": branches}
    if core == "m4f":
        found["flash"] = round(flash_waits(addresses, lengths, (cycles + branches) / len(instructions)))
    return found


def main():
    if sys.argv[1] == "--where":
        return show_where(*sys.argv[2:])
    core, what, kind, number, elf, trace = sys.argv[1:]
    print(f'[[cycle]]\ntarget = "{core}"\nwhat = "{what}"\nkind = "{kind}"\nnumber = {number}')
    for name, value in estimate(core, elf, trace).items():
        print(f"{name} = {value}")
    print()


main()
