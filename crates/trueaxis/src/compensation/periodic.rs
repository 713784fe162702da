//! Errors that repeat within a period of an axis, in the form that the step reads.
//!
//! The error of a period is a function of the axis' position alone and adds to the axis' own error, before the exact inverse:
//! [`PeriodicSettings`]. One period is divided into cells, at least sixteen for its highest harmonic, with a cubic in each
//! that has the error's value and slope at both ends:
//!
//! ```text
//! E = k0 + k1 t + k2 t² + k3 t³          t = 0 … 1 in the cell
//! ```
//!
//! With 16 cells, h the length of one over the wavelength of the highest harmonic, the cubics deviate from that harmonic by at
//! most (2πh)⁴/384 = 6e-5 of its amplitude. No cell is kept from cycle to cycle: the number of instructions is the same at
//! any speed. In single precision a position of 1 m is rounded to 30 nm, which changes an error with a slope of 0.01 by
//! 0.3 nm.

#![deny(clippy::indexing_slicing)]

use super::Errors;
use super::reversal::Direction;
use super::table::enough;
use crate::error::ConfigError;
use crate::machine::{AxisOrder, MachineSettings, PERIODIC_CAPACITY, PeriodicSettings, carries_workpiece};
use crate::position::Position;
use crate::real::Real;

/// Cells in the wavelength of the highest harmonic.
const CELLS_PER_WAVE: usize = 16;

/// Polynomial of a cell.
type Cell<R> = [R; 4];

/// One period of an axis.
#[derive(Clone, Copy, Debug)]
struct Wave<'a, R> {
    slot: u8,
    /// Of positive travel, then, if it differs, of negative travel.
    cells: &'a [Cell<R>],
    /// Number of cells of a period, a power of two, less 1.
    mask: u16,
    reverse_offset: u16,
    /// Cells per mm (deg), and per step of the position.
    scale: R,
    per_step: R,
}

impl<'a, R: Real> Wave<'a, R> {
    /// Builds a period in borrowed memory; `sense` of the table's angles to the reading, `step` of the position.
    fn build<'m>(
        settings: &PeriodicSettings,
        slot: usize,
        [sense, step]: [f64; 2],
        memory: &'m mut [R],
    ) -> Result<(Self, &'m mut [R]), ConfigError>
    where
        'm: 'a,
    {
        let (count, needed) = (cells(settings), requirement_of(settings));
        enough(memory.len(), needed)?;
        let (lines, rest) = memory.split_at_mut_checked(needed).unwrap_or_default();
        let lines = lines.as_chunks_mut::<4>().0;
        let width = settings.length() / count as f64;
        for (block, negative) in lines.chunks_mut(count).zip([false, true]) {
            for (index, cell) in block.iter_mut().enumerate() {
                let [[e0, d0], [e1, d1]] = [index, index + 1].map(|node| {
                    let [error, slope] = settings.error_and_slope(node as f64 * width, negative);
                    [sense * error, sense * slope * width]
                });
                *cell = [e0, d0, 3.0 * (e1 - e0) - 2.0 * d0 - d1, 2.0 * (e0 - e1) + d0 + d1].map(R::of);
            }
        }
        let reverse_offset = if settings.is_two_sided() { count as u16 } else { 0 };
        let [scale, per_step] = [1.0, step].map(|unit| R::of(unit / width));
        // Six axes, and at most 128 cells.
        Ok((Wave { slot: slot as u8, cells: lines, mask: count as u16 - 1, reverse_offset, scale, per_step }, rest))
    }

    /// Error at a place from machine zero, in cells; mm (deg).
    #[inline(always)]
    fn at(&self, place: R, reverse: Direction) -> R {
        let whole = place.to_i32();
        let rest = place - R::of_i32(whole);
        let (whole, t) = if rest < R::ZERO { (whole.wrapping_sub(1), rest + R::ONE) } else { (whole, rest) };
        // Beyond 2³¹ cells, where the whole part saturates.
        let t = t.limit(R::ZERO, R::ONE);
        let start = usize::from(self.reverse_offset) & reverse.mask();
        let index = (whole as usize & usize::from(self.mask)).wrapping_add(start);
        let Some([k0, k1, k2, k3]) = self.cells.get(index) else { return R::ZERO };
        k0.add_product(t, k1.add_product(t, k2.add_product(t, *k3)))
    }
}

/// The periods of a machine: immutable, built once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Periods<'a, R>([Option<Wave<'a, R>>; PERIODIC_CAPACITY]);

/// Cells of one direction of a period.
fn cells(settings: &PeriodicSettings) -> usize {
    (CELLS_PER_WAVE * settings.highest().max(1)).next_power_of_two()
}

fn requirement_of(settings: &PeriodicSettings) -> usize {
    4 * cells(settings) * (1 + usize::from(settings.is_two_sided()))
}

/// Memory that the periods of a machine need, in scalars of the step.
pub(super) fn requirement(machine: &MachineSettings) -> usize {
    machine.periodic.iter().map(requirement_of).sum()
}

impl<'a, R: Real> Periods<'a, R> {
    /// Builds the periods of a machine in borrowed memory; `None` if it has none. Returns the rest of the memory.
    pub(super) fn build<P: Position, const N: usize>(
        order: &AxisOrder<N>,
        machine: &MachineSettings,
        mut memory: &'a mut [R],
    ) -> Result<(Option<Self>, &'a mut [R]), ConfigError> {
        let mut waves = [None; PERIODIC_CAPACITY];
        let mut free = waves.iter_mut();
        for settings in &machine.periodic {
            let (Some(slot), Some(axis)) = (order.slot(settings.axis), machine.axis(settings.axis)) else { continue };
            let sense = if axis.axis.is_rotary() {
                f64::from(axis.direction) * if carries_workpiece(&machine.chain, axis.axis) { -1.0 } else { 1.0 }
            } else {
                1.0
            };
            let (wave, rest) = Wave::build(settings, slot, [sense, P::STEP], memory)?;
            memory = rest;
            // As many as the settings hold.
            if let Some(place) = free.next() {
                *place = Some(wave);
            }
        }
        let is_any = waves.iter().any(Option::is_some);
        Ok((is_any.then_some(Periods(waves)), memory))
    }

    /// Adds the errors at two positions of X, Y, Z.
    // Only with periods.
    #[inline(always)]
    pub(crate) fn add_to_both<P: Position>(
        &self,
        positions: [&[P; 3]; 2],
        directions: &[Direction; 3],
        errors: &mut [[R; 3]; 2],
    ) {
        let ([there, back], [of_command, of_feedback]) = (positions, errors);
        let zero = P::of(0.0);
        // At most 6 rounds: the settings hold no more periods.
        for wave in self.0.iter().map_while(Option::as_ref) {
            let slot = usize::from(wave.slot);
            let (Some(there), Some(back), Some(direction)) = (there.get(slot), back.get(slot), directions.get(slot))
            else {
                continue;
            };
            let place = |position: &P| position.steps_above::<R>(zero, P::Reach::default()).0 * wave.per_step;
            if let (Some(command), Some(feedback)) = (of_command.get_mut(slot), of_feedback.get_mut(slot)) {
                *command += wave.at(place(there), *direction);
                *feedback += wave.at(place(back), *direction);
            }
        }
    }

    /// Adds the errors at positions from machine zero, mm (deg).
    // Only with periods.
    #[inline(never)]
    pub(crate) fn add_to<const N: usize>(
        &self,
        positions: &[R; N],
        directions: &[Direction; N],
        errors: &mut Errors<R, N>,
    ) {
        // At most 6 rounds: the settings hold no more periods.
        for wave in self.0.iter().map_while(Option::as_ref) {
            let slot = usize::from(wave.slot);
            let (Some(position), Some(direction), Some(error)) =
                (positions.get(slot), directions.get(slot), errors.get_mut(slot))
            else {
                continue;
            };
            *error += wave.at(*position * wave.scale, *direction);
        }
    }
}

/// Position from machine zero, mm (deg).
#[inline(always)]
pub(crate) fn from_zero<R: Real, P: Position>(position: P) -> R {
    position.since_near(P::of(0.0))
}
