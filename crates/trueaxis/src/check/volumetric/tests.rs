use super::*;
use crate::compensation::Query;
use crate::compensation::{Compensation, Direction, ThermalLine, requirement};
use crate::machine::{ErrorModel, Row};
use crate::testing::machine::Machine;
use crate::testing::noise::Noise;
use std::{string::String, vec, vec::Vec};

const REACH_MM: f64 = 60.0;

/// X, Y, Z and `rotary` rotary axes in any order, each on either side.
fn chain_of(random: &mut Noise, rotary: usize) -> String {
    let (mut axes, mut free) = (vec!['X', 'Y', 'Z'], vec!['A', 'B', 'C']);
    for _ in 0..rotary {
        axes.push(free.remove(random.below(free.len())));
    }
    let (bed, mut code) = (random.below(axes.len() + 1), String::from("w"));
    for place in 0..3 + rotary {
        if place == bed {
            code.push('b');
        }
        code.push(axes.remove(random.below(axes.len())));
        if place < bed {
            code.push('\'');
        }
    }
    if bed == 3 + rotary {
        code.push('b');
    }
    code + "t"
}

/// Offsets, tool and position of measurement, often longer than the travels, so that they dominate the levers.
fn machine_of(random: &mut Noise, rotary: usize) -> MachineSettings {
    let chain = chain_of(random, rotary);
    let machine = Machine::new(&chain).each(|axis| {
        axis.offset_mm = random.vector(100.0);
        axis.measured_at_mm = random.vector(100.0);
        axis.travel = if axis.axis.is_rotary() { [-180.0, 180.0] } else { [-REACH_MM, REACH_MM] };
    });
    let mut machine = machine.tool(random.vector(100.0)).settings();
    machine.compensation.model = ErrorModel::Volumetric;
    machine.kinematics.tool_axis = [0.0, 0.6, 0.8];
    machine
}

type Tables = Vec<(Axis, Vec<Row>)>;

/// For every axis, a table over its travel with `error` at each of its rows.
fn tables_of(machine: &MachineSettings, mut error: impl FnMut(Axis, f64) -> [f64; 6]) -> Tables {
    let table = |settings: &AxisSettings| {
        let [low, high] = settings.travel;
        let row = |i: i32| {
            let share = f64::from(i) / 12.0;
            let twist = error(settings.axis, share);
            Row { position: low + (high - low) * share, forward: twist, reverse: twist }
        };
        (settings.axis, (0..=12).map(row).collect())
    };
    machine.axes.iter().map(table).collect()
}

fn of<'r>(tables: &'r Tables) -> impl Fn(Axis) -> Option<&'r [Row]> {
    |axis| tables.iter().find(|(found, _)| *found == axis).map(|(_, rows)| &rows[..])
}

fn built<T, const N: usize>(
    machine: &MachineSettings,
    tables: &Tables,
    user: impl FnOnce(&Compensation<'_, f64, f64, N>) -> T,
) -> T {
    let mut memory = vec![0.0; requirement(machine, of(tables))];
    user(&Compensation::build(machine, of(tables), &[], 1, &mut memory).unwrap())
}

/// Positions up to `share` of the axes' reach; slides first, as the step's order is that of [`Axis::ALL`].
fn place<const N: usize>(random: &mut Noise, share: f64) -> [f64; N] {
    core::array::from_fn(|i| share * random.signed() * if i < 3 { REACH_MM } else { 180.0 })
}

/// Errors of up to `mm` and `rad`, periodic over the turn.
fn waves(random: &mut Noise, machine: &MachineSettings, mm: f64, rad: f64) -> Tables {
    let waves: Vec<[[f64; 3]; 6]> = (0..6).map(|_| [0; 6].map(|_| random.vector(1.0 / 3.0))).collect();
    tables_of(machine, |axis, share| {
        let turn = core::f64::consts::TAU * share;
        core::array::from_fn(|k| {
            let [a, b, c] = waves[axis.index()][k];
            let size = if k < 3 { mm } else { rad };
            size * (a * turn.cos() + b * turn.sin() + c * (2.0 * turn).cos())
        })
    })
}

fn no_growth<const N: usize>() -> [ThermalLine<f64>; N] {
    [ThermalLine::default(); N]
}

/// A constant rotation w of one axis moves the tip by w × lever: for w about X, Y, Z in turn the squares sum to 2 lever².
fn levers<const N: usize>(chains: u64) {
    let mut nearest = 0.0_f64;
    for seed in 0..chains {
        let mut random = Noise::new(seed * 7919 + N as u64);
        let machine = machine_of(&mut random, N - 3);
        let none = tables_of(&machine, |_, _| [0.0; 6]);
        for settings in &machine.axes {
            let bound = norm(&lever(&machine, &of(&none), settings));
            let places: Vec<[f64; N]> = (0..60).map(|_| place(&mut random, 1.0)).collect();
            let mut squares = vec![0.0; places.len()];
            for k in 3..6 {
                let turned = |axis| core::array::from_fn(|i| f64::from(u8::from(axis == settings.axis && i == k)));
                built::<_, N>(&machine, &tables_of(&machine, |axis, _| turned(axis)), |compensation| {
                    for (square, q) in squares.iter_mut().zip(&places) {
                        let at = compensation.coordinates(q);
                        let tip = compensation
                            .pose_error(&Query::at(&at, &[Direction::POSITIVE; N], &no_growth()), &mut 0)
                            .tip
                            .to_array();
                        *square += tip.iter().map(|x| x * x).sum::<f64>();
                    }
                });
            }
            for square in squares {
                // The step's sines for plain tables are coarse.
                let actual = (square / 2.0).sqrt();
                assert!(actual <= bound * (1.0 + 1e-6), "{} {:?}: {actual} {bound}", machine.chain, settings.axis);
                nearest = nearest.max(actual / bound);
            }
        }
    }
    assert!(nearest > 0.8, "{nearest}");
}

#[test]
fn no_lever_is_longer_than_its_bound() {
    levers::<3>(20);
    levers::<4>(40);
    levers::<5>(80);
    levers::<6>(40);
}

#[test]
fn offsets_on_both_sides_of_a_rotary_axis_add() {
    let mut machine = machine_of(&mut Noise::new(1), 0);
    machine.chain = "w b X Y Z A t".try_into().unwrap();
    for settings in &mut machine.axes {
        (settings.offset_mm, settings.measured_at_mm, settings.travel) = ([0.0; 3], [0.0; 3], [0.0, 0.0]);
    }
    let mut a = AxisSettings::with_defaults(Axis::A, false);
    a.offset_mm = [0.0, 0.0, 100.0];
    machine.axes.push(a).unwrap();
    machine.tool_mm = [0.0, 0.0, -100.0];
    let none = Tables::new();
    assert_eq!(lever(&machine, &of(&none), &machine.axes[0]), [200.0; 3]);
}

/// No secant of the errors is steeper than the rates.
fn steepest<const N: usize>(chains: u64) {
    for seed in 0..chains {
        let mut random = Noise::new(seed * 104_729 + N as u64);
        let machine = machine_of(&mut random, N - 3);
        // Turns without translations, and both: the effect of the levers must not be masked by the tables' own slopes.
        for (mm, level) in [(0.0, true), (0.0, false), (6e-3, false)] {
            let w = [0; 6].map(|_| random.vector(6e-6));
            let tables = if level {
                tables_of(&machine, |axis, _| {
                    let [a, b, c] = w[axis.index()];
                    [0.0, 0.0, 0.0, a, b, c]
                })
            } else {
                waves(&mut random, &machine, mm, 6e-6)
            };
            let bounds: Vec<[f64; 2]> =
                machine.axes.iter().map(|axis| rates(&machine, &of(&tables), &GridBounds::NONE, axis)).collect();
            built::<_, N>(&machine, &tables, |compensation| {
                for _ in 0..150 {
                    let q: [f64; N] = place(&mut random, 0.99);
                    let error = |q: &[f64; N]| {
                        let at = compensation.coordinates(q);
                        compensation.pose_error(&Query::at(&at, &[Direction::POSITIVE; N], &no_growth()), &mut 0)
                    };
                    let here = error(&q);
                    for (place, [tip, turn]) in bounds.iter().enumerate() {
                        let mut there = q;
                        there[place] += 0.05;
                        let there = error(&there);
                        let slope = |a: [f64; 3], b: [f64; 3]| {
                            norm(&core::array::from_fn::<f64, 3, _>(|k| (a[k] - b[k]) / 0.05))
                        };
                        let found = [
                            slope(there.tip.into(), here.tip.into()),
                            slope(there.orientation.into(), here.orientation.into()),
                        ];
                        assert!(found[0] <= tip * (1.0 + 1e-6) + 1e-12, "{} {place}: {found:?} {tip}", machine.chain);
                        assert!(found[1] <= turn * (1.0 + 1e-6) + 1e-15, "{} {place}: {found:?} {turn}", machine.chain);
                    }
                }
            });
        }
    }
}

#[test]
fn the_errors_change_no_faster_than_their_rates() {
    steepest::<3>(20);
    steepest::<4>(60);
    steepest::<5>(120);
    steepest::<6>(60);
}

/// Every pass comes closer to the next by at least the contraction factor, and no correction leaves its range.
fn contracts<const N: usize>(chains: u64, orientation: bool) {
    for seed in 0..chains {
        let mut random = Noise::new(seed * 15_485_863 + N as u64);
        let mut machine = machine_of(&mut random, N - 3);
        machine.compensation.orientation = orientation;
        let tables = waves(&mut random, &machine, 2e-3, 2e-6);
        let (norm_bound, _) = contraction(&machine, &of(&tables), &GridBounds::NONE);
        let weight = bounds(&machine, &of(&tables), &GridBounds::NONE).lever * 1f64.to_radians();
        let ranges: Vec<(f64, f64)> = machine
            .axes
            .iter()
            .map(|drive| error_range(&machine, &of(&tables), &GridBounds::NONE, drive, drive.travel))
            .collect();
        built::<_, N>(&machine, &tables, |compensation| {
            let volumetric = compensation.volumetric().unwrap();
            for _ in 0..150 {
                let q = place::<N>(&mut random, 0.9);
                let at = compensation.coordinates(&q);
                let after = |passes| {
                    volumetric.correction(&Query::at(&at, &[Direction::POSITIVE; N], &no_growth()), passes, &mut 0)
                };
                let step = |a: [f64; N], b: [f64; N]| {
                    norm(&core::array::from_fn::<f64, N, _>(|i| (a[i] - b[i]) * if i < 3 { 1.0 } else { weight }))
                };
                let passes = [1, 2, 3].map(after);
                let (first, second) = (step(passes[0], [0.0; N]), step(passes[1], passes[0]));
                let third = step(passes[2], passes[1]);
                let chain = &machine.chain;
                assert!(second <= norm_bound * first + 1e-12, "{chain}: {second} {first} {norm_bound}");
                assert!(third <= norm_bound * second + 1e-12, "{chain}: {third} {second} {norm_bound}");
                for (i, (r, (least, most))) in passes[0].iter().zip(&ranges).enumerate() {
                    let inside = -r >= least - 1e-12 && -r <= most + 1e-12;
                    assert!(inside, "{chain} {i}: {r} {least} {most}");
                }
            }
        });
    }
}

#[test]
fn the_inverse_contracts_and_stays_in_its_range() {
    contracts::<3>(20, false);
    contracts::<4>(40, false);
    contracts::<5>(80, false);
    contracts::<4>(40, true);
    contracts::<5>(80, true);
    contracts::<6>(40, true);
}
