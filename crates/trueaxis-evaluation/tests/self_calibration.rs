//! A plate of holes of unknown places on machines of known errors. Touches are intersections of the tip with round holes by
//! exact transforms.

use rayon::prelude::*;
use std::path::Path;
use trueaxis::machine::AXES;
use trueaxis_evaluation::calibrate::{
    Artefact, Calibration, Grid, Ideal, Kind, Logged, Plan, Planned, Task, Term, foresee, observe, perfect, settle,
    solved as solved_log,
};
use trueaxis_evaluation::simulated::rehearsal::{self, Conditions, Drift};
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_sim::calibration::{Class, random_machine};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::machine_files;

const PLATE: &str = "machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 2.0\nrepeats = 1\n\
                     [[plate]]\nname = \"plate\"\nkind = \"holes\"\ndiameter_mm = 20.0\ncolumns = 5\nrows = 5\n\
                     pitch_mm = 70.0\nat_mm = [215.0, 165.0, -200.0]\n";
const LENGTH: &str = "[plate.length]\nfrom = [1, 1]\nto = [5, 5]\nmm = 395.98\nuncertainty_um = 1.0\n";
const LIES: &str = "[[plate.placement]]\nturn_deg = 0\n";
const TURNED: &str = "[[plate.placement]]\nturn_deg = 90\n";
const ALONG_X: &str = "[[plate.placement]]\nmoved = [1, 0]\n";
const ALONG_Y: &str = "[[plate.placement]]\nmoved = [0, 1]\n";

fn task(parts: &[&str]) -> Task {
    Task::read(&format!("{PLATE}{}", parts.concat()), Path::new("task.toml")).unwrap_or_else(|e| panic!("{e}"))
}

fn whole() -> Task {
    task(&[LENGTH, LIES, TURNED, ALONG_X, ALONG_Y])
}

/// A machine with errors in the plane of X and Y alone, and its lost motion.
fn in_the_plane(seed: u64) -> Machine {
    let mut machine = random_machine(seed, &Class::MILL);
    (machine.settings.location.a0z, machine.settings.location.b0z) = (0.0, 0.0);
    for (own, table) in machine.settings.axes.iter().zip(&mut machine.tables) {
        if own.axis.index() == 2 {
            *table = None;
        }
        for row in table.iter_mut().flat_map(|table| &mut table.rows) {
            (2..6).for_each(|k| (row.forward[k], row.reverse[k]) = (0.0, 0.0));
        }
    }
    machine
}

/// A plate as it is, and where it is put down.
struct Real {
    /// From its middle, mm.
    centres: Vec<[f64; 2]>,
    diameters: Vec<f64>,
    /// For every placement: distance from its place, mm, and rotation, rad.
    put_down: Vec<[f64; 3]>,
}

impl Real {
    fn new(task: &Task, draws: &mut Draws) -> Real {
        let plate = task.artefacts.iter().find_map(|of| Some((grid(of)?, &of.places)));
        let (grid, places) = plate.expect("a plate");
        let mut draw = |size: f64| size * draws.normal();
        let centre = |ball| grid.offset(ball).map(|q| q + draw(0.03));
        let mut centres: Vec<[f64; 2]> = (0..grid.count()).map(centre).collect();
        let diameters = (0..grid.count()).map(|_| grid.diameter_mm + draw(0.01)).collect();
        if let Some([mm, uncertainty]) = grid.length_mm {
            let [[a, b], [c, d]] = grid.ends.map(|ball| centres[ball]);
            let scale = (mm + draw(uncertainty)) / (c - a).hypot(d - b);
            centres.iter_mut().flatten().for_each(|q| *q *= scale);
        }
        let within = |most: f64, by: f64| (by * most).clamp(-most, most);
        let put_down =
            places.iter().map(|_| [0.5, 0.5, 0.2_f64.to_radians()].map(|most| within(most, draw(0.5)))).collect();
        Real { centres, diameters, put_down }
    }

    /// Deviations from the nominal places as the two ends define them: the similarity that brings these to their places.
    fn deviations(&self, task: &Task) -> Vec<[f64; 2]> {
        let grid = task.artefacts.iter().find_map(grid).expect("a plate");
        let [from, to] = grid.ends;
        let [p, q] = [self.centres[from], self.centres[to]];
        let [a, b] = [grid.offset(from), grid.offset(to)];
        let (true_way, way) = ([q[0] - p[0], q[1] - p[1]], [b[0] - a[0], b[1] - a[1]]);
        // As complex numbers: the factor that turns the nominal way into the true one without its length.
        let lengths = true_way[0].hypot(true_way[1]) * way[0].hypot(way[1]);
        let cos = (true_way[0] * way[0] + true_way[1] * way[1]) / lengths;
        let sin = (true_way[1] * way[0] - true_way[0] * way[1]) / lengths;
        let longer = true_way[0].hypot(true_way[1]) / way[0].hypot(way[1]);
        (0..grid.count())
            .filter(|ball| !grid.ends.contains(ball))
            .map(|ball| {
                let [x, y] = [0, 1].map(|k| self.centres[ball][k] - p[k]);
                let back = [cos * x + sin * y, cos * y - sin * x];
                let nominal = grid.offset(ball);
                [0, 1].map(|k| back[k] - longer * (nominal[k] - a[k]))
            })
            .collect()
    }
}

fn grid(of: &Artefact) -> Option<&Grid> {
    match &of.kind {
        Kind::Grid(grid) => Some(grid),
        _ => None,
    }
}

/// The trips of a plan's touches on the true machine.
fn touched(
    task: &Task,
    truth: &Machine,
    plan: &Plan,
    real: &Real,
    (draws, noise_mm): (&mut Draws, f64),
) -> Vec<Logged> {
    let (geometry, ideal) = (Geometry::new(truth, 0.0).unwrap(), Ideal::new(truth).unwrap());
    let reach = |ball: usize| 0.5 * real.diameters[ball] - task.probe.tip_radius_mm;
    let trip = |(index, touch): (usize, &Planned)| {
        let place = &task.artefacts[touch.artefact].places[touch.place];
        let [dx, dy, turn] = real.put_down[touch.place];
        let [x, y, z] = place.at_mm;
        let middle = ideal.tip(&[x + dx, y + dy, z, 0.0, 0.0, 0.0]);
        let (sin, cos) = (turn + 0.5 * std::f64::consts::PI * f64::from(place.turn)).sin_cos();
        let [a, b] = real.centres[touch.feature];
        let centre = [middle[0] + cos * a - sin * b, middle[1] + sin * a + cos * b];
        let at = |share: f64| -> [f64; AXES] {
            std::array::from_fn(|k| touch.start[k] + share * (touch.end[k] - touch.start[k]))
        };
        let [rx, ry, rz] = touch.reverse;
        let reverse = ideal.ordered(&[rx, ry, rz, 0.0, 0.0, 0.0]);
        let gap = |share: f64| {
            let tip = geometry.actual_pose(&ideal.ordered(&at(share)), &reverse).tip_mm;
            reach(touch.feature) - (tip[0] - centre[0]).hypot(tip[1] - centre[1])
        };
        // Secant from the two ends.
        let (mut one, mut other): ((f64, f64), (f64, f64)) = ((0.3, gap(0.3)), (0.7, gap(0.7)));
        for _ in 0..20 {
            if (one.0 - other.0).abs() < 1e-10 || other.1 == one.1 {
                break;
            }
            let next = other.0 - other.1 * (other.0 - one.0) / (other.1 - one.1);
            (one, other) = (other, (next, gap(next)));
        }
        let way = task.probe.approach_mm + task.probe.overtravel_mm;
        Logged { line: index as u32 + 1, position: at(other.0 + noise_mm * draws.normal() / way), rotary: [true; 3] }
    };
    plan.touches.iter().enumerate().map(trip).collect()
}

/// Solves from touches on a plate put down by eye, or so much better.
fn solved(task: &Task, truth: &Machine, seed: u64, [noise_mm, by_eye]: [f64; 2]) -> (Calibration, Real) {
    let nominal = perfect(truth);
    let plan = Plan::new(task, &nominal).unwrap_or_else(|e| panic!("{e}"));
    let mut draws = Draws::new(seed, 0);
    let mut real = Real::new(task, &mut draws);
    real.put_down.iter_mut().flatten().for_each(|off| *off *= by_eye);
    let trips = touched(task, truth, &plan, &real, (&mut draws, noise_mm));
    let positions: Vec<[f64; AXES]> = trips.iter().map(|trip| trip.position).collect();
    let observed = observe(task, &nominal, &plan, &positions).unwrap();
    let found = settle(task, &plan, &trips, Path::new("probe.log"), observed);
    (found.unwrap_or_else(|e| panic!("seed {seed}: {e}")), real)
}

/// Error in the plane over a range of X and Y, without the best shift and rotation: root mean square, mm.
fn left(truth: &Machine, known: Option<&Machine>, [[x0, x1], [y0, y1]]: [[f64; 2]; 2]) -> f64 {
    let [truth, known] = [truth, known.unwrap_or(&perfect(truth))].map(|machine| {
        let mut machine = machine.clone();
        machine.settings.axes.iter_mut().for_each(|own| own.backlash = 0.0);
        Geometry::new(&machine, 0.0).unwrap()
    });
    let mut points = Vec::new();
    for i in 0..81 {
        let share = |i: i32| f64::from(i) / 8.0;
        let (x, y) = (x0 + (x1 - x0) * share(i % 9), y0 + (y1 - y0) * share(i / 9));
        let mut position = [0.0; AXES];
        (position[0], position[1], position[2]) = (x, y, -200.0);
        let [a, b] = [&truth, &known].map(|of| of.tip_error(&position, &[0.0; AXES]));
        points.push(([x - 0.5 * (x0 + x1), y - 0.5 * (y0 + y1)], [a[0] - b[0], a[1] - b[1]]));
    }
    let count = points.len() as f64;
    let mean = [0, 1].map(|k| points.iter().map(|(_, e)| e[k]).sum::<f64>() / count);
    let inertia: f64 = points.iter().map(|([x, y], _)| x * x + y * y).sum();
    let turn = points.iter().map(|([x, y], e)| x * e[1] - y * e[0]).sum::<f64>() / inertia;
    let squares =
        |&([x, y], e): &([f64; 2], [f64; 2])| (e[0] - mean[0] + turn * y).powi(2) + (e[1] - mean[1] - turn * x).powi(2);
    (points.iter().map(squares).sum::<f64>() / count).sqrt()
}

pub(crate) fn written(task: &Task, truth: &Machine, found: &Calibration) -> Machine {
    let files = || machine_files(&perfect(truth), "").into_iter().map(|(name, text)| (name.into(), text));
    let all: Vec<(std::path::PathBuf, String)> = files().collect();
    let edited = found.additions(task).edit(&Memory::new(all.clone()), Path::new("machine.toml")).unwrap();
    let all = all.into_iter().chain(edited.files);
    Machine::read_from(&Memory::new(all), Path::new("machine.toml"), &mut |_| {}).unwrap()
}

/// Random machines of four structures: squareness, scale, bows and waves of X and Y, lost motion, a plate of unknown places
/// put down by eye, a probe of 1 µm and a length known to 1 µm.
#[test]
fn four_placements_remove_the_errors_in_their_plane() {
    let task = whole();
    let removed = |seed: u64| {
        let truth = in_the_plane(seed);
        let (found, _) = solved(&task, &truth, seed, [1e-3, 1.0]);
        let known = written(&task, &truth, &found);
        [[[0.0, 500.0], [0.0, 400.0]], [[75.0, 425.0], [25.0, 375.0]]]
            .map(|range| 1.0 - left(&truth, Some(&known), range) / left(&truth, None, range))
    };
    let shares: Vec<[f64; 2]> = (1..=200_u64).into_par_iter().map(removed).collect();
    for (range, where_) in ["over the travels", "where the plate was"].into_iter().enumerate() {
        let mut shares: Vec<f64> = shares.iter().map(|both| both[range]).collect();
        shares.sort_by(f64::total_cmp);
        println!("removed {where_}: median {:.3}, least {:.3}", shares[100], shares[0]);
        assert!(shares[0] > 0.0, "a machine is made worse {where_}: {}", shares[0]);
        assert!(shares[100] > 0.75, "{where_}: {}", shares[100]);
    }
}

/// Values at the lines of the plate without their least-squares line, mm.
pub(crate) fn shape(lines: &[f64], draws: &mut Draws) -> Vec<f64> {
    let values: Vec<f64> = lines.iter().map(|_| 4e-3 * draws.normal()).collect();
    let count = lines.len() as f64;
    let mean = |of: &[f64]| of.iter().sum::<f64>() / count;
    let (middle, level) = (mean(lines), mean(&values));
    let slope = lines.iter().zip(&values).map(|(q, v)| (q - middle) * v).sum::<f64>()
        / lines.iter().map(|q| (q - middle).powi(2)).sum::<f64>();
    lines.iter().zip(&values).map(|(q, v)| v - level - slope * (q - middle)).collect()
}

/// Errors that are linear between the lines of the plate, and their true values.
struct Linear {
    machine: Machine,
    /// Axis, component, line and shape of each of the four curves, mm.
    shapes: Vec<(usize, usize, Vec<f64>)>,
    squareness: f64,
    scales: [f64; 2],
}

const LINES: [[f64; 6]; 2] = [[75.0, 145.0, 215.0, 285.0, 355.0, 425.0], [25.0, 95.0, 165.0, 235.0, 305.0, 375.0]];
const ENDS: [f64; 2] = [500.0, 400.0];

fn linear(seed: u64) -> Linear {
    let mut draws = Draws::new(seed, 1);
    let mut draw = |size: f64| size * draws.normal();
    let (squareness, scales) = (draw(40e-6), [draw(40e-6), draw(40e-6)]);
    let mut shapes = Vec::new();
    let (mut tables, mut axes) = (Vec::new(), String::new());
    for axis in 0..2 {
        let letter = ["X", "Y"][axis];
        let both = [0, 1].map(|_| shape(&LINES[axis], &mut draws));
        let mut rows = format!("{letter}_mm,EX{letter}_um,EY{letter}_um\n");
        let last = LINES[axis].len() - 1;
        let inner = LINES[axis].iter().enumerate().map(|(at, q)| (*q, at));
        for (q, at) in std::iter::once((0.0, 0)).chain(inner).chain([(ENDS[axis], last)]) {
            let of =
                |component: usize| 1e3 * (both[component][at] + if component == axis { scales[axis] * q } else { 0.0 });
            rows += &format!("{q},{:.9},{:.9}\n", of(0), of(1));
        }
        axes += &format!("[axis.{letter}]\ntravel_mm = [0.0, {}]\ntable = \"{letter}.csv\"\n", ENDS[axis]);
        tables.push((format!("{letter}.csv"), rows));
        let [first, second] = both;
        shapes.extend([(axis, 0, first), (axis, 1, second)]);
    }
    let text = format!(
        "name = \"mill\"\nchain = \"w Y' X' b Z t\"\n[location]\nC0Y_urad = {}\n{axes}[axis.Z]\ntravel_mm = [-300.0, 0.0]\n",
        1e6 * squareness
    );
    let files = std::iter::once(("machine.toml".to_owned(), text)).chain(tables);
    let machine = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap();
    Linear { machine, shapes, squareness, scales }
}

/// Deviations and standard errors of the terms, of the curves at the lines, and of the places of the holes.
fn compared(task: &Task, seed: u64, conditions: [f64; 2]) -> Vec<(String, f64, f64)> {
    let truth = linear(seed);
    let (found, real) = solved(task, &truth.machine, seed, conditions);
    let Calibration { observed, solution, .. } = &found;
    let mut all = Vec::new();
    for (index, term) in observed.terms.terms.iter().enumerate() {
        let expected = match *term {
            Term::Squareness(0) => truth.squareness,
            Term::Curve { axis, degree: 1, .. } => truth.scales[axis.index()],
            _ => continue,
        };
        all.push((observed.names[index].clone(), solution.values[index] - expected, solution.standard_errors[index]));
    }
    for (axis, component, shape) in &truth.shapes {
        let of = [trueaxis::machine::Axis::X, trueaxis::machine::Axis::Y][*axis];
        for (q, value) in LINES[*axis].iter().zip(shape).skip(1) {
            let [mm, error] = found.shape(of, *component as u8, *q, false);
            all.push((format!("E{component}{axis} at {q}"), mm - (value - shape[0]), error));
        }
    }
    let deviations = real.deviations(task).into_iter().flatten();
    for (index, expected) in observed.sizes[0].iter().zip(deviations) {
        all.push((
            observed.names[*index].clone(),
            solution.values[*index] - expected,
            solution.standard_errors[*index],
        ));
    }
    assert_eq!(all.len(), 3 + 4 * 5 + 2 * 23);
    all
}

#[test]
fn exact_touches_give_every_term_and_every_place() {
    let mut task = whole();
    task.artefacts.iter_mut().for_each(|of| {
        if let Kind::Grid(grid) = &mut of.kind {
            grid.length_mm = grid.length_mm.map(|[mm, _]| [mm, 1e-9]);
        }
    });
    // Put down by eye, a hole is touched 1 mm beside its middle: at a slope of 1 in 8, by which a local skew shifts it.
    for (by_eye, most_urad, most_um) in [(0.0, 0.02, 0.01), (1.0, 0.3, 0.15)] {
        for (name, off, _) in compared(&task, 3, [0.0, by_eye]) {
            let is_linear = name.starts_with("squareness") || name.starts_with("scale");
            let most = if is_linear { 1e-6 * most_urad } else { 1e-3 * most_um };
            assert!(off.abs() < most, "{name}: {off}");
        }
    }
}

#[test]
fn standard_errors_cover_terms_curves_and_places() {
    let task = whole();
    let all: Vec<_> = (1..=60_u64).into_par_iter().flat_map_iter(|seed| compared(&task, seed, [1e-3, 1.0])).collect();
    let rms = |of: &dyn Fn(&str) -> bool| {
        let scores: Vec<f64> =
            all.iter().filter(|(name, ..)| of(name)).map(|(_, off, error)| (off / error).powi(2)).collect();
        (scores.iter().sum::<f64>() / scores.len() as f64).sqrt()
    };
    let terms = rms(&|name| name.starts_with("squareness") || name.starts_with("scale"));
    let [curves, places] = [rms(&|name| name.starts_with('E')), rms(&|name| name.starts_with("hole"))];
    let every = rms(&|_| true);
    println!("deviation over standard error: terms {terms:.2}, curves {curves:.2}, places {places:.2}, all {every:.2}");
    assert!((0.9..1.1).contains(&every), "{every}");
    // 180 and 1,200 values, which are correlated.
    assert!((0.85..1.15).contains(&terms) && (0.85..1.15).contains(&curves) && (0.85..1.15).contains(&places));
}

/// Number of combinations that the placements leave free, and the refusal.
fn free(parts: &[&str]) -> (usize, String) {
    let task = task(parts);
    let nominal = perfect(&linear(1).machine);
    let plan = Plan::new(&task, &nominal).unwrap();
    match foresee(&task, &nominal, &plan) {
        Ok(found) => {
            assert_eq!(found.solution.rank, found.observed.names.len());
            (0, String::new())
        }
        Err(refused) => {
            let text = refused.to_string();
            let figures = text.split_once("rank ").unwrap().1.split_once(" unknowns").unwrap().0;
            let (rank, count) = figures.split_once(" of ").unwrap();
            (count.parse::<usize>().unwrap() - rank.parse::<usize>().unwrap(), text)
        }
    }
}

/// Let f be the machine's error at the plate and n the lines along an axis. A placement shows f up to the deviations of the
/// plate's own places. A second one leaves free what it has in common with the first: f(x + p) − f(x) rigid, or
/// R⁻¹ f(R x) − f(x) rigid. Terms: three linear ones (squareness, two scales) and n − 2 shapes in each of four curves.
#[test]
fn the_rank_is_what_symmetry_says() {
    // Unknown and known length. All terms; the length fixes one combination of them.
    assert_eq!([free(&[LIES]).0, free(&[LENGTH, LIES]).0], [3 + 4 * 3, 3 + 4 * 3 - 1]);
    // Turned by 90°, (a u(x), a u(y)) and (−b u(y), b u(x)) of odd degree look the same: with 5 lines one shape is odd, and the
    // scale.
    assert_eq!([free(&[LIES, TURNED]).0, free(&[LENGTH, LIES, TURNED]).0], [3, 2]);
    // By 180° every odd shape of every curve does, and everything linear.
    let half = TURNED.replace("90", "180");
    assert_eq!([free(&[LIES, &half]).0, free(&[LENGTH, LIES, &half]).0], [7, 6]);
    // Moved along X, the curves of Y and everything linear.
    assert_eq!([free(&[LIES, ALONG_X]).0, free(&[LENGTH, LIES, ALONG_X]).0], [3 + 2 * 3, 3 + 2 * 3 - 1]);
    assert_eq!([free(&[LIES, ALONG_X, ALONG_Y]).0, free(&[LENGTH, LIES, ALONG_X, ALONG_Y]).0], [3, 2]);
    // Turned and moved along one axis, nothing but the scale: the fourth placement adds accuracy.
    assert_eq!([free(&[LIES, TURNED, ALONG_X]).0, free(&[LENGTH, LIES, TURNED, ALONG_X]).0], [1, 0]);
    let all = [LIES, TURNED, ALONG_X, ALONG_Y];
    assert_eq!([free(&all).0, free(&[&[LENGTH][..], &all].concat()).0], [1, 0]);
}

/// What the refusal asks for is what is missing, and it is enough.
#[test]
fn the_refusal_asks_for_what_is_missing() {
    let needed = |parts: &[&str]| free(parts).1.split_once("needed ").map(|(_, needed)| needed.to_owned());
    let said = |text: &str| Some(text.to_owned());
    let (turn, shift) =
        ("a [[plate.placement]] with turn_deg = 90", "a [[plate.placement]] with moved = [1, 0] or moved = [0, 1]");
    let length = "[plate.length] between two of its holes";
    assert_eq!(needed(&[LIES]), said(&format!("{turn}; and {shift}; and {length}")));
    assert_eq!(needed(&[LENGTH, LIES, TURNED]), said(shift));
    assert_eq!(needed(&[LENGTH, LIES, ALONG_X, ALONG_Y]), said(turn));
    assert_eq!(needed(&[LIES, TURNED, ALONG_Y]), said(length));
    // Where no scale is asked for, the machine gives the length.
    let no_scale = "[solve]\nscale = false\n";
    assert_eq!(needed(&[LIES, TURNED, no_scale]), said(shift));
    assert_eq!(needed(&[LIES, TURNED, ALONG_X, no_scale]), None);
    // Turned about its middle, a plate of 5 × 4 is half a pitch off its lines.
    let odd = |parts: &[&str]| {
        let text = format!("{}{}", PLATE.replace("rows = 5", "rows = 4"), parts.concat());
        let (task, nominal) = (Task::read(&text, Path::new("task.toml")).unwrap(), perfect(&linear(1).machine));
        let plan = Plan::new(&task, &nominal).unwrap();
        foresee(&task, &nominal, &plan).map(|_| ()).map_err(|refused| refused.to_string())
    };
    let known = "[plate.length]\nfrom = [1, 1]\nto = [5, 4]\nmm = 350.0\nuncertainty_um = 1.0\n";
    let refused = odd(&[known, LIES]).unwrap_err();
    assert!(
        refused.contains("turn_deg = 90 and moved = [0.5, 0.5]; and a [[plate.placement]] with moved"),
        "{refused}"
    );
    assert_eq!(odd(&[known, LIES, &format!("{TURNED}moved = [0.5, 0.5]\n"), ALONG_X]), Ok(()));
}

/// A centre is the middle of two touches: either may be wrong.
#[test]
fn a_wrong_centre_names_both_of_its_touches() {
    let (task, truth) = (whole(), linear(1).machine);
    let nominal = perfect(&truth);
    let plan = Plan::new(&task, &nominal).unwrap();
    let mut draws = Draws::new(1, 0);
    let real = Real::new(&task, &mut draws);
    let mut trips = touched(&task, &truth, &plan, &real, (&mut draws, 1e-3));
    // The third touch of the 15th hole, opposite the first.
    trips[58].position[0] += 0.2;
    let positions: Vec<[f64; AXES]> = trips.iter().map(|trip| trip.position).collect();
    let observed = observe(&task, &nominal, &plan, &positions).unwrap();
    let refused = settle(&task, &plan, &trips, Path::new("probe.log"), observed).unwrap_err().to_string();
    assert!(refused.contains("touch 57 or 59 on plate"), "{refused}");
}

/// What is known of every touch of a plan, such as its tip, counts at the centres of the network.
#[test]
fn quantities_of_the_touches_are_known_at_the_centres() {
    let (task, nominal) = (whole(), perfect(&linear(1).machine));
    let (plan, ideal) = (Plan::new(&task, &nominal).unwrap(), Ideal::new(&nominal).unwrap());
    let positions: Vec<[f64; AXES]> = plan.touches.iter().map(|touch| touch.end).collect();
    let tips: Vec<[f64; 3]> = positions.iter().map(|position| ideal.tip(position)).collect();
    let observed = observe(&task, &nominal, &plan, &positions).unwrap();
    let found = observed.at_network(&tips);
    assert_eq!((found.len(), tips.len()), (observed.network.touches.len(), 2 * found.len()));
    for (found, touch) in found.iter().zip(&observed.network.touches) {
        let off = (0..3).map(|k| (found[k] - touch.tip_mm[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{found:?}, needed {:?}", touch.tip_mm);
    }
}

/// Entered a few micrometres off the lines of the first placement, or higher, a plate is not moved.
#[test]
fn a_placement_off_its_lines_by_micrometres_is_not_moved() {
    let off = TURNED.to_owned() + "at_mm = [215.05, 164.95, -200.0]\n";
    let exact = free(&[LENGTH, LIES, TURNED]);
    assert_eq!((free(&[LENGTH, LIES, &off]), exact.0), (exact.clone(), 2));
    let again = LIES.to_owned() + "at_mm = [215.03, 165.0, -200.0]\n";
    let higher = LIES.to_owned() + "at_mm = [215.0, 165.0, -199.0]\n";
    for same in [again, higher] {
        let (count, text) = free(&[LENGTH, LIES, TURNED, &same]);
        assert!(count == 2 && text.contains("without a moved placement"), "{count}: {text}");
    }
}

/// Nothing goes lower than the stated height, where the bottom of a hole or the plate is near.
#[test]
fn the_tip_stays_above_the_height_of_the_touches() {
    for (kind, normal, axis, height) in
        [("holes", "Z", 2, -200.0), ("balls", "Z", 2, -200.0), ("balls", "Y", 1, 165.0), ("holes", "X", 0, 215.0)]
    {
        let text = PLATE.replace("\"holes\"", &format!("\"{kind}\"")).replace("= 5\n", "= 3\n").replace("70.0", "50.0");
        let text = format!("{text}[[plate.placement]]\nnormal = \"{normal}\"\n");
        let task = Task::read(&text, Path::new("task.toml")).unwrap_or_else(|e| panic!("{e}"));
        let plan = Plan::new(&task, &perfect(&linear(1).machine)).unwrap_or_else(|e| panic!("{e}"));
        for touch in &plan.touches {
            let lowest = touch.start[axis].min(touch.end[axis]).min(touch.take_up[axis]);
            assert!(lowest == height && touch.take_up[axis] > height, "{kind}, {normal}: {touch:?}");
        }
    }
}

/// Balls on a plate upright in X and Z, turned onto its other edge and moved, through program, probing and log.
#[test]
fn a_plate_on_edge_gives_the_terms_of_z() {
    const UPRIGHT: &str = "machine = \"mill\"\ndialect = \"grblhal\"\n[probe]\ntip_radius_mm = 2.0\nrepeats = 1\n\
                           [[plate]]\nname = \"tower\"\nkind = \"balls\"\ndiameter_mm = 20.0\ncolumns = 3\nrows = 3\n\
                           pitch_mm = 60.0\nat_mm = [250.0, 200.0, -180.0]\n\
                           [plate.length]\nfrom = [1, 1]\nto = [3, 1]\nmm = 120.005\nuncertainty_um = 0.01\n\
                           [[plate.placement]]\nnormal = \"Y\"\n[[plate.placement]]\nnormal = \"Y\"\nturn_deg = 90\n\
                           [[plate.placement]]\nnormal = \"Y\"\nmoved = [1, 0]\n";
    const AXES: &str = "[axis.X]\ntravel_mm = [0.0, 500.0]\ntable = \"x.csv\"\nbacklash_um = 5.0\n[axis.Y]\n\
                        travel_mm = [0.0, 400.0]\n[axis.Z]\ntravel_mm = [-300.0, 0.0]\ntable = \"z.csv\"\n\
                        [location]\nB0Z_urad = -20.0\n";
    let machine = format!("name = \"mill\"\nchain = \"w X' Y' b Z t\"\n{AXES}");
    let tables = [("x.csv", "X_mm,EXX_um\n0,0\n500,20\n"), ("z.csv", "Z_mm,EZZ_um\n-300,-6\n0,0\n")];
    let files = tables.map(|(name, text)| (name, text.to_owned())).into_iter().chain([("machine.toml", machine)]);
    let truth = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap();
    let (task, nominal) = (Task::read(UPRIGHT, Path::new("task.toml")).unwrap(), perfect(&truth));
    let conditions = Conditions { noise_um: Some(0.0), drift: Drift::Size(0.0), seed: 4, set_up: 4 };
    let log = rehearsal::calibrate(&task, &nominal, &truth, &conditions).unwrap_or_else(|e| panic!("{e:#}"));
    let (_, found) =
        solved_log(&task, &nominal, &log, Path::new("probe.log"), |_| {}).unwrap_or_else(|e| panic!("{e}"));
    for (name, expected) in [("squareness B0Z", -20e-6), ("scale of X", 40e-6), ("scale of Z", 20e-6)] {
        let at = found.observed.names.iter().position(|of| of == name).unwrap_or_else(|| panic!("{name}"));
        let value = found.solution.values[at];
        // Logged to 0.1 µm.
        assert!((value - expected).abs() < 2e-6, "{name}: {value}");
    }
    assert_eq!(found.lines.len(), 3 * 9 * 4);
}
