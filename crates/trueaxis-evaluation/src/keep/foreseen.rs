//! Plans a task with its expected standard errors, in one call.

use super::reprobing::{foreseen, plan};
use super::task::KeepTask;
use crate::calibrate::{Plan, program};
use crate::shown::{Cell, EXPANDED, Table, Uncertainty};
use anyhow::Result;
use serde::Serialize;
use trueaxis_tables::Machine;

/// A term with the standard error expected of a probing, and its bounds; all in `unit`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Name in the task.
    pub name: String,
    /// Standard error from the stated repeatability.
    pub standard_error: f64,
    /// Unit of all values.
    pub unit: &'static str,
    /// Largest single update.
    pub largest_update: f64,
    /// Largest sum of updates since the beginning.
    pub largest_total: f64,
    /// Number of standard errors beyond which the term has moved.
    pub significance: f64,
}

/// The document that `trueaxis keep plan --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Foreseen {
    /// The machine's name.
    pub machine: String,
    /// Program number that the log states, eight hexadecimal digits.
    pub program: String,
    /// Number of touches.
    pub touches: usize,
    /// Duration of a probing, minutes.
    pub minutes: f64,
    /// Number of parts between two probings.
    pub every_parts: u32,
    /// Every term.
    pub terms: Vec<Expected>,
}

impl Foreseen {
    /// The uncertainties expected, and the bounds.
    pub fn expected(&self) -> Table {
        let rows = self.terms.iter().map(|of| {
            let [update, total] = [of.largest_update, of.largest_total].map(|bound| Cell::number(bound, 2));
            vec![
                of.name.as_str().into(),
                Uncertainty::foreseen(of.standard_error).cell(),
                update,
                total,
                of.unit.into(),
            ]
        });
        let header = ["term", EXPANDED, "at most at once", "at most in all", "unit"];
        Table::new("Expected uncertainty of every term", header, rows)
    }
}

/// A planned probing.
#[derive(Clone, Debug)]
pub struct Planning {
    /// Touches of the probing.
    pub plan: Plan,
    /// The program in the task's dialect.
    pub program: String,
    /// How well every term would be known.
    pub foreseen: Foreseen,
}

impl Planning {
    /// Plans the probings of a task on a machine.
    ///
    /// # Errors
    /// As [`plan`] and [`foreseen`].
    pub fn new(task: &KeepTask, machine: &Machine) -> Result<Planning> {
        let plan = plan(task, machine)?;
        let errors = foreseen(task, machine, &plan)?;
        let terms = task.terms.iter().zip(errors).map(|(kept, error)| {
            let (unit, factor) = kept.term.unit();
            Expected {
                name: kept.name.clone(),
                standard_error: factor * error,
                unit,
                largest_update: factor * kept.bounds.update,
                largest_total: factor * kept.bounds.total,
                significance: kept.bounds.significance,
            }
        });
        let foreseen = Foreseen {
            machine: machine.settings.name.to_string(),
            program: plan.number(),
            touches: plan.touches.len(),
            minutes: plan.minutes(),
            every_parts: task.every_parts,
            terms: terms.collect(),
        };
        Ok(Planning { program: program(&task.probing, machine, &plan), plan, foreseen })
    }
}
