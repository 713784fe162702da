#!/usr/bin/env python3
"""Makes every picture of the documents from this checkout, and checks that they show what it computes.

    docs/pictures.py [NAME...]              makes all of them, or some of report, desk, film, grinding, compare, watch, python, linuxcnc
    docs/pictures.py --check PAGE.html      PAGE.html is the report that `cargo run --release` leaves: the README, docs/dynamic.md and
                                            the pictures have the figures that are printed there

A picture of a page carries what the page says as text in the PNG (keyword Description), so that it cannot be parted from it.
Needs what the checks need: Chromium and desk/node_modules (desk/build.sh), QEMU for compare, LinuxCNC for linuxcnc.
SPDX-License-Identifier: MIT OR Apache-2.0
"""

import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
SIMULATOR = TARGET / "release/firmware-sim"
SIGNATURE = b"\x89PNG\r\n\x1a\n"
KEYWORD = b"Description"
MOST_BYTES_OF_THE_FILM = 600_000
RUNS = ("uncorrected", "corrected", "servo alone", "everything on")
COMPARE = """compare --machine firmware-sim/cortex-m/machine --program short-tour --rate-hz 1000 --drill
    --exchange-at 12000 --second firmware-sim/cortex-m/machine/warm.toml""".split()


def run(*command, cwd=ROOT, **variables):
    subprocess.run([str(word) for word in command], cwd=cwd, env=os.environ | variables, check=True)


def shown(*command):
    """What docs/pictures.mjs prints."""
    return subprocess.check_output(["node", DOCS / "pictures.mjs", *command], cwd=ROOT, text=True).strip()


# Pictures with their words.


def chunks(png):
    at = len(SIGNATURE)
    while at < len(png):
        [length] = struct.unpack_from(">I", png, at)
        yield png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        at += 12 + length


def chunk(kind, content):
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def tell(path, text):
    """Puts a text into a PNG, as UTF-8 (iTXt)."""
    parts = [(kind, content) for kind, content in chunks(path.read_bytes()) if kind not in (b"tEXt", b"iTXt")]
    said = KEYWORD + b"\0\0\0\0\0" + text.encode()
    path.write_bytes(SIGNATURE + b"".join(chunk(*part) for part in [parts[0], (b"iTXt", said), *parts[1:]]))


def told(path):
    """The text in a PNG."""
    for kind, content in chunks(path.read_bytes()):
        if kind == b"iTXt" and content.startswith(KEYWORD + b"\0"):
            return content[len(KEYWORD) + 5 :].decode()
    sys.exit(f"{path.relative_to(ROOT)}: found no {KEYWORD.decode()}, needed a picture that docs/pictures.py made")


# How each is made.


def page(name, picture, first, last, *command):
    """A picture of a report, from one element to another, both by CSS selectors."""
    with tempfile.TemporaryDirectory() as folder:
        run("cargo", "build", "--release", "-p", "firmware-sim")
        run(SIMULATOR, *command, "--report", folder)
        text = shown("page", f"{folder}/{name}.html", DOCS / picture, first, last)
    tell(DOCS / picture, text)


def desk():
    tell(DOCS / "desk.png", shown("desk", DOCS / "desk.png"))


def film():
    with tempfile.TemporaryDirectory() as folder:
        shown("film", folder)
        film = animation(Path(folder))
    if len(film) > MOST_BYTES_OF_THE_FILM:
        sys.exit(f"docs/scope.webp: found {len(film)} bytes, needed at most {MOST_BYTES_OF_THE_FILM}")
    (DOCS / "scope.webp").write_bytes(film)


def animation(folder):
    """One WebP that repeats the frames of a folder (developers.google.com/speed/webp/docs/riff_container)."""

    def part(kind, content):
        return kind + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)

    def three(number):
        return struct.pack("<I", number)[:3]

    def image(webp):
        """The image of a still WebP, without its header."""
        return b"".join(part(kind, content) for kind, content in riff(webp) if kind in (b"VP8 ", b"VP8L"))

    given = json.loads((folder / "frames.json").read_text())
    header = b"\x02\0\0\0" + three(given["width"] - 1) + three(given["height"] - 1)
    content = b"WEBP" + part(b"VP8X", header) + part(b"ANIM", struct.pack("<IH", 0xFFFFFFFF, 0))
    for frame in given["frames"]:
        place = [frame["x"] // 2, frame["y"] // 2, frame["width"] - 1, frame["height"] - 1, frame["ms"]]
        # 2: the frame replaces what is below it.
        content += part(b"ANMF", b"".join(map(three, place)) + b"\x02" + image((folder / frame["name"]).read_bytes()))
    return b"RIFF" + struct.pack("<I", len(content)) + content


def riff(webp):
    at = 12
    while at < len(webp):
        [length] = struct.unpack_from("<I", webp, at + 4)
        yield webp[at : at + 4], webp[at + 8 : at + 8 + length]
        at += 8 + length + length % 2


def watch():
    run("cargo", "test", "-p", "trueaxis", "--lib", "a_resonance_that_the_feedback_excites", UPDATE_DOCS="1")


def python():
    """The notebooks of the Python package. Its tests build the module and install what the notebooks need."""
    package = ROOT / "crates/trueaxis-py"
    if not (TARGET / "python/bin/python").exists():
        run(package / "test.sh")
    code = (
        "import nbformat, sys; from nbclient import NotebookClient; "
        "NotebookClient(nbformat.read(sys.argv[1], 4), timeout=900, resources={'metadata': {'path': '.'}}).execute()"
    )
    for folder, name in ((package, "notebook.ipynb"), (package / "fleet", "fleet.ipynb"), (package / "fleet", "part.ipynb")):
        run(TARGET / "python/bin/python", "-c", code, name, cwd=folder)


PICTURES = {
    "report": lambda: page("index", "report.png", "h1", "section:has-text('Path with magnified deviations') figure >> nth=1", "run"),
    "grinding": lambda: page("grind", "grinding.png", "section:has-text('Roundness, revolution')", "section:has-text('The surface') .figures", "grind"),
    "compare": lambda: page("compare", "compare.png", "h1", "section figure >> nth=3", *COMPARE),
    "desk": desk,
    "film": film,
    "watch": watch,
    "python": python,
    "linuxcnc": lambda: run(ROOT / "integrations/linuxcnc/plots.sh"),
}


# Whether they are of today.


def rows(lines):
    """Largest and RMS error of every run, as printed, from the lines of a page: cells apart by tabs."""
    found = {}
    for line in lines:
        name, *figures = line.split("\t")
        # The first table of a page is that of the tip.
        if name in RUNS and len(figures) >= 2:
            found.setdefault(name, tuple(figures[:2]))
    return found


def report_of(path):
    """The rows and sentences of a report, as docs/pictures.mjs reads them."""
    said = lambda element: " ".join("".join(element.itertext()).split())
    lines = []
    for element in ElementTree.parse(path).iter():
        if element.tag == "tr":
            lines.append("\t".join(map(said, element)))
    return lines


def same(found, printed):
    """Whether a figure of a document is one of the page, which may have more digits."""
    digits = len(found.partition(".")[2])
    return abs(float(found) - float(printed)) <= 0.5 * 10**-digits + 0.5 * 10 ** -len(printed.partition(".")[2]) + 1e-12


def check(path):
    made = rows(report_of(path))
    if set(made) != set(RUNS):
        sys.exit(f"{path}: found rows of {sorted(made)}, needed {', '.join(RUNS)}")
    wrong = []

    def needed(place, run, found):
        if not all(map(same, found, made[run])):
            wrong.append(f"{place}: {run}: found {'; '.join(found)}, needed {'; '.join(made[run])}")

    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for run in RUNS:
        figures = re.search(rf"^\| (?:contour error )?{run}\b[^|]*\| ([\d.]+); ([\d.]+)", readme, re.M)
        needed("README.md", run, figures.groups() if figures else ("nan", "nan"))
    row = re.search(r"^\| circle-diamond-square ((?:\| [\d.]+; [\d.]+ ){3})\|", (DOCS / "dynamic.md").read_text(encoding="utf-8"), re.M)
    figures = re.findall(r"[\d.]+", row[1]) if row else ["nan"] * 6
    for k, run in enumerate(RUNS[1:]):
        needed("docs/dynamic.md", run, figures[2 * k : 2 * k + 2])
    for picture in ("report.png", "desk.png"):
        drawn = rows(told(DOCS / picture).splitlines())
        for run in RUNS:
            needed(f"docs/{picture}", run, drawn.get(run, ("nan", "nan")))
    # The sentence of this page is in docs/commands.md, where a test compares it with the command.
    said = next((line for line in told(DOCS / "grinding.png").splitlines() if line.startswith("Corrected, ")), "no such sentence")
    if f"\n    {said}\n" not in (DOCS / "commands.md").read_text(encoding="utf-8"):
        wrong.append(f"docs/grinding.png: found {said!r}, needed the sentence of docs/commands.md")
    for line in wrong:
        print(line)
    if wrong:
        sys.exit("docs/pictures.py makes the pictures again")
    print(f"pictures and documents have the figures of {path}")


def main():
    words = sys.argv[1:]
    if words[:1] == ["--check"] and len(words) == 2:
        return check(Path(words[1]))
    if unknown := [word for word in words if word not in PICTURES]:
        sys.exit(f"usage: docs/pictures.py [--check PAGE.html | NAME...]; found {unknown[0]!r}, needed some of {', '.join(PICTURES)}")
    for name in words or PICTURES:
        print(f"--- {name}", flush=True)
        PICTURES[name]()
    return None


if __name__ == "__main__":
    main()
