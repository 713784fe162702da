//! Circles from which friction is identified: their planes, and passes in slices.

use std::path::Path;
use trueaxis::Axis;
use trueaxis_sim::friction::{Circles, Pass, Plane, Recorder};
use trueaxis_sim::run::Kind;
use trueaxis_sim::{Settings, SimError};
use trueaxis_tables::Machine;

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis")).unwrap()
}

/// A pass at 1 kHz, in slices of `slice` cycles.
fn pass(plane: Plane, slice: u64) -> Pass {
    let circles = Circles::new(plane, 8.0037, &[1500.0, 900.0], 1).unwrap();
    let settings = Settings { rate_hz: 1000.0, ..Settings::default() };
    let mut recorder = Recorder::new(&circles, machine(), settings, Kind::Compensated).unwrap();
    let mut before = 0.0;
    while recorder.advance(slice) {
        assert!(recorder.progress() > before && recorder.progress() <= 1.0);
        before = recorder.progress();
    }
    recorder.finish()
}

#[test]
fn circles_lie_in_their_plane() {
    for (plane, axes, header) in [
        (Plane::Xy, [Axis::X, Axis::Y], "t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n"),
        (Plane::Zx, [Axis::Z, Axis::X], "t_s,z_cmd_mm,z_mm,x_cmd_mm,x_mm\n"),
        (Plane::Yz, [Axis::Y, Axis::Z], "t_s,y_cmd_mm,y_mm,z_cmd_mm,z_mm\n"),
    ] {
        let pass = pass(plane, 4096);
        assert!(pass.csv().starts_with(header));
        let record = pass.sent().unwrap();
        assert_eq!([record.axes[0].axis, record.axes[1].axis], axes);
        let [first, second] = [0, 1].map(|i| &record.axes[i].command);
        let middle = |values: &[f64]| {
            let [low, high] = values.iter().fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(*v), high.max(*v)]);
            (low + high) / 2.0
        };
        let [a, b] = [middle(first), middle(second)];
        // After the approach to the start, every point is on the circle, except for the geometric correction.
        let start = first.iter().zip(second).position(|(x, y)| ((x - a).hypot(y - b) - 8.0037).abs() < 0.02).unwrap();
        for k in start..first.len() {
            let radius = (first[k] - a).hypot(second[k] - b);
            assert!((radius - 8.0037).abs() < 0.03, "{radius} mm in cycle {k}, {plane:?}");
        }
        // Counterclockwise at first: from the first axis to the second.
        let turn =
            |k: usize| (first[k] - a) * (second[k + 1] - second[k]) - (second[k] - b) * (first[k + 1] - first[k]);
        let moving: Vec<f64> = (start..first.len() - 1).map(turn).filter(|area| area.abs() > 0.05).collect();
        assert!(moving[100] > 0.0 && *moving.last().unwrap() < 0.0, "{plane:?}");
    }
}

#[test]
fn a_pass_is_the_same_however_it_is_divided() {
    let [one, other] = [pass(Plane::Xy, 4096), pass(Plane::Xy, 37)];
    assert_eq!(one.csv(), other.csv());
    assert_eq!((one.error, one.cycles), (other.error, other.cycles));
}

#[test]
fn invalid_circles_are_refused_by_name() {
    for (radius_mm, feeds, turns, name) in [
        (0.5, &[1500.0, 600.0][..], 1, "radius_mm"),
        (f64::NAN, &[1500.0, 600.0], 1, "radius_mm"),
        (10.0, &[1500.0], 1, "feeds"),
        (10.0, &[1500.0, 5.0], 1, "feeds"),
        (10.0, &[1500.0, 600.0], 21, "turns"),
    ] {
        let refused = Circles::new(Plane::Xy, radius_mm, feeds, turns).unwrap_err();
        assert!(matches!(&refused, SimError::Unsuited { what, .. } if what == name), "{refused}");
    }
}
