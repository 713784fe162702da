//! Machines with a gauge, and the gauge's readings.

use super::PERIOD_NS;
use std::f64::consts::TAU;
use std::ptr::null_mut;
use std::sync::OnceLock;
use trueaxis::roundness;
use trueaxis_capi::*;
use trueaxis_tables::Machine;

/// Counts of the spindle per revolution.
const COUNTS: i32 = 1 << 20;

/// Compiles the machine with a gauge of `points` points that feeds X; reads no files, so that Miri can run it too.
pub(crate) fn with_gauge(mut machine: Machine, points: u16) -> Vec<u8> {
    let slots = roundness::ProbeAngles::Slots { p: points * 44 / 256, q: points * 57 / 256 };
    let mut settings = roundness::GaugeSettings::with_defaults(points, slots, COUNTS as u32);
    settings.band = roundness::Band { first: 2, last: 30 };
    settings.revolutions = 1;
    settings.slices_per_cycle = 2;
    settings.infeed =
        Some(roundness::InfeedSettings::with_defaults(trueaxis::Axis::X, roundness::Band { first: 2, last: 10 }));
    machine.settings.roundness = Some(settings);
    trueaxis_tables::compile(&machine).unwrap()
}

/// A three-axis machine with a gauge at its side, 512 points.
pub(crate) fn small_gauge() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| with_gauge(super::small(), 512))
}

pub(crate) struct Gauges {
    pub(crate) gauge: Box<Gauge>,
    pub(crate) state: Box<GaugeState>,
    state_size: usize,
}

impl Gauges {
    pub(crate) fn new(file: &[u8], points: usize) -> Self {
        let state_size = if points == 512 { size_of::<GaugeState512>() } else { size_of::<GaugeState>() };
        let (mut gauge, state) = (super::zeroed::<Gauge>(), super::zeroed::<GaugeState>());
        let (bytes, length, size) = (file.as_ptr(), file.len(), size_of::<Gauge>());
        // SAFETY: all pointers and sizes match their types.
        assert_eq!(unsafe { trueaxis_gauge_build(&mut *gauge, size, bytes, length, PERIOD_NS, null_mut()) }, OK);
        let mut gauges = Gauges { gauge, state, state_size };
        gauges.restart();
        gauges
    }

    pub(crate) fn restart(&mut self) {
        // SAFETY: all pointers and sizes match their types.
        assert_eq!(unsafe { trueaxis_gauge_restart(&*self.gauge, &mut *self.state, self.state_size) }, OK);
    }

    /// Readings of a cycle; consecutive cycles are half a point apart.
    pub(crate) fn ride(&mut self, cycle: i32, points: i32) -> GaugeRide {
        let step = COUNTS / points / 2;
        let spindle = cycle * step;
        let index = spindle - spindle.rem_euclid(COUNTS);
        let angle = TAU * f64::from(spindle) / f64::from(COUNTS);
        let reading = |phase: f64| (2.0 * (3.0 * (angle + phase)).cos() + 0.7 * (5.0 * (angle + phase)).sin()) as Real;
        GaugeRide {
            size: size_of::<GaugeRide>() as u32,
            spindle,
            index,
            arm: 0,
            gauge: &raw const *self.gauge,
            state: &raw mut *self.state,
            readings: [reading(0.0), reading(TAU * 44.0 / 256.0), reading(TAU * 101.0 / 256.0)],
            has_index: u8::from(cycle > 0 && spindle - index < step),
            new_part: 0,
            idle: 0,
            finished: 9,
            flags: u16::MAX,
            reserved: [0; 2],
            infeed: 9.0,
        }
    }
}

/// Readings of the C structure as the Rust type.
pub(crate) fn probes(ride: &GaugeRide) -> roundness::Probes<Real> {
    roundness::Probes {
        readings: ride.readings,
        spindle: ride.spindle,
        index: (ride.has_index == 1).then_some(ride.index),
        ..roundness::Probes::default()
    }
}

/// Asserts that the gauge's results are equal in every bit.
pub(crate) fn same_cycle(c: &GaugeRide, rust: &roundness::Cycle<Real>, cycle: usize) {
    assert_eq!(c.infeed.to_bits(), rust.infeed.to_bits(), "cycle {cycle}");
    assert_eq!((c.flags, c.finished), (rust.flags.0, u8::from(rust.finished)), "cycle {cycle}");
}
