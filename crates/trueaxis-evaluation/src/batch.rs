//! Errors and corrections of many positions at once, as `trueaxis compensate` prints them.

use crate::compensate::{Arrival, Model, NoCorrection, Place, PoseError, Settings, with_model};
use anyhow::{Result, anyhow};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;

/// Positions that one thread takes at a time.
const CHUNK: usize = 4096;

/// What `of` takes of the error at every position; the number of positions beyond a table's end.
///
/// Positions are X, Y, Z (mm), A, B, C (degrees). All cores share the work, but in order of travel, where each position needs
/// the one before. Cost: one look-up a position; in order one correction more.
///
/// # Errors
/// Those of [`with_model`]; in order a pose without a correction, with the index of its position.
///
/// # Panics
/// `errors` is not as long as `positions`.
pub fn errors(
    machine: &Machine,
    settings: &Settings,
    arrival: Arrival,
    positions: &[[f64; AXES]],
    of: impl Fn(&PoseError) -> [f64; 3] + Sync,
    errors: &mut [[f64; 3]],
) -> Result<usize> {
    evaluate(machine, settings, arrival, positions, errors, |_, _, error| Ok(of(error)))
}

/// Corrections of X, Y, Z (mm), A, B, C (degrees) at every position, to be added to the command; the number of positions
/// beyond a table's end. As [`errors`]. Cost: as many look-ups a position as the exact inverse has passes, and one.
///
/// # Errors
/// As [`errors`], and a pose without a correction.
///
/// # Panics
/// `corrections` is not as long as `positions`.
pub fn corrections(
    machine: &Machine,
    settings: &Settings,
    arrival: Arrival,
    positions: &[[f64; AXES]],
    corrections: &mut [[f64; AXES]],
) -> Result<usize> {
    evaluate(machine, settings, arrival, positions, corrections, |model, at, _| model.correction(at))
}

fn evaluate<T: Send>(
    machine: &Machine,
    settings: &Settings,
    mut arrival: Arrival,
    positions: &[[f64; AXES]],
    results: &mut [T],
    of: impl Fn(&dyn Model, &Place, &PoseError) -> Result<T, NoCorrection> + Sync,
) -> Result<usize> {
    assert_eq!(positions.len(), results.len(), "a result for every position");
    let beyond = AtomicUsize::new(0);
    with_model(machine, settings, &mut |model| {
        let run = |first: usize, arrival: &mut Arrival, positions: &[[f64; AXES]], results: &mut [T]| {
            let mut count = 0;
            for (i, (command, result)) in positions.iter().zip(results).enumerate() {
                let mut one = || {
                    let at = arrival.at(model, *command)?;
                    let error = model.error(&at);
                    count += usize::from(error.clamped);
                    of(model, &at, &error)
                };
                *result = one().map_err(|refused| anyhow!("positions[{}]: {refused}", first + i))?;
            }
            beyond.fetch_add(count, Ordering::Relaxed);
            Ok(())
        };
        if matches!(arrival, Arrival::InOrder(_)) {
            return run(0, &mut arrival, positions, results);
        }
        let chunks = positions.par_chunks(CHUNK).zip(results.par_chunks_mut(CHUNK)).enumerate();
        chunks.try_for_each(|(i, (positions, results))| run(i * CHUNK, &mut arrival.clone(), positions, results))
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
            let (mut tips, mut sent) = (vec![[0.0; 3]; positions.len()], vec![[0.0; AXES]; positions.len()]);
            let mut compared = 0;
            assert_eq!(
                errors(&machine, &settings, Arrival::Negative, &positions, |error| error.tip, &mut tips).unwrap(),
                corrections(&machine, &settings, Arrival::Negative, &positions, &mut sent).unwrap()
            );
            for i in (0..positions.len()).step_by(997) {
                let asked = Asked { at: positions[i], reverse: [true; AXES], kelvin: 3.0 };
                let one = by_axes!(machine.settings.step_axes().count(), one(&machine, &asked));
                assert_eq!((tips[i], sent[i]), (one.tip, one.correction), "{name} {i}");
                compared += usize::from(one.tip != [0.0; 3]);
            }
            assert!(compared > 5, "{name}: errors to be compared");
        }
        fn one<const N: usize>(machine: &Machine, asked: &Asked) -> correct::Found {
            correct::at::<N>(machine, asked).unwrap()
        }
    }

    #[test]
    fn growth_that_the_step_does_not_take_is_refused() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
        let settings = Settings { kelvin: 1e6, ..Settings::default() };
        let machine = Machine::read(&folder).unwrap();
        let refused = corrections(&machine, &settings, Arrival::Positive, &[[0.0; AXES]], &mut [[0.0; AXES]]);
        assert!(refused.unwrap_err().to_string().starts_with("temperature: found 1000000 K above the reference"));
    }
}
