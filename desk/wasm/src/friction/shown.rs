//! Tables of the circles simulated without and with the identified friction.

use trueaxis_evaluation::friction::{Deviation, against, deviations};
use trueaxis_evaluation::shown::Shown;
use trueaxis_metrology::friction::Identified;
use trueaxis_sim::friction::Outcome;
use trueaxis_sim::run::Size;

pub(super) fn shown(outcome: &Outcome, found: &[Identified]) -> Shown {
    let size = |name: String, of: Size| (name, Deviation { max: of.max, rms: of.rms });
    let spikes = outcome.axes.iter().flat_map(|own| {
        let (axis, of) = (own.axis, &own.glitch_um);
        [("before", of.before), ("expected after", of.expected), ("after", of.after)]
            .map(|(name, of)| size(format!("{axis} {name}"), of))
    });
    let error = &outcome.contour_error_um;
    let error = [size("before".into(), error.before), size("after".into(), error.after)];
    let truth: Vec<[f64; 9]> = outcome.axes.iter().map(|own| own.r#true.in_order()).collect();
    Shown {
        title: "Friction, simulated again".into(),
        tables: vec![
            deviations("Spikes, simulated again", "spikes", spikes),
            deviations("Contour error of the tip, geometry included", "pass", error),
            against(found, &truth),
        ],
        ..Shown::default()
    }
}
