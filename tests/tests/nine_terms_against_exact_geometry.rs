//! The nine-term form compared with the plant's exact transforms: two implementations that share only the file reader.

use std::path::Path;
use trueaxis::Axis;
use trueaxis::compensation::Query;
use trueaxis::compensation::{Compensation, Direction, ThermalLine, requirement};
use trueaxis::machine::AxisOrder;
use trueaxis::machine::{AXES, ErrorModel};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_testing::noise::Noise;

/// Largest difference, mm. Both interpolate in doubles; squareness and translations are exact in both forms.
const TOLERANCE_MM: f64 = 1e-12;

/// A sample machine without its angular errors: the nine terms represent the rest exactly.
fn without_angles(name: &str) -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables").join(name);
    let mut machine = Machine::read(&path).unwrap();
    for table in machine.tables.iter_mut().flatten() {
        for row in &mut table.rows {
            for k in 3..6 {
                (row.forward[k], row.reverse[k]) = (0.0, 0.0);
            }
        }
    }
    for errors in &mut machine.settings.location.rotary {
        errors[3..].fill(0.0);
    }
    machine
}

fn compare<const N: usize>(name: &str, model: ErrorModel) {
    let mut machine = without_angles(name);
    machine.settings.compensation.model = model;
    for axis in &mut machine.settings.axes {
        // Lost motion of a rotary axis has a lever, which the nine terms lack.
        axis.backlash = if axis.axis.is_rotary() { 0.0 } else { axis.backlash };
    }
    let geometry = Geometry::new(&machine, 0.0).unwrap();
    let rows = |axis: Axis| machine.rows(axis);
    let mut memory = vec![0.0; requirement(&machine.settings, rows)];
    let compensation =
        Compensation::<f64, f64, N>::build(&machine.settings, rows, &machine.grids(), 2, &mut memory).unwrap();
    let axes = AxisOrder::<N>::of(&machine.settings).unwrap().axes();

    let mut random = Noise::new(17);
    let mut largest = 0.0_f64;
    for _ in 0..20_000 {
        let (mut step, mut plant, mut reversed) = ([0.0; N], [0.0; AXES], [0.0; AXES]);
        let mut directions = [Direction::POSITIVE; N];
        for (i, settings) in machine.settings.axes.iter().enumerate() {
            let place = axes.iter().position(|a| *a == settings.axis).unwrap();
            let [low, high] = if settings.axis.is_rotary() { [-700.0, 700.0] } else { settings.travel };
            let [low, high] = [low.max(settings.travel[0]), high.min(settings.travel[1])];
            let q = low + (high - low) * random.unit();
            (step[place], plant[i]) = (q, q);
            // Backlash belongs to the drive in the plant and to the table in the plugin, so both sides leave it out.
            if settings.backlash == 0.0 && random.unit() < 0.5 {
                (directions[place], reversed[i]) = (Direction::NEGATIVE, 1.0);
            }
        }
        let exact = geometry.tip_error(&plant, &reversed);
        let at = compensation.coordinates(&step);
        let nine = compensation.errors(&Query::at(&at, &directions, &[ThermalLine::default(); N]), &mut 0);
        for k in 0..3 {
            let difference = (exact[k] - nine[k]).abs();
            assert!(difference < TOLERANCE_MM, "{name} at {step:?}: {exact:?}, {nine:?}");
            largest = largest.max(nine[k].abs());
        }
    }
    assert!(largest > 5e-3, "there was something to compare: {largest} mm");
}

#[test]
fn three_axes() {
    compare::<3>("mill-3axis", ErrorModel::Nine);
}

#[test]
fn five_axes_at_any_rotary_pose() {
    compare::<5>("mill-5axis", ErrorModel::Nine);
}

#[test]
fn without_angular_errors_the_volumetric_form_says_the_same() {
    compare::<3>("mill-3axis", ErrorModel::Volumetric);
    compare::<5>("mill-5axis", ErrorModel::Volumetric);
}
