#!/usr/bin/env python3
"""Checks the documents: docs/check.py, from any folder.

- Every relative link and every #anchor in the documents at the root, in docs, and in the README files leads somewhere.
- Every page in docs is in docs/SUMMARY.md, and every page there exists.
- Every command of trueaxis and firmware-sim in a code block names a subcommand and flags of docs/commands.md, and the flags
  are arguments in the program's sources.
- Every page in docs/controllers has the same headings, in the same order.
- A code block below `<!-- from FILE -->` is in that file, line by line.
- A run of the simulator has one name: the other names it has had are in no document.

Prints one line for every defect and exits with 1 if there are any. SPDX-License-Identifier: MIT OR Apache-2.0
"""

import re
import sys
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PROGRAMS = {"trueaxis": "crates/trueaxis-cli/src", "firmware-sim": "firmware-sim/src"}
# [text](target), ![text](target); a text may contain `code` and one level of brackets.
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\[\]]*\])*\]\(([^()\s]+)\)")
INCLUDE = re.compile(r"\{\{#include ([^}\s]+)\}\}")
GUIDE = ["What you need", "Install", "Configure", "First corrected move", "Check that it works", "When something is wrong"]
FLAG = re.compile(r"--[a-z][a-z0-9-]*")
# Names that a run had, and the one it has in command line, reports, desk and documents.
RETIRED = {"without compensation": "uncorrected", "with compensation": "corrected", "perfect geometry": "servo alone", "full run": "everything on"}


def documents():
    globs = ("*.md", "*/README.md", "docs/**/*.md", "crates/*/README.md", "integrations/*/*.md", "tests/*/README.md")
    return sorted({path for glob in globs for path in ROOT.glob(glob) if path.name != "SUMMARY.md"})


def lines_of(path):
    """Line number, text and whether it is code, of every line."""
    code, fence, blank = [], None, True
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        mark = re.match(r" {0,3}(```+)", line)
        if mark and fence in (None, mark[1]):
            fence, blank = (None if fence else mark[1]), True
            code.append((number, line, None))
            continue
        # Indented by four spaces after a blank line, or after such a line.
        indented = fence is None and line.startswith("    ") and (blank or code[-1][2] is True)
        code.append((number, line, fence is not None or indented))
        blank = not line.strip()
    return code


def without_spans(line):
    """The line without its `code`, whose brackets are no links; the length stays."""
    return re.sub(r"`[^`]*`", lambda span: "x" * len(span[0]), line)


def anchors(path):
    """The ids of a page's headings, as mdBook and the forges make them."""
    found = set()
    for _, line, code in lines_of(path):
        if code is False and (heading := re.match(r"#{1,6} +(.*)", line)):
            text = LINK.sub(lambda link: link[0].split("](")[0].lstrip("!["), heading[1]).strip()
            slug = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
            repeat = next(n for n in range(100) if (f"{slug}-{n}" if n else slug) not in found)
            found.add(f"{slug}-{repeat}" if repeat else slug)
        found |= set(re.findall(r'<a id="([^"]+)"', line)) if not code else set()
    return found


def check_links(path):
    for number, line, code in lines_of(path):
        if code is not False:
            continue
        for target in LINK.findall(without_spans(line)) + INCLUDE.findall(line):
            if re.match(r"[a-z]+:", target):
                continue
            name, _, anchor = target.partition("#")
            file = (path.parent / name).resolve() if name else path
            if not file.exists():
                yield number, f"found a link to {target}, needed a file that exists"
            elif anchor and file.suffix == ".md" and anchor not in anchors(file):
                yield number, f"found a link to {target}, needed a heading of that page"


def check_names(path):
    for number, line, _ in lines_of(path):
        for name, needed in RETIRED.items():
            if name in line.lower():
                yield number, f"found {name}, needed {needed}"


def check_summary():
    summary = DOCS / "SUMMARY.md"
    listed = LINK.findall(summary.read_text(encoding="utf-8"))
    for name in listed:
        if not (DOCS / name).is_file():
            yield summary, 0, f"found {name}, needed a page that exists"
        if listed.count(name) > 1:
            yield summary, 0, f"found {name} twice, needed it once"
    for path in sorted(DOCS.rglob("*.md")):
        if path != summary and path.relative_to(DOCS).as_posix() not in listed:
            yield path, 0, "found a page that is not in docs/SUMMARY.md"


def commands(path):
    """Line number, program and words of every command of ours in a page's code."""
    joined, start = "", 0
    for number, line, code in lines_of(path):
        if not code:
            joined = ""
            continue
        start = start if joined else number
        joined += line.strip()
        if joined.endswith("\\"):
            joined = joined[:-1]
            continue
        # A comment ends a command; so do a pipe and a list.
        for part in re.split(r"\s+#\s|&&|\|\|?|;", joined.removeprefix("$ ")):
            # Words are apart by one blank; a diagram has more.
            words = [] if re.match(r"\s*\S+  ", part) else part.split()
            if words[:2] == ["cargo", "run"] and "--" in words:
                program = words[words.index("-p") + 1] if "-p" in words else "firmware-sim"
                program = {"trueaxis-cli": "trueaxis"}.get(program, program)
                words = [program, *words[words.index("--") + 1 :]]
            if words and words[0] in PROGRAMS:
                yield start, words[0], words[1:]
        joined = ""


def subcommands(program):
    """First words, and pairs of words, that docs/commands.md has after a program's name."""
    text = (DOCS / "commands.md").read_text(encoding="utf-8")
    text = text.replace("cargo run --release --", "firmware-sim")
    return set(re.findall(rf"\b{program} ([a-z][a-z-]*(?: [a-z][a-z-]*)?)", text))


@cache
def sources(program):
    return "".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / PROGRAMS[program]).rglob("*.rs")))


@cache
def is_argument(flag, program):
    """Whether a program has the flag: a field of its arguments, or a name stated beside one."""
    field = flag[2:].replace("-", "_")
    return re.search(rf'\b{field}\s*:|long = "{flag[2:]}"|--{flag[2:]}\b', sources(program)) is not None


def check_commands(path, known, flags):
    for number, program, words in commands(path):
        word = words[0] if words else "--help"
        if not word.startswith("-") and re.fullmatch(r"[a-z-]+", word):
            pairs = {pair for pair in known[program] if pair.startswith(f"{word} ")}
            if word not in {pair.split()[0] for pair in known[program]}:
                yield number, f"found {program} {word}, needed a subcommand of docs/commands.md"
            elif program == "trueaxis" and word in GROUPS and f"{word} {words[1] if len(words) > 1 else ''}" not in pairs:
                yield number, f"found {program} {' '.join(words[:2])}, needed a subcommand of docs/commands.md"
        for flag in FLAG.findall(" ".join(words)):
            if flag not in flags:
                yield number, f"found {program} {word} {flag}, needed a flag of docs/commands.md"
            elif flag not in GIVEN and not is_argument(flag, program):
                yield number, f"found {program} {word} {flag}, needed an argument of the program"


# Flags that every program has.
GIVEN = {"--help", "--version"}
# Commands of trueaxis whose second word is a command too.
GROUPS = ("tables", "calibrate", "keep", "evaluate", "thermal", "kinematics")


def check_guide(path):
    """A page of a controller has the headings of all of them."""
    found = [line[3:] for _, line, code in lines_of(path) if code is False and line.startswith("## ")]
    if path.parent == DOCS / "controllers" and found[: len(GUIDE)] != GUIDE:
        yield 0, f"found the headings {found[: len(GUIDE)]}, needed {GUIDE}"


def check_quoted(path):
    """Code that a page takes from a file is there."""
    wanted = None
    block = []
    for number, line, code in lines_of(path):
        if mark := re.fullmatch(r"<!-- from (\S+) -->", line):
            wanted, block = (ROOT / mark[1], number), []
        elif wanted and code:
            block.append(line.rstrip())
        elif wanted and block:
            file, at = wanted
            text = "\n" + "\n".join(line.rstrip() for line in file.read_text(encoding="utf-8").splitlines()) + "\n"
            if "\n" + "\n".join(block) + "\n" not in text:
                yield at, f"found other code than in {file.relative_to(ROOT)}, needed the same lines"
            wanted = None
    if wanted:
        yield wanted[1], "found no code block that ends below, needed one"


def main():
    defects = list(check_summary())
    page = DOCS / "commands.md"
    known = {program: subcommands(program) for program in PROGRAMS}
    flags = set(FLAG.findall(page.read_text(encoding="utf-8"))) | GIVEN
    for path in documents():
        found = [*check_links(path), *check_commands(path, known, flags), *check_guide(path), *check_quoted(path), *check_names(path)]
        defects += [(path, number, text) for number, text in found]
    for path, number, text in defects:
        print(f"{path.relative_to(ROOT)}{f':{number}' if number else ''}: {text}", file=sys.stderr)
    if not defects:
        print(f"{len(documents())} documents: links, pages, commands and quoted code are right")
    return 1 if defects else 0


if __name__ == "__main__":
    sys.exit(main())
