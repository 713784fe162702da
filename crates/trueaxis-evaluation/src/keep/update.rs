//! What a look changes in the machine's files.

use super::growth::grown;
use super::look::Look;
use super::task::{Home, Keep};
use crate::calibrate::{Term, Terms};
use anyhow::{Result, anyhow};
use std::path::{Path, PathBuf};
use trueaxis::machine::Axis;
use trueaxis_tables::files::Source;
use trueaxis_tables::text::decode;
use trueaxis_tables::{Additions, Machine};

/// Files as they would be.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Names in the machine's folder with the new text; `machine.toml` last of its own.
    pub files: Vec<(PathBuf, String)>,
    /// A sentence on each change.
    pub notes: Vec<String>,
}

/// The changes that a look makes to a machine; `name` is that of its `machine.toml` in `source`. The residual that was found
/// with the tables at work is added to what they say now. Nothing is written.
///
/// # Errors
/// A result that the controller would refuse, or a thermal model that has no curve to take the growth.
pub fn changes(keep: &Keep, look: &Look, machine: &Machine, source: &dyn Source, name: &Path) -> Result<Changes> {
    let terms = &look.calibration.observed.terms;
    let mut changes = Changes::default();
    if let Some(thermal) = keep.thermal.as_ref() {
        let updates = look.updates(keep, Home::Thermal);
        if updates.iter().any(|value| *value != 0.0) {
            let path = source.path(Path::new(thermal));
            let bytes = source.read(Path::new(thermal)).map_err(|error| anyhow!("{}: {error}", path.display()))?;
            let text = decode(bytes, &path, &['#'])?;
            let text = grown(&text, &path, machine, terms, &updates)?;
            changes.notes.push(format!("growth added to {thermal}"));
            changes.files.push((thermal.into(), text));
        }
    }
    let updates = look.updates(keep, Home::Machine);
    if updates.iter().any(|value| *value != 0.0) {
        let errors = look.verdicts.iter().map(|verdict| verdict.standard_error);
        let edited = additions(terms, &updates, &errors.collect::<Vec<_>>()).edit(source, name)?;
        changes.notes.extend(edited.notes);
        changes.files.extend(edited.files);
    }
    Ok(changes)
}

/// Values of terms as additions, with the standard uncertainties of those that change.
fn additions(terms: &Terms, values: &[f64], errors: &[f64]) -> Additions {
    let mut additions = Additions::default();
    let mut with_curves: Vec<Axis> = Vec::new();
    let changed = terms.terms.iter().zip(values).zip(errors).filter(|((_, value), _)| **value != 0.0);
    for ((term, value), error) in changed {
        match *term {
            Term::Squareness(which) => {
                let location = &mut additions.location;
                let (to, key) = match which {
                    0 => (&mut location.c0y, "C0Y"),
                    1 => (&mut location.b0z, "B0Z"),
                    _ => (&mut location.a0z, "A0Z"),
                };
                *to = *value;
                additions.set.push((format!("uncertainty.location.{key}_urad"), 1e6 * error));
            }
            Term::Location(axis, component) => {
                if let Some(to) = additions.location.rotary[axis.index() % 3].get_mut(usize::from(component)) {
                    *to = *value;
                }
                let unit = if component < 3 { "um" } else { "urad" };
                let key = format!("uncertainty.location.{}_{unit}", term.name());
                additions.set.push((key, term.unit().1 * error));
            }
            Term::Backlash(axis) => {
                additions.backlash.push((axis, *value));
                additions.set.push((format!("axis.{}.uncertainty.backlash_um", axis.letter()), 1e3 * error));
            }
            Term::Curve { axis, .. } if !with_curves.contains(&axis) => with_curves.push(axis),
            Term::Curve { .. } => {}
        }
    }
    // Straight lines: both ends of the travel are enough, and no table grows from update to update.
    let line = |axis: Axis| {
        let ends = terms.travel_mm[axis.index() % 3].into_iter();
        (axis, ends.map(|q| (q, terms.error(values, axis, q))).collect())
    };
    additions.curves = with_curves.into_iter().map(line).collect();
    additions
}
