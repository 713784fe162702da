//! Points in a plane: errors that the test itself makes up, and plates that were measured.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::machine::{AXES, ErrorModel, LocationErrors};
use trueaxis_evaluation::points::{COLUMNS, Options, PlaneDocument, PlaneErrors, PlaneFit, Points, identify_plane};
use trueaxis_evaluation::response::own_tip_errors;
use trueaxis_evaluation::rows::Rows;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::machine_files;
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::machine::{Machine as Settings, rows};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;

const HEADER: &str = "x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm\n";
/// Placement of the plate: shifts, mm, and rotation, rad.
const PLACED: [f64; 3] = [0.08, -0.03, 60e-6];

/// Scattered positions within a circle, or a lattice of 7 by 9.
fn scattered(count: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut noise = Noise::new(seed);
    let mut points = Vec::new();
    while points.len() < count {
        let at = [300.0 * noise.signed(), 300.0 * noise.signed()];
        if at[0].hypot(at[1]) <= 300.0 {
            points.push(at);
        }
    }
    points
}

fn lattice() -> Vec<[f64; 2]> {
    (0..63).map(|k| [-150.0 + 50.0 * f64::from(k % 7), -160.0 + 40.0 * f64::from(k / 7)]).collect()
}

/// A record of the plane Z = 0: errors in µm at the positions, placed, with noise of `sigma_um` a coordinate.
fn record(at: &[[f64; 2]], errors_um: impl Fn(f64, f64) -> [f64; 2], sigma_um: f64, seed: u64) -> String {
    let mut noise = Noise::new(seed);
    let mut text = String::from(HEADER);
    let [shift_x, shift_y, turn] = PLACED;
    for &[x, y] in at {
        let [ex, ey] = errors_um(x, y).map(|um| 1e-3 * (um + sigma_um * normal(&mut noise)));
        writeln!(text, "{x},{y},0,{},{},0", x + shift_x - turn * y + ex, y + shift_y + turn * x + ey).unwrap();
    }
    text
}

fn points(text: &str) -> anyhow::Result<Points> {
    Points::read(&mut Rows::new(text.as_bytes(), Path::new("plate.csv"), &COLUMNS, |_| {})?)
}

fn found(text: &str, machine: Option<&Machine>) -> PlaneFit {
    identify_plane(&points(text).unwrap(), machine, &Options::default(), None).unwrap()
}

fn document(text: &str) -> PlaneDocument {
    PlaneDocument::new(&found(text, None), false)
}

/// A machine with X, Y and Z without any error.
fn bare() -> Machine {
    let mut settings = Settings::new("w X' Y' b Z t").settings();
    settings.axes.iter_mut().for_each(|own| own.travel = [-350.0, 350.0]);
    Machine { tables: vec![None; settings.axes.len()], settings, grids: Vec::new() }
}

/// Scale and squareness over a lattice, with the standard errors of the textbook: σ/√Σ(x − x̄)² for a slope, and the squareness is
/// the sum of two slopes.
#[test]
fn affine_terms_and_their_standard_errors() {
    let truth = |x: f64, y: f64| [40e-3 * x - 30e-3 * y, -25e-3 * y];
    let of = document(&record(&lattice(), truth, 1.0, 3));
    assert_eq!(of.model, "affine", "{:?}", of.models);
    assert_eq!((of.unknowns, of.rank, of.degrees_of_freedom), (6, 6, 2 * 63 - 6));
    let squares: [f64; 2] = [9.0 * 2500.0 * 28.0, 7.0 * 1600.0 * 60.0];
    let needed = [
        ("scale X", 40.0, squares[0].powf(-0.5)),
        ("scale Y", -25.0, squares[1].powf(-0.5)),
        ("C0Y", 30.0, (1.0 / squares[0] + 1.0 / squares[1]).sqrt()),
    ];
    for (term, (name, value, factor)) in of.terms.iter().zip(needed) {
        assert_eq!(term.name, name);
        let error = term.of.standard_error;
        assert!((error / (1e3 * of.sigma_um * factor) - 1.0).abs() < 1e-9, "{name}: {error}");
        assert!((term.of.value - value).abs() < 4.0 * error, "{name}: {:?}", term.of);
    }
    assert!((of.sigma_um - 1.0).abs() < 0.2, "{}", of.sigma_um);
    // The rotation is that of the straightness of Y over X, which has none of its own here.
    assert!((of.turn_urad - 60.0).abs() < 4.0 * 1e3 * squares[0].powf(-0.5), "{}", of.turn_urad);
    // Without noise to the last digits.
    let exact = document(&record(&lattice(), truth, 0.0, 3));
    for (term, (name, value, _)) in exact.terms.iter().zip(needed) {
        assert!((term.of.value - value).abs() < 1e-6, "{name}: {:?}", term.of);
    }
    assert!(exact.left.rms_um < 1e-6 && exact.shift_mm.iter().zip(PLACED).all(|(own, mm)| (own - mm).abs() < 1e-9));
    // Away from machine zero the scales start at the nearest end, X 250 and Y 340, and squareness at machine zero.
    let away: Vec<[f64; 2]> = lattice().iter().map(|[x, y]| [x + 400.0, y + 500.0]).collect();
    let needed = [PLACED[0] + 40e-6 * 250.0, PLACED[1] - 25e-6 * 340.0];
    let shift = document(&record(&away, truth, 0.0, 3)).shift_mm;
    assert!(shift.iter().zip(needed).all(|(own, mm)| (own - mm).abs() < 1e-9), "{shift:?}, needed {needed:?}");
}

/// Tables over the levels of a lattice: errors that kink at every level come out without noise, and with noise within their
/// standard errors. The machine that comes out gives them back.
#[test]
fn tables_of_one_dimension() {
    let saw = |k: f64| 3.0 * ((k * 2.3).sin() + (k * 5.1).cos());
    let truth = |x: f64, y: f64| {
        let (i, j) = (x / 50.0 + 3.0, y / 40.0 + 4.0);
        [saw(i) + saw(j + 20.0), saw(i + 40.0) + saw(j + 60.0)]
    };
    let text = record(&lattice(), truth, 0.3, 5);
    let (of, found) = (document(&text), found(&text, Some(&bare())));
    assert_eq!(of.model, "tables of 7 and 9 nodes", "{:?}", of.models);
    assert_eq!(of.functions.iter().map(|of| of.name.as_str()).collect::<Vec<_>>(), ["EXX", "EYX", "EXY", "EYY"]);
    let PlaneErrors::Tables(tables) = &found.errors else { panic!("{:?}", found.errors) };
    // EXX is zero at machine zero: the difference of the truth from there, with the standard errors of the nodes.
    for (k, node) in tables.nodes_mm[0].iter().enumerate() {
        let needed = 1e-3 * (truth(*node, 0.0)[0] - truth(0.0, 0.0)[0]);
        let (value, error) = (tables.errors[0][0][k], tables.standard_errors[0][0][k]);
        assert!((value - needed).abs() <= 4.0 * error + 1e-12, "{node}: {value} ± {error}, needed {needed}");
        assert!(error < 0.3e-3, "{node}: {error}");
    }
    // Straightness has no slope.
    let slope: f64 = tables.nodes_mm[0].iter().zip(&tables.errors[0][1]).map(|(node, value)| node * value).sum();
    assert!(slope.abs() < 1e-9, "{slope}");
    assert_corrects(&found, &lattice(), truth, 0.35);
}

/// The machine's tip error at positions, by its own model, is the made-up error up to a rigid motion. `most_um`: largest
/// difference, root mean square.
#[track_caller]
fn assert_corrects(found: &PlaneFit, at: &[[f64; 2]], truth: impl Fn(f64, f64) -> [f64; 2], most_um: f64) {
    let files = machine_files(found.machine.as_ref().expect("a machine"), "measured");
    let machine = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap();
    let places: Vec<[f64; AXES]> = at.iter().map(|[x, y]| [*x, *y, 0.0, 0.0, 0.0, 0.0]).collect();
    let (errors, _) = own_tip_errors(&machine, &places).unwrap();
    assert!(errors.iter().all(|error| error[2].abs() < 1e-12), "errors along Z");
    let off: Vec<[f64; 2]> = at
        .iter()
        .zip(&errors)
        .map(|(&[x, y], error)| {
            let needed = truth(x, y);
            [1e3 * error[0] - needed[0], 1e3 * error[1] - needed[1]]
        })
        .collect();
    let rms = rigid_rms(at, &off);
    assert!(rms < most_um, "{rms} µm RMS");
}

/// Root mean square that a rigid motion leaves, by its closed form about the centroid.
fn rigid_rms(at: &[[f64; 2]], off: &[[f64; 2]]) -> f64 {
    let n = at.len() as f64;
    let mean = |of: &[[f64; 2]], k: usize| of.iter().map(|v| v[k]).sum::<f64>() / n;
    let (p, d) = ([mean(at, 0), mean(at, 1)], [mean(off, 0), mean(off, 1)]);
    let (mut moment, mut inertia) = (0.0, 0.0);
    for (a, o) in at.iter().zip(off) {
        let (x, y) = (a[0] - p[0], a[1] - p[1]);
        moment += x * (o[1] - d[1]) - y * (o[0] - d[0]);
        inertia += x * x + y * y;
    }
    let turn = moment / inertia;
    let left = at.iter().zip(off).map(|(a, o)| {
        let (x, y) = (a[0] - p[0], a[1] - p[1]);
        (o[0] - d[0] + turn * y).powi(2) + (o[1] - d[1] - turn * x).powi(2)
    });
    (left.sum::<f64>() / n).sqrt()
}

fn cubic(x: f64, y: f64) -> [f64; 2] {
    let (u, v) = (x / 300.0, y / 300.0);
    [9.0 * u * u * v - 7.0 * v * v * v + 5.0 * u * v, -8.0 * u * v * v + 6.0 * u * u - 5.0 * u * u * u]
}

/// A cubic map over a round plate: chosen, followed by the grid between the measured points, and held outside.
#[test]
fn a_cubic_map() {
    let text = record(&scattered(400, 1), cubic, 1.0, 7);
    let (of, found) = (document(&text), found(&text, Some(&bare())));
    assert_eq!(of.model, "map of degree 3", "{:?}", of.models);
    assert!(of.grid_off_um.unwrap() < 0.1 && (of.sigma_um - 1.0).abs() < 0.1, "{of:?}");
    assert!(of.terms.is_empty() && of.functions.is_empty());
    // √(unknowns/coordinates) of the noise, and the grid's share.
    assert_corrects(&found, &scattered(300, 2), cubic, 0.35);
    let PlaneErrors::Grid(grid) = &found.errors else { panic!("{:?}", found.errors) };
    let largest = |of: &[[f64; 2]]| of.iter().flatten().fold(0.0, |most: f64, mm| most.max(mm.abs()));
    let inside: Vec<[f64; 2]> = scattered(2000, 3).iter().map(|at| grid.at(*at)).collect();
    assert!(largest(&grid.values) < 1.4 * largest(&inside), "{} mm in a corner without points", largest(&grid.values));
}

/// A cross of two lines determines affine terms and tables, but no product of both coordinates.
#[test]
fn lines_along_both_axes() {
    let cross: Vec<[f64; 2]> =
        (-15..=15).flat_map(|k| [[20.0 * f64::from(k), 0.0], [0.0, 10.0 * f64::from(k)]]).skip(1).collect();
    let cross: Vec<[f64; 2]> = cross.into_iter().filter(|at| *at != [0.0, 0.0]).chain([[0.0, 0.0]]).collect();
    let of = document(&record(&cross, |x, y| [50e-3 * x - 80e-3 * y, 20e-3 * y], 0.5, 9));
    assert_eq!(of.model, "affine", "{:?}", of.models);
    assert!((of.terms[2].of.value - 80.0).abs() < 4.0 * of.terms[2].of.standard_error, "{:?}", of.terms);
    let quadratic = of.models.iter().find(|model| model.model == "map of degree 2").unwrap();
    assert_eq!((quadratic.unknowns, quadratic.rank, quadratic.held_out_um), (12, 10, None));
}

/// Noise alone is left alone, in nearly all of a hundred records.
#[test]
fn noise_writes_nothing() {
    let quiet = (0..100).filter(|seed| {
        let text = record(&lattice(), |_, _| [0.0; 2], 2.0, 100 + seed);
        let found = found(&text, Some(&bare()));
        let nothing = found.model() == "placement alone";
        assert_eq!(found.machine.is_none(), nothing);
        nothing
    });
    let quiet = quiet.count();
    println!("{quiet} of 100 records of noise alone");
    assert!(quiet >= 90, "{quiet} of 100");
}

/// The rest of the machine stays and is not counted twice: the tip moves by exact transforms of a machine with levers, of which
/// only the errors in the plane are unknown.
#[test]
fn the_rest_of_the_machine_is_left_alone() {
    let mut truth = bare();
    truth.settings.compensation.model = ErrorModel::Volumetric;
    truth.settings.tool_mm = [0.0, 0.0, -60.0];
    truth.settings.location = LocationErrors { a0z: 20e-6, b0z: -35e-6, c0y: 45e-6, ..LocationErrors::default() };
    for (own, table) in truth.settings.axes.iter().zip(&mut truth.tables) {
        let phase = own.axis.index() as f64;
        let at = (0..=12).map(|k| -300.0 + 50.0 * f64::from(k));
        let own_rows = rows(at, |q| {
            std::array::from_fn(|c| {
                let size = if c < 3 { 5e-3 } else { 20e-6 };
                size * ((q / 120.0 + 1.7 * c as f64 + phase).sin() - (1.7 * c as f64 + phase).sin())
            })
        });
        *table = Some(Table { given: [true; 6], bidirectional: false, rows: own_rows });
    }
    let geometry = Geometry::new(&truth, 0.0).unwrap();
    let mut text = String::from(HEADER);
    let lattice: Vec<[f64; 2]> =
        (0..169).map(|k| [-300.0 + 50.0 * f64::from(k % 13), -300.0 + 50.0 * f64::from(k / 13)]).collect();
    let at = |x: f64, y: f64| [x, y, -120.0, 0.0, 0.0, 0.0];
    for &[x, y] in &lattice {
        let e = geometry.tip_error(&at(x, y), &[0.0; AXES]);
        writeln!(text, "{x},{y},-120,{},{},-120", x + PLACED[0] + e[0], y + PLACED[1] + e[1]).unwrap();
    }
    // What the machine states beside the errors in the plane, which are old values here.
    let mut stated = truth.clone();
    stated.settings.location.c0y = -10e-6;
    for (own, table) in stated.settings.axes.iter().zip(&mut stated.tables) {
        let old = |c: usize| c < 2 && own.axis != Axis::Z;
        let of = |row: [f64; 6]| std::array::from_fn(|c| if old(c) { -0.4 * row[c] } else { row[c] });
        for row in table.iter_mut().flat_map(|table| &mut table.rows) {
            (row.forward, row.reverse) = (of(row.forward), of(row.reverse));
        }
    }
    let found = found(&text, Some(&stated));
    let written = found.machine.as_ref().unwrap();
    assert_eq!(found.model(), "tables of 13 and 13 nodes");
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        for (new, old) in written.rows(axis).unwrap().iter().zip(stated.rows(axis).unwrap()) {
            let kept = if axis == Axis::Z { 0 } else { 2 };
            assert_eq!((new.position, &new.forward[kept..]), (old.position, &old.forward[kept..]), "{axis:?}");
        }
    }
    let (new, old) = (written.settings.location, stated.settings.location);
    assert_eq!((new.a0z, new.b0z), (old.a0z, old.b0z));
    let places: Vec<[f64; AXES]> = scattered(100, 4).iter().map(|[x, y]| at(*x, *y)).collect();
    let (errors, _) = own_tip_errors(written, &places).unwrap();
    let off: Vec<[f64; 2]> = places
        .iter()
        .zip(errors)
        .map(|(place, error)| {
            let e = geometry.tip_error(place, &[0.0; AXES]);
            [0, 1].map(|k| 1e3 * (error[k] - e[k]))
        })
        .collect();
    let rms = rigid_rms(&scattered(100, 4), &off);
    assert!(rms < 0.02, "{rms} µm RMS between the machines");
}

/// Two plates that agree share their terms; unrelated ones do not.
#[test]
fn terms_transfer_where_two_plates_agree() {
    let first = record(&scattered(300, 11), cubic, 1.5, 13);
    let against = |other: &str| {
        let (own, other) = (points(&first).unwrap(), points(other).unwrap());
        let found = identify_plane(&own, Some(&bare()), &Options::default(), Some((&other, "other.csv"))).unwrap();
        (found.transfer.clone().unwrap(), found.machine.is_some(), PlaneDocument::new(&found, false).notes)
    };
    let (test, written, _) = against(&record(&scattered(250, 12), cubic, 1.5, 14));
    assert!(test.transfers && written && test.areas == 16, "{test:?}");
    // What is left is the noise of both directions and of the terms.
    assert!(test.after_um < 1.1 * 1.5 * 2.0_f64.sqrt() && test.before_um > 3.5, "{test:?}");
    let (test, written, notes) = against(&record(&scattered(250, 12), |x, y| cubic(y, -x), 1.5, 14));
    assert!(!test.transfers && !written && test.after_um > test.before_um, "{test:?}");
    assert!(
        notes.iter().any(|note| note.contains("do not transfer to other.csv") && note.ends_with("nothing is written"))
    );
    let unrelated = |seed: u64| {
        let mut noise = Noise::new(seed);
        let size: Vec<f64> = (0..12).map(|_| 6.0 * noise.signed()).collect();
        let map = |x: f64, y: f64| {
            let (u, v) = (x / 300.0, y / 300.0);
            let terms = [u * v, u * u, v * v, u * u * v, u * v * v, v * v * v];
            [0, 6].map(|k| terms.iter().zip(&size[k..]).map(|(term, size)| term * size).sum())
        };
        against(&record(&scattered(120, seed), map, 1.5, seed)).0
    };
    let transferred = (1000..1040).filter(|seed| unrelated(*seed).transfers).count();
    println!("{transferred} of 40 unrelated plates");
    assert!(transferred <= 4, "{transferred} of 40 unrelated plates");
}

#[test]
fn records_that_show_nothing_are_refused() {
    let good = record(&lattice(), |x, _| [0.02 * x, 0.0], 1.0, 3);
    let refused = |text: &str, message: &str| {
        let error =
            points(text).and_then(|points| identify_plane(&points, None, &Options::default(), None)).unwrap_err();
        let error = format!("{error:#}");
        assert!(error.contains(message), "{error} without {message}");
    };
    let lines: Vec<&str> = good.lines().collect();
    let of = |own: &[&str]| own.iter().map(|line| format!("{line}\n")).collect::<String>();
    refused(&of(&lines[..4]), "lines 2 to 4: found 3 points in a plane, needed at least 10");
    refused(&of(&lines[..10]), "lines 2 to 10: found 9 points in a plane, needed at least 10");
    refused(
        &format!("{good}{}\n", lines[3]),
        "plate.csv:65: column x_mm: found a second row for this position, as in line 4",
    );
    refused(
        &good.replacen("\n-100,-160,0,", "\n-100,-160,0,nan,0,0\n-100,-160,0,", 1),
        "plate.csv:3: column actual_x_mm: found",
    );
    // An actual coordinate in inches.
    let mut inches: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
    let cells: Vec<&str> = lines[5].split(',').collect();
    let actual: f64 = cells[4].parse().unwrap();
    inches[5] = [cells[0], cells[1], cells[2], cells[3], &(actual / 25.4).to_string(), cells[5]].join(",");
    refused(&inches.join("\n"), "plate.csv:6: column actual_y_mm: found");
    let tools = lines.iter().enumerate().map(|(i, line)| match i {
        0 => format!("{line},tool_x_mm,tool_y_mm,tool_z_mm\n"),
        _ => {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let x = f64::from(u8::from(i % 2 == 0));
            format!("{},{},{},{},{},{},{x},0,0\n", cells[0], cells[1], cells[2], cells[3] + x, cells[4], cells[5])
        }
    });
    refused(&tools.collect::<String>(), "column tool_x_mm: found 2 reflector offsets, needed one");
    let own = points(&good).unwrap();
    let without = Options { without: vec!["EBX".into()], ..Options::default() };
    let error = identify_plane(&own, None, &without, None).unwrap_err();
    assert!(error.to_string().starts_with("--without: found EBX"), "{error}");
    let upright = points(&good.lines().map(swapped).collect::<String>()).unwrap();
    let error = identify_plane(&own, None, &Options::default(), Some((&upright, "upright.csv"))).unwrap_err();
    assert!(
        format!("{error:#}").contains("upright.csv: found points over X and Z, needed points over X and Y"),
        "{error:#}"
    );
    // The squareness of an upright plane: dx = B0Z·z.
    let tilted = record(&lattice(), |_, y| [0.05 * y, 0.0], 0.0, 3);
    let tilted: String = tilted.lines().map(swapped).collect();
    let of = document(&tilted);
    assert!(of.plane == ['X', 'Z'] && of.terms[2].name == "B0Z", "{of:?}");
    assert!((of.terms[2].of.value - 50.0).abs() < 1e-6, "{:?}", of.terms);
}

/// A row with Y and Z exchanged.
fn swapped(line: &str) -> String {
    let cells: Vec<&str> = line.split(',').collect();
    if cells[0] == "x_mm" {
        return HEADER.into();
    }
    [cells[0], cells[2], cells[1], cells[3], cells[5], cells[4]].join(",") + "\n"
}

/// The plates that were measured, if available; they are not part of this repository.
fn plates() -> Option<[Points; 2]> {
    let folder = std::env::var_os("TRUEAXIS_REFERENCE_DATA")
        .map(PathBuf::from)
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"));
    let read = |name: &str| points(&std::fs::read_to_string(folder.join("real").join(name)).ok()?).ok();
    let plates = read("plate-a.csv").zip(read("plate-b.csv"));
    if plates.is_none() {
        println!("skipped: no real/plate-a.csv and real/plate-b.csv in {}", folder.display());
    }
    plates.map(|(a, b)| [a, b])
}

/// Every second point of a record.
fn half(of: &Points, first: usize) -> Points {
    let points = of.points.iter().skip(first).step_by(2).copied().collect();
    Points { points, ..of.clone() }
}

fn rms_of(points: &Points, model: impl Fn([f64; 2]) -> [f64; 2]) -> f64 {
    let squares = points.points.iter().map(|point| {
        let [x, y, _] = point.command_mm;
        let of = model([x, y]);
        (0..2).map(|k| (point.deviation_mm[k] - of[k]).powi(2)).sum::<f64>()
    });
    1e3 * (squares.sum::<f64>() / points.points.len() as f64).sqrt()
}

/// Polynomial of a total degree in powers of the coordinates over 350 mm, by normal equations and elimination with pivots.
fn polynomial(of: &Points, degree: i32) -> impl Fn([f64; 2]) -> [f64; 2] {
    let powers: Vec<[i32; 2]> = (0..=degree).flat_map(|i| (0..=degree - i).map(move |j| [i, j])).collect();
    let terms = move |[x, y]: [f64; 2]| -> Vec<f64> {
        powers.iter().map(|[i, j]| (x / 350.0).powi(*i) * (y / 350.0).powi(*j)).collect()
    };
    let n = terms([0.0; 2]).len();
    let mut system = vec![vec![0.0; n + 2]; n];
    for point in &of.points {
        let row = terms([point.command_mm[0], point.command_mm[1]]);
        for i in 0..n {
            for j in 0..n {
                system[i][j] += row[i] * row[j];
            }
            system[i][n] += row[i] * point.deviation_mm[0];
            system[i][n + 1] += row[i] * point.deviation_mm[1];
        }
    }
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| system[*a][k].abs().total_cmp(&system[*b][k].abs())).unwrap();
        system.swap(k, pivot);
        for i in (0..n).filter(|i| *i != k) {
            let share = system[i][k] / system[k][k];
            for j in k..n + 2 {
                system[i][j] -= share * system[k][j];
            }
        }
    }
    move |at| {
        let terms = terms(at);
        [0, 1].map(|c| terms.iter().enumerate().map(|(k, term)| term * system[k][n + c] / system[k][k]).sum())
    }
}

/// On the measured plates: the figures of NumPy's least squares (lstsq over the same rows), half to half within 5 % of the best
/// polynomial, and terms of one plate that the other refuses.
#[test]
fn measured_plates() {
    let Some(plates) = plates() else { return };
    let residuals = [[9.01, 8.05, 7.39, 5.98, 5.89, 5.83], [7.68, 5.83, 5.02, 4.27, 4.03, 3.80]];
    for (plate, numpy) in plates.iter().zip(residuals) {
        let found = identify_plane(plate, None, &Options::default(), None).unwrap();
        let of = PlaneDocument::new(&found, false);
        for (model, um) in of.models.iter().zip(numpy) {
            assert!((model.left_um - um).abs() < 0.006, "{model:?}, needed {um}");
        }
        assert!(of.held_out.rms_um < 0.70 * of.before.rms_um, "{of:?}");
        for first in [0, 1] {
            let (own, other) = (half(plate, first), half(plate, 1 - first));
            let found = identify_plane(&own, Some(&bare()), &Options::default(), Some((&other, "half"))).unwrap();
            let left = rms_of(&other, |at| found.deviation_mm(at));
            let best = (1..=8).map(|degree| rms_of(&other, polynomial(&own, degree))).fold(f64::INFINITY, f64::min);
            println!("{}: {left:.2} µm at the other half, best polynomial {best:.2}", found.model());
            assert!(left < 1.05 * best, "{}: {left}, best polynomial {best}", found.model());
            let test = found.transfer.unwrap();
            assert!(test.transfers && found.machine.is_some(), "{test:?}");
        }
    }
    for [own, other] in [[0, 1], [1, 0]] {
        let found = identify_plane(&plates[own], Some(&bare()), &Options::default(), Some((&plates[other], "other")));
        let found = found.unwrap();
        let test = found.transfer.unwrap();
        println!("{:.2} -> {:.2} µm, p {:.3}", test.before_um, test.after_um, test.p);
        assert!(!test.transfers && test.after_um > test.before_um && found.machine.is_none(), "{test:?}");
    }
}
