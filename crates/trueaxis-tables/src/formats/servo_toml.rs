//! Writes drive, friction, dynamic correction, contour feedback and cross-talk in the form in which they are read.

use super::decimal::shortest;
use super::toml_lines::{Lines, section};
use crate::read::unit_of;
use std::fmt::Write;
use trueaxis::machine::{
    AxisSettings, CrosstalkSettings, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings,
};

/// Default for values that are always written.
const NO_DEFAULT: f64 = f64::NAN;

/// Writes those sections of an axis that it has.
pub(super) fn axis(text: &mut String, own: &AxisSettings) {
    let name = format!("axis.{}", own.axis.letter());
    if let Some(figures) = &own.servo.drive {
        section(text, &format!("{name}.drive"), &drive(figures).0);
    }
    let rotary = own.axis.is_rotary();
    let (unit, micro) = if rotary { ("deg", "urad") } else { ("mm", "um") };
    // Degrees written as µrad are converted through rad.
    let (base, scale) = if rotary { (1f64.to_radians(), 1e6) } else { (1.0, 1e3) };
    if let Some(own) = &own.servo.friction {
        let mut lines = Lines::default();
        let plain = FrictionSettings::with_defaults(NO_DEFAULT, NO_DEFAULT);
        lines.number(&format!("coulomb_{unit}_per_s"), own.coulomb_per_s, plain.coulomb_per_s);
        lines.scaled(&format!("presliding_{micro}"), own.presliding * base, plain.presliding, scale);
        lines.number("stribeck_share", own.stribeck_share, plain.stribeck_share);
        let velocity = format!("stribeck_velocity_{unit}_per_s");
        lines.number(&velocity, own.stribeck_velocity_per_s, plain.stribeck_velocity_per_s);
        lines.number("viscous", own.viscous, plain.viscous);
        lines.number("lead_s", own.lead_s, plain.lead_s);
        lines.number("adapt", own.adapt, plain.adapt);
        section(text, &format!("{name}.friction"), &lines.0);
    }
    if let Some(dynamic) = &own.servo.dynamic {
        let mut lines = Lines::default();
        let plain = DynamicSettings::with_defaults(own.axis).limits;
        let limits = &dynamic.limits;
        if limits.magnitude != plain.magnitude {
            lines.scaled(&format!("magnitude_{micro}"), limits.magnitude * base, NO_DEFAULT, scale);
        }
        lines.number(&format!("slope_{unit}_per_s"), limits.slope_per_s, plain.slope_per_s);
        let acceleration = format!("acceleration_{unit}_per_s2");
        lines.number(&acceleration, limits.acceleration_per_s2, plain.acceleration_per_s2);
        // All three, since a section without a line would be left out.
        for (key, on) in [("lag", dynamic.lag), ("acceleration", dynamic.acceleration), ("take_up", dynamic.take_up)] {
            lines.put(key, on);
        }
        lines.number("lag_s", dynamic.lag_s, 0.0);
        section(text, &format!("{name}.dynamic"), &lines.0);
    }
}

fn drive(own: &DriveFigures) -> Lines {
    let mut lines = Lines::default();
    let plain = DriveFigures::with_defaults(NO_DEFAULT, NO_DEFAULT, NO_DEFAULT);
    for (key, value, default) in [
        ("position_gain_per_s", own.position_gain_per_s, plain.position_gain_per_s),
        ("velocity_gain_per_s", own.velocity_gain_per_s, plain.velocity_gain_per_s),
        ("reset_time_s", own.reset_time_s, plain.reset_time_s),
        ("velocity_feed_forward", own.velocity_feed_forward, plain.velocity_feed_forward),
        ("current_loop_s", own.current_loop_s, plain.current_loop_s),
        ("dead_time_s", own.dead_time_s, plain.dead_time_s),
        ("resonance_hz", own.resonance_hz, plain.resonance_hz),
        ("resonance_damping", own.resonance_damping, plain.resonance_damping),
        ("lowest_resonance_hz", own.lowest_resonance_hz, plain.lowest_resonance_hz),
    ] {
        lines.number(key, value, default);
    }
    lines
}

/// `[contour.feedback]`, with all its keys.
pub(super) fn feedback(text: &mut String, own: &FeedbackSettings) {
    let mut lines = Lines::default();
    lines.number("proportional", own.proportional, NO_DEFAULT);
    lines.number("integral_per_s", own.integral_per_s, NO_DEFAULT);
    lines.scaled("max_feed_mm_per_min", own.max_feed_per_s, NO_DEFAULT, 60.0);
    lines.scaled("watch_um", own.watch_mm, NO_DEFAULT, 1e3);
    section(text, "contour.feedback", &lines.0);
}

/// `[[crosstalk]]`.
pub(super) fn crosstalk(text: &mut String, own: &CrosstalkSettings) {
    let (key, scale) = unit_of(own.from);
    let (tip, from) = (own.tip.letter(), own.from.letter());
    let _ = write!(text, "\n[[crosstalk]]\ntip = \"{tip}\"\nfrom = \"{from}\"\n");
    let _ = match own.points.as_slice() {
        [[position, k]] if own.over == own.from && *position == 0.0 => {
            writeln!(text, "{key} = {:?}", shortest(*k, scale))
        }
        points => {
            let pairs: Vec<String> =
                points.iter().map(|[position, k]| format!("[{position:?}, {:?}]", shortest(*k, scale))).collect();
            writeln!(text, "over = \"{}\"\ntable = [{}]", own.over.letter(), pairs.join(", "))
        }
    };
}
