//! Cells that have been left are filled anew.

use super::cell::{Cell, Window, plus, times};
use super::kept::{Cells, Point};
use super::tables::{Borders, Tables};
use crate::compensation::nine::NineTerms;
use crate::compensation::reversal::Direction;
use crate::compensation::table::{Piece, xyz};
use crate::compensation::thermal::ThermalLine;
use crate::position::Position;
use crate::real::Real;

/// Where cells are filled from in one cycle.
pub(crate) struct Source<'n, R, P: Position, const N: usize> {
    /// The tables.
    pub(crate) terms: &'n NineTerms<'n, R, P, N>,
    /// Where their cells end.
    pub(crate) tables: &'n Tables<R, P>,
    /// Directions of travel.
    pub(crate) directions: &'n [Direction; N],
    /// Thermal growth.
    pub(crate) thermal: &'n [ThermalLine<R>; N],
    /// Cells that may still be filled.
    pub(crate) left: u32,
}

impl<R: Real, P: Position, const N: usize> Source<'_, R, P, N> {
    /// Errors at the place of the command; none where a cell has been left that may not be filled.
    #[inline(always)]
    pub(crate) fn at_command(&mut self, cells: &mut Cells<R, P>, positions: &[P; N]) -> Option<[R; 3]> {
        self.errors(&mut cells.command, &mut cells.at_edge, positions)
    }

    /// Errors at the feedback, likewise.
    #[inline(always)]
    pub(crate) fn at_feedback(&mut self, cells: &mut Cells<R, P>, positions: &[P; N]) -> Option<[R; 3]> {
        self.errors(&mut cells.feedback, &mut 0, positions)
    }

    /// Fills the first cell that has been left.
    #[inline(never)]
    pub(crate) fn fill_one(&self, cells: &mut Cells<R, P>, command: &[P; N], feedback: &[P; N]) {
        let at_command = cells.command.cells.iter_mut().zip(command).enumerate();
        for (slot, (cell, position)) in at_command {
            if cell.steps(*position).is_none() {
                let beyond = u8::from(self.fill(slot, *position, cell));
                cells.at_edge = (cells.at_edge & !(1 << (slot & 7))) | beyond << (slot & 7);
                return cells.command.sum_up();
            }
        }
        for (slot, (cell, position)) in cells.feedback.cells.iter_mut().zip(feedback).enumerate() {
            if cell.steps(*position).is_none() {
                self.fill(slot, *position, cell);
                return cells.feedback.sum_up();
            }
        }
    }

    /// `at_edge`: a bit for every cell beyond its table.
    #[inline(never)]
    fn errors(&mut self, point: &mut Point<R, P>, at_edge: &mut u8, positions: &[P; N]) -> Option<[R; 3]> {
        let (cubic, before) = (self.tables.is_cubic(), self.left);
        let (mut sum, mut bit, mut found) = ([R::ZERO; 3], 1, true);
        for (slot, (cell, position)) in point.cells.iter_mut().zip(positions).enumerate() {
            if cell.steps(*position).is_none() && self.left > 0 {
                self.left -= 1;
                let beyond = self.fill(slot, *position, cell);
                *at_edge = if beyond { *at_edge | bit } else { *at_edge & !bit };
            }
            match cell.steps(*position) {
                Some(t) => sum = plus(sum, cell.error(t, cubic)),
                None => found = false,
            }
            bit <<= 1;
        }
        if self.left < before {
            point.sum_up();
        }
        found.then_some(sum)
    }

    /// Fills the cell of an axis about a position; returns whether it lies beyond the table.
    #[inline(never)]
    fn fill(&self, slot: usize, position: P, cell: &mut Cell<R, P>) -> bool {
        let (Some(table), Some(borders), Some(direction), Some(growth)) = (
            self.terms.tables.get(slot),
            self.tables.borders.get(slot),
            self.directions.get(slot),
            self.thermal.get(slot),
        ) else {
            return false;
        };
        let coordinate = table.coordinate(position);
        let piece = table.piece(coordinate, *direction);
        let [first, last] = borders.ends;
        let (below, above) = (position < first, position > last);
        let within = !(below || above || table.is_empty());
        cell.window = if within {
            between_points(borders, position, &piece)
        } else if below {
            borders.below
        } else {
            borders.above
        };
        let t = match cell.steps(position) {
            Some(t) => t,
            None => {
                // The gap beside a table's end, or farther from it than a cell reaches: this position alone.
                cell.window = Window::between(position, position);
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
        (below || above) && !table.is_empty()
    }

    /// Squareness and thermal growth along an axis.
    #[inline(always)]
    fn line(&self, slot: usize, growth: &ThermalLine<R>) -> Line<R> {
        let (Some(origin), Some(datum)) = (self.terms.origins.get(slot), self.terms.datum.get(slot)) else {
            return Line::default();
        };
        let [c0y, b0z, a0z] = self.terms.squareness;
        let mut slope = match slot {
            0 => [R::ZERO; 3],
            1 => [-c0y, R::ZERO, R::ZERO],
            _ => [b0z, -a0z, R::ZERO],
        };
        let mut at_origin = times(*origin, slope);
        if let (Some(own), Some(rate)) = (at_origin.get_mut(slot), slope.get_mut(slot)) {
            *own += growth.at(*origin - *datum);
            *rate += growth.slope();
        }
        Line { at_origin, slope }
    }
}

/// The part of the error that is linear in the position, all along an axis.
#[derive(Clone, Copy, Default)]
struct Line<R> {
    /// Where the table begins.
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

/// Window of the cell between two points of a table.
#[inline(always)]
fn between_points<R: Real, P: Position>(borders: &Borders<R, P>, position: P, piece: &Piece<'_, R, 4>) -> Window<P> {
    let ([first, last], [is_first, is_last]) = (borders.ends, piece.ends);
    let down = piece.t * piece.unit;
    let low = if is_first { first } else { position.plus(-(down + borders.overlap)) };
    let high = if is_last { last } else { position.plus(piece.unit * piece.length - down + borders.overlap) };
    Window::between(low, high)
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
