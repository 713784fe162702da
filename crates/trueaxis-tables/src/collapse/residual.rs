//! Error that tables leave, on a separate grid.

use super::additive::{Level, MainEffects, levels};
use super::volume::Volume;
use super::{CollapseError, LINEAR};
use crate::Machine;
use crate::exact::Geometry;
use trueaxis::compensation::Query;
use trueaxis::compensation::{Compensation, Direction, ThermalLine, requirement};
use trueaxis::error::ConfigError;
use trueaxis::machine::AxisOrder;
use trueaxis::machine::{AXES, Axis};

/// Points per axis at which deviations are evaluated, equidistant, ends included: 42 steps rarely coincide with a table's
/// lines.
const POINTS: usize = 43;
/// Points per axis for the causes.
const FEW_POINTS: usize = 11;

/// Size of a vector field over the working volume, both directions of two-sided axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Largest length, mm.
    pub max_mm: f64,
    /// Root of the mean square of the length over the volume, mm.
    pub rms_mm: f64,
    /// Largest component along X, Y, Z, mm.
    pub max_along_mm: [f64; 3],
    /// Root mean square along X, Y, Z, mm.
    pub rms_along_mm: [f64; 3],
    /// Position of the largest length: X, Y, Z, mm.
    pub at_mm: [f64; 3],
}

/// Share of an axis in the error that no nine tables can express.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cause {
    /// The axis.
    pub axis: Axis,
    /// RMS that the angular errors of this axis alone leave after the best nine tables, mm.
    pub rms_mm: f64,
}

#[derive(Default)]
struct Sum {
    squares: [f64; 3],
    worst: Deviation,
}

impl Sum {
    fn add(&mut self, point: [f64; 3], weight: f64, d: [f64; 3]) {
        for c in 0..3 {
            self.squares[c] += weight * d[c] * d[c];
            self.worst.max_along_mm[c] = self.worst.max_along_mm[c].max(d[c].abs());
        }
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        if length > self.worst.max_mm {
            self.worst.max_mm = length;
            self.worst.at_mm = point;
        }
    }

    fn deviation(&self) -> Deviation {
        Deviation {
            rms_mm: self.squares.iter().sum::<f64>().sqrt(),
            rms_along_mm: self.squares.map(f64::sqrt),
            ..self.worst
        }
    }
}

/// Passes to `user` the tip error according to the controller's nine-term form: positions and directions (0, 1) in the order
/// of the machine's axes.
pub(super) fn with_nine_terms<T>(
    machine: &Machine,
    user: impl FnOnce(&dyn Fn(&[f64; AXES], &[f64; AXES]) -> [f64; 3]) -> T,
) -> Result<T, ConfigError> {
    match machine.settings.step_axes().count() {
        3 => with_step::<3, T>(machine, user),
        _ => with_step::<6, T>(machine, user),
    }
}

fn with_step<const N: usize, T>(
    machine: &Machine,
    user: impl FnOnce(&dyn Fn(&[f64; AXES], &[f64; AXES]) -> [f64; 3]) -> T,
) -> Result<T, ConfigError> {
    let rows = |axis: Axis| machine.rows(axis);
    let mut memory = vec![0.0; requirement(&machine.settings, rows)];
    let compensation = Compensation::<f64, f64, N>::build(&machine.settings, rows, &machine.grids(), 1, &mut memory)?;
    // The step has slots for axes that the machine does not have.
    let slots: [Option<usize>; N] = AxisOrder::<N>::with_spare_slots(&machine.settings)?
        .axes()
        .map(|axis| machine.settings.axes.iter().position(|own| own.axis == axis));
    let tip = |position: &[f64; AXES], reverse: &[f64; AXES]| {
        let of = |all: &[f64; AXES]| slots.map(|slot| slot.map_or(0.0, |slot| all[slot]));
        let direction = of(reverse).map(|reverse| Direction::of(reverse > 0.0));
        let at = compensation.coordinates(&of(position));
        let errors = compensation.errors(&Query::at(&at, &direction, &[ThermalLine::default(); N]), &mut 0);
        [errors[0], errors[1], errors[2]]
    };
    Ok(user(&tip))
}

pub(super) struct Deviations<const M: usize> {
    pub(super) count: usize,
    pub(super) before: Deviation,
    pub(super) left: [Deviation; M],
}

/// The error of `geometry`, and the error left by the nine-term forms of two machines.
pub(super) fn evaluate(
    volume: &Volume,
    geometry: &Geometry,
    machines: [&Machine; 2],
) -> Result<Deviations<2>, ConfigError> {
    let levels = grid(volume, POINTS, volume.two_sided);
    let [first, second] = machines;
    with_nine_terms(first, |first| {
        with_nine_terms(second, |second| {
            let mut sums: [Sum; 3] = Default::default();
            for &x in &levels[0] {
                for &y in &levels[1] {
                    for &z in &levels[2] {
                        let cell = [x, y, z];
                        let point = cell.map(|level| level.position);
                        let (at, reverse) = (volume.position(point), volume.direction(cell.map(|level| level.reverse)));
                        let d = geometry.tip_error(&at, &reverse);
                        let weight = x.weight * y.weight * z.weight;
                        for (sum, model) in sums.iter_mut().zip([[0.0; 3], first(&at, &reverse), second(&at, &reverse)])
                        {
                            sum.add(point, weight, std::array::from_fn(|c| d[c] - model[c]));
                        }
                    }
                }
            }
            let [before, first, second] = sums.map(|sum| sum.deviation());
            let count = levels.iter().map(Vec::len).product();
            Deviations { count, before, left: [first, second] }
        })
    })?
}

fn grid(volume: &Volume, points: usize, two_sided: [bool; 3]) -> [Vec<Level>; 3] {
    std::array::from_fn(|i| {
        let [low, high] = volume.ends[i];
        if volume.slots[i].is_none() {
            return levels(&[0.0], false);
        }
        let last = points - 1;
        let point = |k: usize| if k == last { high } else { low + (high - low) * (k as f64 / last as f64) };
        levels(&(0..points).map(point).collect::<Vec<f64>>(), two_sided[i])
    })
}

/// Error that each linear axis' angular errors alone leave after the best sum, largest first; axes without any are omitted.
pub(super) fn causes(volume: &Volume, machine: &Machine) -> Result<Vec<Cause>, CollapseError> {
    let levels = grid(volume, FEW_POINTS, volume.two_sided_table);
    let mut causes = Vec::new();
    for (axis, slot) in LINEAR.into_iter().zip(volume.slots) {
        let Some(slot) = slot else { continue };
        let mut alone = machine.clone();
        let mut angular = false;
        for (k, table) in alone.tables.iter_mut().enumerate() {
            for twist in table.iter_mut().flat_map(|t| &mut t.rows).flat_map(|row| [&mut row.forward, &mut row.reverse])
            {
                angular |= k == slot && twist[3..].iter().any(|w| *w != 0.0);
                if k != slot && volume.slots.contains(&Some(k)) {
                    twist[3..].fill(0.0);
                }
            }
        }
        if !angular {
            continue;
        }
        let geometry = Geometry::new(&alone, 0.0)?;
        let error = |cell: [Level; 3]| {
            let at = volume.position(cell.map(|level| level.position));
            geometry.tip_error(&at, &volume.direction(cell.map(|level| level.reverse)))
        };
        let effects = MainEffects::of(&levels, error);
        let mut square = 0.0;
        for (i, &x) in levels[0].iter().enumerate() {
            for (j, &y) in levels[1].iter().enumerate() {
                for (k, &z) in levels[2].iter().enumerate() {
                    let left =
                        error([x, y, z]).into_iter().zip(effects.sum([i, j, k])).map(|(d, sum)| (d - sum).powi(2));
                    square += x.weight * y.weight * z.weight * left.sum::<f64>();
                }
            }
        }
        causes.push(Cause { axis, rms_mm: square.sqrt() });
    }
    causes.sort_by(|a, b| b.rms_mm.total_cmp(&a.rms_mm));
    Ok(causes)
}
