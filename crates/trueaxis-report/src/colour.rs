//! Colours, identical in every figure and in the desk (`desk/src/core/theme.ts`).
//!
//! Every one has a counterpart for a dark page. Those that are drawn together remain distinct for colour-blind readers.

use std::fmt::Write as _;

/// A colour in sRGB: red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

/// Measured profiles and points.
pub const MEASURED: Colour = Colour(31, 35, 40);
/// The programmed path and reference circles.
pub const NOMINAL: Colour = Colour(95, 102, 112);
/// Scales, single revolutions, residuals.
pub const GREY: Colour = Colour(134, 140, 149);
/// The uncorrected machine.
pub const UNCOMPENSATED: Colour = Colour(184, 74, 0);
/// The corrected machine.
pub const COMPENSATED: Colour = Colour(0, 90, 156);
/// The servo alone, on a machine without geometric errors.
pub const SERVO: Colour = NOMINAL;
/// Everything on: the servo's errors corrected as well.
pub const FULL: Colour = Colour(0, 114, 90);
/// Corrections and latencies, which belong to no run.
pub const NEUTRAL: Colour = Colour(75, 74, 158);
/// A fourth curve beside the three of [`AXES`].
pub const FOURTH: Colour = Colour(140, 59, 116);
/// Limits, budgets, periods, suppressed harmonics.
pub const LIMIT: Colour = Colour(164, 14, 38);
/// Directions X, Y and Z.
pub const AXES: [Colour; 3] = [UNCOMPENSATED, FULL, COMPENSATED];
/// Rotary axes A, B and C.
pub const ROTARY: [Colour; 3] = [FOURTH, Colour(138, 109, 0), NEUTRAL];

pub(crate) const TEXT: Colour = MEASURED;
pub(crate) const MESH: Colour = Colour(228, 231, 235);
pub(crate) const EDGE: Colour = Colour(120, 126, 135);
pub(crate) const WHITE: Colour = Colour(255, 255, 255);

/// Colours on a light page, and those that take their place on a dark one.
const PAIRS: [(Colour, Colour); 12] = [
    (MEASURED, Colour(230, 232, 235)),
    (NOMINAL, Colour(164, 171, 181)),
    (GREY, Colour(133, 140, 150)),
    (UNCOMPENSATED, Colour(240, 163, 106)),
    (COMPENSATED, Colour(109, 179, 242)),
    (FULL, Colour(70, 199, 160)),
    (NEUTRAL, Colour(169, 168, 238)),
    (FOURTH, Colour(221, 143, 194)),
    (LIMIT, Colour(255, 143, 143)),
    (ROTARY[1], Colour(227, 196, 76)),
    (MESH, Colour(44, 50, 58)),
    (EDGE, Colour(125, 133, 143)),
];
/// The page itself: what lies under a figure, and the rim of text and of bold curves.
const PAPER: (Colour, Colour) = (WHITE, Colour(20, 23, 27));

/// Errors from the smallest to the largest, on a light page and on a dark one: the larger the error, the further its lightness
/// is from that of the page.
const ERRORS: [[Colour; 5]; 2] = [
    [Colour(75, 147, 189), Colour(96, 113, 178), Colour(136, 66, 134), Colour(140, 26, 66), Colour(84, 4, 16)],
    [Colour(79, 127, 181), Colour(152, 138, 200), Colour(222, 150, 164), Colour(246, 190, 120), Colour(255, 233, 168)],
];
/// Number of steps between the smallest and the largest error. A dark page needs a rule for every shade.
const STEPS: u32 = 32;

/// The shade of an error from 0 to 1.
pub(crate) fn of_error(share: f64) -> Colour {
    shade((share.clamp(0.0, 1.0) * f64::from(STEPS)).round() as u32, &ERRORS[0])
}

fn shade(step: u32, stops: &[Colour; 5]) -> Colour {
    let at = f64::from(step.min(STEPS)) / f64::from(STEPS) * (stops.len() - 1) as f64;
    let low = (at.floor() as usize).min(stops.len() - 2);
    let mix =
        |one: u8, next: u8| (f64::from(one) + (at - low as f64) * (f64::from(next) - f64::from(one))).round() as u8;
    let (one, next) = (stops[low], stops[low + 1]);
    Colour(mix(one.0, next.0), mix(one.1, next.1), mix(one.2, next.2))
}

/// All colours of figures with their counterparts on a dark page.
fn pairs() -> impl Iterator<Item = (Colour, Colour)> {
    let shades = (0..=STEPS).map(|step| (shade(step, &ERRORS[0]), shade(step, &ERRORS[1])));
    PAIRS.into_iter().chain([PAPER]).chain(shades)
}

/// Rules of a style sheet by which the figures of a page, drawn for a light one, suit a dark one.
pub(crate) fn on_dark(page: &str) -> String {
    let mut rules = String::new();
    for (light, dark) in pairs().map(|(light, dark)| (light.hex(), dark.hex())) {
        for property in ["fill", "stroke"] {
            if page.contains(&format!("{property}=\"{light}\"")) {
                // Writing to a string does not fail.
                let _ = writeln!(rules, "  svg [{property}='{light}'] {{ {property}: {dark}; }}");
            }
        }
    }
    rules
}

impl Colour {
    /// As the drawing library writes it.
    fn hex(self) -> String {
        format!("#{:02X}{:02X}{:02X}", self.0, self.1, self.2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Transforms of linear red, green and blue: as most people see, and with protanopia, deuteranopia and tritanopia (G. M.
    /// Machado, M. M. Oliveira and L. A. F. Fernandes, IEEE Trans. Vis. Comput. Graph. 15(6), 2009, severity 1.0).
    const SIGHT: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    ];

    fn linear(Colour(red, green, blue): Colour) -> [f64; 3] {
        [red, green, blue].map(|part| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        })
    }

    fn dot(one: [f64; 3], other: [f64; 3]) -> f64 {
        one.into_iter().zip(other).map(|(a, b)| a * b).sum()
    }

    /// Contrast ratio of WCAG 2.2.
    fn contrast(one: Colour, other: Colour) -> f64 {
        let [a, b] = [one, other].map(|colour| dot([0.2126, 0.7152, 0.0722], linear(colour)) + 0.05);
        (a / b).max(b / a)
    }

    /// CIELAB of a colour as it is seen: lightness, green to red, blue to yellow.
    fn seen(colour: Colour, sight: &[[f64; 3]; 3]) -> [f64; 3] {
        let rgb = sight.map(|row| dot(row, linear(colour)).clamp(0.0, 1.0));
        let xyz =
            [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]].map(|row| dot(row, rgb));
        let part = |value: f64| if value > 0.008856 { value.cbrt() } else { 7.787 * value + 16.0 / 116.0 };
        let [x, y, z] = [xyz[0] / 0.95047, xyz[1], xyz[2] / 1.08883].map(part);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn apart(one: Colour, other: Colour, sight: &[[f64; 3]; 3]) -> f64 {
        let (one, other) = (seen(one, sight), seen(other, sight));
        one.into_iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    fn dark(colour: Colour) -> Colour {
        pairs().find(|(light, _)| *light == colour).map(|(_, dark)| dark).expect("a counterpart")
    }

    #[test]
    fn a_colour_stands_out_from_either_page() {
        for (light, dark) in pairs().filter(|(light, _)| ![WHITE, MESH].contains(light)) {
            assert!(contrast(light, PAPER.0) >= 3.0, "{light:?}: {}", contrast(light, PAPER.0));
            assert!(contrast(dark, PAPER.1) >= 3.0, "{dark:?}: {}", contrast(dark, PAPER.1));
        }
        // Labels of marks have the colours of their lines.
        for text in [TEXT, NOMINAL, UNCOMPENSATED, COMPENSATED, FULL, NEUTRAL, LIMIT] {
            assert!(contrast(text, PAPER.0) >= 4.5 && contrast(dark(text), PAPER.1) >= 4.5, "{text:?}");
        }
    }

    #[test]
    fn curves_in_one_figure_remain_distinct_for_colour_blind_readers() {
        let runs = [UNCOMPENSATED, COMPENSATED, SERVO, FULL];
        for together in [&runs[..], &AXES, &[AXES[0], AXES[1], AXES[2], FOURTH], &ROTARY] {
            for (k, one) in together.iter().enumerate() {
                for other in &together[..k] {
                    for sight in &SIGHT {
                        let least = apart(*one, *other, sight).min(apart(dark(*one), dark(*other), sight));
                        assert!(least >= 9.5, "{one:?} and {other:?}: {least}");
                    }
                }
            }
        }
    }

    #[test]
    fn errors_leave_the_lightness_of_the_page_step_by_step_for_every_reader() {
        for ((stops, paper), away) in ERRORS.iter().zip([PAPER.0, PAPER.1]).zip([-1.0, 1.0]) {
            for sight in &SIGHT {
                let lightness: Vec<f64> = (0..=STEPS).map(|step| seen(shade(step, stops), sight)[0]).collect();
                assert!(lightness.windows(2).all(|pair| away * (pair[1] - pair[0]) > 0.0), "{lightness:?}");
                let [first, last] = [lightness[0], lightness[STEPS as usize]];
                assert!(away * (last - first) >= 35.0, "{first} to {last}");
            }
            assert!(contrast(stops[4], paper) > contrast(stops[0], paper));
        }
    }

    #[test]
    fn a_shade_is_no_other_colour() {
        let light: Vec<Colour> = pairs().map(|(light, _)| light).collect();
        for (k, one) in light.iter().enumerate() {
            assert!(!light[..k].contains(one), "{one:?} stands for two things");
        }
    }

    #[test]
    fn errors_run_from_the_first_shade_to_the_last() {
        assert_eq!([-1.0, 0.0, 0.25, 1.0, 9.0].map(of_error), [0, 0, 1, 4, 4].map(|stop| ERRORS[0][stop]));
    }

    /// The desk's colours are the same, light and dark.
    #[test]
    fn the_desk_has_the_same_colours() {
        let theme = concat!(env!("CARGO_MANIFEST_DIR"), "/../../desk/src/core/theme.ts");
        let theme = std::fs::read_to_string(theme).expect("the desk's theme");
        let named = [
            ("ink", TEXT),
            ("grid", MESH),
            ("paper", WHITE),
            ("before", UNCOMPENSATED),
            ("after", COMPENSATED),
            ("servo", SERVO),
            ("full", FULL),
            ("x", AXES[0]),
            ("y", AXES[1]),
            ("z", AXES[2]),
            ("a", ROTARY[0]),
            ("b", ROTARY[1]),
            ("c", ROTARY[2]),
            ("measured", MEASURED),
            ("warning", LIMIT),
        ];
        for (name, colour) in named {
            let line = format!("  {name}: [\"{}\", \"{}\"],", colour.hex(), dark(colour).hex()).to_lowercase();
            assert!(theme.contains(&line), "desk/src/core/theme.ts: needed{line}");
        }
        for stops in ERRORS {
            let stops = stops.map(|Colour(red, green, blue)| format!("[{red}, {green}, {blue}]"));
            assert!(theme.contains(&stops.join(", ")), "desk/src/core/theme.ts: needed {}", stops.join(", "));
        }
    }
}
