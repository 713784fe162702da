"""Writes a crate with the law of a factor under planted defects: every proof of it must fail.

    adapt_controls.py FOLDER        prints the names of the functions
"""

import pathlib
import sys

from defects import write

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
    def signature(function, name):
        of, rest = FUNCTION[function]
        return f"bounds: &{name}::Bounds<f32>, factor: {of}{name}::Factor<f32>{rest}"

    write(folder, "adapt", "dynamic/adapt.rs", DEFECTS, [], signature)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
