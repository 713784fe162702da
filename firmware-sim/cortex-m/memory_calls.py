"""Instructions of the compiler's functions that copy or clear a constant number of bytes, by running them.

Their loops have no source here, and their lengths are constants where they are called. The way through them depends on the
number of bytes and, for the functions whose names promise aligned addresses, on nothing else: so one run counts every call.
What is not constant is refused.
"""

import re

from thumb import CONDITIONAL_BLOCK, PLACE, Refused

# Register with the number of bytes, by function.
LENGTH = {
    "__aeabi_memclr4": "r1",
    "__aeabi_memclr8": "r1",
    "__aeabi_memcpy4": "r2",
    "__aeabi_memcpy8": "r2",
    "__aeabi_memmove4": "r2",
}
WORD = 0xFFFFFFFF
# Longer runs than of any struct on the stack of a controller are refused.
MOST = 100_000
OPPOSITE = {"t": True, "e": False}
TESTS = {
    "eq": lambda n, z, c, v: z,
    "ne": lambda n, z, c, v: not z,
    "hs": lambda n, z, c, v: c,
    "lo": lambda n, z, c, v: not c,
    "mi": lambda n, z, c, v: n,
    "pl": lambda n, z, c, v: not n,
    "hi": lambda n, z, c, v: c and not z,
    "ls": lambda n, z, c, v: not c or z,
    "ge": lambda n, z, c, v: n == v,
    "lt": lambda n, z, c, v: n != v,
    "gt": lambda n, z, c, v: not z and n == v,
    "le": lambda n, z, c, v: z or n != v,
}
CONDITION = "|".join(TESTS)
ARITHMETIC = re.compile(r"(movw?|mvn|adds?|subs?|rsb|and|bic|orr|cmp|tst)s?")


def length_at(function, block, call):
    """The constant that a block puts into the register of the length before a call, or None."""
    register = LENGTH[function.name]
    for instruction in reversed([i for i in block.instructions if i.address < call]):
        if re.match(rf"{register}\b", instruction.operands) and not re.match(r"cmp|tst|str|push", instruction.name):
            found = re.fullmatch(rf"{register}, #(\d+)", instruction.operands)
            constant = found and re.fullmatch(r"mov(s|w|\.w)?", instruction.name) and not instruction.conditional
            return int(found[1]) if constant else None
        if instruction.name.startswith("bl"):
            return None
    return None


class _Run:
    def __init__(self, program, function, count):
        self.program, self.place = program, f"{function.name} of {count} bytes"
        self.registers = {f"r{k}": 0 for k in range(13)} | {"sp": 0x20020000, "lr": 0xFFFFFFFF, "pc": function.address}
        self.registers |= {"r0": 0x20000000, "r1": 0x20010000, LENGTH[function.name]: count}
        self.memory, self.flags, self.count = {}, (False, False, False, False), 0

    def value(self, text):
        if text.startswith("#"):
            return int(text[1:], 0) & WORD
        return self.registers[text]

    def arithmetic(self, name, operands):
        """Runs an instruction of ARITHMETIC; flags follow a subtraction or the result."""
        stem = name.split(".")[0]
        sets = stem in ("cmp", "tst") or stem.endswith("s")
        stem = stem.removesuffix("s").removesuffix("w") if stem != "tst" else stem
        words = operands if stem in ("cmp", "tst") else operands[1:]
        one, other = self.value(words[0] if len(words) > 1 or stem in ("mov", "mvn") else operands[0]), self.value(words[-1])
        carry, overflow = self.flags[2:]
        if stem in ("cmp", "sub", "rsb"):
            left, right = (other, one) if stem == "rsb" else (one, other)
            result = (left - right) & WORD
            carry, overflow = left >= right, ((left ^ right) & (left ^ result)) >> 31 == 1
        elif stem == "add":
            result = (one + other) & WORD
            carry, overflow = one + other > WORD, (~(one ^ other) & (one ^ result)) >> 31 & 1 == 1
        else:
            kinds = {"mov": other, "mvn": ~other, "and": one & other, "tst": one & other, "bic": one & ~other, "orr": one | other}
            result = kinds[stem] & WORD
        if stem not in ("cmp", "tst"):
            self.registers[operands[0]] = result
        if sets:
            self.flags = (result >> 31 == 1, result == 0, carry, overflow)

    def memory_access(self, name, text):
        """Stores count for their addresses only; the stack keeps what it is given."""
        if listed := re.search(r"\{(.*)\}", text):
            names = [one for part in listed[1].split(", ") for one in _expanded(part)]
            if name.startswith("push"):
                for one in reversed(names):
                    self.registers["sp"] -= 4
                    self.memory[self.registers["sp"]] = self.registers[one]
            else:
                for one in names:
                    self.registers[one] = self.memory[self.registers["sp"]]
                    self.registers["sp"] += 4
            return
        found = re.fullmatch(r"([\w, ]+), \[(\w+)(?:, #(-?\d+))?\](!)?(?:, #(-?\d+))?", text)
        if not found:
            raise Refused(f"{self.place}: found {name} {text}, which is not run here")
        targets, base, offset, before, after = found.groups()
        address = self.registers[base] + int(offset or 0)
        for k, one in enumerate(targets.split(", ")):
            if name.startswith("ld"):
                self.registers[one] = self.memory.get(address + 4 * k, 0)
            elif base == "sp":
                self.memory[address + 4 * k] = self.registers[one]
        if before or after:
            self.registers[base] = address + int(after or 0)

    def step(self, instruction, name):
        """Runs an instruction; whether the function goes on."""
        stem, text = name.split(".")[0], instruction.operands
        if stem in ("b", "bx"):
            self.registers["pc"] = int(PLACE.search(text)[1], 16) if stem == "b" else self.registers[text]
        elif ARITHMETIC.fullmatch(stem):
            self.arithmetic(name, re.sub(r"\s", "", text).split(","))
        elif re.fullmatch(r"push|pop|ldr[bh]?|ldrd|str[bh]?|strd", stem):
            self.memory_access(stem, text)
        else:
            raise Refused(f"{self.place}: found {instruction.address:#x}: {instruction.text}, which is not run here")
        return self.registers["pc"] != 0xFFFFFFFF

    def run(self):
        """Instructions up to the return."""
        pending = []
        while self.count < MOST:
            at = self.registers["pc"]
            function = self.program.holding(at)
            self.program.graph(function)
            instruction = function.instructions[at]
            self.registers["pc"] = at + instruction.length
            self.count += 1
            name = instruction.name
            if block := CONDITIONAL_BLOCK.fullmatch(name):
                test = TESTS[instruction.operands](*self.flags)
                pending = [test, *(test == OPPOSITE[letter] for letter in block[1])]
                # Conditions are those at the beginning, which what runs under them keeps or ends with.
                continue
            runs = True
            if pending:
                runs = pending.pop(0)
                name = re.sub(rf"({CONDITION})(?=\.|$)", "", name)
            elif found := re.fullmatch(rf"b({CONDITION})(\.[wn])?", name):
                runs, name = TESTS[found[1]](*self.flags), "b"
            if runs and not self.step(instruction, name):
                return self.count
        raise Refused(f"{self.place}: found more than {MOST} instructions")


def _expanded(part):
    """Registers of a part of a list."""
    first, _, last = part.partition("-")
    return [f"r{k}" for k in range(int(first[1:]), int(last[1:]) + 1)] if last else [part]


def instructions_of(program, function, count):
    """Instructions of one call for a number of bytes."""
    return _Run(program, function, count).run()
