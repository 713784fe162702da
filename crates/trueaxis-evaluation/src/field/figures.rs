//! Figures of a sampled field.

use super::grid::Grid;
use super::sample::{Pose, size};
use super::{Asked, Model, Worst};
use serde::Serialize;
use std::collections::BTreeMap;

/// Figures of a field, before and after, under both models.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Figures {
    /// Name of the machine.
    pub machine: String,
    /// Structural code of the machine.
    pub chain: String,
    /// Model of the rows.
    pub model: Model,
    /// The machine's own model.
    pub own_model: Model,
    /// Points along X, Y, Z; 1 for an axis that the machine does not have.
    pub points: [usize; 3],
    /// Low and high end of the working volume along X, Y, Z, mm.
    pub range_mm: [[f64; 2]; 3],
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Kelvin above the reference temperature.
    pub kelvin: f64,
    /// Axes that travel in negative direction.
    pub negative: Vec<char>,
    /// Tip from the last tool-side frame, mm.
    pub tool_mm: [f64; 3],
    /// Positions of the rotary axes, degrees.
    pub pose_deg: BTreeMap<char, f64>,
    /// Travel of the rotary axes, degrees.
    pub travel_deg: BTreeMap<char, [f64; 2]>,
    /// Whether the correction turns the tool through the rotary axes (volumetric only).
    pub corrects_orientation: bool,
    /// Points beyond the end of a table, where its edge value is used.
    pub clamped_points: usize,
    /// Without correction.
    pub before: Case,
    /// Residual of the nine-term model.
    pub nine: Left,
    /// Residual of the volumetric form.
    pub volumetric: Left,
}

/// Residual under a model.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Left {
    /// Figures; `None` if the machine's errors do not allow the model.
    pub after: Option<Case>,
    /// Points at which the correction of an axis meets its magnitude limit.
    pub limited_points: usize,
    /// Why the model is not allowed.
    pub refused: Option<String>,
}

/// Sizes of the tip's error over the grid, µm.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Case {
    /// Largest size.
    pub largest_um: f64,
    /// Root of the mean square of the size.
    pub rms_um: f64,
    /// The smallest size that 95 % of the points do not exceed.
    pub p95_um: f64,
    /// Lowest and highest component along X, Y, Z: their differences are the volumetric accuracy of ISO 230-1.
    pub range_um: [[f64; 2]; 3],
    /// Rotation of the tool.
    pub orientation: Orientation,
    /// Largest size over every slice across X, Y, Z.
    pub slices: [Vec<Slice>; 3],
    /// The worst point and its causes.
    pub worst: Worst,
}

/// Sizes of the tool's rotation over the grid, µrad.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct Orientation {
    /// Largest.
    pub largest_urad: f64,
    /// Root of the mean square.
    pub rms_urad: f64,
}

/// A slice across an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Slice {
    /// Position of the axis, mm.
    pub at_mm: f64,
    /// Largest size of the tip's error, µm.
    pub largest_um: f64,
}

fn rms(sizes: &[f64]) -> f64 {
    (sizes.iter().map(|size| size * size).sum::<f64>() / sizes.len() as f64).sqrt()
}

/// Smallest of `sizes` that the given share of them does not exceed (nearest rank).
fn percentile(mut sizes: Vec<f64>, share: f64) -> f64 {
    let rank = ((sizes.len() as f64 * share).ceil() as usize).clamp(1, sizes.len()) - 1;
    *sizes.select_nth_unstable_by(rank, f64::total_cmp).1
}

impl Case {
    /// Figures of the poses at all points.
    pub(super) fn new(grid: &Grid, poses: &[Pose], worst: Worst) -> Case {
        let sizes: Vec<f64> = poses.iter().map(|pose| size(pose.tip) * 1e3).collect();
        let mut slices: [Vec<Slice>; 3] = std::array::from_fn(|axis| {
            let slice = |index| Slice { at_mm: grid.along(axis, index), largest_um: 0.0 };
            (0..grid.points[axis]).map(slice).collect()
        });
        let mut range_um = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for (index, (pose, size)) in poses.iter().zip(&sizes).enumerate() {
            for (slices, index) in slices.iter_mut().zip(grid.indices(index)) {
                slices[index].largest_um = slices[index].largest_um.max(*size);
            }
            for ([low, high], mm) in range_um.iter_mut().zip(pose.tip) {
                (*low, *high) = (low.min(mm * 1e3), high.max(mm * 1e3));
            }
        }
        let turns: Vec<f64> = poses.iter().map(|pose| size(pose.orientation) * 1e6).collect();
        Case {
            largest_um: sizes.iter().copied().fold(0.0, f64::max),
            rms_um: rms(&sizes),
            p95_um: percentile(sizes, 0.95),
            range_um,
            orientation: Orientation { largest_urad: turns.iter().copied().fold(0.0, f64::max), rms_urad: rms(&turns) },
            slices,
            worst,
        }
    }
}

impl Figures {
    /// Figures with the models still missing.
    pub(super) fn new(asked: &Asked, model: Model, clamped_points: usize, before: Case) -> Figures {
        let settings = &asked.machine.settings;
        let rotary = || settings.axes.iter().filter(|own| own.axis.is_rotary());
        let missing = || Left { after: None, limited_points: 0, refused: None };
        Figures {
            machine: settings.name.as_str().to_owned(),
            chain: settings.chain.as_str().to_owned(),
            model,
            own_model: Model::of(settings.compensation.model),
            points: asked.grid.points,
            range_mm: asked.grid.range,
            temperature_c: settings.reference_temperature_c + asked.kelvin,
            kelvin: asked.kelvin,
            negative: settings
                .axes
                .iter()
                .filter(|own| asked.reverse[own.axis.index()])
                .map(|own| own.axis.letter())
                .collect(),
            tool_mm: settings.tool_mm,
            pose_deg: rotary().map(|own| (own.axis.letter(), asked.pose[own.axis.index()])).collect(),
            travel_deg: rotary().map(|own| (own.axis.letter(), own.travel)).collect(),
            corrects_orientation: settings.compensation.orientation,
            clamped_points,
            before,
            nine: missing(),
            volumetric: missing(),
        }
    }

    /// Adds the residual of a model and the number of points at which it was limited, or why the model is refused.
    pub(super) fn add(&mut self, model: Model, after: Result<(Case, usize), String>) {
        let kept = match after {
            Ok((case, limited_points)) => Left { after: Some(case), limited_points, refused: None },
            Err(why) => Left { after: None, limited_points: 0, refused: Some(why) },
        };
        match model {
            Model::Nine => self.nine = kept,
            Model::Volumetric => self.volumetric = kept,
        }
    }
}
