//! A machine `w b X Y Z t` of its own, a part cut on it and measured: no code of the evaluation or of the exact geometry.

use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;

pub(super) type V = [f64; 3];
pub(super) type M = [V; 3];

/// Points of a table, 40 mm apart from −200 mm on.
const ROWS: usize = 11;
/// Hysteresis of every axis, mm.
const HYSTERESIS: f64 = 1e-4;

/// Errors of the machine: `table[axis][component][row]`, mm and rad.
#[derive(Clone)]
pub(super) struct Errors {
    pub(super) table: [[[f64; ROWS]; 6]; 3],
    /// A0Z, B0Z, C0Y.
    pub(super) square: V,
    pub(super) scale: V,
    /// Lag in negative travel.
    pub(super) play: V,
}

/// Standard uncertainties of them, mm and rad; `approach`: scatter of an approach.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub(super) shift: f64,
    pub(super) turn: f64,
    pub(super) square: V,
    pub(super) scale: f64,
    pub(super) play: f64,
    pub(super) approach: f64,
}

pub(super) fn sub(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(super) fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn times(m: &M, v: V) -> V {
    std::array::from_fn(|i| dot(m[i], v))
}

pub(super) fn product(a: &M, b: &M) -> M {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// I + [w] + [w]²/2, exact to 1e-12 for 100 µrad.
pub(super) fn turned(w: V) -> M {
    let cross = [[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]];
    let square = product(&cross, &cross);
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j) + cross[i][j] + 0.5 * square[i][j]))
}

impl Errors {
    /// The stated machine: errors of up to 12 µm and 15 µrad, in whole nanometres and nanoradians as in the files.
    pub(super) fn stated() -> Errors {
        let value = |axis: usize, component: usize, row: usize| {
            let phase = 0.7 * row as f64 + 1.3 * component as f64 + 2.1 * axis as f64;
            let size = if component < 3 { 12.0 } else { 15.0 };
            (1e3 * size * phase.sin()).round() * 1e-9
        };
        let table = std::array::from_fn(|a| std::array::from_fn(|c| std::array::from_fn(|row| value(a, c, row))));
        Errors { table: table.map(scaled), square: [20e-6, -15e-6, 30e-6], scale: [0.0; 3], play: [0.0; 3] }
    }

    /// A machine drawn about this one.
    pub(super) fn drawn(&self, known: &Known, noise: &mut Noise) -> Errors {
        let mut drawn = self.clone();
        for axis in &mut drawn.table {
            for (component, rows) in axis.iter_mut().enumerate() {
                let u = if component < 3 { known.shift } else { known.turn };
                rows.iter_mut().for_each(|value| *value += u * normal(noise));
            }
        }
        for i in 0..3 {
            drawn.square[i] += known.square[i] * normal(noise);
            drawn.scale[i] += known.scale * normal(noise);
            drawn.play[i] += known.play * normal(noise);
        }
        drawn
    }

    fn at(&self, axis: usize, q: f64) -> [f64; 6] {
        let place = (q + 200.0) / 40.0;
        let row = (place.floor() as usize).min(ROWS - 2);
        let share = place - row as f64;
        std::array::from_fn(|c| {
            let rows = &self.table[axis][c];
            rows[row] + share * (rows[row + 1] - rows[row])
        })
    }

    /// The tip with the axes at q; `back`: which of them travel in negative direction; `off`: scatter of the approach.
    pub(super) fn tip(&self, q: V, back: [bool; 3], off: V) -> V {
        let (mut place, mut frame) = ([0.0; 3], turned([0.0; 3]));
        for axis in 0..3 {
            let moved = q[axis] * (1.0 + self.scale[axis]) + off[axis] + if back[axis] { self.play[axis] } else { 0.0 };
            let [ex, ey, ez, ea, eb, ec] = self.at(axis, moved);
            let mut shift = [ex, ey, ez];
            shift[axis] += moved;
            match axis {
                1 => shift[0] -= self.square[2] * moved,
                2 => {
                    shift[0] += self.square[1] * moved;
                    shift[1] -= self.square[0] * moved;
                }
                _ => {}
            }
            let by = times(&frame, shift);
            place = std::array::from_fn(|i| place[i] + by[i]);
            frame = product(&frame, &turned([ea, eb, ec]));
        }
        place
    }

    /// The position that brings the tip of this machine to a point.
    pub(super) fn corrected(&self, to: V) -> V {
        let mut q = to;
        for _ in 0..6 {
            let miss = sub(self.tip(q, [false; 3], [0.0; 3]), to);
            q = sub(q, miss);
        }
        q
    }

    /// Text of machine.toml, and of the tables of X, Y, Z.
    pub(super) fn files(&self, known: Option<&Known>) -> Vec<(String, String)> {
        let mut toml =
            String::from("name = \"gantry\"\nchain = \"w b X Y Z t\"\n[compensation]\nmodel = \"volumetric\"\n");
        let letters = ['X', 'Y', 'Z'];
        let mut files = Vec::new();
        for (axis, letter) in letters.into_iter().enumerate() {
            let low = letter.to_ascii_lowercase();
            toml += &format!("[axis.{letter}]\ntable = \"{low}.csv\"\ntravel_mm = [-200, 200]\nhysteresis_um = 0.1\n");
            let names = ["EX", "EY", "EZ", "EA", "EB", "EC"];
            let unit = |c: usize| if c < 3 { "um" } else { "urad" };
            if let Some(known) = known {
                toml += &format!("[axis.{letter}.uncertainty]\nscale_ppm = {}\n", 1e6 * known.scale);
                toml += &format!("backlash_um = {}\nrepeatability_um = {}\n", 1e3 * known.play, 1e3 * known.approach);
                for (c, name) in names.iter().enumerate() {
                    let u = if c < 3 { 1e3 * known.shift } else { 1e6 * known.turn };
                    toml += &format!("{name}{letter}_{} = {u}\n", unit(c));
                }
            }
            let head: Vec<String> = (0..6).map(|c| format!("{}{letter}_{}", names[c], unit(c))).collect();
            let mut table = format!("{letter}_mm,{}\n", head.join(","));
            for row in 0..ROWS {
                let micro = |c: usize| self.table[axis][c][row] * if c < 3 { 1e3 } else { 1e6 };
                let cells: Vec<String> = (0..6).map(|c| format!("{:.4}", micro(c))).collect();
                table += &format!("{},{}\n", -200 + 40 * row as i32, cells.join(","));
            }
            files.push((format!("{low}.csv"), table));
        }
        let named = ["A0Z", "B0Z", "C0Y"];
        let list = |of: V| -> String { (0..3).map(|i| format!("{}_urad = {:.4}\n", named[i], 1e6 * of[i])).collect() };
        toml += &format!("[location]\n{}", list(self.square));
        if let Some(known) = known {
            toml += &format!("[uncertainty.location]\n{}", list(known.square));
        }
        files.push(("machine.toml".into(), toml));
        files
    }
}

/// Translations from µm-sized to mm: `stated` gives both kinds in the unit of 1e-6.
fn scaled(axis: [[f64; ROWS]; 6]) -> [[f64; ROWS]; 6] {
    let mut axis = axis;
    axis[..3].iter_mut().flatten().for_each(|value| *value *= 1e3);
    axis
}

/// A move, and the feature that it cuts.
#[derive(Clone, Copy)]
pub(super) enum Step {
    Rapid(V),
    Line(V, Option<usize>),
    /// A full turn counterclockwise about this centre from where the tool is.
    Turn(V, usize),
}

/// Four rows over the top of a plate, to and fro.
pub(super) fn top(feature: usize) -> Vec<Step> {
    let mut steps = vec![Step::Rapid([-5.0, 5.0, 20.0]), Step::Rapid([-5.0, 5.0, 0.0])];
    for (k, y) in [5.0, 25.0, 45.0, 65.0].into_iter().enumerate() {
        let [from, to] = if k % 2 == 0 { [-5.0, 125.0] } else { [125.0, -5.0] };
        if k > 0 {
            steps.push(Step::Line([from, y, 0.0], Some(feature)));
        }
        steps.push(Step::Line([to, y, 0.0], Some(feature)));
    }
    steps
}

/// An edge, approached and left from above.
pub(super) fn edge(from: V, to: V, feature: usize) -> [Step; 4] {
    let above = |[x, y, _]: V| Step::Rapid([x, y, 20.0]);
    [above(from), Step::Rapid(from), Step::Line(to, Some(feature)), above(to)]
}

/// First and last line of [`program`] that cut a feature.
pub(super) fn lines(steps: &[Step], feature: usize) -> [usize; 2] {
    let of = |step: &Step| match step {
        Step::Line(_, own) => *own == Some(feature),
        Step::Turn(_, own) => *own == feature,
        Step::Rapid(_) => false,
    };
    [steps.iter().position(of), steps.iter().rposition(of)].map(|at| at.unwrap() + 2)
}

/// Lines of the program, one for each move after the first line.
pub(super) fn program(steps: &[Step]) -> String {
    let mut text = String::from("G21 G90 G17 G94 F600\n");
    let mut at = [0.0; 3];
    for step in steps {
        match step {
            Step::Rapid(to) | Step::Line(to, _) => {
                let word = if matches!(step, Step::Rapid(_)) { "G0" } else { "G1" };
                text += &format!("{word} X{} Y{} Z{}\n", to[0], to[1], to[2]);
                at = *to;
            }
            Step::Turn(centre, _) => {
                text += &format!("G3 X{} Y{} I{} J{}\n", at[0], at[1], centre[0] - at[0], centre[1] - at[1]);
            }
        }
    }
    text + "M2\n"
}

/// A drive with its direction: it turns where it has come back by more than the hysteresis.
#[derive(Clone, Copy)]
struct Drive {
    extreme: f64,
    back: bool,
}

impl Drive {
    fn goes(&mut self, to: f64) {
        let beyond = if self.back { self.extreme - to } else { to - self.extreme };
        if beyond > 0.0 {
            self.extreme = to;
        } else if beyond < -HYSTERESIS {
            (self.back, self.extreme) = (!self.back, to);
        }
    }
}

/// A position on the path: feature, programmed point, drives and their directions.
pub(super) struct Place {
    pub(super) feature: usize,
    programmed: V,
    sent: V,
    back: [bool; 3],
}

/// Runs the program with its zero at `at`, corrected by this machine's own errors or uncorrected.
pub(super) fn run(steps: &[Step], at: V, stated: &Errors, is_corrected: bool) -> Vec<Place> {
    let mut places = Vec::new();
    let (mut here, mut drives): (V, Option<[Drive; 3]>) = ([0.0; 3], None);
    for step in steps {
        let (feature, points): (Option<usize>, Vec<V>) = match step {
            Step::Rapid(to) => (None, vec![*to]),
            Step::Line(to, feature) => {
                // Every 1.3 mm or closer.
                let whole = sub(*to, here);
                let count = (dot(whole, whole).sqrt() / 1.3).ceil().max(1.0);
                // From where the axes have turned.
                let point = |k: usize| std::array::from_fn(|i| here[i] + whole[i] * (k as f64 / count).max(1e-3));
                (*feature, (0..=count as usize).map(point).collect())
            }
            Step::Turn(centre, feature) => {
                let [x, y, _] = sub(here, *centre);
                let point = |k: usize| {
                    let (sine, cosine) = (std::f64::consts::TAU * (k as f64 + 0.5) / 240.0).sin_cos();
                    [centre[0] + cosine * x - sine * y, centre[1] + sine * x + cosine * y, here[2]]
                };
                (Some(*feature), (0..240).map(point).collect())
            }
        };
        for programmed in points.iter().copied() {
            let command: V = std::array::from_fn(|i| programmed[i] + at[i]);
            let sent = if is_corrected { stated.corrected(command) } else { command };
            let drives = drives.get_or_insert(sent.map(|q| Drive { extreme: q, back: false }));
            drives.iter_mut().zip(sent).for_each(|(drive, q)| drive.goes(q));
            if let Some(feature) = feature {
                places.push(Place { feature, programmed, sent, back: drives.map(|drive| drive.back) });
            }
        }
        if let Some(last) = points.last().filter(|_| !matches!(step, Step::Turn(..))) {
            here = *last;
        }
    }
    places
}

/// The points that a machine cuts of every feature, in coordinates of the program.
pub(super) fn cut(places: &[Place], at: V, truth: &Errors, off: &[V]) -> Vec<Vec<[V; 2]>> {
    let mut features = vec![Vec::new(); off.len()];
    for place in places {
        let tip = truth.tip(place.sent, place.back, off[place.feature]);
        features[place.feature].push([sub(tip, at), place.programmed]);
    }
    features
}

/// Scatter of the approach to every feature.
pub(super) fn approaches(features: usize, known: &Known, noise: &mut Noise) -> Vec<V> {
    (0..features).map(|_| [0; 3].map(|_| known.approach * normal(noise))).collect()
}
