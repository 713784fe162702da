//! Recovery of the 21 errors from points of machines whose tip moves by exact transforms.

use std::fmt::Write;
use std::path::Path;
use trueaxis::Axis;
use trueaxis::machine::{AXES, ErrorModel, Interpolation, LocationErrors};
use trueaxis_evaluation::points::{COLUMNS, Options, Points, PointsDocument, PointsFit, identify};
use trueaxis_evaluation::response::tip_errors;
use trueaxis_evaluation::rows::Rows;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::formats::machine_files;
use trueaxis_tables::{Machine, Table, files::Memory};
use trueaxis_testing::machine::{Machine as Settings, rows};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::{Scatter, normal};

const BOX: [[f64; 2]; 3] = [[-300.0, 300.0], [-200.0, 200.0], [-250.0, 150.0]];

/// A machine with all 21 errors drawn at random: smooth, some micrometres and tens of microradians, and squareness.
fn machine(chain: &str, seed: u64, measured_at: [f64; 3]) -> Machine {
    let mut noise = Noise::new(seed);
    let location = LocationErrors { a0z: 31e-6, b0z: -22e-6, c0y: 45e-6, ..LocationErrors::default() };
    let mut settings = Settings::new(chain).with(|machine| machine.location = location).settings();
    settings.compensation.model = ErrorModel::Volumetric;
    settings.tool_mm = [0.0, 0.0, -60.0];
    let mut tables = Vec::new();
    for own in &mut settings.axes {
        own.measured_at_mm = measured_at;
        own.interpolation = Interpolation::Linear;
        if own.axis.is_rotary() {
            tables.push(None);
            continue;
        }
        let [low, high] = BOX[own.axis.index()];
        own.travel = [low, high];
        let waves: Vec<[f64; 3]> = (0..6)
            .map(|c| {
                let size = if c < 3 { 6e-3 } else { 25e-6 };
                [size * noise.signed(), noise.range(0.5, 1.5), noise.range(0.0, 6.0)]
            })
            .collect();
        let at = (0..=10).map(|k| low + (high - low) * f64::from(k) / 10.0);
        let table = rows(at, |q| {
            let share = q / 300.0;
            std::array::from_fn(|c| {
                let [size, pitch, phase] = waves[c];
                size * ((3.0 * pitch * share + phase).sin() + 0.5 * share)
            })
        });
        tables.push(Some(Table { given: [true; 6], bidirectional: false, rows: table }));
    }
    Machine { settings, tables, grids: Vec::new() }
}

/// A grid of points; the instrument is shifted and turned, and the reflectors' offsets are wrong.
fn record(machine: &Machine, per_axis: usize, tools: &[[f64; 3]], noise_um: f64) -> String {
    let mut noise = Noise::new(21);
    let mut text = String::from("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm,tool_x_mm,tool_y_mm,tool_z_mm\n");
    let level = |axis: usize, k: usize| {
        let [low, high] = BOX[axis];
        low + (high - low) * k as f64 / (per_axis - 1) as f64
    };
    let (shift, turn) = ([0.12, -0.05, 0.3], [40e-6, -60e-6, 25e-6]);
    for (number, tool) in tools.iter().enumerate() {
        let mut own = machine.clone();
        own.settings.tool_mm = *tool;
        let geometry = Geometry::new(&own, 0.0).unwrap();
        let off = [0.02, -0.01, 0.03].map(|mm| mm * number as f64);
        for i in 0..per_axis {
            for j in 0..per_axis {
                for k in 0..per_axis {
                    let p = [level(0, i), level(1, j), level(2, k)];
                    let mut at = [0.0; AXES];
                    at[..3].copy_from_slice(&p);
                    let e = geometry.tip_error(&at, &[0.0; AXES]);
                    let turned = [
                        turn[1] * p[2] - turn[2] * p[1],
                        turn[2] * p[0] - turn[0] * p[2],
                        turn[0] * p[1] - turn[1] * p[0],
                    ];
                    write!(text, "{},{},{}", p[0], p[1], p[2]).unwrap();
                    for c in 0..3 {
                        let gauss: f64 = (0..12).map(|_| noise.unit()).sum::<f64>() - 6.0;
                        let actual = p[c] + tool[c] + e[c] + shift[c] + turned[c] + off[c] + 1e-3 * noise_um * gauss;
                        write!(text, ",{actual}").unwrap();
                    }
                    writeln!(text, ",{},{},{}", tool[0], tool[1], tool[2]).unwrap();
                }
            }
        }
    }
    text
}

fn points(text: &str) -> anyhow::Result<Points> {
    Points::read(&mut Rows::new(text.as_bytes(), Path::new("points.csv"), &COLUMNS, |_| {})?)
}

fn found(text: &str, machine: &Machine) -> (Points, PointsFit) {
    let points = points(text).unwrap();
    let found = identify(&points, machine, &Options::default()).unwrap();
    (points, found)
}

/// Largest difference of the tip errors of two machines over a fine grid, after removing a best rigid motion: a fit of t + ρ ×
/// p to the differences through normal equations of six unknowns.
fn largest_difference(one: &Machine, other: &Machine) -> f64 {
    let mut places = Vec::new();
    for i in 0..=12 {
        for j in 0..=12 {
            for k in 0..=12 {
                let at = |axis: usize, n: i32| BOX[axis][0] + (BOX[axis][1] - BOX[axis][0]) * f64::from(n) / 12.0;
                places.push([at(0, i), at(1, j), at(2, k), 0.0, 0.0, 0.0]);
            }
        }
    }
    let exact = Geometry::new(one, 0.0).unwrap();
    let (found, _) = tip_errors(other, &places).unwrap();
    let mut fit = trueaxis_metrology::linear_fit::LinearFit::new(6);
    let mut rows = Vec::new();
    for (place, model) in places.iter().zip(found) {
        let truth = exact.tip_error(place, &[0.0; AXES]);
        let [x, y, z, ..] = *place;
        for (c, row) in [[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]]
            .into_iter()
            .enumerate()
        {
            rows.push((row, truth[c] - model[c]));
            fit.add(&row, truth[c] - model[c], 1.0);
        }
    }
    let rigid = fit.solve().values;
    let left = rows.iter().map(|(row, d)| (d - row.iter().zip(&rigid).map(|(a, x)| a * x).sum::<f64>()).abs());
    left.fold(0.0, f64::max)
}

/// The resulting machine moves as the measured one throughout the volume: the residual is the second order of the exact
/// transforms. Structural codes with the workpiece on none, one, two and three axes; with and without `measured_at_mm`.
#[test]
fn the_machine_that_comes_out_moves_as_the_one_that_was_measured() {
    let chains =
        ["w b X Y Z t", "w X' Y' b Z t", "w Y' b X Z t", "w X' b Y Z t", "w Z' Y' X' b t", "w C' A' Y' b X Z t"];
    for (seed, chain) in (1..).zip(chains) {
        for measured_at in [[0.0; 3], [0.0, 0.0, -100.0]] {
            let truth = machine(chain, seed, measured_at);
            let text = record(&truth, 11, &[[0.0, 0.0, -60.0]], 0.0);
            let (points, found) = found(&text, &truth);
            let document = PointsDocument::new(&points, &found);
            assert!(document.before.max_um > 20.0, "{chain}: nothing to find: {:?}", document.before);
            assert!(document.left.max_um < 0.05, "{chain} {measured_at:?}: {:?}", document.left);
            assert!(document.held_out.unwrap().max_um < 0.05, "{chain}: {:?}", document.held_out);
            let off = 1e3 * largest_difference(&truth, &found.machine);
            println!("{chain} {measured_at:?}: {off:.3} µm between the machines");
            assert!(off < 0.25, "{chain} {measured_at:?}: {off} µm between the machines");
            // Straightness has no slope and is zero at machine zero: squareness is separate.
            let of = |axis: Axis| found.machine.rows(axis).unwrap();
            let slope: f64 = of(Axis::X).iter().map(|row| row.position * row.forward[1]).sum();
            assert!(slope.abs() < 1e-6, "{chain}: slope of EYX {slope}");
            assert_eq!(document.rank, document.unknowns);
            // The written files read back as the same machine.
            let files = machine_files(&found.machine, "measured");
            let read = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap();
            assert_eq!(read.tables, found.machine.tables);
        }
    }
}

/// A second reflector offset reveals the last axis' rotations, which one alone does not; they are then valid for any tool.
#[test]
fn a_second_reflector_shows_what_one_does_not() {
    let truth = machine("w X' Y' b Z t", 7, [0.0; 3]);
    let tools = [[0.0, 0.0, -60.0], [80.0, 0.0, -60.0], [0.0, 70.0, -160.0]];
    let (_, one) = found(&record(&truth, 7, &tools[..1], 0.0), &truth);
    for name in ["EAZ", "EBZ", "ECZ"] {
        assert!(one.unseen.contains(&name.to_owned()), "{name} not among {:?}", one.unseen);
    }
    // Roll of the outermost axis turns the workpiece about a point away from the tip: it remains visible.
    assert!(!one.unseen.contains(&"EAX".to_owned()) && !one.unseen.contains(&"ECX".to_owned()), "{:?}", one.unseen);
    let (_, three) = found(&record(&truth, 11, &tools, 0.0), &truth);
    for name in ["EAZ", "EBZ", "ECZ"] {
        assert!(!three.unseen.contains(&name.to_owned()), "{:?}", three.unseen);
    }
    // With a tool that was not measured.
    let (mut a, mut b) = (truth, three.machine);
    a.settings.tool_mm = [30.0, -40.0, -120.0];
    b.settings.tool_mm = a.settings.tool_mm;
    let off = 1e3 * largest_difference(&a, &b);
    assert!(off < 0.1, "{off} µm at another tool");
}

/// With 1 µm of noise: sigma is recovered, the machine is far better than a reading, and squareness is within its standard
/// errors.
#[test]
fn noise_comes_out_as_sigma() {
    let truth = machine("w X' Y' b Z t", 3, [0.0; 3]);
    let (points, found) = found(&record(&truth, 11, &[[0.0, 0.0, -60.0]], 1.0), &truth);
    let document = PointsDocument::new(&points, &found);
    assert!((document.sigma_um - 1.0).abs() < 0.05, "{}", document.sigma_um);
    let off = 1e3 * largest_difference(&truth, &found.machine);
    assert!(off < 1.5, "{off} µm at the worst corner");
    let clean = PointsDocument::new(&points, &{
        let (_, found) = self::found(&record(&truth, 11, &[[0.0, 0.0, -60.0]], 0.0), &truth);
        found
    });
    for (with, without) in [
        (document.squareness.a0z_urad, clean.squareness.a0z_urad),
        (document.squareness.b0z_urad, clean.squareness.b0z_urad),
        (document.squareness.c0y_urad, clean.squareness.c0y_urad),
    ] {
        assert!((with.value - without.value).abs() < 4.0 * with.standard_error, "{with:?} for {without:?}");
        assert!(with.standard_error < 5.0, "{with:?}");
    }
}

#[test]
fn terms_that_points_cannot_separate_are_refused_by_name() {
    let truth = machine("w b X Y Z t", 3, [0.0; 3]);
    let good = record(&truth, 5, &[[0.0, 0.0, -60.0]], 0.5);
    let refused = |text: &str, options: &Options, message: &str| {
        let error = points(text).and_then(|points| identify(&points, &truth, options)).unwrap_err();
        let error = format!("{error:#}");
        assert!(error.contains(message), "{error} without {message}");
    };
    let default = Options::default();
    // Three lines along the axes: the rotations only show if axes move together.
    let lines: String = good
        .lines()
        .filter(|line| {
            let cells: Vec<f64> = line.split(',').filter_map(|cell| cell.parse().ok()).collect();
            cells.is_empty() || [0, 1, 2].iter().filter(|&&c| cells[c] != 0.5 * (BOX[c][0] + BOX[c][1])).count() <= 1
        })
        .map(|line| format!("{line}\n"))
        .collect();
    refused(&lines, &Options { nodes: Some([2; 3]), ..default.clone() }, "cannot separate");
    let few: String = good.lines().take(20).map(|line| format!("{line}\n")).collect();
    refused(&few, &default, "needed points along every axis");
    let rows: Vec<&str> = good.lines().collect();
    refused(
        &format!("{good}{}\n", rows[3]),
        &default,
        "points.csv:127: column x_mm: found a second row for this position, as in line 4",
    );
    refused(
        &good.replacen("\n-300,-200,-250,-2", "\n-300,-200,-250,-3", 1),
        &default,
        "points.csv:2: column actual_x_mm: found",
    );
    refused(&good, &Options { without: vec!["EQX".into()], ..default.clone() }, "--without: found EQX");
    // The instrument loses its target half-way and repeats its last coordinates.
    let mut dead = String::new();
    for (i, line) in rows.iter().enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        if i > 90 {
            let kept: Vec<&str> = rows[90].split(',').collect();
            let mut cells = cells.clone();
            cells[3] = kept[3];
            writeln!(dead, "{}", cells.join(",")).unwrap();
        } else {
            writeln!(dead, "{line}").unwrap();
        }
    }
    refused(&dead, &default, "column actual_x_mm: found");
}

/// Over repeats with noise, the squarenesses scatter with the covariance of the document, whose diagonal is what it prints. Where
/// a corner is missing they are correlated.
#[test]
fn squarenesses_scatter_with_their_covariance() {
    let truth = machine("w X' Y' b Z t", 5, [0.0; 3]);
    let mut clean = points(&record(&truth, 3, &[[0.0, 0.0, -60.0]], 0.0)).unwrap();
    clean.points.retain(|point| {
        let [x, y, z] = point.command_mm;
        x / 300.0 + y / 200.0 + (z + 50.0) / 200.0 < 0.5
    });
    let (mut noise, mut scatter, mut names) = (Noise::new(4), Scatter::default(), Vec::new());
    for _ in 0..400 {
        let mut own = clean.clone();
        for mm in own.points.iter_mut().flat_map(|point| &mut point.deviation_mm) {
            *mm += 1e-3 * normal(&mut noise);
        }
        let found = identify(&own, &truth, &Options::default()).unwrap();
        let document = PointsDocument::new(&own, &found);
        let [a, b, c] = [document.squareness.a0z_urad, document.squareness.b0z_urad, document.squareness.c0y_urad];
        for (k, of) in [a, b, c].into_iter().enumerate() {
            assert_eq!(document.covariance.estimates[k], of.value);
            assert!((document.covariance.matrix[k][k].sqrt() / of.standard_error - 1.0).abs() < 1e-12);
        }
        scatter.add(&document.covariance.estimates, &document.covariance.matrix);
        names = document.covariance.names;
    }
    assert_eq!(names, ["A0Z", "B0Z", "C0Y"]);
    let largest = scatter.check(&names, 0.0);
    assert!(largest > 0.2, "nothing to compare: {largest}");
}
