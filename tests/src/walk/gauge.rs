//! A gauge with few or many points per revolution: a leg has many revolutions, or long ones.

use super::dice::Dice;
use super::scalar::Scalar;
use super::spindle;
use trueaxis::roundness::{Counts, Cycle, Evaluation, Gauge, GaugeState, Probes};
use trueaxis::{GaugeRide, Ride};

/// Minimum number of points.
const FEW: usize = 64;
/// Number of points of a large gauge.
pub(super) const MANY: usize = 512;

/// The gauge of a leg.
#[derive(Debug)]
pub(super) enum AnyGauge<R: Scalar> {
    Few(Gauge<R, FEW>),
    Many(Gauge<R, MANY>),
}

/// State of the gauge.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "a device is copied as a whole, without an allocation")]
pub(super) enum AnyState<R: Scalar> {
    Few(GaugeState<R, FEW>),
    Many(GaugeState<R, MANY>),
}

impl<R: Scalar> AnyGauge<R> {
    /// Draws a gauge; returns it with the bound of its infeed, µm.
    pub(super) fn draw(dice: &mut Dice, period_ns: u32, many: bool) -> (Self, f64) {
        let settings = spindle::settings(dice, if many { MANY as u16 } else { FEW as u16 });
        let limit_um = settings.infeed.map_or(0.0, |infeed| infeed.limit_um);
        let gauge = match many {
            false => AnyGauge::Few(Gauge::build(&settings, period_ns).expect("a gauge")),
            true => AnyGauge::Many(Gauge::build(&settings, period_ns).expect("a gauge")),
        };
        (gauge, limit_um)
    }

    /// A fresh state.
    pub(super) fn start(&self) -> AnyState<R> {
        match self {
            AnyGauge::Few(_) => AnyState::Few(GaugeState::new()),
            AnyGauge::Many(_) => AnyState::Many(GaugeState::new()),
        }
    }

    /// Slot of the infeed axis.
    pub(super) fn infeed_slot(&self) -> Option<usize> {
        match self {
            AnyGauge::Few(gauge) => gauge.infeed_slot(),
            AnyGauge::Many(gauge) => gauge.infeed_slot(),
        }
    }

    /// Runs one cycle with the gauge, by `step`.
    pub(super) fn run_with(
        &self,
        state: &mut AnyState<R>,
        probes: &Probes<R>,
        step: impl FnOnce(&mut dyn Ride<R>),
    ) -> Option<Cycle<R>> {
        match (self, state) {
            (AnyGauge::Few(gauge), AnyState::Few(state)) => {
                let mut ride = GaugeRide::new(gauge, state, probes);
                step(&mut &mut ride);
                Some(ride.cycle())
            }
            (AnyGauge::Many(gauge), AnyState::Many(state)) => {
                let mut ride = GaugeRide::new(gauge, state, probes);
                step(&mut &mut ride);
                Some(ride.cycle())
            }
            _ => None,
        }
    }
}

impl<R: Scalar> AnyState<R> {
    /// State of a device without a gauge.
    pub(super) fn none() -> Self {
        AnyState::Few(GaugeState::new())
    }

    pub(super) fn counts(&self) -> Counts {
        match self {
            AnyState::Few(state) => state.counts(),
            AnyState::Many(state) => state.counts(),
        }
    }

    pub(super) fn is_settled(&self) -> bool {
        match self {
            AnyState::Few(state) => state.is_settled(),
            AnyState::Many(state) => state.is_settled(),
        }
    }

    pub(super) fn latest(&self) -> Option<Evaluation<R>> {
        match self {
            AnyState::Few(state) => state.latest(),
            AnyState::Many(state) => state.latest(),
        }
    }

    /// The infeed of a revolution, point by point, µm.
    pub(super) fn correction(&self) -> &[R] {
        match self {
            AnyState::Few(state) => state.correction(),
            AnyState::Many(state) => state.correction(),
        }
    }
}
