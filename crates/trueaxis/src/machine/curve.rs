//! One column of an error table as the function evaluated by the step.

use super::rows::Rows;
use super::{Axis, AxisSettings, Interpolation, pchip};

/// Error of one component in one direction of travel as a function of position.
///
/// mm or rad over mm or degrees. Costs a few line lookups per interval: meant for build, not for the step.
#[derive(Clone, Copy, Debug)]
pub struct Curve<'r, T: ?Sized> {
    rows: &'r T,
    component: usize,
    reverse: bool,
    cubic: bool,
    wraps: bool,
}

/// One interval: width, rise, slopes at its ends.
#[derive(Clone, Copy, Debug)]
struct Cell {
    start: f64,
    width: f64,
    value: f64,
    secant: f64,
    slopes: [f64; 2],
}

/// Whether a table covers a full circle, so that its end continues at its start.
///
/// 360 degrees within 1e-9: the difference of two decimals need not be exact.
pub fn wraps(axis: Axis, rows: &(impl Rows + ?Sized)) -> bool {
    match (rows.row(0), rows.row(rows.len().wrapping_sub(1))) {
        (Some(first), Some(last)) => axis.is_rotary() && (last.position - first.position - 360.0).abs() < 1e-9,
        _ => false,
    }
}

impl<'r, T: Rows + ?Sized> Curve<'r, T> {
    /// Creates the column of `component` (0 to 5: EX EY EZ EA EB EC) in positive or negative travel, without backlash.
    pub fn new(settings: &AxisSettings, rows: &'r T, component: usize, reverse: bool) -> Self {
        Curve {
            rows,
            component,
            reverse,
            cubic: settings.interpolation == Interpolation::Cubic,
            wraps: wraps(settings.axis, rows),
        }
    }

    fn point(&self, index: usize) -> Option<(f64, f64)> {
        let row = self.rows.row(index)?;
        let twist = if self.reverse { row.reverse } else { row.forward };
        Some((row.position, twist.get(self.component).copied()?))
    }

    fn secant(&self, index: usize) -> Option<(f64, f64)> {
        let ((q0, v0), (q1, v1)) = (self.point(index)?, self.point(index.checked_add(1)?)?);
        Some((q1 - q0, (v1 - v0) / (q1 - q0)))
    }

    fn slope(&self, index: usize) -> Option<f64> {
        let last = self.rows.len().checked_sub(1)?;
        let join = |(h0, d0), (h1, d1), f: fn(f64, f64, f64, f64) -> f64| Some(f(h0, d0, h1, d1));
        if last == 1 {
            return self.secant(0).map(|(_, d)| d);
        }
        if self.wraps && (index == 0 || index == last) {
            return join(self.secant(last.checked_sub(1)?)?, self.secant(0)?, pchip::slope);
        }
        if index == 0 {
            join(self.secant(0)?, self.secant(1)?, pchip::end_slope)
        } else if index == last {
            join(self.secant(last.checked_sub(1)?)?, self.secant(last.checked_sub(2)?)?, pchip::end_slope)
        } else {
            join(self.secant(index.checked_sub(1)?)?, self.secant(index)?, pchip::slope)
        }
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        let (start, value) = self.point(index)?;
        let (width, secant) = self.secant(index)?;
        let slopes =
            if self.cubic { [self.slope(index)?, self.slope(index.checked_add(1)?)?] } else { [secant, secant] };
        Some(Cell { start, width, value, secant, slopes })
    }

    fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        (0..self.rows.len().saturating_sub(1)).filter_map(|index| self.cell(index))
    }

    /// Largest |slope| over the whole table, exact, and the line at which its interval starts.
    pub fn steepest(&self) -> (f64, usize) {
        let slopes = self.cells().map(|cell| cell.steepest()).enumerate();
        // An overflow may give NaN: it counts as the steepest.
        slopes.fold((0.0, 0), |(most, at), (index, slope)| if slope <= most { (most, at) } else { (slope, index) })
    }

    /// Largest |second derivative| over the whole table, exact; `None` for a linear table, whose slope steps at its
    /// points.
    pub fn most_bent(&self) -> Option<f64> {
        self.cubic.then(|| self.cells().map(|cell| cell.most_bent()).fold(0.0, f64::max))
    }

    /// Largest step of the slope between two intervals, including the seam of a full circle; 0 for a cubic table.
    pub fn slope_step(&self) -> f64 {
        if self.cubic {
            return 0.0;
        }
        let secants = || self.cells().map(|cell| cell.secant);
        let seam = match (self.wraps, secants().next(), secants().last()) {
            (true, Some(first), Some(last)) => (first - last).abs(),
            _ => 0.0,
        };
        secants().zip(secants().skip(1)).fold(seam, |most, (before, after)| most.max((after - before).abs()))
    }

    /// Value at a position; beyond the ends the edge value, or around the circle if the table wraps.
    pub fn at(&self, position: f64) -> Option<f64> {
        let last = self.rows.len().checked_sub(1)?;
        let ((low, first), (high, end)) = (self.point(0)?, self.point(last)?);
        let position = if self.wraps {
            let turned = libm::fmod(position - low, 360.0);
            low + if turned < 0.0 { turned + 360.0 } else { turned }
        } else {
            position
        };
        if position <= low {
            return Some(first);
        }
        if position >= high {
            return Some(end);
        }
        let cell = self.cells().take_while(|cell| cell.start <= position).last()?;
        Some(cell.at((position - cell.start) / cell.width))
    }

    /// Smallest and largest value of `E(q) + tilt · q` over `[low, high]`, evaluated at the lines in between and at both
    /// ends.
    ///
    /// Exact without tilt (no curve leaves its interval's end values) and for linear tables.
    pub fn extremes(&self, low: f64, high: f64, tilt: f64) -> Option<(f64, f64)> {
        let ends = [low, high].map(|q| self.at(q).map(|value| value + tilt * q));
        let [Some(a), Some(b)] = ends else { return None };
        // On a circle the range may contain any line, wherever it lies.
        let inside = |q: f64| self.wraps || (low..=high).contains(&q);
        let between = (0..self.rows.len()).filter_map(|index| self.point(index)).filter(|(q, _)| inside(*q));
        let values = between.map(|(q, value)| value + tilt * q);
        Some(values.fold((a.min(b), a.max(b)), |(least, most), value| (least.min(value), most.max(value))))
    }
}

/// Smallest and largest difference reverse − forward of a component over a whole table; exact, without backlash.
pub(crate) fn lost(settings: &AxisSettings, rows: &(impl Rows + ?Sized), component: usize) -> (f64, f64) {
    let [forward, reverse] = [false, true].map(|reverse| Curve::new(settings, rows, component, reverse));
    let mut both = (f64::INFINITY, f64::NEG_INFINITY);
    for (there, back) in forward.cells().zip(reverse.cells()) {
        let [m0, m1] = there.slopes;
        let [n0, n1] = back.slopes;
        let difference = Cell {
            value: back.value - there.value,
            secant: back.secant - there.secant,
            slopes: [n0 - m0, n1 - m1],
            ..there
        };
        let (least, most) = difference.range();
        both = (both.0.min(least), both.1.max(most));
    }
    both
}

impl Cell {
    /// Smallest and largest value on 0…1: at the ends or at zeros of the derivative.
    fn range(&self) -> (f64, f64) {
        let [m0, m1] = self.slopes;
        let (linear, square) = (2.0 * (3.0 * self.secant - 2.0 * m0 - m1), 3.0 * (m0 + m1 - 2.0 * self.secant));
        // m0 + linear t + square t² = 0, in the form without cancellation; NaN without a root.
        let root = libm::sqrt(linear * linear - 4.0 * square * m0);
        let half = -0.5 * (linear + if linear < 0.0 { -root } else { root });
        let (a, b) = (self.at(0.0), self.at(1.0));
        let inside = [half / square, m0 / half].into_iter().filter(|t| *t > 0.0 && *t < 1.0).map(|t| self.at(t));
        inside.fold((a.min(b), a.max(b)), |(least, most), value| (least.min(value), most.max(value)))
    }

    /// `p'(t) = m0 + 2 (3d − 2 m0 − m1) t + 3 (m0 + m1 − 2d) t²` on 0…1: largest at an end or at the vertex.
    fn steepest(&self) -> f64 {
        let [m0, m1] = self.slopes;
        let (linear, square) = (2.0 * (3.0 * self.secant - 2.0 * m0 - m1), 3.0 * (m0 + m1 - 2.0 * self.secant));
        let ends = m0.abs().max(m1.abs());
        let vertex = -linear / (2.0 * square);
        if vertex > 0.0 && vertex < 1.0 { ends.max((m0 + vertex * linear / 2.0).abs()) } else { ends }
    }

    /// The derivative of p' is linear, so its extreme is at an end.
    fn most_bent(&self) -> f64 {
        let [m0, m1] = self.slopes;
        let (linear, square) = (2.0 * (3.0 * self.secant - 2.0 * m0 - m1), 3.0 * (m0 + m1 - 2.0 * self.secant));
        linear.abs().max((linear + 2.0 * square).abs()) / self.width
    }

    fn at(&self, t: f64) -> f64 {
        let [m0, m1] = self.slopes;
        let d = self.secant;
        self.value + self.width * t * (m0 + t * ((3.0 * d - 2.0 * m0 - m1) + t * (m0 + m1 - 2.0 * d)))
    }
}
