#!/usr/bin/env python3
"""Worst-case stack of functions from the compiler's frame sizes and the call graph of the linked program.

    stack.py --tools DIR --budgets budgets.toml --target m4f ELF [--painted FILE] [--path SYMBOL]

The ELF has a section .stack_sizes (rustc -Zemit-stack-sizes, kept by stack-sizes.ld). A function without an entry, as
those of the precompiled compiler_builtins, is charged with all that its instructions push and subtract. A call by a
register and a recursion have no bound here: they are refused. A tail call counts as a call. A budget with `without`
leaves out the functions with that in their names: what a machine needs that is configured never to call them.

Fails (exit 1) where a function needs more than is committed by over 2 % (a spilled register or two is not growth), or where
the painted stack exceeds the bound; a bound above its limit is shown as "limit missed" in every run.
"""

import argparse
import bisect
import re
import subprocess
import sys
import tomllib

GROWTH = 1.02
HEADING = re.compile(r"^([0-9a-f]{8}) <(.+)>:$")
INSTRUCTION = re.compile(r"^\s*([0-9a-f]+):\s+(\S+)\s*(.*)$")
TARGET = re.compile(r"0x([0-9a-f]+)")
# Branches that stay in the function or leave it by a known address; cbz and cbnz never leave it.
BRANCH = re.compile(r"^(bl?x?)(eq|ne|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le|al)?(\.[wn])?$")
JUMP_TABLE = re.compile(r"^tb[bh]$")


class Function:
    def __init__(self, address, name):
        self.address, self.name = address, name
        self.frame, self.pushed = None, 0
        self.calls = set()
        self.unbounded = []


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def registers(operands):
    """Bytes of a register list as in `push {r4-r7, lr}` or `vpush {d8, d9}`."""
    listed = operands[operands.index("{") + 1 : operands.index("}")]
    size = 0
    for part in listed.replace(" ", "").split(","):
        kind = 8 if part.startswith("d") else 4
        first, _, last = part.partition("-")
        count = int(last[1:]) - int(first[1:]) + 1 if last else 1
        size += kind * count
    return size


def sizes(nm, elf):
    """Address to size: the padding after a function disassembles to anything."""
    known = {}
    for line in run(nm, "--print-size", "--defined-only", elf).splitlines():
        words = line.split()
        if len(words) == 4:
            known[int(words[0], 16) & ~1] = int(words[1], 16)
    return known


def disassembled(tools, elf):
    functions, order = {}, []
    current = None
    ends = sizes(f"{tools}/llvm-nm", elf)
    for line in run(f"{tools}/llvm-objdump", "-d", "--no-show-raw-insn", elf).splitlines():
        if heading := HEADING.match(line):
            current = Function(int(heading[1], 16), heading[2])
            functions[current.address] = current
            order.append(current.address)
            continue
        instruction = INSTRUCTION.match(line)
        if not (current and instruction):
            continue
        if (size := ends.get(current.address)) and int(instruction[1], 16) >= current.address + size:
            continue
        mnemonic, operands = instruction[2], instruction[3]
        operands = operands.split("@")[0].split("<")[0].strip()
        branch = BRANCH.match(mnemonic)
        if branch and (target := TARGET.search(operands)):
            current.calls.add(int(target[1], 16))
        elif branch and operands != "lr":
            current.unbounded.append(line.strip())
        elif not JUMP_TABLE.match(mnemonic) and re.match(r"^(pc|.*, pc)$", operands.split(",")[0]):
            current.unbounded.append(line.strip())
        elif mnemonic in ("push", "push.w", "vpush") or (mnemonic.startswith("stmdb") and operands.startswith("sp!")):
            current.pushed += registers(operands)
        elif mnemonic.startswith("str") and re.search(r"\[sp, #-(0x[0-9a-f]+|\d+)\]!", operands):
            current.pushed += int(re.search(r"#-(\w+)", operands)[1], 0)
        elif mnemonic.startswith("sub") and operands.startswith("sp,"):
            amount = re.search(r"#(0x[0-9a-f]+|\d+)$", operands)
            if amount:
                current.pushed += int(amount[1], 0)
            else:
                current.unbounded.append(line.strip())
    return functions, order


def frames(readobj, elf, functions):
    by_name = {f.name: f for f in functions.values()}
    for line in run(readobj, "--stack-sizes", "--elf-output-style=GNU", elf).splitlines():
        words = line.replace(",", " ").split()
        if len(words) > 1 and words[0].isdigit():
            for name in words[1:]:
                if name in by_name:
                    by_name[name].frame = int(words[0])


class Graph:
    def __init__(self, functions, order, without=None):
        self.functions, self.order, self.known, self.without = functions, order, {}, without

    def holding(self, address):
        return self.functions[self.order[bisect.bisect_right(self.order, address) - 1]]

    def worst(self, function, above=()):
        """Bytes and the path that needs them."""
        if function.address in self.known:
            return self.known[function.address]
        if function.address in above:
            sys.exit(f"{function.name} calls itself: no bound")
        if function.unbounded:
            sys.exit(f"{function.name} has no bound: {function.unbounded[0]}")
        own = function.frame if function.frame is not None else function.pushed
        deepest, path = 0, []
        for address in function.calls:
            callee = self.holding(address)
            if callee is function or (self.without and self.without in callee.name):
                continue
            size, further = self.worst(callee, (*above, function.address))
            if size > deepest:
                deepest, path = size, further
        self.known[function.address] = (own + deepest, [(function.name, own), *path])
        return self.known[function.address]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tools", required=True, help="directory of llvm-nm, llvm-objdump and llvm-readobj")
    parser.add_argument("--budgets", required=True)
    parser.add_argument("--target", required=True)
    parser.add_argument("--painted", help="lines of symbol and bytes, measured in a run")
    parser.add_argument("--path", help="symbol whose deepest path to print")
    parser.add_argument("elf")
    options = parser.parse_args()

    functions, order = disassembled(options.tools, options.elf)
    frames(f"{options.tools}/llvm-readobj", options.elf, functions)
    graph = Graph(functions, order)
    by_name = {f.name: f for f in functions.values()}
    if options.path:
        for name, size in graph.worst(by_name[options.path])[1]:
            print(f"{size:6} {name}")
        return 0

    painted = {}
    if options.painted:
        for line in open(options.painted, encoding="ascii"):
            symbol, size = line.split()
            painted[symbol] = int(size)
    budgets = [b for b in tomllib.load(open(options.budgets, "rb"))["stack"] if b["target"] == options.target]
    failed = False
    for symbol in sorted(set(by_name) - {b["symbol"] for b in budgets}):
        if symbol.startswith("proved_"):
            print(f"{symbol} on {options.target} is not in {options.budgets}")
            failed = True
    for budget in budgets:
        symbol, committed, limit = budget["symbol"], budget["bytes"], budget.get("limit")
        if symbol not in by_name:
            print(f"{symbol:26} {options.target:4} NOT IN THE PROGRAM")
            failed = True
            continue
        without = budget.get("without")
        size, _ = Graph(functions, order, without).worst(by_name[symbol])
        seen = None if without else painted.get(symbol)
        if without:
            symbol = f"  without {without}"
        verdict = ""
        if size > committed * GROWTH:
            verdict, failed = "GREW", True
        elif seen is not None and seen > size:
            verdict, failed = "PAINTED MORE THAN THE BOUND", True
        elif limit is not None and size > limit:
            verdict = "limit missed"
        row = ["-" if x is None else str(x) for x in (size, seen, committed, limit)]
        print(f"{symbol:26} {options.target:4} {row[0]:>9} {row[1]:>9} {row[2]:>9} {row[3]:>7}  {verdict}".rstrip())
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
