//! Compares the rates of the corrections at a feed with differences of the interpolated curve.

use std::path::Path;
use trueaxis::machine::{Axis, Curve, PeriodicSettings};
use trueaxis_tables::files::Memory;
use trueaxis_tables::{Machine, Warning, check, rates};

fn machine(interpolation: &str) -> Machine {
    let text = format!(
        "name = \"m\"\nchain = \"w b X Y t\"\n[axis.X]\ntable = \"x.csv\"\ninterpolation = \"{interpolation}\"\n\
         max_feed_mm_per_min = 6000\n[axis.X.limits]\nslope_mm_per_s = 3\nacceleration_mm_per_s2 = 400\n"
    );
    let table = "X_mm,EXX_um,EYX_um\n0,0,1\n10,3,-2\n25,5,4\n30,12,4.5\n50,-3,0\n";
    let files = Memory::new([("machine.toml", text.as_str()), ("x.csv", table)]);
    Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap()
}

/// Largest first and second derivative of a column, by differences inside its intervals.
fn differences(machine: &Machine, component: usize) -> (f64, f64) {
    let rows = machine.rows(Axis::X).unwrap();
    let curve = Curve::new(machine.settings.axis(Axis::X).unwrap(), rows, component, false);
    let (mut slope, mut bent) = (0.0_f64, 0.0_f64);
    for pair in rows.windows(2) {
        let (low, high) = (pair[0].position, pair[1].position);
        let h = (high - low) / 1000.0;
        for part in 1..1000 {
            let at = |k: f64| curve.at(low + (part as f64 + k) * h).unwrap();
            slope = slope.max(((at(1.0) - at(-1.0)) / (2.0 * h)).abs());
            bent = bent.max(((at(1.0) - 2.0 * at(0.0) + at(-1.0)) / (h * h)).abs());
        }
    }
    (slope, bent)
}

#[test]
fn rate_and_acceleration_are_those_of_the_curve_at_the_feed() {
    let machine = machine("cubic");
    for (index, component) in [(0, 0), (1, 1)] {
        let (slope, bent) = differences(&machine, component);
        for (feed, v) in [(None, 100.0), (Some(20.0), 20.0), (Some(1e9), 100.0)] {
            let found = rates(&machine, feed)[index];
            let near = |found: f64, needed: f64| assert!((found / needed - 1.0).abs() < 5e-3, "{found} {needed}");
            near(found.rate, slope * v);
            near(found.acceleration.unwrap(), bent * v * v);
            assert_eq!(
                (found.moving, found.limit, found.acceleration_limit),
                match index {
                    0 => (Axis::X, 3.0, 400.0),
                    _ => (Axis::X, 5.0, 5000.0),
                }
            );
        }
    }
}

#[test]
fn a_linear_table_steps_the_velocity() {
    let found = rates(&machine("linear"), None);
    assert_eq!(found.iter().map(|drive| drive.acceleration).collect::<Vec<_>>(), [None, None]);
    // The steepest is 7 µm over 5 mm, at 100 mm/s.
    assert!((found[0].rate - 0.14).abs() < 1e-12);
}

/// 3 µm in 5 mm at 100 mm/s: 0.377 mm/s and 47.4 mm/s² more.
#[test]
fn periods_count_in_the_rates_and_are_warned_of() {
    let with = |period: f64| {
        let mut machine = machine("cubic");
        let harmonics = [[0.0, 3e-3]].into_iter().collect();
        let screw = PeriodicSettings { axis: Axis::X, period, harmonics, reverse: Default::default() };
        machine.settings.periodic.push(screw).unwrap();
        machine
    };
    let [plain, periodic] = [machine("cubic"), with(5.0)].map(|machine| rates(&machine, None)[0]);
    assert!((periodic.rate - plain.rate - 0.377).abs() < 1e-3, "{periodic:?}");
    let acceleration = [periodic, plain].map(|rate| rate.acceleration.unwrap());
    assert!((acceleration[0] - acceleration[1] - 47.4).abs() < 0.1, "{acceleration:?}");
    // The table has points 5 mm apart; at 1.5 mm the limit of 400 mm/s² suffices up to 87 mm/s.
    let named = |machine: &Machine| {
        let warnings = check(machine, 1000.0);
        let is_in_table = warnings.iter().any(|one| matches!(one, Warning::PeriodInTable { axis: Axis::X, .. }));
        let feed = warnings.iter().find_map(|one| match one {
            Warning::PeriodAboveLimit { feed, .. } => Some(feed.round()),
            _ => None,
        });
        (is_in_table, feed)
    };
    assert_eq!(
        [machine("cubic"), with(5.0), with(1.5), with(12.0)].map(|machine| named(&machine)),
        [(false, None), (false, None), (false, Some(87.0)), (true, None)]
    );
}
