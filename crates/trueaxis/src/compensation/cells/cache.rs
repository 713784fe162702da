//! Cells cached from cycle to cycle.

use super::LINEAR;
use super::cell::{Cell, Window, plus};
use super::tables::{Binding, Form, Tables};
use crate::compensation::grid::{Grids, Near, NearGrids};
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

    /// Number of cells that the position has left. `None` if it has also left the grids' box, which implies at least one
    /// left cell.
    #[inline(always)]
    fn missing<const N: usize>(&self, near: Option<&Near<R, P>>, positions: &[P; N]) -> Option<u32> {
        let mut missing = 0;
        for (slot, (cell, position)) in self.cells.iter().zip(positions).enumerate() {
            if cell.steps(*position).is_none() {
                if let Some(near) = near
                    && !position.is_within(&near.ends(slot)?)
                {
                    return None;
                }
                missing += 1;
            }
        }
        Some(missing)
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
    pub(super) command: Point<R, P>,
    pub(super) feedback: Point<R, P>,
    /// One bit for every axis whose cell at the command lies beyond its table.
    pub(super) at_edge: u8,
}

impl<R: Real, P: Position> Cells<R, P> {
    /// An empty cache, bound to no tables.
    pub(crate) fn empty() -> Self {
        Cells { binding: Binding::NONE, passes: 1, command: Point::empty(), feedback: Point::empty(), at_edge: 0 }
    }

    /// Whether the cache is bound to these tables and their inverse takes one pass: a calm cycle may read the cells
    /// directly.
    #[inline(always)]
    pub(crate) fn are_direct(&self, tables: &Tables<R, P>) -> bool {
        self.binding == tables.direct
    }

    /// Binds the cache to these tables. Empties it and returns `true` if it was bound to none or to others.
    pub(crate) fn bind_to<const N: usize>(&mut self, tables: &Tables<R, P>, thermal: &[ThermalLine<R>; N]) -> bool {
        let (direct, by_several) = (tables.direct, tables.direct.by_several_passes());
        if self.binding == direct || self.binding == by_several {
            return false;
        }
        self.passes = tables.passes(thermal);
        self.binding = if self.passes == 1 { direct } else { by_several };
        (0..LINEAR).for_each(|slot| self.forget_axis(slot));
        true
    }

    /// Passes of the inverse per cycle.
    pub(crate) fn passes(&self) -> u8 {
        self.passes
    }

    /// Number of cells that the positions have left. If they have also left a grid box, moves the box to them first.
    #[inline(always)]
    pub(crate) fn missing<const N: usize>(
        &mut self,
        grids: Option<(&Grids<'_, R>, &mut NearGrids<R, P>)>,
        command: &[P; N],
        feedback: &[P; N],
    ) -> u32 {
        let near = grids.as_ref().map(|(_, near)| &**near);
        let at_command = self.command.missing(near.map(NearGrids::at_command), command);
        let at_feedback = self.feedback.missing(near.map(NearGrids::at_feedback), feedback);
        match (at_command, at_feedback, grids) {
            (Some(at_command), Some(at_feedback), _) => at_command + at_feedback,
            (_, _, Some((grids, near))) => self.follow(grids, near, command, feedback),
            _ => 0,
        }
    }

    /// [`Cells::missing`] for positions that have left a grid box: moves the boxes and drops every cell that extends
    /// beyond them.
    #[cold]
    #[inline(never)]
    fn follow<const N: usize>(
        &mut self,
        grids: &Grids<'_, R>,
        near: &mut NearGrids<R, P>,
        command: &[P; N],
        feedback: &[P; N],
    ) -> u32 {
        if let (Some(there), Some(back)) = (command.first_chunk(), feedback.first_chunk()) {
            near.about(grids, there, back);
            self.command.keep_within(near.at_command());
            self.feedback.keep_within(near.at_feedback());
        }
        self.command.missing(None, command).unwrap_or(0) + self.feedback.missing(None, feedback).unwrap_or(0)
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
        let sums = |cubic| [self.command.sum(there, cubic), self.feedback.sum(back, cubic)];
        Some(match tables.form() {
            Form::Linear => (sums(false), self.at_edge),
            Form::Cubic => (sums(true), self.at_edge),
            Form::WithGrids => {
                part::GRIDS?;
                return self.errors_with_grids_out_of_line(tables, near, command, feedback);
            }
        })
    }

    /// Out-of-line [`Cells::errors_with_grids`], so that a machine without grids keeps its registers.
    #[inline(never)]
    fn errors_with_grids_out_of_line(
        &self,
        tables: &Tables<R, P>,
        near: &NearGrids<R, P>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<([[R; 3]; 2], u8)> {
        self.errors_with_grids(tables, near, command, feedback)
    }

    /// [`Cells::errors`] with grids.
    #[inline(always)]
    pub(crate) fn errors_with_grids(
        &self,
        tables: &Tables<R, P>,
        near: &NearGrids<R, P>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<([[R; 3]; 2], u8)> {
        let (there, back) = (self.command.steps(*command)?, self.feedback.steps(*feedback)?);
        let sums = |cubic| [self.command.sum(there, cubic), self.feedback.sum(back, cubic)];
        let [drive, tip] = if tables.is_cubic() { sums(true) } else { sums(false) };
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
