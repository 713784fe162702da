//! The sheet of a dial indicator: a CSV with a row for every reading, into which the operator types it.

use super::dial::{Dial, Reading};
use super::log::{Logged, identity_of};
use super::plan::{Plan, Planned};
use super::reach::beyond;
use super::task::Task;
use crate::rows::{Column, Rows};
use anyhow::Result;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;
use trueaxis_tables::error::FileError;
use trueaxis_tables::text::one_line;

const COLUMNS: [Column; 7] = [
    Column { name: "id", needed: true },
    Column { name: "x_mm", needed: false },
    Column { name: "y_mm", needed: false },
    Column { name: "z_mm", needed: false },
    Column { name: "spindle_deg", needed: false },
    Column { name: "reading_um", needed: false },
    Column { name: "reading_mm", needed: false },
];

/// Largest distance of a stated position from the planned one, mm or degrees; the axis that the dial reads may be anywhere.
const OFF: f64 = 0.5;
/// Longest remark, characters.
const LONGEST: usize = 300;
/// Largest reading, mm: the travel of a dial.
const TRAVEL_MM: f64 = 30.0;

/// The reading of a planned touch.
pub(crate) fn reading<'t>(task: &'t Task, touch: &Planned) -> Option<(&'t Dial, &'t Reading)> {
    let dial = task.artefacts.get(touch.artefact)?.dial()?;
    Some((dial, dial.readings.get(touch.feature)?))
}

/// The sheet of a plan, with readings in µm where they are given.
pub(crate) fn sheet(task: &Task, plan: &Plan, readings_um: Option<&[f64]>) -> String {
    let mut text = format!("# trueaxis calibrate {} readings {}\n", plan.number(), plan.touches.len());
    text.push_str(
        "# A reading increases as the plunger is pushed in. Every position is reached in positive travel. The axis that the\n\
         # dial reads stays where the dial touches for all readings of a line: type its position if it is another one.\n",
    );
    let all =
        || plan.touches.iter().enumerate().filter_map(|(index, touch)| reading(task, touch).map(|of| (index, of)));
    let mut last = String::new();
    for (touch, (dial, reading)) in all() {
        let name = &task.artefacts[plan.touches[touch].artefact].name;
        let what = one_line(&dial.text(name, reading), LONGEST);
        if what != last {
            let _ = writeln!(text, "# from {} on: {what}", touch + 1);
        }
        last = what;
    }
    text.push_str("id,x_mm,y_mm,z_mm,spindle_deg,reading_um\n");
    for (touch, (_, reading)) in all() {
        let [x, y, z] = reading.at_mm.map(|q| (q * 1e4).round() / 1e4);
        let typed = readings_um.and_then(|all| all.get(touch)).map_or(String::new(), |um| format!("{um:.2}"));
        let _ = writeln!(text, "{},{x},{y},{z},{},{typed}", touch + 1, reading.spindle_deg);
    }
    text
}

/// Reads a filled sheet and its name for errors: every reading as the position of a touch.
///
/// # Errors
/// With line and column: readings without a unit, missing or duplicate ones, positions of another plan.
pub(super) fn read_sheet(
    task: &Task,
    machine: &Machine,
    plan: &Plan,
    (text, file): (&str, &Path),
    note: impl FnMut(String),
) -> Result<Vec<Logged>> {
    for (line, text) in (1..).zip(text.lines()).take_while(|(_, text)| text.starts_with('#')) {
        if let Some(other) = identity_of(text).filter(|number| *number != plan.identity) {
            let found = format!("the sheet of plan {other:08x}");
            let needed = format!("that of {}, which {} plans", plan.number(), task.file.display());
            return Err(FileError { file: file.into(), line: Some(line), column: None, found, needed }.into());
        }
    }
    let head = (1..).zip(text.lines()).find(|(_, line)| !line.starts_with('#')).map_or(1, |(line, _)| line);
    let mut rows = Rows::new(text.as_bytes(), file, &COLUMNS, note)?.with_gaps();
    let unit_mm = match [rows.present[5], rows.present[6]] {
        [true, false] => 1e-3,
        [false, true] => 1.0,
        _ => {
            let found = rows.header.join(", ");
            let needed = "one of the columns reading_um and reading_mm".to_owned();
            let found = format!("columns {found}");
            return Err(FileError { file: file.into(), line: Some(head), column: None, found, needed }.into());
        }
    };
    let count = plan.touches.len();
    let mut typed: BTreeMap<usize, Logged> = BTreeMap::new();
    while let Some(row) = rows.next()? {
        let [id, x, y, z, spindle_deg, um, mm] = row.values;
        let touch = if id.fract() == 0.0 && id >= 1.0 { id as usize - 1 } else { usize::MAX };
        let Some((dial, reading)) = plan.touches.get(touch).and_then(|touch| reading(task, touch)) else {
            return Err(rows.error(row.line, "id", id, format!("1 to {count}, as {} plans", task.file.display())));
        };
        let planned = [reading.at_mm[0], reading.at_mm[1], reading.at_mm[2], reading.spindle_deg];
        for (slot, (stated, planned)) in [x, y, z, spindle_deg].into_iter().zip(planned).enumerate() {
            if rows.present[slot + 1] && slot != reading.reads && (stated - planned).abs() > OFF {
                return Err(rows.error(row.line, COLUMNS[slot + 1].name, stated, format!("{planned}, as planned")));
            }
        }
        let mut position = super::dial::pose(reading);
        for (slot, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            let stated = [x, y, z][slot];
            if rows.present[slot + 1] && !stated.is_nan() {
                position[slot] = stated;
                let own = machine.settings.axis(axis);
                if let Some((found, needed)) = own.and_then(|own| beyond(own, stated)) {
                    return Err(rows.error(row.line, COLUMNS[slot + 1].name, found, needed));
                }
            }
        }
        let (column, value) = if rows.present[5] { (COLUMNS[5].name, um) } else { (COLUMNS[6].name, mm) };
        let value = unit_mm * value;
        if value.is_nan() {
            return Err(rows.error(row.line, column, "an empty cell", format!("reading {id}")));
        }
        if value.abs() > TRAVEL_MM {
            return Err(rows.error(row.line, column, format!("{value} mm"), format!("at most {TRAVEL_MM} mm")));
        }
        let way = dial.displacement(reading);
        (0..3).for_each(|k| position[k] += value * way[k]);
        let logged = Logged { line: row.line, position, rotary: [true; 3] };
        if let Some(first) = typed.insert(touch, logged) {
            let found = format!("{id} for the second time, the first in line {}", first.line);
            return Err(rows.error(row.line, "id", found, "every reading once"));
        }
    }
    let mut before = head;
    let mut all = Vec::with_capacity(count);
    for touch in 0..count {
        let Some(logged) = typed.remove(&touch) else {
            let found = format!("no reading {}", touch + 1);
            let needed = format!("all {count} readings, reading {} after this line", touch + 1);
            return Err(FileError { file: file.into(), line: Some(before), column: None, found, needed }.into());
        };
        before = logged.line;
        all.push(logged);
    }
    Ok(all)
}
