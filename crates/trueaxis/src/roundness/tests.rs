use super::*;
use std::boxed::Box;
use std::f64::consts::TAU;
use std::vec::Vec;

/// A workpiece and a spindle as sums of harmonics, evaluated directly.
struct Truth {
    /// (k, amplitude µm, phase rad) over θ.
    profile: Vec<(f64, f64, f64)>,
    /// The same of R_X and R_Y, over α; k need not be whole (asynchronous motion).
    motion: [Vec<(f64, f64, f64)>; 2],
    ratio: f64,
    phi: [f64; 3],
}

fn series(terms: &[(f64, f64, f64)], angle: f64) -> f64 {
    terms.iter().map(|(k, amplitude, phase)| amplitude * (k * angle + phase).cos()).sum()
}

impl Truth {
    fn new(settings: &RoundnessSettings, highest: u16) -> Self {
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

fn counts(angle: f64, per_turn: u32) -> i32 {
    ((angle / TAU * f64::from(per_turn)).round() as i64) as i32
}

/// The angles that the encoders report: whole counts.
fn probes(truth: &Truth, alpha: f64, before: f64) -> Probes<f64> {
    let spindle = counts(alpha, COUNTS);
    let alpha = f64::from(spindle) / f64::from(COUNTS) * TAU;
    let crossed = (alpha / TAU).floor() != (before / TAU).floor();
    Probes {
        readings: truth.readings(alpha),
        spindle,
        index: crossed.then(|| counts((alpha / TAU).floor() * TAU, COUNTS)),
        arm: counts(truth.beta(alpha), ARM_COUNTS),
        new_part: false,
    }
}

fn settings(points: u16, angles: ProbeAngles, arm: bool) -> RoundnessSettings {
    let mut settings = RoundnessSettings::with_defaults(points, angles, COUNTS);
    settings.band.last = 50;
    if arm {
        settings.arm = Some(ArmSettings {
            lengths: Arm { crank_mm: 45.0, wheel_mm: 300.0, pin_mm: 27.5 },
            counts: ARM_COUNTS,
            direction: 1,
            tolerance_deg: 0.5,
        });
    }
    settings
}

struct Run<R, const N: usize> {
    gauge: Roundness<R, N>,
    state: Box<RoundnessState<R, N>>,
    alpha: f64,
    seen: Flags,
    evaluations: Vec<Evaluation<R>>,
}

impl<R: Real, const N: usize> Run<R, N> {
    fn new(settings: &RoundnessSettings) -> Self {
        let gauge = Roundness::build(settings, 100_000).unwrap();
        let state = Box::new(gauge.start());
        Run { gauge, state, alpha: -0.3, seen: Flags::default(), evaluations: Vec::new() }
    }

    fn cycle(&mut self, probes: &Probes<f64>) -> Cycle<R> {
        let probes = Probes {
            readings: probes.readings.map(R::of),
            spindle: probes.spindle,
            index: probes.index,
            arm: probes.arm,
            new_part: probes.new_part,
        };
        let cycle = self.gauge.update(&mut self.state, &probes, false);
        self.seen.set(cycle.flags);
        if cycle.finished {
            self.evaluations.push(*self.state.latest().unwrap());
        }
        cycle
    }

    /// Turns by some revolutions; `speed` gives the step of α at α, rad.
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

/// Separation from time samples: eight or more to a point, whole and broken angles, arm still and following.
fn separates<const N: usize>(angles: ProbeAngles, arm: bool, noise_gain: f64) {
    let settings = settings(N as u16, angles, arm);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, N>::new(&settings);
    run.turn(&truth, 3.95, |_| TAU / (N as f64 * 9.3));
    assert_eq!(run.state.latest().unwrap().revolution, 2, "{angles:?}");
    assert!(run.state.is_settled());
    let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
    std::println!("N {N} {angles:?} arm {arm}: profile {profile:.1e} um, motion {motion:.1e} um");
    assert!(profile < 1e-3 && motion < 1e-3, "{angles:?} {arm}: {profile:e} {motion:e}");
    // The parabola is worth more than that where the probes see well.
    assert!(profile < 3e-5 * noise_gain && motion < 3e-5 * noise_gain, "{angles:?} {arm}: {profile:e} {motion:e}");
    for (k, amplitude, phase) in &truth.profile {
        let [a, b] = run.state.harmonics()[*k as usize];
        assert!((a - amplitude * phase.cos()).abs() < 1e-4, "{k}");
        assert!((b + amplitude * phase.sin()).abs() < 1e-4, "{k}");
    }
}

#[test]
fn separates_within_a_nanometre_from_time_samples() {
    for arm in [false, true] {
        separates::<1024>(BEST_1024, arm, 3.2);
        separates::<512>(BEST_512, arm, 3.4);
        for (phi2, phi3) in [(90.0, 181.05), (60.82, 240.12)] {
            separates::<1024>(ProbeAngles::Degrees { phi2, phi3 }, arm, 20.0);
            separates::<512>(ProbeAngles::Degrees { phi2, phi3 }, arm, 20.0);
        }
        separates::<1024>(ProbeAngles::Degrees { phi2: 66.1, phi3: 234.47 }, arm, 3.5);
    }
}
