//! Cells kept from cycle to cycle.

use super::LINEAR;
use super::cell::Cell;
use super::tables::{Passes, Tables};
use crate::compensation::thermal::ThermalLine;
use crate::position::Position;
use crate::real::Real;

/// The cells of all three axes about one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<R, P: Position> {
    pub(super) cells: [Cell<R, P>; LINEAR],
    /// Sum of the errors at the starts of the cells.
    base: [R; 3],
}

impl<R: Real, P: Position> Point<R, P> {
    fn nowhere() -> Self {
        Point { cells: [Cell::nowhere(); LINEAR], base: [R::ZERO; 3] }
    }

    /// A cell has been filled.
    pub(super) fn sum_up(&mut self) {
        let [x, y, z] = &self.cells;
        self.base = core::array::from_fn(|k| x.start[k] + y.start[k] + z.start[k]);
    }

    /// Distances from the starts of the cells, and whether all three positions lie in theirs.
    #[inline(always)]
    fn steps(&self, [x, y, z]: [P; LINEAR]) -> ([R; LINEAR], bool) {
        let [cx, cy, cz] = &self.cells;
        let (x, in_x) = cx.steps(x);
        let (y, in_y) = cy.steps(y);
        let (z, in_z) = cz.steps(z);
        ([x, y, z], in_x & in_y & in_z)
    }

    /// Sum of the linear polynomials.
    #[inline(always)]
    fn linear(&self, [x, y, z]: [R; LINEAR]) -> [R; 3] {
        let [cx, cy, cz] = &self.cells;
        core::array::from_fn(|k| self.base[k] + x * cx.slope[k] + y * cy.slope[k] + z * cz.slope[k])
    }

    /// Sum of the cubic polynomials.
    #[inline(always)]
    fn cubic(&self, [x, y, z]: [R; LINEAR]) -> [R; 3] {
        let [cx, cy, cz] = &self.cells;
        core::array::from_fn(|k| self.base[k] + cx.rise(x, k) + cy.rise(y, k) + cz.rise(z, k))
    }
}

/// Cells kept from cycle to cycle; forgotten, they are found again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells<R, P: Position> {
    key: u64,
    passes: Passes,
    pub(super) command: Point<R, P>,
    pub(super) feedback: Point<R, P>,
    /// A bit for every axis whose cell at the command lies beyond its table.
    pub(super) at_edge: u8,
}

impl<R: Real, P: Position> Cells<R, P> {
    /// Key of no tables.
    pub(crate) const NONE: u64 = 0;

    /// None yet, of no tables.
    pub(crate) fn none() -> Self {
        let passes = Passes { motion: 1, any: 1 };
        Cells { key: Self::NONE, passes, command: Point::nowhere(), feedback: Point::nowhere(), at_edge: 0 }
    }

    /// Makes them cells of these tables, none yet if they were not; returns whether they were.
    pub(crate) fn are_of<const N: usize>(&mut self, tables: &Tables<R, P>, thermal: &[ThermalLine<R>; N]) -> bool {
        // With more look-ups than one, no cycle ends in the cells as they are: they have a key of their own.
        if self.key == tables.key || self.key == !tables.key {
            return true;
        }
        self.passes = tables.passes(thermal);
        self.key = if self.passes.motion == 1 { tables.key } else { !tables.key };
        (self.command, self.feedback, self.at_edge) = (Point::nowhere(), Point::nowhere(), 0);
        false
    }

    /// Look-ups of the inverse in this cycle; `anything`: more has changed than that the axes moved.
    pub(crate) fn passes(&self, anything: bool) -> u8 {
        if anything { self.passes.any } else { self.passes.motion }
    }

    /// Key of the tables that they are of.
    #[inline(always)]
    pub(crate) fn key(&self) -> u64 {
        self.key
    }

    /// From now on they are of no tables.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        self.key = Self::NONE;
    }

    /// Forgets the cells of an axis.
    pub(crate) fn forget_axis(&mut self, slot: usize) {
        for point in [&mut self.command, &mut self.feedback] {
            if let Some(cell) = point.cells.get_mut(slot) {
                *cell = Cell::nowhere();
            }
        }
    }

    /// Axes beyond their tables at the command.
    #[inline(always)]
    pub(crate) fn at_edge(&self) -> u8 {
        self.at_edge
    }

    /// Errors at command and feedback, in mm; none where one of the axes has left its cell.
    #[inline(always)]
    pub(crate) fn errors(&self, command: [P; LINEAR], feedback: [P; LINEAR], cubic: bool) -> Option<[[R; 3]; 2]> {
        let (command, at_command) = self.command.steps(command);
        let (feedback, at_feedback) = self.feedback.steps(feedback);
        if !(at_command & at_feedback) {
            return None;
        }
        Some(if cubic {
            [self.command.cubic(command), self.feedback.cubic(feedback)]
        } else {
            [self.command.linear(command), self.feedback.linear(feedback)]
        })
    }

    /// Where the cells lie, those that lie anywhere.
    #[cfg(test)]
    pub(crate) fn windows(&self) -> [Option<(P, P::Reach)>; 2 * LINEAR] {
        let [a, b, c] = &self.command.cells;
        let [d, e, f] = &self.feedback.cells;
        [a, b, c, d, e, f].map(|cell| {
            let (window, nowhere) = (cell.window, Cell::<R, P>::nowhere().window);
            (window.low.is_usable() || window.reach != nowhere.reach).then_some((window.low, window.reach))
        })
    }
}
