//! Wrong readings and counts, and revolutions that are too short.

use super::*;

/// Disturbs the cycles of a quarter turn in the third revolution; returns that revolution's flags, and the counts afterwards.
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
fn a_rejected_probe_costs_one_whole_revolution() {
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
    // The spindle rests on a count that flickers: half a slot back and forth.
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
    // Gives every revolution the same amount of work.
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
    // Slower again: no flag remains.
    run.turn(&truth, 4.0, |_| TAU / (work as f64 + 8.0));
    assert!(run.state.latest().unwrap().flags.is_empty(), "{:?}", run.state.latest().unwrap().flags);
}
