//! Readings of a wrong sign or scale on every drive of the simulator, and shipped programs on which none is reported.

use crate::common::machine;
use trueaxis::Fault;
use trueaxis_sim::plant::drive::Variant;
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Moment, Run, Sample};
use trueaxis_sim::{Scenario, Settings};

/// Distance of X and fault, cycle by cycle, on a line.
fn line(variant: Option<Variant>, feed: u32, scale: Option<f64>, feedback: bool) -> Vec<(f64, u8)> {
    let mut settings = Settings { rate_hz: 2000.0, ..Settings::default() };
    if let Some(variant) = variant {
        settings.set("drive.variant", &format!("\"{}\"", variant.name())).unwrap();
    }
    if let Some(scale) = scale {
        settings.set("faults", &format!("[\"scale:X@0s+1000000={scale}\"]")).unwrap();
    }
    if !feedback {
        settings.set("events", "[\"off:feedback@0s\"]").unwrap();
    }
    let text = format!("G21 G90 F{feed}\nG1 X10 Y4\nG1 X0 Y0\n");
    let program = Program::parse("line", &text, "line.ngc").unwrap();
    let scenario = Scenario::new(machine(), program, settings).unwrap();
    let mut run = Run::of(scenario, &[Kind::Full]).unwrap();
    let mut cycles = Vec::new();
    let mut sink = |_: &Moment, machines: &[Option<&Sample>]| {
        cycles.extend(machines.iter().flatten().map(|sample| (sample.command[0], sample.fault)));
    };
    while run.advance(997, &mut sink) {}
    cycles
}

#[test]
fn a_wrong_sign_and_a_wrong_scale_are_found_on_every_drive() {
    let ratio = Fault::FeedbackRatio as u8;
    for variant in [None].into_iter().chain(Variant::ALL.map(Some)) {
        for (feed, feedback) in [(300, true), (1500, true), (1500, false), (4000, false)] {
            let sound = line(variant, feed, None, feedback);
            assert!(sound.len() > 500 && sound.iter().all(|(_, fault)| *fault == 0), "{variant:?}, F{feed}");
            for scale in [-1.0, 0.5, 2.0] {
                // Drives with lag need the way of ten lags until half the motion is not their lag.
                let lag_s = match variant {
                    Some(Variant::Soft) => 0.04,
                    Some(Variant::Worn) => 0.007,
                    _ => 0.0,
                };
                let lag = lag_s * f64::from(feed) / 60.0;
                let most = 1.0 + lag * if scale == 0.5 { 10.0 } else { 3.0 };
                let cycles = line(variant, feed, Some(scale), feedback);
                let first = cycles.iter().position(|(_, fault)| *fault != 0).map(|k| cycles[k]);
                let case = format!("{variant:?}, F{feed}, x{scale}, feedback {feedback}: {first:?}");
                assert!(first.is_some_and(|(x, fault)| fault == ratio && x > 0.1 && x < most), "{case}");
            }
        }
    }
}

#[test]
fn shipped_programs_on_any_drive_show_no_wrong_ratio() {
    for variant in Variant::ALL {
        for name in ["short-tour", "butterfly"] {
            let mut settings = Settings { rate_hz: 1000.0, ..Settings::default() };
            settings.set("drive.variant", &format!("\"{}\"", variant.name())).unwrap();
            let program = Program::builtin(name).unwrap().unwrap();
            let mut run = Run::of(Scenario::new(machine(), program, settings).unwrap(), &[Kind::Full]).unwrap();
            let mut sink = |moment: &Moment, machines: &[Option<&Sample>]| {
                let faults = machines.iter().flatten().filter(|sample| sample.fault != 0).count();
                assert_eq!(faults, 0, "{}, {name}: {moment:?}", variant.name());
            };
            while run.advance(u64::MAX, &mut sink) {}
        }
    }
}
