#!/usr/bin/env python3
"""Preprocessor of mdBook (book.toml): pages of the repository inside the book.

A line `{{#include ../../crates/trueaxis-capi/README.md}}` becomes that page, with its links seen from there. A link to a page
that the book includes leads to it; a link to another file of the repository leads to `git-repository-url` of book.toml, and
is plain text while there is none. Pictures outside docs are put into the page.
SPDX-License-Identifier: MIT OR Apache-2.0
"""

import base64
import json
import os
import re
import sys

from check import DOCS, INCLUDE, LINK, ROOT, lines_of, without_spans

TYPES = {".png": "image/png", ".svg": "image/svg+xml"}


def included():
    """The page of the book in which a file of the repository is."""
    pages = {}
    for page in DOCS.rglob("*.md"):
        for target in INCLUDE.findall(page.read_text(encoding="utf-8")):
            pages[(page.parent / target).resolve()] = page
    return pages


def destination(target, source, page, pages, url):
    """A link of the file `source`, seen from `page`; None where it leads nowhere."""
    name, mark, anchor = target.partition("#")
    if re.match(r"[a-z]+:", target) or not name:
        return target
    file = (source.parent / name).resolve()
    if file.is_dir() and (file / "README.md").resolve() in pages:
        file = file / "README.md"
    file = pages.get(file, file)
    if DOCS in file.parents:
        # mdBook writes README.md as index.html.
        file = file.with_name("index.md") if file.name == "README.md" else file
        return os.path.relpath(file, page.parent) + mark + anchor
    if file.suffix in TYPES:
        return f"data:{TYPES[file.suffix]};base64,{base64.b64encode(file.read_bytes()).decode()}"
    return f"{url.rstrip('/')}/blob/main/{file.relative_to(ROOT)}{mark}{anchor}" if url else None


def rewritten(source, page, pages, url):
    """The text of a page or of an included file."""
    text = []
    for _, line, code in lines_of(source):
        if include := INCLUDE.fullmatch(line):
            text.append(rewritten((source.parent / include[1]).resolve(), page, pages, url))
            continue
        if code is False:
            plain = without_spans(line)
            for link in reversed(list(LINK.finditer(plain))):
                to = destination(link[1], source, page, pages, url)
                start, end = link.span(1)
                if to is None:
                    label = line[link.start() + 1 : start - 2]
                    line = line[: link.start()] + label + line[link.end() :]
                else:
                    line = line[:start] + to + line[end:]
        text.append(line)
    return "\n".join(text)


def chapters(value):
    """Every chapter of a book, in whatever form this version of mdBook nests them."""
    if isinstance(value, dict):
        if "Chapter" in value:
            yield value["Chapter"]
        for inner in value.values():
            yield from chapters(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from chapters(inner)


def main():
    if sys.argv[1:2] == ["supports"]:
        return 0
    context, book = json.load(sys.stdin)
    url = context["config"].get("output", {}).get("html", {}).get("git-repository-url", "")
    pages = included()
    for chapter in chapters(book):
        if name := chapter.get("source_path"):
            page = DOCS / name
            chapter["content"] = rewritten(page, page, pages, url)
    json.dump(book, sys.stdout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
