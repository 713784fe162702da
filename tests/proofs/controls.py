"""Writes a crate with the limiter's source under planted defects: every proof of it must fail.

    controls.py FOLDER        prints the names of the functions
"""

import pathlib
import sys

from defects import write

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
    signature = lambda function, name: (
        f"limiter: &{name}::Limiter<f32>, state: &mut {name}::LimiterState<f32>{FUNCTION[function]}")
    write(folder, "limiter", "limiter/mod.rs", DEFECTS, ["use trueaxis::{error, machine};"], signature)
    manifest = folder / "Cargo.toml"
    manifest.write_text(manifest.read_text().replace("[dependencies]", "[dependencies]\nlibm = '0.2.16'"))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
