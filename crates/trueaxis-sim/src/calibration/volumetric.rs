//! Error over a volume, without and with compensation.

use super::correction::with_correction;
use crate::error::Result;
use glam::{DMat3, DVec3};
use trueaxis::machine::{AXES, MachineSettings};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Error of the tip over the volume after removing the best-fitting rigid motion, µm.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Errors {
    /// Root mean square.
    pub rms: f64,
    /// Largest.
    pub max: f64,
}

/// Points along an axis.
const POINTS: usize = 7;

/// Errors of a machine without correction and with the correction by the tables of `known`; three linear axes, rotary axes at
/// 0.
///
/// Evaluated at 7 × 7 × 7 points of the travels in positive and in negative travel, by exact transforms; the correction uses
/// the compiled table, as a controller would.
///
/// # Errors
/// A machine that cannot be compiled.
pub fn volumetric(truth: &Machine, known: &Machine) -> Result<[Errors; 2]> {
    let geometry = Geometry::new(truth, 0.0)?;
    let (mut points, mut before) = (Vec::new(), Vec::new());
    for position in grid(&truth.settings) {
        let tip = DVec3::from(geometry.ideal_pose(&position).tip_mm);
        for reverse in BOTH {
            points.push(tip);
            before.push(DVec3::from(geometry.tip_error(&position, &reverse)));
        }
    }
    let after = remaining(truth, known, &grid(&truth.settings))?;
    Ok([left(&points, before), left(&points, after)])
}

/// Positive and negative travel of all axes.
const BOTH: [[f64; AXES]; 2] = [[0.0; AXES], [1.0; AXES]];

/// Error of the tip that remains after the correction by the tables of `known`, at positions (in the order of the machine's
/// axes), mm, in machine directions: in positive and in negative travel at each, by exact transforms.
///
/// # Errors
/// A machine that cannot be compiled.
pub fn remaining(truth: &Machine, known: &Machine, positions: &[[f64; AXES]]) -> Result<Vec<DVec3>> {
    let geometry = Geometry::new(truth, 0.0)?;
    with_correction(&truth.settings, known, |sent| {
        let at = |position: &[f64; AXES]| {
            let commanded = geometry.commanded(position);
            let error = |reverse| geometry.pose_error_of(&commanded, &sent(position, &reverse), &reverse).tip_mm;
            BOTH.map(|reverse| DVec3::from(error(reverse)))
        };
        Ok(positions.iter().flat_map(at).collect())
    })
}

fn grid(settings: &MachineSettings) -> Vec<[f64; AXES]> {
    let mut all = vec![[0.0; AXES]];
    for (slot, own) in settings.axes.iter().enumerate().filter(|(_, own)| !own.axis.is_rotary()) {
        let [low, high] = own.travel;
        let along = |i: usize| low + (high - low) * i as f64 / (POINTS - 1) as f64;
        all = all
            .into_iter()
            .flat_map(|point| {
                (0..POINTS).map(move |i| {
                    let mut point = point;
                    point[slot] = along(i);
                    point
                })
            })
            .collect();
    }
    all
}

/// Size of the errors without the best-fitting shift and rotation, which correspond to how the workpiece is set up.
fn left(points: &[DVec3], errors: Vec<DVec3>) -> Errors {
    let count = points.len().max(1) as f64;
    let middle = points.iter().sum::<DVec3>() / count;
    let shift = errors.iter().sum::<DVec3>() / count;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (point, error) in points.iter().zip(&errors) {
        let from = *point - middle;
        let dyad = DMat3::from_cols(from * from.x, from * from.y, from * from.z);
        matrix += DMat3::from_diagonal(DVec3::splat(from.length_squared())) - dyad;
        right += from.cross(*error - shift);
    }
    let turn = matrix.inverse() * right;
    let sizes: Vec<f64> = points
        .iter()
        .zip(&errors)
        .map(|(point, error)| 1e3 * (*error - shift - turn.cross(*point - middle)).length())
        .collect();
    let squares: f64 = sizes.iter().map(|size| size * size).sum();
    Errors { rms: libm::sqrt(squares / count), max: sizes.into_iter().fold(0.0, f64::max) }
}
