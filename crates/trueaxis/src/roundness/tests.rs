use super::*;
use crate::error::Field;
use crate::real::Real;
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
        let [a, b] = run.state.harmonic(*k as usize);
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

#[test]
fn single_precision_separates_to_ten_nanometres() {
    let settings = settings(1024, BEST_1024, true);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f32, 1024>::new(&settings);
    run.turn(&truth, 3.95, |_| TAU / 9500.0);
    let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
    std::println!("f32: profile {profile:.1e} um, motion {motion:.1e} um");
    assert!(profile < 1e-4 && motion < 1e-4, "{profile:e} {motion:e}");
}

#[test]
fn a_changing_speed_is_flagged_and_costs_nothing() {
    let settings = settings(512, BEST_512, false);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    // From 8 to 24 cycles a point within every turn.
    run.turn(&truth, 3.95, |alpha| TAU / 512.0 / (16.0 + 8.0 * alpha.sin()));
    assert!(run.state.latest().unwrap().flags.has(GaugeFlags::SPEED));
    let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
    assert!(profile < 5e-5 && motion < 5e-5, "{profile:e} {motion:e}");
    let mut steady = Run::<f64, 512>::new(&settings);
    steady.turn(&truth, 3.95, |_| TAU / 5000.0);
    assert!(steady.state.latest().unwrap().flags.is_empty());
}

/// A small gauge on which faults are tried: 64 points, harmonics up to 12.
fn small() -> (GaugeSettings, Truth) {
    let mut settings = GaugeSettings::with_defaults(64, ProbeAngles::Slots { p: 11, q: 15 }, COUNTS);
    settings.band.last = 12;
    settings.stop_s = 0.05;
    let truth = Truth::new(&settings, 12);
    (settings, truth)
}

/// Disturbs the cycles of a quarter turn in the third revolution; returns flags of that revolution and the counts after.
fn disturbed(disturb: impl Fn(&mut Probes<f64>)) -> (GaugeFlags, Counts, Run<f64, 64>) {
    let (settings, truth) = small();
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 3.3, |_| TAU / 1000.0);
    assert_eq!(run.state.counts(), Counts { sampled: 2, evaluated: 2, skipped: 0, discarded: 0 });
    assert_eq!(run.seen, GaugeFlags::NO_INDEX);
    run.seen = GaugeFlags::default();
    for _ in 0..250 {
        let before = run.alpha;
        run.alpha += TAU / 1000.0;
        let mut probes = probes(&truth, run.alpha, before);
        disturb(&mut probes);
        run.cycle(&probes);
    }
    let seen = run.seen;
    run.turn(&truth, 4.4, |_| TAU / 1000.0);
    assert!(run.profile_error(&truth) < 1e-3, "{:e}", run.profile_error(&truth));
    let counts = run.state.counts();
    (seen, counts, run)
}

#[test]
fn a_probe_that_is_not_believed_costs_one_whole_revolution() {
    for bad in [f64::NAN, f64::INFINITY, -1000.5, 1e300] {
        for probe in 0..3 {
            let (seen, counts, _) = disturbed(|probes| probes.readings[probe] = bad);
            assert_eq!(seen, GaugeFlags::PROBE_RANGE);
            assert_eq!((counts.discarded, counts.skipped), (1, 0), "{bad}");
            assert_eq!((counts.sampled, counts.evaluated), (5, 5));
        }
    }
}

#[test]
fn a_jump_of_the_count_costs_the_revolution_and_waits_for_the_index() {
    let (seen, counts, _) = disturbed(|probes| probes.spindle = probes.spindle.wrapping_add(1 << 30));
    assert!(seen.has(GaugeFlags::SPINDLE_JUMP) && seen.has(GaugeFlags::NO_INDEX));
    assert_eq!(counts.discarded, 1);
    assert_eq!(counts.evaluated, 4, "one more passes until zero is known again");
}

#[test]
fn a_missing_index_is_flagged_and_waited_for() {
    let (settings, truth) = small();
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 3.3, |_| TAU / 1000.0);
    run.seen = GaugeFlags::default();
    let end = run.alpha + 1.5 * TAU;
    while run.alpha < end {
        let before = run.alpha;
        run.alpha += TAU / 1000.0;
        let without = Probes { index: None, ..probes(&truth, run.alpha, before) };
        run.cycle(&without);
    }
    assert!(run.seen.has(GaugeFlags::INDEX_MISSING));
    let before = run.state.counts().evaluated;
    run.turn(&truth, 3.5, |_| TAU / 1000.0);
    assert!(run.state.counts().evaluated > before);
    assert!(run.profile_error(&truth) < 1e-3);
}

#[test]
fn a_stop_in_mid_revolution_discards_it() {
    let (settings, truth) = small();
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 3.3, |_| TAU / 1000.0);
    run.seen = GaugeFlags::default();
    for _ in 0..2000 {
        run.cycle(&probes(&truth, run.alpha, run.alpha));
    }
    assert_eq!(run.seen, GaugeFlags::STOPPED);
    let counts = run.state.counts();
    assert_eq!((counts.sampled, counts.discarded), (2, 1));
    run.turn(&truth, 2.4, |_| TAU / 1000.0);
    assert_eq!(run.state.counts().sampled, 3, "the rest of the revolution is not taken for a whole one");
    assert!(run.profile_error(&truth) < 1e-3);
}

#[test]
fn turning_back_discards_the_revolution_and_jitter_does_not() {
    let (settings, truth) = small();
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 3.3, |_| TAU / 1000.0);
    run.seen = GaugeFlags::default();
    // Standing on a count that flickers: half a slot forth and back.
    for i in 0..100 {
        let flicker = if i % 2 == 0 { 0.04 } else { 0.0 };
        run.cycle(&probes(&truth, run.alpha + flicker, run.alpha));
    }
    assert_eq!((run.seen, run.state.counts().discarded), (GaugeFlags::default(), 0));
    for _ in 0..200 {
        run.alpha -= TAU / 1000.0;
        run.cycle(&probes(&truth, run.alpha, run.alpha));
    }
    assert_eq!(run.seen, GaugeFlags::REVERSED);
    assert_eq!(run.state.counts().discarded, 1);
    run.turn(&truth, 3.5, |_| TAU / 1000.0);
    assert!(run.profile_error(&truth) < 1e-3);
}

#[test]
fn too_fast_a_spindle_is_flagged() {
    let (settings, truth) = small();
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 3.3, |_| TAU / 1000.0);
    run.seen = GaugeFlags::default();
    run.turn(&truth, 5.0, |_| TAU / 24.0);
    assert!(run.seen.has(GaugeFlags::TOO_FAST));
    assert_eq!(run.state.counts().sampled, 2);
    run.turn(&truth, 4.5, |_| TAU / 1000.0);
    assert!(run.profile_error(&truth) < 1e-3);
}

#[test]
fn revolutions_shorter_than_the_work_are_skipped_whole() {
    let (mut settings, truth) = small();
    // Every revolution is the same amount of work.
    settings.revolutions = 1;
    let mut run = Run::<f64, 64>::new(&settings);
    let work = run.gauge.cycles_of_work();
    for (cycles, kept) in [(work as f64 + 8.0, 1), (work as f64 * 0.7, 2), (work as f64 * 0.4, 3)] {
        run.turn(&truth, 2.0, |_| TAU / cycles);
        let before = run.state.counts();
        run.turn(&truth, 24.0, |_| TAU / cycles);
        let after = run.state.counts();
        let sampled = after.sampled - before.sampled;
        let evaluated = after.evaluated - before.evaluated;
        assert!(sampled >= 23, "{sampled} of {cycles}: {before:?} {after:?} {:?}", run.seen);
        assert!(evaluated.abs_diff(sampled / kept) <= 1, "{evaluated} of {sampled}, one in {kept}");
        assert!((after.skipped - before.skipped).abs_diff(sampled - evaluated) <= 1);
        assert_eq!(run.seen.has(GaugeFlags::SKIPPED), kept > 1);
        assert_eq!(run.state.latest().unwrap().flags.has(GaugeFlags::SKIPPED), kept > 1);
        assert_eq!(after.discarded, 0);
        assert!(run.profile_error(&truth) < 0.05, "{:e}", run.profile_error(&truth));
    }
    // Slower again, nothing of it is left.
    run.turn(&truth, 4.0, |_| TAU / (work as f64 + 8.0));
    assert!(run.state.latest().unwrap().flags.is_empty(), "{:?}", run.state.latest().unwrap().flags);
}

#[test]
fn the_arm_is_compared_with_the_linkage() {
    let mut settings = settings(512, BEST_512, true);
    settings.infeed = None;
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    run.turn(&truth, 2.95, |_| TAU / 6000.0);
    assert!(!run.state.latest().unwrap().flags.has(GaugeFlags::ARM));
    // A wheel dressed down by 30 mm: β is off by up to 0.8°.
    run.gauge.set_wheel(&mut run.state, 270.0).unwrap();
    run.turn(&truth, 2.0, |_| TAU / 6000.0);
    assert!(run.state.latest().unwrap().flags.has(GaugeFlags::ARM));
    run.gauge.set_wheel(&mut run.state, 300.0).unwrap();
    run.turn(&truth, 2.0, |_| TAU / 6000.0);
    assert!(!run.state.latest().unwrap().flags.has(GaugeFlags::ARM));
    assert!(run.gauge.set_wheel(&mut run.state, 17.0).is_err(), "R >= R_S + R_W");
    assert!(run.gauge.set_wheel(&mut run.state, f64::NAN).is_err());
    let still = Gauge::<f64, 64>::build(&small().0, 100_000).unwrap();
    assert!(still.set_wheel(&mut still.start(), 300.0).is_err(), "no arm");
}

#[test]
fn the_spindle_is_told_apart_over_the_window() {
    let (mut settings, mut truth) = small();
    settings.revolutions = 4;
    // Synchronous 2 and 3, eccentricity, and a motion that repeats every four revolutions: ±0.25 µm of amplitude.
    truth.motion =
        [std::vec![(1.0, 20.0, 0.4), (2.0, 0.7, 1.0), (0.25, 0.25, 0.0)], std::vec![(1.0, 15.0, 1.4), (3.0, 0.4, 0.3)]];
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 6.9, |_| TAU / 2000.0);
    let found = run.state.latest().unwrap();
    assert_eq!(found.revolutions, 4);
    assert!((found.x.synchronous_um - 1.4).abs() < 0.01, "{:?}", found.x);
    assert!((found.y.synchronous_um - 0.8).abs() < 0.01, "{:?}", found.y);
    let amplitude = |[a, b]: [f64; 2]| a.hypot(b);
    assert!((amplitude(found.x.once_per_revolution_um) - 20.0).abs() < 0.01);
    assert!((amplitude(found.y.once_per_revolution_um) - 15.0).abs() < 0.01);
    let [a, b] = found.y.once_per_revolution_um;
    assert!(((-b).atan2(a) - 1.4).abs() < 1e-3, "phase");
    // Four phases a quarter turn apart: the widest pair is 0.25·2 apart where one of them stands at its crest.
    assert!((found.x.asynchronous_um - 0.5).abs() < 0.005, "{:?}", found.x);
    assert!(found.y.asynchronous_um < 1e-3);
    assert!((found.x.total_um - found.x.synchronous_um) > 0.3 && found.x.total_um < 1.9 + 0.01);
}

#[test]
fn peak_to_valley_is_that_of_the_filtered_profile() {
    for (filter, transmission) in [(None, 1.0), (Some(15), 0.5_f64)] {
        let mut settings = settings(512, BEST_512, false);
        settings.filter = filter;
        let mut truth = Truth::new(&settings, 50);
        truth.profile = std::vec![(15.0, 1.0, 0.3)];
        let mut run = Run::<f64, 512>::new(&settings);
        run.turn(&truth, 2.95, |_| TAU / 6000.0);
        // 512 points do not meet every crest of fifteen waves exactly.
        let found = run.state.latest().unwrap().peak_to_valley_um;
        assert!((found - 2.0 * transmission).abs() < 4e-3, "{filter:?} {found}");
        assert!((run.state.profile()[0] - 0.3_f64.cos()).abs() < 1e-4, "the profile itself is not filtered");
    }
}

#[test]
fn blind_harmonics_are_suppressed_and_blind_bands_refused() {
    let close = ProbeAngles::Degrees { phi2: 90.0, phi3: 135.02 };
    let mut settings = settings(512, close, false);
    settings.noise_gain_limit = 30.0;
    let gauge = Gauge::<f64, 512>::build(&settings, 100_000).unwrap();
    let suppressed: Vec<usize> = (2..=50).filter(|k| gauge.is_suppressed(*k)).collect();
    assert!(suppressed.contains(&7) && suppressed.contains(&9) && suppressed.len() < 14, "{suppressed:?}");
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    run.turn(&truth, 2.95, |_| TAU / 6000.0);
    for k in 2..=50 {
        assert_eq!(run.state.harmonic(k) == [0.0; 2], suppressed.contains(&k), "{k}");
    }
    settings.angles = ProbeAngles::Degrees { phi2: 90.0, phi3: 135.0 };
    let error = Gauge::<f64, 512>::build(&settings, 100_000).unwrap_err();
    assert_eq!((error.field, error.found), (Field::ProbeAngles, 7.0));
    settings.angles = BEST_512;
    assert!(Gauge::<f64, 1024>::build(&settings, 100_000).is_err(), "another capacity");
    assert!(Gauge::<f64, 512>::build(&settings, 10).is_err(), "period");
}

/// A plant of one line: what is measured in a revolution was ground in the one before, d − c.
struct Grinding {
    settings: GaugeSettings,
    contact: f64,
}

impl Grinding {
    fn new(gain: f64) -> Self {
        let mut settings = GaugeSettings::with_defaults(256, ProbeAngles::Slots { p: 44, q: 57 }, COUNTS);
        settings.band.last = 40;
        settings.infeed = Some(InfeedSettings {
            axis: crate::Axis::X,
            direction: -1,
            band: Band { first: 2, last: 30 },
            gain,
            delay_revolutions: 2,
            contact_deg: 170.0,
            drive_delay_s: 0.0,
            limit_um: 5.0,
            noise_gain_limit: 10.0,
        });
        Grinding { settings, contact: 170.0_f64.to_radians() }
    }

    fn run(&self) -> (Run<f64, 256>, Truth) {
        let mut truth = Truth::new(&self.settings, 30);
        truth.profile = std::vec![(2.0, 1.0, 0.3), (7.0, 0.5, 1.0), (30.0, 0.2, 2.0)];
        (Run::new(&self.settings), truth)
    }
}

#[test]
fn the_infeed_is_the_profile_at_the_contact() {
    let grinding = Grinding::new(0.25);
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 3.95, |_| TAU / 5000.0);
    // One update: c = g r, sent with the sign of the axis, mm.
    let mut worst = 0.0_f64;
    for _ in 0..240 {
        let before = run.alpha;
        run.alpha += TAU / 5000.0;
        let cycle = run.cycle(&probes(&truth, run.alpha, before));
        let wanted = -0.25e-3 * series(&truth.profile, run.alpha + grinding.contact);
        worst = worst.max((cycle.infeed - wanted).abs());
    }
    // The cubic between points carries harmonic 30 of 256 within 7e-3 of its amplitude, 0.05 µm.
    assert!(worst < 4e-7, "{worst:e} mm");
}

#[test]
fn the_drive_s_delay_is_led_by() {
    let mut grinding = Grinding::new(0.25);
    grinding.settings.infeed.as_mut().unwrap().drive_delay_s = 0.01;
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 3.9, |_| TAU / 5000.0);
    let before = run.alpha;
    run.alpha += TAU / 5000.0;
    let cycle = run.cycle(&probes(&truth, run.alpha, before));
    // A hundred cycles ahead.
    let wanted = -0.25e-3 * series(&truth.profile, run.alpha + grinding.contact + TAU * 100.0 / 5000.0);
    assert!((cycle.infeed - wanted).abs() < 3e-7, "{:e} {wanted:e}", cycle.infeed);
}

#[test]
fn the_law_integrates_until_its_bound_and_is_reset_by_a_new_part() {
    let grinding = Grinding::new(0.25);
    let (mut run, truth) = grinding.run();
    // A surface that never changes: the sum grows by g r a revolution, and stops below 5 µm.
    run.turn(&truth, 30.0, |_| TAU / 5000.0);
    let peak = |state: &GaugeState<f64, 256>| state.correction().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let profile = (0..256).map(|n| series(&truth.profile, TAU * n as f64 / 256.0).abs()).fold(0.0, f64::max);
    let found = peak(&run.state);
    assert!(found <= 5.0 && found > 5.0 - 0.25 * profile - 1e-3, "{found}");
    assert!(run.state.latest().unwrap().flags.has(GaugeFlags::INFEED_FROZEN));
    let before = run.alpha;
    run.alpha += TAU / 5000.0;
    let renewed = Probes { new_part: true, ..probes(&truth, run.alpha, before) };
    assert_eq!(run.cycle(&renewed).infeed, 0.0);
    run.turn(&truth, 0.2, |_| TAU / 5000.0);
    assert_eq!(peak(&run.state), 0.0);
    run.turn(&truth, 3.0, |_| TAU / 5000.0);
    assert!(peak(&run.state) > 0.1, "goes on");
}

#[test]
fn while_the_axis_is_limited_the_correction_is_frozen_and_then_gives_way() {
    let grinding = Grinding::new(0.25);
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 3.95, |_| TAU / 5000.0);
    let limited = |run: &mut Run<f64, 256>, revolutions: f64| {
        let end = run.alpha + revolutions * TAU;
        while run.alpha < end {
            let last = run.alpha;
            run.alpha += TAU / 5000.0;
            let probes = probes(&truth, run.alpha, last);
            run.gauge.update(&mut run.state, &probes, Followed::Limited);
        }
    };
    // The revolution that was limited to its end is the first that does not count.
    limited(&mut run, 2.0);
    assert!(run.state.latest().unwrap().flags.has(GaugeFlags::INFEED_FROZEN));
    let frozen = *run.state.correction();
    limited(&mut run, 1.0);
    assert!(frozen == *run.state.correction(), "frozen");
    limited(&mut run, 1.0);
    assert!(run.state.latest().unwrap().flags.has(GaugeFlags::INFEED_REDUCED));
    for (now, before) in run.state.correction().iter().zip(&frozen) {
        assert!((now - 0.75 * before).abs() < 1e-12, "{now} {before}");
    }
    // Free again, it goes on.
    run.turn(&truth, 3.0, |_| TAU / 5000.0);
    assert!(run.state.latest().unwrap().flags.is_empty());
}

/// A radius that shrinks is no profile, and a radius that is not zero no motion, with the arm as without.
#[test]
fn size_and_its_change_enter_neither_profile_nor_motion() {
    for arm in [false, true] {
        let settings = settings(512, BEST_512, arm);
        let truth = Truth::new(&settings, 50);
        let mut run = Run::<f64, 512>::new(&settings);
        let end = run.alpha + 4.95 * TAU;
        while run.alpha < end {
            let before = run.alpha;
            run.alpha += TAU / 6000.0;
            let mut probes = probes(&truth, run.alpha, before);
            let theta = run.alpha + truth.beta(run.alpha);
            probes.readings = probes.readings.map(|h| h + 30.0 - 2.0 * theta / TAU);
            run.cycle(&probes);
        }
        let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
        assert!(profile < 1e-4 && motion < 1e-4, "{arm} {profile:e} {motion:e}");
    }
}

#[test]
fn harmonics_that_the_probes_see_badly_are_measured_but_not_corrected() {
    let mut grinding = Grinding::new(0.25);
    let (mut all, truth) = grinding.run();
    all.turn(&truth, 3.95, |_| TAU / 5000.0);
    let gain = *all.gauge.gain();
    let limit = gain.noise_gain(7) * 1.001;
    assert!(gain.noise_gain(2) > limit || gain.noise_gain(30) > limit, "the case distinguishes");
    grinding.settings.infeed.as_mut().unwrap().noise_gain_limit = limit;
    let (mut some, truth) = grinding.run();
    some.turn(&truth, 3.95, |_| TAU / 5000.0);
    let kept: Vec<_> = truth.profile.iter().copied().filter(|(k, ..)| gain.noise_gain(*k as usize) <= limit).collect();
    for (n, c) in some.state.correction().iter().enumerate() {
        assert!((c - 0.25 * series(&kept, TAU * n as f64 / 256.0)).abs() < 1e-3);
    }
    assert!(some.profile_error(&truth) < 1e-3, "measured all the same");
}

/// While pulses are missing nothing is measured, but the correction stays where the count says.
#[test]
fn a_missing_index_does_not_drop_the_correction() {
    let grinding = Grinding::new(0.25);
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 2.95, |_| TAU / 5000.0);
    let (mut worst, mut overdue) = (0.0_f64, false);
    let table = series(&truth.profile, 0.0);
    assert!(table.abs() > 0.1);
    let counts = run.state.counts().evaluated;
    let end = run.alpha + 3.0 * TAU;
    while run.alpha < end {
        let before = run.alpha;
        run.alpha += TAU / 5000.0;
        let probes = Probes { index: None, ..probes(&truth, run.alpha, before) };
        let cycle = run.cycle(&probes);
        if cycle.flags.has(GaugeFlags::NO_INDEX) && run.state.is_settled() {
            overdue = true;
            let n = run.state.correction().len() as f64;
            let place = ((run.alpha + grinding.contact) / TAU).rem_euclid(1.0) * n;
            let near = run.state.correction()[place.round() as usize % 256];
            worst = worst.max((cycle.infeed + 1e-3 * near).abs());
        }
    }
    assert!(overdue && run.seen.has(GaugeFlags::INDEX_MISSING));
    assert!(run.state.counts().evaluated <= counts + 2, "nothing was measured");
    // Half a point off at most: the steepest of harmonic 30.
    assert!(worst < 1e-4, "{worst:e}");
    assert!(run.state.correction().iter().any(|c| c.abs() > 0.2));
}

/// Turns; `change` sets the input of every cycle.
fn turned(run: &mut Run<f64, 256>, truth: &Truth, revolutions: f64, change: impl Fn(&mut Probes<f64>) -> Followed) {
    let end = run.alpha + revolutions * TAU;
    while run.alpha < end {
        let last = run.alpha;
        run.alpha += TAU / 5000.0;
        let mut probes = probes(truth, run.alpha, last);
        let followed = change(&mut probes);
        run.gauge.update(&mut run.state, &probes, followed);
    }
}

#[test]
fn nothing_is_learnt_while_nothing_is_fed_in_or_ground() {
    let grinding = Grinding::new(0.25);
    for idle in [false, true] {
        let (mut run, truth) = grinding.run();
        turned(&mut run, &truth, 12.0, |probes| {
            probes.idle = idle;
            if idle { Followed::Whole } else { Followed::Not }
        });
        assert!(run.state.correction().iter().all(|c| *c == 0.0));
        let flags = run.state.latest().unwrap().flags;
        assert_eq!(flags, GaugeFlags::INFEED_FROZEN, "and not made smaller for it");
        run.turn(&truth, 3.0, |_| TAU / 5000.0);
        assert!(run.state.correction().iter().any(|c| c.abs() > 0.1));
    }
}

#[test]
fn an_unsteady_size_is_not_learnt_from() {
    let grinding = Grinding::new(0.25);
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 4.95, |_| TAU / 5000.0);
    let before = *run.state.correction();
    // The feed begins within a revolution.
    let from = run.alpha;
    let feed = |alpha: f64| (from - alpha) / TAU;
    for turn in 0..2 {
        let end = run.alpha + TAU;
        while run.alpha < end {
            let last = run.alpha;
            run.alpha += TAU / 5000.0;
            let mut probes = probes(&truth, run.alpha, last);
            probes.readings = probes.readings.map(|h| h + feed(run.alpha));
            run.cycle(&probes);
        }
        let frozen = run.state.latest().unwrap().flags.has(GaugeFlags::INFEED_FROZEN);
        // The first of them was sampled before the feed began, save for a twentieth.
        assert_eq!(frozen, turn > 0, "{turn}");
    }
    assert!(before != *run.state.correction());
}

#[test]
fn a_wheel_set_while_the_linkage_is_worked_out_is_taken_next() {
    let settings = settings(512, BEST_512, true);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    // Over the beginning of a job and a few hundred of its units.
    run.turn(&truth, 3.03, |_| TAU / 6000.0);
    run.gauge.set_wheel(&mut run.state, 200.0).unwrap();
    run.turn(&truth, 1.06, |_| TAU / 6000.0);
    run.gauge.set_wheel(&mut run.state, 300.0).unwrap();
    run.turn(&truth, 2.9, |_| TAU / 6000.0);
    assert!(run.state.latest().unwrap().flags.is_empty());
    assert!(run.motion_error(&truth) < 1e-3, "{:e}", run.motion_error(&truth));
}

#[test]
fn of_a_new_part_nothing_old_is_told() {
    let grinding = Grinding::new(0.25);
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 11.95, |_| TAU / 5000.0);
    assert_eq!(run.state.latest().unwrap().revolutions, 8);
    run.turn(&truth, 0.2, |_| TAU / 5000.0);
    let renewed = Probes { new_part: true, ..probes(&truth, run.alpha, run.alpha) };
    run.cycle(&renewed);
    assert_eq!(run.state.latest(), None);
    run.turn(&truth, 2.8, |_| TAU / 5000.0);
    assert_eq!(run.state.latest().unwrap().revolutions, 0);
}

#[test]
fn a_revolution_found_again_does_not_disturb_the_lead() {
    let mut grinding = Grinding::new(0.25);
    grinding.settings.infeed.as_mut().unwrap().drive_delay_s = 0.01;
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 4.3, |_| TAU / 5000.0);
    // The count jumps; zero is known again at the next index.
    let jumped = Probes { spindle: 1 << 30, ..probes(&truth, run.alpha, run.alpha) };
    run.cycle(&jumped);
    run.turn(&truth, 0.9, |_| TAU / 5000.0);
    let mut worst = 0.0_f64;
    let table = |run: &Run<f64, 256>, angle: f64| {
        let place = (angle / TAU).rem_euclid(1.0) * 256.0;
        run.state.correction()[place.round() as usize % 256]
    };
    for _ in 0..100 {
        let before = run.alpha;
        run.alpha += TAU / 5000.0;
        let probes = probes(&truth, run.alpha, before);
        let cycle = run.cycle(&probes);
        let expected = table(&run, run.alpha + grinding.contact + TAU * 100.0 / 5000.0);
        worst = worst.max((cycle.infeed + 1e-3 * expected).abs());
    }
    // Half a point off, and a speed that is being found again.
    assert!(worst < 1.5e-4, "{worst:e}");
}

#[test]
fn stability_limits_of_the_law() {
    for (delay, limit) in [(1, 1.0), (2, 0.618), (3, 0.445)] {
        assert!((gain_limit(delay) - limit).abs() < 5e-4);
        // The recursion itself, just inside and just outside.
        for (gain, stable) in [(0.99, true), (1.01, false)] {
            let mut c = std::vec![0.0_f64; usize::from(delay) + 1];
            for _ in 0..4000 {
                let seen = 1.0 - c[c.len() - 1 - usize::from(delay)];
                c.push(c[c.len() - 1] + gain * gain_limit(delay) * seen);
            }
            assert_eq!((c[c.len() - 1] - 1.0).abs() < 1e-3, stable, "{delay} {gain}");
        }
    }
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(200))]

    /// Arbitrary readings and counts: never a panic, never an infeed beyond its bound.
    #[test]
    fn no_input_breaks_the_gauge(
        seed in proptest::collection::vec((proptest::num::f64::ANY, proptest::num::i32::ANY, 0u8..8), 50..400),
    ) {
        let (mut settings, truth) = small();
        settings.infeed = Some(InfeedSettings {
            axis: crate::Axis::X, direction: 1, band: Band { first: 2, last: 8 }, gain: 0.25, delay_revolutions: 1,
            contact_deg: 10.0, drive_delay_s: 0.001, limit_um: 3.0, noise_gain_limit: 10.0,
        });
        let mut run = Run::<f32, 64>::new(&settings);
        run.turn(&truth, 3.0, |_| TAU / 700.0);
        for (reading, count, kind) in seed {
            let before = run.alpha;
            run.alpha += TAU / 300.0;
            let mut probes = probes(&truth, run.alpha, before);
            match kind {
                0 => probes.readings[1] = reading,
                1 => probes.spindle = count,
                2 => probes.index = Some(count),
                3 => probes.arm = count,
                4 => probes.new_part = count % 97 == 0,
                _ => {}
            }
            let cycle = run.cycle(&probes);
            // Between the points the cubic may stand a little above them.
            proptest::prop_assert!(cycle.infeed.abs() <= 3.0e-3 * 1.3, "{}", cycle.infeed);
        }
    }
}
