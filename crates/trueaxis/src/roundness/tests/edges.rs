//! Limits of the settings, and the values that a gauge reports about itself.

use super::super::filter::has_enough_points;
use super::*;
use crate::error::Field;

#[test]
fn seven_points_an_undulation_are_enough() {
    assert!(has_enough_points(512, 50) && has_enough_points(350, 50) && !has_enough_points(349, 50));
    assert!(has_enough_points(105, 15) && !has_enough_points(104, 15) && !has_enough_points(64, 15));
}

fn refused(change: impl Fn(&mut GaugeSettings)) -> (Field, f64) {
    let mut settings = GaugeSettings::with_defaults(256, ProbeAngles::Slots { p: 44, q: 57 }, COUNTS);
    settings.band = Band { first: 2, last: 40 };
    settings.infeed = Some(InfeedSettings {
        axis: crate::Axis::X,
        direction: -1,
        band: Band { first: 2, last: 30 },
        gain: 0.1,
        delay_revolutions: 2,
        contact_deg: 170.0,
        drive_delay_s: 0.0,
        limit_um: 5.0,
        noise_gain_limit: 10.0,
    });
    assert!(settings.check().is_ok());
    change(&mut settings);
    settings.check().map_or_else(|error| (error.field, error.found), |_| (Field::Table, f64::NAN))
}

fn infeed(settings: &mut GaugeSettings) -> &mut InfeedSettings {
    settings.infeed.as_mut().expect("an infeed")
}

#[test]
fn settings_of_the_infeed_are_refused_by_name() {
    assert_eq!(refused(|s| infeed(s).band.last = 33), (Field::InfeedHarmonics, 33.0), "N/8 is 32");
    assert!(refused(|s| infeed(s).band.last = 32).1.is_nan());
    assert_eq!(refused(|s| infeed(s).band = Band { first: 20, last: 10 }).0, Field::InfeedHarmonics);
    assert_eq!(refused(|s| infeed(s).direction = 0), (Field::InfeedDirection, 0.0));
    assert_eq!(refused(|s| infeed(s).delay_revolutions = 0), (Field::InfeedDelay, 0.0));
    // sin(π/(2(2·2 + 1))) = sin 18°.
    let most = 18.0_f64.to_radians().sin();
    assert!(refused(|s| infeed(s).gain = most - 1e-9).1.is_nan());
    assert_eq!(refused(|s| infeed(s).gain = most + 1e-9), (Field::InfeedGain, most + 1e-9));
    assert_eq!(
        refused(|s| s.spindle.index_tolerance = COUNTS / 4),
        (Field::SpindleIndexTolerance, f64::from(COUNTS / 4))
    );
    assert!(refused(|s| s.spindle.index_tolerance = COUNTS / 4 - 1).1.is_nan());
}

#[test]
fn the_default_band_ends_below_half_the_points() {
    let of = |points| GaugeSettings::with_defaults(points, ProbeAngles::Slots { p: 11, q: 14 }, COUNTS).band.last;
    assert_eq!((of(64), of(128), of(256), of(4096)), (31, 63, 100, 100));
}

#[test]
fn a_gauge_says_what_it_is_built_for() {
    let (settings, truth) = small();
    assert_eq!(settings.check().unwrap().points(), 64);
    let error = Gauge::<f64, 64>::build(&settings, 999).unwrap_err();
    assert!(error.field == Field::Period && (error.found - 999e-9).abs() < 1e-15, "{error}");
    let mut run = Run::<f64, 64>::new(&settings);
    assert_eq!(run.gauge.infeed_slot(), None);
    assert!(GaugeFlags::default().is_empty() && !GaugeFlags::ARM.is_empty());
    run.turn(&truth, 2.9, |_| TAU / 2000.0);
    assert!(run.state.latest().is_some() && run.state.is_settled());
    // Once the next revolution is whole, work is pending.
    let works = (0..400).any(|_| {
        run.turn(&truth, 0.0005, |_| TAU / 2000.0);
        !run.state.is_settled()
    });
    assert!(works);
    run.gauge.restart(&mut run.state);
    assert!(run.state.latest().is_none() && run.state.is_settled());
}

/// A quarter of a hundredth of a point per cycle: slow, but neither stopped nor too fast, at the index pulse too.
#[test]
fn a_creeping_spindle_is_not_too_fast() {
    let (settings, truth) = small();
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 3.2, |_| TAU / 20_000.0);
    assert!(!run.seen.has(GaugeFlags::TOO_FAST) && run.state.latest().is_some());
}
