//! The gauge of a run, whose number of points is not part of its type.

use crate::error::{Result, SimError};
use trueaxis::roundness::{Counts, Cycle, Evaluation, Gauge, GaugeSettings, GaugeState, Probes};
use trueaxis::{ConfigError, GaugeRide, Ride};

/// A gauge with its state.
pub(super) trait Gauging {
    /// Sets the wheel's radius R_S, mm.
    fn set_wheel(&mut self, wheel_mm: f64) -> Result<(), ConfigError>;
    /// Runs the gauge with one call of `step`; returns its output in that cycle.
    fn run_with(&mut self, probes: &Probes<f64>, step: &mut dyn FnMut(&mut dyn Ride<f64>)) -> Cycle<f64>;
    fn cycles_of_work(&self) -> usize;
    fn latest(&self) -> Option<Evaluation<f64>>;
    fn counts(&self) -> Counts;
    fn harmonic(&self, harmonic: usize) -> [f64; 2];
    fn motion(&self) -> [&[f64]; 2];
    fn correction(&self) -> &[f64];
}

/// The gauge of a machine.
///
/// # Errors
/// The settings do not build, or the number of points is not a power of two from 64 to 4096.
pub(super) fn gauging(settings: &GaugeSettings, period_ns: u32) -> Result<Box<dyn Gauging + Send>> {
    match settings.points {
        64 => of::<64>(settings, period_ns),
        128 => of::<128>(settings, period_ns),
        256 => of::<256>(settings, period_ns),
        512 => of::<512>(settings, period_ns),
        1024 => of::<1024>(settings, period_ns),
        2048 => of::<2048>(settings, period_ns),
        4096 => of::<4096>(settings, period_ns),
        other => Err(SimError::unsuited("[roundness] points", other.to_string(), "a power of two from 64 to 4096")),
    }
}

fn of<const POINTS: usize>(settings: &GaugeSettings, period_ns: u32) -> Result<Box<dyn Gauging + Send>> {
    let gauge: Box<Gauge<f64, POINTS>> = Box::new(Gauge::build(settings, period_ns).map_err(SimError::Gauge)?);
    let state = Box::new(gauge.start());
    Ok(Box::new(Started { gauge, state }))
}

struct Started<const POINTS: usize> {
    gauge: Box<Gauge<f64, POINTS>>,
    state: Box<GaugeState<f64, POINTS>>,
}

impl<const POINTS: usize> Gauging for Started<POINTS> {
    fn set_wheel(&mut self, wheel_mm: f64) -> Result<(), ConfigError> {
        self.gauge.set_wheel(&mut self.state, wheel_mm)
    }

    fn run_with(&mut self, probes: &Probes<f64>, step: &mut dyn FnMut(&mut dyn Ride<f64>)) -> Cycle<f64> {
        let mut ride = GaugeRide::new(&self.gauge, &mut self.state, probes);
        step(&mut &mut ride);
        ride.cycle()
    }

    fn cycles_of_work(&self) -> usize {
        self.gauge.cycles_of_work()
    }

    fn latest(&self) -> Option<Evaluation<f64>> {
        self.state.latest()
    }

    fn counts(&self) -> Counts {
        self.state.counts()
    }

    fn harmonic(&self, harmonic: usize) -> [f64; 2] {
        self.state.harmonic(harmonic)
    }

    fn motion(&self) -> [&[f64]; 2] {
        self.state.motion().map(|motion| motion.as_slice())
    }

    fn correction(&self) -> &[f64] {
        self.state.correction()
    }
}
