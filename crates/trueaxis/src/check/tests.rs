use super::*;
use crate::compensation::Query;
use crate::machine::is_turned;
use crate::machine::{CompensationSettings, ErrorModel, Interpolation, LocationErrors, PeriodicSettings, Row};
use crate::testing::machine::Machine;
use crate::testing::noise::Noise;
use std::{vec, vec::Vec};

fn rows_of(points: &[(f64, [f64; 6])]) -> Vec<Row> {
    points.iter().map(|&(position, error)| Row { position, forward: error, reverse: error }).collect()
}

fn column(component: usize, points: &[(f64, f64)]) -> Vec<Row> {
    let error = |value| core::array::from_fn(|k| if k == component { value } else { 0.0 });
    rows_of(&points.iter().map(|&(q, value)| (q, error(value))).collect::<Vec<_>>())
}

fn machine_of(chain: &str) -> MachineSettings {
    Machine::new(chain).settings()
}

#[test]
fn chains_with_sense_are_read_from_workpiece_to_tool() {
    let axes = |chain| links(chain).map(|l| l.iter().map(|l| (l.axis, l.carries_workpiece)).collect::<Vec<_>>());
    let head = [(Axis::X, true), (Axis::Y, false), (Axis::Z, false)].to_vec();
    assert_eq!(axes("w X' b Y Z t"), Ok(head.clone()));
    assert_eq!(axes(" wX'bYZt "), Ok(head));
    assert_eq!(axes("w b t"), Ok(vec![]));
    assert_eq!(axes("w C' A' X' b Y Z t").unwrap().len(), 5);
}

#[test]
fn chains_without_sense_are_refused_at_their_letter() {
    for (chain, place) in [
        ("", 0.0),
        ("b X t", 0.0),
        ("w X b t", 2.0),
        ("w b X' t", 4.0),
        ("w X' b X t", 7.0),
        ("w X'' b t", 4.0),
        ("w x' b t", 2.0),
        ("w b b t", 4.0),
        ("w t", 2.0),
        ("w b X", 5.0),
        ("w b X t Y", 8.0),
        ("w é' b t", 2.0),
    ] {
        let error = links(chain).unwrap_err();
        assert_eq!((error.field, error.found), (Field::Chain, place), "{chain}");
    }
}

#[test]
fn a_rotary_axis_turns_what_it_carries() {
    let links = links("w C' A' Y' b X B Z t").unwrap();
    let turned = [Axis::C, Axis::Z];
    for link in &links {
        assert_eq!(is_turned(&links, link.axis), turned.contains(&link.axis), "{:?}", link.axis);
    }
}

#[test]
fn look_ups_of_the_inverse() {
    assert_eq!(inverse_passes(0.05, 0.1), Ok(4));
    assert_eq!(inverse_passes(0.1, 0.1), Ok(5));
    assert_eq!(inverse_passes(0.0, 0.1), Ok(1));
    assert_eq!(inverse_passes(1e-3, 0.1), Ok(2));
    // 0.1 · n⁸ = 1e-6 at n = 10^(−5/8).
    let edge = 10_f64.powf(-5.0 / 8.0);
    assert_eq!(inverse_passes(edge, 0.1), Ok(8));
    for norm in [edge * 1.001, 1.0, 2.0, f64::NAN, f64::INFINITY, -0.1] {
        assert_eq!(inverse_passes(norm, 0.1).unwrap_err().field, Field::Inverse, "{norm}");
    }
    assert_eq!(inverse_passes(0.1, f64::NAN).unwrap_err().field, Field::Magnitude);
}

/// Bound of the iteration itself: after N lookups at most 1e-6 mm remains.
#[test]
fn the_look_ups_suffice() {
    for norm in [0.01, 0.05, 0.12, 0.2] {
        let error = |p: f64| 0.05 * libm::sin(p * norm / 0.05);
        let passes = inverse_passes(norm, 0.1).unwrap();
        for i in 0..1000 {
            let q = f64::from(i) * 0.37;
            let truth = (0..200).fold(0.0, |r, _| -error(q + r));
            let r = (0..passes).fold(0.0, |r, _| -error(q + r));
            assert!((r - truth).abs() <= 1e-6, "{norm} {q}");
        }
    }
}

#[test]
fn the_norm_adds_up_all_slopes_and_squareness() {
    let mut machine = machine_of("w X' b Y Z t");
    machine.location = LocationErrors { a0z: -3e-3, b0z: 1e-3, c0y: 2e-3, ..Default::default() };
    // Slopes: EXX 0.01 then −0.03; EZX 0.02; EYZ 0.004.
    let x =
        rows_of(&[(0.0, [0.0; 6]), (10.0, [0.1, 0.0, 0.2, 0.0, 0.0, 5.0]), (20.0, [-0.2, 0.0, 0.2, 0.0, 0.0, 0.0])]);
    let z = column(1, &[(0.0, 0.0), (5.0, 0.02)]);
    let tables = |axis| match axis {
        Axis::X => Some(&x[..]),
        Axis::Z => Some(&z[..]),
        _ => None,
    };
    let entries: [f64; 5] = [0.03, 0.02, 0.004 + 0.003, 0.001, 0.002];
    let truth = entries.iter().map(|e| e * e).sum::<f64>().sqrt();
    assert!((jacobian_norm(&machine, tables, &GridBounds::NONE) - truth).abs() < 1e-15);
    // In cubic form the slope varies; compare with differences at most 1e-4 mm away (second derivative some 0.004/mm).
    machine.axes[0].interpolation = Interpolation::Cubic;
    let curve = Curve::new(&machine.axes[0], &x[..], 0, false);
    let h = 1e-5;
    let differences = (0..200_000).map(|i| {
        let q = f64::from(i) * 1e-4;
        ((curve.at(q + h).unwrap() - curve.at(q).unwrap()) / h).abs()
    });
    let steepest = differences.fold(0.0, f64::max);
    assert!((curve.steepest().0 - steepest).abs() < 1e-6, "{} {steepest}", curve.steepest().0);
}

#[test]
fn rotary_errors_count_in_their_own_unit() {
    let machine = machine_of("w C' b X t");
    // EXC 1 µm and ECC 1 mrad per degree: 0.057 rad/rad.
    let c = rows_of(&[(0.0, [0.0; 6]), (1.0, [1e-3, 0.0, 0.0, 0.0, 0.0, 1e-3])]);
    let norm = jacobian_norm(&machine, |axis| (axis == Axis::C).then_some(&c[..]), &GridBounds::NONE);
    let own = 1e-3_f64.to_degrees();
    assert!((norm - (own * own + 1e-6_f64).sqrt()).abs() < 1e-15);
    assert!(rows(&machine.axes[1], &c[..]).is_ok());
    let steep = column(5, &[(0.0, 0.0), (0.5, 0.00875)]);
    assert_eq!(rows(&machine.axes[1], &steep[..]).unwrap_err().field, Field::Table);
    // About X, the slope is a cross term.
    let cross = column(3, &[(0.0, 0.0), (0.5, 0.00875)]);
    assert!(rows(&machine.axes[1], &cross[..]).is_ok());
}

#[test]
fn tables_that_break_a_rule_are_refused_at_their_line() {
    let x = AxisSettings::with_defaults(Axis::X, false);
    let cubic = AxisSettings { interpolation: Interpolation::Cubic, ..x };
    let c = AxisSettings::with_defaults(Axis::C, false);
    let good = [(0.0, 0.0), (1.0, 0.1), (2.0, 0.0)];
    assert_eq!(table(&x, &column(0, &good)[..]), Ok(()));
    let fault = |settings: &AxisSettings, component, points: &[(f64, f64)]| {
        table(settings, &column(component, points)[..]).map_err(|fault| (fault.rule, fault.row, fault.component))
    };
    assert_eq!(fault(&x, 0, &good[..1]), Err((TableRule::Count, 0, None)));
    assert_eq!(fault(&x, 0, &[]), Err((TableRule::Count, 0, None)));
    assert_eq!(fault(&x, 0, &[(0.0, 0.0), (0.0, 0.0)]), Err((TableRule::Increasing, 1, None)));
    assert_eq!(fault(&x, 0, &[(0.0, 0.0), (1.0, 0.0), (f64::NAN, 0.0)]), Err((TableRule::Position, 2, None)));
    assert_eq!(fault(&x, 4, &[(0.0, 0.0), (1.0, f64::INFINITY)]), Err((TableRule::Rotation, 1, Some(4))));
    assert_eq!(fault(&x, 0, &[(0.0, 0.0), (1.0, 0.0), (2.0, -1.0)]), Err((TableRule::Slope, 1, Some(0))));
    assert_eq!(fault(&x, 1, &[(0.0, 0.0), (1.0, 0.0), (2.0, -1.0)]), Ok(()));
    // Secants of 0.9, but between extremes the cubic is 1.5 times as steep.
    let stair = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.9), (3.0, 0.9)];
    assert_eq!(fault(&x, 0, &stair), Ok(()));
    assert_eq!(fault(&cubic, 0, &stair), Err((TableRule::Slope, 1, Some(0))));
    let found = table(&cubic, &column(0, &stair)[..]).unwrap_err().found;
    assert!((found - 1.5 * 0.9).abs() < 1e-14, "{found}");
    // In doubles these decimals are not 360 apart.
    let inexact = [(152.2, 1e-6), (332.0, 0.0), (512.2, 1.02e-6)];
    assert!(inexact[2].0 - inexact[0].0 != 360.0);
    assert_eq!(fault(&c, 5, &inexact), Err((TableRule::Closed, 2, Some(5))));
    let circle = |end| [(-180.0, 1e-6), (0.0, 0.0), (180.0, end)];
    assert_eq!(fault(&c, 5, &circle(1.01e-6)), Ok(()));
    assert_eq!(fault(&c, 5, &circle(1.02e-6)), Err((TableRule::Closed, 2, Some(5))));
    assert_eq!(fault(&c, 0, &circle(1.02e-6)), Ok(()));
    let mut one_sided = column(0, &good);
    one_sided[2].reverse[0] = -0.95;
    let found = table(&x, &one_sided[..]).unwrap_err();
    assert_eq!((found.rule, found.reverse, found.row), (TableRule::Slope, true, 1));
    assert!((found.found - 1.05).abs() < 1e-12);
}

#[test]
fn the_joint_has_room_for_the_correction() {
    let mut machine = machine_of("w b X Y t");
    machine.axes[0].travel = [0.0, 100.0];
    machine.axes[1].travel = [0.0, 50.0];
    machine.axes[1].joint = [-1.0, 51.0];
    machine.location.c0y = 100e-6;
    // At X 100 the error is −20 µm, and Y adds −C0Y·50 mm = −5 µm: the correction reaches +25 µm there, and +10 to +15 at
    // 0.
    let x = column(0, &[(0.0, -0.010), (100.0, -0.020)]);
    let tables = |axis| (axis == Axis::X).then_some(&x[..]);
    for (joint, good) in [
        ([0.0, 100.02501], true),
        ([0.0, 100.02499], false),
        // The corrected position never falls below 0.010.
        ([0.0099, 100.03], true),
        ([0.0101, 100.03], false),
    ] {
        machine.axes[0].joint = joint;
        assert_eq!(joint_range(&machine, tables, &GridBounds::NONE).is_ok(), good, "{joint:?}");
    }
    // The magnitude limit cuts the correction.
    machine.axes[0].joint = [-1.0, 100.02001];
    machine.axes[0].limits.magnitude = 0.02;
    assert!(joint_range(&machine, tables, &GridBounds::NONE).is_ok());
}

#[test]
fn defaults_of_any_chain_are_sound() {
    for chain in ["w X' b Y Z t", "w C' A' X' b Y Z t", "w b X Y Z C B t", "wX'bt"] {
        assert_eq!(settings(&machine_of(chain)), Ok(()));
    }
    // No table is needed: errors that are not stated are zero.
    let machine = machine_of("w b X Y t");
    assert!(super::machine(&machine, |_| None::<&[Row]>, &[]).is_ok());
}

/// The step's own evaluation at random positions never leaves the range checked at build, and covers most of it.
#[test]
fn the_range_of_the_error_holds_what_the_step_computes() {
    use crate::compensation::{Compensation, Direction, ThermalLine, requirement};
    for (chain, tightest) in [("w X' b Y Z t", 0.9), ("w C' A' X' b Y Z t", 0.5)] {
        let mut machine = machine_of(chain);
        machine.location = LocationErrors { a0z: 30e-6, b0z: -20e-6, c0y: 50e-6, ..Default::default() };
        machine.location.rotary[2] = [0.01, -0.02, 0.005, 0.0, 0.0, 0.0];
        let mut tables = Vec::new();
        for (number, axis) in machine.axes.iter_mut().enumerate() {
            axis.interpolation = if number % 2 == 0 { Interpolation::Cubic } else { Interpolation::Linear };
            axis.travel = [-100.0, 150.0];
            axis.backlash = 0.002;
            let row = |i: i32| {
                let error = |k: i32| 0.01 * libm::sin(f64::from(i * (k + 2) + k * 7 + number as i32));
                let forward = core::array::from_fn(|k| error(k as i32) * if k < 3 { 1.0 } else { 1e-3 });
                Row { position: -120.0 + 10.0 * f64::from(i), forward, reverse: forward.map(|e| 1.1 * e) }
            };
            let rows: &'static [Row] = (0..26).map(row).collect::<Vec<_>>().leak();
            tables.push((axis.axis, rows));
        }
        let find = |axis| tables.iter().find(|(a, _)| *a == axis).map(|(_, rows)| *rows);
        fn widest<const N: usize>(
            machine: &MachineSettings,
            find: impl Fn(Axis) -> Option<&'static [Row]>,
        ) -> Vec<f64> {
            let memory = vec![0.0; requirement(machine, &find)].leak();
            let compensation = Compensation::<f64, f64, N>::build(machine, &find, &[], 1, memory).unwrap();
            let mut noise = Noise::new(1);
            let mut share = vec![0.0_f64; N];
            let ranges: Vec<_> = machine
                .axes
                .iter()
                .map(|drive| error_range(machine, &find, &GridBounds::NONE, drive, drive.travel))
                .collect();
            for _ in 0..200_000 {
                let q: [f64; N] = core::array::from_fn(|_| -100.0 + 250.0 * noise.unit());
                let reverse =
                    core::array::from_fn(
                        |_| if noise.unit() < 0.5 { Direction::POSITIVE } else { Direction::NEGATIVE },
                    );
                let at = compensation.coordinates(&q);
                let error = compensation.errors(&Query::at(&at, &reverse, &[ThermalLine::default(); N]), &mut 0);
                for ((share, error), &(least, most)) in share.iter_mut().zip(error).zip(&ranges) {
                    assert!(error >= least - 1e-12 && error <= most + 1e-12, "{error} {least} {most}");
                    *share = share.max(error / most).max(error / least);
                }
            }
            share
        }
        let share = if machine.axes.len() == 3 { widest::<3>(&machine, find) } else { widest::<5>(&machine, find) };
        assert!(share.iter().all(|share| *share > tightest), "{chain}: {share:?}");
    }
}

/// Forward zero, reverse these six errors, over 0 … 100.
fn lost(reverse: [f64; 6]) -> Vec<Row> {
    [0.0, 50.0, 100.0].map(|position| Row { position, forward: [0.0; 6], reverse }).to_vec()
}

#[test]
fn lost_motion_between_the_lines_of_a_cubic_table_counts() {
    let mut machine = machine_of("w b X Y Z t");
    machine.axes[0].interpolation = Interpolation::Cubic;
    // Equal at the lines; between them the two directions differ.
    let values = [(0.0, 0.0), (0.01, 0.0), (0.0, 0.0), (0.02, 0.02), (0.0, 0.0)];
    let rows: Vec<Row> = (0..)
        .zip(values)
        .map(|(i, (there, back))| Row {
            position: 10.0 * f64::from(i),
            forward: [there, 0.0, 0.0, 0.0, 0.0, 0.0],
            reverse: [back, 0.0, 0.0, 0.0, 0.0, 0.0],
        })
        .collect();
    let [least, most] = lost_motion(&machine.axes[0], Some(rows.as_slice()));
    let [there, back] = [false, true].map(|reverse| Curve::new(&machine.axes[0], rows.as_slice(), 0, reverse));
    let sampled: Vec<f64> =
        (0..=40_000).map(|i| f64::from(i) * 1e-3).map(|q| back.at(q).unwrap() - there.at(q).unwrap()).collect();
    let ends = sampled.iter().fold((0.0_f64, 0.0_f64), |(least, most), v| (least.min(*v), most.max(*v)));
    assert!((least - ends.0).abs() < 1e-9 && (most - ends.1).abs() < 1e-9, "{least} {most} {ends:?}");
    assert_eq!(lost_motion::<[Row]>(&machine.axes[0], None), [0.0; 2]);
}

/// Tables of X, Y and Z, with errors in negative travel in µm; the band is 0.3 µm.
fn refused(steps: [[f64; 3]; 3]) -> Option<ConfigError> {
    let machine = machine_of("w b X Y Z t");
    let tables = steps.map(|[x, y, z]| lost([x * 1e-3, y * 1e-3, z * 1e-3, 0.0, 0.0, 0.0]));
    let error = reversal(&machine, |axis| Some(tables[axis.index()].as_slice()), &GridBounds::NONE).err();
    error.inspect(|error| assert_eq!((error.field, error.found), (Field::Hysteresis, 0.3e-3)))
}

#[test]
fn a_reversal_that_takes_itself_back_is_refused() {
    let none = [0.0; 3];
    // Positive lost motion of any size; negative within the band; beyond it.
    assert_eq!(refused([[50.0, 0.0, 0.0], none, [0.0, 0.0, 7.0]]), None);
    assert_eq!(refused([[-0.29, 0.0, 0.0], none, none]), None);
    let error = refused([none, [0.0, -0.31, 0.0], none]).unwrap();
    assert!(error.axis == Some(Axis::Y) && (error.bound.unwrap() - 0.31e-3).abs() < 1e-9, "{error}");
    // X reverses Y, and Y nothing: harmless. If Y reverses X in turn, only a step against the first is refused.
    assert_eq!(refused([[0.0, 2.0, 0.0], none, none]), None);
    assert_eq!(refused([[0.0, 2.0, 0.0], [2.0, 0.0, 0.0], none]), None);
    assert_eq!(refused([[0.0, -2.0, 0.0], [-2.0, 0.0, 0.0], none]), None);
    assert_eq!(refused([[0.0, 2.0, 0.0], [-0.2, 0.0, 0.0], none]), None);
    assert!(refused([[0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], none]).is_some());
    // Through a third axis; and the steps of two axes add.
    assert!(refused([[0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [-2.0, 0.0, 0.0]]).is_some());
    assert_eq!(refused([[0.0, 2.0, 0.0], [0.0, 0.0, -2.0], [-2.0, 0.0, 0.0]]), None);
    assert!(refused([[0.0, 2.0, 0.0], [-0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]]).is_some());
}

#[test]
fn the_hysteresis_spans_the_steps_of_the_encoder() {
    let mut machine = machine_of("w b X Y Z t");
    machine.axes[1].encoder_resolution = Some(0.1e-3);
    machine.axes[2].encoder_resolution = Some(0.2e-3);
    let (own, none) = (lost([0.0, 1e-3, 1e-3, 0.0, 0.0, 0.0]), lost([0.0; 6]));
    let of = |y: &'static [Row], z: &'static [Row]| {
        move |axis| match axis {
            Axis::Y => Some(y),
            Axis::Z => Some(z),
            _ => None,
        }
    };
    let (own, none): (&'static [Row], &'static [Row]) = (own.leak(), none.leak());
    // Three steps are just enough, and the direction of Z does not matter.
    assert_eq!(reversal(&machine, of(own, none), &GridBounds::NONE), Ok(()));
    let error = reversal(&machine, of(own, own), &GridBounds::NONE).unwrap_err();
    assert_eq!((error.field, error.axis, error.found), (Field::Hysteresis, Some(Axis::Z), 0.3e-3));
    assert!((error.bound.unwrap() - 0.6e-3).abs() < 1e-15);
    machine.axes[2].hysteresis = 0.6e-3;
    assert_eq!(reversal(&machine, of(own, own), &GridBounds::NONE), Ok(()));
    machine.axes[2].encoder_resolution = Some(0.0);
    assert_eq!(settings(&machine).unwrap_err().field, Field::EncoderResolution);
}

#[test]
fn angular_errors_step_the_tip_by_their_lever() {
    let mut machine = machine_of("w b X Y Z t");
    machine.axes[0].travel = [0.0, 100.0];
    machine.axes[2].offset_mm = [0.0, 0.0, 400.0];
    // 2 µrad about Y on a lever of 400 mm move the tip by 0.8 µm along X, in either direction.
    let x = lost([0.0, 0.0, 0.0, 0.0, 2e-6, 0.0]);
    let tables = |axis| (axis == Axis::X).then_some(x.as_slice());
    assert_eq!(reversal(&machine, tables, &GridBounds::NONE), Ok(()));
    machine.compensation.model = ErrorModel::Volumetric;
    let error = reversal(&machine, tables, &GridBounds::NONE).unwrap_err();
    assert!(error.axis == Some(Axis::X) && (error.bound.unwrap() - 0.8e-3).abs() < 1e-8, "{error}");
    // Lost motion of 1 µm outweighs it.
    machine.axes[0].backlash = 1e-3;
    assert_eq!(reversal(&machine, tables, &GridBounds::NONE), Ok(()));
}

/// A rotary axis that turns against its convention has its own error in the opposite sense, and its lost motion in its
/// own sense.
#[test]
fn lost_motion_of_a_rotary_axis_counts_in_its_own_sense() {
    let mut machine = machine_of("w C' b X Y Z t");
    let c = lost([0.0, 0.0, 0.0, 0.0, 0.0, 20e-6]);
    let tables = |axis| (axis == Axis::C).then_some(c.as_slice());
    assert_eq!(reversal(&machine, tables, &GridBounds::NONE), Ok(()));
    machine.axes[3].direction = 1;
    let error = reversal(&machine, tables, &GridBounds::NONE).unwrap_err();
    assert!(error.axis == Some(Axis::C) && (error.bound.unwrap() - 20e-6_f64.to_degrees()).abs() < 1e-8, "{error}");
    machine.axes[3].backlash = 20e-6_f64.to_degrees();
    assert_eq!(reversal(&machine, tables, &GridBounds::NONE), Ok(()));
}

/// With the direction corrected, lost motion in only the own rotation of an axis turns that axis only; additional
/// rotations may turn the other axes, by large angles near the singular pose.
#[test]
fn lost_motion_of_a_rotary_axis_turns_no_other() {
    let mut machine = machine_of("w C' b X Y Z A t");
    machine.compensation = CompensationSettings { model: ErrorModel::Volumetric, orientation: true, fade_deg: 5.0 };
    let (a, c) = (lost([0.0, 0.0, 0.0, 30e-6, 0.0, 0.0]), lost([0.0, 0.0, 0.0, 0.0, 0.0, 30e-6]));
    let of = |a: &'static [Row], c: &'static [Row]| {
        move |axis| match axis {
            Axis::A => Some(a),
            Axis::C => Some(c),
            _ => None,
        }
    };
    assert_eq!(reversal(&machine, of(a.leak(), c.leak()), &GridBounds::NONE), Ok(()));
    let a_with_c = lost([0.0, 0.0, 0.0, 30e-6, 0.0, 2e-6]);
    let c_with_a = lost([0.0, 0.0, 0.0, 2e-6, 0.0, 30e-6]);
    assert_eq!(
        reversal(&machine, of(a_with_c.leak(), c_with_a.leak()), &GridBounds::NONE).unwrap_err().field,
        Field::Hysteresis
    );
}

#[test]
fn periods_are_refused_where_they_have_no_meaning() {
    let refused = |chain: &str, model, axis, periods: &[f64]| {
        let machine = Machine::new(chain).with(|machine| {
            machine.compensation.model = model;
            for period in periods {
                let harmonics = [[1e-3, 0.0]].into_iter().collect();
                let period = PeriodicSettings { axis, period: *period, harmonics, reverse: Default::default() };
                machine.periodic.push(period).unwrap();
            }
        });
        settings(&machine.settings()).err().map(|error| (error.field, error.index, error.needed))
    };
    let (nine, volumetric) = (ErrorModel::Nine, ErrorModel::Volumetric);
    assert_eq!(refused("w b X Y Z t", nine, Axis::X, &[5.0, 0.25]), None);
    assert_eq!(refused("w C' A' b X Y Z t", nine, Axis::C, &[4.0]), None);
    for (chain, model, axis, periods, index, needed) in [
        ("w b X Y t", nine, Axis::Z, &[5.0][..], Some(0), "an axis of the machine"),
        ("w C' A' b X Y Z t", nine, Axis::C, &[7.0], Some(0), "a whole number of periods in 360 degrees"),
        ("w C' A' b X Y Z t", volumetric, Axis::C, &[4.0], Some(0), "the model \"nine\" for a period of a rotary axis"),
        ("w b C X Y Z t", nine, Axis::X, &[5.0], Some(0), "a linear axis that no rotary axis carries"),
        ("w b X Y Z t", nine, Axis::X, &[5.0, 5.0], Some(1), "another period than the axis has already"),
        ("w b X Y Z t", nine, Axis::X, &[1.0, 0.001], Some(1), "0.01 to 10000 mm"),
    ] {
        assert_eq!(
            refused(chain, model, axis, periods),
            Some((Field::PeriodLength, index, needed)),
            "{chain} {periods:?}"
        );
    }
}

#[test]
fn the_slope_of_a_period_counts_in_the_contraction() {
    let with = |amplitude: f64, model| {
        let harmonics = [[0.0, amplitude]].into_iter().collect();
        let period = PeriodicSettings { axis: Axis::X, period: 5.0, harmonics, reverse: Default::default() };
        let machine = Machine::three_axis().with(|machine| {
            machine.compensation.model = model;
            machine.periodic.push(period).unwrap();
        });
        super::machine(&machine.settings(), |_| None::<&[Row]>, &[])
    };
    for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
        // 0.0038 and 0.126 take no look-up beyond those of thermal growth; 1.13 is no contraction.
        assert_eq!((with(0.003, model), with(0.1, model)), (Ok(2), Ok(2)), "{model:?}");
        assert_eq!(with(0.9, model).unwrap_err().field, Field::Inverse, "{model:?}");
    }
}

#[test]
fn directions_that_differ_within_a_period_need_a_wide_hysteresis() {
    let with = |hysteresis: f64| {
        let machine = Machine::three_axis().hysteresis(hysteresis).with(|machine| {
            let [harmonics, reverse] = [[[0.0, 1e-3]], [[0.0, 0.4e-3]]].map(|pairs| pairs.into_iter().collect());
            machine.periodic.push(PeriodicSettings { axis: Axis::X, period: 5.0, harmonics, reverse }).unwrap();
        });
        super::machine(&machine.settings(), |_| None::<&[Row]>, &[]).err().map(|error| (error.field, error.axis))
    };
    // The correction may step back by 0.6 um at a reversal.
    assert_eq!(with(0.5e-3), Some((Field::Hysteresis, Some(Axis::X))));
    assert_eq!(with(0.7e-3), None);
}
