"""Writes a crate with the limiter's source under planted defects: every proof of it must fail.

    controls.py FOLDER        prints the names of the functions
"""

import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE / "../../crates/trueaxis/src/limiter/mod.rs"
FUNCTION = {"follow": ", wanted: f32) -> bool { limiter.follow(state, wanted) }",
            "freeze": ") { limiter.freeze(state) }", "hold": ") { limiter.hold(state) }"}

# name: (function, original text, planted text).
DEFECTS = {
    "no_bound_of_slope": ("follow", ".min(self.velocity);", ";"),
    "no_bound_of_acceleration": ("follow", "up.min(fastest).max(slowest)", "up"),
    "flipped_sign": ("follow", "(v - self.acceleration, v + self.acceleration)",
                     "(v - self.acceleration, v + self.acceleration + self.acceleration)"),
    "clamp_left_out": ("follow", "let velocity = want.limit(lowest, highest);", "let velocity = want;"),
    "lock_unchecked": ("follow", "&& direct >= lowest && direct <= highest", "&& direct >= lowest"),
    "passes_any_change": ("follow", "change.abs() <= self.velocity\n            && ", ""),
    "passes_any_acceleration": ("follow", "&& (change - state.velocity).abs() <= self.acceleration", ""),
    "infinite_target": ("follow", "let r = wanted.limit(-self.magnitude, self.magnitude);", "let r = wanted;"),
    "flag_flipped": ("follow", "        sent != wanted\n", "        sent == wanted\n"),
    "brakes_too_hard": ("freeze", "state.velocity.limit(-self.acceleration, self.acceleration)", "state.velocity"),
    "adds_what_it_brakes": ("freeze", "state.velocity - state.velocity.limit", "state.velocity + state.velocity.limit"),
    "moves_while_held": ("hold", "LimiterState::at_rest(state.sent)", "LimiterState::at_rest(state.sent + state.velocity)"),
}


def main(folder):
    source = SOURCE.read_text()
    (folder / "src").mkdir(parents=True, exist_ok=True)
    manifest = (HERE / "limiter/Cargo.toml").read_text().replace("../../../crates", str((HERE / "../../crates").resolve()))
    (folder / "Cargo.toml").write_text(manifest.replace("trueaxis-limiter-ir", "trueaxis-limiter-controls")
                                       .replace("[dependencies]", "[dependencies]\nlibm = '0.2.16'"))
    # The limiter's source names modules of its own crate; `real` is not public there.
    lines = ["#![no_std]", "#![allow(warnings)]", "use trueaxis::{error, machine};", "mod real { pub use trueaxis::Real; }"]
    for name, (function, right, wrong) in DEFECTS.items():
        if source.count(right) != 1:
            sys.exit(f"controls.py: found {source.count(right)} times in limiter/mod.rs, needed once: {right}")
        (folder / f"src/{name}.rs").write_text(source.replace(right, wrong))
        lines.append(f"mod {name};")
        lines.append(f"#[unsafe(no_mangle)] #[inline(never)] pub extern \"C\" fn {function}_f32_{name}(limiter: "
                     f"&{name}::Limiter<f32>, state: &mut {name}::LimiterState<f32>{FUNCTION[function]}")
        print(f"{function}_f32_{name}")
    (folder / "src/lib.rs").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
