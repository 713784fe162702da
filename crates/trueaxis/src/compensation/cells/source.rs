//! Refills the cells that an axis has left.

use super::cache::{Cells, Point};
use super::cell::{Cell, Window, plus, times};
use super::tables::{Borders, Tables};
use crate::compensation::grid::{Near, NearGrids};
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
    /// Boxes of the grids beside the tables.
    pub(crate) near: Option<&'n NearGrids<R, P>>,
    /// Number of cells that may still be filled.
    pub(crate) left: u32,
}

impl<R: Real, P: Position, const N: usize> Source<'_, R, P, N> {
    /// Errors at a position of the command, filling cells; `None` if a left cell may no longer be filled.
    #[inline(never)]
    pub(crate) fn at_command(&mut self, cells: &mut Cells<R, P>, positions: &[P; N]) -> Option<[R; 3]> {
        let near = self.near.map(NearGrids::at_command);
        self.fill_point(&mut cells.command, near, &mut cells.at_edge, positions);
        let at = positions.first_chunk()?;
        let error = cells.command.error(at, self.tables.is_cubic())?;
        Some(near.map_or(error, |near| plus(error, near.error(at).array())))
    }

    /// Fills as many left cells as are still permitted.
    #[inline(never)]
    pub(crate) fn fill_left(&mut self, cells: &mut Cells<R, P>, command: &[P; N], feedback: &[P; N]) {
        let [at_command, at_feedback] = [self.near.map(NearGrids::at_command), self.near.map(NearGrids::at_feedback)];
        self.fill_point(&mut cells.command, at_command, &mut cells.at_edge, command);
        self.fill_point(&mut cells.feedback, at_feedback, &mut 0, feedback);
    }

    /// `at_edge`: one bit for every cell beyond its table.
    #[inline(always)]
    fn fill_point(&mut self, point: &mut Point<R, P>, near: Option<&Near<R, P>>, at_edge: &mut u8, positions: &[P; N]) {
        let (before, mut bit) = (self.left, 1);
        for (slot, (cell, position)) in point.cells.iter_mut().zip(positions).enumerate() {
            if cell.steps(*position).is_none() && self.left > 0 {
                self.left -= 1;
                let beyond = self.fill(slot, *position, cell, near);
                *at_edge = if beyond { *at_edge | bit } else { *at_edge & !bit };
            }
            bit <<= 1;
        }
        if self.left < before {
            point.sum_up();
        }
    }

    /// Fills the cell of an axis around a position, clipped to the grids' box; returns whether it lies beyond the table.
    #[inline(never)]
    fn fill(&self, slot: usize, position: P, cell: &mut Cell<R, P>, near: Option<&Near<R, P>>) -> bool {
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
        let [mut low, mut high] = if within {
            between_points(borders, position, &piece)
        } else if below {
            borders.below
        } else {
            borders.above
        };
        if let Some([from, to]) = near.and_then(|near| near.ends(slot)) {
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
        (below || above) && !table.is_empty()
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
