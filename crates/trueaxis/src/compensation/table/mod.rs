//! Error table of one axis, in the form that the step reads.

mod build;
mod interval;
#[cfg(feature = "bench")]
mod many;

use super::reversal::Direction;
use crate::position::Position;
use crate::real::Real;
pub(super) use build::{enough, own_component, requirement_of_all};
pub(super) use interval::{Piece, xyz};

/// Contribution of an axis at one position.
///
/// Four numbers: the translations along X, Y, Z in mm and the axis' own rotation in degrees (zero for a linear axis,
/// whose positioning error is one of the translations). Six: the translations in mm and the rotations about X, Y, Z in
/// rad.
pub type Contribution<R, const W: usize = 4> = [R; W];

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

    /// A table that is zero everywhere, of a rotary axis whose coordinate is reduced by whole turns.
    pub(super) fn zero_around() -> Self {
        AxisTable { wraps: true, ..AxisTable::zero() }
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
    // Only with crowded_tables.
    #[cold]
    #[inline(never)]
    fn search_on(&self, first: usize, coordinate: R) -> usize {
        let mut index = first;
        let mut half = (1usize << (self.depth & 15)) >> 1;
        // At most 15 rounds: `half` starts at 2^14.
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

#[cfg_attr(feature = "fast", inline(always))]
fn along<R: Real, const W: usize>(value: &[R; W], t: R, slope: &[R; W]) -> [R; W] {
    core::array::from_fn(|k| value[k] + t * slope[k])
}
