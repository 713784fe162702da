//! Thermal and probing tests: figures of hand-made records.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;
use trueaxis_evaluation::circle::Evaluation;
use trueaxis_evaluation::probing::{self, Feature, Record};
use trueaxis_evaluation::rows::{Column, Rows};
use trueaxis_evaluation::thermal::{self, Recording};
use trueaxis_evaluation::thermal_test::{self, Test, ThermalTestDocument};

fn thermal(text: &str) -> anyhow::Result<Test> {
    thermal_test::read(&mut Rows::new(text.as_bytes(), Path::new("drift.csv"), &thermal_test::COLUMNS, |_| {})?)
}

fn probed(text: &str, feature: Feature, diameter: Option<f64>) -> anyhow::Result<Record> {
    Record::read(&mut Rows::new(text.as_bytes(), Path::new("ring.csv"), &probing::COLUMNS, |_| {})?, feature, diameter)
}

fn near(found: f64, truth: f64, within: f64) {
    assert!((found - truth).abs() < within, "{found} for {truth}");
}

/// Four hours of warm-up, a reading per minute: z grows by 30 (1 − e^(−t/40)), x1 by half of it, the spindle tilts by 1 µrad
/// per minute.
fn warm_up() -> String {
    let mut text = String::from("t_s,x1_um,z_um,x2_um,spindle_c\n");
    for minute in 0..=240 {
        let t = f64::from(minute);
        let z = 30.0 * (1.0 - (-t / 40.0).exp());
        writeln!(text, "{},{},{z},{},{}", 100.0 + 60.0 * t, 0.5 * z, 0.5 * z + 0.1 * t, 20.0 + 0.4 * z).unwrap();
    }
    text
}

#[test]
fn ranges_over_the_stated_periods() {
    let test = thermal(&warm_up()).unwrap();
    let found = ThermalTestDocument::new(&test, "spindle", 60.0, Some(100.0));
    let channels = &found.positions[0].channels;
    let of = |name: &str| channels.iter().find(|channel| channel.name == name).unwrap();
    let z = |t: f64| 30.0 * (1.0 - (-t / 40.0).exp());
    near(of("Z").range, z(240.0), 1e-9);
    near(of("Z").first_period, z(60.0), 1e-9);
    near(of("X1").worst_period, 0.5 * z(60.0), 1e-9);
    near(of("X1").worst_from_min, 0.0, 1e-9);
    // x2 − x1 grows by 0.1 µm per minute over 100 mm.
    near(of("B").range, 240.0, 1e-9);
    near(of("B").first_period, 60.0, 1e-9);
    assert!(channels.iter().all(|channel| channel.name != "A"), "no y was recorded");
    near(found.temperatures[0].end_k, 0.4 * z(240.0), 1e-9);
    near(found.duration_min, 240.0, 1e-9);
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    let etve = ThermalTestDocument::new(
        &thermal(&warm_up().lines().take(90).collect::<Vec<_>>().join("\n")).unwrap(),
        "etve",
        60.0,
        None,
    );
    assert!(
        etve.notes.iter().any(|note| note.contains("4 h"))
            && etve.notes.iter().any(|note| note.contains("--distance-mm"))
    );
}

#[test]
fn a_moving_axis_has_a_drift_at_each_position() {
    let mut text = String::from("t_s,position,z_um\n");
    for k in 0..60 {
        let drift = f64::from(k) * if k % 2 == 0 { 0.1 } else { 0.3 };
        writeln!(text, "{},{},{drift}", 30 * k, 1 + k % 2).unwrap();
    }
    let found = ThermalTestDocument::new(&thermal(&text).unwrap(), "axis", 10.0, None);
    assert_eq!(found.positions.iter().map(|place| place.position).collect::<Vec<_>>(), [1, 2]);
    near(found.positions[0].channels[0].range, 5.8, 1e-9);
    near(found.positions[1].channels[0].range, 0.3 * 58.0, 1e-9);
    // Ten minutes are 20 readings, 10 of each position.
    near(found.positions[0].channels[0].worst_period, 2.0, 1e-9);
}

#[test]
fn a_probe_that_dies_half_way_is_refused_with_its_line() {
    let refused = |text: &str, message: &str| {
        let error = format!("{:#}", thermal(text).unwrap_err());
        assert!(error.contains(message), "{error} without {message}");
    };
    let good = warm_up();
    let dead: String = good
        .lines()
        .enumerate()
        .map(|(i, line)| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if i > 120 {
                cells[1] = "12.5";
            }
            cells.join(",") + "\n"
        })
        .collect();
    refused(
        &dead,
        "drift.csv:122: column x1_um: found 12.5 for 121 readings in a row, needed a sensor whose readings change",
    );
    refused(
        &good.replacen("\n160,", "\n100,", 1),
        "drift.csv:3: column t_s: found 100, needed more than 100 of the line before",
    );
    refused("t_s,spindle_c\n0,20\n1,20\n", "needed at least one of x1_um");
    refused("t_s,x1_um\n0,1\n1,2\n", "2 readings at position 0, needed at least 10");
    refused(&good.replacen(",20\n", ",4000\n", 1), "drift.csv:2: column spindle_c: found 4000");
}

#[test]
fn a_drift_that_no_probe_reads_and_a_position_left_out_are_refused() {
    let refused = |text: &str, message: &str| {
        let error = format!("{:#}", thermal(text).unwrap_err());
        assert!(error.contains(message), "{error} without {message}");
    };
    let good = warm_up();
    let last = good.lines().last().unwrap();
    let wrong = good.replace(last, "14500,15,16030,39,32");
    refused(
        &wrong,
        "drift.csv:242: column z_um: found 16030, needed at most 2000 um either way, the travel of a probe",
    );
    // One probe alone, which dies.
    let mut alone = String::from("t_s,z_um\n");
    (0..60).for_each(|k| writeln!(alone, "{},{}", 60 * k, (0.1 * f64::from(k)).min(4.0)).unwrap());
    refused(&alone, "drift.csv:42: column z_um: found 4 for 20 readings in a row");
    // A dial of 1 µm at the end of its warming is not a dead sensor.
    let mut dial = String::from("t_s,z_um\n");
    (0..60).for_each(|k| writeln!(dial, "{},{}", 60 * k, (0.2 * f64::from(k)).min(8.0).round()).unwrap());
    assert!(thermal(&dial).is_ok());
    let mut turns = String::from("t_s,position,z_um\n");
    (0..60).for_each(|k| writeln!(turns, "{},{},{}", 30 * k, 1 + k % 2, 0.1 * f64::from(k)).unwrap());
    assert!(thermal(&turns).is_ok());
    let without: Vec<&str> = turns.lines().enumerate().filter(|(k, _)| *k != 30).map(|(_, line)| line).collect();
    refused(
        &without.join("\n"),
        "drift.csv:31: column position: found 1, needed 2, which follows 1 everywhere else: a row is missing",
    );
}

/// Opens the rows of a CSV text.
fn rows<'t, const C: usize>(text: &'t str, columns: &[Column; C]) -> anyhow::Result<Rows<'t, C>> {
    Rows::new(text.as_bytes(), Path::new("r.csv"), columns, |_| {})
}

#[test]
fn every_stream_notices_a_channel_that_dies() {
    let refused = |found: anyhow::Result<()>, message: &str| {
        let error = format!("{:#}", found.unwrap_err());
        assert!(error.contains(message), "{error} without {message}");
    };
    // A circle whose second coordinate freezes.
    let mut circle = String::from("x_mm,y_mm\n");
    for k in 0..90 {
        let angle = TAU * f64::from(k.min(60)) / 90.0;
        writeln!(circle, "{},{}", 10.0 * (TAU * f64::from(k) / 90.0).cos(), 10.0 * angle.sin()).unwrap();
    }
    let found = rows(&circle, &trueaxis_evaluation::circle::COLUMNS).and_then(|mut rows| Evaluation::read(&mut rows));
    refused(found.map(drop), "r.csv:62: column y_mm: found -8.66");
    // The drift of a warm-up.
    let warm_up = |drift: fn(u32) -> f64| {
        let mut text = String::from("t_s,cycle,ez_um,T1_c\n");
        (0..120).for_each(|k| writeln!(text, "{},{},{},{}", 60 * k, k / 40, drift(k), 20 + k / 10).unwrap());
        rows(&text, &thermal::COLUMNS).and_then(|rows| Recording::read(rows, &[])).map(drop)
    };
    assert!(warm_up(|k| (0.1 * f64::from(k)).sin()).is_ok());
    refused(warm_up(|k| (0.1 * f64::from(k.min(70))).sin()), "r.csv:72: column ez_um: found ");
    refused(warm_up(|k| 3000.0 * (0.1 * f64::from(k)).sin()), "needed at most 2000 um either way");
    refused(
        warm_up(|k| 0.02 * (0.1 * f64::from(k)).sin()),
        "r.csv:1: column ez_um: found a drift of 4.00e-2 um over the whole record",
    );
}

/// A ring of 50 mm: tip of 6 mm, three lobes of 2 µm, centre 100, 200; with the tip 8, −5 µm off the spindle's axis.
fn ring(spindle: &[f64]) -> String {
    let mut text = String::from("x_mm,y_mm,run,spindle_deg\n");
    for (run, deg) in spindle.iter().enumerate() {
        let (sin, cos) = deg.to_radians().sin_cos();
        let (ex, ey) = (0.008 * cos + 0.005 * sin, 0.008 * sin - 0.005 * cos);
        for k in 0..36 {
            let angle = TAU * f64::from(k) / 36.0;
            let radius = 22.0 + 0.002 * (3.0 * angle).cos();
            writeln!(
                text,
                "{},{},{},{deg}",
                100.0 + ex + radius * angle.cos(),
                200.0 + ey + radius * angle.sin(),
                run + 1
            )
            .unwrap();
        }
    }
    text
}

#[test]
fn a_ring_gives_form_tip_diameter_and_offset() {
    let found =
        probing::ProbingDocument::new(&probed(&ring(&[0.0, 90.0, 180.0, 270.0]), Feature::Ring, Some(50.0)).unwrap());
    assert_eq!(found.p_ftu_name, Some("P_FTU,2D"));
    near(found.p_ftu_um.unwrap(), 4.0, 1e-3);
    near(found.effective_tip_diameter_mm.unwrap(), 6.0, 1e-6);
    let offset = found.tip_offset.unwrap();
    near(offset.x_um.value, 8.0, 1e-6);
    near(offset.y_um.value, -5.0, 1e-6);
    near(offset.length_um, 89.0_f64.sqrt(), 1e-6);
    // Corrected for orientation, the location repeats.
    assert!(found.location_repeatability.unwrap().range_um.iter().all(|um| *um < 1e-6));
    // One orientation does not determine the offset.
    let one = probing::ProbingDocument::new(&probed(&ring(&[0.0, 0.0]), Feature::Ring, None).unwrap());
    assert!(one.tip_offset.is_none() && one.effective_tip_diameter_mm.is_none());
    assert!(one.notes.iter().any(|note| note.contains("180°")));
}

#[test]
fn a_sphere_and_a_point() {
    let mut text = String::from("x_mm,y_mm,z_mm,run\n");
    for run in 1..=3 {
        for k in 0..25 {
            let (height, turn) = (f64::from(k) / 25.0, 2.4 * f64::from(k));
            let flat = (1.0_f64 - height * height).sqrt();
            let r = 15.5 + if k == 7 { 0.003 } else { 0.0 };
            let shift = 0.001 * f64::from(run);
            writeln!(text, "{},{},{},{run}", 10.0 + shift + r * flat * turn.cos(), r * flat * turn.sin(), r * height)
                .unwrap();
        }
    }
    let found = probing::ProbingDocument::new(&probed(&text, Feature::Sphere, Some(25.0)).unwrap());
    assert_eq!(found.p_ftu_name, Some("P_FTU,3D"));
    assert!((2.3..3.3).contains(&found.p_ftu_um.unwrap()), "{:?}", found.p_ftu_um);
    near(found.effective_tip_diameter_mm.unwrap(), 6.0, 1e-3);
    near(found.location_repeatability.unwrap().range_um[0], 2.0, 1e-6);
    let points = "x_mm,y_mm,z_mm\n1,2,3.000\n1,2,3.001\n1,2,3.003\n1,2,2.999\n";
    let found = probing::ProbingDocument::new(&probed(points, Feature::Point, None).unwrap());
    let spread = found.point_repeatability.unwrap();
    near(spread.range_um[2], 4.0, 1e-6);
    // Standard deviation of 0, 1, 3, −1: variance (0.75² + 0.25² + 2.25² + 1.75²)/3.
    near(spread.standard_deviation_um.unwrap()[2], (8.75_f64 / 3.0).sqrt(), 1e-6);
}

#[test]
fn bad_probing_records_are_refused() {
    let refused = |text: &str, feature, diameter, message: &str| {
        let error = format!("{:#}", probed(text, feature, diameter).unwrap_err());
        assert!(error.contains(message), "{error} without {message}");
    };
    let good = ring(&[0.0, 90.0]);
    refused(
        &good,
        Feature::Ring,
        Some(100.0),
        "ring.csv: run 1: found a diameter of 44.000 mm, needed within 25 % of 100 mm",
    );
    refused(&good, Feature::Sphere, None, "needed z_mm for a sphere or a point");
    let lines: Vec<&str> = good.lines().collect();
    refused(
        &format!("{good}{}\n", lines[3]),
        Feature::Ring,
        None,
        "ring.csv:74: column x_mm: found the same point as in line 4",
    );
    let turning = good.replacen(",1,0\n", ",1,10\n", 1);
    refused(
        &turning,
        Feature::Ring,
        None,
        "ring.csv:3: column spindle_deg: found 0, needed 10 as in the run's first line",
    );
    refused(&good.replace(lines[20], "100,200,1,0"), Feature::Ring, None, "ring.csv:21: column x_mm: found a point 2");
    refused(
        &good.replace(&format!("{}\n", lines[20]), ""),
        Feature::Ring,
        None,
        "ring.csv: run 1: found 35 points, needed 36 as in run 2",
    );
    refused("x_mm,y_mm\n1,2\n2,3\n", Feature::Ring, None, "run 0: found 2 points, needed 4");
    refused("x_mm,y_mm,z_mm\n0,0,0\n1,0,0\n0,1,0\n1,1,0\n2,1,0\n", Feature::Sphere, None, "found points in one plane");
}
