"""What comments of the source state about loops and paths, and to which instructions of a program that applies."""

import re
import subprocess
from functools import cache
from pathlib import Path

from thumb import Refused

ROUNDS = re.compile(r"//.*\bAt most (\w+) rounds?\b(?: without (\w+), else (\w+))?")
TAKES = re.compile(r"//.*\bTakes (\w+) of at most (\w+) (\w+) in one step\b")
ONLY = re.compile(r"//.*\bOnly with (\w+)\b")
NEVER_BOTH = re.compile(r"//.*\bNever both (\w+) and (\w+) in one step\b")
LOOP = re.compile(r"\b(?:for\b(?!\s*<)[^;{}]*?\bin\b|while\b|loop\b)")
FUNCTION = re.compile(r"\bfn\s+\w+")
ITEM = re.compile(r"(?:pub\b[^a-z]*\S*\s+)?(?:unsafe\s+|const\s+)*(?:fn|impl)\b")
# Comments, strings and characters, which may have braces in them.
QUIET = re.compile(r'//[^\n]*|/\*.*?\*/|r?"(?:\\.|[^"\\])*"|b?\'(?:\\[^\n\']+|[^\\\'\n])\'', re.S)


class Frame:
    """A function, inlined or not, and a place in it."""

    __slots__ = ("function", "path", "line", "column")

    def __init__(self, function, path, line, column):
        self.function, self.path, self.line, self.column = function, path, line, column

    def key(self):
        return self.function, self.path, self.line, self.column


class Frames:
    """Frames of the instructions of a program, from its line table."""

    def __init__(self, elf, sources):
        command = ["llvm-symbolizer", f"--obj={elf}", "--functions=linkage", "--demangle", "--inlines"]
        self._asked = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._sources, self._known = sources, {}

    def at(self, address):
        """Frames of an address, the outermost first."""
        if address not in self._known:
            self._asked.stdin.write(f"{address:#x}\n")
            self._asked.stdin.flush()
            lines = []
            while line := self._asked.stdout.readline().strip():
                lines.append(line)
            stack = []
            for function, place in zip(lines[::2], lines[1::2]):
                path, line, column = place.rsplit(":", 2)
                function = re.sub(r"::h[0-9a-f]{16}$", "", function)
                stack.append(Frame(function, self._sources.own(path), int(line), int(column)))
            self._known[address] = stack[::-1]
        return self._known[address]


class Place:
    """Where a loop is: path and line, whether it is a loop of the text, and the loops of the text around it."""

    def __init__(self, path, line, is_loop, outer):
        self.at, self.is_loop, self.outer = (path, line), is_loop, outer
        self.text = f"{path}:{line}"


class Source:
    """A file of the repository."""

    def __init__(self, path, root):
        self._marks = {}
        text = (Path(root) / path).read_text(encoding="utf-8")
        self.path, self.lines = path, text.splitlines()
        quiet = QUIET.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
        self.quiet, self.code = quiet, quiet.splitlines()
        self._starts = [0] + [at + 1 for at, c in enumerate(text) if c == "\n"]
        self.loops = sorted(filter(None, (self._extent(found.start()) for found in LOOP.finditer(quiet))))
        self.functions = sorted(filter(None, (self._extent(found.start()) for found in FUNCTION.finditer(quiet))))

    def _line(self, at):
        return self.quiet.count("\n", 0, at) + 1

    def _extent(self, at):
        """First and last line of what begins at a place and ends with its braces, or before them with a semicolon."""
        item = ITEM.match(self.quiet, at)
        depth = inside = 0
        for k in range(at, len(self.quiet)):
            c = self.quiet[k]
            if c in "([":
                inside += 1
            elif c in ")]":
                inside -= 1
                if inside < 0:
                    return self._line(at), self._line(k)
            elif c == "{":
                depth += 1
            elif c == "}":
                depth -= 1
                if depth < 0 or depth == 0 and inside == 0:
                    return self._line(at), self._line(k)
            elif (c == ";" or c == "," and not item) and depth == 0 and inside == 0:
                return self._line(at), self._line(k)
        return None

    def statement(self, line):
        """First line of the statement with a line."""
        while line > 1 and self.code[line - 2].strip() and not re.search(r"[;{}]\s*$", self.code[line - 2]):
            line -= 1
        return line

    def above(self, line, pattern):
        """What a comment on a line, or directly above it, states."""
        if found := pattern.search(self.lines[line - 1]):
            return found
        while line > 1 and re.match(r"\s*(//|#\[)", self.lines[line - 2]):
            line -= 1
            if found := pattern.search(self.lines[line - 1]):
                return found
        return None

    def function(self, line):
        """First and last line of the innermost function with a line."""
        around = [extent for extent in self.functions if extent[0] <= line <= extent[1]]
        return max(around, default=None)

    def around(self, first, last):
        """First lines of the loops with both lines, in their function, the innermost last."""
        begin = (self.function(first) or (0, 0))[0]
        return [extent[0] for extent in self.loops if begin <= extent[0] <= first and last <= extent[1]]

    def value(self, name, given, path, line):
        """A number, or a constant of this file, or of the command line."""
        if name.isdigit():
            return int(name)
        if name in given:
            return given[name]
        found = re.search(rf"\bconst {name}: \w+ = ([\d_]+);", self.quiet)
        if not found:
            raise Refused(f"{path}:{line}: found {name}, needed a number, a constant of this file or --let {name}=NUMBER")
        return int(found[1].replace("_", ""))

    def function_line(self, line):
        """The name of the innermost function with a line, or the line."""
        extent = self.function(line)
        return re.search(r"fn\s+(\w+)", self.lines[extent[0] - 1])[1] if extent else line

    def marked(self, pattern):
        """First and last line of everything that a comment marks, and what it says."""
        if pattern not in self._marks:
            self._marks[pattern] = [
                (self._extent(self._after(number)), pattern.search(line), number)
                for number, line in enumerate(self.lines, 1)
                if pattern.search(line)
            ]
        return self._marks[pattern]

    def _after(self, number):
        """Where the code begins that a comment in a line is about: in that line, or after the comments below it."""
        while re.match(r"\s*(//|#\[)", self.lines[number - 1]):
            number += 1
        line = self.lines[number - 1]
        return self._starts[number - 1] + len(line) - len(line.lstrip())


class Sources:
    """Files of the repository and what the command line states besides."""

    def __init__(self, root, given, built):
        """`built`: time of the program, in seconds."""
        self.root, self.given, self.built, self._files = root, given, built, {}

    def file(self, path):
        if path not in self._files:
            if (Path(self.root) / path).stat().st_mtime > self.built:
                raise Refused(f"{path}: found a source newer than the program, whose lines may have moved")
            self._files[path] = Source(path, self.root)
        return self._files[path]

    @cache
    def own(self, path):
        """Path of a file of the repository, or None; the compiler writes folders by other names."""
        path = path.rsplit("/./", 1)[-1].removeprefix("./").removeprefix(f"{self.root}/")
        return path if not path.startswith("/") and (Path(self.root) / path).is_file() else None

    def place(self, stacks):
        """Where the loop over instructions with these frames is in the source, or None if that has no source here.

        The loop is in the innermost function, inlined or not, that all instructions have in common: the innermost loop of
        its text around all their lines, or, where that function is not of the repository, the statement that calls it.
        """
        stacks = [stack for stack in stacks if stack and stack[-1].line]
        if not stacks:
            return None
        depth = 0
        while all(len(s) > depth + 1 for s in stacks) and len({(s[depth].key(), s[depth + 1].function) for s in stacks}) == 1:
            depth += 1
        own = depth
        while own >= 0 and stacks[0][own].path is None:
            own -= 1
        if own < 0:
            return None
        path = stacks[0][own].path
        lines = [stack[own].line for stack in stacks if stack[own].line]
        around = self.file(path).around(min(lines), max(lines))
        callers = [frame for frame in stacks[0][:own] if frame.path]
        outer = [(one.path, line) for one in callers for line in self.file(one.path).around(one.line, one.line)]
        if own == depth and around:
            *rest, line = around
        else:
            rest, line = around, self.file(path).statement(min(lines))
        return Place(path, line, own == depth and bool(around), [*outer, *((path, one) for one in rest)])

    def rounds(self, place, without):
        """Rounds that the source states for a loop, or None."""
        path, line = place
        source = self.file(path)
        found = source.above(line, ROUNDS)
        if not found:
            return None
        stated = found[1] if not found[2] or found[2] in without else found[3]
        return source.value(stated, self.given, path, line)

    def takes(self, stack):
        """What the function takes whose first instruction has these frames: number, most, name; or None."""
        if not stack or not stack[0].path:
            return None
        path, source = stack[0].path, self.file(stack[0].path)
        for extent, found, number in source.marked(TAKES):
            # Not a closure in it.
            name = extent and re.search(r"\bfn (\w+)", source.lines[extent[0] - 1])
            if name and extent[0] <= stack[0].line <= extent[1] and stack[0].function.split("::")[-1] == name[1]:
                taken, most = (source.value(one, self.given, path, number) for one in found.group(1, 2))
                return taken, most, found[3]
        return None

    def never_both(self):
        """Pairs of parts that never meet in a step, of all files read so far."""
        lines = (line for source in self._files.values() for line in source.lines)
        return sorted({found.group(1, 2) for line in lines if (found := NEVER_BOTH.search(line))})

    def only(self, stack):
        """Names that the source marks the code of a stack of frames with."""
        return {name for frame in stack if frame.path for name in self._only(frame.path, frame.line)}

    @cache
    def _only(self, path, line):
        marked = self.file(path).marked(ONLY)
        return frozenset(found[1] for extent, found, _ in marked if extent and extent[0] <= line <= extent[1])
