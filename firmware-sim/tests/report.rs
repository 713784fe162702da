//! The simulator's report: content of a whole page, and robustness to any input.

use std::f64::consts::TAU;

use firmware_sim::{
    latency::Latency,
    report::{AxisReport, CircleReport, ContourSeries, PathPoint, Report, ReversalReport, decimate, render, write},
};
use trueaxis_evaluation::shown::Shown;
use trueaxis_tables::output::Outputs;

const RADIUS_MM: f64 = 50.0;
const CYCLES: u32 = 60_000;
const RATE_HZ: f64 = 10_000.0;
const SVG_NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// A 50 mm circle: two lobes from squareness and a reversal spike at each quadrant, a residual of a tenth, servo noise.
fn circle() -> Report {
    let mut report = Report {
        shown: Shown {
            title: "Servo cycle simulation".to_owned(),
            summary: vec!["mill <3> & \"Söhne\" (w X' b Y Z t)".to_owned()],
            notes: vec!["SCHED_FIFO priority 80: not permitted (Operation not permitted (os error 1))".to_owned()],
            ..Shown::default()
        },
        ..Report::default()
    };
    let mut axes = ["X", "Y", "Z"].map(|name| AxisReport {
        name: name.to_owned(),
        magnitude_limit: if name == "X" { 20.0 } else { 200.0 },
        slope_limit: if name == "X" { 0.05 } else { 1.0 },
        acceleration_limit: 0.2,
        ..AxisReport::default()
    });
    let mut random = trueaxis_testing::noise::Noise::new(1);
    for k in 0..CYCLES {
        let noise = 0.5 * random.signed();
        let angle = TAU * f64::from(k) / f64::from(CYCLES);
        let (sin, cos) = angle.sin_cos();
        let spike = 6.0 * (-(((2.0 * angle).sin() / 0.05).powi(2))).exp();
        let radial = 11.0 * (2.0 * angle + 0.6).sin() + spike;
        let servo = 0.6 * (3.0 * angle).sin() + 0.5 * noise;
        let residue = 0.07 * radial + servo;
        let length = RADIUS_MM * angle;
        report.contour.uncompensated.push([length, radial + servo]);
        report.contour.compensated.push([length, residue]);
        report.contour.servo_only.push([length, servo]);
        let lift = 2.0 * angle;
        if k % 5 == 0 {
            report.path.push(PathPoint {
                run: 0,
                nominal_mm: [RADIUS_MM * cos, RADIUS_MM * sin, lift],
                uncompensated_um: [radial * cos, radial * sin, 3.0 * sin],
                compensated_um: [residue * cos, residue * sin, 0.2 * sin],
            });
        }
        let time_s = f64::from(k) / RATE_HZ;
        for (axis, (value, slope)) in axes.iter_mut().zip([
            (-radial * cos, 0.04 * (3.0 * angle).cos()),
            (-radial * sin, 0.03 * sin),
            (-3.0 * sin, -0.003 * cos),
        ]) {
            axis.correction.push([time_s, value]);
            axis.slope.push([time_s, slope]);
        }
    }
    report.contour.program_lines = (0..24_u32).map(|k| (TAU * RADIUS_MM * f64::from(k) / 24.0, 10 + k)).collect();
    report.axes = axes.into();
    let mut latency = Latency::new(25_000, 100_000);
    for k in 0..u64::from(CYCLES) {
        let noise = random.below(1 << 32) as u32;
        let jitter = u64::from(noise >> 28) + u64::from(noise >> 20 & 7) * u64::from(noise >> 24 & 3);
        latency.record(match k % 20_000 {
            77 => 140_000,
            78..100 => 6_000 + 97 * (k % 31),
            _ => 142 + jitter,
        });
    }
    report.latency = latency.summary();
    report.latency_buckets = latency.buckets().collect();
    report
}

/// Checks that the whole page, including each SVG, is well-formed XML; returns its visible text.
fn text_of(page: &str) -> String {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(page, options).expect("a well-formed page");
    let mut svgs = 0;
    for svg in document.descendants().filter(|node| node.tag_name().name() == "svg") {
        assert_eq!(svg.tag_name().namespace(), Some(SVG_NAMESPACE));
        let size: Vec<f64> =
            svg.attribute("viewBox").expect("viewBox").split(' ').map(|part| part.parse().expect("a number")).collect();
        for shape in svg.descendants() {
            check_inside(&shape, &size);
        }
        svgs += 1;
    }
    assert_eq!(svgs, page.matches("<svg").count());
    document.descendants().filter(roxmltree::Node::is_text).filter_map(|node| node.text()).collect()
}

/// Checks that every coordinate of a shape is a number inside its drawing, within the width of a stroke.
fn check_inside(shape: &roxmltree::Node<'_, '_>, size: &[f64]) {
    let inside = |text: &str, limit: f64| {
        let value: f64 = text.parse().unwrap_or_else(|_| panic!("`{text}` is not a number"));
        assert!(value >= -40.0 && value <= limit + 40.0, "{value} is outside 0 to {limit} in {shape:?}");
    };
    for point in shape.attribute("points").unwrap_or_default().split_whitespace() {
        let (x, y) = point.split_once(',').expect("x,y");
        inside(x, size[2]);
        inside(y, size[3]);
    }
    for (name, limit) in [("x", 2), ("cx", 2), ("x1", 2), ("x2", 2), ("y", 3), ("cy", 3), ("y1", 3), ("y2", 3)] {
        if let Some(value) = shape.attribute(name) {
            inside(value, size[limit]);
        }
    }
}

#[test]
fn a_realistic_page_is_complete_and_self_contained() {
    let page = render(&circle());
    if let Some(directory) = std::env::var_os("REPORT_DIR") {
        write(Outputs::default(), directory.as_ref(), &[("index.html".into(), page.clone())]).expect("written");
    }
    let text = text_of(&page);
    for expected in [
        "mill <3> & \"Söhne\"",
        "w X' b Y Z t",
        "servo alone",
        "limit ±20.0 µm",
        "limit ±200 µm, outside the figure",
        "limit ±0.0500 mm/s",
        "limit ±1.00 mm/s, outside the figure",
        "budget 25\u{202f}000 ns",
        "period 100\u{202f}000 ns",
        "p99.99 ",
        "wall time on a shared host: shown, not gated",
        "3 longer than the period (missed deadlines)",
        "SCHED_FIFO priority 80: not permitted (Operation not permitted (os error 1))",
        "deviations magnified 500 times",
        "XZ view",
        "X in mm",
        "time in s",
        "contour error in µm",
        "path length in mm",
        "latency in ns",
    ] {
        assert!(text.contains(expected), "`{expected}` is missing");
    }
    assert!(!page.contains("NaN") && !page.contains("inf"));
    assert_eq!(page.matches("http").count(), page.matches(SVG_NAMESPACE).count(), "no address but the SVG namespace");
    assert!(!page.contains("<script") && !page.contains("@import") && !page.contains("url("));
    assert!((50_000..600_000).contains(&page.len()), "{} bytes", page.len());
}

#[test]
fn the_largest_error_is_in_the_figure_at_its_place() {
    let mut report = circle();
    report.contour.uncompensated[12_345] = [64.64, -33.3];
    assert!(text_of(&render(&report)).contains("uncorrected: largest 33.3 µm at 64.64 mm"));
}

#[test]
fn limits_are_drawn_where_they_are_near() {
    let dashes = |limit: f64| {
        let axes = vec![AxisReport {
            name: "C".to_owned(),
            rotary: true,
            correction: vec![[0.0, -10.0], [1.0, 10.0]],
            magnitude_limit: limit,
            ..AxisReport::default()
        }];
        let page = render(&Report { axes, ..Report::default() });
        assert!(text_of(&page).contains(&format!("limit ±{limit:.1} µrad")), "{}", text_of(&page));
        page.matches("stroke=\"#A40E26\"").count()
    };
    assert!(dashes(12.0) > 20, "a limit just above the curve is drawn");
    assert_eq!(dashes(80.0), 0, "a limit far away is stated only");
}

#[test]
fn degenerate_data_make_a_page_all_the_same() {
    text_of(&render(&Report::default()));
    for value in [0.0, 1.0, -3.5, 1e-9, 1e9, 1e12, 1e300, f64::MAX, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for count in [1_usize, 2, 3, 5_000] {
            for varied in [false, true] {
                let at = |k: usize| if varied && k % 2 == 1 { -value } else { value };
                let series: Vec<[f64; 2]> = (0..count).map(|k| [at(k / 2), at(k)]).collect();
                let mut latency = Latency::new(at(0) as u64, at(1) as u64);
                (0..count).for_each(|k| latency.record(at(k) as u64));
                let axis = AxisReport {
                    name: "\u{1}X\0<".to_owned(),
                    rotary: varied,
                    correction: series.clone(),
                    slope: series.clone(),
                    magnitude_limit: value,
                    slope_limit: -value,
                    acceleration_limit: value,
                };
                let report = Report {
                    contour: ContourSeries {
                        breaks: Vec::new(),
                        uncompensated: series.clone(),
                        compensated: decimate(&series, 3),
                        servo_only: Vec::new(),
                        full: series.clone(),
                        program_lines: (0..count).map(|k| (at(k), u32::MAX)).collect(),
                    },
                    path: (0..count)
                        .map(|k| PathPoint {
                            run: 0,
                            nominal_mm: [at(k), at(k / 2), value],
                            uncompensated_um: [value, at(k), 0.0],
                            compensated_um: [0.0, at(k), value],
                        })
                        .collect(),
                    circle: Some(CircleReport {
                        radius_mm: value,
                        plane: [count, 1],
                        line: u32::MAX,
                        uncompensated: series.clone(),
                        full: series.clone(),
                        ..CircleReport::default()
                    }),
                    reversals: vec![ReversalReport {
                        axis: "\u{1}<".to_owned(),
                        rotary: varied,
                        time_s: value,
                        sent: series.clone(),
                        feed_forward: series.clone(),
                        full_um: series.clone(),
                        ..ReversalReport::default()
                    }],
                    axes: vec![axis],
                    latency: latency.summary(),
                    latency_buckets: latency.buckets().collect(),
                    ..Report::default()
                };
                let page = render(&report);
                text_of(&page);
                assert!(!page.contains("NaN") && !page.contains("inf"), "{value}, {count} points");
            }
        }
    }
}

#[test]
fn the_page_is_written_where_it_is_asked_for() {
    let directory = tempfile::tempdir().expect("a directory");
    let page = [("index.html".to_owned(), "T".to_owned())];
    let write = |directory: &std::path::Path| write(Outputs::default(), directory, &page);
    let file = write(&directory.path().join("a/b")).expect("written");
    assert_eq!(file, directory.path().join("a/b/index.html"));
    assert_eq!(std::fs::read_to_string(&file).expect("readable"), "T");
    assert!(write(&file).is_err(), "a file is not a directory");
}
