#!/usr/bin/env python3
"""Writes the gallery's notebooks and its page from the scripts in gallery/.

    gallery.py            writes gallery/*.ipynb, docs/gallery.md and docs/gallery/*.svg; runs every script
    gallery.py --check    fails where a file is not what the scripts give; drawn numbers may differ by what rounding does

A script begins with a docstring: its question, and a sentence on the answer. Needs the module and what its tests need.
"""

import contextlib
import io
import json
import os
import re
import runpy
import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
DOCS = ROOT / "docs"
SCRIPTS = sorted((HERE / "gallery").glob("*.py"))
# A number of a figure or of printed text may differ by this much of its size, or by this much.
SHARE, LEAST = 1e-3, 0.02
LOOK = {"figure.figsize": (6, 3.4), "svg.hashsalt": "trueaxis", "svg.fonttype": "none", "path.simplify_threshold": 0.5, "savefig.bbox": "tight"}
HEAD = """\
# Questions to Python

Each of these is a script in [crates/trueaxis-py/gallery](../crates/trueaxis-py/gallery), and a notebook beside it; both run in the repository. Install the module first: `pip install .` in the repository's root ([more](included/python.md)).
"""


def parts(script):
    """Question, answer and code of a script."""
    text = script.read_text(encoding="utf-8")
    said, code = re.match(r'"""(.*?)"""\n+(.*)', text, re.DOTALL).groups()
    question, mark, answer = said.partition("?")
    return question + mark, answer.strip(), code.rstrip()


def notebook(script):
    """The script as a notebook without outputs, by its comments cut into cells."""
    question, answer, code = parts(script)
    cells = [("markdown", f"# {question}\n\n{answer}"), ("code", "%cd -q ../../..\n%matplotlib inline")]
    cells += [("code", code)]

    def cell(number, kind, source):
        own = {"cell_type": kind, "id": f"{script.stem[:2]}-{number}", "metadata": {}, "source": source.splitlines(keepends=True)}
        return own | ({"execution_count": None, "outputs": []} if kind == "code" else {})

    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}, "language_info": {"name": "python"}}
    made = {"cells": [cell(number, *of) for number, of in enumerate(cells)], "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(made, indent=1, ensure_ascii=False) + "\n"


def drawn(figure):
    """A figure as SVG without the date of its making."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None})
    return re.sub(r"[ \t]+$", "", out.getvalue(), flags=re.MULTILINE)


def made():
    """Texts of all files, by path."""
    texts, page = {}, HEAD
    os.chdir(ROOT)
    for script in SCRIPTS:
        texts[script.with_suffix(".ipynb")] = notebook(script)
        question, answer, code = parts(script)
        said = io.StringIO()
        with plt.rc_context(LOOK), contextlib.redirect_stdout(said):
            plt.close("all")
            runpy.run_path(str(script))
            figures = [drawn(plt.figure(number)) for number in plt.get_fignums()]
            plt.close("all")
        page += f"\n## {question}\n\n{answer}\n\n```python\n{code}\n```\n\n```text\n{said.getvalue().rstrip()}\n```\n"
        for number, figure in enumerate(figures, 1):
            name = f"{script.stem}{f'-{number}' if len(figures) > 1 else ''}.svg"
            texts[DOCS / "gallery" / name] = figure
            page += f"\n![{question}](gallery/{name})\n"
    texts[DOCS / "gallery.md"] = page
    return texts


NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def same(found, needed):
    """Whether two texts are the same but for the rounding of their numbers."""
    if NUMBER.sub("#", found) != NUMBER.sub("#", needed):
        return False
    pairs = zip(map(float, NUMBER.findall(found)), map(float, NUMBER.findall(needed)))
    return all(abs(a - b) <= LEAST + SHARE * abs(b) for a, b in pairs)


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    texts = made()
    if not sys.argv[1:]:
        (DOCS / "gallery").mkdir(exist_ok=True)
        for path, text in texts.items():
            path.write_text(text, encoding="utf-8")
        return
    there = {*(HERE / "gallery").glob("*.ipynb"), *(DOCS / "gallery").glob("*"), DOCS / "gallery.md"}
    wrong = [path for path in sorted(there | texts.keys()) if path not in texts or not path.exists() or not same(path.read_text(encoding="utf-8"), texts[path])]
    for path in wrong:
        print(f"{path.relative_to(ROOT)}: found another text than the scripts give, needed that of crates/trueaxis-py/gallery.py")
    sys.exit(bool(wrong))


main()
