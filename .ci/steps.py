#!/usr/bin/env python3
"""The steps of .ci/run: everything that must hold before a change is taken.

Long steps come first, so that the lanes end together.
"""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from lanes import Step, run  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
TOOLS = Path(subprocess.check_output([ROOT / ".ci/install", "--where"], text=True).strip())
REFERENCE = ROOT.parent / "shared/data"
# What a run from nothing may leave on the disk, GB; it prints what it has left.
DISK_GB = 30.0

TOOLS_SCRIPT = """
# Everything that other scripts would install, so that two of them do not meet at the package manager.
.ci/install rustup:target:thumbv7em-none-eabihf rustup:target:wasm32-unknown-unknown rustup:nightly:miri \\
    rustup:nightly:rust-src rustup:component:llvm-tools rustup:component:clippy rustup:component:rustfmt \\
    gcc g++ make libc6-dev libc6-dbg valgrind llvm qemu-system-arm gcc-arm-none-eabi libnewlib-arm-none-eabi \\
    linuxcnc-uspace linuxcnc-uspace-dev chromium python3-venv \\
    cargo:cargo-deny@0.20.2 cargo:gungraun-runner@=0.20.0 cargo:defmt-print@1.2.0 crate:desk/bindgen
rm -rf "$tools/build"
"""

SINGLE = """
# All packages are selected so that their features, and with them what is built, stay those of `cargo test --workspace`;
# the attack on the interface is written for double precision.
cargo test --workspace --exclude trueaxis-fuzz --features trueaxis-capi/single --test capi
cargo test --workspace --exclude trueaxis-fuzz --features trueaxis-capi/three --test capi three::
"""

FEATURES = """
# Features of the core: none, each alone, all but one, all; fp64 chooses an instruction on Arm, and the images are built with
# it.
export CARGO_TARGET_DIR="$target/features"
mapfile -t sets < <(cargo metadata --no-deps --format-version 1 | python3 -c '
import json, sys

[core] = [package for package in json.load(sys.stdin)["packages"] if package["name"] == "trueaxis"]
names = sorted(set(core["features"]) - {"default", "fp64"})
sets = [[], *([name] for name in names), *([other for other in names if other != name] for name in names), names]
print(*dict.fromkeys(map(",".join, sets)), sep="\\n")
')
export RUSTC_WRAPPER=$PWD/.ci/check-of-core
for features in "${sets[@]}"; do
    echo "features: $features"
    cargo check --quiet -p trueaxis --no-default-features --features "$features"
done
# The examples, as a host builds them: without `bench`, which every other build of them has.
core=$(cargo check --quiet -p trueaxis --message-format json | sed -n 's/.*"\\([^"]*libtrueaxis-[^"]*\\.rmeta\\)".*/\\1/p')
for example in embed mcu; do
    echo "example: $example"
    CARGO_MANIFEST_DIR=$PWD/crates/trueaxis rustc --edition 2024 --emit metadata -L "dependency=$CARGO_TARGET_DIR/debug/deps" \\
        --extern "trueaxis=$core" --out-dir "$CARGO_TARGET_DIR" "crates/trueaxis/examples/$example.rs"
done
rm -rf "$target/features"
"""

NO_STD = """
(cd firmware-sim/cortex-m && cargo clippy --quiet --release --lib --bins -- -D warnings)
for features in '' defmt; do
    cargo check --quiet -p trueaxis --target thumbv7em-none-eabihf --no-default-features --features "$features"
done
cargo check --quiet -p trueaxis-metrology --target thumbv7em-none-eabihf --no-default-features
"""

LOWEST = """
# Of what others build: the tests and what they are made of need no more than the stable compiler.
lowest=$(sed -n 's/^rust-version = "\\(.*\\)"/\\1/p' Cargo.toml)
rustup run "$lowest" rustc --version 2>/dev/null || rustup toolchain install "$lowest" --profile minimal
CARGO_TARGET_DIR="$target/lowest" cargo "+$lowest" check --quiet --workspace --exclude trueaxis-benches --exclude trueaxis-py \\
    --exclude trueaxis-fuzz --exclude trueaxis-testing --exclude trueaxis-tests
rm -rf "$target/lowest"
"""

LICENCES = """
git ls-files '*Cargo.lock' | while read -r lock; do
    echo "$lock"
    cargo deny --manifest-path "$(dirname "$lock")/Cargo.toml" --config deny.toml check --hide-inclusion-graph licenses bans sources
done
.ci/advisories
"""

COMMANDS = r"""
cargo run --release -- run --json >"$target/run.json"
python3 - "$target/run.json" <<'PYTHON'
import json, sys

error = json.load(open(sys.argv[1]))["contour_error_um"]
for figure in ("max", "rms"):
    before, after = error["uncompensated"][figure], error["compensated"][figure]
    print(f"contour error, {figure}: {before:.3f} um before, {after:.3f} um after, factor {before / after:.1f}")
    if not 0.0 < after <= before / 5.0:
        sys.exit(f"contour error, {figure}: found {after} um, needed at most a fifth of {before} um")
PYTHON
rm -f report/index.html
cargo run --release
if [[ ! -s report/index.html ]]; then
    echo 'cargo run --release left no report/index.html' >&2
    exit 1
fi
docs/pictures.py --check report/index.html
"""

DOCUMENTATION = """
# With the features of clippy, which has checked the packages of others.
RUSTDOCFLAGS='-D warnings' cargo doc --quiet --workspace --no-deps --features trueaxis-benches/counts,trueaxis-benches/side-by-side
.ci/api --check
"""

# Builds that several steps share are steps of their own. Otherwise whichever of them runs first would pay for the build.
BUILDS = ("tools", "commands")
# By processor time, that of the steps which wait for them included.
STEPS = [
    Step("cargo test", "cargo test --workspace"),
    Step("tools", TOOLS_SCRIPT, varies=True),
    Step("commands", "tests/hosts/recording.sh"),
    Step("counts of the host, built", "benches/check-budgets.sh --build base", BUILDS),
    Step("LinuxCNC", "integrations/linuxcnc/test.sh", (*BUILDS, "cargo test"), waits=True),
    Step("bare metal", """
        firmware-sim/cortex-m/test.sh
        python3 firmware-sim/cortex-m/schedule.py firmware-sim/cortex-m/counts.toml --check docs/bare-metal.md docs/cost.md \\
            benches/README.md README.md
        """, (*BUILDS, "counts of the host, built")),
    Step("instruction budgets", "benches/check-budgets.sh", (*BUILDS, "counts of the host, built")),
    Step("desk", "desk/test.sh", (*BUILDS, "cargo test")),
    Step("clippy", "cargo clippy --workspace --all-targets --features trueaxis-benches/counts,trueaxis-benches/side-by-side -- -D warnings",
         ("cargo test", "tools")),
    Step("core under Miri", "crates/trueaxis/miri.sh --quick", BUILDS),
    Step("C interface under Miri", "crates/trueaxis-capi/miri.sh", ("core under Miri",)),
    Step("C interface", "crates/trueaxis-capi/test.sh", (*BUILDS, "cargo test")),
    Step("flash", "crates/trueaxis-capi/size.py --check docs/bare-metal.md", BUILDS),
    Step("grblHAL", "integrations/grblhal/test.sh", ("C interface", "flash")),
    Step("Python", "crates/trueaxis-py/test.sh", BUILDS),
    Step("C interface under sanitizers", "crates/trueaxis-capi/sanitize.sh --quick", (*BUILDS, "cargo test")),
    Step("LinuxCNC under sanitizers", "integrations/linuxcnc/sanitize.sh --quick", ("C interface under sanitizers",)),
    Step("Klipper", "integrations/klipper/test.sh", BUILDS),
    Step("lowest Rust version", LOWEST, BUILDS, varies=True),
    Step("feature matrix", FEATURES, BUILDS),
    Step("proofs of the limiter", "tests/proofs/prove.sh", BUILDS),
    Step("mutants on changed lines", "tests/mutants/changed.sh", BUILDS, varies=True),
    Step("EtherCAT", "integrations/ethercat/test.sh", BUILDS),
    Step("the two commands of the README", COMMANDS, ("commands",)),
    Step("documentation", DOCUMENTATION, ("clippy",)),
    Step("single precision and three axes", SINGLE, ("cargo test",)),
    Step("no_std target", NO_STD, ("clippy",)),
    Step("licences and sources", LICENCES, BUILDS),
    Step("ROS 2 control", "integrations/ros2/test.sh", BUILDS),
    Step("packages", """
        cargo package --workspace --exclude trueaxis-tests --exclude trueaxis-benches --exclude trueaxis-testing \\
            --exclude trueaxis-desk --exclude trueaxis-fuzz --exclude trueaxis-py --no-verify --allow-dirty
        """, ("tools",)),
    Step("format and circles of files", """
        .ci/format
        .ci/circles.py crates/* firmware-sim desk/wasm benches tests fuzz
        docs/check.py
        """, ("tools",)),
    Step("one recording through every host", 'tests/hosts/table.py --check "$target/hosts" docs/hosts.md',
         ("C interface", "Python", "grblHAL", "LinuxCNC", "Klipper", "ROS 2 control", "bare metal", "EtherCAT")),
]


def left_gb():
    """What runs have left in this folder and in the target folder: all that git ignores, GB."""
    ignored = ["git", "ls-files", "--others", "--ignored", "--exclude-standard", "--directory", "-z"]
    names = subprocess.check_output(ignored, cwd=ROOT, text=True).split("\0")
    folders = {ROOT / name for name in names if name} | {TARGET}
    # du fails if a file is deleted while it counts; it counts a folder inside another one once.
    done = subprocess.run(["du", "-sck", *filter(Path.exists, folders)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    return int(done.stdout.splitlines()[-1].split()[0]) * 1024 / 1e9


def room():
    """Whether the disk has room for a run; says what is lacking."""
    needed = max(DISK_GB - left_gb(), 1.0)
    found = shutil.disk_usage(TARGET).free / 1e9
    if found < needed:
        print(f".ci/run: found {found:.1f} GB free on the disk of {TARGET}, needed {needed:.1f} GB", file=sys.stderr)
    return found >= needed


def main():
    words = sys.argv[1:]
    commit = words == ["--commit"]
    named = [] if commit else words
    unknown = set(named) - {step.name for step in STEPS}
    if unknown:
        names = "\n  ".join(step.name for step in STEPS)
        print(f"usage: .ci/run [quick | --commit | STEP...]; found {sorted(unknown)[0]!r}, needed some of\n  {names}", file=sys.stderr)
        return 2
    steps = [replace(step, after=()) for step in STEPS if step.name in named] if named else STEPS
    os.chdir(ROOT)
    cold = not named and not (TARGET / "debug").exists() and not (TARGET / "release").exists()
    if commit and not cold:
        print(f".ci/run --commit: found {TARGET} built already, needed none: times are those of a run from nothing", file=sys.stderr)
        return 2
    (TARGET / "ci").mkdir(parents=True, exist_ok=True)
    os.environ.update(
        CI="true",
        target=str(TARGET),
        tools=str(TOOLS),
        TRUEAXIS_TOOLS=str(TOOLS),
        CARGO_TERM_COLOR=os.environ.get("CARGO_TERM_COLOR", "never"),
        PATH=os.pathsep.join([str(TOOLS / "bin"), str(Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo")) / "bin"), os.environ["PATH"]]),
        # Nothing is built twice after a change here, and nobody looks for a line: the files for that would double what a
        # run takes on the disk.
        CARGO_INCREMENTAL="0",
        CARGO_PROFILE_DEV_DEBUG="0",
    )
    # Circles of known reference values, where there are any.
    if REFERENCE.is_dir():
        os.environ["TRUEAXIS_REFERENCE_DATA"] = str(REFERENCE)
    if shutil.which("rustup") is None:
        print(".ci/run: found no rustup, needed with the stable toolchain", file=sys.stderr)
        return 2
    if not named and not room():
        return 2
    code = run(steps, TARGET / "ci", ROOT / ".ci/times.toml", cold, commit)
    if cold:
        left = left_gb()
        print(f"=== left on the disk: {left:.1f} GB of {DISK_GB:.0f} GB allowed by .ci/steps.py")
        if code == 0 and left > DISK_GB:
            code = 1
    subprocess.run([str(ROOT / ".ci/campaign")], check=True)
    return code


if __name__ == "__main__":
    sys.exit(main())
