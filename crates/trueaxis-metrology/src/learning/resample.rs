//! A recorded contour error at equidistant nodes.

use super::NotLearned;
use std::vec::Vec;

/// Widest gap between two rows, as a share of the cut-off wavelength: two rows per wave at the cut-off.
pub const GAP_OF_CUTOFF: f64 = 0.5;
/// Largest plausible contour error, mm: a larger one indicates a wrong unit or reading.
pub const LARGEST_ERROR_MM: f64 = 1.0;
/// Tolerance for a decreasing path length due to rounding, mm.
const ROUNDING_MM: f64 = 1e-6;

/// Contour error in a cycle of the part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredError {
    /// Path length of the reference, mm.
    pub length_mm: f64,
    /// Tip − foot, X, Y, Z in machine directions, mm; `None` if not measured (rapid motion, search, fault).
    pub error_mm: Option<[f64; 3]>,
}

/// Errors at nodes 0, h, 2h, …
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled {
    /// Spacing h, mm.
    pub spacing_mm: f64,
    /// Error at each node, mm; zero where nothing was measured.
    pub errors_mm: Vec<[f64; 3]>,
}

/// Resamples a record over a path of `length_mm` to nodes `spacing_mm` apart: the mean of the rows nearest to a node, linear
/// interpolation for nodes without rows, zero where nothing was measured.
///
/// # Errors
/// The first unacceptable row, with its index: a path length that decreases or is off the path, a step wider than
/// `widest_gap_mm` between two measured rows, an error that is too large; also a record that does not cover the path from
/// start to end, or contains no measured error.
pub fn resample(
    rows: &[MeasuredError],
    length_mm: f64,
    spacing_mm: f64,
    widest_gap_mm: f64,
) -> Result<Resampled, NotLearned> {
    check(rows, length_mm, widest_gap_mm)?;
    let nodes = super::table::nodes(length_mm, spacing_mm)?;
    let mut sums = std::vec![([0.0; 3], 0_u32); nodes];
    for row in rows {
        let node = (row.length_mm / spacing_mm).round() as usize;
        if let (Some(error), Some((sum, count))) = (row.error_mm, sums.get_mut(node)) {
            sum.iter_mut().zip(error).for_each(|(sum, error)| *sum += error);
            *count += 1;
        }
    }
    let mut errors: Vec<[f64; 3]> =
        sums.iter().map(|(sum, count)| sum.map(|sum| sum / f64::from(*count).max(1.0))).collect();
    bridge(&mut errors, &sums, rows, spacing_mm);
    Ok(Resampled { spacing_mm, errors_mm: errors })
}

/// Interpolates nodes that no row is nearest to from the rows on either side.
fn bridge(errors: &mut [[f64; 3]], sums: &[([f64; 3], u32)], rows: &[MeasuredError], spacing_mm: f64) {
    let mut next = 0;
    for (k, (error, (_, count))) in errors.iter_mut().zip(sums).enumerate() {
        if *count > 0 {
            continue;
        }
        let at = k as f64 * spacing_mm;
        while rows.get(next).is_some_and(|row| row.length_mm < at) {
            next += 1;
        }
        let before = next.checked_sub(1).and_then(|before| rows.get(before));
        let (Some(before), Some(after)) = (before, rows.get(next)) else { continue };
        let (Some(one), Some(other)) = (before.error_mm, after.error_mm) else { continue };
        let share = (at - before.length_mm) / (after.length_mm - before.length_mm);
        *error = core::array::from_fn(|i| one[i] + share * (other[i] - one[i]));
    }
}

fn check(rows: &[MeasuredError], length_mm: f64, widest_gap_mm: f64) -> Result<(), NotLearned> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Err(NotLearned::Empty) };
    for (index, row) in rows.iter().enumerate() {
        let found_mm = row.length_mm;
        // Also refuses NaN.
        if !(-widest_gap_mm..=length_mm + widest_gap_mm).contains(&found_mm) {
            return Err(NotLearned::OffThePath { index, found_mm, length_mm });
        }
        let largest = row.error_mm.iter().flatten().fold(0.0, |largest: f64, e| largest.max(e.abs()));
        if row.error_mm.iter().flatten().any(|e| !e.is_finite()) || largest > LARGEST_ERROR_MM {
            return Err(NotLearned::TooLarge { index, found_mm: largest, most_mm: LARGEST_ERROR_MM });
        }
        let Some(before) = index.checked_sub(1).and_then(|before| rows.get(before)) else { continue };
        if found_mm < before.length_mm - ROUNDING_MM {
            return Err(NotLearned::Backwards { index, found_mm, before_mm: before.length_mm });
        }
        let both = row.error_mm.is_some() && before.error_mm.is_some();
        if both && found_mm - before.length_mm > widest_gap_mm {
            return Err(NotLearned::Gap {
                index,
                from_mm: before.length_mm,
                to_mm: found_mm,
                widest_mm: widest_gap_mm,
            });
        }
    }
    if first.length_mm > widest_gap_mm {
        return Err(NotLearned::Gap { index: 0, from_mm: 0.0, to_mm: first.length_mm, widest_mm: widest_gap_mm });
    }
    if last.length_mm < length_mm - widest_gap_mm {
        let index = rows.len() - 1;
        return Err(NotLearned::Gap { index, from_mm: last.length_mm, to_mm: length_mm, widest_mm: widest_gap_mm });
    }
    if rows.iter().all(|row| row.error_mm.is_none()) {
        return Err(NotLearned::Empty);
    }
    Ok(())
}
