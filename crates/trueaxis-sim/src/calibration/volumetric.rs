//! Error over a volume, without and with compensation.

use crate::error::Result;
use glam::{DMat3, DVec3};
use trueaxis::compensation::{Compensation, Direction, Query, ThermalLine, requirement};
use trueaxis::machine::{AXES, AxisOrder, MachineSettings};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::{Machine, compile};

/// Error of the tip over the volume, its best rigid motion taken out, µm.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Errors {
    /// Root mean square.
    pub rms: f64,
    /// Largest.
    pub max: f64,
}

/// Points along an axis.
const POINTS: usize = 7;

/// Errors of a machine without correction, and with the one that `known` makes; three linear axes, rotary axes at 0.
///
/// At 7 × 7 × 7 points of the travels in positive and in negative travel, by exact transforms; the correction by the compiled
/// table as a controller would.
///
/// # Errors
/// A machine that cannot be compiled.
pub fn volumetric(truth: &Machine, known: &Machine) -> Result<[Errors; 2]> {
    match truth.settings.axes.len() {
        3 => of::<3>(truth, known),
        4 => of::<4>(truth, known),
        5 => of::<5>(truth, known),
        _ => of::<6>(truth, known),
    }
}

fn of<const N: usize>(truth: &Machine, known: &Machine) -> Result<[Errors; 2]> {
    let geometry = Geometry::new(truth, 0.0)?;
    let bytes = compile(known)?;
    let tcomp = Tcomp::parse(&bytes)?;
    let rows = |axis| tcomp.table(axis);
    let mut memory = vec![0.0; requirement(tcomp.settings(), rows)];
    let compensation: Compensation<'_, f64, f64, N> =
        Compensation::build(tcomp.settings(), rows, tcomp.grids(), tcomp.inverse_passes(), &mut memory)?;
    let slots = AxisOrder::<N>::of(tcomp.settings())?.axes().map(|axis| place(&truth.settings, axis));
    let (mut points, mut before, mut after) = (Vec::new(), Vec::new(), Vec::new());
    for position in grid(&truth.settings) {
        let tip = DVec3::from(geometry.ideal_pose(&position).tip_mm);
        let commanded = geometry.commanded(&position);
        for (reverse, direction) in [(0.0, Direction::POSITIVE), (1.0, Direction::NEGATIVE)] {
            let reverse = [reverse; AXES];
            let command: [f64; N] = slots.map(|slot| slot.map_or(0.0, |slot| position[slot]));
            let at = compensation.coordinates(&command);
            let thermal = [ThermalLine::default(); N];
            let correction = compensation.correction(&Query::at(&at, &[direction; N], &thermal), &mut 0);
            let mut sent = position;
            for (slot, by) in slots.into_iter().zip(correction) {
                if let Some(slot) = slot {
                    sent[slot] += by;
                }
            }
            points.push(tip);
            before.push(DVec3::from(geometry.tip_error(&position, &reverse)));
            after.push(DVec3::from(geometry.pose_error_of(&commanded, &sent, &reverse).tip_mm));
        }
    }
    Ok([left(&points, before), left(&points, after)])
}

fn place(settings: &MachineSettings, axis: trueaxis::Axis) -> Option<usize> {
    settings.axes.iter().position(|own| own.axis == axis)
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

/// Size of the errors without the shift and turn that fit them best: those are how the workpiece is set up.
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
