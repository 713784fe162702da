//! Whether a part will be in tolerance on a machine, before it is cut.
//!
//! ```text
//! PART.toml, program ─► points of the features, in the order in which they are cut
//! point             = programmed point + error of the exact transforms, axes where the drives bring them
//! y                 = characteristic of the features fitted to the points
//! y(z)              ≈ y(0) + Σ_k ∂y/∂z_k z_k       z_k: the machine's uncertain quantities, of unit variance, correlated as
//!                                                  stated
//! ```
//!
//! The machine is the stated one. Uncorrected, the drives get the commands; corrected, the commands with the correction of the
//! machine's own tables, so that the residual of its model remains. Lost motion follows the direction in which each drive
//! arrives, from the start of the program on; it is taken up at once.
//!
//! Draws of the quantities, 10,000 of them unless told otherwise, give the interval of 95 % of each characteristic through
//! the derivatives. 200 of them are also cut by exact transforms and fitted again. Where the two differ, as for the width of
//! a zone, which cannot fall below zero, all draws are cut that way in place of the derivatives.
//!
//! Where temperatures are known the growth of machine and part is added; with runs of the servo the axes are where the drives
//! bring them. The result excludes the process.
//!
//! Sources: JCGM 101:2008, clause 7; ISO 14253-1:2017, clause 5; ISO 1101:2017 (zones); ISO 5459:2011 (datums).

mod advise;
mod characteristic;
mod chords;
mod circle;
mod cut;
mod document;
mod find;
mod fit;
mod fixture;
mod gear;
mod inputs;
mod kinds;
mod live;
mod locate;
mod part;
mod prepared;
mod profile;
mod room;
mod run;
mod servo;
mod shape;
mod shown;
mod temperature;
mod times;
mod unknowns;
mod used;
mod verdict;
mod zone;

pub use advise::{
    Advice, Advised, AdvisedTask, Directed, Elsewhere, Instrument, InstrumentKind, Left, Measurement, Placed, Touching,
    advise, elsewhere,
};
pub use document::{Contribution, Known, PredictDocument, Predicted, Shape};
pub use find::{Found, LeftOut, find, sections};
pub use fixture::{Setup, Tool};
pub use gear::{FlankDeviation, GearFlank};
pub use inputs::{PartFiles, growth_model, own_task, thermal_beside};
pub use live::Live;
pub use part::{Association, Characteristic, Feature, FeatureKind, Part, Side, Tolerance};
pub use servo::ServoDocument;
pub use temperature::{
    AxisGrowth, Expansion, Growth, GrowthModel, PartTemperature, SensorTemperature, SetupStart, Start, TEMPERATURES,
    TemperatureDocument, TemperatureRecord,
};

use anyhow::{Result, bail};
use cut::State;
use document::Outcome;
use prepared::{Prepared, Servo};
use trueaxis_metrology::cores::*;
use trueaxis_metrology::uncertainty::Correlations;
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;
use unknowns::{Model, Unknown};

/// Draws cut by exact transforms as a check of the derivatives, the least number of draws.
const CHECKED: u64 = 200;
/// Most draws: what takes minutes.
const MOST_TRIALS: u64 = 1_000_000;
/// Difference above which the derivatives are replaced: a share of the standard deviation, plus a length that no instrument
/// resolves, mm.
const DIFFERENCE: f64 = 0.05;
const NOTHING: f64 = 1e-6;

/// The draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Number of machines drawn, 200 to 1,000,000.
    pub trials: u64,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Options { trials: 10_000, seed: 1 }
    }
}

/// Predicts the part that a program cuts on a machine.
///
/// Without any uncertainty stated, only the deviations are predicted.
///
/// # Errors
/// A number of draws out of its range; a part without tolerances; a machine without X, Y or Z, or that the model refuses; a
/// program that turns axes that the machine does not have or leaves the travel; features that their lines do not cut; datums
/// that are not made before the features that refer to them.
pub fn predict(
    machine: &Machine,
    stated: &Uncertainties,
    program: &Program,
    part: &Part,
    options: Options,
) -> Result<PredictDocument> {
    predicted((machine, stated), program, part, options, None)
}

/// As [`predict`], with the servo: runs of the simulator at a servo rate, Hz, bring the axes where the drives do. Verdicts and
/// uncertainties are those of everything on. `on_progress` gets the cycles done and all cycles.
///
/// # Errors
/// As [`predict`]; a moving axis without figures of its drive; a program or machine that the simulator refuses.
pub fn predict_with_servo(
    (machine, stated): (&Machine, &Uncertainties),
    program: &Program,
    part: &Part,
    options: Options,
    rate_hz: f64,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<PredictDocument> {
    predicted((machine, stated), program, part, options, Some((rate_hz, on_progress)))
}

fn predicted(
    (machine, stated): (&Machine, &Uncertainties),
    program: &Program,
    part: &Part,
    options: Options,
    servo: Option<Servo<'_>>,
) -> Result<PredictDocument> {
    if !(CHECKED..=MOST_TRIALS).contains(&options.trials) {
        bail!("trials: found {}, needed {CHECKED} to {MOST_TRIALS}", options.trials);
    }
    let mut prepared = Prepared::new(machine, stated, program, part)?;
    let mut servo =
        servo.map(|servo| prepared.follow((machine, stated), program, part, options.seed, servo)).transpose()?;
    let model = prepared.model(machine, part);
    let nothing = model.nothing();
    let points = |state: State| model.points(&nothing, state);
    let points = [points(State::Uncorrected)?, points(State::Corrected)?, points(State::Everything)?];
    let [uncorrected, corrected, everything] = points.each_ref().map(|points| model.values(points));
    let [uncorrected, corrected, everything] = [uncorrected?, corrected?, everything?];
    let outcomes = if model.terms.all.is_empty() { Vec::new() } else { outcomes(&model, &everything, options)? };
    let mut departure = (Vec::new(), 0);
    if let Some(servo) = servo.as_mut().filter(|servo| !servo.drawn.is_empty()) {
        departure = servo::departure(&model, &servo.drawn, &outcomes)?;
        servo.document.departure = departure.0.iter().copied().reduce(f64::max);
    }
    let values = [&uncorrected[..], &corrected, &everything];
    let servo = servo.map(|servo| servo.document);
    let mut document = PredictDocument::new(&model, program, options, (values, servo), outcomes);
    let titles: Vec<String> = document.features.iter().map(Predicted::title).collect();
    document.warnings.extend(servo::notes(&titles, &departure.0, departure.1));
    let shapes = shape::drawn(&model, points.each_ref().map(Vec::as_slice), &document);
    Ok(PredictDocument { temperature: prepared.temperature, shapes, ..document })
}

/// Derivatives of all characteristics with respect to an unknown, and what it contributes to their standard uncertainties.
struct Response {
    derivatives: Vec<f64>,
    contributions: Vec<f64>,
}

fn response(model: &Model<'_>, unknown: &Unknown, at_zero: &[f64]) -> Result<Response> {
    let up = model.cut(&model.alone(unknown, 1.0), State::Everything)?;
    let down = model.cut(&model.alone(unknown, -1.0), State::Everything)?;
    let (mut derivatives, mut contributions) = (Vec::new(), Vec::new());
    for ((up, down), zero) in up.iter().zip(&down).zip(at_zero) {
        let [more, less] = [up - zero, down - zero];
        derivatives.push(if unknown.squared { 0.5 * (more + less) } else { 0.5 * (more - less) });
        // Also where both directions widen a zone and the derivative vanishes.
        contributions.push((0.5 * (more * more + less * less)).sqrt());
    }
    Ok(Response { derivatives, contributions })
}

fn responses(model: &Model<'_>, unknowns: &[Unknown], at_zero: &[f64]) -> Result<Vec<Response>> {
    (0..unknowns.len()).into_par_iter().map(|k| response(model, &unknowns[k], at_zero)).collect()
}

fn correlations(model: &Model<'_>, unknowns: &[Unknown]) -> Correlations {
    let of: Vec<usize> = unknowns.iter().map(|unknown| unknown.term).collect();
    model.terms.correlated.of_quantities(model.terms, &of)
}

/// What the draws give for each tolerance.
fn outcomes(model: &Model<'_>, at_zero: &[f64], Options { trials, seed }: Options) -> Result<Vec<Outcome>> {
    let unknowns = model.unknowns();
    let responses = responses(model, &unknowns, at_zero)?;
    let correlations = correlations(model, &unknowns);
    let linear = |number: u64| -> Vec<f64> {
        let drawn = model.draw(seed, number);
        let mut values = at_zero.to_vec();
        for (unknown, response) in unknowns.iter().zip(&responses) {
            let z = drawn.of(unknown);
            values.iter_mut().zip(&response.derivatives).for_each(|(value, derivative)| *value += z * derivative);
        }
        values
    };
    let by_derivatives: Vec<Vec<f64>> = (0..trials).into_par_iter().map(linear).collect();
    let exact = |numbers: std::ops::Range<u64>| {
        let cut = |number| model.cut(&model.draw(seed, number), State::Everything);
        numbers.into_par_iter().map(cut).collect::<Result<Vec<_>>>()
    };
    let mut cut = exact(0..CHECKED)?;
    let differs: Vec<bool> = (0..at_zero.len()).map(|index| disagree(&by_derivatives, &cut, index)).collect();
    if differs.contains(&true) {
        cut.extend(exact(CHECKED..trials)?);
    }
    let outcome = |(index, differs): (usize, bool)| {
        let draws = if differs { &cut } else { &by_derivatives };
        let mut contributions = vec![0.0; model.terms.all.len()];
        for (unknown, response) in unknowns.iter().zip(&responses) {
            contributions[unknown.term] += response.contributions[index].powi(2);
        }
        let own: Vec<f64> = responses.iter().map(|response| response.derivatives[index]).collect();
        for ((unknown, own), common) in unknowns.iter().zip(&own).zip(correlations.times(&own)) {
            contributions[unknown.term] += own * (common - own);
        }
        Outcome { values: draws.iter().map(|values| values[index]).collect(), cut: differs, contributions }
    };
    Ok(differs.into_iter().enumerate().map(outcome).collect())
}

/// Whether the derivatives fail to give what the same draws cut.
fn disagree(by_derivatives: &[Vec<f64>], cut: &[Vec<f64>], index: usize) -> bool {
    let count = cut.len().max(1) as f64;
    let mean = cut.iter().map(|values| values[index]).sum::<f64>() / count;
    let variance = cut.iter().map(|values| (values[index] - mean).powi(2)).sum::<f64>() / count;
    let apart = cut.iter().zip(by_derivatives).map(|(cut, linear)| (cut[index] - linear[index]).powi(2));
    (apart.sum::<f64>() / count).sqrt() > DIFFERENCE * variance.sqrt() + NOTHING
}
