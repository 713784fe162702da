//! Times the steps of one machine of a run.

use crate::latency::Latency;
use std::time::Instant;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{Given, Moment, Sample, Sink};

/// A sink that records the duration of each step of a machine; settling is excluded.
#[derive(Debug)]
pub struct Stopwatch {
    /// The recorded times.
    pub latency: Latency,
    machine: usize,
    started: Option<Instant>,
}

impl Stopwatch {
    /// Times the machine with that index in a run of `scenario`; a step may take `budget_ns`.
    pub fn new(machine: usize, scenario: &Scenario, budget_ns: u64) -> Stopwatch {
        let latency = Latency::new(budget_ns, scenario.period_ns().into());
        Stopwatch { latency, machine, started: None }
    }
}

impl Sink for Stopwatch {
    fn cycle(&mut self, _moment: &Moment, _machines: &[Option<&Sample>]) {}

    fn before_step(&mut self, given: &Given<'_>) {
        self.started = (given.machine == self.machine && !given.settling).then(Instant::now);
    }

    fn after_step(&mut self) {
        if let Some(started) = self.started.take() {
            self.latency.record(started.elapsed().as_nanos() as u64);
        }
    }
}
