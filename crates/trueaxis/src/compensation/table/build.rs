//! Builds the table of an axis in borrowed memory.

use super::{AxisTable, Contribution};
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisSettings, Interpolation, Lines, MachineSettings, Row, Rows, pchip, wraps};
use crate::position::Position;
use crate::real::Real;

/// Refuses memory of `found` scalars if `needed` is more.
pub(in crate::compensation) fn enough(found: usize, needed: usize) -> Result<(), ConfigError> {
    if found >= needed {
        return Ok(());
    }
    let error = ConfigError::new(Field::Memory, found as f64, "memory for as many scalars as the tables take");
    Err(ConfigError { bound: Some(needed as f64), ..error })
}

/// Splits `count` scalars off the memory.
fn take<'a, R>(memory: &mut &'a mut [R], count: usize) -> Result<&'a mut [R], ConfigError> {
    enough(memory.len(), count)?;
    let (taken, rest) = core::mem::take(memory).split_at_mut_checked(count).unwrap_or_default();
    *memory = rest;
    Ok(taken)
}

impl<'a, R: Real, P: Position> AxisTable<'a, R, P, 4> {
    /// Builds the table of the nine-term form in borrowed memory. `own_sign` is the sense in which the axis' own angular
    /// error adds to its reading (+1 unless the axis turns against its convention); linear axes ignore it.
    ///
    /// # Errors
    /// Fewer than two rows, rows not ascending or not finite, or memory too small.
    pub fn build(
        settings: &AxisSettings,
        rows: &(impl Rows + ?Sized),
        own_sign: f64,
        memory: &mut &'a mut [R],
    ) -> Result<Self, ConfigError> {
        let own = own_component(settings.axis);
        let values = |row: &Row, reverse: bool| {
            let error = if reverse { row.reverse } else { row.forward };
            let [x, y, z, ..] = error;
            let mut values = [x, y, z, 0.0];
            if settings.axis.is_rotary() {
                values[3] = error.get(settings.axis.index()).copied().unwrap_or(0.0).to_degrees() * own_sign;
            }
            if reverse && let Some(value) = values.get_mut(own) {
                *value += settings.backlash;
            }
            values
        };
        Self::build_from(settings, rows, &values, &|line| line, [0.0; 4], memory)
    }
}

impl<'a, R: Real, P: Position> AxisTable<'a, R, P, 6> {
    /// Builds the table of an axis' twist in borrowed memory: `e − w × lever` in mm and `w` in rad, e and w the
    /// interpolated columns. The lever is subtracted from the polynomials, so that it is exact between the points too;
    /// `constant` (mm, rad) is added everywhere.
    ///
    /// # Errors
    /// Fewer than two rows, rows not ascending or not finite, or memory too small.
    pub fn build_twists(
        settings: &AxisSettings,
        rows: &(impl Rows + ?Sized),
        [lx, ly, lz]: [f64; 3],
        constant: [f64; 6],
        memory: &mut &'a mut [R],
    ) -> Result<Self, ConfigError> {
        let own = settings.axis.index();
        let swung = |[a, b, c]: [f64; 3]| [b * lz - c * ly, c * lx - a * lz, a * ly - b * lx];
        // Lost motion is not a reading along the measured line: the lever that is subtracted later is added here first.
        let mut lost = [0.0; 6];
        if let Some(lost) = lost.get_mut(own) {
            *lost = if own < 3 { settings.backlash } else { settings.backlash.to_radians() };
        }
        let [_, _, _, a, b, c] = lost;
        for (lost, swung) in lost.iter_mut().zip(swung([a, b, c])) {
            *lost += swung;
        }
        let values = |row: &Row, reverse: bool| {
            let twist = if reverse { row.reverse } else { row.forward };
            if reverse { core::array::from_fn(|k| twist[k] + lost[k]) } else { twist }
        };
        let levered = |[x, y, z, a, b, c]: [f64; 6]| {
            let [sx, sy, sz] = swung([a, b, c]);
            [x - sx, y - sy, z - sz, a, b, c]
        };
        Self::build_from(settings, rows, &values, &levered, constant, memory)
    }
}

impl<'a, R: Real, P: Position, const W: usize> AxisTable<'a, R, P, W> {
    /// Memory needed to build this table, in scalars.
    pub fn requirement(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> usize {
        let Need { lines, knots, guide } = Need::of::<W>(settings, rows);
        lines + knots + guide
    }

    /// Builds a table from the `values` of each row; applies `finish` to the coefficients of every polynomial and adds
    /// `constant`.
    fn build_from(
        settings: &AxisSettings,
        rows: &(impl Rows + ?Sized),
        values: &dyn Fn(&Row, bool) -> [f64; W],
        finish: &dyn Fn([f64; W]) -> [f64; W],
        constant: [f64; W],
        memory: &mut &'a mut [R],
    ) -> Result<Self, ConfigError> {
        let axis = settings.axis;
        let bad = |found, needed| ConfigError::new(Field::Table, found, needed).on(axis);
        let count = rows.len();
        let (Some(first), Some(end)) = (rows.row(0), rows.row(count.wrapping_sub(1))) else {
            return Err(bad(count as f64, "at least two points"));
        };
        if !(2..=usize::from(u16::MAX)).contains(&count) {
            return Err(bad(count as f64, "2 to 65535 points"));
        }
        let need = Need::of::<W>(settings, rows);
        let lines = take(memory, need.lines)?;
        let knots = take(memory, need.knots)?;
        let guide = take(memory, need.guide)?;

        let origin = P::of(first.position);
        let length = end.position - first.position;
        let wraps = wraps(axis, rows);
        let equidistant = spacing(rows);
        let source = Source { settings, rows, values, wraps, cell: equidistant };
        let powers = need.lines / count / (1 + usize::from(two_sided(settings, rows))) / W;
        let lines = lines.as_chunks_mut::<W>().0;
        for (block, reverse) in lines.chunks_mut(count * powers).zip([false, true]) {
            for (index, node) in block.chunks_mut(powers).enumerate() {
                let polynomial = source.polynomial(index, reverse).map_err(|found| bad(found, "ascending, finite"))?;
                let mut added = constant;
                for (line, coefficients) in node.iter_mut().zip(polynomial) {
                    let finished = finish(coefficients);
                    *line = core::array::from_fn(|k| R::of(finished[k] + added[k]));
                    added = [0.0; W];
                }
            }
        }
        for (index, knot) in knots.iter_mut().enumerate() {
            *knot = R::of(rows.row(index).map_or(length, |row| row.position - first.position));
        }

        let (scale, last) = match equidistant {
            Some(cell) => (1.0 / cell, (count - 1) as f64),
            None => ((guide.len().saturating_sub(1)) as f64 / length, 0.0),
        };
        let scale = R::of(scale);
        let depth = fill_guide(knots, guide, scale);
        let lines: &'a [Contribution<R, W>] = lines;
        let (linear, cubic): (&[_], &[_]) = match settings.interpolation {
            Interpolation::Linear => (lines.as_chunks().0, &[]),
            Interpolation::Cubic => (&[], lines.as_chunks().0),
        };
        Ok(AxisTable {
            origin,
            end: P::of(end.position),
            span: R::of(length),
            scale,
            last: R::of(last),
            wraps,
            reverse_offset: if lines.len() > count * powers { count } else { 0 },
            linear,
            cubic,
            knots,
            guide,
            depth,
        })
    }
}

/// Scalars that a table needs.
struct Need {
    /// Polynomial coefficients, one line of numbers per power and point.
    lines: usize,
    /// Positions of a free grid.
    knots: usize,
    /// Search guide of a free grid.
    guide: usize,
}

impl Need {
    fn of<const W: usize>(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> Need {
        let blocks = 1 + usize::from(two_sided(settings, rows));
        let powers = match settings.interpolation {
            Interpolation::Linear => 2,
            Interpolation::Cubic => 4,
        };
        let free = if spacing(rows).is_some() { 0 } else { rows.len() };
        Need { lines: rows.len() * blocks * powers * W, knots: free, guide: 2 * free }
    }
}

/// Scalars that the tables of all axes of a machine need, with `W` numbers per line.
pub(in crate::compensation) fn requirement_of_all<'r, const W: usize, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
) -> usize {
    let need = |settings: &AxisSettings| {
        let lines = Lines::of(machine, &rows, settings);
        lines.map_or(0, |(lines, settings)| AxisTable::<f64, f64, W>::requirement(&settings, &lines))
    };
    machine.axes.iter().map(need).sum()
}

/// Constant spacing of the grid, if its points are equidistant within 1e-9 of a cell.
fn spacing(rows: &(impl Rows + ?Sized)) -> Option<f64> {
    let count = rows.len();
    let (first, end) = (rows.row(0)?.position, rows.row(count.wrapping_sub(1))?.position);
    let cell = (end - first) / (count.saturating_sub(1)) as f64;
    (0..count)
        .all(|i| rows.row(i).is_some_and(|row| (row.position - first - cell * i as f64).abs() <= 1e-9 * cell))
        .then_some(cell)
}

/// Whether the direction of travel matters: bidirectional values or backlash.
fn two_sided(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> bool {
    settings.backlash != 0.0 || (0..rows.len()).any(|i| rows.row(i).is_some_and(|row| row.forward != row.reverse))
}

/// Stores, for each bucket, the last knot of an earlier bucket. The bucket of a knot results from the same rounded
/// multiplication as in the search, which is monotone: a knot of an earlier bucket is never above the coordinate, one
/// of a later bucket never below. Returns the number of halvings that cover the knots of the fullest bucket.
fn fill_guide<R: Real>(knots: &[R], guide: &mut [R], scale: R) -> u32 {
    let mut most = 0;
    let mut next = 0usize;
    for (bucket, entry) in guide.iter_mut().enumerate() {
        *entry = R::of_index(next.saturating_sub(1) as u16);
        let before = next;
        while knots.get(next).is_some_and(|knot| (*knot * scale).to_i32() as usize <= bucket) {
            next += 1;
        }
        most = most.max(next - before);
    }
    usize::BITS - most.leading_zeros()
}

/// Forms the polynomial of each interval, in double precision.
struct Source<'s, T: ?Sized, const W: usize> {
    settings: &'s AxisSettings,
    rows: &'s T,
    values: &'s dyn Fn(&Row, bool) -> [f64; W],
    wraps: bool,
    /// Spacing of an equidistant grid, whose parameter runs 0..1 over a cell; a free grid's runs in mm.
    cell: Option<f64>,
}

impl<T: Rows + ?Sized, const W: usize> Source<'_, T, W> {
    fn point(&self, index: usize, reverse: bool) -> Option<(f64, [f64; W])> {
        let row = self.rows.row(index)?;
        Some((row.position, (self.values)(&row, reverse)))
    }

    /// Slope at a point for monotone cubic interpolation.
    fn slope(&self, index: usize, reverse: bool) -> Option<[f64; W]> {
        let count = self.rows.len();
        let secant = |i: usize| {
            let (q0, v0) = self.point(i, reverse)?;
            let (q1, v1) = self.point(i + 1, reverse)?;
            let h = q1 - q0;
            Some((h, core::array::from_fn::<f64, W, _>(|k| (v1[k] - v0[k]) / h)))
        };
        let join = |(h0, d0): (f64, [f64; W]), (h1, d1): (f64, [f64; W]), f: fn(f64, f64, f64, f64) -> f64| {
            Some(core::array::from_fn(|k| f(h0, d0[k], h1, d1[k])))
        };
        let last = count - 1;
        if self.wraps && (index == 0 || index == last) {
            return join(secant(last - 1)?, secant(0)?, pchip::slope);
        }
        match (index, count) {
            (_, 2) => secant(0).map(|(_, d)| d),
            (0, _) => join(secant(0)?, secant(1)?, pchip::end_slope),
            (i, _) if i == last => join(secant(last - 1)?, secant(last - 2)?, pchip::end_slope),
            (i, _) => join(secant(i - 1)?, secant(i)?, pchip::slope),
        }
    }

    /// Coefficients, in its parameter, of the interval that starts at point `index`; constant beyond the last point.
    fn polynomial(&self, index: usize, reverse: bool) -> Result<[[f64; W]; 4], f64> {
        let Some((q0, v0)) = self.point(index, reverse) else { return Err(index as f64) };
        let zero = [0.0; W];
        let Some((q1, v1)) = self.point(index + 1, reverse) else { return Ok([v0, zero, zero, zero]) };
        let h = q1 - q0;
        if !(h > 0.0 && h.is_finite() && v0.iter().chain(&v1).all(|v| v.is_finite())) {
            return Err(q1);
        }
        let rise: [f64; W] = core::array::from_fn(|k| v1[k] - v0[k]);
        // In a parameter 0..1 over the interval; converted to mm for free grids.
        let unit = match self.settings.interpolation {
            Interpolation::Linear => [v0, rise, zero, zero],
            Interpolation::Cubic => {
                let (Some(m0), Some(m1)) = (self.slope(index, reverse), self.slope(index + 1, reverse)) else {
                    return Err(index as f64);
                };
                let c1 = m0.map(|m| m * h);
                let end = m1.map(|m| m * h);
                [
                    v0,
                    c1,
                    core::array::from_fn(|k| 3.0 * rise[k] - 2.0 * c1[k] - end[k]),
                    core::array::from_fn(|k| c1[k] + end[k] - 2.0 * rise[k]),
                ]
            }
        };
        Ok(match self.cell {
            Some(_) => unit,
            None => {
                let [value, c1, c2, c3] = unit;
                [value, c1.map(|c| c / h), c2.map(|c| c / (h * h)), c3.map(|c| c / (h * h * h))]
            }
        })
    }
}

/// Which component of a contribution is the axis' own positioning error.
pub(crate) fn own_component(axis: Axis) -> usize {
    if axis.is_rotary() { 3 } else { axis.index() }
}
