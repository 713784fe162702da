#!/usr/bin/env python3
"""Tests of longest_path.py on small programs for a Cortex-M4F: bounds counted by hand, longer paths, and what is refused.

    test_longest_path.py FOLDER       a folder for the programs
"""

import json
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
WORK = Path(sys.argv[1]).resolve()
HEAD = """#![no_std]
#![no_main]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
"""

ASSEMBLY = """
core::arch::global_asm!(
    ".syntax unified", ".thumb", ".text",
    ".global counted", ".type counted, %function", ".thumb_func",
    "counted:",
    "push {{r4, lr}}", "cmp r0, #2", "bhi 9f", "tbb [pc, r0]",
    "7: .byte (1f - 7b) / 2, (2f - 7b) / 2, (3f - 7b) / 2, 0", ".p2align 1",
    "1: movs r1, #1", "b 9f",
    "2: movs r1, #2", "movs r1, #3", "cbz r1, 9f",
    "3: movs r1, #4", "EXTRA", "bl leaf",
    "9: adds r1, #1", "pop {{r4, lr}}", "b.w last",
    ".size counted, . - counted",
    ".type leaf, %function", ".thumb_func",
    "leaf:", "cmp r1, #3", "ite eq", "moveq r1, #0", "movne r1, #1", "bx lr",
    ".size leaf, . - leaf",
    ".type last, %function", ".thumb_func",
    "last:", "cmp r1, #3", "itt eq", "moveq r0, r1", "bxeq lr", "udf #0",
    ".size last, . - last",
);
"""
CALLER = """
#[unsafe(no_mangle)]
pub extern "C" fn step() {
    unsafe extern "C" {
        fn counted();
    }
    unsafe { counted() }
}
"""
# 4 instructions to the table, of the ways behind it the second, which goes on into the third: 3 + 1 and the call, 5 in the
# leaf, 3 after it, 5 in the last with its trap.
COUNTED = 4 + 3 + 1 + 1 + 5 + 3 + 5

SOURCE = """
const MOST: usize = 8;
#[inline(never)]
fn extra(x: f32) -> f32 {
    let mut y = x;
    // At most 5 rounds.
    while y > 1.0 {
        y = y * 0.5 - 0.25;
    }
    y
}
// Only with cubes.
#[inline(never)]
fn cubed(x: f32) -> f32 {
    (x * x * x - x * x) * x + x / (x + 3.0)
}
// Takes 1 of at most 2 squares in one step.
#[inline(never)]
fn squared(x: f32) -> f32 {
    x * x + x / 3.0 - x / 7.0
}
// Never both left and right in one step: one flag chooses.
// Only with left.
#[inline(never)]
fn left(x: f32) -> f32 {
    x / 3.0 + x * 5.0
}
// Only with right.
#[inline(never)]
fn right(x: f32) -> f32 {
    x / 5.0 + x * 3.0 - x
}
#[unsafe(no_mangle)]
pub extern "C" fn step(values: &[f32; 64], count: usize, flags: u32) -> f32 {
    let mut sum = 0.0;
    // At most MOST rounds.
    for value in values.iter().take(count) {
        sum = sum * 0.5 + extra(*value);
    }
    if flags & 1 != 0 {
        sum += cubed(sum);
    }
    for k in 0..3 {
        if flags & (2 << k) != 0 {
            sum = squared(sum);
        }
    }
    if flags & 16 != 0 {
        sum += left(sum);
    }
    if flags & 32 != 0 {
        sum += right(sum);
    }
    sum
}
"""


def built(name, text):
    """Builds a program; `name` is that of its file."""
    folder = WORK / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "fixture.rs").write_text(HEAD + text)
    command = ["rustc", "--edition=2024", "--target=thumbv7em-none-eabihf", "-Copt-level=2", "-Cdebuginfo=1",
               "-Cpanic=abort", "-Awarnings", "-Clink-arg=-estep", "-Clink-arg=--gc-sections", "-Clink-arg=-ustep", "fixture.rs"]
    subprocess.run(command, cwd=folder, check=True)
    return folder


def run(folder, *arguments, function="step"):
    command = [sys.executable, HERE / "longest_path.py", folder / "fixture", function, "--root", folder, "--json", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def bound(folder, *arguments, function="step"):
    done = run(folder, *arguments, function=function)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["bound"]


def refused(name, text, *words, arguments=()):
    done = run(built(name, text), *arguments)
    assert done.returncode == 1 and all(word in done.stderr for word in words), (name, words, done)


def line_of(text, part):
    return (HEAD + text)[: (HEAD + text).index(part)].count("\n") + 1


def counted_by_hand():
    assembly = ASSEMBLY + CALLER
    plain = bound(built("plain", assembly.replace('"EXTRA",', "")), function="counted")
    assert plain == COUNTED, (plain, COUNTED)
    longer = bound(built("longer", assembly.replace('"EXTRA"', '"nop", "nop", "nop"')), function="counted")
    assert longer == COUNTED + 3, (longer, COUNTED)


def statements():
    folder = built("source", SOURCE)
    whole = bound(folder)
    more = bound(built("rounds", SOURCE.replace("MOST: usize = 8", "MOST: usize = 9")))
    inner = bound(built("inner", SOURCE.replace("At most 5 rounds", "At most 6 rounds")))
    # A round more of the outer loop costs the five rounds of the inner one; a round more of that costs it at least eight times,
    # and nine times where the outer loop's last test counts as the beginning of a round.
    assert inner - whole >= 8 and more - whole > 5 * ((inner - whole) // 9), (whole, more, inner)
    # A longer path planted into the program: the division must run in every round.
    planted = SOURCE.replace("sum = sum * 0.5 + extra(*value);", "sum = sum * 0.5 + extra(*value) / (sum + 2.0);")
    assert bound(built("planted", planted)) >= whole + 8
    without = bound(folder, "--without", "cubes")
    assert without < whole - 5, (without, whole)
    takes = bound(built("takes", SOURCE.replace("at most 2 squares", "at most 3 squares")))
    one = bound(built("takes-one", SOURCE.replace("at most 2 squares", "at most 1 squares")))
    assert one < whole < takes and takes - whole == whole - one, (one, whole, takes)
    both = bound(built("both", SOURCE.replace("// Never both left and right", "// Sometimes both left and right")))
    alone = [bound(folder, "--without", part) for part in ("left", "right")]
    assert whole == max(alone) and both > whole, (both, whole, alone)


def refusals():
    where = f"fixture.rs:{line_of(SOURCE, 'while y')}"
    refused("no-bound", SOURCE.replace("// At most 5 rounds.", "// Some rounds."), where, "without a bound")
    refused("no-name", SOURCE.replace("At most MOST", "At most MANY"), "found MANY, needed a number")
    refused("register", SOURCE.replace("flags: u32", "flags: u32, f: fn(f32) -> f32").replace("extra(*value)", "f(*value)"),
            "step: 0x", "by a register")
    recursion = SOURCE.replace("    y\n", "    if y < -9.0 { extra(y * y) + extra(y + 1.0) } else { y }\n")
    refused("recursion", recursion, "extra calls itself")
    folder = built("stale", SOURCE)
    (folder / "fixture.rs").write_text(HEAD + "\n" + SOURCE)
    done = run(folder)
    assert done.returncode == 1 and "newer than the program" in done.stderr, done
    done = run(built("source", SOURCE), "--seen", "100000")
    assert done.returncode == 1 and "of the worst seen" in done.stderr, done


for test in (counted_by_hand, statements, refusals):
    test()
    print(f"{test.__name__}: good")
