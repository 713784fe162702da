//! The origin of a network, for the words of its refusals.

use super::observed::Observed;
use super::plan::Plan;
use super::task::Task;
use super::terms::Term;
use super::unseen;
use anyhow::{Result, anyhow};
use std::path::{Path, PathBuf};
use trueaxis_metrology::calibration::{CalibrationRefusal, Surface};
use trueaxis_tables::error::FileError;

/// The log, with the names that errors need.
pub(super) struct Source<'s> {
    pub(super) task: &'s Task,
    pub(super) plan: &'s Plan,
    pub(super) file: &'s Path,
    pub(super) lines: Vec<u32>,
}

impl Source<'_> {
    pub(super) fn error(&self, line: Option<u32>, found: impl ToString, needed: impl ToString) -> anyhow::Error {
        let file: PathBuf = self.file.into();
        FileError { file, line, column: None, found: found.to_string(), needed: needed.to_string() }.into()
    }

    pub(super) fn line(&self, touch: usize) -> Option<u32> {
        self.lines.get(touch).copied()
    }

    /// Refuses placements of a plate of unknown places that leave combinations of its unknowns free.
    pub(super) fn separates(&self, observed: &Observed) -> Result<()> {
        if self.task.plate().is_none() {
            return Ok(());
        }
        let mut network = observed.network.clone();
        // A ball beside the plate is known, but too small for a scale: it counts against drift and for lost motion only.
        for touch in network.touches.iter_mut().filter(|touch| matches!(touch.surface, Surface::Ball { .. })) {
            let all = touch.response.iter_mut().zip(&observed.terms.terms);
            all.filter(|(_, term)| !matches!(term, Term::Backlash(_))).for_each(|(response, _)| *response = [0.0; 3]);
        }
        let combinations = network.free();
        if combinations.is_empty() {
            Ok(())
        } else {
            Err(self.refused(observed, CalibrationRefusal::NotApart { combinations }))
        }
    }

    pub(super) fn refused(&self, observed: &Observed, refused: CalibrationRefusal) -> anyhow::Error {
        match refused {
            CalibrationRefusal::NotApart { combinations } => {
                let file = self.task.file.clone();
                let line = Some(self.line_of(observed, &combinations));
                if let Some((plate, grid)) = self.task.plate().and_then(|plate| Some((plate, plate.grid()?))) {
                    let (found, needed) = unseen::words(plate, grid, observed, &combinations);
                    let column = Some("plate.placement".into());
                    return FileError { file, line: Some(plate.line), column, found, needed }.into();
                }
                let sentences: Vec<String> =
                    combinations.iter().map(|parts| words(parts, observed, self.task.word())).collect();
                let one = sentences.first().cloned().unwrap_or_default();
                let more = match sentences.len() {
                    0 | 1 => String::new(),
                    2 => String::from(", and one more combination"),
                    count => format!(", and {} more combinations", count - 1),
                };
                let found = format!("a set-up that cannot {one}{more}");
                let needed = if self.task.is_read() {
                    "dials that do (a reversal, the uncertainty of an artefact, more points), or fewer unknowns in [solve]"
                } else {
                    "artefacts or places that do (a known size along each of them, a ball for the tip's radius, a \
                     reversal), or fewer unknowns in [solve]"
                };
                FileError { file, line, column: None, found, needed: needed.into() }.into()
            }
            CalibrationRefusal::Unsettled { touch, residual_mm } => {
                let (word, numbers) = (self.task.word(), observed.numbers(touch));
                let touch = observed.first(touch);
                let found = format!("{word} {numbers} {residual_mm:.3} mm off {}", self.name(touch));
                self.error(self.line(touch), found, format!("every {word} on the artefact that the task names"))
            }
            CalibrationRefusal::NotFinite { touch } => {
                self.error(self.line(observed.first(touch)), "a position that is not a number", "numbers")
            }
            CalibrationRefusal::TooFew { found, needed } => {
                self.error(None, format!("{found} {}", self.task.words()), format!("at least {needed}"))
            }
            refused => anyhow!("{}: {refused}", self.task.file.display()),
        }
    }

    /// Line of the task's first artefact that has a part in a combination, or of its first one.
    fn line_of(&self, observed: &Observed, combinations: &[Vec<(usize, f64)>]) -> u32 {
        let has_part = |index: &usize| combinations.iter().flatten().any(|(part, _)| part == index);
        let concerned = |of: usize| {
            let places = observed.places.get(of).into_iter().flatten();
            let sizes = observed.sizes.get(of).into_iter().flatten();
            let length = observed.lengths.get(of).and_then(Option::as_ref);
            places.chain(sizes).chain(length).any(has_part)
        };
        let all = &self.task.artefacts;
        let found = (0..all.len()).find(|of| concerned(*of)).and_then(|of| all.get(of)).or(all.first());
        found.map_or(0, |artefact| artefact.line)
    }

    pub(super) fn name(&self, touch: usize) -> String {
        let of = self.plan.touches.get(touch).and_then(|touch| self.task.artefacts.get(touch.artefact));
        of.map_or(String::new(), |artefact| artefact.name.clone())
    }
}

/// Describes a combination in words, the machine's terms first.
fn words(parts: &[(usize, f64)], observed: &Observed, word: &str) -> String {
    let mut parts = parts.to_vec();
    trueaxis_metrology::order::sort_by_number(&mut parts, |one| -one.1.abs());
    // Places only follow the terms: they are named only if nothing else can be.
    let sizes: Vec<&(usize, f64)> = parts.iter().filter(|(index, _)| observed.is_term_or_size(*index)).collect();
    let said = if sizes.is_empty() { parts.iter().collect() } else { sizes };
    let names: Vec<&str> =
        said.iter().take(6).filter_map(|(index, _)| observed.names.get(*index).map(String::as_str)).collect();
    let more = if said.len() > 6 { " and others" } else { "" };
    match names.split_last() {
        Some((last, [])) => format!("determine {last}, which no {word} sees"),
        Some((last, rest)) => format!("separate {} and {last}{more}", rest.join(", ")),
        None => String::new(),
    }
}
