//! Errors of cells that have been left: filled anew, or looked up without.

use super::LINEAR;
use super::cell::{Cell, Window};
use super::kept::{Cells, Point};
use super::tables::{Borders, Tables};
use crate::compensation::nine::NineTerms;
use crate::compensation::reversal::Direction;
use crate::compensation::table::AxisTable;
use crate::compensation::thermal::ThermalLine;
use crate::position::Position;
use crate::real::Real;

/// Errors of one cycle, in cells and beside them.
pub(crate) struct Source<'n, R, P: Position, const N: usize> {
    terms: &'n NineTerms<'n, R, P, N>,
    tables: &'n Tables<R, P>,
    directions: &'n [Direction; N],
    thermal: &'n [ThermalLine<R>; N],
    /// Cells that may still be filled.
    left: u32,
}

impl<'n, R: Real, P: Position, const N: usize> Source<'n, R, P, N> {
    /// Fills at most so many cells.
    pub(crate) fn new(
        terms: &'n NineTerms<'n, R, P, N>,
        tables: &'n Tables<R, P>,
        directions: &'n [Direction; N],
        thermal: &'n [ThermalLine<R>; N],
        refills: u32,
    ) -> Self {
        Source { terms, tables, directions, thermal, left: refills }
    }

    /// Errors at the place of the command, and a bit for every axis that is beyond its table there.
    #[inline(always)]
    pub(crate) fn at_command(&mut self, cells: &mut Cells<R, P>, positions: &[P; N]) -> ([R; 3], u8) {
        let mut at_edge = cells.at_edge;
        let errors = self.errors(&mut cells.command, &mut cells.at_edge, &mut at_edge, positions);
        (errors, at_edge)
    }

    /// Errors at the feedback.
    #[inline(always)]
    pub(crate) fn at_feedback(&mut self, cells: &mut Cells<R, P>, positions: &[P; N]) -> [R; 3] {
        self.errors(&mut cells.feedback, &mut 0, &mut 0, positions)
    }

    /// `kept`: a bit for every cell beyond its table; `at_edge` begins as it is and becomes the same of all positions.
    #[inline(never)]
    fn errors(&mut self, point: &mut Point<R, P>, kept: &mut u8, at_edge: &mut u8, positions: &[P; N]) -> [R; 3] {
        let cubic = self.tables.is_cubic();
        let mut sum = [R::ZERO; 3];
        let mut bit = 1;
        for slot in 0..LINEAR {
            let (Some(cell), Some(position)) = (point.cells.get_mut(slot), positions.get(slot)) else { continue };
            let (t, inside) = cell.steps(*position);
            let part = if inside {
                cell.error(t, cubic)
            } else if self.left > 0 {
                self.left -= 1;
                let beyond = self.fill(slot, *position, cell);
                *kept = if beyond { *kept | bit } else { *kept & !bit };
                *at_edge = if beyond { *at_edge | bit } else { *at_edge & !bit };
                let (t, _) = cell.steps(*position);
                cell.error(t, cubic)
            } else {
                let (part, beyond) = self.look_up(slot, *position);
                *at_edge = if beyond { *at_edge | bit } else { *at_edge & !bit };
                part
            };
            sum = core::array::from_fn(|k| sum[k] + part[k]);
            bit <<= 1;
        }
        point.sum_up();
        sum
    }

    fn growth(&self, slot: usize) -> ThermalLine<R> {
        self.thermal.get(slot).copied().unwrap_or_default()
    }

    /// Error along an axis, and whether it is beyond its table.
    fn look_up(&self, slot: usize, position: P) -> ([R; 3], bool) {
        let (Some(table), Some(direction)) = (self.terms.tables.get(slot), self.directions.get(slot)) else {
            return ([R::ZERO; 3], false);
        };
        let coordinate = table.coordinate(position);
        let ([x, y, z, _], beyond) = if self.tables.is_cubic() {
            table.at_cubic(coordinate, *direction)
        } else {
            table.at_linear(coordinate, *direction)
        };
        let mut error = [x, y, z];
        self.add_linear(slot, coordinate, &mut error, &mut [R::ZERO; 3]);
        (error, beyond)
    }

    /// Fills the cell of an axis about a position; returns whether it lies beyond the table.
    fn fill(&self, slot: usize, position: P, cell: &mut Cell<R, P>) -> bool {
        let (Some(table), Some(borders), Some(direction)) =
            (self.terms.tables.get(slot), self.tables.borders.get(slot), self.directions.get(slot))
        else {
            return false;
        };
        let coordinate = table.coordinate(position);
        let [first, last] = borders.ends;
        let beyond = position < first || position > last;
        let down = if beyond || table.is_empty() {
            let [below, above] = borders.beyond;
            cell.window = if position < first { below } else { above };
            let ([x, y, z, _], _) = table.at(coordinate, *direction);
            (cell.start, cell.slope, cell.curve) = ([x, y, z], [R::ZERO; 3], [[R::ZERO; 3]; 2]);
            anchor(position, cell)
        } else {
            within(table, borders, position, coordinate, *direction, cell)
        };
        self.add_linear(slot, coordinate - down, &mut cell.start, &mut cell.slope);
        beyond && !table.is_empty()
    }

    /// Adds squareness and thermal growth along one axis: to the error at a coordinate, and to its slope per step.
    #[inline(always)]
    fn add_linear(&self, slot: usize, coordinate: R, [x, y, z]: &mut [R; 3], [dx, dy, dz]: &mut [R; 3]) {
        let (Some(origin), Some(datum)) = (self.terms.origins.get(slot), self.terms.datum.get(slot)) else { return };
        let (q, step, growth) = (coordinate + *origin, R::of(P::STEP), self.growth(slot));
        let [c0y, b0z, a0z] = self.terms.squareness;
        let (own, rate) = match slot {
            0 => (x, dx),
            1 => {
                *x += -c0y * q;
                *dx += -c0y * step;
                (y, dy)
            }
            _ => {
                *x += b0z * q;
                *dx += b0z * step;
                *y += -a0z * q;
                *dy += -a0z * step;
                (z, dz)
            }
        };
        *own += growth.at(q - *datum);
        *rate += growth.slope() * step;
    }
}

/// Lays the cell about a position that it does not reach; distance of the position from its start, mm.
#[inline(always)]
fn anchor<R: Real, P: Position>(position: P, cell: &mut Cell<R, P>) -> R {
    let (t, inside) = cell.steps(position);
    if inside {
        return t * R::of(P::STEP);
    }
    cell.window = Window::between(position, position);
    R::ZERO
}

/// The cell between two points of a table; distance of the position from its start, mm.
#[inline(always)]
fn within<R: Real, P: Position>(
    table: &AxisTable<'_, R, P>,
    borders: &Borders<R, P>,
    position: P,
    coordinate: R,
    direction: Direction,
    cell: &mut Cell<R, P>,
) -> R {
    let interval = table.interval(coordinate, direction);
    let [first, last] = borders.ends;
    let [is_first, is_last] = interval.ends;
    let low = if is_first { first } else { position.plus(-(interval.down + borders.overlap)) };
    let high = if is_last { last } else { position.plus(interval.width - interval.down + borders.overlap) };
    cell.window = Window::between(low, high);
    let down = anchor(position, cell);
    // The parameter at the cell's start, and its change per step.
    let (u, unit) = ((interval.down - down) * interval.rate, interval.rate * R::of(P::STEP));
    let zero = [R::ZERO; 3];
    if let Some([[vx, vy, vz, _], [sx, sy, sz, _]]) = interval.linear {
        cell.start = [*vx + u * *sx, *vy + u * *sy, *vz + u * *sz];
        cell.slope = [unit * *sx, unit * *sy, unit * *sz];
        cell.curve = [zero; 2];
    } else if let Some([c0, c1, c2, c3]) = interval.cubic {
        let (second, third) = (unit * unit, unit * unit * unit);
        let thrice = R::THREE * u;
        for k in 0..3 {
            cell.start[k] = c0[k] + u * (c1[k] + u * (c2[k] + u * c3[k]));
            cell.slope[k] = unit * (c1[k] + u * (R::TWO * c2[k] + thrice * c3[k]));
            cell.curve[0][k] = second * (c2[k] + thrice * c3[k]);
            cell.curve[1][k] = third * c3[k];
        }
    }
    down
}
