//! Three axes of the limiter with its default limits at 10 kHz.

use trueaxis::Axis;
use trueaxis::limiter::{Limiter, LimiterState};
use trueaxis::machine::AxisSettings;

/// Servo period, s.
pub const PERIOD_S: f64 = 1e-4;

/// Limiters, their states, and the wanted corrections of the next cycle.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Limits of each axis.
    pub limiter: [Limiter<f64>; 3],
    /// State of each axis.
    pub state: [LimiterState<f64>; 3],
    /// Wanted corrections, mm.
    pub wanted: [f64; 3],
}

impl Limits {
    fn new() -> Self {
        let limits = AxisSettings::with_defaults(Axis::X, false).limits;
        let limiter = Limiter::new(&limits, PERIOD_S).expect("valid limits");
        Limits { limiter: [limiter; 3], state: Default::default(), wanted: [0.0; 3] }
    }

    /// Locked on to a slow ramp, with no limit binding.
    pub fn free() -> Self {
        let mut limits = Limits::new();
        for cycle in 0..100 {
            limits.wanted = [1e-7, -1e-7, 2e-7].map(|rise| rise * f64::from(cycle));
            limits.follow();
        }
        limits.wanted = limits.wanted.map(|w| w * 1.01);
        limits
    }

    /// In the middle of a jump of 80 µm on every axis: all are limited, including the braking law.
    pub fn binding() -> Self {
        let mut limits = Limits::new();
        limits.wanted = [0.08, -0.08, 0.07];
        for _ in 0..20 {
            limits.follow();
        }
        limits
    }

    /// Runs one cycle; returns the number of limited axes.
    #[inline(always)]
    pub fn follow(&mut self) -> u8 {
        let mut limited = 0;
        for ((limiter, state), wanted) in self.limiter.iter().zip(&mut self.state).zip(self.wanted) {
            limited += u8::from(limiter.follow(state, wanted));
        }
        limited
    }
}
