//! Tables of circles simulated without and with the identified friction.

use crate::friction::{Deviation, against, deviations};
use crate::shown::Shown;
use trueaxis_metrology::friction::Identified;
use trueaxis_sim::friction::Outcome;
use trueaxis_sim::run::Size;
use trueaxis_tables::text::counted;

/// The figures beside the true ones, the spikes of both passes, and their contour errors.
pub fn shown(outcome: &Outcome, found: &[Identified]) -> Shown {
    let [fast, slow] = outcome.feeds_mm_per_min;
    let turns = counted(outcome.turns as usize, "turn");
    let size = |name: String, of: Size| (name, Deviation { max: of.max, rms: of.rms });
    let spikes = outcome.axes.iter().flat_map(|own| {
        let (axis, of) = (own.axis, &own.glitch_um);
        [("before", of.before), ("predicted", of.predicted), ("expected after", of.expected), ("after", of.after)]
            .map(|(name, of)| size(format!("{axis} {name}"), of))
    });
    let error = &outcome.contour_error_um;
    let error = [size("before".into(), error.before), size("after".into(), error.after)];
    let truth: Vec<[f64; 9]> = outcome.axes.iter().map(|own| own.r#true.in_order()).collect();
    Shown {
        title: "Friction from simulated circles".into(),
        summary: vec![
            format!("R {} mm at {fast} and {slow} mm/min, {turns} each way", outcome.radius_mm),
            format!("{} cycles at {} Hz", outcome.cycles, outcome.servo_rate_hz),
        ],
        tables: vec![
            against(found, &truth),
            deviations("Spikes, simulated again", "spikes", spikes),
            deviations("Contour error of the tip, geometry included", "pass", error),
        ],
        ..Shown::default()
    }
}
