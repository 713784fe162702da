//! The infeed correction and its law.

use super::*;

/// A one-line plant: each revolution measures d − c, the result of the previous one.
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
    // One update: c = g r; the output has the sign of the axis, in mm.
    let mut worst = 0.0_f64;
    for _ in 0..240 {
        let before = run.alpha;
        run.alpha += TAU / 5000.0;
        let cycle = run.cycle(&probes(&truth, run.alpha, before));
        let wanted = -0.25e-3 * series(&truth.profile, run.alpha + grinding.contact);
        worst = worst.max((cycle.infeed - wanted).abs());
    }
    // The cubic between points reproduces harmonic 30 of 256 within 7e-3 of its amplitude, 0.05 µm.
    assert!(worst < 4e-7, "{worst:e} mm");
}

#[test]
fn the_drive_s_delay_is_compensated_by_the_lead() {
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
    // A surface that never changes: the sum grows by g r per revolution, and stops below 5 µm.
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
    // The first revolution limited to its end is the first one without an update.
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
    // Once free again, the correction continues.
    run.turn(&truth, 3.0, |_| TAU / 5000.0);
    assert!(run.state.latest().unwrap().flags.is_empty());
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

/// While pulses are missing the gauge measures nothing, but the correction continues by the count.
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
    // At most half a point off, at the steepest part of harmonic 30.
    assert!(worst < 1e-4, "{worst:e}");
    assert!(run.state.correction().iter().any(|c| c.abs() > 0.2));
}

/// Turns the spindle; `change` sets the input of every cycle.
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

/// The readings of a stuck stylus cannot be distinguished from valid ones. They lead to a wrong profile, and to an
/// infeed that stays within its bound.
#[test]
fn a_stuck_probe_is_not_detected_and_the_infeed_keeps_its_bound() {
    let grinding = Grinding::new(0.25);
    let (mut run, truth) = grinding.run();
    run.turn(&truth, 2.95, |_| TAU / 5000.0);
    run.seen = GaugeFlags::default();
    let (mut largest, end) = (0.0_f64, run.alpha + 40.0 * TAU);
    while run.alpha < end {
        let before = run.alpha;
        run.alpha += TAU / 2000.0;
        let mut stuck = probes(&truth, run.alpha, before);
        stuck.readings[1] = 3.0;
        largest = largest.max(run.cycle(&stuck).infeed.abs());
    }
    assert!(!run.seen.has(GaugeFlags::PROBE_RANGE), "it is within its range");
    assert!(run.profile_error(&truth) > 0.5, "and the profile is wrong");
    assert!(largest > 1e-3 && largest <= 5e-3 * (1.0 + 1e-9), "{largest} mm");
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
        // The first of them was sampled before the feed began, except for a twentieth.
        assert_eq!(frozen, turn > 0, "{turn}");
    }
    assert!(before != *run.state.correction());
}

#[test]
fn a_new_part_discards_earlier_results() {
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
    // The count jumps; zero is known again from the next index pulse.
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
    // Half a point off, while the speed estimate converges again.
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
