//! Both models and their corrections compared with products of homogeneous transforms, which are independent of the walk.

use super::super::*;
use crate::machine::Row;
use crate::testing::machine::{Machine, rows};
use crate::testing::noise::Noise;
use glam::{DAffine3, DMat3, DVec3};
use std::{vec, vec::Vec};

mod inverse;
mod nine;

/// Errors so small that their second-order terms lie below this, mm.
const CLOSE: f64 = 1e-10;

/// A machine with linear, equidistant tables.
struct Exact {
    machine: MachineSettings,
    tables: Vec<(Axis, Vec<Row>)>,
    lines: [[f64; 2]; 6],
}

/// Pose of the machine.
struct Pose {
    /// Orientation of the carrier of each axis and origin of its moved frame.
    carriers: Vec<(Axis, bool, DMat3, DVec3)>,
    workpiece: DAffine3,
    tip: DVec3,
    tool: DVec3,
}

fn along(axis: Axis) -> DVec3 {
    [DVec3::X, DVec3::Y, DVec3::Z][axis.index() % 3]
}

impl Exact {
    fn new(random: &mut Noise, chain: &str) -> Self {
        let mut tables = Vec::new();
        let machine = Machine::new(chain).tool(random.vector(100.0)).each(|axis| {
            axis.offset_mm = random.vector(80.0);
            axis.limits.magnitude = 0.3;
            axis.thermal.datum = 30.0 * random.signed();
            if axis.axis.is_rotary() && random.unit() < 0.5 {
                axis.direction = -1;
            }
            let step = if axis.axis.is_rotary() { 20.0 } else { 25.0 };
            let places = (-8..=8).map(|i| step * f64::from(i));
            let of = |_| core::array::from_fn(|k| if k < 3 { 1e-5 } else { 1e-8 } * random.signed());
            tables.push((axis.axis, rows(places, of)));
        });
        let mut machine = machine.settings();
        machine.compensation.model = crate::machine::ErrorModel::Volumetric;
        machine.kinematics.tool_axis = [0.3, 0.6, 1.4];
        (machine.location.c0y, machine.location.b0z, machine.location.a0z) = (2e-8, -3e-8, 1e-8);
        for errors in &mut machine.location.rotary {
            *errors = core::array::from_fn(|k| if k < 3 { 1e-5 } else { 1e-8 } * random.signed());
        }
        Exact { machine, tables, lines: core::array::from_fn(|_| [1e-5 * random.signed(), 1e-8 * random.signed()]) }
    }

    fn rows(&self, axis: Axis) -> Option<&[Row]> {
        self.tables.iter().find(|(of, _)| *of == axis).map(|(_, rows)| &rows[..])
    }

    fn pose(&self, q: &[f64; 6]) -> Pose {
        let code: Vec<char> = self.machine.chain.chars().filter(|c| c.is_ascii_uppercase()).collect();
        let count = self.machine.chain.split('b').next().unwrap().chars().filter(|c| c.is_ascii_uppercase()).count();
        let mut carriers = Vec::new();
        let mut out = |letters: &mut dyn Iterator<Item = &char>, on_workpiece: bool| {
            letters.fold(DAffine3::IDENTITY, |carrier, letter| {
                let axis = Axis::from_letter(*letter).unwrap();
                let settings = self.machine.axis(axis).unwrap();
                let q = q[axis.index()];
                let motion = if axis.is_rotary() {
                    DAffine3::from_axis_angle(along(axis), (f64::from(settings.direction) * q).to_radians())
                } else {
                    DAffine3::from_translation(along(axis) * if on_workpiece { -q } else { q })
                };
                let moved = carrier * DAffine3::from_translation(DVec3::from_array(settings.offset_mm)) * motion;
                carriers.push((axis, on_workpiece, carrier.matrix3, moved.translation));
                moved
            })
        };
        let workpiece = out(&mut code[..count].iter().rev(), true);
        let head = out(&mut code[count..].iter(), false);
        let tool = head.matrix3 * DVec3::from_array(self.machine.kinematics.tool_axis).normalize();
        let tip = head.transform_point3(DVec3::from_array(self.machine.tool_mm));
        Pose { carriers, workpiece, tip, tool }
    }

    /// An axis' twist from its table, clamped beyond its ends, plus the errors outside it; and whether it is clamped.
    fn twist(&self, axis: Axis, q: f64) -> ([f64; 6], bool) {
        let rows = self.rows(axis).unwrap();
        let (first, last) = (rows[0].position, rows[rows.len() - 1].position);
        let held = q.clamp(first, last);
        let i = rows.windows(2).position(|w| held <= w[1].position).unwrap();
        let t = (held - rows[i].position) / (rows[i + 1].position - rows[i].position);
        let located = self.machine.location.of(axis).copied().unwrap_or_default();
        let twist = core::array::from_fn(|k| {
            let [from, to] = [&rows[i], &rows[i + 1]].map(|row| row.forward[k]);
            from + t * (to - from) + located[k]
        });
        (twist, held != q)
    }

    fn growth(&self, axis: Axis, q: f64) -> f64 {
        let [offset, slope] = self.lines[axis.index()];
        offset + slope * (q - self.machine.axis(axis).unwrap().thermal.datum)
    }

    /// `d` and the rotation of the tool in the volumetric model, and the axes whose table is clamped.
    fn volumetric(&self, q: &[f64; 6]) -> (DVec3, DVec3, Vec<Axis>) {
        let pose = self.pose(q);
        let (mut tip, mut turn, mut held) = (DVec3::ZERO, DVec3::ZERO, Vec::new());
        for (axis, _, carrier, origin) in &pose.carriers {
            let q = q[axis.index()];
            let (mut twist, beyond) = self.twist(*axis, q);
            held.extend(beyond.then_some(*axis));
            let growth = self.growth(*axis, q);
            twist[axis.index()] += if axis.is_rotary() { growth.to_radians() } else { growth };
            let location = &self.machine.location;
            match axis {
                Axis::Y => twist[0] -= location.c0y * q,
                Axis::Z => (twist[0], twist[1]) = (twist[0] + location.b0z * q, twist[1] - location.a0z * q),
                _ => {}
            }
            let [x, y, z, a, b, c] = twist;
            let w = *carrier * DVec3::new(a, b, c);
            tip += *carrier * DVec3::new(x, y, z) + w.cross(pose.tip - *origin);
            turn += w;
        }
        (tip, turn, held)
    }

    fn with<const N: usize, T>(&self, user: impl FnOnce(&Volumetric<'_, f64, f64, N>, &AxisOrder<N>) -> T) -> T {
        let scalars = Volumetric::<f64, f64, N>::requirement(&self.machine, |axis| self.rows(axis));
        let (mut memory, order) = (vec![0.0; scalars], AxisOrder::of(&self.machine).unwrap());
        let rows = |axis| self.rows(axis);
        assert!(Volumetric::<f64, f64, N>::build(&order, &self.machine, rows, &mut memory[1..]).is_err());
        user(&Volumetric::build(&order, &self.machine, rows, &mut memory).unwrap(), &order)
    }

    fn thermal<const N: usize>(&self, order: &AxisOrder<N>) -> [ThermalLine<f64>; N] {
        order.axes().map(|axis| {
            let [offset, slope] = self.lines[axis.index()];
            ThermalLine::new(offset, slope).unwrap()
        })
    }

    /// Positions of the axes, zero for absent ones.
    fn place<const N: usize>(&self, random: &mut Noise, order: &AxisOrder<N>, size: f64) -> ([f64; 6], [f64; N]) {
        let all: [f64; 6] = core::array::from_fn(|k| size * if k < 3 { 220.0 } else { 170.0 } * random.signed());
        let has = |axis: Axis| self.machine.axis(axis).is_some();
        let all = Axis::ALL.map(|axis| if has(axis) { all[axis.index()] } else { 0.0 });
        (all, order.axes().map(|axis| all[axis.index()]))
    }
}

fn bits<const N: usize>(order: &AxisOrder<N>, held: &[Axis]) -> u8 {
    held.iter().map(|axis| 1 << order.slot(*axis).unwrap()).sum()
}

const FIVE: [&str; 8] = [
    "w C' A' b X Y Z t",
    "w b X Y Z C B t",
    "w B' C' b Z Y X t",
    "w C' X' b Y Z B t",
    "w X' Y' b Z C A t",
    "w Z' B' X' b Y A t",
    "w b X C Y A Z t",
    "w Y' X' C' b Z B t",
];

fn poses_of<const N: usize>(chain: &str, seed: u64) {
    let mut random = Noise::new(seed);
    let mut exact = Exact::new(&mut random, chain);
    for plain in [true, false] {
        // Looked up at the feedback, which equals the command: another code path to the same numbers.
        exact.machine.axes[0].lookup = if plain { Lookup::Command } else { Lookup::Feedback };
        exact.with::<N, _>(|model, order| {
            assert_eq!(model.plain, plain);
            let thermal = exact.thermal(order);
            for _ in 0..40 {
                let (all, at) = exact.place(&mut random, order, 1.0);
                let (tip, turn, held) = exact.volumetric(&all);
                let (coordinates, mut clamped) = (model.coordinates(&at), 0);
                let directions = [Direction::POSITIVE; N];
                let error = model.pose_error(&Query::at(&coordinates, &directions, &thermal), &mut clamped);
                assert!((error.tip - tip).length() < CLOSE, "{chain} {all:?}: {} {tip}", error.tip);
                assert!((error.orientation - turn).length() < 1e-14, "{chain}: {} {turn}", error.orientation);
                assert_eq!(clamped, bits(order, &held), "{chain} {all:?}");
                let tool = exact.pose(&all).tool;
                assert!((model.tool_axis(&coordinates) - tool).length() < 1e-12, "{chain} {all:?}");
            }
        });
    }
}

#[test]
fn twists_are_carried_to_the_tip_as_by_transforms() {
    for (seed, chain) in FIVE.into_iter().enumerate() {
        poses_of::<5>(chain, 20 + seed as u64);
    }
    for chain in ["w b X Y Z t", "w X' b Y Z t", "w Z' Y' b X t"] {
        poses_of::<3>(chain, 30);
    }
    poses_of::<6>("w A' b X Y Z C B t", 31);
    poses_of::<6>("w C' B' A' b X Y Z t", 32);
}
