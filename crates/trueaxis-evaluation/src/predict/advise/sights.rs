//! Readings of a ballbar and of a laser interferometer.

use super::instrument::Instrument;
use crate::calibrate::{Ideal, Pose};
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// Readings of a circle in each direction, and its arc where Z moves: the table is below, degrees from the horizontal.
const READINGS: usize = 36;
const UPRIGHT_DEG: [f64; 2] = [-20.0, 200.0];
/// Standard uncertainty of a laser's zero, mm: the readings determine it.
const ZERO: f64 = 0.1;
/// Positions of a laser along an axis without a table.
const POSITIONS: usize = 11;

/// Terms of a circle's evaluation, and how many of them are results.
pub(super) const FOUND: usize = 7;
pub(super) const RESULTS: usize = 4;

/// Readings: how far the tool is from the workpiece along a direction.
#[derive(Clone, Debug)]
pub(super) struct Sights {
    /// Axes and directions of travel, in the machine's order.
    pub(super) poses: Vec<Pose>,
    /// Directions in the coordinates of the workpiece.
    pub(super) along: Vec<[f64; 3]>,
    /// Effects of what else is unknown, of unit variance: a column each, mm.
    pub(super) others: Vec<Vec<f64>>,
    /// Standard deviation of a reading, mm.
    pub(super) noise_mm: f64,
    /// Of a circle: what its evaluation finds, a row each reading: squareness, difference of the scales, lost motion of both
    /// axes; then the pivot and the length, which it removes. Empty if each reading counts by itself.
    pub(super) found: Vec<[f64; FOUND]>,
    /// Why the machine cannot do it.
    pub(super) refused: Option<String>,
}

impl Sights {
    /// Share of the radius by which a circle goes below its centre.
    pub(super) fn below(normal: Axis) -> f64 {
        if normal == Axis::Z { 1.0 } else { -UPRIGHT_DEG[0].to_radians().sin() }
    }

    /// A circle across an axis, in both directions.
    pub(super) fn circle(machine: &Machine, of: &Instrument, normal: Axis, at: [f64; 3], scatter: f64) -> Sights {
        let [i, j] = match normal {
            Axis::X => [1, 2],
            Axis::Y => [0, 2],
            _ => [0, 1],
        };
        let [from, to] = if normal == Axis::Z { [0.0, 360.0] } else { UPRIGHT_DEG };
        let mut rows = Rows::new(machine, at);
        let mut found = Vec::new();
        for sense in [1.0, -1.0] {
            for k in 0..READINGS {
                let angle = (from + (to - from) * (k as f64 + 0.5) / READINGS as f64).to_radians();
                let (mut q, mut reverse) = (at, [0.0; 3]);
                q[i] += of.size_mm * angle.cos();
                q[j] += of.size_mm * angle.sin();
                reverse[i] = f64::from(u8::from(-sense * angle.sin() < 0.0));
                reverse[j] = f64::from(u8::from(sense * angle.cos() < 0.0));
                rows.put(q, reverse, None);
                let (sine, cosine) = angle.sin_cos();
                let [shear, scales] = [sine * cosine, cosine * cosine - sine * sine].map(|part| part * of.size_mm);
                found.push([shear, scales, reverse[i] * cosine, reverse[j] * sine, cosine, sine, 1.0]);
            }
        }
        Sights { found, ..rows.sights(of, scatter, Vec::new()) }
    }

    /// Positions along an axis, in both directions: those of its table.
    pub(super) fn line(machine: &Machine, of: &Instrument, axis: Axis, at: [f64; 3], scatter: f64) -> Sights {
        let own = machine.axes().find(|(own, _)| own.axis == axis);
        let travel = own.map_or([0.0; 2], |(own, _)| own.travel);
        let table = own.and_then(|(_, table)| table).map(|table| table.rows.iter().map(|row| row.position).collect());
        let evenly = || {
            let position = |k: usize| travel[0] + (travel[1] - travel[0]) * k as f64 / (POSITIONS - 1) as f64;
            (0..POSITIONS).map(position).collect()
        };
        let positions: Vec<f64> = table.unwrap_or_else(evenly);
        let mut rows = Rows::new(machine, at);
        let mut lengths = Vec::new();
        for reverse in [0.0, 1.0] {
            for position in positions.iter().filter(|q| (travel[0]..=travel[1]).contains(*q)) {
                let (mut q, mut back) = (at, [0.0; 3]);
                q[axis.index()] = *position;
                back[axis.index()] = reverse;
                rows.put(q, back, Some(axis));
                lengths.push(of.uncertainty * (position - positions[0]));
            }
        }
        let zero = vec![ZERO; lengths.len()];
        rows.sights(of, scatter, vec![zero, lengths])
    }
}

/// Readings as they are put together.
struct Rows<'m> {
    machine: &'m Machine,
    ideal: Option<Ideal>,
    centre: [f64; 3],
    poses: Vec<Pose>,
    along: Vec<[f64; 3]>,
    refused: Option<String>,
}

impl<'m> Rows<'m> {
    fn new(machine: &'m Machine, centre: [f64; 3]) -> Rows<'m> {
        let (poses, along) = (Vec::new(), Vec::new());
        Rows { machine, ideal: Ideal::new(machine).ok(), centre, poses, along, refused: None }
    }

    /// A reading at q; along an axis, otherwise away from the centre.
    fn put(&mut self, q: [f64; 3], reverse: [f64; 3], axis: Option<Axis>) {
        let Some(ideal) = &self.ideal else { return };
        let whole = |[x, y, z]: [f64; 3]| -> [f64; AXES] { [x, y, z, 0.0, 0.0, 0.0] };
        for own in self.machine.settings.axes.iter().filter(|own| !own.axis.is_rotary()) {
            let (at, [low, high]) = (q[own.axis.index()], own.travel);
            if self.refused.is_none() && !(low..=high).contains(&at) {
                let letter = own.axis.letter();
                self.refused = Some(format!("{letter} at {at:.1} mm, needed within its travel, {low} to {high} mm"));
            }
        }
        let mut from = self.centre;
        if let Some(axis) = axis {
            from = q;
            from[axis.index()] -= 1.0;
        }
        let [tip, from] = [q, from].map(|q| ideal.tip(&whole(q)));
        let away: [f64; 3] = std::array::from_fn(|k| tip[k] - from[k]);
        let length = away.iter().map(|part| part * part).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        self.along.push(away.map(|part| part / length));
        self.poses.push(Pose { position: ideal.ordered(&whole(q)), reverse: ideal.ordered(&whole(reverse)) });
    }

    fn sights(self, of: &Instrument, scatter_mm: f64, others: Vec<Vec<f64>>) -> Sights {
        let noise_mm = of.repeatability_mm.unwrap_or_default().hypot(scatter_mm);
        Sights { poses: self.poses, along: self.along, others, noise_mm, found: Vec::new(), refused: self.refused }
    }
}
