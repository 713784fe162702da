//! Refusals and their texts: settings one step beyond their ranges, segments that do not form a path.

use super::{Sum, check};
use glam::DVec3;
use trueaxis::contour::{CommandWindow, ContourSearch, Method, Segment, convert, span_count};
use trueaxis::kinematics::Kinematics;
use trueaxis::limiter::{Limiter, ramp_in_s};
use trueaxis::machine::Limits;
use trueaxis::roundness::{Arm, ArmSettings, GaugeSettings, ProbeAngles};
use trueaxis_testing::machine::{ARM, Machine};

fn add(sum: &mut Sum, result: Result<impl std::fmt::Debug, impl std::fmt::Debug + std::fmt::Display>) {
    match result {
        Ok(made) => sum.add(&made),
        Err(error) => sum.add(&(format!("{error}"), error)),
    }
}

#[test]
fn gauges() {
    let mut sum = Sum::new();
    let good = || GaugeSettings::with_defaults(256, ProbeAngles::Slots { p: 47, q: 167 }, 1 << 20);
    let mut tried = |change: &dyn Fn(&mut GaugeSettings)| {
        let mut settings = good();
        change(&mut settings);
        add(&mut sum, settings.check());
    };
    for points in [0, 32, 63, 64, 65, 100, 4096, 8192] {
        tried(&|s| s.points = points);
    }
    for (p, q) in [(0, 1), (64, 128), (1, 255), (256, 3), (128, 64)] {
        tried(&|s| s.angles = ProbeAngles::Slots { p, q });
        tried(&|s| s.angles = ProbeAngles::Degrees { phi2: f64::from(p), phi3: f64::from(q) });
    }
    for (first, last) in [(0, 5), (1, 5), (2, 2), (2, 127), (2, 128), (9, 8)] {
        tried(&|s| (s.band.first, s.band.last) = (first, last));
    }
    for filter in [14, 15, 50, 150, 151, 500] {
        tried(&|s| s.filter = Some(filter));
    }
    for number in [0, 1, 16, 17, 10_000, 10_001] {
        tried(&|s| s.revolutions = number);
        tried(&|s| s.slices_per_cycle = number.min(255) as u8);
        tried(&|s| s.spindle.index_tolerance = (1 << 18) - 9 + u32::from(number));
        tried(&|s| s.spindle.counts = 240 + u32::from(number));
    }
    for crank in [0.0, 45.0, 324.0, 325.0, 327.0, f64::NAN] {
        let lengths = Arm { crank_mm: crank, ..ARM };
        for direction in [-1, 0, 1] {
            tried(&|s| s.arm = Some(ArmSettings { lengths, counts: 1 << 20, direction, tolerance_deg: 0.5 }));
        }
    }
    tried(&|s| s.probes[1].range = [1.0, 1.0]);
    tried(&|s| s.stop_s = -1.0);
    tried(&|s| s.noise_gain_limit = 0.0);
    check(&[sum.0], &[0x4237_8523_9207_bb68]);
}

#[test]
fn paths() {
    let mut sum = Sum::new();
    let v = DVec3::new;
    let line = |start, end| Segment::Line { start, end };
    let arc = |end, center, normal, turns| Segment::Arc { start: v(10.0, 0.0, 0.0), end, center, normal, turns };
    let mut segments = vec![
        line(v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        line(v(0.0, 0.0, 0.0), v(1e-7, 0.0, 0.0)),
        line(v(0.0, 0.0, 0.0), v(f64::NAN, 0.0, 0.0)),
        line(v(0.0, 0.0, 0.0), v(8e6, 0.0, 0.0)),
        line(v(0.0, 0.0, 0.0), v(9e6, 0.0, 0.0)),
        line(v(0.0, 0.0, 0.0), v(8.0, 0.0, 0.0)),
        line(v(0.0, 0.0, 0.0), v(16.0, 1e-9, 0.0)),
    ];
    for turns in [0, 1, 3, 1_000_000] {
        segments.push(arc(v(10.0, 0.0, 0.0), v(0.0, 0.0, 0.0), DVec3::Z, turns));
        segments.push(arc(v(0.0, 10.0, 5.0), v(0.0, 0.0, 0.0), DVec3::Z, turns));
        segments.push(arc(v(0.0, 10.0, 0.0), v(0.0, 0.0, 0.0), -DVec3::Z, turns));
    }
    segments.push(arc(v(0.0, 10.1, 0.0), v(0.0, 0.0, 0.0), DVec3::Z, 0));
    segments.push(arc(v(0.0, 10.0, 0.0), v(10.0, 0.0, 0.0), DVec3::Z, 0));
    segments.push(arc(v(0.0, 10.0, 0.0), v(0.0, 0.0, 0.0), DVec3::ZERO, 0));
    let points = [v(0.0, 0.0, 0.0), v(3.0, 4.0, 0.0), v(6.0, 0.0, 1.0), v(9.0, 2.0, 0.0)];
    let knots: [&[f64]; 7] = [
        &[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
        &[0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0],
        &[0.0, 0.0, 0.0, 1.0, 0.5, 1.0, 1.0],
        &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        &[0.0, 0.0, 1.0, 2.0, 3.0, 3.0],
        &[0.0, 0.0, 1.0, 1.0, 3.0, 3.0],
        &[0.0, f64::NAN],
    ];
    let weights: [&[f64]; 4] = [&[], &[1.0, 2.0, 0.5, 1.0], &[1.0, -1.0, 1.0, 1.0], &[1.0]];
    for degree in 0..=6 {
        for knots in knots {
            for weights in weights {
                segments.push(Segment::Nurbs { degree, knots, points: &points, weights });
            }
        }
    }
    for segment in &segments {
        add(&mut sum, span_count(segment));
        if span_count(segment).is_ok_and(|count| count > 10_000) {
            continue;
        }
        let mut count = 0;
        let made = convert::<f64, f64>(segment, 3, [0.0, 0.0, 1.0], |_| {
            count += 1;
            Ok(())
        });
        add(&mut sum, made);
        sum.add(&count);
    }
    for plane in [[0.0; 3], [0.0, 0.0, 1e-7], [0.0, f64::NAN, 1.0]] {
        add(&mut sum, convert::<f64, f64>(&segments[5], 0, plane, |_| Ok(())));
        add(&mut sum, CommandWindow::<f64, f64, 8>::new(plane, 0.01).map(|_| ()));
    }
    for size in [f64::NAN, -1.0, 0.0, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 1.0, 2.0, 10.0, 100.0, 1e3, 1e6] {
        add(&mut sum, CommandWindow::<f64, f64, 8>::new([0.0, 0.0, 1.0], size).map(|_| ()));
        add(&mut sum, ContourSearch::<f64>::new(size, Method::Guarded));
    }
    check(&[sum.0], &[0x07a9_a986_d93b_2591]);
}

#[test]
fn limits_and_chains() {
    let mut sum = Sum::new();
    let values = [f64::NAN, -1.0, 0.0, 1e-16, 1e-9, 1e-3, 0.1, 2.0, f64::INFINITY];
    for a in values {
        for b in values {
            let limits = Limits { magnitude: a, slope_per_s: b, acceleration_per_s2: 3.0 };
            add(&mut sum, Limiter::<f64>::new(&limits, 1e-3));
            add(&mut sum, Limiter::<f32>::new(&limits, b));
            let limits = Limits { magnitude: 0.1, slope_per_s: 2.0, acceleration_per_s2: a };
            add(&mut sum, Limiter::<f32>::new(&limits, b));
        }
    }
    let limits = Limits { magnitude: 1.0, slope_per_s: 2.0, acceleration_per_s2: 30.0 };
    for way in [0.0, 0.01, -0.1, 0.149, 0.151, 0.5, 1.0] {
        sum.add(&ramp_in_s(&limits, way));
    }
    for axis in [[0.0; 3], [0.0, 0.0, 1e-3], [0.0, 0.0, 1.1e3], [0.0, 3.0, 4.0], [f64::NAN, 0.0, 1.0]] {
        for (chain, cone) in [("w C' A' b X Y Z t", 0.1), ("w b X Y Z C C t", 0.1), ("w C' A' b X Y Z t", 46.0)] {
            let Ok(_) = trueaxis::machine::links(chain) else { continue };
            let mut machine = Machine::new(chain).settings();
            (machine.kinematics.tool_axis, machine.kinematics.singular_cone_deg) = (axis, cone);
            let made = Kinematics::<f64>::new(&machine);
            add(&mut sum, made.map(|made| (made.tool_axis(), made.tool_mm(), made.with_tool_length(33.0).tool_mm())));
        }
    }
    check(&[sum.0], &[0xd4f7_a3eb_4e9e_7f6f]);
}
