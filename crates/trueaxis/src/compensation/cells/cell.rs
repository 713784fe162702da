//! A cell of one axis.

use crate::position::Position;
use crate::real::Real;

/// Positions from `low` to `low + reach`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window<P: Position> {
    pub(super) low: P,
    pub(super) reach: P::Reach,
}

impl<P: Position> Window<P> {
    /// A window that contains no position.
    pub(super) fn empty() -> Self {
        Window { low: P::of(f64::NAN), reach: P::Reach::default() }
    }

    pub(super) fn between([low, high]: [P; 2]) -> Self {
        Window { low, reach: high.apart(low) }
    }

    /// Whether it lies within these ends.
    pub(super) fn is_within(&self, ends: &[P; 2]) -> bool {
        let [_, high] = ends;
        self.low.is_within(ends) && high.apart(self.low) >= self.reach
    }
}

/// Window of a cell, and its polynomial of the distance from its start, in steps of the position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<R, P: Position> {
    pub(super) window: Window<P>,
    /// k1.
    pub(super) slope: [R; 3],
    /// k2 and k3; zero in a linear table.
    pub(super) curve: [[R; 3]; 2],
    /// k0.
    pub(super) start: [R; 3],
}

impl<R: Real, P: Position> Cell<R, P> {
    /// A cell that contains no position.
    pub(super) fn empty() -> Self {
        let zero = [R::ZERO; 3];
        Cell { window: Window::empty(), slope: zero, curve: [zero; 2], start: zero }
    }

    /// Distance of a position from the cell's start if it lies in the cell.
    #[inline(always)]
    pub(super) fn steps(&self, position: P) -> Option<R> {
        let (steps, inside) = position.steps_above(self.window.low, self.window.reach);
        if inside { Some(steps) } else { None }
    }

    /// Becomes a copy of another cell if that holds a position and lies within these ends; returns whether it does.
    #[inline(always)]
    pub(super) fn takes(&mut self, other: &Self, position: P, ends: Option<[P; 2]>) -> bool {
        let fits = other.steps(position).is_some() && ends.is_none_or(|ends| other.window.is_within(&ends));
        if fits {
            *self = *other;
        }
        fits
    }

    /// Rise of the error from the cell's start to a distance `t`.
    #[inline(always)]
    pub(super) fn rise(&self, t: R, cubic: bool) -> [R; 3] {
        let [second, third] = self.curve;
        let slope = if cubic { plus(self.slope, times(t, plus(second, times(t, third)))) } else { self.slope };
        times(t, slope)
    }
}

#[inline(always)]
pub(super) fn plus<R: Real>([a, b, c]: [R; 3], [x, y, z]: [R; 3]) -> [R; 3] {
    [a + x, b + y, c + z]
}

#[inline(always)]
pub(super) fn times<R: Real>(t: R, [x, y, z]: [R; 3]) -> [R; 3] {
    [t * x, t * y, t * z]
}
