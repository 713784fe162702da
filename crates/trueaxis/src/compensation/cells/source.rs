//! Refills the cells that an axis has left, one at a time, and reads the tables themselves where a cell is missing.

use super::cache::{Cells, Point};
use super::cell::{Cell, Window, plus, times};
use super::tables::{Borders, Tables};
use crate::compensation::grid::{Grids, Near, NearGrids};
use crate::compensation::nine::NineTerms;
use crate::compensation::reversal::Direction;
use crate::compensation::table::{Piece, xyz};
use crate::compensation::thermal::ThermalLine;
use crate::position::Position;
use crate::real::Real;

/// Data from which a cycle fills its cells.
pub(crate) struct Source<'n, R, P: Position, const N: usize> {
    /// The tables.
    pub(crate) terms: &'n NineTerms<'n, R, P, N>,
    /// Borders of their cells.
    pub(crate) tables: &'n Tables<R, P>,
    /// Directions of travel.
    pub(crate) directions: &'n [Direction; N],
    /// Thermal growth.
    pub(crate) thermal: &'n [ThermalLine<R>; N],
    /// Grids beside the tables, and their boxes.
    pub(crate) grids: Option<(&'n Grids<'n, R>, &'n NearGrids<R, P>)>,
}

impl<R: Real, P: Position, const N: usize> Source<'_, R, P, N> {
    /// Errors at a position of the command, mm, and the axes beyond their tables or grids.
    #[inline(always)]
    pub(crate) fn at_command(&self, cells: &Cells<R, P>, positions: &[P; N]) -> ([R; 3], u8) {
        self.at(&cells.command, cells.at_edge, self.grids.map(|(_, near)| near.at_command()), positions)
    }

    /// Errors at the feedback, mm.
    #[inline(always)]
    pub(crate) fn at_feedback(&self, cells: &Cells<R, P>, positions: &[P; N]) -> [R; 3] {
        self.at(&cells.feedback, 0, self.grids.map(|(_, near)| near.at_feedback()), positions).0
    }

    /// Errors at a position, and the axes beyond their tables or grids: in the cells (`at_edge`: theirs) and the box if they
    /// hold it, otherwise in the tables and grids themselves.
    #[inline(always)]
    fn at(&self, point: &Point<R, P>, at_edge: u8, near: Option<&Near<R, P>>, positions: &[P; N]) -> ([R; 3], u8) {
        let Some(at) = positions.first_chunk() else { return ([R::ZERO; 3], 0) };
        let (error, edge) = match point.error(at, self.tables.is_cubic()) {
            Some(error) => (error, at_edge),
            None => self.terms.errors_at(at, self.directions, self.thermal),
        };
        match (self.grids, near) {
            // Only with grids.
            (Some((grids, _)), Some(near)) => {
                let (of_grids, beyond) = self.of_grids(grids, near, positions);
                (plus(error, of_grids), edge | beyond)
            }
            _ => (error, edge),
        }
    }

    /// Errors that grids add at a position: in their box if it holds that.
    // Only with grids.
    #[inline(never)]
    fn of_grids(&self, grids: &Grids<'_, R>, near: &Near<R, P>, positions: &[P; N]) -> ([R; 3], u8) {
        match positions.first_chunk().filter(|at| near.holds(at)) {
            Some(at) => (near.error(at).array(), near.edge()),
            None => {
                let sum = grids.of_slides(&self.terms.slides(&self.terms.coordinates(positions)));
                (sum.tip.array(), sum.edge)
            }
        }
    }

    /// Fills the cell of the first axis that has left its cell, at the command or else at the feedback; one cell may serve
    /// both. Returns whether there was such an axis.
    #[inline(never)]
    pub(crate) fn refill(&self, cells: &mut Cells<R, P>, command: &[P; N], feedback: &[P; N]) -> bool {
        let Cells { command: at_command, feedback: at_feedback, at_edge, .. } = cells;
        let both = at_command.cells.iter_mut().zip(&mut at_feedback.cells);
        for (slot, ((there, back), (command, feedback))) in both.zip(command.iter().zip(feedback)).enumerate() {
            if there.steps(*command).is_none() || back.steps(*feedback).is_none() {
                let bit = 1 << (slot & 7);
                self.refill_axis(slot, [there, back], [*command, *feedback]);
                *at_edge = if self.is_beyond(slot, *command) { *at_edge | bit } else { *at_edge & !bit };
                at_command.sum_up();
                at_feedback.sum_up();
                return true;
            }
        }
        false
    }

    /// Whether a position of an axis is beyond its table.
    #[inline(always)]
    fn is_beyond(&self, slot: usize, position: P) -> bool {
        let there = self.terms.tables.get(slot).is_some_and(|table| !table.is_empty());
        there && self.tables.borders.get(slot).is_some_and(|borders| !position.is_within(&borders.ends))
    }

    /// Fills the cell of an axis that the command has left, otherwise that of the feedback.
    #[inline(always)]
    fn refill_axis(&self, slot: usize, [there, back]: [&mut Cell<R, P>; 2], [command, feedback]: [P; 2]) {
        let [of_command, of_feedback] = match self.grids {
            Some((_, near)) => near.boxes().map(|near| near.ends(slot)),
            None => [None; 2],
        };
        if there.steps(command).is_some() {
            if !back.takes(there, feedback, of_feedback) {
                self.fill(slot, feedback, back, of_feedback);
            }
            return;
        }
        if !there.takes(back, command, of_command) {
            self.fill(slot, command, there, of_command);
        }
        if back.steps(feedback).is_none() {
            back.takes(there, feedback, of_feedback);
        }
    }

    /// Fills the cell of an axis around a position, clipped to the ends of the grids' box.
    #[inline(never)]
    fn fill(&self, slot: usize, position: P, cell: &mut Cell<R, P>, ends: Option<[P; 2]>) {
        let (Some(table), Some(borders), Some(direction), Some(growth)) = (
            self.terms.tables.get(slot),
            self.tables.borders.get(slot),
            self.directions.get(slot),
            self.thermal.get(slot),
        ) else {
            return;
        };
        let [first, last] = borders.ends;
        let (below, above) = (position < first, position > last);
        let coordinate = table.coordinate(position);
        let piece = table.piece(coordinate, *direction);
        let within = !(below || above || table.is_empty());
        let [mut low, mut high] = if within {
            between_points(borders, position, &piece)
        } else if below {
            borders.below
        } else {
            borders.above
        };
        if let Some([from, to]) = ends {
            (low, high) = (if from > low { from } else { low }, if to < high { to } else { high });
        }
        cell.window = Window::between([low, high]);
        let t = match cell.steps(position) {
            Some(t) => t,
            None => {
                // In the gap at a table's end, or farther out than a cell reaches: the cell is this position alone.
                cell.window = Window::between([position; 2]);
                R::ZERO
            }
        };
        let down = t * R::of(P::STEP);
        if within {
            expand(&piece, down, cell);
        } else {
            (cell.start, cell.slope, cell.curve) = (piece.at(piece.t), [R::ZERO; 3], [[R::ZERO; 3]; 2]);
        }
        let line = self.line(slot, growth);
        cell.start = plus(cell.start, line.at(coordinate - down));
        cell.slope = plus(cell.slope, times(R::of(P::STEP), line.slope));
    }

    /// Squareness and thermal growth along an axis.
    #[inline(always)]
    fn line(&self, slot: usize, growth: &ThermalLine<R>) -> Line<R> {
        let (Some(origin), Some(datum)) = (self.terms.origins.get(slot), self.terms.datum.get(slot)) else {
            return Line::default();
        };
        let [dx, dy] = self.terms.squareness.slopes(slot);
        let mut slope = [dx, dy, R::ZERO];
        let mut at_origin = times(*origin, slope);
        if let (Some(own), Some(rate)) = (at_origin.get_mut(slot), slope.get_mut(slot)) {
            *own += growth.at(*origin - *datum);
            *rate += growth.slope();
        }
        Line { at_origin, slope }
    }
}

/// The part of the error that is linear in the position along the whole axis.
#[derive(Clone, Copy, Default)]
struct Line<R> {
    /// At the start of the table.
    at_origin: [R; 3],
    /// Per mm.
    slope: [R; 3],
}

impl<R: Real> Line<R> {
    #[inline(always)]
    fn at(&self, coordinate: R) -> [R; 3] {
        plus(self.at_origin, times(coordinate, self.slope))
    }
}

/// Ends of the cell between two points of a table.
#[inline(always)]
fn between_points<R: Real, P: Position>(borders: &Borders<R, P>, position: P, piece: &Piece<'_, R, 4>) -> [P; 2] {
    let ([first, last], [is_first, is_last]) = (borders.ends, piece.ends);
    let down = piece.t * piece.unit;
    let low = if is_first { first } else { position.plus(-(down + borders.overlap)) };
    let high = if is_last { last } else { position.plus(piece.unit * piece.length - down + borders.overlap) };
    [low, high]
}

/// Polynomials of the cell between two points of a table, `down` mm below the coordinate.
#[inline(always)]
fn expand<R: Real, P: Position>(piece: &Piece<'_, R, 4>, down: R, cell: &mut Cell<R, P>) {
    // The parameter at the cell's start, and its change per step.
    let (u, unit) = (piece.t - down * piece.rate, piece.rate * R::of(P::STEP));
    if let Some([value, slope]) = piece.linear {
        cell.start = plus(xyz(value), times(u, xyz(slope)));
        cell.slope = times(unit, xyz(slope));
        cell.curve = [[R::ZERO; 3]; 2];
    } else if let Some([c0, c1, c2, c3]) = piece.cubic {
        let (c0, c1, c2, c3) = (xyz(c0), xyz(c1), xyz(c2), xyz(c3));
        let (second, third, thrice) = (unit * unit, unit * unit * unit, times(R::THREE * u, c3));
        cell.start = plus(c0, times(u, plus(c1, times(u, plus(c2, times(u, c3))))));
        cell.slope = times(unit, plus(c1, times(u, plus(plus(c2, c2), thrice))));
        cell.curve = [times(second, plus(c2, thrice)), times(third, c3)];
    }
}
