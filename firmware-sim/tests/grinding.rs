//! Grinding with the infeed correction: improvement of the true surface, and behaviour under disturbances.

use firmware_sim::samples::sample_machine;
use trueaxis::roundness::{GaugeFlags, GaugeSettings, ProbeAngles, gain_limit};
use trueaxis_sim::grinding::{self, Event, Grinding, Moment, Process, Run};
use trueaxis_tables::Machine;

/// The sample grinder with fewer points, to keep the tests fast: 256 points, 2000 cycles per revolution.
fn grinding(revolutions: u32, change: impl FnOnce(&mut GaugeSettings)) -> Grinding {
    let mut machine = Machine::read(&sample_machine("grinder")).unwrap();
    let gauge = machine.settings.roundness.as_mut().unwrap();
    gauge.points = 256;
    gauge.angles = ProbeAngles::Degrees { phi2: 66.09375, phi3: 234.492_187_5 };
    gauge.filter = None;
    gauge.infeed.as_mut().unwrap().band.last = 32;
    change(gauge);
    Grinding {
        machine,
        rate_hz: 4000.0,
        speed_rpm: 120.0,
        revolutions,
        seed: 1,
        process: Process::default(),
        events: Vec::new(),
    }
}

/// Runs without and with correction.
fn both(grinding: &Grinding) -> [Run; 2] {
    let runs = [false, true].map(|corrected| grinding::run(grinding, corrected, &mut |_| {}).unwrap());
    for run in &runs {
        assert_eq!(run.revolutions.len(), grinding.revolutions as usize);
        assert_eq!(run.limits_exceeded, 0);
    }
    runs
}

/// The requirement: less than a tenth of the synchronous imprint remains.
fn falls_below_a_tenth(what: &str, grinding: &Grinding) -> [Run; 2] {
    let [before, after] = both(grinding);
    let ratio = after.imprint_um / before.imprint_um;
    println!(
        "{what}: {:.4} to {:.4} um, {:.1} %, {:?}",
        before.imprint_um,
        after.imprint_um,
        100.0 * ratio,
        after.counts
    );
    assert!(before.imprint_um > 1.0, "{what}: there must be something to correct: {}", before.imprint_um);
    assert!(ratio < 0.1, "{what}: {ratio}");
    [before, after]
}

#[test]
fn the_synchronous_imprint_falls_below_a_tenth_and_stays_without_correction() {
    for (seed, feed_um) in [(1, 0.1), (2, 0.3)] {
        let process = Process { feed_um, ..Process::default() };
        let grinding = Grinding { seed, process, ..grinding(40, |_| {}) };
        let [before, after] = falls_below_a_tenth(&format!("default gain, feed {feed_um} um"), &grinding);
        let mean = |run: &Run, from: usize, to: usize| {
            run.revolutions[from..to].iter().map(|r| r.imprint_um).sum::<f64>() / (to - from) as f64
        };
        let (early, late) = (mean(&before, 10, 20), mean(&before, 30, 40));
        assert!((late / early - 1.0).abs() < 0.1, "without correction it must not fall: {early} to {late}");
        assert!(mean(&after, 30, 40) < 0.1 * late, "every single revolution counts, on average");
        assert!(after.roundness_um < 0.2 * before.roundness_um);
        // The gauge, without access to these data, measures the same.
        let last = before.revolutions.last().unwrap();
        let (seen, seen_roundness) = (last.gauge_imprint_um.unwrap(), last.gauge_roundness_um.unwrap());
        assert!((seen / last.imprint_um - 1.0).abs() < 0.05, "{seen} {}", last.imprint_um);
        assert!((seen_roundness / last.roundness_um - 1.0).abs() < 0.1, "{seen_roundness} {}", last.roundness_um);
        assert_eq!(after.counts.discarded, 0);
    }
}

#[test]
fn other_points_and_an_ordinary_shaft() {
    let with_512 = grinding(40, |gauge| {
        gauge.points = 512;
        gauge.angles = ProbeAngles::Slots { p: 155, q: 172 };
        gauge.infeed.as_mut().unwrap().band.last = 50;
    });
    falls_below_a_tenth("512 points", &Grinding { rate_hz: 10_000.0, ..with_512 });
    falls_below_a_tenth("no arm", &grinding(40, |gauge| gauge.arm = None));
    let turned_about = grinding(40, |gauge| {
        gauge.spindle.direction = -1;
        gauge.arm.as_mut().unwrap().direction = -1;
        gauge.probes[1].gain_um = -2.0;
        gauge.probes[2].zero = 30.0;
        gauge.infeed.as_mut().unwrap().direction = 1;
        gauge.infeed.as_mut().unwrap().contact_deg = 150.0;
    });
    falls_below_a_tenth("every sign turned about", &turned_about);
}

#[test]
fn skipped_revolutions_cost_time_but_not_quality() {
    for skip in [1, 3] {
        let mut grinding = grinding(24 * (skip + 1), |_| {});
        grinding.speed_rpm = grinding::speed_that_skips(grinding.gauge().unwrap(), grinding.rate_hz, skip).unwrap();
        let [_, after] = falls_below_a_tenth(&format!("{skip} skipped"), &grinding);
        let counts = after.counts;
        assert!(counts.evaluated >= 20 && counts.skipped + 4 >= skip * counts.evaluated, "{counts:?}");
        assert!(after.flags.has(GaugeFlags::SKIPPED));
    }
}

#[test]
fn half_the_limit_of_stability_is_stable() {
    for delay in [2, 3] {
        let gain = 0.5 * gain_limit(delay);
        let grinding = grinding(48, |gauge| {
            let infeed = gauge.infeed.as_mut().unwrap();
            (infeed.gain, infeed.delay_revolutions) = (gain, delay);
        });
        let [_, after] = falls_below_a_tenth(&format!("D {delay}, gain {gain:.4}"), &grinding);
        let imprint = |k: usize| after.revolutions[k].imprint_um;
        assert!((36..48).all(|k| imprint(k) < 0.2), "no swing is left");
    }
}

/// One observed run with correction.
struct Watched {
    run: Run,
    /// Per cycle: turns, requested infeed (µm), correction of X (µm), flags, evaluated.
    cycles: Vec<(f64, f64, f64, GaugeFlags, u32)>,
    /// Every change of the correction table: turns and its largest value.
    tables: Vec<(f64, f64)>,
}

fn watch(grinding: &Grinding) -> Watched {
    let limits = grinding.machine.settings.axes[0].limits;
    // The steepest feed of the program: roughing at the start of a part.
    let feed = 1e-3 * (grinding.fed_um(0.01) / 0.01) * grinding.speed_rpm / 60.0 / grinding.rate_hz;
    let step = limits.slope_per_s / grinding.rate_hz + 1.1 * feed;
    let mut before: Option<[f64; 3]> = None;
    let (mut cycles, mut tables, mut table) = (Vec::new(), Vec::new(), Vec::new());
    let run = grinding::run(grinding, true, &mut |moment: &Moment<'_>| {
        for (now, before) in moment.drive_mm.iter().zip(before.unwrap_or(moment.drive_mm)) {
            assert!((now - before).abs() <= step, "the drive jumps by {} at {}", now - before, moment.turns);
        }
        before = Some(moment.drive_mm);
        if moment.table_um != table {
            table = moment.table_um.to_vec();
            tables.push((moment.turns, table.iter().fold(0.0, |worst: f64, c| worst.max(c.abs()))));
        }
        let (infeed, correction) = (1e3 * moment.infeed_mm, 1e3 * moment.correction_mm[0]);
        cycles.push((moment.turns, infeed, correction, moment.flags, moment.counts.evaluated));
    });
    let run = run.unwrap();
    assert_eq!(run.limits_exceeded, 0);
    Watched { run, cycles, tables }
}

impl Watched {
    fn seen_between(&self, from: f64, to: f64) -> GaugeFlags {
        let flags = self.cycles.iter().filter(|c| (from..to).contains(&c.0)).map(|c| c.3);
        flags.fold(GaugeFlags::default(), |all, flags| GaugeFlags(all.0 | flags.0))
    }

    fn table_changes_between(&self, from: f64, to: f64) -> usize {
        self.tables.iter().filter(|t| (from..to).contains(&t.0)).count()
    }

    fn recovers(&self, grinding: &Grinding) {
        let quiet = Grinding { events: Vec::new(), ..grinding.clone() };
        let before = grinding::run(&quiet, false, &mut |_| {}).unwrap();
        let ratio = self.run.imprint_um / before.imprint_um;
        println!("{:?}: {:.1} % left, {:?}", grinding.events, 100.0 * ratio, self.run.counts);
        assert!(ratio < 0.1, "{ratio}");
    }
}

#[test]
fn a_spindle_that_stops_in_mid_revolution_freezes_the_correction() {
    let events = vec![Event::Stop { at: 24.4, for_s: 1.5 }];
    let grinding = Grinding { events, ..grinding(40, |_| {}) };
    let watched = watch(&grinding);
    assert!(watched.seen_between(24.4, 25.0).has(GaugeFlags::STOPPED));
    assert_eq!(watched.run.counts.discarded, 1);
    // At standstill the infeed is constant and non-zero.
    let stopped: Vec<_> = watched.cycles.iter().filter(|c| c.3.has(GaugeFlags::STOPPED)).collect();
    let [first, .., last] = stopped[..] else { panic!("it must have stopped") };
    assert!(stopped.len() > 2000 && first.4 == last.4);
    assert!((first.1 - last.1).abs() < 0.02 && first.1.abs() > 0.05, "{} {}", first.1, last.1);
    assert!((first.2 - last.2).abs() < 0.02);
    watched.recovers(&grinding);
}

#[test]
fn a_missing_index_freezes_the_table_and_the_correction_continues_by_count() {
    let grinding = Grinding { events: vec![Event::MissingIndex { turn: 24 }], ..grinding(44, |_| {}) };
    let watched = watch(&grinding);
    assert!(watched.seen_between(24.0, 24.5).has(GaugeFlags::INDEX_MISSING));
    assert!(watched.seen_between(24.3, 24.9).has(GaugeFlags::NO_INDEX));
    assert!(!watched.seen_between(25.1, 44.0).has(GaugeFlags::NO_INDEX));
    assert_eq!(watched.run.counts.discarded, 1);
    // A count that may have slipped does not serve measuring, but the table stays and is followed.
    let fed = watched.cycles.iter().filter(|c| (24.3..24.9).contains(&c.0)).map(|c| c.1.abs()).fold(0.0, f64::max);
    assert!(fed > 1.0, "{fed}");
    assert!(watched.tables.iter().filter(|t| t.0 > 20.0).all(|t| t.1 > 1.0));
    watched.recovers(&grinding);
}

#[test]
fn a_probe_that_is_knocked_off_freezes_the_table_and_the_correction_continues() {
    let events = vec![Event::ProbeOut { probe: 1, at: 24.2, turns: 2.3 }];
    let grinding = Grinding { events, ..grinding(44, |_| {}) };
    let watched = watch(&grinding);
    assert!(watched.seen_between(24.2, 26.5).has(GaugeFlags::PROBE_RANGE));
    assert!(!watched.seen_between(26.6, 44.0).has(GaugeFlags::PROBE_RANGE));
    assert!(watched.run.counts.discarded >= 1);
    // The work on the previous revolution finishes within a turn; the next complete revolution ends at 28.
    assert_eq!(watched.table_changes_between(25.2, 27.9), 0);
    assert!(watched.table_changes_between(27.9, 32.0) > 0);
    let fed = watched.cycles.iter().filter(|c| (25.2..26.5).contains(&c.0)).map(|c| c.1.abs()).fold(0.0, f64::max);
    assert!(fed > 1.0, "the existing correction continues: {fed}");
    watched.recovers(&grinding);
}

#[test]
fn a_new_part_begins_from_zero_through_the_limiter() {
    let grinding = Grinding { events: vec![Event::NewPart { at: 24.3 }], ..grinding(64, |_| {}) };
    let watched = watch(&grinding);
    let soon = watched.tables.iter().find(|t| t.0 > 24.3 && t.1 == 0.0).map(|t| t.0);
    assert!(soon.is_some_and(|turns| turns < 24.5), "{soon:?}");
    // The rough surface of the new pin is visible again.
    assert!(watched.run.revolutions[25].roundness_um > 5.0 * watched.run.revolutions[23].roundness_um);
    watched.recovers(&grinding);
}

#[test]
fn a_dressed_wheel_is_reported_at_run_time_and_detected_if_it_is_not() {
    let dressed = |reported| {
        let events = vec![Event::Wheel { at: 20.5, wheel_mm: 284.0, reported }];
        let grinding = Grinding { events, ..grinding(44, |_| {}) };
        (watch(&grinding), grinding)
    };
    let (watched, grinding) = dressed(true);
    let last = watched.run.evaluation.unwrap();
    assert!(!last.flags.has(GaugeFlags::ARM) && last.revolution > 38, "{last:?}");
    watched.recovers(&grinding);
    let (watched, _) = dressed(false);
    let last = watched.run.evaluation.unwrap();
    assert!(last.flags.has(GaugeFlags::ARM) && last.flags.has(GaugeFlags::INFEED_FROZEN), "{last:?}");
    assert_eq!(watched.table_changes_between(23.0, 44.0), 0);
}
