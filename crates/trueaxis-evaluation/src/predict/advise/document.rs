//! The advice as a document.

use serde::Serialize;
use trueaxis_metrology::uncertainty::Interval;

/// What to do about a predicted part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// A short set of measurements with which most characteristics get a verdict, in the order of the part's file.
    pub measurements: Vec<Measurement>,
    /// Whether it is the shortest of all sets: every set was compared.
    pub exact: bool,
    /// Time of all of them.
    pub minutes: f64,
    /// Every toleranced characteristic before and after them, in the order of the part.
    pub features: Vec<Advised>,
    /// Measurements that are possible and were compared.
    pub compared: Vec<String>,
    /// Measurements that are not possible, and why.
    pub left_out: Vec<String>,
    /// Lasers that are used along several axes: what is common to these uses, such as the wavelength, is taken as independent.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub independent: Vec<String>,
    /// Another place or direction, if they were compared.
    #[serde(flatten)]
    pub elsewhere: Option<Elsewhere>,
    /// Characteristics to which the correction gives another verdict, in words.
    pub corrected: Vec<String>,
    /// The task of `calibrate plan`, if one is needed: all but the machine's folder.
    #[serde(skip)]
    pub task: Option<AdvisedTask>,
}

/// The task for the artefacts that were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct AdvisedTask {
    pub(super) probe: super::instrument::Touching,
    pub(super) scatter_mm: f64,
    pub(super) artefacts: Vec<String>,
}

/// A measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measurement {
    /// Instrument, and where or along which axis it is used.
    pub name: String,
    /// Time.
    pub minutes: f64,
    /// Whether it is part of the task of `calibrate plan`.
    pub in_task: bool,
    /// The owner's own task of `calibrate plan`, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
}

/// A characteristic before and after the measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advised {
    /// Name of the feature.
    pub feature: String,
    /// The characteristic.
    pub kind: &'static str,
    /// Expanded uncertainty before the measurements.
    pub before_um: f64,
    /// Expanded uncertainty after them.
    pub after_um: f64,
    /// Expanded uncertainty after every measurement that is possible.
    pub least_um: f64,
    /// Interval expected after the measurements, if they confirm the predicted value.
    pub interval_um: Interval,
    /// Verdict before.
    pub verdict_before: &'static str,
    /// Verdict expected after.
    pub verdict_after: &'static str,
    /// What keeps an undecided feature uncertain.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left: Vec<Left>,
    #[serde(skip)]
    pub(super) title: String,
}

/// A term that keeps a feature uncertain after the measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Left {
    /// Name of the term.
    pub term: String,
    /// Share of the variance that is left, 0 … 1.
    pub share: f64,
    /// Whether one of the measurements depends on it.
    pub is_measured: bool,
}

/// The part at other places, its features cut in the other direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Elsewhere {
    /// Where on the table the part is better, before the measurements.
    pub place: Option<Placed>,
    /// Number of places compared.
    pub places_compared: usize,
    /// Number of places refused: the part or its correction leaves the travel there.
    pub places_refused: usize,
    /// Features that are better cut in the other direction.
    pub directions: Vec<Directed>,
    /// Whether the prediction has the servo, without which all of them are compared.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub without_servo: bool,
}

/// A place of the part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Placed {
    /// Program zero in machine coordinates.
    pub at_mm: [f64; 3],
    /// Characteristics that conform where the part is, and at this place.
    pub conform: [usize; 2],
    /// Largest end of an interval as a share of the tolerance, where the part is.
    pub here: f64,
    /// The same at this place.
    pub there: f64,
}

/// A feature cut in the other direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Directed {
    /// The feature.
    pub feature: String,
    /// The characteristic that improves most.
    pub kind: &'static str,
    /// Its largest end as a share of the tolerance, as programmed.
    pub here: f64,
    /// The same in the other direction.
    pub there: f64,
}

impl AdvisedTask {
    /// Text of the task; `machine`: the machine's folder from where the task will be.
    pub fn text(&self, machine: &str) -> String {
        super::text::task_text(machine, &self.probe, self.scatter_mm, &self.artefacts)
    }
}
