//! Cells cached from cycle to cycle.

use super::LINEAR;
use super::cell::{Cell, Window, plus};
use super::tables::{Binding, Form, INVERSE_MM, InverseEnd, Tables};
use crate::compensation::grid::{Grids, Near, NearGrids, Side};
use crate::compensation::thermal::ThermalLine;
use crate::part;
use crate::position::Position;
use crate::real::Real;

/// The cells of all three axes around one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<R, P: Position> {
    pub(super) cells: [Cell<R, P>; LINEAR],
    /// Sum of the errors at the starts of the cells.
    base: [R; 3],
}

impl<R: Real, P: Position> Point<R, P> {
    fn empty() -> Self {
        Point { cells: [Cell::empty(); LINEAR], base: [R::ZERO; 3] }
    }

    /// Updates the base after a cell was filled.
    pub(super) fn sum_up(&mut self) {
        let [x, y, z] = &self.cells;
        self.base = plus(plus(x.start, y.start), z.start);
    }

    /// Distances from the starts of the cells, if all three positions lie in their cells.
    #[inline(always)]
    fn steps(&self, [x, y, z]: [P; LINEAR]) -> Option<[R; LINEAR]> {
        let [cx, cy, cz] = &self.cells;
        Some([cx.steps(x)?, cy.steps(y)?, cz.steps(z)?])
    }

    /// Errors at a position, if it lies in the cells.
    #[inline(always)]
    pub(super) fn error(&self, at: &[P; LINEAR], cubic: bool) -> Option<[R; 3]> {
        let steps = self.steps(*at)?;
        Some(if cubic { self.sum(steps, true) } else { self.sum(steps, false) })
    }

    /// Drops the cells that extend beyond the grids' box.
    fn keep_within(&mut self, near: &Near<R, P>) {
        for (slot, cell) in self.cells.iter_mut().enumerate() {
            if !near.ends(slot).is_some_and(|ends| cell.window.is_within(&ends)) {
                cell.window = Window::empty();
            }
        }
    }

    /// Sum of the polynomials.
    #[inline(always)]
    fn sum(&self, [x, y, z]: [R; LINEAR], cubic: bool) -> [R; 3] {
        let [cx, cy, cz] = &self.cells;
        plus(plus(plus(self.base, cx.rise(x, cubic)), cy.rise(y, cubic)), cz.rise(z, cubic))
    }
}

/// Cells cached from cycle to cycle; after [`Cells::forget`] they are recomputed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells<R, P: Position> {
    binding: Binding,
    /// Passes of the inverse per cycle.
    passes: u8,
    /// Where the inverse ends in a cycle in which more than the position changed.
    end: InverseEnd<R>,
    pub(super) command: Point<R, P>,
    pub(super) feedback: Point<R, P>,
    /// One bit for every axis whose cell at the command lies beyond its table.
    pub(super) at_edge: u8,
}

impl<R: Real, P: Position> Cells<R, P> {
    /// An empty cache, bound to no tables.
    pub(crate) fn empty() -> Self {
        Cells {
            binding: Binding::NONE,
            passes: 1,
            end: InverseEnd::NEVER,
            command: Point::empty(),
            feedback: Point::empty(),
            at_edge: 0,
        }
    }

    /// Whether the cache is bound to these tables, their inverse takes one pass and no periods add to them: a calm cycle may
    /// read the cells directly.
    #[inline(always)]
    pub(crate) fn are_direct(&self, tables: &Tables<R, P>) -> bool {
        self.binding == tables.direct
    }

    /// [`Cells::are_direct`] of tables to which periods add.
    // Only with periods.
    pub(crate) fn are_direct_with_periods(&self, tables: &Tables<R, P>) -> bool {
        self.passes == 1 && self.binding == tables.direct.by_several_passes()
    }

    /// Binds the cache to these tables. Empties it and returns `true` if it was bound to none or to others.
    pub(crate) fn bind_to<const N: usize>(&mut self, tables: &Tables<R, P>, thermal: &[ThermalLine<R>; N]) -> bool {
        let (direct, by_several) = (tables.direct, tables.direct.by_several_passes());
        if self.binding == direct || self.binding == by_several {
            return false;
        }
        (self.passes, self.end) = tables.passes(thermal);
        let is_direct = self.passes == 1 && !tables.have_periods();
        self.binding = if is_direct { direct } else { by_several };
        (0..LINEAR).for_each(|slot| self.forget_axis(slot));
        true
    }

    /// Passes of the inverse per cycle.
    pub(crate) fn passes(&self) -> u8 {
        self.passes
    }

    /// Where the inverse ends in a cycle in which more than the position changed.
    pub(crate) fn inverse_end(&self) -> InverseEnd<R> {
        self.end
    }

    /// Where a cycle with periods ends, of tables with cells or without.
    // Only with periods.
    pub(crate) fn end_with_periods<const N: usize>(
        &self,
        tables: &Tables<R, P>,
        thermal: &[ThermalLine<R>; N],
    ) -> InverseEnd<R> {
        if tables.has_cells() { self.end } else { tables.inverse_end(INVERSE_MM, thermal) }
    }

    /// Moves a box of the grids that a position has left, the command's before the feedback's, and drops the cells that
    /// extend beyond it. A position never leaves a box without leaving a cell.
    #[inline(never)]
    pub(crate) fn follow<const N: usize>(
        &mut self,
        grids: &Grids<'_, R>,
        near: &mut NearGrids<R, P>,
        command: &[P; N],
        feedback: &[P; N],
    ) {
        let (Some(there), Some(back)) = (command.first_chunk(), feedback.first_chunk()) else { return };
        match near.follow(grids, there, back) {
            Some(Side::Command) => self.command.keep_within(near.at_command()),
            Some(Side::Feedback) => self.feedback.keep_within(near.at_feedback()),
            None => {}
        }
    }

    /// Unbinds the cache from its tables.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        self.binding = Binding::NONE;
    }

    /// Drops the cells of an axis.
    pub(crate) fn forget_axis(&mut self, slot: usize) {
        for point in [&mut self.command, &mut self.feedback] {
            if let Some(cell) = point.cells.get_mut(slot) {
                cell.window = Window::empty();
            }
        }
    }

    /// Errors at command and feedback, in mm, and the axes whose command is beyond their tables or grids; `None` if any
    /// axis has left its cell.
    #[inline(always)]
    pub(crate) fn errors(
        &self,
        tables: &Tables<R, P>,
        near: &NearGrids<R, P>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<([[R; 3]; 2], u8)> {
        let (there, back) = (self.command.steps(*command)?, self.feedback.steps(*feedback)?);
        Some(match tables.form() {
            Form::Linear => (self.sums(there, back, false), self.at_edge),
            Form::Cubic => (self.sums(there, back, true), self.at_edge),
            Form::WithGrids => {
                part::GRIDS?;
                return self.errors_with_grids(tables, near, command, feedback);
            }
        })
    }

    /// [`Cells::errors`] of tables to which periods add: one copy for any number of axes.
    // Only with periods.
    #[inline(never)]
    pub(crate) fn errors_beside_periods(
        &self,
        tables: &Tables<R, P>,
        near: &NearGrids<R, P>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<([[R; 3]; 2], u8)> {
        self.errors(tables, near, command, feedback)
    }

    /// Sums of the polynomials at command and feedback.
    #[inline(always)]
    fn sums(&self, there: [R; LINEAR], back: [R; LINEAR], cubic: bool) -> [[R; 3]; 2] {
        [self.command.sum(there, cubic), self.feedback.sum(back, cubic)]
    }

    /// [`Cells::errors`] with grids: out of line, so that a machine without grids keeps its registers.
    // Only with grids.
    #[inline(never)]
    fn errors_with_grids(
        &self,
        tables: &Tables<R, P>,
        near: &NearGrids<R, P>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<([[R; 3]; 2], u8)> {
        let (there, back) = (self.command.steps(*command)?, self.feedback.steps(*feedback)?);
        let [drive, tip] = if tables.is_cubic() { self.sums(there, back, true) } else { self.sums(there, back, false) };
        // A cell never extends beyond the box.
        let [drive_grids, tip_grids] = near.errors(command, feedback);
        Some(([plus(drive, drive_grids.array()), plus(tip, tip_grids.array())], self.at_edge | near.edge()))
    }

    /// Windows of the cells that are filled.
    #[cfg(test)]
    pub(crate) fn windows(&self) -> [Option<(P, P::Reach)>; 2 * LINEAR] {
        let [a, b, c] = &self.command.cells;
        let [d, e, f] = &self.feedback.cells;
        [a, b, c, d, e, f].map(|cell| {
            let (window, empty) = (cell.window, Window::<P>::empty());
            (window.low.is_usable() || window.reach != empty.reach).then_some((window.low, window.reach))
        })
    }
}
