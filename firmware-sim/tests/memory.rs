//! A run stores nothing per cycle and little per line, whatever output is requested.

use allocation_counter::{AllocationInfo, measure};
use firmware_sim::outcome;
use firmware_sim::samples::sample_machine;
use firmware_sim::series::Series;
use firmware_sim::trace::Trace;
use std::fmt::Write;
use std::sync::Arc;
use trueaxis_columnar::Form;
use trueaxis_sim::path;
use trueaxis_sim::program::{Curve, Program};
use trueaxis_sim::run::{Kind, Run, Sink};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// Lines of 0.1 mm around a circle of 20 mm, with a lift every fiftieth round.
fn program(lines: u32) -> String {
    let mut text = String::from("G21 G90 F3000\n");
    for i in 0..lines {
        let (sin, cos) = (0.005 * f64::from(i)).sin_cos();
        let word = if i % 1000 < 3 { "G0" } else { "G1" };
        let _ = writeln!(text, "{word} X{:.4} Y{:.4} Z{:.4}", 20.0 * cos, 20.0 * sin, 1e-4 * f64::from(i % 1000));
    }
    text
}

fn scenario(text: &str) -> Scenario {
    let machine = Machine::read(&sample_machine("mill-3axis")).unwrap();
    let program = Program::parse("lines", text, "lines.ngc").unwrap();
    Scenario::new(machine, program, Settings { rate_hz: 1000.0, ..Settings::default() }).unwrap()
}

/// Peak memory of a run (motion, three runs, every curve of the report, the trace), and its cycles.
fn run(scenario: Scenario) -> (u64, u64) {
    let scenario = Arc::new(scenario);
    let mut cycles = 0;
    let AllocationInfo { bytes_max, .. } = measure(|| {
        let run = Run::new(Arc::clone(&scenario)).unwrap();
        cycles = run.cycles();
        let mut series = Series::new(&scenario);
        let mut trace =
            Trace::new(std::io::sink(), Form::Csv, 1, Kind::Compensated, &scenario.machine.settings).unwrap();
        let sinks: Vec<&mut dyn Sink> = vec![&mut series, &mut trace];
        let outcome =
            outcome::simulate(run, &scenario, outcome::Timing { budget_ns: 100_000, paced: false }, sinks, &mut |_| {})
                .unwrap();
        let report = outcome.report(&scenario, &series);
        assert!(report.contour.compensated.len() > 500 && report.path.len() > 500);
        assert!(firmware_sim::report::render(&report).len() < 2_000_000);
    });
    (bytes_max, cycles)
}

#[test]
fn a_run_keeps_nothing_per_cycle_and_little_per_line() {
    let [short, long] = [2_000, 20_000].map(|lines| run(scenario(&program(lines))));
    let (more, cycles) = (long.0.saturating_sub(short.0), long.1 - short.1);
    assert!(cycles > 30_000, "{cycles}");
    // Per line: starts of the moves, their sections and speeds, their numbers in a figure.
    assert!(more < 18_000 * 150, "{} bytes a line: {short:?} {long:?}", more / 18_000);

    // The same lines at a tenth of the feed fill every figure to its last bucket. A fifth of that feed means five times
    // the cycles, and may not take a byte more.
    let [slow, slower] = ["F300", "F60"].map(|feed| run(scenario(&program(2_000).replace("F3000", feed))));
    let (more, cycles) = (slower.0.saturating_sub(slow.0), slower.1 - slow.1);
    assert!(cycles > 150_000, "{cycles}");
    assert!(more < 64 * 1024, "{more} bytes in {cycles} cycles: {slow:?} {slower:?}");
    assert!(slow.0.saturating_sub(short.0) < 512 * 1024, "{short:?} {slow:?}");
}

/// The window around the current position has the same spans and numbers as the whole path.
#[test]
fn the_sliding_path_is_the_whole_one_where_it_is() {
    let scenario = scenario(&program(3_000));
    let motion = scenario.motion().unwrap();
    let whole = path::PlannedPath::new(&scenario.program, scenario.origin_mm, &scenario.placement).unwrap();
    let mut sliding = path::SlidingPath::new(&scenario);
    let (mut near, mut also_near) = (0, 0);
    let mut held = 0;
    for point in motion.setpoints(&scenario.program) {
        sliding.cover(&scenario, [point.move_index; 2]).unwrap();
        let at = whole.reference(point.move_index, point.u, &mut near);
        assert_eq!(sliding.reference(point.move_index, point.u, &mut also_near), at);
        for number in at.span.saturating_sub(60)..at.span + 60 {
            let (own, of_whole) = (sliding.view().span(number), whole.view().span(number));
            assert_eq!(own.map(|span| span.position(0.5)), of_whole.map(|span| span.position(0.5)), "{number}");
        }
        let around = (0..whole.spans.len() as u32).step_by(50).filter(|n| sliding.view().span(*n).is_some()).count();
        held = held.max(around);
    }
    assert!(held * 50 < 600, "{held}");
}

/// A spline between distant points is refused before any of its spans is created.
#[test]
fn a_spline_of_too_many_pieces_is_refused_before_it_is_cut() {
    let mut scenario = scenario(&program(10));
    // 1.2 million spans of 8 mm.
    let far = 8.0 * 1.2e6;
    scenario.program.moves[5].curve = Curve::Nurbs {
        degree: 2,
        knots: vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        points: vec![[0.0; 3], [0.5 * far, 1.0, 0.0], [far, 0.0, 0.0]],
        weights: vec![1.0; 3],
    };
    let line = format!("line {}", scenario.program.moves[5].line);
    let AllocationInfo { bytes_max, .. } = measure(|| {
        let checked = path::check(&scenario).unwrap_err().to_string();
        let planned = path::PlannedPath::new(&scenario.program, scenario.origin_mm, &scenario.placement).unwrap_err();
        assert!(checked.contains(&line) && checked == planned.to_string(), "{checked}, {planned}");
    });
    assert!(bytes_max < 100_000, "{bytes_max} bytes");
}
