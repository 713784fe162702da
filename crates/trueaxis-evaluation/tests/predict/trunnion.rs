//! Parts on a five-axis machine: features cut under the tool centre point, indexed, and by the rotary table alone.

use super::measured;
use super::plant::{M, V, dot, product, sub, times, turned};
use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;
use trueaxis_testing::share::share;

const AT: V = [10.0, -20.0, 60.0];
const RADIUS: f64 = 40.0;
/// Chords of the tilted circle, and its tilt.
const CHORDS: usize = 120;
const TILT: f64 = 10.0;

/// Axes X, Y, Z, A, C, mm and degrees.
type Axes = [f64; 5];

/// Errors of the machine `w C' A' Y' b X Z t`, mm and rad.
#[derive(Clone)]
struct Errors {
    /// A0Z, B0Z, C0Y.
    square: V,
    /// Location errors of A and C: three shifts, three turns.
    location: [[f64; 6]; 2],
    /// Error of each axis along itself, mm and rad.
    approach: [f64; 5],
}

/// Standard uncertainties of squareness, shifts and turns of location errors, and approaches of linear and rotary axes.
const SQUARE: f64 = 6e-6;
const SHIFT: f64 = 3e-3;
const TURN: f64 = 12e-6;
const APPROACH: [f64; 2] = [0.4e-3, 3e-6];

/// Location errors that machines have: those of the others vanish by the choice of coordinates.
const LOCATIONS: [[usize; 4]; 2] = [[1, 2, 4, 5], [0, 1, 3, 4]];

impl Errors {
    fn stated() -> Errors {
        let mut location = [[0.0; 6]; 2];
        for (axis, own) in LOCATIONS.iter().enumerate() {
            for (k, component) in own.iter().enumerate() {
                let size = if *component < 3 { 9e-3 } else { 21e-6 };
                location[axis][*component] = size * [0.9, -0.7, 0.5, -1.0][(k + 2 * axis) % 4];
            }
        }
        Errors { square: [12e-6, -15e-6, 17e-6], location, approach: [0.0; 5] }
    }

    fn drawn(&self, noise: &mut Noise) -> Errors {
        let mut drawn = self.clone();
        drawn.square.iter_mut().for_each(|q| *q += SQUARE * normal(noise));
        for (axis, own) in LOCATIONS.iter().enumerate() {
            for component in own {
                let u = if *component < 3 { SHIFT } else { TURN };
                drawn.location[axis][*component] += u * normal(noise);
            }
        }
        drawn
    }

    /// Scatter of the approach to a feature.
    fn approaches(&mut self, noise: &mut Noise) {
        self.approach = std::array::from_fn(|axis| APPROACH[usize::from(axis > 2)] * normal(noise));
    }

    /// The tip on the workpiece: the bed's frame moved along the tool's side, then back along the workpiece's.
    fn tip(&self, axes: Axes) -> V {
        let unit = |axis: usize| if axis > 2 { 1f64.to_radians() } else { 1.0 };
        let [x, y, z, a, c]: Axes = std::array::from_fn(|axis| axes[axis] + self.approach[axis] / unit(axis));
        let [a0z, b0z, c0y] = self.square;
        let tool = [x + b0z * z, -a0z * z, z];
        // Y carries the workpiece: it goes the other way, and so do its errors.
        let slide = [c0y * y, -y, 0.0];
        let [tilt, table] = self.location.map(|of| of.map(|part| -part));
        let [in_slide, in_tilt] = [(tilt, about(0, -a)), (table, about(2, -c))];
        let mut place = sub(tool, slide);
        for ([ex, ey, ez, ea, eb, ec], rotation) in [in_slide, in_tilt] {
            let frame = product(&turned([ea, eb, ec]), &rotation);
            place = times(&transposed(&frame), sub(place, [ex, ey, ez]));
        }
        place
    }

    /// Axes that bring this machine's tip where a perfect machine has it with these axes.
    fn corrected(&self, axes: Axes) -> Axes {
        let to = NONE.tip(axes);
        let mut sent = axes;
        for _ in 0..4 {
            let at = self.tip(sent);
            let miss = sub(to, at);
            // Columns: how X, Y, Z move the tip.
            let column = |axis: usize| {
                let mut beside = sent;
                beside[axis] += 1.0;
                sub(self.tip(beside), at)
            };
            let [x, y, z] = [0, 1, 2].map(column);
            let volume = dot(x, cross(y, z));
            sent[0] += dot(miss, cross(y, z)) / volume;
            sent[1] += dot(miss, cross(z, x)) / volume;
            sent[2] += dot(miss, cross(x, y)) / volume;
        }
        sent
    }

    /// machine.toml; with its uncertainties.
    fn files(&self, is_known: bool) -> Vec<(String, String)> {
        let mut toml = String::from("name = \"trunnion\"\nchain = \"w C' A' Y' b X Z t\"\n");
        toml += "[compensation]\nmodel = \"volumetric\"\n";
        for letter in ["X", "Y", "Z"] {
            toml += &format!("[axis.{letter}]\ntravel_mm = [-400, 400]\n");
            if is_known {
                toml += &format!("[axis.{letter}.uncertainty]\nrepeatability_um = {}\n", 1e3 * APPROACH[0]);
            }
        }
        for letter in ["A", "C"] {
            toml += &format!("[axis.{letter}]\ndirection = -1\ntravel_deg = [-720, 720]\n");
            if is_known {
                toml += &format!("[axis.{letter}.uncertainty]\nrepeatability_urad = {}\n", 1e6 * APPROACH[1]);
            }
        }
        let named = ["A0Z", "B0Z", "C0Y"];
        let location = |square: V, shift: &dyn Fn(usize, usize) -> f64| {
            let mut text: String = (0..3).map(|i| format!("{}_urad = {:.4}\n", named[i], 1e6 * square[i])).collect();
            for (axis, own) in LOCATIONS.iter().enumerate() {
                for component in own {
                    let name = format!("E{}0{}", ["X", "Y", "Z", "A", "B", "C"][*component], ["A", "C"][axis]);
                    let [unit, per] = if *component < 3 { ["um", "1e3"] } else { ["urad", "1e6"] };
                    let per: f64 = per.parse().unwrap();
                    text += &format!("{name}_{unit} = {:.4}\n", per * shift(axis, *component));
                }
            }
            text
        };
        toml += &format!("[location]\n{}", location(self.square, &|axis, component| self.location[axis][component]));
        if is_known {
            let u = |_, component: usize| if component < 3 { SHIFT } else { TURN };
            toml += &format!("[uncertainty.location]\n{}", location([SQUARE; 3], &u));
        }
        vec![("machine.toml".into(), toml)]
    }
}

/// A perfect machine.
const NONE: Errors = Errors { square: [0.0; 3], location: [[0.0; 6]; 2], approach: [0.0; 5] };

fn transposed(m: &M) -> M {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Rotation by an angle in degrees about X (0) or Z (2).
fn about(axis: usize, degrees: f64) -> M {
    let (s, c) = degrees.to_radians().sin_cos();
    if axis == 0 { [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]] } else { [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]] }
}

/// Directions of the tilted circle's plane, and its normal.
fn tilted() -> [V; 3] {
    let (s, c) = TILT.to_radians().sin_cos();
    [[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]]
}

/// The commands of the three features, and the program: a tilted circle of chords under the tool centre point, a hole drilled
/// from the side at A −90, a circle that the table turns.
fn part() -> ([Vec<Axes>; 3], String) {
    let mut text = String::from("G21 G90 G17 G94 F600\nG43.4\n");
    let [first, second, _] = tilted();
    let mut chords = Vec::new();
    for k in 0..=CHORDS {
        let angle = 360.0 * k as f64 / CHORDS as f64;
        let (sine, cosine) = angle.to_radians().sin_cos();
        let tip: V = std::array::from_fn(|i| RADIUS * (cosine * first[i] + sine * second[i]));
        let tip = tip.map(|q| (1e5 * q).round() * 1e-5);
        let (a, c) = (-25.0, angle);
        text += &format!("{} X{} Y{} Z{} A{a} C{c}\n", if k == 0 { "G0" } else { "G1" }, tip[0], tip[1], tip[2]);
        if k > 0 {
            chords.push(axes_at(tip, a, c));
        }
    }
    // Lines 124 and on.
    text += "G0 Z150\nG0 A0 C360\nG49\nG0 X5 Y15 A-90 C30\nG0 Z40\nG1 Z20\nG0 Z150\n";
    let hole = (0..=10).map(|k| command([5.0, 15.0, 40.0 - 2.0 * f64::from(k)], -90.0, 30.0)).collect();
    text += "G0 A0 C0\nG0 X40 Y0\nG1 Z10\nG1 C360\nG0 Z150\nM2\n";
    let turned = (0..180).map(|k| command([40.0, 0.0, 10.0], 0.0, 2.0 * f64::from(k) + 1.0)).collect();
    ([chords, hole, turned], text)
}

fn command([x, y, z]: V, a: f64, c: f64) -> Axes {
    [x + AT[0], y + AT[1], z + AT[2], a, c]
}

/// Axes with the tip at a point of the program.
fn axes_at(tip: V, a: f64, c: f64) -> Axes {
    // The workpiece's frame turned by A and C and moved by Y: what is left are X, −Y, Z.
    let point: V = std::array::from_fn(|i| tip[i] + AT[i]);
    let [x, y, z] = times(&product(&about(0, -a), &about(2, -c)), point);
    [x, y, z, a, c]
}

const PART: &str = "name = \"tilted\"\nat_mm = [10, -20, 60]\n\
    [[feature]]\nname = \"rim\"\nkind = \"circle\"\nlines = [4, 123]\n\
    [[feature]]\nname = \"side\"\nkind = \"hole\"\nlines = [129, 129]\n\
    [[feature]]\nname = \"turned\"\nkind = \"circle\"\nlines = [134, 134]\n\
    [[tolerance]]\nfeature = \"rim\"\nkind = \"roundness\"\nwidth_um = 40\n\
    [[tolerance]]\nfeature = \"rim\"\nkind = \"size\"\nlimits_um = [-20, 20]\n\
    [[tolerance]]\nfeature = \"side\"\nkind = \"position\"\nwidth_um = 60\n\
    [[tolerance]]\nfeature = \"turned\"\nkind = \"size\"\nlimits_um = [-60, 60]\n";

fn predicted(is_known: bool) -> PredictDocument {
    let files = Memory::new(Errors::stated().files(is_known));
    let toml = Path::new("machine.toml");
    let machine = Machine::read_from(&files, toml, &mut |_| {}).unwrap();
    let stated = Uncertainties::read_from(&files, toml).unwrap();
    let program = Program::parse("tilted", &part().1, "tilted.ngc").unwrap();
    let part = Part::read(PART, Path::new("part.toml")).unwrap();
    predict(&machine, &stated, &program, &part, Options { trials: 2000, seed: 3 }).unwrap()
}

/// Measures the tolerances, µm; `cut`: the machine of each feature.
fn measure(sent: &[Vec<Axes>; 3], cut: &[Errors; 3]) -> [f64; 4] {
    let points = |feature: usize| sent[feature].iter().map(move |axes| sub(cut[feature].tip(*axes), AT));
    let [first, second, _] = tilted();
    let flat = |point: V| [[dot(point, first), dot(point, second), 0.0], [0.0; 3]];
    let rim: Vec<[V; 2]> = points(0).map(flat).collect();
    let (_, diameter, form) = measured::circle(&rim, [0.0; 2]);
    // The hole from where a perfect machine drills it, seen along the tool.
    let nominal = |feature: usize| part().0[feature].iter().map(|axes| sub(NONE.tip(*axes), AT)).collect::<Vec<V>>();
    let mean = |of: Vec<V>| -> V { std::array::from_fn(|i| of.iter().map(|p| p[i]).sum::<f64>() / of.len() as f64) };
    let off = sub(mean(points(1).collect()), mean(nominal(1)));
    // Where the tool points with A −90 and C 30: the workpiece is turned by −A and −C.
    let [px, py, pz] = times(&product(&about(2, 30.0), &about(0, -90.0)), [0.0, 0.0, 1.0]);
    let along = dot(off, [px, py, pz]);
    let aside = sub(off, [along * px, along * py, along * pz]);
    let turned: Vec<[V; 2]> = points(2).map(|point| [point, [0.0; 3]]).collect();
    let middle = [-AT[0], -AT[1]];
    let radius = (40.0 + AT[0]).hypot(AT[1]);
    let wider = measured::circle(&turned, middle).1 - 2.0 * radius;
    [form, diameter - 2.0 * RADIUS, 2.0 * dot(aside, aside).sqrt(), wider].map(|mm| 1e3 * mm)
}

fn sent(is_corrected: bool) -> [Vec<Axes>; 3] {
    let machine = Errors::stated();
    part().0.map(|all| all.iter().map(|axes| if is_corrected { machine.corrected(*axes) } else { *axes }).collect())
}

#[test]
fn a_stated_five_axis_machine_cuts_what_is_predicted() {
    let found = predicted(false);
    for is_corrected in [false, true] {
        let wanted = measure(&sent(is_corrected), &[(); 3].map(|()| Errors::stated()));
        for (wanted, found) in wanted.into_iter().zip(&found.features) {
            let um = if is_corrected { found.corrected_um } else { found.uncorrected_um };
            let case = format!("corrected {is_corrected}, {} {}: {um} for {wanted}", found.feature, found.kind);
            assert!((um - wanted).abs() < 0.02, "{case}");
        }
    }
    let uncorrected: Vec<f64> = found.features.iter().map(|of| of.uncorrected_um.abs()).collect();
    assert!(uncorrected[1..].iter().all(|um| *um > 5.0), "{uncorrected:?}");
}

#[test]
fn of_100_parts_of_a_five_axis_machine_95_are_within_the_predicted_intervals() {
    let found = predicted(true);
    let sent = sent(true);
    let parts = share(4000);
    let mut held = [0; 4];
    for number in 0..parts {
        let mut noise = Noise::new(500 + number as u64);
        let drawn = Errors::stated().drawn(&mut noise);
        let cut = [(); 3].map(|()| {
            let mut own = drawn.clone();
            own.approaches(&mut noise);
            own
        });
        for ((held, value), of) in held.iter_mut().zip(measure(&sent, &cut)).zip(&found.features) {
            *held += usize::from(of.known.as_ref().unwrap().interval_um.contains(value));
        }
    }
    let most = 0.01 + 3.5 * (0.95_f64 * 0.05 / parts as f64).sqrt();
    for (held, of) in held.into_iter().zip(&found.features) {
        let share = held as f64 / parts as f64;
        let expanded = of.known.as_ref().unwrap().expanded_um;
        println!("{} {}: {:.1} %, ± {expanded:.2} µm", of.feature, of.kind, 100.0 * share);
        assert!((share - 0.95).abs() < most, "{} {}: {held} of {parts}", of.feature, of.kind);
    }
}
