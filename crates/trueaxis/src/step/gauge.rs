//! A three-probe gauge that runs with the step.

#![deny(clippy::indexing_slicing)]

use crate::position::Position;
use crate::real::Real;
use crate::roundness::{Cycle, Followed, Gauge, GaugeState, Probes};
use crate::sample::{Sample, Verdict};

/// Optional gauge that runs with the step: `()` for none, or `&mut` [`GaugeRide`], resolved at compile time, or
/// `&mut dyn Ride`.
pub trait Ride<R> {
    /// Slot of the axis that the infeed moves.
    fn infeed_slot(&self) -> Option<usize>;
    /// Runs one cycle of the gauge; returns the infeed it requests, mm in the sense of its axis.
    fn update(&mut self, followed: Followed) -> R;
}

impl<R: Real> Ride<R> for () {
    #[inline(always)]
    fn infeed_slot(&self) -> Option<usize> {
        None
    }
    #[inline(always)]
    fn update(&mut self, _: Followed) -> R {
        R::ZERO
    }
}

/// Any implementation, chosen at run time.
impl<R: Real> Ride<R> for &mut (dyn Ride<R> + '_) {
    fn infeed_slot(&self) -> Option<usize> {
        (**self).infeed_slot()
    }
    fn update(&mut self, followed: Followed) -> R {
        (**self).update(followed)
    }
}

/// A gauge, its state and the readings of a cycle.
///
/// Every cycle does some slices of the gauge's work and adds its infeed correction to the tables' correction of that
/// axis, through the same limiter. While the step is inactive the gauge continues to measure, without infeed. Motion due
/// to the infeed is part of the contour error: the programmed path does not contain it.
#[derive(Debug)]
pub struct GaugeRide<'a, R, const POINTS: usize> {
    gauge: &'a Gauge<R, POINTS>,
    state: &'a mut GaugeState<R, POINTS>,
    probes: &'a Probes<R>,
    cycle: Cycle<R>,
}

impl<'a, R: Real, const POINTS: usize> GaugeRide<'a, R, POINTS> {
    /// Binds a gauge, its state and its probes for one cycle.
    #[inline(always)]
    pub fn new(gauge: &'a Gauge<R, POINTS>, state: &'a mut GaugeState<R, POINTS>, probes: &'a Probes<R>) -> Self {
        GaugeRide { gauge, state, probes, cycle: Cycle::default() }
    }

    /// Output of the gauge in the cycle.
    #[inline(always)]
    pub fn cycle(&self) -> Cycle<R> {
        self.cycle
    }
}

impl<R: Real, const POINTS: usize> Ride<R> for &mut GaugeRide<'_, R, POINTS> {
    #[inline(always)]
    fn infeed_slot(&self) -> Option<usize> {
        self.gauge.infeed_slot()
    }
    #[inline(always)]
    fn update(&mut self, followed: Followed) -> R {
        self.cycle = self.gauge.update(self.state, self.probes, followed);
        self.cycle.infeed
    }
}

/// A cycle of the gauge: reports to it how its infeed was followed, and adds the next infeed.
#[inline(always)]
pub(super) fn run<R: Real, P: Position, const N: usize>(
    gauge: &mut impl Ride<R>,
    sample: &Sample<P, N>,
    limited: u8,
    wanted: &mut [R; N],
) {
    let slot = gauge.infeed_slot().unwrap_or(N);
    let followed = match sample.verdict {
        Verdict::Active if (limited >> (slot & 7)) & 1 == 1 => Followed::Limited,
        Verdict::Active => Followed::Whole,
        _ => Followed::Not,
    };
    let infeed = gauge.update(followed);
    if let (Verdict::Active, Some(wanted)) = (sample.verdict, wanted.get_mut(slot)) {
        *wanted += infeed;
    }
}
