//! One cell of one axis.

use crate::position::Position;
use crate::real::Real;

/// Positions from `low` on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window<P: Position> {
    pub(super) low: P,
    pub(super) reach: P::Reach,
}

impl<P: Position> Window<P> {
    pub(super) fn between(low: P, high: P) -> Self {
        Window { low, reach: high.apart(low) }
    }
}

/// Where it lies and its polynomial of the distance from its start, in steps of the position.
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
    /// No position lies in it.
    pub(super) fn nowhere() -> Self {
        let (zero, window) = ([R::ZERO; 3], Window { low: P::of(f64::NAN), reach: P::Reach::default() });
        Cell { window, slope: zero, curve: [zero; 2], start: zero }
    }

    /// Distance from its start, and whether the position lies in it.
    #[inline(always)]
    pub(super) fn steps(&self, position: P) -> (R, bool) {
        position.steps_above(self.window.low, self.window.reach)
    }

    /// What a component rises from its start.
    #[inline(always)]
    pub(super) fn rise(&self, t: R, k: usize) -> R {
        let [second, third] = &self.curve;
        match (self.slope.get(k), second.get(k), third.get(k)) {
            (Some(slope), Some(second), Some(third)) => t * (*slope + t * (*second + t * *third)),
            _ => R::ZERO,
        }
    }

    /// Error at a distance from its start.
    #[inline(always)]
    pub(super) fn error(&self, t: R, cubic: bool) -> [R; 3] {
        if cubic {
            core::array::from_fn(|k| self.start[k] + self.rise(t, k))
        } else {
            core::array::from_fn(|k| self.start[k] + t * self.slope[k])
        }
    }
}
