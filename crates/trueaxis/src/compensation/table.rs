//! Error table of one axis, in the form that the step reads.

use super::reversal::Direction;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisSettings, Interpolation, Lines, MachineSettings, Row, Rows, pchip, wraps};
use crate::position::Position;
use crate::real::Real;

/// Contribution of an axis at one position.
///
/// Four numbers: the translations along X, Y, Z in mm and the axis' own rotation in degrees (zero for a linear axis,
/// whose positioning error is one of the translations). Six: the translations in mm and the rotations about X, Y, Z in
/// rad.
pub type Contribution<R, const W: usize = 4> = [R; W];

/// Refuses memory of `found` scalars if `needed` is more.
pub(super) fn enough(found: usize, needed: usize) -> Result<(), ConfigError> {
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

/// Farthest extension of an interval beyond its ends, mm.
const OVERLAP_MM: f64 = 0.02;

/// Polynomial between two points of a table.
pub(super) struct Piece<'a, R, const W: usize> {
    /// Parameter at the requested coordinate, zero at the start.
    pub(super) t: R,
    /// Parameter at the end.
    pub(super) length: R,
    /// Change of the parameter per mm.
    pub(super) rate: R,
    /// mm per change of the parameter.
    pub(super) unit: R,
    /// Coefficients, if the table is linear.
    pub(super) linear: Option<&'a [Contribution<R, W>; 2]>,
    /// Coefficients, if the table is cubic.
    pub(super) cubic: Option<&'a [Contribution<R, W>; 4]>,
    /// Whether it is the table's first, and its last.
    pub(super) ends: [bool; 2],
}

impl<R: Real> Piece<'_, R, 4> {
    /// Translations at a parameter.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn at(&self, t: R) -> [R; 3] {
        match (self.linear, self.cubic) {
            (Some([value, slope]), _) => xyz(&along(value, t, slope)),
            (_, Some([value, c1, c2, c3])) => xyz(&along(value, t, &along(c1, t, &along(c2, t, c3)))),
            _ => [R::ZERO; 3],
        }
    }
}

/// The translations of a contribution.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn xyz<R: Real>([x, y, z, _]: &Contribution<R, 4>) -> [R; 3] {
    [*x, *y, *z]
}

/// The errors of one axis as a function of its position, in the form that the step reads.
///
/// Finding the interval costs one multiplication on an equidistant grid; on a free grid it takes a guide table and a
/// search of fixed depth without a data-dependent branch. Beyond its ends a table has its clamped edge value. `W` is the
/// count of numbers per line: [`Contribution`].
#[derive(Clone, Copy, Debug)]
pub struct AxisTable<'a, R, P, const W: usize = 4> {
    origin: P,
    end: P,
    span: R,
    scale: R,
    last: R,
    wraps: bool,
    reverse_offset: usize,
    /// Value and slope of each interval; empty for a cubic table.
    linear: &'a [[Contribution<R, W>; 2]],
    /// Value and three coefficients of each interval; empty for a linear table.
    cubic: &'a [[Contribution<R, W>; 4]],
    knots: &'a [R],
    /// Indices, as the bits of scalars ([`Real::of_index`]).
    guide: &'a [R],
    depth: u32,
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
    /// A table that is zero everywhere.
    pub fn zero() -> Self {
        AxisTable {
            origin: P::of(0.0),
            end: P::of(0.0),
            span: R::MAX,
            scale: R::ZERO,
            last: R::ZERO,
            wraps: false,
            reverse_offset: 0,
            linear: &[],
            cubic: &[],
            knots: &[],
            guide: &[],
            depth: 0,
        }
    }

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

    /// Converts a position to a table coordinate: from the table's first point, reduced by whole turns if the table
    /// wraps.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn coordinate(&self, position: P) -> R {
        if self.wraps { position.turn_since(self.origin) } else { position.since(self.origin) }
    }

    /// The table's first point.
    pub fn origin(&self) -> P {
        self.origin
    }

    /// The table's first and last point.
    pub(super) fn ends(&self) -> [P; 2] {
        [self.origin, self.end]
    }

    /// Whether the table is zero everywhere.
    pub(super) fn is_empty(&self) -> bool {
        self.linear.is_empty() && self.cubic.is_empty()
    }

    /// Number of intervals between the table's points.
    fn intervals(&self) -> usize {
        let points =
            if self.reverse_offset > 0 { self.reverse_offset } else { self.linear.len().max(self.cubic.len()) };
        points.saturating_sub(1)
    }

    /// The interval between two points around a coordinate; for a coordinate beyond the table, the end of the first or
    /// last one.
    #[inline]
    pub(super) fn piece(&self, coordinate: R, direction: Direction) -> Piece<'a, R, W> {
        let last = self.intervals().saturating_sub(1);
        let (index, t, length, rate, unit);
        if self.knots.is_empty() {
            let place = (coordinate * self.scale).limit(R::ZERO, self.last);
            index = (place.to_i32() as usize).min(last);
            (t, length) = (place - R::of_i32(index as i32), R::ONE);
            (rate, unit) = (self.scale, R::ONE / self.scale);
        } else {
            let clamped = coordinate.limit(R::ZERO, self.span);
            index = self.search(clamped).0.min(last);
            let knot = |index: usize| self.knots.get(index).copied().unwrap_or(self.span);
            (t, length) = (clamped - knot(index), knot(index.wrapping_add(1)) - knot(index));
            (rate, unit) = (R::ONE, R::ONE);
        }
        let line = index.wrapping_add(self.reverse_offset & direction.mask());
        let (linear, cubic) = (self.linear.get(line), self.cubic.get(line));
        Piece { t, length, rate, unit, linear, cubic, ends: [index == 0, index == last] }
    }

    /// How far an interval may extend beyond its ends, mm, with at most `tolerance` mm of error: at most [`OVERLAP_MM`]
    /// and half the shortest interval. With Δ the change of a coefficient from one interval to the next,
    ///
    /// ```text
    /// |Δc1| o + |Δc2| o² + |Δc3| o³ <= tolerance
    /// ```
    pub(super) fn overlap(&self, tolerance: f64) -> f64 {
        let mut most = OVERLAP_MM;
        for direction in [Direction::POSITIVE, Direction::NEGATIVE] {
            let mut before = None;
            for index in 0..self.intervals() {
                let (width, powers) = self.powers(index, direction);
                most = most.min(0.5 * width);
                if let Some(before) = before.replace(at_end(width, powers)) {
                    let [d1, d2, d3] = changes(before, powers);
                    while most * (d1 + most * (d2 + most * d3)) > tolerance {
                        most *= 0.9;
                    }
                }
            }
        }
        most
    }

    /// Length of an interval, mm, and its first to third powers from its start, per mm.
    fn powers(&self, index: usize, direction: Direction) -> (f64, [[f64; W]; 3]) {
        let start = self.knots.get(index).map_or(index as f64 / self.scale.to_f64(), |knot| knot.to_f64());
        let next = self.knots.get(index + 1).map_or((index + 1) as f64 / self.scale.to_f64(), |knot| knot.to_f64());
        let Piece { rate, linear, cubic, .. } = self.piece(R::of(0.5 * (start + next)), direction);
        let zero = [R::ZERO; W];
        let (c1, c2, c3) = match (linear, cubic) {
            (Some([_, c1]), _) => (*c1, zero, zero),
            (_, Some([_, c1, c2, c3])) => (*c1, *c2, *c3),
            _ => (zero, zero, zero),
        };
        let rate = rate.to_f64();
        let per_mm = |line: [R; W], rate: f64| line.map(|c| c.to_f64() * rate);
        (next - start, [per_mm(c1, rate), per_mm(c2, rate * rate), per_mm(c3, rate * rate * rate)])
    }

    /// Calls `take` with every number that distinguishes this table from another.
    pub(super) fn numbers(&self, take: &mut impl FnMut(f64)) {
        take(self.origin.to_f64());
        take(self.end.to_f64());
        take(self.reverse_offset as f64);
        let scalars = [self.span, self.scale, self.last];
        let linear = self.linear.iter().flatten().flatten();
        let cubic = self.cubic.iter().flatten().flatten();
        scalars.iter().chain(linear).chain(cubic).chain(self.knots).for_each(|number| take(number.to_f64()));
    }

    /// Whether the table is equidistant, linear and does not wrap, as [`AxisTable::at_plain`] requires.
    pub fn is_plain(&self) -> bool {
        self.knots.is_empty() && self.is_linear()
    }

    /// Whether the table is equidistant and linear: [`AxisTable::at_plain`] accepts every result of
    /// [`AxisTable::coordinate`], but does not continue across a seam.
    pub fn is_even(&self) -> bool {
        self.knots.is_empty() && self.cubic.is_empty()
    }

    /// Returns the contribution at a coordinate of a *plain* table, and whether its edge value is clamped.
    ///
    /// `v + t s` with the interval and `t` from one multiplication.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn at_plain(&self, coordinate: R, direction: Direction) -> (Contribution<R, W>, bool) {
        let wanted = coordinate * self.scale;
        let clamped = wanted.limit(R::ZERO, self.last);
        let index = clamped.to_i32();
        let t = clamped - R::of_i32(index);
        match self.linear.get((index as usize).wrapping_add(self.reverse_offset & direction.mask())) {
            Some([value, slope]) => (along(value, t, slope), wanted != clamped),
            None => ([R::ZERO; W], false),
        }
    }

    /// Whether the table is linear and does not wrap, as [`AxisTable::at_linear`] requires.
    pub fn is_linear(&self) -> bool {
        !self.wraps && self.cubic.is_empty()
    }

    /// Returns the contribution at a coordinate of a *linear* table on any grid, and whether its edge value is clamped.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn at_linear(&self, coordinate: R, direction: Direction) -> (Contribution<R, W>, bool) {
        if self.knots.is_empty() {
            return self.at_plain(coordinate, direction);
        }
        let clamped = coordinate.limit(R::ZERO, self.span);
        let (index, t) = self.search(clamped);
        match self.linear.get(index.wrapping_add(self.reverse_offset & direction.mask())) {
            Some([value, slope]) => (along(value, t, slope), coordinate != clamped),
            None => ([R::ZERO; W], false),
        }
    }

    /// Whether the table is cubic and does not wrap, or is empty, as [`AxisTable::at_cubic`] requires.
    pub fn is_cubic(&self) -> bool {
        !self.wraps && self.linear.is_empty()
    }

    /// Returns the contribution at a coordinate of a *cubic* table on any grid, and whether its edge value is clamped.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn at_cubic(&self, coordinate: R, direction: Direction) -> (Contribution<R, W>, bool) {
        let (index, t, edge) = if self.knots.is_empty() {
            let wanted = coordinate * self.scale;
            let clamped = wanted.limit(R::ZERO, self.last);
            let index = clamped.to_i32();
            (index as usize, clamped - R::of_i32(index), wanted != clamped)
        } else {
            let clamped = coordinate.limit(R::ZERO, self.span);
            let (index, t) = self.search(clamped);
            (index, t, coordinate != clamped)
        };
        match self.cubic.get(index.wrapping_add(self.reverse_offset & direction.mask())) {
            Some([value, c1, c2, c3]) => (along(value, t, &along(c1, t, &along(c2, t, c3))), edge),
            None => ([R::ZERO; W], false),
        }
    }

    /// Wraps a coordinate that a correction has carried across the seam of a table over a full turn.
    #[cfg_attr(feature = "fast", inline(always))]
    fn over_the_seam(&self, coordinate: R) -> R {
        if !self.wraps {
            coordinate
        } else if coordinate < R::ZERO {
            coordinate + self.span
        } else if coordinate > self.span {
            coordinate - self.span
        } else {
            coordinate
        }
    }

    /// Returns the contribution at a coordinate, and whether the table's edge value is clamped, for any table.
    #[inline]
    pub fn at(&self, coordinate: R, direction: Direction) -> (Contribution<R, W>, bool) {
        let coordinate = self.over_the_seam(coordinate);
        let clamped = coordinate.limit(R::ZERO, self.span);
        let (index, t) = if self.knots.is_empty() {
            let place = (clamped * self.scale).min(self.last);
            let index = place.to_i32();
            (index as usize, place - R::of_i32(index))
        } else {
            self.search(clamped)
        };
        let index = index.wrapping_add(self.reverse_offset & direction.mask());
        let value = if self.cubic.is_empty() {
            self.linear.get(index).map(|[value, slope]| along(value, t, slope))
        } else {
            let cell = self.cubic.get(index);
            cell.map(|[value, c1, c2, c3]| along(value, t, &along(c1, t, &along(c2, t, c3))))
        };
        match value {
            Some(value) => (value, coordinate != clamped),
            None => ([R::ZERO; W], false),
        }
    }

    /// The interval at a coordinate, for caching: outside the fast path of the cycle.
    #[inline]
    pub(super) fn interval(&self, coordinate: R, direction: Direction) -> Interval<'a, R, W> {
        let mut found = Interval {
            line: Line::Zero,
            t: R::ZERO,
            per_mm: R::ONE,
            below: R::MAX,
            above: R::MAX,
            inner: [false; 2],
            edge: false,
        };
        let count = self.linear.len().max(self.cubic.len());
        if count == 0 {
            return found;
        }
        let coordinate = self.over_the_seam(coordinate);
        let clamped = coordinate.limit(R::ZERO, self.span);
        // The parameter of an equidistant interval runs from 0 to 1, that of a free one in mm.
        let (index, t, width) = if self.knots.is_empty() {
            found.per_mm = self.scale;
            let place = (clamped * self.scale).min(self.last);
            let index = place.to_i32();
            (index as usize, place - R::of_i32(index), R::ONE)
        } else {
            let (index, t) = self.search(clamped);
            let knot = |index: usize| self.knots.get(index).copied().unwrap_or(self.span);
            (index, t, knot(index.wrapping_add(1)) - knot(index))
        };
        let last = if self.reverse_offset == 0 { count } else { self.reverse_offset }.wrapping_sub(1);
        let line = index.wrapping_add(self.reverse_offset & direction.mask());
        found.line = match (self.linear.get(line), self.cubic.get(line)) {
            (Some(line), _) => Line::Linear(line),
            (_, Some(line)) => Line::Cubic(line),
            _ => Line::Zero,
        };
        found.t = t;
        if coordinate != clamped {
            (found.edge, found.per_mm) = (true, R::ZERO);
            let low = coordinate < R::ZERO;
            (found.below, found.above) = if low { (R::MAX, -coordinate) } else { (coordinate - self.span, R::MAX) };
            return found;
        }
        let mm = R::ONE / found.per_mm;
        // The table's last point is a separate interval.
        (found.below, found.above) = (t * mm, if index < last { (width - t) * mm } else { R::ZERO });
        found.inner = [index > 0 && index < last, index.wrapping_add(1) < last];
        found
    }

    /// Largest |second derivative| within the intervals, per mm² (deg²), for each of the `W` numbers.
    pub(super) fn largest_bends(&self) -> [R; W] {
        let mut most = [R::ZERO; W];
        for (index, [_, _, c2, c3]) in self.cubic.iter().enumerate() {
            let count = self.knots.len().max(1);
            let knot = |index: usize| self.knots.get(index % count).copied();
            let (per_mm, width) = match (knot(index), knot(index.wrapping_add(1))) {
                (Some(low), Some(high)) => (R::ONE, (high - low).max(R::ZERO)),
                _ => (self.scale, R::ONE),
            };
            for ((most, c2), c3) in most.iter_mut().zip(c2).zip(c3) {
                let bend = R::TWO * c2.abs() + R::TWO * R::THREE * width * c3.abs();
                *most = most.max(bend * per_mm * per_mm);
            }
        }
        most
    }

    /// Largest change of a slope from one interval to the next, per mm (deg), for each of the `W` numbers.
    pub(super) fn largest_kinks(&self) -> [R; W] {
        let mut most = [R::ZERO; W];
        let count = if self.reverse_offset == 0 { self.linear.len() } else { self.reverse_offset };
        let per_mm = if self.knots.is_empty() { self.scale } else { R::ONE };
        for block in self.linear.chunks(count.max(1)) {
            // The last line is the constant beyond the table; no interval continues into it.
            let intervals = block.get(..count.saturating_sub(1)).unwrap_or(&[]);
            for ([_, before], [_, after]) in intervals.iter().zip(intervals.iter().skip(1)) {
                for ((most, before), after) in most.iter_mut().zip(before).zip(after) {
                    *most = most.max((*after - *before).abs() * per_mm);
                }
            }
        }
        most
    }

    /// Whether the table is not cubic.
    pub(super) fn is_straight(&self) -> bool {
        self.cubic.is_empty()
    }

    /// Interval of a free grid and the distance from its first point.
    ///
    /// A bucket of the guide contains at most one point, unless the grid is very uneven; one comparison then decides.
    #[cfg_attr(feature = "fast", inline(always))]
    fn search(&self, coordinate: R) -> (usize, R) {
        let bucket = (coordinate * self.scale).to_u32() as usize;
        let first = self.guide.get(bucket).map_or(0, |entry| entry.to_index());
        let first = if self.depth > 1 { self.search_on(first, coordinate) } else { first };
        let ahead = self.knots.get(first.wrapping_add(1)).is_some_and(|next| *next <= coordinate);
        let index = first.wrapping_add(usize::from(ahead));
        match self.knots.get(index) {
            Some(knot) => (index, coordinate - *knot),
            None => (index, R::ZERO),
        }
    }

    /// Bisects a crowded bucket, starting from the last point before it. Returns the last point not above the
    /// coordinate, or the one before that; the caller's comparison decides.
    #[cold]
    #[inline(never)]
    fn search_on(&self, first: usize, coordinate: R) -> usize {
        let mut index = first;
        let mut half = (1usize << (self.depth & 15)) >> 1;
        while half > 0 {
            let ahead = index.wrapping_add(half);
            if self.knots.get(ahead).is_some_and(|knot| *knot <= coordinate) {
                index = ahead;
            }
            half >>= 1;
        }
        index
    }
}

/// First to third powers of a polynomial, shifted by `u`.
fn at_end<const W: usize>(u: f64, [c1, c2, c3]: [[f64; W]; 3]) -> [[f64; W]; 3] {
    [
        core::array::from_fn(|k| c1[k] + u * (2.0 * c2[k] + 3.0 * u * c3[k])),
        core::array::from_fn(|k| c2[k] + 3.0 * u * c3[k]),
        c3,
    ]
}

/// Norms of the differences, power by power.
fn changes<const W: usize>(before: [[f64; W]; 3], after: [[f64; W]; 3]) -> [f64; 3] {
    core::array::from_fn(|power| {
        let squares = before[power].iter().zip(after[power]).map(|(a, b)| (b - a) * (b - a));
        libm::sqrt(squares.sum())
    })
}

/// An interval of a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval<'a, R, const W: usize> {
    line: Line<'a, R, W>,
    /// Parameter of the polynomial at the coordinate, and its rate, zero beyond the table.
    pub(super) t: R,
    pub(super) per_mm: R,
    /// Extent of the interval to either side, mm (deg).
    pub(super) below: R,
    pub(super) above: R,
    /// Whether the table has another interval on that side.
    pub(super) inner: [bool; 2],
    /// Whether the coordinate is beyond the table: clamped edge value.
    pub(super) edge: bool,
}

#[derive(Clone, Copy, Debug)]
enum Line<'a, R, const W: usize> {
    Zero,
    Linear(&'a [Contribution<R, W>; 2]),
    Cubic(&'a [Contribution<R, W>; 4]),
}

impl<R: Real, const W: usize> Interval<'_, R, W> {
    /// Room for a tangent to either side, mm (deg): up to the interval's ends, plus the overlap at a point within the
    /// table.
    pub(super) fn rooms(&self, overlap: R) -> [R; 2] {
        let [below, above] = self.inner;
        [(self.below, below), (self.above, above)].map(|(room, inner)| if inner { room + overlap } else { room })
    }

    /// Coefficients of the polynomial around a parameter, per mm (deg): value and slope, and for a cubic table the rest.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn powers(&self, t: R) -> ([[R; W]; 2], Option<[[R; W]; 2]>) {
        let (zero, f) = ([R::ZERO; W], self.per_mm);
        match self.line {
            Line::Zero => ([zero; 2], None),
            Line::Linear([value, slope]) => ([along(value, t, slope), slope.map(|slope| slope * f)], None),
            Line::Cubic([value, c1, c2, c3]) => {
                let (square, cube) = (f * f, f * f * f);
                let value = along(value, t, &along(c1, t, &along(c2, t, c3)));
                let slope = core::array::from_fn(|k| (c1[k] + t * (R::TWO * c2[k] + R::THREE * t * c3[k])) * f);
                let second = core::array::from_fn(|k| (c2[k] + R::THREE * t * c3[k]) * square);
                ([value, slope], Some([second, c3.map(|c3| c3 * cube)]))
            }
        }
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
pub(super) fn requirement_of_all<'r, const W: usize, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
) -> usize {
    let need = |settings: &AxisSettings| {
        let lines = Lines::of(machine, &rows, settings);
        lines.map_or(0, |(lines, settings)| AxisTable::<f64, f64, W>::requirement(&settings, &lines))
    };
    machine.axes.iter().map(need).sum()
}

#[cfg_attr(feature = "fast", inline(always))]
fn along<R: Real, const W: usize>(value: &[R; W], t: R, slope: &[R; W]) -> [R; W] {
    core::array::from_fn(|k| value[k] + t * slope[k])
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
