//! The identified machine as loaded by a controller, and the true tip error with its correction.

use super::cycle::{AxisCycle, with_ball};
use crate::error::Result;
use trueaxis::Axis;
use trueaxis::compensation::Query;
use trueaxis::compensation::{Compensation, Direction, ThermalLine, requirement};
use trueaxis::machine::AxisOrder;
use trueaxis::machine::{AXES, ErrorModel, LocationErrors, Row, Twist};
use trueaxis::tcomp::Tcomp;
use trueaxis_metrology::identification::{Ball, Identified};
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::{Machine, Table, compile};

/// Table of an axis from its stops; the table of a full circle is closed with its first line.
///
/// Each cycle sees both axes: C's sees the constant errors of A at 0, turned with C, and A's those of C at 0. The errors that
/// both see at the shared pose, `at_zero`, become part of A: A's table is the reading, C's the reading minus `at_zero` turned
/// by C. Together they reproduce either cycle.
pub(super) fn table(stops_deg: &[f64], found: &Identified, at_zero: &Twist) -> Table {
    let mut rows: Vec<Row> = (stops_deg.iter().zip(&found.angles))
        .map(|(&position, angle)| {
            let read = if angle.angle_rad == 0.0 { *at_zero } else { angle.errors };
            let errors = if found.axis == Axis::C { less(read, turned(*at_zero, angle.angle_rad)) } else { read };
            Row { position, forward: errors, reverse: errors }
        })
        .collect();
    if found.axis == Axis::C
        && let Some(first) = rows.first().copied()
    {
        rows.push(Row { position: first.position + 360.0, ..first });
    }
    Table { given: [true; 6], bidirectional: false, rows }
}

fn less(from: Twist, what: Twist) -> Twist {
    std::array::from_fn(|i| from[i] - what[i])
}

/// A twist turned about Z.
fn turned([x, y, z, a, b, c]: Twist, angle_rad: f64) -> Twist {
    let (sin, cos) = libm::sincos(angle_rad);
    [x * cos - y * sin, x * sin + y * cos, z, a * cos - b * sin, a * sin + b * cos, c]
}

/// The machine as known after the test: identified tables, nothing else.
pub(super) fn identified(machine: &Machine, tables: &[(Axis, Table)]) -> Machine {
    let mut machine = machine.clone();
    machine.settings.location = LocationErrors::default();
    machine.settings.periodic.clear();
    machine.settings.compensation.model = ErrorModel::Volumetric;
    for (settings, slot) in machine.settings.axes.iter().zip(&mut machine.tables) {
        *slot = tables.iter().find(|(axis, _)| *axis == settings.axis).map(|(_, table)| table.clone());
    }
    machine
}

/// True tip error of one set-up at the judged angles, mm: without and with the correction by the tables of `known`.
pub(super) fn tip_errors(
    cycle: &AxisCycle,
    plant: &Machine,
    known: &Machine,
    ball: Ball,
) -> Result<Vec<[[f64; 3]; 2]>> {
    let geometry = Geometry::new(&with_ball(plant, ball), 0.0)?;
    let bytes = compile(&with_ball(known, ball))?;
    let tcomp = Tcomp::parse(&bytes)?;
    let rows = tcomp.rows();
    let mut memory = vec![0.0; requirement(tcomp.settings(), rows)];
    let compensation: Compensation<'_, f64, f64, AXES> =
        Compensation::build(tcomp.settings(), rows, tcomp.grids(), tcomp.inverse_passes(), &mut memory)?;
    let axes = AxisOrder::<AXES>::with_spare_slots(tcomp.settings())?.axes();
    let slots = axes.map(|axis| super::place(plant, axis));

    let mut errors = Vec::with_capacity(cycle.judged_deg.len());
    for &angle_deg in &cycle.judged_deg {
        let position = cycle.position(plant, ball, angle_deg)?;
        let command: [f64; AXES] = slots.map(|slot| slot.map_or(0.0, |slot| position[slot]));
        let at = compensation.coordinates(&command);
        let thermal = [ThermalLine::default(); AXES];
        let correction = compensation.correction(&Query::at(&at, &[Direction::POSITIVE; AXES], &thermal), &mut 0);
        let mut sent: [f64; AXES] = position;
        for (slot, correction) in slots.into_iter().zip(correction) {
            if let Some(slot) = slot {
                sent[slot] += correction;
            }
        }
        let ideal = geometry.ideal_pose(&position).tip_mm;
        let actual = geometry.actual_pose(&sent, &[0.0; AXES]).tip_mm;
        let left = std::array::from_fn(|i| actual[i] - ideal[i]);
        errors.push([geometry.tip_error(&position, &[0.0; AXES]), left]);
    }
    Ok(errors)
}
