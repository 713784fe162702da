"""Functions of a Cortex-M program as graphs of blocks, from its ELF file and llvm-objdump's text."""

import re
import struct
import subprocess
from bisect import bisect_right

CONDITION = "eq|ne|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le"
BRANCH = re.compile(rf"(bl?x?)({CONDITION}|al)?(\.[wn])?")
COMPARE_AND_BRANCH = re.compile(r"cbn?z")
CONDITIONAL_BLOCK = re.compile(r"it([te]*)")
PLACE = re.compile(r"0x([0-9a-f]+)")
# Never reached by a step that ends: traps.
TRAP = re.compile(r"udf")
# End of a function, as the target of a branch.
RETURN = "return"


class Refused(Exception):
    """The program has something without a bound; says where."""


class Elf:
    """Symbols, mapping symbols and bytes of a 32-bit little-endian ELF file."""

    def __init__(self, path):
        self.path, self.data = path, open(path, "rb").read()
        if self.data[:6] != b"\x7fELF\x01\x01":
            raise Refused(f"{path}: found no 32-bit little-endian ELF file")
        offset, size, count = struct.unpack_from("<I", self.data, 32)[0], *struct.unpack_from("<HH", self.data, 46)
        self.sections = [struct.unpack_from("<10I", self.data, offset + k * size) for k in range(count)]
        # Address to size and name; starts of code and of data.
        self.functions, self.marks = {}, []
        for kind, link, start, length in ((s[1], s[6], s[4], s[5]) for s in self.sections):
            if kind == 2:
                self._symbols(start, length, self.sections[link][4])
        self.marks = sorted(set(self.marks))
        self._at = [at for at, _ in self.marks]

    def _symbols(self, start, length, names):
        for at in range(start, start + length, 16):
            name, value, size, info, _, section = struct.unpack_from("<IIIBBH", self.data, at)
            text = self.data[names + name : self.data.index(b"\0", names + name)].decode()
            if re.match(r"\$[tad](\.|$)", text):
                self.marks.append((value & ~1, text[1]))
            elif info & 15 == 2 and section:
                known = self.functions.get(value & ~1)
                if known is None or size > known[0]:
                    self.functions[value & ~1] = (size, text)

    def is_code(self, address):
        place = bisect_right(self._at, address) - 1
        return place >= 0 and self.marks[place][1] == "t"

    def data_end(self, address):
        """End of the data that begin at an address."""
        return self._at[bisect_right(self._at, address)]

    def read(self, address, count):
        for kind, start, offset, size in ((s[1], s[3], s[4], s[5]) for s in self.sections):
            if kind == 1 and start and start <= address and address + count <= start + size:
                return self.data[offset + address - start : offset + address - start + count]
        raise Refused(f"{self.path}: found no bytes at {address:#x}")


class Instruction:
    __slots__ = ("address", "length", "text", "name", "operands", "conditional")

    def __init__(self, address, length, name, operands):
        self.address, self.length, self.name, self.operands = address, length, name, operands
        self.text, self.conditional = f"{name} {operands}", False


class Block:
    """Instructions that run one after the other, what they call, and where they may go on."""

    def __init__(self, address):
        self.address, self.instructions, self.calls, self.goes = address, [], [], []


class Function:
    def __init__(self, address, size, symbol, name):
        self.address, self.end, self.symbol, self.name = address, address + size, symbol, name
        self.lines, self.instructions, self.blocks = [], {}, {}


def demangled(names):
    """The names without parameters of the compiler's."""
    answer = subprocess.run(["llvm-cxxfilt"], input="\n".join(names), capture_output=True, text=True, check=True).stdout
    return [re.sub(r"::h[0-9a-f]{16}$", "", line) for line in answer.splitlines()]


class Program:
    """All functions of an ELF file; their graphs are built when they are asked for."""

    def __init__(self, path, processor):
        self.elf = Elf(path)
        ordered = sorted(self.elf.functions.items())
        names = demangled([symbol for _, (_, symbol) in ordered])
        self.functions = {at: Function(at, size, symbol, name) for (at, (size, symbol)), name in zip(ordered, names)}
        self._starts = [at for at, _ in ordered]
        self._disassemble(path, processor)

    def _disassemble(self, path, processor):
        """Keeps the lines of every function; those of the functions that are asked for are read."""
        command = ["llvm-objdump", "-d", "--no-show-raw-insn", f"--mcpu={processor}", path]
        function = None
        for line in subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines():
            if line.endswith(">:"):
                address = int(line.partition(" ")[0], 16)
                # Data within a function have symbols of their own.
                function = self.functions.get(address, function)
            elif function and line.startswith(" "):
                function.lines.append(line)

    def _read(self, function):
        """Reads the instructions from the lines."""
        code = self.elf.read(function.address, function.end - function.address)
        for line in function.lines:
            body = re.match(r"\s*([0-9a-f]+):\s+(\S+)\s*([^<@]*)", line)
            address = int(body[1], 16) if body else function.end
            if function.address <= address < function.end and self.elf.is_code(address):
                length = 4 if code[address - function.address + 1] >> 3 >= 0b11101 else 2
                function.instructions[address] = Instruction(address, length, body[2], body[3].strip())
        function.lines = []

    def holding(self, address):
        """The function with an address."""
        place = bisect_right(self._starts, address) - 1
        if place < 0:
            return None
        function = self.functions[self._starts[place]]
        return function if address < function.end else None

    def named(self, text):
        """The only function whose name has this text."""
        exact = [f for f in self.functions.values() if text in (f.name, f.symbol)]
        found = exact or [f for f in self.functions.values() if text in f.name]
        if len(found) != 1:
            raise Refused(f"{self.elf.path}: found {len(found)} functions named {text!r}, needed one")
        return found[0]

    def graph(self, function):
        """The function's blocks by address."""
        if not function.blocks:
            self._read(function)
            _split(self, function)
        return function.blocks


def _conditions(instructions):
    """Marks what runs under the condition of an IT block."""
    left = 0
    for instruction in instructions:
        if left:
            instruction.conditional, left = True, left - 1
        elif block := CONDITIONAL_BLOCK.fullmatch(instruction.name):
            left = 1 + len(block[1])


def _table(program, function, instruction):
    """Places that a jump table in the code leads to."""
    start = instruction.address + instruction.length
    width = 1 if instruction.name.startswith("tbb") else 2
    entries = program.elf.read(start, program.elf.data_end(start) - start)
    if program.elf.is_code(start) or "[pc," not in instruction.operands:
        raise Refused(f"{function.name}: found no jump table after {instruction.address:#x}: {instruction.text}")
    entries = [int.from_bytes(entries[k : k + width], "little") for k in range(0, len(entries) // width * width, width)]
    # A table of bytes is filled up to an even length.
    if width == 1 and len(entries) > 1 and start + 2 * entries[-1] not in function.instructions:
        entries.pop()
    return {start + 2 * entry for entry in entries}


def _goes(program, function, instruction):
    """Where an instruction may go on other than to the next one, whether it may go to the next one, and whom it calls."""
    name, operands = instruction.name, instruction.operands
    place = f"{function.name}: {instruction.address:#x}: {instruction.text}"
    may = instruction.conditional
    if COMPARE_AND_BRANCH.fullmatch(name.split(".")[0]):
        return {int(PLACE.findall(operands)[-1], 16)}, True, None
    if branch := BRANCH.fullmatch(name):
        may = may or branch[2] not in (None, "al")
        target = PLACE.search(operands)
        if branch[1] in ("bl", "blx"):
            if not target:
                raise Refused(f"{place}: found a call by a register, which has no bound")
            return set(), True, int(target[1], 16)
        if branch[1] == "bx":
            if operands != "lr":
                raise Refused(f"{place}: found a branch by a register, which has no bound")
            return {RETURN}, may, None
        return {int(target[1], 16)}, may, None
    if re.match(r"tb[bh]", name):
        return _table(program, function, instruction), False, None
    if TRAP.match(name):
        return {RETURN}, may, None
    if re.match(r"pop|ldm", name) and re.search(r"\bpc\b", operands):
        return {RETURN}, may, None
    if re.match(rf"ldr({CONDITION})?(\.w)?$", name) and re.match(r"pc, \[sp\], #", operands):
        return {RETURN}, may, None
    if re.match(r"pc\b", operands) and not re.match(r"cmp|tst|push|st", name):
        raise Refused(f"{place}: found a jump by a register, which has no bound")
    return set(), True, None


def _split(program, function):
    """Splits a function into blocks."""
    instructions = [function.instructions[at] for at in sorted(function.instructions)]
    if not instructions:
        raise Refused(f"{function.name}: found no instructions")
    _conditions(instructions)
    ways = {i.address: _goes(program, function, i) for i in instructions}
    heads = {function.address}
    for instruction in instructions:
        targets = ways[instruction.address][0]
        heads |= {t for t in targets if t != RETURN and function.address <= t < function.end}
        if targets:
            heads.add(instruction.address + instruction.length)
    blocks, block = {}, None
    for instruction in instructions:
        if instruction.address in heads:
            if block is not None:
                block.goes = block.goes or [instruction.address]
            block = blocks[instruction.address] = Block(instruction.address)
        targets, falls, callee = ways[instruction.address]
        block.instructions.append(instruction)
        if callee is not None:
            block.calls.append((instruction.address, callee, instruction.conditional))
        if targets:
            following = instruction.address + instruction.length
            block.goes = sorted(targets | ({following} if falls else set()), key=str)
        elif instruction.address + instruction.length not in function.instructions:
            # Nothing follows: what was called does not return.
            block.goes = [RETURN]
    for block in blocks.values():
        for target in block.goes:
            if target != RETURN and target not in blocks and target not in program.functions:
                raise Refused(f"{function.name}: {block.address:#x} goes to {target:#x}, where no function begins")
    function.blocks = blocks
