#![allow(clippy::indexing_slicing)]

use super::*;
use crate::check::{self, GridBounds};
use crate::compensation::{Compensation, Direction, Query, ThermalLine, requirement};
use crate::error::Field;
use crate::machine::{ErrorModel, GridAxis, GridHeader};
use crate::position::{Nanometres, Position};
use crate::testing::machine::{Machine, rows};
use crate::testing::noise::Noise;
use std::{vec, vec::Vec};

/// A grid with its bytes.
#[derive(Clone, Debug)]
struct Made {
    header: GridHeader,
    bytes: Vec<u8>,
}

impl Made {
    /// Nodes along X, Y, Z (empty if the grid does not span that axis), all six errors or the translations, values in
    /// steps.
    fn new(nodes: [&[f64]; 3], given: u8, scales: [f64; 6], mut value: impl FnMut([f64; 3], usize) -> i16) -> Made {
        let mut header = GridHeader { given, ..GridHeader::default() };
        let mut bytes = Vec::new();
        for (along, nodes) in header.axes.iter_mut().zip(nodes) {
            let Some(last) = nodes.last() else { continue };
            let cell = (last - nodes[0]) / (nodes.len() - 1) as f64;
            let free = nodes.iter().enumerate().any(|(i, node)| (node - nodes[0] - cell * i as f64).abs() > 1e-9);
            *along = GridAxis { nodes: nodes.len() as u16, ends: [nodes[0], *last], free };
            if free {
                bytes.extend(nodes.iter().flat_map(|node| node.to_le_bytes()));
            }
        }
        let or_zero = |nodes: &[f64]| if nodes.is_empty() { vec![0.0] } else { nodes.to_vec() };
        for x in or_zero(nodes[0]) {
            for y in or_zero(nodes[1]) {
                for z in or_zero(nodes[2]) {
                    for component in (0..6).filter(|component| given >> component & 1 == 1) {
                        header.scales[component] = scales[component];
                        bytes.extend(value([x, y, z], component).to_le_bytes());
                    }
                }
            }
        }
        Made { header, bytes }
    }

    fn random(noise: &mut Noise, over: [bool; 3], given: u8, size: f64) -> Made {
        let nodes: [Vec<f64>; 3] = over.map(|there| {
            let free = noise.unit() < 0.5;
            let count = if there { 2 + noise.below(6) } else { 0 };
            let first = noise.range(-300.0, 0.0);
            let stray = |noise: &mut Noise| if free { noise.range(-20.0, 20.0) } else { 0.0 };
            (0..count).map(|i| first + 75.0 * i as f64 + stray(noise)).collect()
        });
        let scales = [1e-6, 2e-6, 5e-7, 1e-9, 1e-9, 2e-9].map(|scale| scale * size);
        Made::new([&nodes[0], &nodes[1], &nodes[2]], given, scales, |_, _| (20_000.0 * noise.signed()) as i16)
    }

    fn data(&self) -> GridData<'_> {
        GridData::new(self.header, &self.bytes).unwrap().0
    }

    /// Reference: the sum over the corners of the cell, weight by weight.
    fn error(&self, at: [f64; 3]) -> [f64; 6] {
        let data = self.data();
        let places: Vec<Vec<(usize, f64)>> = (0..3)
            .map(|axis| {
                let count = usize::from(self.header.axes[axis].nodes);
                if count == 0 {
                    return vec![(0, 1.0)];
                }
                let node = |index| data.position(axis, index).unwrap();
                let q = at[axis].clamp(node(0), node(count - 1));
                let cell = (1..count - 1).take_while(|i| node(*i) <= q).count();
                let share = (q - node(cell)) / (node(cell + 1) - node(cell));
                vec![(cell, 1.0 - share), (cell + 1, share)]
            })
            .collect();
        let mut sum = [0.0; 6];
        for (i, x) in &places[0] {
            for (j, y) in &places[1] {
                for (k, z) in &places[2] {
                    let node = data.node([*i, *j, *k]).unwrap();
                    (0..6).for_each(|c| sum[c] += x * y * z * node[c]);
                }
            }
        }
        let weight = self.header.fade.map_or(1.0, |[whole, none]| ((none - at[2]) / (none - whole)).clamp(0.0, 1.0));
        sum.map(|error| weight * error)
    }
}

const OVER: [[bool; 3]; 4] = [[true, true, false], [true, false, true], [false, true, true], [true; 3]];

fn nine() -> MachineSettings {
    Machine::three_axis().travel([-400.0, 400.0], 1.0).settings()
}

fn volumetric(chain: &str) -> MachineSettings {
    let machine = Machine::new(chain).travel([-400.0, 400.0], 1.0).tool([12.0, -7.0, -90.0]);
    machine.with(|machine| machine.compensation.model = ErrorModel::Volumetric).settings()
}

fn place(noise: &mut Noise) -> [f64; 3] {
    noise.vector(500.0)
}

#[test]
fn a_look_up_is_the_weighted_sum_over_the_corners() {
    let mut noise = Noise::new(11);
    let machine = nine();
    for case in 0..400 {
        let given = 1 + noise.below(63) as u8;
        let made = Made::random(&mut noise, OVER[case % 4], given, 1.0);
        check::grids(&machine, &[made.data()]).unwrap();
        let grids = Grids::<f64>::build(&machine, &[made.data()]).unwrap();
        let single = Grids::<f32>::build(&machine, &[made.data()]).unwrap();
        for _ in 0..40 {
            let at = place(&mut noise);
            let found = grids.of_slides(&at);
            let truth = made.error(at);
            for k in 0..3 {
                assert!((found.tip.array()[k] - truth[k]).abs() < 1e-12, "{case} {at:?}: {found:?} {truth:?}");
                let single = single.of_slides(&at.map(|x| x as f32)).tip.array()[k];
                assert!((f64::from(single) - truth[k]).abs() < 1e-6, "{case} {at:?}: {single} {truth:?}");
            }
            for (axis, along) in made.header.axes.iter().enumerate() {
                let beyond = along.is_there() && !(along.ends[0]..=along.ends[1]).contains(&at[axis]);
                assert_eq!(found.edge >> axis & 1 == 1, beyond);
            }
        }
    }
}

/// At every node, from either side along every axis.
#[test]
fn there_is_no_jump_at_a_node() {
    let mut noise = Noise::new(12);
    for case in 0..40 {
        let made = Made::random(&mut noise, OVER[case % 4], 0b000_111, 1.0);
        let grids = Grids::<f64>::build(&nine(), &[made.data()]).unwrap();
        let data = made.data();
        for index in data.indices() {
            let node: [f64; 3] = core::array::from_fn(|axis| data.position(axis, index[axis]).unwrap_or(17.0));
            let value = grids.of_slides(&node).tip.array();
            let stored = data.node(index).unwrap();
            for axis in 0..3 {
                for side in [-1e-7, 1e-7] {
                    let mut shifted = node;
                    shifted[axis] += side;
                    let shifted = grids.of_slides(&shifted).tip.array();
                    for k in 0..3 {
                        assert!((value[k] - stored[k]).abs() < 1e-12 && (shifted[k] - value[k]).abs() < 1e-9);
                    }
                }
            }
        }
    }
}

/// Nodes at whole millimetres, slopes in whole steps: the stored numbers are the function itself.
#[test]
fn affine_functions_are_exact() {
    let mut noise = Noise::new(13);
    let nodes: [&[f64]; 3] = [&[-100.0, -40.0, 0.0, 55.0, 90.0], &[0.0, 50.0, 100.0], &[-30.0, 10.0, 20.0]];
    for over in OVER {
        let of = core::array::from_fn(|k| if over[k] { nodes[k] } else { &[][..] });
        let function = |[x, y, z]: [f64; 3], k: usize| 3.0 + x * (k as f64 + 1.0) - 2.0 * y + z * k as f64;
        let made = Made::new(of, 0b000_111, [1e-6; 6], |at, k| function(at, k) as i16);
        let grids = Grids::<f64>::build(&nine(), &[made.data()]).unwrap();
        for _ in 0..200 {
            let at: [f64; 3] = core::array::from_fn(|k| match of[k] {
                [first, .., last] => noise.range(*first, *last),
                _ => 0.0,
            });
            let found = grids.of_slides(&at).tip.array();
            for k in 0..3 {
                assert!((found[k] - 1e-6 * function(at, k)).abs() < 1e-15, "{at:?}");
            }
        }
    }
}

#[test]
fn a_grid_fades_with_height() {
    let mut noise = Noise::new(14);
    let mut made = Made::random(&mut noise, OVER[0], 0b000_100, 1.0);
    made.header.fade = Some([1.0, 10.0]);
    check::grids(&nine(), &[made.data()]).unwrap();
    let grids = Grids::<f64>::build(&nine(), &[made.data()]).unwrap();
    let at = |z: f64| grids.of_slides(&[-50.0, -20.0, z]).tip.z;
    assert!(at(0.0) != 0.0 && at(-400.0) == at(1.0) && (at(0.0) - at(1.0)).abs() < 1e-18);
    assert!((at(5.5) - 0.5 * at(1.0)).abs() < 1e-15 && at(10.0) == 0.0 && at(300.0) == 0.0);
    for _ in 0..300 {
        let place = [noise.range(-500.0, 500.0), noise.range(-500.0, 500.0), noise.range(-5.0, 15.0)];
        assert!((grids.of_slides(&place).tip.z - made.error(place)[2]).abs() < 1e-12);
    }
}

/// Boxes compared with direct lookups: several grids at once, rotations with their levers, fading grids.
fn boxes_agree<R: Real, P: Position>(seed: u64, tolerance: f64) {
    let mut noise = Noise::new(seed);
    for case in 0..150 {
        let settings = if case % 3 == 0 { nine() } else { volumetric(["w X' Y' b Z t", "w b Y X Z t"][case % 2]) };
        let count = 1 + noise.below(GRIDS);
        let mut made: Vec<Made> = Vec::new();
        for place in 0..count {
            let over = OVER[noise.below(4)];
            let mut one = Made::random(&mut noise, over, [0b111, 63][place % 2], 0.3);
            one.header.measured_at_mm =
                core::array::from_fn(
                    |axis| {
                        if one.header.axes[axis].is_there() { 0.0 } else { noise.range(-200.0, 200.0) }
                    },
                );
            if !one.header.axes[2].is_there() && one.header.given == 0b111 {
                let from = noise.range(-300.0, 100.0);
                one.header.fade = Some([from, from + noise.range(5.0, 200.0)]);
            }
            made.push(one);
        }
        let data: Vec<GridData<'_>> = made.iter().map(Made::data).collect();
        check::grids(&settings, &data).unwrap();
        let exact = Grids::<f64>::build(&settings, &data).unwrap();
        let grids = Grids::<R>::build(&settings, &data).unwrap();
        let mut kept = NearGrids::<R, P>::empty();
        let mut at = place(&mut noise);
        for _ in 0..200 {
            let step = [0.01, 3.0, 60.0][noise.below(3)];
            at = core::array::from_fn(|k| (at[k] + step * noise.signed()).clamp(-500.0, 500.0));
            let feedback = at.map(|x| x + 0.01);
            let [command, back] = [at, feedback].map(|at| at.map(P::of));
            // One box a call.
            let first = kept.about(&grids, &command, &back);
            assert!(first.iter().any(Option::is_some), "{case}: {at:?}");
            assert!(kept.about(&grids, &command, &back).iter().all(Option::is_some), "{case}: {at:?}");
            let ([drives, tip], edge) = (kept.errors(&command, &back), kept.edge());
            let truth = |place: [P; 3]| exact.of_slides(&place.map(|p| p.to_f64()));
            for (found, truth) in [(drives, truth(command)), (tip, truth(back))] {
                for (found, truth) in found.array().into_iter().zip(truth.tip.array()) {
                    let off = (found.to_f64() - truth).abs();
                    assert!(off < tolerance, "{case}: {off:e} at {at:?}");
                }
            }
            // Next to an end, a box extends to either side of it.
            let near_end = made
                .iter()
                .flat_map(|m| m.header.axes.iter().enumerate())
                .any(|(axis, along)| along.is_there() && along.ends.iter().any(|end| (end - at[axis]).abs() < 0.03));
            assert!(near_end || edge == truth(command).edge);
        }
    }
}

#[test]
fn boxes_say_what_look_ups_say() {
    boxes_agree::<f64, f64>(21, 0.2e-6);
    boxes_agree::<f32, f64>(22, 0.4e-6);
    boxes_agree::<f32, Nanometres>(23, 0.4e-6);
}

/// `q + r + E(q + r) = q`, tables and grids together.
#[test]
fn the_inverse_takes_the_grid_in() {
    let mut noise = Noise::new(31);
    for case in 0..60 {
        let machine = [nine(), volumetric("w X' Y' b Z t"), volumetric("w b Y X Z t")][case % 3].clone();
        let table = rows([-400.0, 0.0, 400.0], |_| {
            let ([x, y, z], [a, b, c]) = (noise.vector(0.02), noise.vector(20e-6));
            [x, y, z, a, b, c]
        });
        let tables = |axis: Axis| (axis != Axis::Y).then_some(&table[..]);
        let made = Made::random(&mut noise, OVER[case % 4], 63, 1.0);
        let grids = [made.data()];
        let passes = check::machine(&machine, tables, &grids).unwrap();
        let mut memory = vec![0.0; requirement(&machine, tables)];
        let compensation = Compensation::<f64, f64, 3>::build(&machine, tables, &grids, passes, &mut memory).unwrap();
        for _ in 0..50 {
            let q = place(&mut noise);
            let at = compensation.coordinates(&q);
            let (directions, thermal) = ([Direction::POSITIVE; 3], [ThermalLine::default(); 3]);
            let r = compensation.correction(&Query::at(&at, &directions, &thermal), &mut 0);
            let sent: [f64; 3] = core::array::from_fn(|k| q[k] + r[k]);
            let at = compensation.coordinates(&sent);
            let error = compensation.errors(&Query::at(&at, &directions, &thermal), &mut 0);
            for k in 0..3 {
                assert!((r[k] + error[k]).abs() < check::INVERSE_TOLERANCE_MM, "{case} {q:?}");
            }
        }
    }
}

/// Half of the steepest cell of a random grid suffices to show that the bound is valid and that it is reached.
#[test]
fn bounds_hold_and_are_reached() {
    let mut noise = Noise::new(32);
    for case in 0..60 {
        let made = Made::random(&mut noise, OVER[case % 4], 0b000_111, 1.0);
        let grids = Grids::<f64>::build(&nine(), &[made.data()]).unwrap();
        let bounds = GridBounds::of(&[made.data()]);
        let mut most = [[0.0f64; 3]; 3];
        for _ in 0..3000 {
            let at = place(&mut noise);
            for axis in 0..3 {
                let mut shifted = at;
                shifted[axis] += 1e-4;
                let (here, there) = (grids.of_slides(&at).tip.array(), grids.of_slides(&shifted).tip.array());
                for k in 0..3 {
                    most[k][axis] = most[k][axis].max((there[k] - here[k]).abs() / 1e-4);
                    let [least, largest] = bounds.values(k);
                    assert!(here[k] >= least - 1e-12 && here[k] <= largest + 1e-12);
                }
            }
        }
        for (k, most) in most.iter().enumerate() {
            for (axis, most) in Axis::ALL.into_iter().zip(most) {
                let bound = bounds.slope(axis, k);
                assert!(*most <= bound * (1.0 + 1e-6) + 1e-9, "{case} {k} {axis:?}: {most} {bound}");
                assert!(*most >= 0.4 * bound, "{case} {k} {axis:?}: {most} {bound}");
            }
        }
    }
}

#[test]
fn a_grid_too_steep_to_be_inverted_is_refused() {
    let machine = nine();
    let steep =
        |value: i16| Made::new([&[0.0, 1.0], &[0.0, 1.0], &[]], 1, [1e-5; 6], move |[x, ..], _| x as i16 * value);
    let table = rows([-400.0, 400.0], |_| [0.0; 6]);
    let tables = |_| Some(&table[..]);
    let none = check::machine(&machine, tables, &[]).unwrap();
    let little = check::machine(&machine, tables, &[steep(500).data()]).unwrap();
    assert!(little > none, "{little} {none}");
    let error = check::machine(&machine, tables, &[steep(30_000).data()]).unwrap_err();
    assert_eq!(error.field, Field::Inverse);
    assert!(error.found > 0.3, "{}", error.found);
}

#[test]
fn invalid_grids_are_refused() {
    let machine = nine();
    let good = Made::new([&[0.0, 50.0, 110.0], &[0.0, 40.0], &[]], 0b100, [1e-6; 6], |_, _| 1001);
    check::grids(&machine, &[good.data()]).unwrap();
    check::grids(&machine, &[good.data(); GRIDS]).unwrap();
    let refused = |change: &dyn Fn(&mut Made), field: Field| {
        let mut made = good.clone();
        change(&mut made);
        let bytes = vec![0; made.header.bytes().unwrap().iter().sum::<usize>().max(made.bytes.len())];
        let mut all = made.bytes.clone();
        all.resize(bytes.len(), 0);
        let data = GridData::new(made.header, &all).unwrap().0;
        let error = check::grids(&machine, &[good.data(), data]).unwrap_err();
        assert_eq!((error.field, error.index), (field, Some(1)));
    };
    refused(&|made| made.header.axes[1] = GridAxis::default(), Field::GridAxes);
    refused(&|made| made.header.axes[1].nodes = 1, Field::GridTable);
    refused(&|made| made.header.axes[1].nodes = 1001, Field::GridTable);
    refused(&|made| made.header.axes[1].ends = [0.0, 0.0], Field::GridTable);
    refused(&|made| made.header.axes[1].ends = [40.0, 0.0], Field::GridTable);
    refused(&|made| made.header.axes[1].ends = [0.0, f64::NAN], Field::GridTable);
    refused(&|made| made.header.axes[1].ends = [0.0, 2e6], Field::GridTable);
    refused(&|made| made.header.axes[0].ends = [0.0, 111.0], Field::GridTable);
    refused(&|made| made.header.axes[2].ends = [0.0, 1.0], Field::GridAxes);
    refused(&|made| made.bytes[8..16].copy_from_slice(&(-3.0f64).to_le_bytes()), Field::GridTable);
    refused(&|made| made.bytes[8..16].copy_from_slice(&f64::NAN.to_le_bytes()), Field::GridTable);
    refused(&|made| made.header.given = 0, Field::GridTable);
    refused(&|made| made.header.given = 64 | 4, Field::GridTable);
    refused(&|made| made.header.scales[2] = 0.0, Field::GridResolution);
    refused(&|made| made.header.scales[2] = f64::NAN, Field::GridResolution);
    refused(&|made| made.header.scales[0] = 1e-6, Field::GridResolution);
    let beyond = |made: &mut Made| {
        made.header.scales[2] = 1e-3;
        let last = made.bytes.len() - 2;
        made.bytes[last..].copy_from_slice(&10_001i16.to_le_bytes());
    };
    refused(&beyond, Field::GridTable);
    refused(&|made| made.header.fade = Some([1.0, 1.0]), Field::GridFade);
    refused(&|made| made.header.fade = Some([1.0, f64::INFINITY]), Field::GridFade);
    refused(&|made| made.header.measured_at_mm = [1.0, 0.0, 0.0], Field::GridMeasuredAt);
    refused(&|made| made.header.measured_at_mm = [0.0, 0.0, f64::NAN], Field::GridMeasuredAt);
    let error = check::grids(&machine, &[good.data(); GRIDS + 1]).unwrap_err();
    assert_eq!(error.field, Field::GridTable);
    let without_x = Machine::new("w b Y Z t").settings();
    assert_eq!(check::grids(&without_x, &[good.data()]).unwrap_err().field, Field::GridAxes);
    // A fade needs Z, a grid that does not span it, and no rotations.
    let faded = |over: [&[f64]; 3], given: u8| {
        let mut made = Made::new(over, given, [1e-6; 6].map(|s| s), |_, _| 10);
        made.header.fade = Some([1.0, 2.0]);
        made
    };
    let (few, no): (&[f64], &[f64]) = (&[0.0, 9.0], &[]);
    check::grids(&machine, &[faded([few, few, no], 4).data()]).unwrap();
    for made in [faded([few, no, few], 4), faded([few, few, few], 4), faded([few, few, no], 12)] {
        assert_eq!(check::grids(&machine, &[made.data()]).unwrap_err().field, Field::GridFade);
    }
    let flat = Machine::new("w b X Y t").settings();
    assert_eq!(check::grids(&flat, &[faded([few, few, no], 4).data()]).unwrap_err().field, Field::GridFade);
}

/// Keys distinguish grids, so that a box of one is never used for another.
#[test]
fn every_number_of_a_grid_is_in_its_key() {
    let machine = nine();
    let made = Made::new([&[0.0, 50.0, 110.0], &[0.0, 40.0], &[]], 0b100, [1e-6; 6], |[x, ..], _| x as i16);
    let key = |made: &Made, machine: &MachineSettings| Grids::<f64>::build(machine, &[made.data()]).unwrap().key();
    let own = key(&made, &machine);
    let mut others = Vec::new();
    for byte in 0..made.bytes.len() {
        let mut other = made.clone();
        other.bytes[byte] ^= 1;
        others.push(key(&other, &machine));
    }
    for change in [
        (|made| made.header.scales[2] = 2e-6) as fn(&mut Made),
        |made| made.header.fade = Some([0.0, 1.0]),
        |made| made.header.axes[1].ends[1] = 41.0,
        |made| made.header.measured_at_mm[2] = 1.0,
    ] {
        let mut other = made.clone();
        change(&mut other);
        others.push(key(&other, &machine));
    }
    // In the other model, rotations count too.
    let mut volumetric = machine.clone();
    volumetric.compensation.model = ErrorModel::Volumetric;
    others.push(key(&made, &volumetric));
    assert!(own != 0 && others.iter().all(|other| *other != own));
}
