//! Readings of three probes on a rotating workpiece that is not being ground.

use std::f64::consts::TAU;
use trueaxis::roundness::GaugeSettings;
use trueaxis_recording::Probe;
use trueaxis_sim::Scenario;
use trueaxis_sim::grinding::{CentreMotion, Noise, Term, Turning, counts, probe_angles, sum};

/// Surface deviation over the angle, µm.
const SURFACE: [Term; 4] = [
    Term { order: 2.0, amplitude: 1.2, phase: 0.3 },
    Term { order: 3.0, amplitude: 0.8, phase: 1.9 },
    Term { order: 7.0, amplitude: 0.4, phase: 0.8 },
    Term { order: 31.0, amplitude: 0.1, phase: 2.5 },
];

/// The rotating workpiece.
pub(super) struct Turned {
    gauge: GaugeSettings,
    phi: [f64; 3],
    motion: CentreMotion,
    turning: Turning,
    noise: Noise,
    turn: i64,
}

impl Turned {
    pub(super) fn new(gauge: &GaugeSettings, scenario: &Scenario, speed_rpm: f64) -> Turned {
        Turned {
            gauge: *gauge,
            phi: probe_angles(gauge),
            motion: CentreMotion::default(),
            turning: Turning::new(-0.3, speed_rpm, scenario.period_s()),
            noise: Noise::new(scenario.settings.seed, 101),
            turn: -1,
        }
    }

    /// Returns the readings of this cycle and advances one period.
    pub(super) fn cycle(&mut self) -> Probe {
        let alpha = self.turning.alpha();
        let [x, y] = self.motion.at(alpha);
        let mut probe = Probe::default();
        for ((reading, phi), settings) in probe.readings.iter_mut().zip(self.phi).zip(&self.gauge.probes) {
            let um = sum(&SURFACE, alpha + phi) + y * phi.cos() + x * phi.sin() + self.noise.next(0.01);
            *reading = (um / settings.gain_um + settings.zero) as f32;
        }
        let spindle = &self.gauge.spindle;
        probe.spindle = counts(alpha, spindle.counts, spindle.direction);
        let turn = (alpha / TAU).floor() as i64;
        if turn != self.turn {
            probe.index = Some((turn * i64::from(spindle.counts) * i64::from(spindle.direction)) as i32);
            self.turn = turn;
        }
        self.turning.cycle(true);
        probe
    }
}
