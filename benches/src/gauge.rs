//! A gauge of three probes with 1024 points, at nine and a half cycles per point.

use crate::step::PERIOD_NS;
use trueaxis::roundness::{self, Followed, GaugeSettings, ProbeAngles, Probes};

/// Points of a revolution.
pub const POINTS: usize = 1024;
/// Counts of the spindle encoder per revolution.
const COUNTS: i32 = 1 << 22;
/// Counts per cycle.
const STEP: i32 = 431;
/// Units of work of the forward transform, the pairs, the harmonics kept and the inverse, and the twelve units between and
/// after them.
const TRANSFORM_UNITS: usize = 512 + 256 + 127 + 512 + 12;

/// A gauge and the readings of its next cycle.
#[derive(Clone)]
pub struct Gauge {
    /// The gauge.
    pub gauge: Box<roundness::Gauge<f64, POINTS>>,
    /// State of the gauge.
    pub state: Box<roundness::GaugeState<f64, POINTS>>,
    /// Readings.
    pub probes: Probes<f64>,
    cycle: i32,
}

impl Gauge {
    fn new() -> Self {
        let mut settings =
            GaugeSettings::with_defaults(POINTS as u16, ProbeAngles::Slots { p: 188, q: 667 }, COUNTS as u32);
        settings.revolutions = 1;
        let gauge = Box::new(roundness::Gauge::build(&settings, PERIOD_NS).expect("valid settings"));
        let state = Box::new(gauge.start());
        Gauge { gauge, state, probes: Probes::default(), cycle: 0 }
    }

    /// Advances to the readings of the next cycle.
    pub fn advance(&mut self) {
        let before = self.cycle * STEP - 1000;
        self.cycle += 1;
        let now = self.cycle * STEP - 1000;
        let turn = now.div_euclid(COUNTS);
        let crossed = turn != before.div_euclid(COUNTS);
        let wave = |phase: f64| (f64::from(now) * 3e-6 + phase).sin();
        self.probes = Probes {
            readings: [wave(0.0), wave(1.0), wave(2.0)],
            spindle: now,
            index: crossed.then_some(turn * COUNTS),
            arm: 0,
            new_part: false,
            idle: false,
        };
    }

    /// Runs the first stage.
    #[inline(always)]
    pub fn sample(&mut self) -> u16 {
        self.gauge.sample(&mut self.state, &self.probes, Followed::Whole).0
    }

    /// Whether the next cycle passes a point.
    fn passes(&self) -> bool {
        let place = |cycle: i32| (cycle * STEP - 1000).div_euclid(COUNTS / POINTS as i32);
        place(self.cycle) != place(self.cycle - 1)
    }

    /// A gauge in the middle of a revolution, before a cycle that passes a point or does not.
    pub fn sampling(passing: bool) -> Self {
        let mut gauge = Gauge::new();
        loop {
            gauge.advance();
            if gauge.cycle > 15_000 && gauge.passes() == passing {
                return gauge;
            }
            gauge.sample();
        }
    }

    /// A gauge before the first slice of work on a revolution.
    pub fn whole_revolution() -> Self {
        let mut gauge = Gauge::new();
        while gauge.state.is_settled() {
            gauge.advance();
            gauge.sample();
        }
        gauge
    }

    /// Runs forward transform, division and inverse of one revolution.
    #[inline(always)]
    pub fn transform(&mut self) -> bool {
        (0..TRANSFORM_UNITS).fold(false, |finished, _| finished | self.gauge.work(&mut self.state))
    }

    /// Runs all the work on one revolution.
    #[inline(always)]
    pub fn work(&mut self) {
        while !self.gauge.work(&mut self.state) {}
    }
}
