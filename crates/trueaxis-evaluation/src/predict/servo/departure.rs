//! How far the sum of the single effects is from parts cut by plants with all figures of their drives drawn at once.

use super::super::cut::{Cut, State};
use super::super::document::Outcome;
use super::super::fixture::Moves;
use super::super::unknowns::{Model, Unknown};
use super::Drawn;
use anyhow::Result;

/// Share of the scatter above which a note names a characteristic.
const NOTED: f64 = 0.05;

/// Root mean square difference of every characteristic as a share of its scatter, and how many plants the step stopped.
pub(in crate::predict) fn departure(
    model: &Model<'_>,
    drawn: &[Drawn],
    outcomes: &[Outcome],
) -> Result<(Vec<f64>, usize)> {
    let of_drives: Vec<usize> = model
        .part_terms()
        .zip(model.moves)
        .filter(|(_, of)| matches!(of, Moves::Drive))
        .map(|(term, _)| term)
        .collect();
    let mut squares = vec![0.0; outcomes.len()];
    let mut count = 0;
    for Drawn { z, errors } in drawn {
        let Some(errors) = errors else { continue };
        let mut cuts: Vec<Cut> = model.cuts.to_vec();
        for (point, error) in cuts.iter_mut().flat_map(|cut| &mut cut.points).zip(errors) {
            if let Some(error) = error {
                point.everything = point.after(*error);
            }
        }
        let full = Model { cuts: &cuts, ..*model }.cut(&model.nothing(), State::Everything)?;
        let mut sum = model.nothing();
        for (term, z) in of_drives.iter().zip(z) {
            sum.set(&Unknown { term: *term, index: 0, squared: false }, *z);
        }
        let sum = model.cut(&sum, State::Everything)?;
        for (to, (full, sum)) in squares.iter_mut().zip(full.iter().zip(&sum)) {
            *to += (full - sum).powi(2);
        }
        count += 1;
    }
    let share = |(squares, of): (&f64, &Outcome)| {
        let scatter = of.standard_deviation();
        if count > 0 && scatter > 0.0 { (squares / f64::from(count)).sqrt() / scatter } else { 0.0 }
    };
    Ok((squares.iter().zip(outcomes).map(share).collect(), drawn.len() - count as usize))
}

/// What a reader has to know of it; `titles`: of the characteristics.
pub(in crate::predict) fn notes(titles: &[String], shares: &[f64], stopped: usize) -> Vec<String> {
    let named = titles.iter().zip(shares).filter(|(_, share)| **share > NOTED);
    let named: Vec<String> = named.map(|(title, share)| format!("{title} ({:.0} %)", 100.0 * share)).collect();
    let mut notes = Vec::new();
    if !named.is_empty() {
        notes.push(format!(
            "the figures of the drives do not act one by one: with all drawn at once the part differs from the sum of their \
             effects by this share of the scatter: {}",
            named.join(", ")
        ));
    }
    if stopped > 0 {
        notes.push(format!(
            "the simulated controller stops {stopped} of {} machines with drawn figures of their drives",
            super::DRAWN
        ));
    }
    notes
}
