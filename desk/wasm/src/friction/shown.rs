//! Tables of the circles simulated without and with the identified friction.

use trueaxis_evaluation::friction::{Deviation, FIGURES, deviations};
use trueaxis_evaluation::shown::{Cell, Quantity, Shown, Table, Uncertainty};
use trueaxis_sim::friction::{Figures, Outcome};
use trueaxis_sim::run::Size;

/// In the order of [`FIGURES`].
fn values(of: &Figures<f64>) -> [f64; 9] {
    [
        of.coulomb_mm_per_s,
        of.presliding_um,
        of.stribeck_share,
        of.stribeck_velocity_mm_per_s,
        of.viscous,
        of.position_gain_per_s,
        of.velocity_gain_per_s,
        of.reset_time_s,
        of.velocity_feed_forward,
    ]
}

pub(super) fn shown(outcome: &Outcome) -> Shown {
    let size = |name: String, of: Size| (name, Deviation { max: of.max, rms: of.rms });
    let spikes = outcome.axes.iter().flat_map(|own| {
        let (axis, of) = (own.axis, &own.glitch_um);
        [("before", of.before), ("expected after", of.expected), ("after", of.after)]
            .map(|(name, of)| size(format!("{axis} {name}"), of))
    });
    let error = &outcome.contour_error_um;
    let error = [size("before".into(), error.before), size("after".into(), error.after)];
    let found: Vec<[[f64; 9]; 2]> =
        outcome.axes.iter().map(|own| [values(&own.identified), values(&own.r#true)]).collect();
    let truth = FIGURES.into_iter().enumerate().map(|(k, (quantity, symbol, unit))| {
        let name = Quantity::new(quantity, unit, None, Uncertainty::Unknown).symbol(symbol).label();
        let cells = found.iter().flatten().map(|values| Cell::number(values[k], 4));
        std::iter::once(name.into()).chain(cells).collect()
    });
    let axes = outcome.axes.iter().flat_map(|own| [format!("{} found", own.axis), format!("{} true", own.axis)]);
    Shown {
        title: "Friction, simulated again".into(),
        tables: vec![
            deviations("Spikes, simulated again", "spikes", spikes),
            deviations("Contour error of the tip, geometry included", "pass", error),
            Table::new("Found against the simulated drives", std::iter::once("figure".into()).chain(axes), truth),
        ],
        ..Shown::default()
    }
}
