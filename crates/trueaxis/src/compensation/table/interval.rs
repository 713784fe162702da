//! Intervals of a table: polynomial and extent, for a cache of them, and how they meet at the table's points.

use super::{AxisTable, Contribution, along};
use crate::compensation::reversal::Direction;
use crate::position::Position;
use crate::real::Real;

/// Farthest extension of an interval beyond its ends, mm.
const OVERLAP_MM: f64 = 0.02;

/// Polynomial between two points of a table.
pub(in crate::compensation) struct Piece<'a, R, const W: usize> {
    /// Parameter at the requested coordinate, zero at the start.
    pub(in crate::compensation) t: R,
    /// Parameter at the end.
    pub(in crate::compensation) length: R,
    /// Change of the parameter per mm.
    pub(in crate::compensation) rate: R,
    /// mm per change of the parameter.
    pub(in crate::compensation) unit: R,
    /// Coefficients, if the table is linear.
    pub(in crate::compensation) linear: Option<&'a [Contribution<R, W>; 2]>,
    /// Coefficients, if the table is cubic.
    pub(in crate::compensation) cubic: Option<&'a [Contribution<R, W>; 4]>,
    /// Whether it is the table's first, and its last.
    pub(in crate::compensation) ends: [bool; 2],
}

impl<R: Real> Piece<'_, R, 4> {
    /// Translations at a parameter.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(in crate::compensation) fn at(&self, t: R) -> [R; 3] {
        match (self.linear, self.cubic) {
            (Some([value, slope]), _) => xyz(&along(value, t, slope)),
            (_, Some([value, c1, c2, c3])) => xyz(&along(value, t, &along(c1, t, &along(c2, t, c3)))),
            _ => [R::ZERO; 3],
        }
    }
}

/// The translations of a contribution.
#[cfg_attr(feature = "fast", inline(always))]
pub(in crate::compensation) fn xyz<R: Real>([x, y, z, _]: &Contribution<R, 4>) -> [R; 3] {
    [*x, *y, *z]
}

impl<'a, R: Real, P: Position, const W: usize> AxisTable<'a, R, P, W> {
    /// The interval between two points around a coordinate; for a coordinate beyond the table, the end of the first or
    /// last one.
    #[inline]
    pub(in crate::compensation) fn piece(&self, coordinate: R, direction: Direction) -> Piece<'a, R, W> {
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
    pub(in crate::compensation) fn overlap(&self, tolerance: f64) -> f64 {
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

    /// The interval at a coordinate, for caching: outside the fast path of the cycle.
    #[inline]
    pub(in crate::compensation) fn interval(&self, coordinate: R, direction: Direction) -> Interval<'a, R, W> {
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
    pub(in crate::compensation) fn largest_bends(&self) -> [R; W] {
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
    pub(in crate::compensation) fn largest_kinks(&self) -> [R; W] {
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
pub(in crate::compensation) struct Interval<'a, R, const W: usize> {
    line: Line<'a, R, W>,
    /// Parameter of the polynomial at the coordinate, and its rate, zero beyond the table.
    pub(in crate::compensation) t: R,
    pub(in crate::compensation) per_mm: R,
    /// Extent of the interval to either side, mm (deg).
    pub(in crate::compensation) below: R,
    pub(in crate::compensation) above: R,
    /// Whether the table has another interval on that side.
    pub(in crate::compensation) inner: [bool; 2],
    /// Whether the coordinate is beyond the table: clamped edge value.
    pub(in crate::compensation) edge: bool,
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
    pub(in crate::compensation) fn rooms(&self, overlap: R) -> [R; 2] {
        let [below, above] = self.inner;
        [(self.below, below), (self.above, above)].map(|(room, inner)| if inner { room + overlap } else { room })
    }

    /// Coefficients of the polynomial around a parameter, per mm (deg): value and slope, and for a cubic table the rest.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(in crate::compensation) fn powers(&self, t: R) -> ([[R; W]; 2], Option<[[R; W]; 2]>) {
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
