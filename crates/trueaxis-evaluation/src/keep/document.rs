//! A probing as a document and as an entry.

use super::entry::{BallPlace, Measured};
use super::reprobing::{Decision, Reprobing};
use super::task::KeepTask;
use serde::Serialize;
use std::collections::BTreeMap;

/// A term.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermDocument {
    /// Name in the task.
    pub name: String,
    /// Unit of all values.
    pub unit: &'static str,
    /// Residual that the tables leave.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
    /// Sum of the updates since the beginning.
    pub from: f64,
    /// That sum if this probing's update is applied.
    pub to: f64,
    /// `keep`, `update` or `refused`.
    pub verdict: &'static str,
    /// Why it is refused.
    pub reason: Option<String>,
    /// Largest single update.
    pub largest_update: f64,
    /// Largest sum of updates.
    pub largest_total: f64,
    /// Number of standard errors beyond which the term has moved.
    pub significance: f64,
}

/// The JSON document of a probing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReprobingDocument {
    /// The machine's name.
    pub machine: String,
    /// Number that the probing's entry has or would have.
    pub entry: u32,
    /// Number of touches.
    pub touches: usize,
    /// Standard deviation of a touch, from the residuals.
    pub sigma_um: f64,
    /// Every term.
    pub terms: Vec<TermDocument>,
    /// Every ball.
    pub balls: Vec<BallPlace>,
    /// Number of terms changed.
    pub updates: usize,
    /// Number of terms out of their bounds.
    pub refused: usize,
    /// Whether the files were changed.
    pub applied: bool,
    /// Decisions on every moved term that has its own figure; empty if a term is refused.
    pub written: Vec<trueaxis_tables::finding::Decision>,
    /// Caveats on the result.
    pub notes: Vec<String>,
    /// Degrees of freedom of the standard errors; infinite if these follow from the stated repeatability.
    #[serde(skip)]
    pub degrees_of_freedom: f64,
}

impl Reprobing {
    fn terms(&self, task: &KeepTask) -> Vec<TermDocument> {
        let term = |verdict: &super::Verdict| {
            let kept = task.terms.iter().find(|kept| kept.name == verdict.name)?;
            let (unit, factor) = kept.term.unit();
            let (name, reason) = match &verdict.decision {
                Decision::Unchanged => ("keep", None),
                Decision::Update => ("update", None),
                Decision::Refused(reason) => ("refused", Some(reason.clone())),
            };
            Some(TermDocument {
                name: verdict.name.clone(),
                unit,
                value: factor * verdict.value,
                standard_error: factor * verdict.standard_error,
                from: factor * verdict.total,
                to: factor * (verdict.total + verdict.update()),
                verdict: name,
                reason,
                largest_update: factor * kept.bounds.update,
                largest_total: factor * kept.bounds.total,
                significance: kept.bounds.significance,
            })
        };
        self.verdicts.iter().filter_map(term).collect()
    }

    /// The document.
    pub fn document(&self, task: &KeepTask, machine: &str, entry: u32) -> ReprobingDocument {
        let terms = self.terms(task);
        let count = |verdict: &str| terms.iter().filter(|term| term.verdict == verdict).count();
        let sigma = self.calibration.solution.sigma_mm;
        let mut notes = Vec::new();
        if sigma > 2.0 * task.probing.probe.repeatability_mm {
            notes.push(format!(
                "touches scatter by {:.2} µm, {:.2} µm is stated: errors that the terms do not model, or a less repeatable probe",
                1e3 * sigma,
                1e3 * task.probing.probe.repeatability_mm
            ));
        }
        ReprobingDocument {
            machine: machine.into(),
            entry,
            touches: self.calibration.observed.network.touches.len(),
            sigma_um: 1e3 * sigma,
            updates: count("update"),
            refused: count("refused"),
            terms,
            balls: self.balls.clone(),
            applied: false,
            written: Vec::new(),
            notes,
            degrees_of_freedom: self.calibration.solution.error_degrees_of_freedom(),
        }
    }

    /// The terms in the form of an entry.
    pub fn measured(&self, task: &KeepTask) -> Vec<Measured> {
        let of = |term: TermDocument| Measured {
            term: term.name,
            unit: term.unit.into(),
            value: rounded(term.value),
            standard_error: rounded(term.standard_error),
            from: rounded(term.from),
            to: rounded(term.to),
        };
        self.terms(task).into_iter().map(of).collect()
    }

    /// Sums of the updates after this probing.
    pub fn totals(&self, task: &KeepTask) -> BTreeMap<String, f64> {
        let terms = self.terms(task).into_iter();
        terms.filter(|term| term.to != 0.0).map(|term| (term.name, rounded(term.to))).collect()
    }
}

/// Rounds to a thousandth of a nanometre or nanoradian.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
