//! Acceleration cross-talk: the tip moves by Δ_i = Σ_j k_ij(q) a_j while axes j accelerate by a_j.

#![deny(clippy::indexing_slicing)]

use crate::error::{ConfigError, Field};
use crate::machine::{AxisOrder, CROSSTALK_CAPACITY, CROSSTALK_POINTS, CrosstalkSettings, MachineSettings};
use crate::position::Position;
use crate::real::Real;

/// One point: position, k in periods², slope to the next one.
#[derive(Clone, Copy, Debug)]
struct Knot<R, P> {
    at: P,
    value: R,
    slope: R,
}

/// One entry, with axes as slots.
#[derive(Clone, Copy, Debug)]
struct Entry<R, P> {
    tip: usize,
    from: usize,
    over: usize,
    knots: [Option<Knot<R, P>>; CROSSTALK_POINTS],
}

/// All entries of a machine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crosstalk<R, P>([Option<Entry<R, P>>; CROSSTALK_CAPACITY]);

impl<R: Real, P: Position> Entry<R, P> {
    fn new<const N: usize>(
        order: &AxisOrder<N>,
        settings: &CrosstalkSettings,
        period_s: f64,
    ) -> Result<Self, ConfigError> {
        let slot = |axis| order.slot(axis).ok_or(ConfigError::new(Field::Axes, 0.0, "an axis of the machine").on(axis));
        let per_periods = 1.0 / (period_s * period_s);
        let mut knots = [None; CROSSTALK_POINTS];
        let followers = settings.points.iter().skip(1).map(Some).chain([None]);
        for ((knot, [at, value]), next) in knots.iter_mut().zip(&settings.points).zip(followers) {
            let slope = next.map_or(0.0, |[above, then]| (then - value) / (above - at));
            let (value, slope) = (R::of(value * per_periods), R::of(slope * per_periods));
            *knot = Some(Knot { at: P::nearest(*at), value, slope });
        }
        Ok(Entry { tip: slot(settings.tip)?, from: slot(settings.from)?, over: slot(settings.over)?, knots })
    }

    /// k at a position, from the value and slope of the last knot below it.
    #[inline(always)]
    fn at(&self, position: P) -> R {
        let mut found = R::ZERO;
        for (index, knot) in self.knots.iter().flatten().enumerate() {
            if index > 0 && position < knot.at {
                break;
            }
            let above: R = position.since_near(knot.at);
            found = knot.value + knot.slope * above.max(R::ZERO);
        }
        found
    }
}

impl<R: Real, P: Position> Crosstalk<R, P> {
    /// # Errors
    /// An axis that the machine does not have.
    pub(super) fn new<const N: usize>(
        order: &AxisOrder<N>,
        machine: &MachineSettings,
        period_s: f64,
    ) -> Result<Self, ConfigError> {
        let mut entries = [None; CROSSTALK_CAPACITY];
        for (entry, settings) in entries.iter_mut().zip(&machine.crosstalk) {
            *entry = Some(Entry::new(order, settings, period_s)?);
        }
        Ok(Crosstalk(entries))
    }

    /// Adds the compensation of the cross-talk; `changes`: changes of the distances per period, by slot.
    #[inline(always)]
    pub(super) fn subtract<const N: usize>(&self, wanted: &mut [R; N], changes: &[R; N], places: &[P; N]) {
        for entry in self.0.iter().flatten() {
            let (Some(change), Some(place)) = (changes.get(entry.from), places.get(entry.over)) else { continue };
            if let Some(wanted) = wanted.get_mut(entry.tip) {
                *wanted += -entry.at(*place) * *change;
            }
        }
    }
}
