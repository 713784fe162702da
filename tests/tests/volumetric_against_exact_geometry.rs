//! The volumetric form compared with the exact transforms: two implementations that share only the settings.

use trueaxis::compensation::Query;
use trueaxis::compensation::{Compensation, Direction, ThermalLine, requirement};
use trueaxis::machine::{AXES, AxisSettings, ErrorModel, Interpolation, LocationErrors, Row, ThermalGrowth};
use trueaxis::machine::{AxisOrder, carries_workpiece};
use trueaxis::{Axis, check};
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::noise::Noise;

/// Linear axes travel ±250 mm, rotary ones are unlimited.
const REACH_MM: f64 = 250.0;
/// Temperature above the reference in every comparison, K.
const RISE_K: f64 = 3.0;

/// A chain of X, Y, Z and `rotary` rotary axes in any order, each on either side.
fn chain(random: &mut Noise, rotary: usize) -> String {
    let mut axes = vec![Axis::X, Axis::Y, Axis::Z];
    let mut free = vec![Axis::A, Axis::B, Axis::C];
    for _ in 0..rotary {
        axes.push(free.remove(random.below(free.len())));
    }
    let mut order = Vec::new();
    while !axes.is_empty() {
        order.push(axes.remove(random.below(axes.len())));
    }
    let bed = random.below(order.len() + 1);
    let (mut code, tool) = (String::from("w"), &order[bed..]);
    for axis in &order[..bed] {
        code += &format!(" {}'", axis.letter());
    }
    code += " b";
    for axis in tool {
        code += &format!(" {}", axis.letter());
    }
    code + " t"
}

/// Errors of up to `mm` and `rad`; the table changes slowly, as those of machines do.
fn rows(random: &mut Noise, axis: Axis, mm: f64, rad: f64) -> Vec<Row> {
    let rotary = axis.is_rotary();
    let (low, high) = if rotary { (-180.0, 180.0) } else { (-REACH_MM - 10.0, REACH_MM + 10.0) };
    let free = random.unit() < 0.5;
    let waves: [[f64; 3]; 6] = std::array::from_fn(|_| [random.signed(), random.signed(), random.signed()]);
    (0..=24)
        .map(|i| {
            let stray = if free && i > 0 && i < 24 { 0.3 * random.signed() } else { 0.0 };
            let phase = (f64::from(i) + stray) / 24.0;
            let twist = std::array::from_fn(|k| {
                let [a, b, c] = waves[k];
                let turn = std::f64::consts::TAU * phase;
                let size = if k < 3 { mm } else { rad } / 3.0;
                size * (a * turn.cos() + b * turn.sin() + c * if rotary { (2.0 * turn).cos() } else { phase })
            });
            Row { position: low + (high - low) * phase, forward: twist, reverse: twist }
        })
        .collect()
}

struct Case {
    machine: Machine,
}

fn case(random: &mut Noise, rotary: usize, mm: f64, rad: f64) -> Case {
    let chain = chain(random, rotary);
    let mut axes = heapless::Vec::<AxisSettings, AXES>::new();
    let mut tables = Vec::new();
    for axis in Axis::ALL.into_iter().filter(|axis| chain.contains(axis.letter())) {
        let mut settings = AxisSettings::with_defaults(axis, carries_workpiece(&chain, axis));
        if axis.is_rotary() && random.unit() < 0.5 {
            settings.direction = -settings.direction;
        }
        if random.unit() < 0.5 {
            settings.interpolation = Interpolation::Cubic;
        }
        if random.unit() < 0.5 {
            settings.measured_at_mm = random.vector(100.0);
        }
        settings.offset_mm = random.vector(80.0);
        if axis.is_rotary() {
            settings.backlash = (0.2 * rad * random.unit()).to_degrees();
            settings.thermal =
                ThermalGrowth { offset_per_k: (0.1 * rad).to_degrees(), expansion_per_k: 0.0, datum: 0.0 };
        } else {
            settings.backlash = 0.1 * mm * random.unit();
            settings.thermal =
                ThermalGrowth { offset_per_k: 0.02 * mm, expansion_per_k: 2e-4 * mm, datum: 50.0 * random.signed() };
        }
        let table = (random.unit() < 0.9).then(|| Table {
            given: [true; 6],
            bidirectional: false,
            rows: rows(random, axis, mm, rad),
        });
        if table.is_none() {
            // Lost motion is part of the table.
            settings.backlash = 0.0;
        }
        axes.push(settings).unwrap();
        tables.push(table);
    }
    let mut location = LocationErrors {
        a0z: 0.5 * rad * random.signed(),
        b0z: 0.5 * rad * random.signed(),
        c0y: 0.5 * rad * random.signed(),
        rotary: [[0.0; 6]; 3],
    };
    for errors in &mut location.rotary {
        *errors = std::array::from_fn(|k| 0.3 * if k < 3 { mm } else { rad } * random.signed());
    }
    let machine = trueaxis_testing::machine::Machine::new(&chain).axes(&axes).tool(random.vector(100.0));
    let mut settings = machine.settings();
    settings.location = location;
    settings.compensation.model = ErrorModel::Volumetric;
    settings.kinematics.tool_axis = [0.0, 0.6, 0.8];
    Case { machine: Machine { settings, tables, grids: Vec::new() } }
}

impl Case {
    /// The machine with all errors scaled by `factor`.
    fn scaled(&self, factor: f64) -> Case {
        let mut machine = self.machine.clone();
        for table in machine.tables.iter_mut().flatten() {
            for row in &mut table.rows {
                row.forward = row.forward.map(|x| x * factor);
                row.reverse = row.reverse.map(|x| x * factor);
            }
        }
        for axis in &mut machine.settings.axes {
            axis.backlash *= factor;
            axis.thermal.offset_per_k *= factor;
            axis.thermal.expansion_per_k *= factor;
        }
        let location = &mut machine.settings.location;
        location.a0z *= factor;
        location.b0z *= factor;
        location.c0y *= factor;
        for errors in location.rotary.iter_mut().flatten() {
            *errors *= factor;
        }
        Case { machine }
    }

    fn with<const N: usize, T>(&self, passes: u8, user: impl FnOnce(&Compensation<'_, f64, f64, N>) -> T) -> T {
        let settings = &self.machine.settings;
        check::settings(settings).unwrap();
        let rows = |axis: Axis| self.machine.rows(axis);
        let mut memory = vec![0.0; requirement(settings, rows)];
        user(&Compensation::build(settings, rows, &[], passes, &mut memory).unwrap())
    }

    fn thermal<const N: usize>(&self) -> [ThermalLine<f64>; N] {
        AxisOrder::<N>::of(&self.machine.settings).unwrap().axes().map(|axis| {
            let settings = self.machine.settings.axis(axis);
            settings.map_or(ThermalLine::default(), |s| ThermalLine::for_axis(&s.thermal, RISE_K).unwrap())
        })
    }

    /// Converts positions from the step's order to the plant's.
    fn plant<const N: usize>(&self, step: &[f64; N]) -> [f64; AXES] {
        let axes = AxisOrder::<N>::of(&self.machine.settings).unwrap().axes();
        let mut plant = [0.0; AXES];
        for (slot, settings) in plant.iter_mut().zip(&self.machine.settings.axes) {
            *slot = step[axes.iter().position(|a| *a == settings.axis).unwrap()];
        }
        plant
    }
}

fn place<const N: usize>(random: &mut Noise) -> [f64; N] {
    std::array::from_fn(|i| if i < 3 { REACH_MM * random.signed() } else { 175.0 * random.signed() })
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Largest error, and largest difference from the exact one: tip (mm), direction (rad).
fn compare<const N: usize>(case: &Case, seed: u64) -> [[f64; 2]; 2] {
    let geometry = Geometry::new(&case.machine, RISE_K).unwrap();
    let mut random = Noise::new(seed);
    let mut largest = [[0.0_f64; 2]; 2];
    case.with::<N, _>(1, |compensation| {
        for _ in 0..20 {
            let q = place::<N>(&mut random);
            let reversed: [f64; N] = std::array::from_fn(|_| f64::from(u8::from(random.unit() < 0.5)));
            let directions = reversed.map(|r| if r > 0.5 { Direction::NEGATIVE } else { Direction::POSITIVE });
            let at = compensation.coordinates(&q);
            let found = compensation.pose_error(&Query::at(&at, &directions, &case.thermal()), &mut 0);
            let tool = compensation.volumetric().unwrap().tool_axis(&at);
            let exact = geometry.pose_error(&case.plant(&q), &case.plant(&reversed));
            let direction = cross(found.orientation.into(), tool.into());
            let tip = [norm(exact.tip_mm), norm(minus(found.tip.into(), exact.tip_mm))];
            let turn = [norm(exact.direction), norm(minus(direction, exact.direction))];
            for (largest, found) in largest.iter_mut().zip([tip, turn]) {
                *largest = [largest[0].max(found[0]), largest[1].max(found[1])];
            }
        }
    });
    largest
}

fn first_order<const N: usize>(chains: u64) {
    for seed in 0..chains {
        let mut random = Noise::new(seed * 7919 + N as u64);
        let large = case(&mut random, N - 3, 60e-3, 60e-6);
        let small = large.scaled(0.1);
        let (found, tenth) = (compare::<N>(&large, seed), compare::<N>(&small, seed));
        let chain = &large.machine.settings.chain;
        for k in 0..2 {
            let [size, difference] = found[k];
            assert!(difference <= 5e-3 * size, "{chain}: {found:?}");
            // Rounding: 1e-12 mm, 1e-15 rad.
            let rounding = [1e-12, 1e-15][k];
            assert!(tenth[k][1] < difference / 70.0 + rounding, "{chain}: {found:?} {tenth:?}");
        }
    }
}

#[test]
fn three_axes_agree_to_second_order() {
    first_order::<3>(300);
}

#[test]
fn four_axes_agree_to_second_order() {
    first_order::<4>(400);
}

#[test]
fn five_axes_agree_to_second_order() {
    first_order::<5>(1000);
}

#[test]
fn six_axes_agree_to_second_order() {
    first_order::<6>(300);
}

/// Largest distance between the ideal pose at the command and the pose reached by the corrected command: tip in mm, direction
/// in rad, among the poses that slides and rotary axes can correct; and the number of these poses.
fn landing<const N: usize>(case: &Case, seed: u64) -> ([f64; 2], u32) {
    let settings = &case.machine.settings;
    let geometry = Geometry::new(&case.machine, RISE_K).unwrap();
    let mut random = Noise::new(seed);
    let (mut largest, mut compared) = ([0.0_f64; 2], 0);
    case.with::<N, _>(8, |compensation| {
        for _ in 0..20 {
            let q = place::<N>(&mut random);
            let at = compensation.coordinates(&q);
            let r = compensation.correction(&Query::at(&at, &[Direction::POSITIVE; N], &case.thermal()), &mut 0);
            let there: [f64; N] = std::array::from_fn(|i| q[i] + r[i]);
            let ideal = geometry.ideal_pose(&case.plant(&q));
            let actual = geometry.actual_pose(&case.plant(&there), &[0.0; AXES]);
            if !settings.compensation.orientation {
                assert!(r[3..].iter().all(|r| *r == 0.0));
            }
            // Directions of the slides, and rotations of the tool by the rotary axes, as differences of the exact geometry.
            let moved = |place: usize, by: f64| {
                let mut there = q;
                there[place] += by;
                geometry.ideal_pose(&case.plant(&there))
            };
            let slides = [0, 1, 2].map(|k| minus(moved(k, 1.0).tip_mm, ideal.tip_mm));
            let determinant: f64 = (0..3).map(|k| slides[0][k] * cross(slides[1], slides[2])[k]).sum();
            let columns: Vec<[f64; 3]> = (3..N)
                .map(|k| minus(moved(k, 1e-4).direction, moved(k, -1e-4).direction).map(|x| x / 2e-4_f64.to_radians()))
                .collect();
            // One axis: |a × t|; several: the determinants of all pairs.
            let singular = match columns.as_slice() {
                [only] => norm(*only),
                columns => {
                    let pairs =
                        columns.iter().enumerate().flat_map(|(i, a)| columns[i + 1..].iter().map(move |b| (a, b)));
                    pairs.map(|(a, b)| norm(cross(*a, *b)).powi(2)).sum::<f64>().sqrt()
                }
            };
            if determinant.abs() < 0.06 || (settings.compensation.orientation && singular < 0.1) {
                continue;
            }
            compared += 1;
            largest[0] = largest[0].max(norm(minus(actual.tip_mm, ideal.tip_mm)));
            if settings.compensation.orientation {
                let off = minus(actual.direction, ideal.direction);
                // One axis corrects only along its column.
                let left = match columns.as_slice() {
                    [only] => (0..3).map(|k| off[k] * only[k]).sum::<f64>().abs() / norm(*only),
                    _ => norm(off),
                };
                largest[1] = largest[1].max(left);
            }
        }
    });
    (largest, compared)
}

fn exact_inverse<const N: usize>(chains: u64, orientation: bool) {
    let mut compared = 0;
    for seed in 0..chains {
        let mut random = Noise::new(seed * 104_729 + N as u64);
        let mut large = case(&mut random, N - 3, 6e-3, 6e-6);
        large.machine.settings.compensation.orientation = orientation;
        let (found, poses) = landing::<N>(&large, seed);
        let (tenth, _) = landing::<N>(&large.scaled(0.1), seed);
        let chain = &large.machine.settings.chain;
        // Second order, magnified by unfavourably oriented slides (1/0.06) and rotary axes (1/0.1): 20 nm of 6 µm.
        assert!(found[0] < 2e-5 && found[1] < 2e-8, "{chain}: {found:?}");
        for k in 0..2 {
            assert!(tenth[k] < found[k] / 50.0 + [1e-11, 1e-14][k], "{chain}: {found:?} {tenth:?}");
        }
        compared += poses;
    }
    assert!(f64::from(compared) > 0.5 * 20.0 * chains as f64, "{compared} poses compared");
}

#[test]
fn the_corrected_command_brings_the_tip_where_it_was_meant() {
    exact_inverse::<3>(100, false);
    exact_inverse::<4>(200, false);
    exact_inverse::<5>(400, false);
}

#[test]
fn with_orientation_the_tool_points_where_it_was_meant_too() {
    exact_inverse::<4>(200, true);
    exact_inverse::<5>(400, true);
    exact_inverse::<6>(50, true);
}
