//! Printed summary of the identified friction.

use std::fmt::{self, Write};
use trueaxis_report::number::significant;
use trueaxis_sim::friction::{Figures, Outcome, Pair};
use trueaxis_tables::text::counted;

fn rows<T: Copy>(figures: &Figures<T>) -> [T; 9] {
    [
        figures.coulomb_mm_per_s,
        figures.presliding_um,
        figures.stribeck_share,
        figures.stribeck_velocity_mm_per_s,
        figures.viscous,
        figures.position_gain_per_s,
        figures.velocity_gain_per_s,
        figures.reset_time_s,
        figures.velocity_feed_forward,
    ]
}

/// Names of the rows of [`Figures`].
const NAMES: [&str; 9] = [
    "F_c/K_vp, mm/s",
    "pre-sliding z, µm",
    "Stribeck share s",
    "v_s, mm/s",
    "viscous d/K_vp",
    "K_v, 1/s",
    "K_vp, 1/s",
    "τ, s",
    "k_ff",
];

pub(super) fn text(outcome: &Outcome) -> Result<String, fmt::Error> {
    let mut f = String::new();
    let [fast, slow] = outcome.feeds_mm_per_min;
    writeln!(
        f,
        "circles  R {} mm at {fast} and {slow} mm/min, {} each way, {} cycles at {} Hz",
        outcome.radius_mm,
        counted(outcome.turns as usize, "turn"),
        outcome.cycles,
        outcome.servo_rate_hz
    )?;
    for own in &outcome.axes {
        writeln!(f, "\naxis {}, {} reversals", own.axis, own.reversals)?;
        writeln!(f, "{:<22}{:>12}{:>14}{:>12}", "", "identified", "std. error", "true")?;
        let rows = NAMES.iter().zip(rows(&own.identified)).zip(rows(&own.standard_errors)).zip(rows(&own.r#true));
        for (k, (((name, value), error), truth)) in rows.enumerate() {
            let held = if k >= 5 && !own.drive_found { "the machine's" } else { "held" };
            let error = error.map_or_else(|| held.to_owned(), |error| significant(error, 2));
            writeln!(f, "{name:<22}{:>12}{error:>14}{:>12}", significant(value, 4), significant(truth, 4))?;
        }
        let spikes = &own.glitch_um;
        for (name, size) in [
            ("before", &spikes.before),
            ("predicted", &spikes.predicted),
            ("expected after", &spikes.expected),
            ("after", &spikes.after),
        ] {
            let [max, rms] = [size.max, size.rms].map(|um| significant(um, 3));
            writeln!(f, "spikes {name:<15}{max:>12} µm largest, {rms} µm RMS")?;
        }
    }
    let Pair { before, after } = &outcome.contour_error_um;
    let [a, b, c, d] = [before.max, before.rms, after.max, after.rms].map(|um| significant(um, 3));
    writeln!(f, "\ncontour error of the tip, geometry included: {a}/{b} µm largest/RMS before, {c}/{d} µm after")?;
    Ok(f)
}
