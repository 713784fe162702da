//! Axis positions at which the exact geometry puts the tool at its commanded pose.

use super::{Geometry, into_frame, side};
use glam::{DMat3, DVec3};
use trueaxis::machine::AXES;

/// Largest number of passes if none is stated.
const PASSES: usize = 60;
/// Smallest determinant of the linear axes' directions, squared.
const LEAST_SQUARE: f64 = 0.05 * 0.05;
/// Smallest sine of the fade: the correction stays bounded even without a fade.
const LEAST_FADE: f64 = 1e-3;

/// Settings of a correction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CorrectionSettings {
    /// Number of look-ups; `None`: repeat until the correction changes by less than 1e-12 mm (1e-14 rad).
    pub passes: Option<u8>,
    /// The rotary axes correct the tool direction, fully while it is at least this many degrees from its singular pose;
    /// `None`: the linear axes correct the tip and nothing else is corrected.
    pub fade_deg: Option<f64>,
}

/// Directions in which the axes move the tool relative to the workpiece, in bed directions, at a pose.
struct Directions {
    linear: [Option<(usize, DVec3)>; 3],
    rotary: [Option<(usize, DVec3)>; 3],
}

impl Geometry {
    /// The correction `r`, mm and degrees in the order of `settings.axes`: the actual tip at `position + r` equals the ideal
    /// tip at `position` in workpiece coordinates, grids included.
    ///
    /// `r ← r − J⁺ D(q + r)` with `D = R_w (p_w,actual(q + r) − p_w,ideal(q))` and J the nominal directions of the linear
    /// axes; in a direction that no linear axis has, the result is the nearest possible. With a fade the rotary axes correct
    /// the tool direction t, `Σ δ_k a_k × t = −(error of t)` in the least-squares sense, weighted by 1 if the singular measure
    /// s = |t · (a_1 × a_2)| (one axis: |a × t|) is at least sin(`fade_deg`), and by `x² (3 − 2x)`, x = s / sin(`fade_deg`),
    /// below. Cost: two products of the chain a pass, usually 4 to 6 passes.
    ///
    /// `None` if the linear axes' directions are linearly dependent at this pose, or if the errors are too steep to be
    /// corrected.
    pub fn correction(
        &self,
        position: &[f64; AXES],
        reverse: &[f64; AXES],
        settings: CorrectionSettings,
    ) -> Option<[f64; AXES]> {
        let (workpiece, _) = side(&self.workpiece, position, reverse);
        let (tool, _) = side(&self.tool, position, reverse);
        let ideal = self.pose(&workpiece, &tool);
        let (ideal_tip, ideal_direction) = (DVec3::from_array(ideal.tip_mm), DVec3::from_array(ideal.direction));
        let directions = self.directions(position);
        let undo = nearest(&directions.linear)?;
        let pointing = workpiece.matrix3 * ideal_direction;
        let turns = settings.fade_deg.map(|degrees| Turns::new(&directions.rotary, pointing, degrees));

        let reach = position.iter().fold(ideal_tip.length(), |far, q| far.max(q.abs()));
        let settled = (1e-12 + 8.0 * f64::EPSILON * reach, 1e-14);
        let mut correction = [0.0; AXES];
        for _ in 0..settings.passes.map_or(PASSES, usize::from) {
            let at: [f64; AXES] = std::array::from_fn(|slot| position[slot] + correction[slot]);
            let (_, workpiece_actual) = side(&self.workpiece, &at, reverse);
            let (_, tool_actual) = self.tool_side(&at, reverse);
            let mut change = (0.0_f64, 0.0_f64);
            if let Some(turns) = &turns {
                let actual = workpiece_actual.matrix3.transpose() * tool_actual.matrix3 * self.tool_axis;
                let wrong = workpiece.matrix3 * (actual - ideal_direction);
                for (slot, angle) in turns.back(wrong, &correction) {
                    let degrees = angle.to_degrees();
                    change.1 = change.1.max((degrees - correction[slot]).abs().to_radians());
                    correction[slot] = degrees;
                }
            }
            // Looked up again, so that even with a fixed count the linear axes correct the tip motion of the rotary axes.
            let at: [f64; AXES] = std::array::from_fn(|slot| position[slot] + correction[slot]);
            let (_, workpiece_actual) = side(&self.workpiece, &at, reverse);
            let (_, tool_actual) = self.tool_side(&at, reverse);
            let actual = into_frame(&workpiece_actual, tool_actual.transform_point3(self.tool_mm));
            let step = undo * (workpiece.matrix3 * (actual - ideal_tip));
            for (axis, step) in directions.linear.iter().zip(step.to_array()) {
                if let Some((slot, _)) = axis {
                    correction[*slot] -= step;
                    change.0 = change.0.max(step.abs());
                }
            }
            if settings.passes.is_none() && change.0 <= settled.0 && change.1 <= settled.1 {
                return Some(correction);
            }
        }
        settings.passes.map(|_| correction)
    }

    fn directions(&self, position: &[f64; AXES]) -> Directions {
        let mut directions = Directions { linear: [None; 3], rotary: [None; 3] };
        for carriages in [&self.workpiece, &self.tool] {
            let mut carrier = DMat3::IDENTITY;
            for carriage in carriages {
                let along = carrier * carriage.along * (carriage.motion * carriage.sign);
                if carriage.rotary {
                    directions.rotary[carriage.own - 3] = Some((carriage.slot, along));
                    let angle = (carriage.motion * position[carriage.slot]).to_radians();
                    carrier *= super::rotation::about(carriage.along, angle);
                } else {
                    directions.linear[carriage.own] = Some((carriage.slot, along));
                }
            }
        }
        directions
    }
}

/// Least-squares inverse of the linear axes' directions, zero rows for absent axes.
fn nearest(linear: &[Option<(usize, DVec3)>; 3]) -> Option<DMat3> {
    let columns = linear.map(|axis| axis.map_or(DVec3::ZERO, |(_, along)| along));
    let j = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let present = DVec3::from_array(linear.map(|axis| if axis.is_some() { 0.0 } else { 1.0 }));
    let gram = j.transpose() * j + DMat3::from_diagonal(present);
    (gram.determinant() >= LEAST_SQUARE).then(|| gram.inverse() * j.transpose())
}

/// Effect of the rotary axes on the tool direction.
struct Turns {
    axes: Vec<(usize, DVec3)>,
    pointing: DVec3,
    scale: f64,
}

impl Turns {
    fn new(rotary: &[Option<(usize, DVec3)>; 3], pointing: DVec3, fade_deg: f64) -> Turns {
        let axes: Vec<(usize, DVec3)> =
            rotary.iter().flatten().map(|&(slot, along)| (slot, along.cross(pointing))).collect();
        let square = match axes.as_slice() {
            [(_, only)] => only.length_squared(),
            all => pairs(all).map(|(_, a, _, b)| pointing.dot(a.cross(b)).powi(2)).sum(),
        };
        let sine = fade_deg.to_radians().sin().max(LEAST_FADE);
        let scale =
            if square >= sine * sine { 1.0 / square } else { (3.0 - 2.0 * square.sqrt() / sine) / (sine * sine) };
        Turns { axes, pointing, scale }
    }

    /// Corrections, rad, that cancel the direction error `wrong` observed with the corrections `so_far` (degrees).
    fn back(&self, wrong: DVec3, so_far: &[f64; AXES]) -> Vec<(usize, f64)> {
        // The machine's error is the observed error less the motion due to the correction itself.
        let moved: DVec3 = self.axes.iter().map(|&(slot, column)| column * so_far[slot].to_radians()).sum();
        let error = wrong - moved;
        if let [(slot, only)] = self.axes.as_slice() {
            return vec![(*slot, -only.dot(error) * self.scale)];
        }
        let mut wanted: Vec<(usize, f64)> = self.axes.iter().map(|&(slot, _)| (slot, 0.0)).collect();
        // For more than two axes the shortest solution is the mean over all pairs, weighted by their squared determinants.
        for (i, a, j, b) in pairs(&self.axes) {
            let determinant = self.pointing.dot(a.cross(b));
            wanted[i].1 -= determinant * self.pointing.dot(error.cross(b)) * self.scale;
            wanted[j].1 -= determinant * self.pointing.dot(a.cross(error)) * self.scale;
        }
        wanted
    }
}

fn pairs(axes: &[(usize, DVec3)]) -> impl Iterator<Item = (usize, DVec3, usize, DVec3)> + '_ {
    axes.iter()
        .enumerate()
        .flat_map(move |(i, &(_, a))| axes.iter().enumerate().skip(i + 1).map(move |(j, &(_, b))| (i, a, j, b)))
}
