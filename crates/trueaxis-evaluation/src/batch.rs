//! Errors and corrections of many positions at once, as `trueaxis compensate` prints them.

use crate::compensate::{Arrival, Many, Model, NoCorrection, Place, Settings, with_model};
use anyhow::{Result, anyhow};
use std::sync::atomic::{AtomicUsize, Ordering};
use trueaxis::compensation::Direction;
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

    /// `count` rows from `first` on, if the columns are X, Y, Z.
    fn slides(&self, first: usize, count: usize) -> Option<&[[f64; 3]]> {
        let rows = self.values.as_chunks().0;
        (self.columns == [Axis::X, Axis::Y, Axis::Z]).then(|| &rows[first..first + count])
    }
}

/// Writes what `of` makes of the errors of tip (mm) and orientation (rad) at every position; returns the number of positions beyond a table's end.
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
    of: impl Fn([f64; 3], [f64; 3]) -> [f64; 3] + Sync,
    errors: &mut [[f64; 3]],
) -> Result<usize> {
    let one = |model: &dyn Model, at: &Place, result: &mut [f64]| {
        let error = model.error(at);
        result.copy_from_slice(&of(error.tip, error.orientation));
        Ok(error.clamped)
    };
    let many = |model: &dyn Many, at: &[[f64; 3]], directions: &[Direction; AXES], results: &mut [[f64; 3]]| {
        let beyond = model.errors(at, directions, results);
        for result in results {
            *result = of(*result, [0.0; 3]);
        }
        beyond
    };
    evaluate(machine, settings, arrival, positions, errors.as_flattened_mut(), 3, one, many)
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
    let one = |model: &dyn Model, at: &Place, result: &mut [f64]| {
        let (correction, clamped) = model.correction_and_clamped(at)?;
        for (axis, result) in positions.columns.iter().zip(result) {
            *result = correction[axis.index()];
        }
        Ok(clamped)
    };
    let many = |model: &dyn Many, at: &[[f64; 3]], directions: &[Direction; AXES], results: &mut [[f64; 3]]| {
        model.corrections(at, directions, results)
    };
    evaluate(machine, settings, arrival, positions, corrections, width, one, many)
}

/// `one` writes the `width` results of a place and returns whether the place is beyond a table's end; `many` writes those of
/// several positions of X, Y, Z and returns the number beyond.
fn evaluate(
    machine: &Machine,
    settings: &Settings,
    mut arrival: Arrival,
    positions: Positions<'_>,
    results: &mut [f64],
    width: usize,
    one: impl Fn(&dyn Model, &Place, &mut [f64]) -> Result<bool, NoCorrection> + Sync,
    many: impl Fn(&dyn Many, &[[f64; 3]], &[Direction; AXES], &mut [[f64; 3]]) -> usize + Sync,
) -> Result<usize> {
    assert_eq!(positions.count() * width, results.len(), "a result for every position");
    let beyond = AtomicUsize::new(0);
    with_model(machine, settings, |model| {
        let run = |first: usize, arrival: &mut Arrival, results: &mut [f64]| {
            let mut count = 0;
            let slides = positions.slides(first, results.len() / width);
            if let (Some(model), Some(directions), Some(slides)) = (model.batch(), arrival.directions(), slides) {
                count = many(model, slides, &directions, results.as_chunks_mut().0);
            } else {
                for (row, result) in (first..).zip(results.chunks_exact_mut(width)) {
                    let mut one = || one(model, &arrival.at(model, positions.at(row))?, result);
                    count += usize::from(one().map_err(|refused| anyhow!("positions[{row}]: {refused}"))?);
                }
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
    use trueaxis::machine::Interpolation;

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
                errors(&machine, &settings, Arrival::Negative, rows, |tip, _| tip, &mut tips).unwrap(),
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

    /// Random positions, a run along X, and table points and ends; some 2 % lie beyond a table's end.
    fn places() -> Vec<[f64; 3]> {
        let ends = [[-303.0, 303.0], [-202.0, 202.0], [-404.0, 4.0]];
        let share = |i: usize, axis: usize| (i as f64 * [0.754877666, 0.569840291, 0.430159709][axis]).fract();
        let random = (1..CHUNK + 700)
            .map(|i| [0, 1, 2].map(|axis| ends[axis][0] + (ends[axis][1] - ends[axis][0]) * share(i, axis)));
        let run = (0..1500).map(|i| [-310.0 + 0.41 * i as f64, 33.3, -0.1 * i as f64]);
        let points = [-300.0, -290.0, -0.0, 0.0, 10.0, 300.0, 1e6, -1e6];
        let corners = points.iter().flat_map(|x| points.iter().map(|y| [*x, *y * 2.0 / 3.0, (*x + *y) / 2.0 - 200.0]));
        random.chain(run).chain(corners).collect()
    }

    /// The numbers of [`Model::error`] and [`Model::correction`], whose arithmetic is the servo step's.
    #[test]
    fn many_positions_are_bit_for_bit_the_step_s() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
        let mill = Machine::read(&folder).unwrap();
        assert!(mill.tables.iter().flatten().any(|table| table.bidirectional), "tables in both directions");
        let of = |edit: &dyn Fn(&mut Machine)| {
            let mut machine = mill.clone();
            edit(&mut machine);
            machine
        };
        let linear = |machine: &mut Machine| {
            machine.settings.axes.iter_mut().for_each(|axis| axis.interpolation = Interpolation::Linear);
        };
        // Points 10 and 40 mm apart: a free grid.
        let thinned = |machine: &mut Machine| {
            for table in machine.tables.iter_mut().flatten() {
                let (mut row, last) = (0, table.rows.len());
                table.rows.retain(|_| {
                    row += 1;
                    row == last || row % 5 < 2
                });
            }
        };
        let machines = [
            ("cubic", mill.clone()),
            ("linear", of(&linear)),
            ("cubic, free grid", of(&thinned)),
            (
                "linear, free grid",
                of(&|machine| {
                    linear(machine);
                    thinned(machine)
                }),
            ),
            ("without a table", of(&|machine| machine.tables[1] = None)),
            ("unlike kinds", of(&|machine| machine.settings.axes[0].interpolation = Interpolation::Linear)),
        ];
        let places = places();
        let rows = Positions { values: places.as_flattened(), columns: &[Axis::X, Axis::Y, Axis::Z] };
        for (name, machine) in &machines {
            for (arrival, reverse, kelvin, passes) in [
                (Arrival::Positive, false, 0.0, None),
                (Arrival::Negative, true, 3.0, None),
                (Arrival::Negative, true, -7.0, Some(1)),
                (Arrival::Positive, false, 3.0, Some(3)),
            ] {
                let settings = Settings { exact: false, passes, kelvin };
                let (mut tips, mut sent) = (vec![[0.0; 3]; places.len()], vec![[0.0; 3]; places.len()]);
                let beyond = [
                    errors(machine, &settings, arrival.clone(), rows, |tip, _| tip, &mut tips).unwrap(),
                    corrections(machine, &settings, arrival, rows, sent.as_flattened_mut()).unwrap(),
                ];
                with_model(machine, &settings, |model| {
                    assert_eq!(model.batch().is_some(), *name != "unlike kinds", "{name}");
                    let mut clamped = 0;
                    for (i, [x, y, z]) in places.iter().enumerate() {
                        let command = [*x, *y, *z, 0.0, 0.0, 0.0];
                        let at = Place { command, directions: [Direction::of(reverse); AXES] };
                        let (error, [cx, cy, cz, ..]) = (model.error(&at), model.correction(&at)?);
                        let bits = |of: [f64; 3]| of.map(f64::to_bits);
                        assert_eq!(bits(tips[i]), bits(error.tip), "{name}, error at {:?}", places[i]);
                        assert_eq!(bits(sent[i]), bits([cx, cy, cz]), "{name}, correction at {:?}", places[i]);
                        clamped += usize::from(error.clamped);
                    }
                    assert_eq!(beyond, [clamped; 2], "{name}");
                    assert!(clamped > 100 && clamped < places.len() / 4, "{clamped} beyond a table's end");
                    Ok(())
                })
                .unwrap();
            }
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
