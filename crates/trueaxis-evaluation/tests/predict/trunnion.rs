//! Parts on five-axis machines: features cut under the tool centre point, indexed, and by the rotary table alone, and a gear's
//! flank.

use super::measured;
use super::plant::{M, V, dot, product, sub, times, turned};
use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict};
use trueaxis_metrology::helicoid::Gear;
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

/// Errors of a machine `w C' A' Y' b X Z t`, or `w C' b X Y Z A t`, mm and rad.
#[derive(Clone)]
struct Errors {
    /// Length of the tool from the axis A, where that turns the tool.
    head: Option<f64>,
    /// Positioning error of C under the head at the rows of its table, rad.
    rows: Vec<f64>,
    /// A0Z, B0Z, C0Y.
    square: V,
    /// Location errors of A and C: three shifts, three turns.
    location: [[f64; 6]; 2],
    /// Error of each axis along itself, mm and rad.
    approach: [f64; 5],
}

/// Rows of the table of C, and the standard uncertainty of each, rad.
const ROWS: usize = 289;
const ROW: f64 = 2e-6;

/// Rows of 5 degrees about zero.
fn degrees(row: usize) -> f64 {
    5.0 * row as f64 - 720.0
}

/// A scale and a wave, in whole nanoradians as in the file.
fn stated_row(row: usize) -> f64 {
    let angle = degrees(row).to_radians();
    (40e3 * angle + 9e3 * (14.0 * angle).sin()).round() * 1e-9
}

/// Standard uncertainties of squareness, shifts and turns of location errors, and approaches of linear and rotary axes.
const SQUARE: f64 = 6e-6;
const SHIFT: f64 = 3e-3;
const TURN: f64 = 12e-6;
const APPROACH: [f64; 2] = [0.4e-3, 3e-6];

/// Location errors that machines have: those of the others vanish by the choice of coordinates.
const LOCATIONS: [[usize; 4]; 2] = [[1, 2, 4, 5], [0, 1, 3, 4]];

impl Errors {
    fn stated(head: Option<f64>) -> Errors {
        let mut location = [[0.0; 6]; 2];
        for (axis, own) in LOCATIONS.iter().enumerate() {
            for (k, component) in own.iter().enumerate() {
                let size = if *component < 3 { 9e-3 } else { 21e-6 };
                location[axis][*component] = size * [0.9, -0.7, 0.5, -1.0][(k + 2 * axis) % 4];
            }
        }
        Errors {
            head,
            rows: head.map_or_else(Vec::new, |_| (0..ROWS).map(stated_row).collect()),
            square: [12e-6, -15e-6, 17e-6],
            location,
            approach: [0.0; 5],
        }
    }

    fn drawn(&self, noise: &mut Noise) -> Errors {
        let mut drawn = self.clone();
        drawn.square.iter_mut().for_each(|q| *q += SQUARE * normal(noise));
        drawn.rows.iter_mut().for_each(|q| *q += ROW * normal(noise));
        for (axis, own) in LOCATIONS.iter().enumerate() {
            for component in own {
                let u = if *component < 3 { SHIFT } else { TURN };
                drawn.location[axis][*component] += u * normal(noise);
            }
        }
        drawn
    }

    /// Scatter of the approach to a feature.
    fn with_approaches(mut self, noise: &mut Noise) -> Errors {
        self.approach = std::array::from_fn(|axis| APPROACH[usize::from(axis > 2)] * normal(noise));
        self
    }

    /// Between the rows, rad.
    fn positioning(&self, c: f64) -> f64 {
        if self.rows.is_empty() {
            return 0.0;
        }
        let place = (c - degrees(0)) / 5.0;
        let (row, share) = (place.floor() as usize, place.fract());
        self.rows[row] + share * (self.rows[row + 1] - self.rows[row])
    }

    /// The tip on the workpiece: the bed's frame moved along the tool's side, then back along the workpiece's.
    fn tip(&self, axes: Axes) -> V {
        let unit = |axis: usize| if axis > 2 { 1f64.to_radians() } else { 1.0 };
        let [x, y, z, a, c]: Axes = std::array::from_fn(|axis| axes[axis] + self.approach[axis] / unit(axis));
        let [a0z, b0z, c0y] = self.square;
        if let Some(length) = self.head {
            let [tilt, table] = self.location;
            let turn = product(&turned([tilt[3], tilt[4], tilt[5]]), &about(0, a));
            let tool = times(&turn, [0.0, 0.0, -length]);
            let axis = [x - c0y * y + b0z * z, y - a0z * z, z + length];
            let tip: V = std::array::from_fn(|i| axis[i] + tilt[i] + tool[i]);
            let [ex, ey, ez, ea, eb, ec] = table.map(|part| -part);
            let ec = ec - self.positioning(c);
            let frame = product(&turned([ea, eb, ec]), &about(2, c));
            return times(&transposed(&frame), sub(tip, [ex, ey, ez]));
        }
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
        let to = Errors { head: self.head, ..NONE }.tip(axes);
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
        let (chain, direction) = if self.head.is_some() { ("w C' b X Y Z A t", 1) } else { ("w C' A' Y' b X Z t", -1) };
        let mut toml = format!("name = \"five\"\nchain = \"{chain}\"\n");
        let length = self.head.unwrap_or(0.0);
        toml += &format!("tool_mm = [0, 0, {}]\n", -length);
        toml += "[compensation]\nmodel = \"volumetric\"\n";
        for letter in ["X", "Y", "Z"] {
            toml += &format!("[axis.{letter}]\ntravel_mm = [-400, 400]\n");
            if is_known {
                toml += &format!("[axis.{letter}.uncertainty]\nrepeatability_um = {}\n", 1e3 * APPROACH[0]);
            }
        }
        for letter in ["A", "C"] {
            toml += &format!("[axis.{letter}]\ndirection = {direction}\ntravel_deg = [-720, 720]\n");
            if letter == "A" {
                toml += &format!("offset_mm = [0, 0, {length}]\n");
            } else if self.head.is_some() {
                toml += "table = \"c.csv\"\n";
            }
            if is_known {
                toml += &format!("[axis.{letter}.uncertainty]\nrepeatability_urad = {}\n", 1e6 * APPROACH[1]);
                if letter == "C" && self.head.is_some() {
                    toml += &format!("ECC_urad = {}\n", 1e6 * ROW);
                }
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
        let line = |(row, error): (usize, &f64)| format!("{},{:.3}\n", degrees(row), 1e6 * error);
        let rows: Vec<String> = self.rows.iter().enumerate().map(line).collect();
        vec![("machine.toml".into(), toml), ("c.csv".into(), format!("C_deg,ECC_urad\n{}", rows.concat()))]
    }
}

/// A perfect machine.
const NONE: Errors =
    Errors { head: None, rows: Vec::new(), square: [0.0; 3], location: [[0.0; 6]; 2], approach: [0.0; 5] };

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

fn machine_of(errors: &Errors, is_known: bool) -> (Machine, Uncertainties) {
    let (files, toml) = (Memory::new(errors.files(is_known)), Path::new("machine.toml"));
    (Machine::read_from(&files, toml, &mut |_| {}).unwrap(), Uncertainties::read_from(&files, toml).unwrap())
}

fn predicted(machine: &Errors, is_known: bool, program: &str, part: &str) -> PredictDocument {
    let (machine, stated) = machine_of(machine, is_known);
    let program = Program::parse("five", program, "five.ngc").unwrap();
    let part = Part::read(part, Path::new("part.toml")).unwrap();
    predict(&machine, &stated, &program, &part, Options { trials: 1000, seed: 3 }).unwrap()
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
    let machine = Errors::stated(None);
    part().0.map(|all| all.iter().map(|axes| if is_corrected { machine.corrected(*axes) } else { *axes }).collect())
}

#[test]
fn a_stated_five_axis_machine_cuts_what_is_predicted() {
    let found = predicted(&Errors::stated(None), false, &part().1, PART);
    for is_corrected in [false, true] {
        let wanted = measure(&sent(is_corrected), &[(); 3].map(|()| Errors::stated(None)));
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
    let found = predicted(&Errors::stated(None), true, &part().1, PART);
    let sent = sent(true);
    let parts = share(4000);
    let mut held = [0; 4];
    for number in 0..parts {
        let mut noise = Noise::new(500 + number as u64);
        let drawn = Errors::stated(None).drawn(&mut noise);
        let cut = [(); 3].map(|()| drawn.clone().with_approaches(&mut noise));
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

const GEAR: Gear = Gear { module_mm: 3.0, teeth: 24, pressure_angle_deg: 20.0, helix_angle_deg: 15.0 };
/// Roll angles and heights of the grid.
const ROLLS: [f64; 9] = [0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6];
const HEIGHTS: usize = 9;

/// Commands over the grid of a flank with the tool along its normal, the program, and base radius and lead parameter. The gear
/// stands on the axis of the table; the zero of the program is that of the machine.
fn flank(length: f64) -> (Vec<Axes>, String, [f64; 2]) {
    let beta = GEAR.helix_angle_deg.to_radians();
    let radius = 0.5 * GEAR.module_mm * f64::from(GEAR.teeth) / beta.cos();
    let pressure = (GEAR.pressure_angle_deg.to_radians().tan() / beta.cos()).atan();
    let [base, lead] = [radius * pressure.cos(), radius / beta.tan()];
    let tilt = lead.atan2(base);
    let mut text = String::from("G21 G90 G17 G94 F600\nG0 Z200\n");
    let mut commands = Vec::new();
    for u in ROLLS {
        for k in 0..HEIGHTS {
            let theta = 0.03 * k as f64;
            let phi = u + theta;
            // The table turns the normal into the plane in which the head tilts the tool.
            let [x, y, z] = [base, -base * u, lead * theta];
            let to =
                [x, y - length * tilt.sin(), z + length * (tilt.cos() - 1.0), tilt.to_degrees(), -phi.to_degrees()];
            let to = to.map(|q| (1e6 * q).round() * 1e-6);
            text += &format!("G1 X{} Y{} Z{} A{} C{}\n", to[0], to[1], to[2], to[3], to[4]);
            commands.push(to);
        }
    }
    (commands, text + "G0 Z200\nM2\n", [base, lead])
}

/// Deviations of profile and helix, µm: total, form and slope of each.
fn flank_deviations(points: &[V], [base, lead]: [f64; 2]) -> [f64; 6] {
    // How far the screw through a point is above that of the flank, along the normal.
    let above = |[x, y, z]: V| {
        let u = (x.hypot(y).powi(2) / base.powi(2) - 1.0).sqrt();
        (z - lead * (y.atan2(x) + u.atan() - u)) * base / lead.hypot(base)
    };
    let profile = (0..ROLLS.len()).map(|row| (base * ROLLS[row], above(points[row * HEIGHTS + HEIGHTS / 2])));
    // The roll angle of the reference cylinder is 0.377.
    let helix = (0..HEIGHTS).map(|k| (lead * 0.03 * k as f64, above(points[4 * HEIGHTS + k])));
    let of = |trace: Vec<(f64, f64)>| {
        let count = trace.len() as f64;
        let [s, d] =
            [trace.iter().map(|one| one.0).sum::<f64>() / count, trace.iter().map(|one| one.1).sum::<f64>() / count];
        let squares: f64 = trace.iter().map(|one| (one.0 - s).powi(2)).sum();
        let slope = trace.iter().map(|one| (one.0 - s) * (one.1 - d)).sum::<f64>() / squares;
        let width = |slope: f64| {
            let rest: Vec<f64> = trace.iter().map(|one| one.1 - slope * one.0).collect();
            rest.iter().copied().fold(f64::MIN, f64::max) - rest.iter().copied().fold(f64::MAX, f64::min)
        };
        [width(0.0), width(slope), slope * (trace[trace.len() - 1].0 - trace[0].0)]
    };
    let [[a, b, c], [d, e, f]] = [of(profile.collect()), of(helix.collect())];
    [a, b, c, d, e, f].map(|mm| 1e3 * mm)
}

/// The gear with six tolerances; `setup`: sections before its feature, and what that states.
fn gear([sections, key]: [&str; 2]) -> String {
    let mut part = format!(
        "name = \"gear\"\nat_mm = [0, 0, 0]\n{sections}[[feature]]\nname = \"tooth\"\nkind = \"flank\"\nlines = [3, 83]\n\
         module_mm = 3\nteeth = 24\nhelix_angle_deg = 15\nface_mm = 33\n{key}",
    );
    for of in ["profile", "helix"] {
        for kind in ["total", "form", "slope"] {
            part += &format!("[[tolerance]]\nfeature = \"tooth\"\nkind = \"{of} {kind}\"\nclass = 6\n");
        }
    }
    part
}

/// In a further set-up, however it is turned, the flank is that of its program; clamped with an angle about X, its helix and
/// profile are those of the points turned by it.
#[test]
fn a_gear_in_a_further_set_up_is_that_of_its_program() {
    let (commands, text, surface) = flank(150.0);
    let stated = Errors::stated(Some(150.0));
    let wanted = predicted(&stated, true, &text, &gear(["", ""]));
    let none = Program::parse("none", "G21 G90 G17 G94 F600\nG0 X0 Y0 Z200\nX1\nM2\n", "none.ngc").unwrap();
    let (machine, known) = machine_of(&stated, true);
    let clamped = 80e-6;
    for (turned, clamp) in [([0, 0, 0], 0.0), ([90, 0, 0], 0.0), ([20, 40, 60], clamped)] {
        let sections = format!(
            "[[setup]]\nname = \"s\"\nprogram = \"s.ngc\"\nat_mm = [0, 0, 0]\nzero_mm = [30, -20, 10]\n\
             turned_deg = {turned:?}\nuncertainty_urad = [{}, 0, 0]\n",
            1e6 * clamp
        );
        let mut part = Part::read(&gear([&sections, "setup = \"s\"\n"]), Path::new("part.toml")).unwrap();
        part.read_setups(|file| Program::parse("gear", &text, file)).unwrap();
        let found = predict(&machine, &known, &none, &part, Options { trials: 1000, seed: 3 }).unwrap();
        let nominal: Vec<V> = commands.iter().map(|axes| Errors { head: Some(150.0), ..NONE }.tip(*axes)).collect();
        let tilted: Vec<V> = nominal.iter().map(|[x, y, z]| [*x, y - clamped * z, z + clamped * y]).collect();
        let by = flank_deviations(&tilted, surface);
        for (k, (found, wanted)) in found.features.iter().zip(&wanted.features).enumerate() {
            let case = format!("{turned:?}, {}", found.kind);
            let [is, was] = [found, wanted].map(|of| [of.uncorrected_um, of.corrected_um]);
            assert!((0..2).all(|state| (is[state] - was[state]).abs() < 1e-6), "{case}: {is:?} for {was:?}");
            let [is, was] = [found, wanted].map(|of| of.known.as_ref().unwrap());
            if clamp == 0.0 {
                assert!((is.expanded_um - was.expanded_um).abs() < 1e-6, "{case}");
            } else if found.kind.ends_with("slope") {
                let term = is.budget.iter().find(|one| one.term == "set-up s about X").unwrap();
                let wanted = by[k].abs();
                assert!(
                    wanted > 0.05 && (term.standard_um / wanted - 1.0).abs() < 0.06,
                    "{case}: {term:?} for {wanted}"
                );
            }
        }
    }
}

#[test]
fn profile_and_helix_of_a_gear_are_cut_as_predicted() {
    let (commands, program, surface) = flank(150.0);
    let part = gear(["", ""]);
    let stated = Errors::stated(Some(150.0));
    let found = predicted(&stated, true, &program, &part);
    // m_n 3, d 74.54, b 33, class 6 of ISO 1328-1:2013, rounded as there.
    let limits: Vec<f64> = found.features.iter().map(|of| (1e6 * of.limits_um[1].unwrap()).round() * 1e-6).collect();
    assert_eq!(limits, [12.0, 9.5, 7.5, 14.0, 10.0, 9.0]);
    let cut = |sent: &dyn Fn(Axes) -> Axes, truth: &Errors| {
        let points: Vec<V> = commands.iter().map(|axes| truth.tip(sent(*axes))).collect();
        flank_deviations(&points, surface)
    };
    for (k, of) in found.features.iter().enumerate() {
        let wanted = [cut(&|axes| axes, &stated)[k], cut(&|axes| stated.corrected(axes), &stated)[k]];
        let um = [of.uncorrected_um, of.corrected_um];
        assert!((0..2).all(|state| (um[state] - wanted[state]).abs() < 0.01), "{}: {um:?} for {wanted:?}", of.kind);
        assert!(wanted[0].abs() > 0.1, "{}: {wanted:?}", of.kind);
    }
    let parts = share(4000);
    let mut held = [0; 6];
    for number in 0..parts {
        let mut noise = Noise::new(7000 + number as u64);
        let drawn = stated.drawn(&mut noise).with_approaches(&mut noise);
        let values = cut(&|axes| stated.corrected(axes), &drawn);
        for ((held, value), of) in held.iter_mut().zip(values).zip(&found.features) {
            *held += usize::from(of.known.as_ref().unwrap().interval_um.contains(value));
        }
    }
    let most = 0.01 + 3.5 * (0.95_f64 * 0.05 / parts as f64).sqrt();
    for (held, of) in held.into_iter().zip(&found.features) {
        let (share, expanded) = (held as f64 / parts as f64, of.known.as_ref().unwrap().expanded_um);
        println!("{}: {:.1} %, ± {expanded:.2} µm", of.kind, 100.0 * share);
        assert!((share - 0.95).abs() < most, "{}: {held} of {parts}", of.kind);
    }
}
