//! A plate of balls of unknown places on edge, on machines of known errors: through plan, rehearsed probing, log and solve.

use crate::self_calibration::{shape, written};
use rayon::prelude::*;
use std::path::Path;
use trueaxis::machine::{AXES, Axis};
use trueaxis_evaluation::calibrate::{Calibration, Task, perfect, solved};
use trueaxis_evaluation::simulated::rehearsal::{self, Conditions, Drift};
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_sim::calibration::{Class, random_machine};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::files::Memory;
use trueaxis_testing::share::share;

/// Middle of the plate, mm.
const MIDDLE: [f64; 3] = [250.0, 200.0, -175.0];
const TRAVELS: [[f64; 2]; 3] = [[0.0, 500.0], [0.0, 400.0], [-300.0, 0.0]];

/// The plane of Z and X (0) or Y (1).
#[derive(Clone, Copy)]
struct Plane(usize);

impl Plane {
    fn letter(self) -> char {
        ['X', 'Y'][self.0]
    }

    fn axis(self) -> Axis {
        [Axis::X, Axis::Y][self.0]
    }

    /// Lines of balls along X or Y, and along Z, where the third placement adds one.
    fn lines(self) -> [Vec<f64>; 2] {
        let from = |middle: f64, count: i32| (0..count).map(move |k| middle - 100.0 + 50.0 * f64::from(k)).collect();
        [from(MIDDLE[self.0], 5), from(MIDDLE[2], 6)]
    }
}

/// Upright, on its other edge, a pitch higher; a touch of 1 µm, one on each side, and a length known to 1 µm.
fn task(plane: Plane) -> Task {
    let (normal, higher) = [("Y", "[1, 0]"), ("X", "[0, 1]")][plane.0];
    let text = format!(
        "machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 2.0\nrepeats = 1\nrepeatability_um = 1.0\n\
         [[plate]]\nname = \"tower\"\nkind = \"balls\"\ndiameter_mm = 20.0\ncolumns = 5\nrows = 5\npitch_mm = 50.0\n\
         at_mm = {MIDDLE:?}\n[plate.length]\nfrom = [1, 1]\nto = [5, 5]\nmm = 282.843\nuncertainty_um = 1.0\n\
         [[plate.placement]]\nnormal = \"{normal}\"\n[[plate.placement]]\nnormal = \"{normal}\"\nturn_deg = 90\n\
         [[plate.placement]]\nnormal = \"{normal}\"\nmoved = {higher}\n"
    );
    Task::read(&text, Path::new("task.toml")).unwrap_or_else(|error| panic!("{error}"))
}

fn found(task: &Task, truth: &Machine, seed: u64) -> Calibration {
    let nominal = perfect(truth);
    let conditions = Conditions { noise_um: Some(1.0), drift: Drift::Size(0.0), seed, set_up: seed };
    let log = rehearsal::calibrate(task, &nominal, truth, &conditions).unwrap_or_else(|e| panic!("seed {seed}: {e:#}"));
    let (_, found) = solved(task, &nominal, &log, Path::new("probe.log"), |_| {})
        .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    found
}

/// What remains of the errors of Z, mm: along a line of Z, root mean square of EZ and of the sideways error from the direction
/// of X or Y, without the mean.
fn left(truth: &Machine, known: &Machine, plane: Plane) -> f64 {
    let [truth, known] = [truth, known].map(|machine| {
        let mut machine = machine.clone();
        machine.settings.axes.iter_mut().for_each(|own| own.backlash = 0.0);
        Geometry::new(&machine, 0.0).unwrap()
    });
    let difference = |axis: usize, share: f64| {
        let mut position = [0.0; AXES];
        position[..3].copy_from_slice(&MIDDLE);
        let [low, high] = TRAVELS[axis];
        position[axis] = low + share * (high - low);
        let [a, b] = [&truth, &known].map(|of| of.tip_error(&position, &[0.0; AXES]));
        [position[axis], a[plane.0] - b[plane.0], a[2] - b[2]]
    };
    let along = |axis: usize| (0..=40).map(|k| difference(axis, f64::from(k) / 40.0)).collect::<Vec<_>>();
    let mean = |points: &[[f64; 3]], k: usize| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
    let across = along(plane.0);
    let [middle, level] = [0, 2].map(|k| mean(&across, k));
    let slope = across.iter().map(|p| (p[0] - middle) * (p[2] - level)).sum::<f64>()
        / across.iter().map(|p| (p[0] - middle).powi(2)).sum::<f64>();
    let line: Vec<[f64; 3]> = along(2).iter().map(|[z, side, up]| [*z, side + slope * z, *up]).collect();
    let [side, up] = [1, 2].map(|k| mean(&line, k));
    let squares = line.iter().map(|p| (p[1] - side).powi(2) + (p[2] - up).powi(2));
    (squares.sum::<f64>() / line.len() as f64).sqrt()
}

/// Random mills of four structures with every error of the class, also those that the plate does not see.
#[test]
fn three_placements_on_edge_remove_the_errors_of_z() {
    let count = share(200);
    let removed = |seed: u64| {
        let plane = Plane((seed % 2) as usize);
        let (task, truth) = (task(plane), random_machine(seed, &Class::MILL));
        let known = written(&task, &truth, &found(&task, &truth, seed));
        1.0 - left(&truth, &known, plane) / left(&truth, &perfect(&truth), plane)
    };
    let mut shares: Vec<f64> = (1..=count as u64).into_par_iter().map(removed).collect();
    shares.sort_by(f64::total_cmp);
    let median = shares[shares.len() / 2];
    println!("removed of Z on {count} machines: median {median:.3}, least {:.3}", shares[0]);
    assert!(shares[0] > 0.0, "a machine is made worse: {}", shares[0]);
    assert!(median > 0.75, "{median}");
}

/// Errors in the plane that are linear between the lines, with their true values.
struct Linear {
    machine: Machine,
    squareness: f64,
    scales: [f64; 2],
    /// Along X or Y, and Z: shape of the error in either direction at the lines, mm.
    shapes: [[Vec<f64>; 2]; 2],
}

fn linear(plane: Plane, seed: u64) -> Linear {
    let mut draws = Draws::new(seed, 1);
    let mut draw = |size: f64| size * draws.normal();
    let (squareness, scales) = (draw(40e-6), [draw(40e-6), draw(40e-6)]);
    let lines = plane.lines();
    let shapes = [0, 1].map(|axis| [0, 1].map(|_| shape(&lines[axis], &mut draws)));
    let letters = [plane.letter(), 'Z'];
    let (mut files, mut axes) = (Vec::new(), String::new());
    for (axis, letter) in letters.into_iter().enumerate() {
        let mut rows = format!("{letter}_mm,E{}{letter}_um,EZ{letter}_um\n", plane.letter());
        let [low, high] = TRAVELS[[plane.0, 2][axis]];
        let last = lines[axis].len() - 1;
        let inner = lines[axis].iter().enumerate().map(|(at, q)| (*q, at));
        for (q, at) in std::iter::once((low, 0)).chain(inner).chain([(high, last)]) {
            let of = |side: usize| 1e3 * (shapes[axis][side][at] + if side == axis { scales[axis] * q } else { 0.0 });
            rows += &format!("{q},{:.9},{:.9}\n", of(0), of(1));
        }
        files.push((format!("{letter}.csv"), rows));
    }
    for (letter, [low, high]) in ['X', 'Y', 'Z'].into_iter().zip(TRAVELS) {
        axes += &format!("[axis.{letter}]\ntravel_mm = [{low:?}, {high:?}]\n");
        if letters.contains(&letter) {
            axes += &format!("table = \"{letter}.csv\"\n");
        }
    }
    let text = format!(
        "name = \"mill\"\nchain = \"w Y' X' b Z t\"\n[location]\n{}_urad = {}\n{axes}",
        ["B0Z", "A0Z"][plane.0],
        1e6 * squareness
    );
    let files = files.into_iter().chain([("machine.toml".to_owned(), text)]);
    let machine = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap();
    Linear { machine, squareness, scales, shapes }
}

/// Deviations of terms and of curves at the lines, and their standard errors.
fn compared(seed: u64) -> Vec<(bool, f64, f64)> {
    let plane = Plane((seed % 2) as usize);
    let truth = linear(plane, seed);
    let found = found(&task(plane), &truth.machine, seed);
    let mut all = Vec::new();
    let names = [
        (format!("squareness {}", ["B0Z", "A0Z"][plane.0]), truth.squareness),
        (format!("scale of {}", plane.letter()), truth.scales[0]),
        ("scale of Z".to_owned(), truth.scales[1]),
    ];
    for (name, expected) in names {
        let at = found.observed.names.iter().position(|of| *of == name).unwrap_or_else(|| panic!("no {name}"));
        all.push((true, found.solution.values[at] - expected, found.solution.standard_errors[at]));
    }
    for (axis, lines) in plane.lines().iter().enumerate() {
        // A curve is zero at the line nearest to the machine's zero: the lowest of X or Y, the highest of Z.
        let zero = [0, lines.len() - 1][axis];
        for (side, shape) in truth.shapes[axis].iter().enumerate() {
            for at in (0..lines.len()).filter(|at| *at != zero) {
                let of = [plane.axis(), Axis::Z][axis];
                let [mm, error] = found.shape(of, [plane.0, 2][side] as u8, lines[at], false);
                all.push((false, mm - (shape[at] - shape[zero]), error));
            }
        }
    }
    all
}

#[test]
fn standard_errors_of_a_plate_on_edge_cover_terms_and_curves() {
    let count = share(200);
    let all: Vec<_> = (1..=count as u64).into_par_iter().flat_map_iter(compared).collect();
    let rms = |terms: bool| {
        let scores: Vec<f64> =
            all.iter().filter(|(of, ..)| *of == terms).map(|(_, off, error)| (off / error).powi(2)).collect();
        (scores.iter().sum::<f64>() / scores.len() as f64).sqrt()
    };
    let (terms, curves) = (rms(true), rms(false));
    println!("deviation over standard error on {count} machines: terms {terms:.2}, curves {curves:.2}");
    // Four standard deviations of the root mean square of as many independent values; curves are 18 values a machine,
    // correlated.
    let wide = |values: usize| 4.0 / (2.0 * values as f64).sqrt();
    assert!((terms - 1.0).abs() < wide(3 * count), "{terms}");
    assert!((curves - 1.0).abs() < wide(4 * count), "{curves}");
}
