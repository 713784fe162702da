//! Errors that repeat within a period of an axis, in the form that the step reads.
//!
//! The error of a period is a function of the axis' position alone and adds to the axis' own error, before the exact inverse:
//! [`PeriodicSettings`]. One period is divided into cells, at least sixteen for its highest harmonic, with a cubic in each
//! that has the error's value and slope at both ends:
//!
//! ```text
//! E = k0 + k1 t + k2 t² + k3 t³          t = 0 … 65536 in the cell
//! ```
//!
//! With 16 cells, h the length of one over the wavelength of the highest harmonic, the cubics deviate from that harmonic by at
//! most (2πh)⁴/384 = 6e-5 of its amplitude. No cell is kept from cycle to cycle: the number of instructions is the same at
//! any speed. The place within a period is an integer of 32 bits that wraps with the period, so it is as exact many periods
//! from machine zero as there.
//!
//! The tables' inverse does not see the periods. It starts from a command that their correction has moved, and returns the
//! tables' part T of the correction; one step of Newton's method for the periods alone, from the correction c sent last,
//! gives the whole:
//!
//! ```text
//! r = c + (T − E(q + c) − c) / (1 + E'(q + c))          |r − r*| <= |E"| |c − r*|² / 2 (1 − |E'|), beside the tables' share
//! ```

#![deny(clippy::indexing_slicing)]

use super::reversal::{Direction, Reversal};
use super::table::enough;
use crate::error::ConfigError;
use crate::machine::{AxisOrder, MachineSettings, PeriodicSettings, carries_workpiece};
use crate::position::Position;
use crate::real::Real;

/// Cells in the wavelength of the highest harmonic.
const CELLS_PER_WAVE: usize = 16;
/// Parts of a cell in which places are told apart.
const PARTS: f64 = 65536.0;
/// Lines before the cells of a period.
const HEAD: usize = 2;
/// Bit beside the slot: the next period is of another axis.
const LAST: u16 = 1 << 3;

/// Four numbers: the polynomial of a cell, or half a head.
type Line<R> = [R; 4];

/// The periods of a machine, sorted by slots, as lines of numbers: immutable, built once. For each period a head, the cells of
/// positive travel and, if the directions differ, those of negative travel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Periods<'a, R>(&'a [Line<R>]);

/// One period of an axis.
struct Wave<'a, R> {
    slot: usize,
    /// Whether the next period is of another axis.
    last: bool,
    /// [`Position::rate`].
    rate: u64,
    cells: &'a [Line<R>],
    /// Number of cells of a period.
    count: usize,
    /// First cell of negative travel.
    reverse: usize,
    /// Parts of cells per mm (deg).
    scale: R,
}

/// Cells of one direction of a period.
fn cells(settings: &PeriodicSettings) -> usize {
    CELLS_PER_WAVE * settings.highest().max(1)
}

fn lines_of(settings: &PeriodicSettings) -> usize {
    HEAD + cells(settings) * (1 + usize::from(settings.is_two_sided()))
}

/// Memory that the periods of a machine need, in scalars of the step.
pub(super) fn requirement(machine: &MachineSettings) -> usize {
    machine.periodic.iter().map(|settings| 4 * lines_of(settings)).sum()
}

/// Writes the lines of a period; `sense` of the table's angles to the reading.
fn write<R: Real, P: Position>(
    settings: &PeriodicSettings,
    slot: usize,
    last: bool,
    sense: f64,
    lines: &mut [Line<R>],
) {
    let count = cells(settings);
    let width = settings.length() / count as f64;
    let [first, second, lines @ ..] = lines else { return };
    let rate = P::rate(settings.length());
    let reverse = if settings.is_two_sided() { count } else { 0 };
    // Six axes, and at most 192 cells.
    let axis = slot as u16 | if last { LAST } else { 0 };
    *first = [R::of_index(axis), R::of_word(rate as u32), R::of_word((rate >> 32) as u32), R::of(PARTS / width)];
    *second = [R::of_index(count as u16), R::of_index(reverse as u16), R::ZERO, R::ZERO];
    for (block, negative) in lines.chunks_mut(count).zip([false, true]) {
        for (index, cell) in block.iter_mut().enumerate() {
            let [[e0, d0], [e1, d1]] = [index, index + 1].map(|node| {
                let [error, slope] = settings.error_and_slope(node as f64 * width, negative);
                [sense * error, sense * slope * width]
            });
            let [k2, k3] = [3.0 * (e1 - e0) - 2.0 * d0 - d1, 2.0 * (e0 - e1) + d0 + d1];
            *cell = [e0, d0 / PARTS, k2 / (PARTS * PARTS), k3 / (PARTS * PARTS * PARTS)].map(R::of);
        }
    }
}

impl<'a, R: Real> Wave<'a, R> {
    /// Reads the next period, and returns the lines after it.
    #[inline(always)]
    fn next(lines: &'a [Line<R>]) -> Option<(Self, &'a [Line<R>])> {
        let [[axis, low, high, scale], [count, reverse, ..], rest @ ..] = lines else { return None };
        let (axis, count, reverse) = (axis.to_index(), count.to_index(), reverse.to_index());
        let (cells, after) = rest.split_at_checked(count.wrapping_add(reverse))?;
        let rate = u64::from(high.to_word()) << 32 | u64::from(low.to_word());
        let (slot, last) = (axis & usize::from(LAST - 1), axis & usize::from(LAST) != 0);
        let wave = Wave { slot, last, rate, cells, count, reverse, scale: *scale };
        Some((wave, after))
    }

    /// The cell at a place in the period, and where in it.
    #[inline(always)]
    fn cell(&self, phase: u32, direction: Direction) -> Option<(&'a Line<R>, R)> {
        // Whole and fraction of the place in cells.
        let place = u64::from(phase) * self.count as u64;
        let index = ((place >> 32) as usize).wrapping_add(self.reverse & direction.mask());
        Some((self.cells.get(index)?, R::of_i32((place as u32 >> 16) as i32)))
    }
}

#[inline(always)]
fn value<R: Real>([k0, k1, k2, k3]: &Line<R>, t: R) -> R {
    k0.add_product(t, k1.add_product(t, k2.add_product(t, *k3)))
}

/// [`value`] and its slope per part of a cell.
#[inline(always)]
fn value_and_slope<R: Real>([k0, k1, k2, k3]: &Line<R>, t: R) -> [R; 2] {
    let second = k2.add_product(t, *k3);
    let first = k1.add_product(t, second);
    [k0.add_product(t, first), first.add_product(t, second.add_product(t, *k3))]
}

impl<'a, R: Real> Periods<'a, R> {
    /// Builds the periods of a machine in borrowed memory. Returns the rest of the memory.
    pub(super) fn build<P: Position, const N: usize>(
        order: &AxisOrder<N>,
        machine: &MachineSettings,
        memory: &'a mut [R],
    ) -> Result<(Self, &'a mut [R]), ConfigError> {
        let needed = requirement(machine);
        enough(memory.len(), needed)?;
        let (own, rest) = memory.split_at_mut_checked(needed).unwrap_or_default();
        let lines = own.as_chunks_mut::<4>().0;
        let mut written = 0;
        for slot in 0..N {
            let mut all = machine.periodic.iter().filter(|settings| order.slot(settings.axis) == Some(slot)).peekable();
            while let Some(settings) = all.next() {
                let Some(axis) = machine.axis(settings.axis) else { continue };
                let sense = if axis.axis.is_rotary() {
                    f64::from(axis.direction) * if carries_workpiece(&machine.chain, axis.axis) { -1.0 } else { 1.0 }
                } else {
                    1.0
                };
                let end = written + lines_of(settings);
                if let Some(lines) = lines.get_mut(written..end) {
                    write::<R, P>(settings, slot, all.peek().is_none(), sense, lines);
                }
                written = end;
            }
        }
        Ok((Periods(lines.get(..written).unwrap_or_default()), rest))
    }

    /// Whether there are none.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Completes the tables' corrections of a cycle by those of the periods, and adds the errors at the feedback to those of
    /// the tip. `drive`: command with the correction sent last. Returns the square of the way from there, of these axes.
    // Only with periods.
    #[inline(never)]
    pub(crate) fn complete<P: Position, const N: usize>(
        &self,
        [command, drive, feedback]: [&[P; N]; 3],
        reversal: &[Reversal<P>; N],
        wanted: &mut [R; N],
        tip_error: &mut [R; N],
    ) -> R {
        let mut square = R::ZERO;
        let mut lines = self.0;
        let [mut error, mut slope, mut tip] = [R::ZERO; 3];
        // At most 6 rounds: the settings hold no more periods.
        while let Some((wave, after)) = Wave::next(lines) {
            lines = after;
            let slot = wave.slot;
            let (Some(drive), Some(back), Some(reversal)) = (drive.get(slot), feedback.get(slot), reversal.get(slot))
            else {
                break;
            };
            let direction = reversal.direction();
            let (Some((there, along)), Some((here, t))) =
                (wave.cell(drive.phase(wave.rate), direction), wave.cell(back.phase(wave.rate), direction))
            else {
                break;
            };
            let [own, rise] = value_and_slope(there, along);
            error += own;
            slope = slope.add_product(rise, wave.scale);
            tip += value(here, t);
            if !wave.last {
                continue;
            }
            if let (Some(command), Some(wanted), Some(tip_error)) =
                (command.get(slot), wanted.get_mut(slot), tip_error.get_mut(slot))
            {
                let sent: R = drive.since_near(*command);
                let way = (*wanted - error - sent) / (R::ONE + slope);
                *wanted = sent + way;
                square += way * way;
                *tip_error += tip;
            }
            [error, slope, tip] = [R::ZERO; 3];
        }
        square
    }

    /// Error and slope of the axis in a slot at a position from machine zero, mm (deg).
    // Only with periods.
    #[inline(never)]
    pub(super) fn of_axis(&self, slot: usize, position: R, direction: Direction) -> [R; 2] {
        let mut lines = self.0;
        let mut sum = [R::ZERO; 2];
        // At most 6 rounds: the settings hold no more periods.
        while let Some((wave, after)) = Wave::next(lines) {
            lines = after;
            if wave.slot != slot {
                continue;
            }
            let periods = position * wave.scale / R::of_i32((wave.count << 16) as i32);
            let part = periods - R::of_i32(periods.to_i32());
            // A negative part wraps.
            let phase = ((part * R::of((1_u32 << 31) as f64)).to_i32() as u32) << 1;
            let Some((cell, t)) = wave.cell(phase, direction) else { break };
            let [own, rise] = value_and_slope(cell, t);
            let [error, slope] = &mut sum;
            *error += own;
            *slope += rise * wave.scale;
        }
        sum
    }
}
