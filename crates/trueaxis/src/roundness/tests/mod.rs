//! Shared by the tests of the gauge: a workpiece, its probes, a run.

mod edges;
mod faults;
mod infeed;
mod sampling;
mod separation;
mod spindle;

use super::*;
use crate::real::Real;
use crate::testing::machine::ARM;
use std::boxed::Box;
use std::f64::consts::TAU;
use std::vec::Vec;

/// A workpiece and a spindle as sums of harmonics, evaluated directly.
struct Truth {
    /// (k, amplitude µm, phase rad) over θ.
    profile: Vec<(f64, f64, f64)>,
    /// (k, amplitude µm, phase rad) of R_X and R_Y, over α; k need not be whole (asynchronous motion).
    motion: [Vec<(f64, f64, f64)>; 2],
    ratio: f64,
    phi: [f64; 3],
}

fn series(terms: &[(f64, f64, f64)], angle: f64) -> f64 {
    terms.iter().map(|(k, amplitude, phase)| amplitude * (k * angle + phase).cos()).sum()
}

impl Truth {
    fn new(settings: &GaugeSettings, highest: u16) -> Self {
        let gain = settings.check().unwrap();
        let profile = (2..=highest).map(|k| {
            let k = f64::from(k);
            (k, 1.5 / k.sqrt() * (1.0 + 0.5 * (k * 1.7).sin()), k * k * 0.37)
        });
        Truth {
            profile: profile.collect(),
            motion: [
                std::vec![(1.0, 20.0, 0.4), (2.0, 0.7, 1.0), (3.0, 0.3, 2.0), (11.0, 0.1, 0.1)],
                std::vec![(1.0, 15.0, 1.4), (2.0, 0.4, 0.3), (5.0, 0.2, 1.0)],
            ],
            ratio: settings.arm.map_or(0.0, |arm| arm.lengths.ratio().unwrap()),
            phi: [0.0, gain.phi2(), gain.phi2() + gain.phi3()],
        }
    }

    fn beta(&self, alpha: f64) -> f64 {
        (self.ratio * alpha.sin()).asin()
    }

    fn motion(&self, alpha: f64) -> [f64; 2] {
        [series(&self.motion[0], alpha), series(&self.motion[1], alpha)]
    }

    /// Readings at a spindle angle, rad over all turns.
    fn readings(&self, alpha: f64) -> [f64; 3] {
        let beta = self.beta(alpha);
        let [x, y] = self.motion(alpha);
        self.phi.map(|phi| series(&self.profile, alpha + beta + phi) + y * (phi + beta).cos() + x * (phi + beta).sin())
    }

    /// α at a θ of the first turn, by fixed-point iteration of θ = α + β(α).
    fn alpha(&self, theta: f64) -> f64 {
        (0..60).fold(theta, |alpha, _| theta - self.beta(alpha))
    }
}

const COUNTS: u32 = 1 << 26;

const ARM_COUNTS: u32 = 1 << 27;

/// Whole counts; the encoder's counter wraps at 32 bits.
fn counts(angle: f64, per_turn: u32) -> i64 {
    (angle / TAU * f64::from(per_turn)).round() as i64
}

/// The angles that the encoders report: whole counts.
fn probes(truth: &Truth, alpha: f64, before: f64) -> Probes<f64> {
    let spindle = counts(alpha, COUNTS);
    let alpha = spindle as f64 / f64::from(COUNTS) * TAU;
    let crossed = (alpha / TAU).floor() != (before / TAU).floor();
    Probes {
        readings: truth.readings(alpha),
        spindle: spindle as i32,
        index: crossed.then(|| counts((alpha / TAU).floor() * TAU, COUNTS) as i32),
        arm: counts(truth.beta(alpha), ARM_COUNTS) as i32,
        new_part: false,
        idle: false,
    }
}

fn settings(points: u16, angles: ProbeAngles, arm: bool) -> GaugeSettings {
    let mut settings = GaugeSettings::with_defaults(points, angles, COUNTS);
    settings.band.last = 50;
    if arm {
        settings.arm = Some(ArmSettings { lengths: ARM, counts: ARM_COUNTS, direction: 1, tolerance_deg: 0.5 });
    }
    settings
}

struct Run<R, const N: usize> {
    gauge: Gauge<R, N>,
    state: Box<GaugeState<R, N>>,
    alpha: f64,
    seen: GaugeFlags,
    evaluations: Vec<Evaluation<R>>,
}

impl<R: Real, const N: usize> Run<R, N> {
    fn new(settings: &GaugeSettings) -> Self {
        let gauge = Gauge::build(settings, 100_000).unwrap();
        let state = Box::new(gauge.start());
        Run { gauge, state, alpha: -0.3, seen: GaugeFlags::default(), evaluations: Vec::new() }
    }

    fn cycle(&mut self, probes: &Probes<f64>) -> Cycle<R> {
        let probes = Probes {
            readings: probes.readings.map(R::of),
            spindle: probes.spindle,
            index: probes.index,
            arm: probes.arm,
            new_part: probes.new_part,
            idle: probes.idle,
        };
        let cycle = self.gauge.update(&mut self.state, &probes, Followed::Whole);
        self.seen.set(cycle.flags);
        if cycle.finished {
            self.evaluations.push(self.state.latest().unwrap());
        }
        cycle
    }

    /// Turns by the given number of revolutions; `speed` returns the step of α at α, rad.
    fn turn(&mut self, truth: &Truth, revolutions: f64, speed: impl Fn(f64) -> f64) {
        let end = self.alpha + revolutions * TAU;
        while self.alpha < end {
            let before = self.alpha;
            self.alpha += speed(self.alpha);
            let probes = probes(truth, self.alpha, before);
            self.cycle(&probes);
        }
    }

    fn profile_error(&self, truth: &Truth) -> f64 {
        let theta = |n: usize| TAU * n as f64 / N as f64;
        let error = |(n, r): (usize, &R)| (r.to_f64() - series(&truth.profile, theta(n))).abs();
        self.state.profile().iter().enumerate().map(error).fold(0.0, f64::max)
    }

    fn motion_error(&self, truth: &Truth) -> f64 {
        let [x, y] = self.state.motion();
        let mut worst = 0.0_f64;
        for n in 0..N {
            let [tx, ty] = truth.motion(truth.alpha(TAU * n as f64 / N as f64));
            worst = worst.max((x[n].to_f64() - tx).abs()).max((y[n].to_f64() - ty).abs());
        }
        worst
    }
}

const BEST_1024: ProbeAngles = ProbeAngles::Slots { p: 188, q: 667 };

const BEST_512: ProbeAngles = ProbeAngles::Slots { p: 155, q: 172 };

/// A small gauge for testing faults: 64 points, harmonics up to 12.
fn small() -> (GaugeSettings, Truth) {
    let mut settings = GaugeSettings::with_defaults(64, ProbeAngles::Slots { p: 11, q: 15 }, COUNTS);
    settings.band.last = 12;
    settings.stop_s = 0.05;
    let truth = Truth::new(&settings, 12);
    (settings, truth)
}
