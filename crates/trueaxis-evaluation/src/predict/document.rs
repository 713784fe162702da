//! The document of a predicted part.

use super::Options;
use super::advise::document::Advice;
use super::servo::ServoDocument;
use super::temperature::TemperatureDocument;
use super::unknowns::Model;
use super::verdict::verdict_of;
use serde::Serialize;
use trueaxis_metrology::order::sort_by_number;
use trueaxis_metrology::uncertainty::{Interval, quantile};
use trueaxis_sim::program::Program;

/// Coverage of the intervals.
const COVERAGE: f64 = 0.95;

/// The JSON document.
#[derive(Clone, Debug, Serialize)]
pub struct PredictDocument {
    /// Name of the part.
    pub part: String,
    /// Name of the program.
    pub program: String,
    /// Name of the machine.
    pub machine: String,
    /// Program zero in machine coordinates.
    pub at_mm: [f64; 3],
    /// Coverage of the intervals.
    pub confidence_percent: f64,
    /// Number of machines drawn.
    pub trials: u64,
    /// Seed of the draws.
    pub seed: u64,
    /// A toleranced characteristic each, in the order of the part.
    pub features: Vec<Predicted>,
    /// Temperatures while the part is cut, where they are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<TemperatureDocument>,
    /// The runs of the servo; `uncorrected_um` and `corrected_um` include its error then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<ServoDocument>,
    /// Keys of the machine that are not stated; their uncertainty counts as zero.
    pub not_stated: Vec<String>,
    /// Remarks: on the machine's uncertainties, and on limits that reduce its correction.
    pub warnings: Vec<String>,
    /// What to do about it, where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<Advice>,
    /// The features as a picture, in the order of the part.
    #[serde(skip)]
    pub shapes: Vec<Shape>,
}

/// A toleranced characteristic of a feature.
#[derive(Clone, Debug, Serialize)]
pub struct Predicted {
    /// Name of the feature.
    pub feature: String,
    /// The characteristic.
    pub kind: &'static str,
    /// How a form is associated with its points: `least squares` or `minimum zone`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub association: Option<&'static str>,
    /// Names of the datums; of a distance: the other feature.
    pub datums: Vec<String>,
    /// Predicted value without correction.
    pub uncorrected_um: f64,
    /// Predicted value with the machine's correction.
    pub corrected_um: f64,
    /// Predicted value with the servo and all that the machine configures against its error; absent without a run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub everything_um: Option<f64>,
    /// Least and greatest value that the tolerance permits; a zone has no least.
    pub limits_um: [Option<f64>; 2],
    /// What the uncertainties of the machine allow to say; absent if it states none.
    #[serde(flatten)]
    pub known: Option<Known>,
}

/// Uncertainty, verdict and budget of a characteristic of the corrected part.
#[derive(Clone, Debug, Serialize)]
pub struct Known {
    /// Expanded uncertainty: half of the interval.
    pub expanded_um: f64,
    /// Interval that contains the true value.
    pub interval_um: Interval,
    /// Probability that the true value is within the limits, 0 … 1.
    pub conformance: f64,
    /// `conforms`, `does not conform` or `undecided`, after ISO 14253-1.
    pub verdict: &'static str,
    /// Drawn parts cut by exact transforms that gave the interval; `null` if the derivatives did.
    pub parts_cut: Option<usize>,
    /// Contributions, largest first.
    pub budget: Vec<Contribution>,
}

/// Contribution of a term of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contribution {
    /// Name of the term: of its errors those of ISO 230-1.
    pub term: String,
    /// Contribution to the standard uncertainty; their squares add up to its square, those of negative ones subtracted.
    pub standard_um: f64,
    /// Share of the variance after the squares of the effects of each quantity alone, of a correlated one with half of what it
    /// has in common with each other one: negative where that makes the whole smaller. All shares add up to 1.
    pub share: f64,
}

/// A feature as a picture draws it.
#[derive(Clone, Debug, Serialize)]
pub struct Shape {
    /// Name of the feature.
    pub feature: String,
    /// Its kind, as a part's file names it.
    pub kind: &'static str,
    /// Whether the last point joins the first: a full circle.
    pub closed: bool,
    /// Programmed points in coordinates of the program, in the order in which they are cut, mm.
    pub points_mm: Vec<[f64; 3]>,
    /// Deviations of the points without correction, µm.
    pub uncorrected_um: Vec<[f64; 3]>,
    /// Deviations of the points with the machine's correction, µm.
    pub corrected_um: Vec<[f64; 3]>,
    /// Deviations of the points with everything on, µm; absent without a run of the servo.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub everything_um: Option<Vec<[f64; 3]>>,
    /// Worst verdict of its characteristics, in the words of [`Known::verdict`]; `null` without
    /// tolerances or uncertainties.
    pub verdict: Option<&'static str>,
    /// Largest share of a tolerance that is used ([`Predicted::used`]); `null` without tolerances.
    pub used: Option<f64>,
}

/// What the draws give for a tolerance, mm.
pub(super) struct Outcome {
    pub(super) values: Vec<f64>,
    /// Whether the values were cut by exact transforms.
    pub(super) cut: bool,
    /// Part of every term in the variance, mm²; negative where its correlation makes the whole smaller.
    pub(super) contributions: Vec<f64>,
}

impl PredictDocument {
    /// Values of all tolerances uncorrected, corrected and with everything on, mm; `outcomes` is empty without uncertainties.
    pub(super) fn new(
        model: &Model<'_>,
        program: &Program,
        Options { trials, seed }: Options,
        ([uncorrected, corrected, everything], servo): ([&[f64]; 3], Option<ServoDocument>),
        outcomes: Vec<Outcome>,
    ) -> PredictDocument {
        let part = model.part;
        let name = |index: usize| part.features[index].name.clone();
        let names: Vec<&str> = model.terms.all.iter().map(|term| term.name.as_str()).collect();
        let mut outcomes = outcomes.into_iter();
        let features = part.tolerances.iter().enumerate().map(|(index, of)| Predicted {
            feature: name(of.feature),
            kind: of.characteristic.name(),
            association: of.characteristic.is_form().then(|| of.association.name()),
            datums: of.datums.iter().copied().map(name).collect(),
            uncorrected_um: 1e3 * uncorrected[index],
            corrected_um: 1e3 * corrected[index],
            everything_um: servo.as_ref().map(|_| 1e3 * everything[index]),
            limits_um: of.limits.map(|mm| mm.is_finite().then_some(1e3 * mm)),
            known: outcomes.next().map(|outcome| outcome.known(of.limits, &names)),
        });
        PredictDocument {
            part: part.name.clone(),
            program: program.name.clone(),
            machine: model.machine.settings.name.to_string(),
            at_mm: part.at_mm,
            confidence_percent: 100.0 * COVERAGE,
            trials,
            seed,
            features: features.collect(),
            temperature: None,
            servo: servo.clone(),
            not_stated: model.terms.not_stated.clone(),
            warnings: model.terms.warnings.clone(),
            advice: None,
            shapes: Vec::new(),
        }
    }
}

impl Outcome {
    /// Scatter of the values, mm.
    pub(super) fn standard_deviation(&self) -> f64 {
        let count = self.values.len().max(1) as f64;
        let mean = self.values.iter().sum::<f64>() / count;
        (self.values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
    }

    fn known(mut self, [low, high]: [f64; 2], names: &[&str]) -> Known {
        self.values.sort_unstable_by(f64::total_cmp);
        let end = |p: f64| quantile(&self.values, p);
        let interval = Interval { low: end(0.5 * (1.0 - COVERAGE)), high: end(0.5 * (1.0 + COVERAGE)) };
        let inside = self.values.iter().filter(|value| (low..=high).contains(*value)).count();
        // What widens a zone from zero adds up to more than its scatter: the shares divide the scatter that was drawn.
        let whole: f64 = self.contributions.iter().sum();
        let share = |part: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let deviation = self.standard_deviation();
        let budget = names.iter().zip(&self.contributions).filter(|(_, part)| **part != 0.0);
        let mut budget: Vec<Contribution> = budget
            .map(|(term, part)| Contribution {
                term: (*term).to_owned(),
                standard_um: 1e3 * share(part.abs()).sqrt().copysign(*part) * deviation,
                share: share(*part),
            })
            .collect();
        sort_by_number(&mut budget, |one| -one.share.abs());
        Known {
            expanded_um: 1e3 * 0.5 * (interval.high - interval.low),
            interval_um: Interval { low: 1e3 * interval.low, high: 1e3 * interval.high },
            conformance: inside as f64 / self.values.len().max(1) as f64,
            verdict: verdict_of(interval, [low, high]),
            parts_cut: self.cut.then_some(self.values.len()),
            budget,
        }
    }
}
