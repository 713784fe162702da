//! Errors and corrections of many positions at once, as the servo step computes them and `trueaxis compensate` prints them.

use crate::by_axes;
use crate::model::{passes, takes_rise, thermal, with_compensation};
use anyhow::{Result, anyhow, bail};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trueaxis::compensation::{Compensation, Direction, Query};
use trueaxis::machine::{AXES, AxisOrder};
use trueaxis_tables::Machine;

/// Positions that one thread takes at a time.
const CHUNK: usize = 4096;

/// Settings shared by all positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Look-ups of the exact inverse, 1 to 8; none: as many as the machine needs.
    pub passes: Option<u8>,
    /// All axes travel in negative direction.
    pub reverse: bool,
    /// Kelvin above the reference temperature.
    pub kelvin: f64,
}

/// Error of the tool tip at every position, actual − ideal, mm; the number of positions beyond a table's end.
///
/// Positions are X, Y, Z (mm), A, B, C (degrees); the machine's own model is evaluated, each position for itself, on all
/// cores. Cost: one look-up a position.
///
/// # Errors
/// A machine that the model refuses, or a thermal growth beyond what the step takes.
///
/// # Panics
/// `errors` is not as long as `positions`.
pub fn errors(
    machine: &Machine,
    settings: &Settings,
    positions: &[[f64; AXES]],
    errors: &mut [[f64; 3]],
) -> Result<usize> {
    by_axes!(machine.settings.step_axes().count(), errors_of(machine, settings, positions, errors))
}

/// Corrections of X, Y, Z (mm), A, B, C (degrees) at every position, to be added to the command; the number of positions
/// beyond a table's end. As [`errors`]. Cost: as many look-ups a position as the exact inverse has passes, and one.
///
/// # Errors
/// As [`errors`], and more than 8 passes needed.
///
/// # Panics
/// `corrections` is not as long as `positions`.
pub fn corrections(
    machine: &Machine,
    settings: &Settings,
    positions: &[[f64; AXES]],
    corrections: &mut [[f64; AXES]],
) -> Result<usize> {
    by_axes!(machine.settings.step_axes().count(), corrections_of(machine, settings, positions, corrections))
}

fn errors_of<const N: usize>(
    machine: &Machine,
    settings: &Settings,
    positions: &[[f64; AXES]],
    errors: &mut [[f64; 3]],
) -> Result<usize> {
    evaluate::<N, _>(machine, settings, positions, errors, |compensation, _, query, clamped| {
        compensation.pose_error(query, clamped).tip.into()
    })
}

fn corrections_of<const N: usize>(
    machine: &Machine,
    settings: &Settings,
    positions: &[[f64; AXES]],
    corrections: &mut [[f64; AXES]],
) -> Result<usize> {
    evaluate::<N, _>(machine, settings, positions, corrections, |compensation, slots, query, clamped| {
        // Only the position itself counts as beyond an end, not the places where the inverse looks.
        compensation.pose_error(query, clamped);
        let found = compensation.correction(query, &mut 0);
        let mut correction = [0.0; AXES];
        for (slot, found) in slots.iter().zip(found) {
            correction[*slot] = found;
        }
        correction
    })
}

fn evaluate<const N: usize, T: Send>(
    machine: &Machine,
    settings: &Settings,
    positions: &[[f64; AXES]],
    results: &mut [T],
    at: impl Fn(&Compensation<'_, f64, f64, N>, &[usize; N], &Query<'_, f64, N>, &mut u8) -> T + Sync,
) -> Result<usize> {
    assert_eq!(positions.len(), results.len(), "a result for every position");
    let axes = AxisOrder::<N>::of(&machine.settings).map_err(|error| anyhow!("{error}"))?.axes();
    let slots = axes.map(|axis| axis.index());
    let passes = passes(machine, settings.passes)?;
    if !takes_rise(machine, settings.kelvin) {
        bail!(
            "temperature: found {} K above the reference, needed a growth of at most 10 mm and 1e-3",
            settings.kelvin
        );
    }
    let thermal = thermal(machine, &axes, settings.kelvin);
    let directions = [Direction::of(settings.reverse); N];
    let beyond = AtomicUsize::new(0);
    with_compensation::<N, _>(machine, passes, |compensation| {
        positions.par_chunks(CHUNK).zip(results.par_chunks_mut(CHUNK)).for_each(|(positions, results)| {
            let mut count = 0;
            for (position, result) in positions.iter().zip(results) {
                let coordinates = compensation.coordinates(&slots.map(|slot| position[slot]));
                let mut clamped = 0;
                *result = at(compensation, &slots, &Query::at(&coordinates, &directions, &thermal), &mut clamped);
                count += usize::from(clamped != 0);
            }
            beyond.fetch_add(count, Ordering::Relaxed);
        });
        Ok(())
    })?;
    Ok(beyond.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::{self, Asked};
    use std::path::Path;

    #[test]
    fn every_position_is_what_correct_says_of_it() {
        for name in ["mill-3axis", "head-5axis"] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name);
            let machine = Machine::read(&folder).unwrap();
            let positions: Vec<[f64; AXES]> =
                (0..2 * CHUNK).map(|i| [0.01 * i as f64, 20.0, -150.0, 5.0, 0.0, 30.0]).collect();
            let settings = Settings { passes: None, reverse: true, kelvin: 3.0 };
            let (mut tips, mut sent) = (vec![[0.0; 3]; positions.len()], vec![[0.0; AXES]; positions.len()]);
            let mut compared = 0;
            assert_eq!(
                errors(&machine, &settings, &positions, &mut tips).unwrap(),
                corrections(&machine, &settings, &positions, &mut sent).unwrap()
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
        let refused = errors(&Machine::read(&folder).unwrap(), &settings, &[[0.0; AXES]], &mut [[0.0; 3]]);
        assert!(refused.unwrap_err().to_string().starts_with("temperature: found 1000000 K above the reference"));
    }
}
