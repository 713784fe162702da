#!/usr/bin/env python3
"""Lists files of a crate that import one another in a circle: `.ci/circles.py CRATE...`; exit code 1 if there is one.

An import is followed through re-exports to the file that defines the name. A module may use its own submodules, so an
arrow from a file to one below it does not count; an arrow upward, or to any other file, does. Tests are left out.
"""

import re
import sys
from pathlib import Path

DEFINITION = re.compile(
    r"^\s*(?:pub(?:\([^)]*\))?\s+)?(?:const |async |unsafe |extern \"C\" )*"
    r"(?:fn|struct|enum|trait|type|const|static|union|macro_rules!)\s+(\w+)",
    re.M,
)
USE = re.compile(r"^\s*(?:bench!\()?(?:pub(?:\([^)]*\))?\s+)?use\s+([^;]+?)\)?;", re.M)
DECLARATION = re.compile(r"^\s*(?:bench!\()?(?:pub(?:\([^)]*\))?\s+)?(?:use|mod)\s+[^;]+;", re.M)
PATH = re.compile(r"\b[A-Za-z_]\w*(?:::\w+)+")
IS_TEST = re.compile(r"(^|/)tests?(/|\.rs$)|_tests\.rs$")


def module_of(file):
    """The module path of a file below `src`."""
    parts = file[: -len(".rs")].split("/")
    if parts[-1] in ("mod", "lib", "main"):
        parts.pop()
    return tuple(parts)


def without_tests_and_comments(text):
    text = re.split(r"#\[cfg\(test\)\]\s*mod \w+ \{", text)[0]
    return "\n".join(line for line in text.split("\n") if not line.lstrip().startswith("//"))


def leaves(tree, prefix=()):
    """(path, alias) of every name in a `use` tree."""
    tree = tree.strip()
    if not tree:
        return
    if tree.endswith("}"):
        head, body = tree[:-1].split("{", 1)
        prefix = prefix + tuple(part.strip() for part in head.split("::") if part.strip())
        depth, start = 0, 0
        for index, letter in enumerate(body + ","):
            depth += (letter == "{") - (letter == "}")
            if letter == "," and depth == 0:
                yield from leaves(body[start:index], prefix)
                start = index + 1
        return
    path, _, alias = tree.partition(" as ")
    path = prefix + tuple(part.strip() for part in path.split("::"))
    if path[-1] == "self":
        path = path[:-1]
    yield path, alias.strip() or path[-1]


class Crate:
    def __init__(self, source):
        files = {str(p.relative_to(source)): p for p in sorted(source.rglob("*.rs"))}
        self.text = {f: without_tests_and_comments(p.read_text()) for f, p in files.items() if not IS_TEST.search(f)}
        self.file_of = {module_of(f): f for f in self.text}
        self.defined = {module_of(f): set(DEFINITION.findall(t)) for f, t in self.text.items()}
        self.used = {module_of(f): [leaf for tree in USE.findall(t) for leaf in leaves(tree)] for f, t in self.text.items()}

    def absolute(self, module, path):
        """A path as seen from a module, from the crate's root; None where it leads outside."""
        path, here = list(path), list(module)
        if path[0] == "crate":
            return tuple(path[1:])
        if path[0] == "self":
            return tuple(here + path[1:])
        if path[0] == "super":
            while path and path[0] == "super":
                here, path = here[:-1], path[1:]
            return tuple(here + path)
        if tuple(here + path[:1]) in self.file_of:
            return tuple(here + path)
        for used, alias in self.used[module]:
            if alias == path[0] and used != tuple(path):
                base = self.absolute(module, used) if used[0] in ("crate", "self", "super") else None
                return None if base is None else base + tuple(path[1:])
        return None

    def home(self, path, seen=()):
        """The file in which an absolute path is defined."""
        if path in self.file_of:
            return self.file_of[path]
        if not path or path in seen:
            return None
        module, name = path[:-1], path[-1]
        if module not in self.file_of:
            return self.home(module, (*seen, path))
        if name not in self.defined[module]:
            for used, alias in self.used[module]:
                if alias == name:
                    target = self.absolute(module, used)
                    if target is not None and target != path:
                        return self.home(target, (*seen, path))
        return self.file_of[module]

    def arrows(self):
        """For each file, the files that it uses, and by which names."""
        graph = {}
        for file, text in self.text.items():
            module = module_of(file)
            body = DECLARATION.sub("", text)
            paths = [path for path, alias in self.used[module] if re.search(rf"\b{re.escape(alias)}\b", body)]
            paths += [tuple(match.split("::")) for match in PATH.findall(body)]
            for path in paths:
                target = self.absolute(module, path)
                home = self.home(target) if target is not None else None
                below = home is not None and module_of(home)[: len(module)] == module
                if home is not None and home != file and not (below and file_is_parent(module, home)):
                    graph.setdefault(file, {}).setdefault(home, set()).add("::".join(path))
        return graph


def file_is_parent(module, other):
    return len(module_of(other)) > len(module)


def circles(graph):
    """Strongly connected sets of two files or more (Tarjan)."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph.get(node, {}):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            part = []
            while part[-1:] != [node]:
                part.append(stack.pop())
            if len(part) > 1:
                found.append(sorted(part))

    for node in list(graph):
        if node not in index:
            visit(node)
    return found


def main(crates):
    count = 0
    for crate in crates:
        graph = Crate(Path(crate) / "src").arrows()
        for circle in circles(graph):
            count += 1
            print(f"{crate}: circle of {len(circle)} files")
            for file in circle:
                for other in sorted(set(graph.get(file, {})) & set(circle)):
                    print(f"    {file} -> {other}: {', '.join(sorted(graph[file][other])[:6])}")
    print(f"{count} circles in {len(crates)} crates")
    return 1 if count else 0


if __name__ == "__main__":
    sys.setrecursionlimit(10_000)
    sys.exit(main(sys.argv[1:]))
