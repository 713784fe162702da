//! Errors and corrections of many positions at once, as `trueaxis compensate` prints them.

use crate::compensate::{Arrival, Model, NoCorrection, Place, PoseError, Settings, with_model};
use anyhow::{Result, anyhow};
use std::sync::atomic::{AtomicUsize, Ordering};
use trueaxis::machine::{AXES, Axis};
use trueaxis_metrology::cores::*;
use trueaxis_tables::Machine;

/// Number of positions that one thread processes at a time.
const CHUNK: usize = 4096;

/// Positions row by row, mm and degrees; axes without a column are at 0.
#[derive(Clone, Copy, Debug)]
pub struct Positions<'p> {
    /// Values, row after row.
    pub values: &'p [f64],
    /// Axis of every column; not empty.
    pub columns: &'p [Axis],
}

impl Positions<'_> {
    /// Number of rows.
    pub fn count(&self) -> usize {
        self.values.len() / self.columns.len()
    }

    /// X, Y, Z (mm), A, B, C (degrees) of a row; 0 beyond the last row.
    pub fn at(&self, row: usize) -> [f64; AXES] {
        let mut command = [0.0; AXES];
        let values = self.values.iter().skip(row * self.columns.len());
        for (axis, value) in self.columns.iter().zip(values) {
            command[axis.index()] = *value;
        }
        command
    }
}

/// Writes the part of the error that `of` selects at every position; returns the number of positions beyond a table's end.
///
/// All cores share the work, except in order of travel, where each position needs the previous one. Cost: one look-up per
/// position; in order one additional correction.
///
/// # Errors
/// As [`with_model`]; in order also a pose without a correction, with the index of its position.
///
/// # Panics
/// If `errors` is not as long as the number of positions.
pub fn errors(
    machine: &Machine,
    settings: &Settings,
    arrival: Arrival,
    positions: Positions<'_>,
    of: impl Fn(&PoseError) -> [f64; 3] + Sync,
    errors: &mut [[f64; 3]],
) -> Result<usize> {
    evaluate(machine, settings, arrival, positions, errors.as_flattened_mut(), 3, |model, at, result| {
        let error = model.error(at);
        result.copy_from_slice(&of(&error));
        Ok(error.clamped)
    })
}

/// Writes the corrections of the axes of the columns (mm, degrees) at every position, row by row, to be added to the command;
/// returns the number of positions beyond a table's end. As [`errors`]. Cost: one look-up per position and pass of the exact
/// inverse, and one more if a pass meets a table's end.
///
/// # Errors
/// As [`errors`], and a pose without a correction.
///
/// # Panics
/// If `corrections` is not as long as the positions.
pub fn corrections(
    machine: &Machine,
    settings: &Settings,
    arrival: Arrival,
    positions: Positions<'_>,
    corrections: &mut [f64],
) -> Result<usize> {
    let width = positions.columns.len();
    evaluate(machine, settings, arrival, positions, corrections, width, |model, at, result| {
        let (correction, clamped) = model.correction_and_clamped(at)?;
        for (axis, result) in positions.columns.iter().zip(result) {
            *result = correction[axis.index()];
        }
        Ok(clamped)
    })
}

/// `of` writes the `width` results of a place and returns whether the place is beyond a table's end.
fn evaluate(
    machine: &Machine,
    settings: &Settings,
    mut arrival: Arrival,
    positions: Positions<'_>,
    results: &mut [f64],
    width: usize,
    of: impl Fn(&dyn Model, &Place, &mut [f64]) -> Result<bool, NoCorrection> + Sync,
) -> Result<usize> {
    assert_eq!(positions.count() * width, results.len(), "a result for every position");
    let beyond = AtomicUsize::new(0);
    with_model(machine, settings, |model| {
        let run = |first: usize, arrival: &mut Arrival, results: &mut [f64]| {
            let mut count = 0;
            for (row, result) in (first..).zip(results.chunks_exact_mut(width)) {
                let mut one = || of(model, &arrival.at(model, positions.at(row))?, result);
                count += usize::from(one().map_err(|refused| anyhow!("positions[{row}]: {refused}"))?);
            }
            beyond.fetch_add(count, Ordering::Relaxed);
            Ok(())
        };
        if matches!(arrival, Arrival::InOrder(_)) {
            return run(0, &mut arrival, results);
        }
        results
            .par_chunks_mut(CHUNK * width)
            .enumerate()
            .try_for_each(|(i, results)| run(i * CHUNK, &mut arrival.clone(), results))
    })?;
    Ok(beyond.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::by_axes;
    use crate::correct::{self, Asked};
    use std::path::Path;

    #[test]
    fn every_position_is_what_correct_says_of_it() {
        for name in ["mill-3axis", "head-5axis"] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name);
            let machine = Machine::read(&folder).unwrap();
            let positions: Vec<[f64; AXES]> =
                (0..2 * CHUNK).map(|i| [0.01 * i as f64, 20.0, -150.0, 5.0, 0.0, 30.0]).collect();
            let settings = Settings { exact: false, passes: None, kelvin: 3.0 };
            let rows = Positions { values: positions.as_flattened(), columns: &Axis::ALL };
            let (mut tips, mut sent) = (vec![[0.0; 3]; positions.len()], vec![[0.0; AXES]; positions.len()]);
            let mut compared = 0;
            assert_eq!(
                errors(&machine, &settings, Arrival::Negative, rows, |error| error.tip, &mut tips).unwrap(),
                corrections(&machine, &settings, Arrival::Negative, rows, sent.as_flattened_mut()).unwrap()
            );
            for i in (0..positions.len()).step_by(997) {
                let asked = Asked { at: positions[i], reverse: [true; AXES], kelvin: 3.0 };
                let one = by_axes!(machine.settings.step_axes().count(), one(&machine, &asked));
                assert_eq!((tips[i], sent[i]), (one.tip, one.correction), "{name} {i}");
                compared += usize::from(one.tip != [0.0; 3]);
            }
            assert!(compared > 5, "{name}: errors to be compared");
        }
        fn one<const N: usize>(machine: &Machine, asked: &Asked) -> correct::CorrectionAt {
            correct::at::<N>(machine, asked).unwrap()
        }
    }

    #[test]
    fn growth_that_the_step_does_not_take_is_refused() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
        let settings = Settings { kelvin: 1e6, ..Settings::default() };
        let machine = Machine::read(&folder).unwrap();
        let rows = Positions { values: &[0.0; AXES], columns: &Axis::ALL };
        let refused = corrections(&machine, &settings, Arrival::Positive, rows, &mut [0.0; AXES]);
        assert!(refused.unwrap_err().to_string().starts_with("temperature: found 1000000 K above the reference"));
    }
}
