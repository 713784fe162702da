//! Identified errors as an axis table.

use super::readings::SAME_ANGLE_DEG;
use anyhow::{Result, bail};
use trueaxis::machine::Row;
use trueaxis_metrology::identification::Identified;
use trueaxis_tables::Table;

/// A gap to the full circle of at most this many widest steps counts as a closed circle.
const CLOSING_STEPS: f64 = 1.5;

/// The table, and a note on how its ends were closed.
///
/// A table over exactly 360° wraps, so its ends must agree: a test that stops one step short is closed with its first line; a
/// test that includes the closing angle gets the mean of both readings at both ends.
///
/// # Errors
/// Fewer than two angles.
pub fn table(angles_deg: &[f64], found: &Identified) -> Result<(Table, Option<String>)> {
    let mut rows: Vec<Row> = angles_deg
        .iter()
        .zip(&found.angles)
        .map(|(&position, angle)| Row { position, forward: angle.errors, reverse: angle.errors })
        .collect();
    let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else { bail!("found no angles, needed two") };
    if rows.len() < 2 {
        bail!("found one angle, needed at least two for a table");
    }
    let steps = rows.windows(2).map(|pair| pair[1].position - pair[0].position);
    let (widest, gap) = (steps.fold(0.0, f64::max), first.position + 360.0 - last.position);
    let mut note = None;
    if gap.abs() <= SAME_ANGLE_DEG {
        let mean = std::array::from_fn(|i| 0.5 * (first.forward[i] + last.forward[i]));
        let apart = |i: usize| (last.forward[i] - first.forward[i]).abs();
        note = Some(format!(
            "the circle closes within {:.3} µm and {:.3} µrad; the table has the mean at both ends",
            1e3 * (0..3).map(apart).fold(0.0, f64::max),
            1e6 * (3..6).map(apart).fold(0.0, f64::max)
        ));
        let end = rows.len() - 1;
        for (index, position) in [(0, first.position), (end, first.position + 360.0)] {
            rows[index] = Row { position, forward: mean, reverse: mean };
        }
    } else if gap <= CLOSING_STEPS * widest {
        rows.push(Row { position: first.position + 360.0, ..first });
    }
    Ok((Table { given: [true; 6], bidirectional: false, rows }, note))
}
