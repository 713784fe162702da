//! Centre lines of a five-axis machine.
//!
//! Position and direction of a centre line are defined only relative to the motion of the linear axes: the zero of their
//! errors is at the machine's corner, far from all touches. They are therefore evaluated as in ISO 10791-6, with the tip on
//! the line while the rotary axis turns by 180°:
//!
//! ```text
//! d(s) = ½ [E(s, 0°) + E(s, 180°)]
//! ```
//! E is the tip error at s along the line, in machine directions. Every error that turns with the workpiece cancels; d is the
//! deviation of the centre line from the motion of the linear axes. The least-squares line of d over s gives the position (its
//! value at the middle) and the tilt (its slope).

use super::{Conditions, TaskText, run};
use anyhow::Result;
use serde::Serialize;
use trueaxis::machine::{AXES, Axis};
use trueaxis_sim::calibration::{Class, random_five_axis};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Deviation of the identified centre lines from the true ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FiveAxes {
    /// Seed.
    pub seed: u64,
    /// Largest position error of a centre line, µm.
    pub place_um: f64,
    /// Largest error of a tilt, µrad.
    pub tilt_urad: f64,
    /// Largest true position error, µm, and tilt, µrad.
    pub true_um_urad: [f64; 2],
}

/// Calibrates the five-axis machine of a seed by a task such as [`FIVE_AXES`](super::FIVE_AXES).
///
/// # Errors
/// Any error of planning, probing or solving.
pub fn five_axes<'t>(
    seed: u64,
    task: impl Into<TaskText<'t>>,
    class: &Class,
    conditions: &Conditions,
) -> Result<FiveAxes> {
    let truth = random_five_axis(seed, class);
    let calibrated = run(task, &truth, seed, conditions)?;
    compared(seed, &truth, &calibrated.known)
}

/// Centre lines of a machine as its files describe it, against the true ones.
///
/// # Errors
/// A machine whose chain cannot be read.
pub fn compared(seed: u64, truth: &Machine, known: &Machine) -> Result<FiveAxes> {
    let (there, known) = (centre_lines(truth)?, centre_lines(known)?);
    let mut outcome = FiveAxes { seed, place_um: 0.0, tilt_urad: 0.0, true_um_urad: [0.0; 2] };
    for (there, known) in there.iter().zip(&known) {
        let away: [f64; 2] = std::array::from_fn(|k| (known[k] - there[k]).abs());
        outcome.place_um = outcome.place_um.max(1e3 * away[0]);
        outcome.tilt_urad = outcome.tilt_urad.max(1e6 * away[1]);
        outcome.true_um_urad[0] = outcome.true_um_urad[0].max(1e3 * there[0].abs());
        outcome.true_um_urad[1] = outcome.true_um_urad[1].max(1e6 * there[1].abs());
    }
    Ok(outcome)
}

/// Evaluated stretch of either line, from the crossing point (the origin of A), mm: above the trunnion, and above the table.
const STRETCHES: [(Axis, usize, [f64; 2]); 2] = [(Axis::A, 0, [-100.0, 100.0]), (Axis::C, 2, [0.0, 100.0])];
const POINTS: usize = 9;

/// Position, mm, and tilt, rad, of A and of C, each in the two directions across it.
fn centre_lines(machine: &Machine) -> Result<Vec<[f64; 2]>> {
    let geometry = Geometry::new(machine, 0.0)?;
    let slot = |axis: Axis| machine.settings.axes.iter().position(|own| own.axis == axis).unwrap_or_default();
    let crossing = machine.settings.axis(Axis::A).map_or([0.0; 3], |own| own.offset_mm);
    let mut found = Vec::new();
    for (rotary, along, [low, high]) in STRETCHES {
        let at: Vec<f64> = (0..POINTS).map(|i| low + (high - low) * i as f64 / (POINTS - 1) as f64).collect();
        let middle = 0.5 * (low + high);
        let errors: Vec<[f64; 3]> = at
            .iter()
            .map(|s| {
                let mut position = [0.0; AXES];
                for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
                    position[slot(axis)] =
                        crossing[k] - machine.settings.tool_mm[k] + if k == along { *s } else { 0.0 };
                }
                let mut error = |degrees: f64| {
                    position[slot(rotary)] = degrees;
                    // Half-way through the lost motion: the mean of both directions of travel.
                    geometry.tip_error(&position, &[0.5; AXES])
                };
                let [one, other] = [error(0.0), error(180.0)];
                std::array::from_fn(|k| 0.5 * (one[k] + other[k]))
            })
            .collect();
        for across in (0..3).filter(|k| *k != along) {
            // The points are symmetric about the middle, so the normal equations decouple.
            let from_middle = || at.iter().map(|s| s - middle);
            let sum: f64 = errors.iter().map(|error| error[across]).sum();
            let moment: f64 = from_middle().zip(&errors).map(|(s, error)| s * error[across]).sum();
            let squares: f64 = from_middle().map(|s| s * s).sum();
            found.push([sum / POINTS as f64, moment / squares]);
        }
    }
    Ok(found)
}
