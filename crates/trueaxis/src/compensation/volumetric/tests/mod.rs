#![allow(clippy::indexing_slicing)]

use super::slides::Work;
use super::tangent::Tangent;
use super::*;
use crate::check;
use crate::compensation::{NineTerms, Tables, requirement};
use crate::machine::{Interpolation, Row, links};
use crate::position::Nanometres;
use crate::testing::machine::{Machine, rows};
use crate::testing::noise::Noise;
use crate::testing::share::share;
use std::{format, string::String, vec, vec::Vec};

mod transforms;

const REACH_MM: f64 = 250.0;

/// A machine with random errors of 20 µm and 40 µrad, and its tables.
struct Case {
    machine: MachineSettings,
    tables: Vec<(Axis, Vec<Row>)>,
}

/// X, Y, Z and two rotary axes in any order on either side.
fn chain(random: &mut Noise, rotary: usize) -> String {
    let mut axes = vec!['X', 'Y', 'Z'];
    let mut free = vec!['A', 'B', 'C'];
    for _ in 0..rotary {
        axes.push(free.remove(random.below(free.len())));
    }
    let mut order = Vec::new();
    while !axes.is_empty() {
        order.push(axes.remove(random.below(axes.len())));
    }
    let bed = random.below(order.len() + 1);
    let workpiece: String = order[..bed].iter().map(|axis| format!("{axis}' ")).collect();
    let tool: String = order[bed..].iter().map(|axis| format!("{axis} ")).collect();
    format!("w {workpiece}b {tool}t")
}

fn case(random: &mut Noise, chain: &str, orientation: bool) -> Case {
    let mut tables = Vec::new();
    let machine = Machine::new(chain).tool(random.vector(100.0)).each(|axis| {
        axis.interpolation = if random.unit() < 0.5 { Interpolation::Cubic } else { Interpolation::Linear };
        axis.offset_mm = random.vector(80.0);
        if random.unit() < 0.5 {
            axis.measured_at_mm = random.vector(100.0);
        }
        axis.backlash = if axis.axis.is_rotary() { 3e-4 } else { 2e-3 } * random.unit();
        let (low, high) = if axis.axis.is_rotary() { (-180.0, 180.0) } else { (-REACH_MM - 10.0, REACH_MM + 10.0) };
        axis.travel = if axis.axis.is_rotary() { axis.travel } else { [-REACH_MM, REACH_MM] };
        axis.joint = axis.travel.map(|x| x * 1.01);
        axis.limits.magnitude = 0.3;
        let free = random.unit() < 0.5;
        let waves: [[f64; 4]; 6] = core::array::from_fn(|_| core::array::from_fn(|_| random.signed()));
        let places: Vec<f64> = (0..=60)
            .map(|i| if free && i > 0 && i < 60 { f64::from(i) + 0.3 * random.signed() } else { f64::from(i) } / 60.0)
            .collect();
        let of = |q: f64| {
            let phase = core::f64::consts::TAU * (q - low) / (high - low);
            core::array::from_fn(|k| {
                let [a, b, c, d] = waves[k];
                let size = if k < 3 { 0.01 } else { 20e-6 };
                size * (a * libm::cos(phase)
                    + b * libm::sin(phase)
                    + c * libm::cos(2.0 * phase)
                    + d * libm::sin(3.0 * phase))
            })
        };
        tables.push((axis.axis, rows(places.iter().map(|place| low + (high - low) * place), of)));
    });
    let mut machine = machine.settings();
    machine.compensation.model = crate::machine::ErrorModel::Volumetric;
    machine.compensation.orientation = orientation;
    machine.location.c0y = 20e-6 * random.signed();
    machine.location.b0z = 20e-6 * random.signed();
    machine.location.a0z = 20e-6 * random.signed();
    for errors in &mut machine.location.rotary {
        *errors = core::array::from_fn(|k| if k < 3 { 0.01 } else { 20e-6 } * random.signed());
    }
    machine.kinematics.tool_axis = [0.0, 0.6, 0.8];
    Case { machine, tables }
}

impl Case {
    fn rows(&self, axis: Axis) -> Option<&[Row]> {
        self.tables.iter().find(|(of, _)| *of == axis).map(|(_, rows)| &rows[..])
    }

    fn with<R: Real, P: Position, const N: usize, T>(&self, user: impl FnOnce(&Volumetric<'_, R, P, N>) -> T) -> T {
        let mut memory = vec![R::ZERO; requirement(&self.machine, |axis| self.rows(axis))];
        let order = AxisOrder::of(&self.machine).unwrap();
        user(&Volumetric::build(&order, &self.machine, |axis| self.rows(axis), &mut memory).unwrap())
    }

    /// A position within the tables and slightly beyond.
    fn place<const N: usize>(random: &mut Noise) -> [f64; N] {
        core::array::from_fn(
            |slot| if slot < 3 { (REACH_MM + 15.0) * random.signed() } else { 170.0 * random.signed() },
        )
    }

    /// Lines of thermal growth and directions of travel.
    fn conditions<R: Real, const N: usize>(random: &mut Noise) -> ([Direction; N], [ThermalLine<R>; N]) {
        let directions = core::array::from_fn(|_| Direction::of(random.unit() < 0.5));
        (
            directions,
            core::array::from_fn(|_| ThermalLine::new(2e-3 * random.signed(), 1e-6 * random.signed()).unwrap()),
        )
    }
}

fn direct<R: Real, P: Position, const N: usize>(
    model: &Volumetric<'_, R, P, N>,
    at: &[P; N],
    directions: &[Direction; N],
    thermal: &[ThermalLine<R>; N],
) -> ([f64; 3], [f64; 3], u8) {
    let mut edge = 0;
    let error = model.pose_error(&Query::at(&model.coordinates(at), directions, thermal), &mut edge);
    let doubles = |v: R::Vec3| Into::<[R; 3]>::into(v).map(R::to_f64);
    (doubles(error.tip), doubles(error.orientation), edge)
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::sqrt((0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum())
}

/// Largest differences of tip and direction between tangents and lookups, over boxes of random machines.
fn in_boxes<R: Real, P: Position, const N: usize>(random: &mut Noise, boxes: usize) -> [f64; 2] {
    let chain = chain(random, N - 3);
    let case = case(random, &chain, false);
    case.with::<R, P, N, _>(|model| {
        let mut worst = [0.0_f64; 2];
        for _ in 0..boxes {
            let at = Case::place::<N>(random).map(P::of);
            let (directions, thermal) = Case::conditions(random);
            let mut tangent = Tangent::empty();
            if N == 3 {
                let mut work = Work::none();
                model.begin_slides(&mut tangent, &mut work, &at, &directions);
                assert!(work.serves::<R>(&at) && !tangent.steps(&at).1);
                while !model.add_slide(&mut tangent, &mut work, &directions, &thermal) {}
            } else {
                model.tangent(&mut tangent, &at, &directions, &thermal);
            }
            assert!(tangent.steps(&at).1, "{chain}: {at:?}");
            for _ in 0..40 {
                // Also in corners; positions that rounding moves out of the box are skipped.
                let there = core::array::from_fn(|slot| {
                    let size = if slot < 3 { 8.0 } else { 0.4 } * random.unit() * random.unit();
                    let there = at[slot].plus(R::of(size * random.signed()));
                    let mut one = at;
                    one[slot] = there;
                    if tangent.steps(&one).1 { there } else { at[slot] }
                });
                let (steps, inside) = tangent.steps(&there);
                assert!(inside);
                let (tip, turn, edge) = direct(model, &there, &directions, &thermal);
                assert_eq!(tangent.edge, edge, "{chain}: {there:?}");
                worst[0] = worst[0].max(apart(tangent.tip(&steps).array().map(R::to_f64), tip));
                if N == 3 {
                    continue;
                }
                worst[1] = worst[1].max(apart(tangent.turn(&steps).array().map(R::to_f64), turn));
            }
        }
        worst
    })
}

#[test]
fn in_its_box_a_tangent_is_the_look_up() {
    let mut random = Noise::new(11);
    for _ in 0..share(60) {
        let [tip, turn] = in_boxes::<f64, f64, 3>(&mut random, 40);
        assert!(tip <= 0.7e-6 && turn <= 2e-9, "{tip:e} {turn:e}");
        let [tip, turn] = in_boxes::<f64, f64, 5>(&mut random, 40);
        assert!(tip <= 0.7e-6 && turn <= 2e-9, "{tip:e} {turn:e}");
        let [tip, turn] = in_boxes::<f64, f64, 6>(&mut random, 40);
        assert!(tip <= 0.7e-6 && turn <= 2e-9, "{tip:e} {turn:e}");
        // Lookups in single precision round by some parts in 1e7 of 50 µm, and their positions by 15 nm.
        let [tip, turn] = in_boxes::<f32, Nanometres, 5>(&mut random, 40);
        assert!(tip <= 0.8e-6 && turn <= 3e-9, "{tip:e} {turn:e}");
    }
}

/// Moves a machine at its highest speed; its limiter follows the wanted correction by `most` per cycle.
fn drive<const N: usize>(random: &mut Noise, case: &Case, passes: u8, most: f64) -> (f64, f64, usize) {
    let norm = check::jacobian_norm(&case.machine, |axis| case.rows(axis), &check::GridBounds::NONE);
    case.with::<f64, f64, N, _>(|model| {
        let mut cache = TangentCache::empty();
        let terms = None::<&NineTerms<'_, f64, f64, N>>;
        let tables = Tables::new(terms, None, [norm, 0.0], [1.0, most * libm::sqrt(N as f64)], passes);
        let (mut command, mut sent) = (Case::place::<N>(random).map(|q| q * 0.9), [0.0; N]);
        let (mut directions, thermal) = Case::conditions::<f64, N>(random);
        let mut speed = [0.0; N];
        let (mut locked, mut worst, mut back) = (0, 0.0_f64, 0.0_f64);
        for number in 0..3000 {
            if number % 300 == 0 {
                speed = core::array::from_fn(|slot| if slot < 3 { 0.1 } else { 0.02 } * random.signed());
                directions = speed.map(|speed| Direction::of(speed < 0.0));
            }
            for ((command, speed), size) in
                command.iter_mut().zip(&mut speed).zip([240.0, 240.0, 240.0, 170.0, 170.0, 170.0])
            {
                if command.abs() > size && *command * *speed > 0.0 {
                    *speed = -*speed;
                }
                *command += *speed;
            }
            let feedback: [f64; N] = core::array::from_fn(|slot| command[slot] + sent[slot] + 0.005 * random.signed());
            let drive: [f64; N] = core::array::from_fn(|slot| command[slot] + sent[slot]);
            let cycle = Cycle {
                command: &command,
                drive: &drive,
                feedback: &feedback,
                directions: &directions,
                thermal: &thermal,
                tables: &tables,
            };
            let (wanted, (tip, turn)) = model.modelled(&mut cache, &cycle, passes, true, &mut 0);
            let (tip_there, turn_there, _) = direct(model, &feedback, &directions, &thermal);
            back = back.max(apart(tip.array(), tip_there));
            assert!(apart(turn.array(), turn_there) < 2e-9);

            let at = model.coordinates(&command);
            let exact = model.correction(&Query::at(&at, &directions, &thermal), 8, &mut 0);
            let off = apart([wanted[0], wanted[1], wanted[2]], [exact[0], exact[1], exact[2]]);
            let held_back = libm::sqrt((0..N).map(|k| (sent[k] - exact[k]) * (sent[k] - exact[k])).sum());
            let bound = libm::pow(norm, passes.into()) * held_back;
            assert!(off <= bound + 0.8e-6, "cycle {number}: {off:e}, {held_back} held back at {norm}");
            if held_back <= most / (1.0 - norm) {
                (locked, worst) = (locked + 1, worst.max(off));
            }
            for (sent, wanted) in sent.iter_mut().zip(wanted) {
                *sent += (wanted - *sent).clamp(-most, most);
            }
        }
        (worst, back, locked)
    })
}

#[test]
fn the_inverse_from_the_correction_sent_last_is_the_converged_one() {
    let mut random = Noise::new(12);
    for _ in 0..share(12) {
        let links = chain(&mut random, 0);
        let of_three = case(&mut random, &links, false);
        let (worst, back, locked) = drive::<3>(&mut random, &of_three, 1, 1e-4);
        assert!(worst <= 1e-6 && back <= 0.7e-6 && locked > 1500, "{links}: {worst:e} {back:e} {locked}");
        let links = chain(&mut random, 2);
        for orientation in [false, true] {
            let of_five = case(&mut random, &links, orientation);
            let (worst, back, locked) = drive::<5>(&mut random, &of_five, 2, 1e-4);
            assert!(worst <= 1e-6 && back <= 0.7e-6, "{links} {orientation}: {worst:e} {back:e} {locked}");
        }
    }
}

#[test]
fn cached_state_is_dropped_with_the_tables() {
    let mut random = Noise::new(13);
    let first = case(&mut random, "w b X Y Z t", false);
    let mut second = case(&mut random, "w b X Y Z t", false);
    let keys = [&first, &second].map(|case| case.with::<f64, f64, 3, _>(|model| model.key));
    assert_ne!(keys[0], keys[1]);
    second.tables.clone_from(&first.tables);
    second.machine = first.machine.clone();
    assert_eq!(second.with::<f64, f64, 3, _>(|model| model.key), keys[0]);
    second.tables[1].1[7].reverse[4] += 1e-9;
    assert_ne!(second.with::<f64, f64, 3, _>(|model| model.key), keys[0]);
    second.tables[1].1[7].reverse[4] -= 1e-9;
    let mut seen = std::collections::BTreeSet::new();
    for [lookup, cross] in [[0, 0], [0, 1], [1, 0], [1, 1]] {
        let of = |which: usize| [Lookup::Command, Lookup::Feedback][which];
        (second.machine.axes[0].lookup, second.machine.axes[0].cross_lookup) = (of(lookup), of(cross));
        seen.insert(second.with::<f64, f64, 3, _>(|model| model.key));
    }
    assert_eq!(seen.len(), 4);
    second.machine.axes[0].clone_from(&first.machine.axes[0]);
    second.machine.tool_mm[2] += 1e-3;
    assert_ne!(second.with::<f64, f64, 3, _>(|model| model.key), keys[0]);
    assert_eq!(links(&second.machine.chain).unwrap().len(), 3);
}
