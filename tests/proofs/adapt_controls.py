"""Writes a crate with the law of a factor under planted defects: every proof of it must fail.

    adapt_controls.py FOLDER        prints the names of the functions
"""

import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE / "../../crates/trueaxis/src/dynamic/adapt.rs"
FUNCTION = {"follow": ("&mut ", ", error: f32) { bounds.follow(factor, error); }"), "used": ("&", ") -> f32 { bounds.used(factor) }")}

# name: (function, original text, planted text).
DEFECTS = {
    "unbounded_use": ("used", "factor.value.limit(self.low, self.high)", "factor.value"),
    "no_low_end": ("used", "factor.value.limit(self.low, self.high)", "factor.value.min(self.high)"),
    "unbounded_sum": ("follow", "(self.used(factor) + step).limit(self.low, self.high)", "self.used(factor) + step"),
    "wide_step_up": ("follow", ".limit(-self.step, self.step)", ".limit(-self.step, self.step + self.step)"),
    "unbounded_step": ("follow", ".limit(-self.step, self.step)", ""),
    "wrong_way": ("follow", "(self.used(factor) + step)", "(self.used(factor) - step)"),
    "follows_anything": ("follow", "if error.is_finite() {", "if error.abs() >= R::ZERO || !error.is_finite() {"),
}


def main(folder):
    source = SOURCE.read_text().replace("#[cfg(test)]\nmod tests", "#[cfg(any())]\nmod tests")
    (folder / "src").mkdir(parents=True, exist_ok=True)
    manifest = (HERE / "adapt/Cargo.toml").read_text().replace("../../../crates", str((HERE / "../../crates").resolve()))
    (folder / "Cargo.toml").write_text(manifest.replace("trueaxis-adapt-ir", "trueaxis-adapt-controls"))
    lines = ["#![no_std]", "#![allow(warnings)]", "mod real { pub use trueaxis::Real; }"]
    for name, (function, right, wrong) in DEFECTS.items():
        if source.count(right) != 1:
            sys.exit(f"adapt_controls.py: found {source.count(right)} times in dynamic/adapt.rs, needed once: {right}")
        (folder / f"src/{name}.rs").write_text(source.replace(right, wrong))
        lines.append(f"mod {name};")
        of, rest = FUNCTION[function]
        lines.append(f"#[unsafe(no_mangle)] #[inline(never)] pub extern \"C\" fn {function}_f32_{name}(bounds: "
                     f"&{name}::Bounds<f32>, factor: {of}{name}::Factor<f32>{rest}")
        print(f"{function}_f32_{name}")
    (folder / "src/lib.rs").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
