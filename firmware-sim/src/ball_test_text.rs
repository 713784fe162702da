//! JSON of the ball test.

use serde::Serialize;
use trueaxis_sim::ball_test::{BallCycle, Outcome, Stop, TipError};

#[derive(Serialize)]
struct BeforeAfter {
    before: TipError,
    after: TipError,
    /// Error after divided by error before.
    ratio: TipError,
}

impl BeforeAfter {
    fn new(before: TipError, after: TipError) -> BeforeAfter {
        BeforeAfter { before, after, ratio: TipError { max: after.max / before.max, rms: after.rms / before.rms } }
    }
}

#[derive(Serialize)]
struct AxisJson<'o> {
    axis: char,
    stops: usize,
    sigma_um: f64,
    degrees_of_freedom: usize,
    tip_error_um: BeforeAfter,
    over_angle: &'o [Stop],
}

/// The document that `--json` prints.
#[derive(Serialize)]
pub(crate) struct Json<'o> {
    machine: &'o str,
    chain: &'o str,
    gauge_noise_um: f64,
    seed: u64,
    tip_error_um: BeforeAfter,
    axes: Vec<AxisJson<'o>>,
}

/// The JSON document.
pub(crate) fn json<'o>(outcome: &'o Outcome, test: &'o BallCycle) -> Json<'o> {
    let axes = outcome.axes.iter().map(|of| AxisJson {
        axis: of.axis.letter(),
        stops: of.stops_deg.len(),
        sigma_um: 1e3 * of.found.sigma_mm,
        degrees_of_freedom: of.found.degrees_of_freedom,
        tip_error_um: BeforeAfter::new(of.before, of.after),
        over_angle: &of.over_angle,
    });
    Json {
        machine: &test.machine.settings.name,
        chain: &test.machine.settings.chain,
        gauge_noise_um: test.gauge_noise_um,
        seed: test.seed,
        tip_error_um: BeforeAfter::new(outcome.before, outcome.after),
        axes: axes.collect(),
    }
}
