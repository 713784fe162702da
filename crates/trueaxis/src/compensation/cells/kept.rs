//! Cells kept from cycle to cycle.

use super::LINEAR;
use super::cell::{Cell, Window, plus};
use super::tables::Tables;
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
        self.base = plus(plus(x.start, y.start), z.start);
    }

    /// Distances from the starts of the cells, if all three positions lie in theirs.
    #[inline(always)]
    fn steps(&self, [x, y, z]: [P; LINEAR]) -> Option<[R; LINEAR]> {
        let [cx, cy, cz] = &self.cells;
        Some([cx.steps(x)?, cy.steps(y)?, cz.steps(z)?])
    }

    /// Sum of the polynomials.
    #[inline(always)]
    fn sum(&self, [x, y, z]: [R; LINEAR], cubic: bool) -> [R; 3] {
        let [cx, cy, cz] = &self.cells;
        plus(plus(plus(self.base, cx.rise(x, cubic)), cy.rise(y, cubic)), cz.rise(z, cubic))
    }
}

/// Cells kept from cycle to cycle; forgotten, they are found again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells<R, P: Position> {
    key: u64,
    /// Look-ups of the inverse in a cycle.
    passes: u8,
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
        Cells { key: Self::NONE, passes: 1, command: Point::nowhere(), feedback: Point::nowhere(), at_edge: 0 }
    }

    /// Makes them cells of these tables, none yet if they were not; returns whether they were.
    pub(crate) fn are_of<const N: usize>(&mut self, tables: &Tables<R, P>, thermal: &[ThermalLine<R>; N]) -> bool {
        // With more look-ups than one, or grids beside the tables, no cycle ends in the cells as they are: they have a key
        // of their own.
        if self.key == tables.key || self.key == !tables.key {
            return true;
        }
        self.passes = tables.passes(thermal);
        self.key = if self.passes == 1 && !tables.beside_grids { tables.key } else { !tables.key };
        (0..LINEAR).for_each(|slot| self.forget_axis(slot));
        false
    }

    /// They are of these tables, beside grids, and the inverse looks up once.
    #[inline(always)]
    pub(crate) fn are_beside_grids(&self, tables: &Tables<R, P>) -> bool {
        (self.key == !tables.key) & (self.passes == 1)
    }

    /// Look-ups of the inverse in a cycle.
    pub(crate) fn passes(&self) -> u8 {
        self.passes
    }

    /// Cells that have been left.
    pub(crate) fn missing<const N: usize>(&self, command: &[P; N], feedback: &[P; N]) -> u32 {
        let of = |point: &Point<R, P>, positions: &[P; N]| {
            let left = point.cells.iter().zip(positions).map(|(cell, position)| cell.steps(*position).is_none());
            left.map(u32::from).sum::<u32>()
        };
        of(&self.command, command) + of(&self.feedback, feedback)
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
                cell.window = Window::nowhere();
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
        let (command, feedback) = (self.command.steps(command)?, self.feedback.steps(feedback)?);
        Some(if cubic {
            [self.command.sum(command, true), self.feedback.sum(feedback, true)]
        } else {
            [self.command.sum(command, false), self.feedback.sum(feedback, false)]
        })
    }

    /// Where the cells lie, those that lie anywhere.
    #[cfg(test)]
    pub(crate) fn windows(&self) -> [Option<(P, P::Reach)>; 2 * LINEAR] {
        let [a, b, c] = &self.command.cells;
        let [d, e, f] = &self.feedback.cells;
        [a, b, c, d, e, f].map(|cell| {
            let (window, nowhere) = (cell.window, Window::<P>::nowhere());
            (window.low.is_usable() || window.reach != nowhere.reach).then_some((window.low, window.reach))
        })
    }
}
