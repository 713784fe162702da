//! Commanded positions: `trueaxis compensate`, and `trueaxis correct` at each of them.

use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal, small};
use anyhow::Result;
use std::convert::Infallible;
use std::path::Path;
use trueaxis::Axis;
use trueaxis::compensation::{Compensation, Direction, Query, ThermalLine, requirement};
use trueaxis::machine::{AXES, AxisOrder, ErrorModel};
use trueaxis_evaluation::correct::{self, Asked};
use trueaxis_evaluation::positions::{COLUMNS, Travel, next};
use trueaxis_evaluation::rows::Rows;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{CorrectionSettings, Geometry};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "positions",
    about: "positions (CSV), evaluated by the step's model and by exact geometry, and asked one by one",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: SLOWEST,
};

const FILE: &str = "positions.csv";
/// Longer inputs reach nothing new.
const MOST_ROWS: usize = 64;

/// A machine with its model built.
struct Model {
    machine: Machine,
    axes: [Axis; 5],
    compensation: Compensation<'static, f64, f64, 5>,
    geometry: Geometry,
}

fn model() -> Model {
    let mut machine = small::machine("w C' A' X' Y' b Z t");
    machine.settings.compensation.model = ErrorModel::Volumetric;
    let rows = |axis: Axis| machine.rows(axis);
    // Once per thread, never freed.
    let memory = vec![0.0; requirement(&machine.settings, rows)].leak();
    let compensation = Compensation::build(&machine.settings, rows, &[], 2, memory).expect("a good machine");
    let axes = AxisOrder::<5>::of(&machine.settings).expect("five axes").axes();
    let geometry = Geometry::new(&machine, 0.0).expect("a good machine");
    Model { machine, axes, compensation, geometry }
}

thread_local! {
    static MODEL: Model = model();
}

fn run(bytes: &[u8]) {
    if bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() > MOST_ROWS {
        return;
    }
    if let Err(error) = MODEL.with(|model| evaluate(model, bytes)) {
        refusal::of_file(&format!("{error:#}"), FILE, bytes);
    }
}

/// Row by row, like the command: each is within the travel, with finite errors, and a correction within the reach of the
/// table.
fn evaluate(model: &Model, bytes: &[u8]) -> Result<()> {
    let mut rows = Rows::new(bytes, Path::new(FILE), &COLUMNS, outcome::refused)?;
    let mut travel = Travel::new(&model.machine, model.axes.into_iter());
    let thermal = [ThermalLine::default(); 5];
    let mut line = 0;
    while let Some(row) = next(&model.machine, &mut rows)? {
        // A carriage return alone ends a row, but not a line.
        assert!(row.line >= line, "line {} behind line {line}", row.line);
        line = row.line;
        assert_eq!(rows.cells().count(), rows.header.len());
        let command = model.axes.map(|axis| row.values[axis.index()]);
        assert!(command.iter().all(|q| q.abs() <= 400.0), "{command:?}");
        let at = model.compensation.coordinates(&command);
        let sent = |directions: &[Direction; 5]| {
            Ok::<_, Infallible>(model.compensation.correction(&Query::at(&at, directions, &thermal), &mut 0))
        };
        let Ok(directions) = travel.arrive(&command, sent);
        let mut clamped = 0;
        let error = model.compensation.pose_error(&Query::at(&at, &directions, &thermal), &mut clamped);
        let Ok(correction) = sent(&directions);
        let tip: [f64; 3] = error.tip.into();
        assert!(tip.iter().chain(&correction).all(|value| value.abs() < 1.0), "{tip:?} {correction:?} at {command:?}");
        assert_eq!(clamped, 0, "no position within the travel is beyond the table");
        exact(model, &row.values, &directions, tip);
    }
    outcome::accepted();
    one(model, bytes)
}

/// Exact transforms give the same error to second order.
fn exact(model: &Model, values: &[f64; AXES], directions: &[Direction; 5], tip: [f64; 3]) {
    let mut at = [0.0; AXES];
    let mut reverse = [0.0; AXES];
    for ((q, reverse), own) in at.iter_mut().zip(&mut reverse).zip(&model.machine.settings.axes) {
        *q = values[own.axis.index()];
        let slot = model.axes.iter().position(|axis| *axis == own.axis).expect("an axis of the step");
        *reverse = if directions[slot] == Direction::POSITIVE { 0.0 } else { 1.0 };
    }
    let exact = model.geometry.pose_error(&at, &reverse).tip_mm;
    let off = exact.iter().zip(tip).fold(0.0_f64, |off, (exact, tip)| off.max((exact - tip).abs()));
    assert!(off < 1e-4, "{off} mm between {exact:?} and {tip:?} at {values:?}");
    let settings = CorrectionSettings { passes: None, fade_deg: None };
    let correction = model.geometry.correction(&at, &reverse, settings).expect("three linear axes");
    assert!(correction.iter().all(|value| value.abs() < 1.0), "{correction:?} at {values:?}");
}

/// One position of the file, queried separately, has the same error in every bit.
fn one(model: &Model, bytes: &[u8]) -> Result<()> {
    // Expensive: this rebuilds the model.
    if !bytes.len().is_multiple_of(64) {
        return Ok(());
    }
    let mut rows = Rows::new(bytes, Path::new(FILE), &COLUMNS, |_| {})?;
    let Some(row) = next(&model.machine, &mut rows)? else { return Ok(()) };
    let found = correct::at::<5>(&model.machine, &Asked { at: row.values, reverse: [false; AXES], kelvin: 0.0 })?;
    let at = model.compensation.coordinates(&model.axes.map(|axis| row.values[axis.index()]));
    let thermal = [ThermalLine::default(); 5];
    let query = Query::at(&at, &[Direction::POSITIVE; 5], &thermal);
    let error: [f64; 3] = model.compensation.pose_error(&query, &mut 0).tip.into();
    assert_eq!(found.tip, error);
    let sum = found.contributions.iter().fold([0.0; 3], |sum, (_, share)| [0, 1, 2].map(|i| sum[i] + share[i]));
    assert!(sum.iter().zip(error).all(|(sum, error)| (sum - error).abs() < 1e-12), "{sum:?} of {error:?}");
    assert!(found.out_of_travel.is_empty());
    Ok(())
}

fn seeds() -> Vec<Vec<u8>> {
    [
        "x_mm,y_mm,z_mm\n0,0,0\n10,-20,30\n400,-400,0\n",
        "z_mm;a_deg;c_deg;y_mm;x_mm\n-10,5;30;90;1;2\n# again\n-10,5;-30;-90;1;-2\n-11;-30;-90;1;-2,5\n",
        "x_mm\ty_mm\tz_mm\tb_deg\r\n1\t2\t3\t0\r\n1.5e1\t-2\t+3\t0\r\n",
        "x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n\"1\",\"2\",\"3\",\"4\",\"0\",\"-6\"\n",
    ]
    .map(|text| text.as_bytes().to_vec())
    .into()
}
