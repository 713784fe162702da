//! Errors of an axis that only the settings state, compared with the same settings plus a table of zeros.

use super::*;
use crate::machine::ErrorModel;

fn build<R: Real, P: Position, const N: usize>(
    machine: &MachineSettings,
    tables: &[(Axis, Vec<Row>)],
) -> Compensation<'static, R, P, N> {
    let find = |axis| tables.iter().find(|(a, _)| *a == axis).map(|(_, rows)| &rows[..]);
    let memory = lent(requirement(machine, find));
    Compensation::build(machine, find, &[], 4, memory).unwrap()
}

/// Lost motion, squareness and any location errors of rotary axes; only X may have a table.
fn machine(chain: &str, model: ErrorModel, cubic: bool) -> MachineSettings {
    let mut noise = Noise::new(61);
    let machine = Machine::new(chain).travel([-180.0, 180.0], 1.0).each(|axis| {
        axis.backlash = if axis.axis.is_rotary() { 1e-3 } else { noise.range(0.005, 0.03) };
        axis.interpolation = if cubic { Interpolation::Cubic } else { Interpolation::Linear };
    });
    let location = LocationErrors { a0z: 31e-6, b0z: -17e-6, c0y: 43e-6, ..LocationErrors::default() };
    machine.with(|machine| (machine.location, machine.compensation.model) = (location, model)).settings()
}

fn agrees<R: Real, P: Position, const N: usize>(chain: &str, model: ErrorModel, with_x: bool) {
    let mut noise = Noise::new(62);
    let machine = machine(chain, model, with_x);
    let x: Vec<(Axis, Vec<Row>)> = if with_x {
        let positions = (0..=36).map(|i| -180.0 + 10.0 * f64::from(i));
        vec![(Axis::X, machine::rows(positions, |q| [1e-4 * q, 0.01, 0.0, 0.0, 1e-5, 0.0]))]
    } else {
        Vec::new()
    };
    let beyond = |[low, high]: [f64; 2]| [low - 10.0, high + 10.0];
    let ends = |axis: &AxisSettings| if axis.axis.is_rotary() { [0.0, 360.0] } else { beyond(axis.travel) };
    let zeros = |axis: &AxisSettings| (axis.axis, machine::rows(ends(axis), |_| [0.0; 6]));
    let others = machine.axes.iter().filter(|axis| !with_x || axis.axis != Axis::X);
    let all: Vec<_> = x.iter().cloned().chain(others.map(zeros)).collect();
    let (without, with) = (build::<R, P, N>(&machine, &x), build::<R, P, N>(&machine, &all));
    let thermal = [ThermalLine::default(); N];
    for _ in 0..share(2000) {
        let at: [P; N] = core::array::from_fn(|_| P::of(noise.range(-170.0, 170.0)));
        let directions: [Direction; N] =
            core::array::from_fn(|_| [Direction::POSITIVE, Direction::NEGATIVE][noise.below(2)]);
        let found = [&without, &with].map(|compensation| {
            let at = compensation.coordinates(&at);
            let query = Query::at(&at, &directions, &thermal);
            let mut clamped = 0;
            let (errors, correction) =
                (compensation.errors(&query, &mut clamped), compensation.correction(&query, &mut clamped));
            (errors.map(|e| e.to_f64().to_bits()), correction.map(|c| c.to_f64().to_bits()), clamped)
        });
        assert_eq!(found[0], found[1], "{chain} {model:?}");
        assert_eq!(found[0].2, 0);
        if N == 3 && !with_x {
            // Backlash of each axis in negative travel, and the tilts: to the rounding of the scalar.
            let q = at.map(|q| q.to_f64());
            let of =
                |slot: usize| if directions[slot] == Direction::NEGATIVE { machine.axes[slot].backlash } else { 0.0 };
            let location = &machine.location;
            let truth = [of(0) - location.c0y * q[1] + location.b0z * q[2], of(1) - location.a0z * q[2], of(2)];
            for (error, truth) in found[0].0.iter().zip(truth) {
                assert!((f64::from_bits(*error) - truth).abs() < 4e-8, "{} {truth}", f64::from_bits(*error));
            }
        }
    }
}

fn agrees_for<R: Real, P: Position>() {
    for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
        for with_x in [false, true] {
            agrees::<R, P, 3>("w b X Y Z t", model, with_x);
            agrees::<R, P, 3>("w X' Y' b Z t", model, with_x);
            agrees::<R, P, 5>("w C' A' b X Y Z t", model, with_x);
        }
    }
}

#[test]
fn lost_motion_needs_no_table() {
    agrees_for::<f64, f64>();
    agrees_for::<f32, Nanometres>();
}

/// A correction moves the lookup beyond the end of the travel, but the axis has no table with an edge.
#[test]
fn an_axis_without_a_table_is_at_no_edge() {
    let machine = Machine::new("w C' b X Y Z t").travel([-30.0, 40.0], 1.0).each(|axis| axis.backlash = 0.02);
    let compensation = build::<f64, f64, 4>(&machine.settings(), &[]);
    for q in [-30.01, 40.01] {
        let at = compensation.coordinates(&[q; 4]);
        let mut clamped = 0;
        compensation.errors(&Query::at(&at, &[Direction::NEGATIVE; 4], &[ThermalLine::default(); 4]), &mut clamped);
        assert_eq!(clamped, 0, "{q}");
    }
}

/// Without a declared travel no position of a rotary axis counts as beyond a table, and the value is right everywhere.
#[test]
fn lost_motion_needs_no_declared_travel() {
    let machine = Machine::new("w C' b X Y Z t").each(|axis| axis.backlash = 0.02).settings();
    let compensation = build::<f64, f64, 4>(&machine, &[]);
    for q in [-1e5, -999.0, 0.0, 720.5, 1e5] {
        let at = compensation.coordinates(&[q; 4]);
        let mut clamped = 0;
        let errors =
            compensation.errors(&Query::at(&at, &[Direction::NEGATIVE; 4], &[ThermalLine::default(); 4]), &mut clamped);
        for error in errors {
            assert!((error.abs() - 0.02).abs() < 1e-12, "{errors:?}");
        }
        assert_eq!(clamped & 8, 0);
    }
}
