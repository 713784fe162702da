//! Changes that a probing makes to the machine's files.

use super::growth::grown;
use super::reprobing::Reprobing;
use super::task::{Home, KeepTask};
use crate::calibrate::{Term, Terms};
use anyhow::{Result, anyhow};
use std::path::{Path, PathBuf};
use trueaxis::machine::Axis;
use trueaxis_tables::files::Source;
use trueaxis_tables::finding::{Decision, Finding, Known};
use trueaxis_tables::text::decode;
use trueaxis_tables::{Additions, Machine};

/// Changes to the machine's files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Decisions on every moved term that has its own figure.
    pub decisions: Vec<Decision>,
    /// Names in the machine's folder with the new text; `machine.toml` last of the machine's own.
    pub files: Vec<(PathBuf, String)>,
    /// A sentence on each change.
    pub notes: Vec<String>,
}

/// Computes the changes that a probing makes to a machine; `name` is its `machine.toml` in `source`. The residual found with
/// the tables active is added to their present values. Writes nothing.
///
/// # Errors
/// A result that the controller would refuse, or a thermal model without a curve for the growth.
pub fn changes(
    task: &KeepTask,
    reprobing: &Reprobing,
    machine: &Machine,
    source: &dyn Source,
    name: &Path,
) -> Result<Changes> {
    let terms = &reprobing.calibration.observed.terms;
    let mut changes = Changes::default();
    if let Some(thermal) = task.thermal.as_ref() {
        let updates = reprobing.updates(task, Home::Thermal);
        if updates.iter().any(|value| *value != 0.0) {
            let path = source.path(Path::new(thermal));
            let bytes = source.read(Path::new(thermal)).map_err(|error| anyhow!("{}: {error}", path.display()))?;
            let text = decode(bytes, &path, &['#'])?;
            let text = grown(&text, &path, machine, terms, &updates)?;
            changes.notes.push(format!("growth added to {thermal}"));
            changes.files.push((thermal.into(), text));
        }
    }
    let updates = reprobing.updates(task, Home::Machine);
    if updates.iter().any(|value| *value != 0.0) {
        let errors = reprobing.verdicts.iter().map(|verdict| verdict.standard_error);
        let degrees_of_freedom = reprobing.calibration.solution.degrees_of_freedom;
        let additions = additions(terms, &updates, &errors.collect::<Vec<_>>(), degrees_of_freedom);
        changes.decisions = additions.decide(source, name)?;
        changes.notes.extend(changes.decisions.iter().map(ToString::to_string));
        let edited = additions.edit(source, name)?;
        changes.notes.extend(edited.notes);
        changes.files.extend(edited.files);
    }
    Ok(changes)
}

/// Values of moved terms as additions, with their standard uncertainties and the degrees of freedom of those.
fn additions(terms: &Terms, values: &[f64], errors: &[f64], degrees_of_freedom: usize) -> Additions {
    let mut additions = Additions::default();
    let mut with_curves: Vec<Axis> = Vec::new();
    let changed = terms.terms.iter().zip(values).zip(errors).filter(|((_, value), _)| **value != 0.0);
    for ((term, value), error) in changed {
        let (key, factor) = match *term {
            Term::Squareness(which) => {
                (format!("location.{}_urad", ["C0Y", "B0Z", "A0Z"][usize::from(which) % 3]), 1e6)
            }
            Term::Location(_, component) if component < 3 => (format!("location.{}_um", term.name()), 1e3),
            Term::Location(..) => (format!("location.{}_urad", term.name()), 1e6),
            Term::Backlash(axis) => (format!("axis.{}.backlash_um", axis.letter()), 1e3),
            Term::Curve { axis, .. } => {
                if !with_curves.contains(&axis) {
                    with_curves.push(axis);
                }
                continue;
            }
        };
        additions.findings.push(Finding {
            key,
            found: Known::new(factor * value, factor * error, degrees_of_freedom),
            on_top: true,
            moved: true,
            ..Finding::default()
        });
    }
    // Straight lines: both ends of the travel suffice, and no table grows from update to update.
    let line = |axis: Axis| {
        let ends = terms.travel_mm[axis.index() % 3].into_iter();
        (axis, ends.map(|q| (q, terms.error(values, axis, q))).collect())
    };
    additions.curves = with_curves.into_iter().map(line).collect();
    additions
}
