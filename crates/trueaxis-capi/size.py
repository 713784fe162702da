#!/usr/bin/env python3
"""What the library takes of flash, by parts and optimisation, on a Cortex-M4F in single precision.

    size.py                  builds everything and prints the table
    size.py --commit         writes sizes.toml as well
    size.py --write PAGE...  puts the table of sizes.toml between the markers `sizes` of the pages
    size.py --check PAGE...  builds the rows marked `checked`; fails where one has grown by more than 2 % or shrunk by more
                             than 5 % (a figure that is no limit any more), or where a page holds another table

Flash is code, constants and the initial values of variables. `whole`: a program that calls every function of the header.
`small`: examples/c/small.c, which loads tables, measures against a path of lines and sends records. `rust`: the same
firmware in Rust on `McuServo<3>`, small.rs. All link with --gc-sections and nothing but the library.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "flash"
TRIPLE = "thumbv7em-none-eabihf"
COMMITTED = HERE / "sizes.toml"
BEGIN, END = "<!-- sizes -->\n", "<!-- /sizes -->\n"
GROWN, STALE = 1.02, 0.95

ALL = "grids,volumetric,rotary,dynamic,gauge,curves,toolpath,growth"
# Name, features beside `single`, optimisations that are measured, those that --check builds.
ROWS = [
    ("three to six axes, everything", f"{ALL},text,fast", "z", ""),
    ("three axes, everything", f"three,{ALL},text,fast", "3sz", "z"),
    ("… one copy of the step (without `fast`)", f"three,{ALL},text", "z", ""),
    ("… and without `text`", f"three,{ALL}", "z", ""),
    ("three axes, nine terms, lines and curves, records", "three,curves", "z", ""),
    ("three axes, nine terms, lines, records", "three", "3sz", "z"),
]
COLUMNS = [("3", "speed"), ("s", "size, `s`"), ("z", "size, `z`")]
CPU = "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -DTRUEAXIS_SINGLE".split()
# What a board has: nothing, so that only the library counts.
BOARD = """
const unsigned char tables[1] = { 0 }, tables_end[1] = { 0 };
void read_machine(void *input) { (void)input; }
void write_drives(const void *drive) { (void)drive; }
void send(const unsigned char *bytes, unsigned count) { (void)bytes; (void)count; }
#ifndef RUST
int start(const double *from, const double *to);
void servo_interrupt(double u);
void reset(void) {
    static const double from[3] = { 0 }, to[3] = { 1 };
    start(from, to);
    for (;;) servo_interrupt(0.5);
}
#endif
"""
# The crate of small.rs, made in the target directory: as a static library it has no other use.
RUST = """
[package]
name = "small"
version = "0.1.0"
edition = "2024"

[lib]
crate-type = ["staticlib"]
path = {path}

[dependencies]
trueaxis = {{ path = {core}, default-features = false, features = {features} }}

[profile.flash]
inherits = "release"
opt-level = {level}
lto = "fat"
codegen-units = 1
panic = "abort"

[workspace]
"""
OF_THE_CORE = "grids volumetric rotary dynamic gauge curves text fast".split()


def level_of(opt):
    return f'"{opt}"' if opt in "sz" else opt


def built(command, folder):
    environment = {**os.environ, "CARGO_TARGET_DIR": str(TARGET), "CARGO_INCREMENTAL": "0"}
    subprocess.run(command, cwd=folder, check=True, env=environment)


def rust_library(features, opt):
    folder = TARGET / "rust"
    folder.mkdir(exist_ok=True)
    core = [feature for feature in features.split(",") if feature in OF_THE_CORE]
    paths = {"path": json.dumps(str(HERE / "small.rs")), "core": json.dumps(str(ROOT / "crates/trueaxis"))}
    (folder / "Cargo.toml").write_text(RUST.format(features=json.dumps(core), level=level_of(opt), **paths))
    # The workspace's versions; cargo drops those that are not needed.
    shutil.copy(ROOT / "Cargo.lock", folder / "Cargo.lock")
    built(["cargo", "build", "--quiet", "--profile", "flash", "--target", TRIPLE], folder)
    return TARGET / TRIPLE / "flash/libsmall.a"


def library(features, opt):
    level = level_of(opt)
    overrides = [f"profile.flash.opt-level={level}"]
    overrides += [f"profile.flash.package.{name}.opt-level={level}" for name in ("trueaxis", "trueaxis-capi", "trueaxis-sqrt")]
    # As a static library alone: with a Rust library beside it cargo cannot optimise at linking.
    command = ["cargo", "rustc", "--quiet", "-p", "trueaxis-capi", "--lib", "--crate-type", "staticlib", "--profile", "flash"]
    command += ["--target", TRIPLE, "--no-default-features", "--features", f"single,{features}"]
    for override in overrides:
        command += ["--config", override]
    built(command, ROOT)
    return TARGET / TRIPLE / "flash/libtrueaxis_capi.a"


def linked(name, sources, archive, keep=(), defines=()):
    image = TARGET / f"{name}.elf"
    command = ["arm-none-eabi-gcc", "-std=c99", "-Os", "-ffunction-sections", *CPU, *defines, f"-I{HERE / 'include'}", *map(str, sources)]
    command += [f"-Wl,-u,{symbol}" for symbol in keep]
    command += [str(archive), "-nostdlib", "-lgcc", "-Wl,--gc-sections,-e,reset,-Ttext=0,-z,noexecstack,--no-warn-rwx-segments"]
    subprocess.run([*command, "-o", str(image)], check=True)
    listed = subprocess.run(["arm-none-eabi-size", str(image)], check=True, capture_output=True, text=True).stdout
    text, data, bss, *_ = listed.splitlines()[1].split()
    return int(text) + int(data), int(data) + int(bss)


def measured(features, opt):
    archive = library(features, opt)
    board, empty = TARGET / "board.c", TARGET / "empty.c"
    board.write_text(BOARD)
    empty.write_text("void reset(void) { for (;;) {} }\n")
    header = (HERE / "include/trueaxis.h").read_text()
    functions = sorted(set(re.findall(r"^\w.*?\b(trueaxis_[a-z0-9_]+)\(", header, re.M)))
    whole, _ = linked("whole", [empty], archive, functions)
    small, ram = linked("small", [HERE / "examples/c/small.c", board], archive)
    found = {"whole": whole, "small": small, "ram": ram}
    if "three" in features:
        found["rust"], _ = linked("rust", [board], rust_library(features, opt), defines=["-DRUST"])
    return found


def committed():
    if not COMMITTED.exists():
        sys.exit(f"{COMMITTED}: found no file, needed that of size.py --commit")
    rows = tomllib.loads(COMMITTED.read_text())["size"]
    return {(row["features"], row["opt"]): row for row in rows}


def table(sizes):
    lines = ["| flash, kB: whole; small host; the same in Rust | " + " | ".join(f"for {title}" for _, title in COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
    for name, features, opts, _ in ROWS:
        cells = []
        for opt, _ in COLUMNS:
            size = sizes[features, opt] if opt in opts else None
            cells.append("; ".join(f"{size[key] / 1000:.0f}" for key in ("whole", "small", "rust") if key in size) if size else "–")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def page(path, sizes, write):
    """Whether a page holds the table; puts it there to write."""
    text = path.read_text()
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        sys.exit(f"{path}: found no {BEGIN.strip()} with its {END.strip()}, needed both")
    new = before + begin + table(sizes) + end + after
    if write:
        path.write_text(new)
    elif new != text:
        print(f"{path}: found another table of sizes than that of {COMMITTED.name}, needed size.py --write {path}")
        return False
    return True


def main(words):
    if words and words[0] not in ("--commit", "--write", "--check") or words[1:] and words[0] == "--commit":
        sys.exit(__doc__)
    pages = [Path(word) for word in words[1:]]
    if words[:1] == ["--write"]:
        for path in pages:
            page(path, committed(), True)
        return
    subprocess.run([str(ROOT / ".ci/install"), f"rustup:target:{TRIPLE}", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi"], check=True)
    TARGET.mkdir(parents=True, exist_ok=True)
    check = words[:1] == ["--check"]
    good, sizes = True, {}
    for name, features, opts, checked in ROWS:
        for opt in checked if check else opts:
            found = sizes[features, opt] = measured(features, opt)
            print(f"{name}, {opt}: " + ", ".join(f"{key} {value}" for key, value in found.items()), flush=True)
            if not check:
                continue
            limits = committed()[features, opt]
            for key, value in found.items():
                limit = limits[key]
                if not STALE * limit <= value <= GROWN * limit:
                    print(f"{COMMITTED}: {key} of {name}, {opt}: found {value} bytes, needed {limit} (+2 %, -5 %)")
                    good = False
    if check:
        good = all([page(path, committed(), False) for path in pages]) and good
        sys.exit(0 if good else 1)
    print(table(sizes), end="")
    if words == ["--commit"]:
        lines = ["# Bytes, by parts and optimisation: size.py --commit writes this.\n"]
        for (features, opt), size in sizes.items():
            lines.append(f"\n[[size]]\nfeatures = {json.dumps(features)}\nopt = {json.dumps(opt)}\n")
            lines += [f"{key} = {value}\n" for key, value in size.items()]
        COMMITTED.write_text("".join(lines))


main(sys.argv[1:])
