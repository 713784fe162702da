//! `trueaxis compensate`.

use crate::csv_in::{Column, Rows};
use crate::model::{axis_count, compiled, parsed, with_compensation};
use crate::output::{progress, put};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis::compensation::{ThermalLine, step_axes};
use trueaxis::tcomp::Tcomp;

pub(crate) const HELP: &str = "\
POSITIONS.csv: x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg], commanded positions, columns in any order.
Output: the same columns and
  ex_um,ey_um,ez_um   error of the tool tip at the uncorrected command: actual − ideal, machine coordinates
  cx_mm,cy_mm,cz_mm   corrected command: where the axes must be sent so that the tool is at the position
A two-sided table is read in positive travel (--reverse: in negative travel, backlash included).

Example: trueaxis compensate compensation-tables/mill-3axis positions.csv -o corrected.csv";

/// Which model is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Model {
    /// Axis-wise: nine one-dimensional functions, one per direction and moving axis (and the translations of rotary axes).
    Nine,
}

#[derive(Args)]
pub(crate) struct Arguments {
    /// machine.toml, its folder, or a compiled .tcomp.
    #[arg(value_name = "M")]
    machine: PathBuf,
    /// Positions to evaluate.
    #[arg(value_name = "POSITIONS.csv")]
    positions: PathBuf,
    /// Error model.
    #[arg(long, value_enum, default_value = "nine")]
    model: Model,
    /// Look-ups of the exact inverse, 1 to 8 [default: what the machine needs for 1e-3 µm].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    inverse_passes: Option<u8>,
    /// All axes travel in negative direction.
    #[arg(long)]
    reverse: bool,
    /// Temperature of the machine, °C, for its thermal growth [default: its reference temperature].
    #[arg(long, value_name = "C", allow_hyphen_values = true)]
    temperature_c: Option<f64>,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

const COLUMNS: [Column; 6] = [
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
    Column { name: "a_deg", needed: false },
    Column { name: "b_deg", needed: false },
    Column { name: "c_deg", needed: false },
];

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let Model::Nine = arguments.model;
    let bytes = compiled(&arguments.machine)?;
    let tables = parsed(&bytes, &arguments.machine)?;
    let positions = Rows::read(&arguments.positions, &COLUMNS)?;
    for (column, present) in COLUMNS.iter().zip(positions.present).skip(3) {
        let letter = column.name.chars().next().map(|c| c.to_ascii_uppercase());
        if present && !tables.settings().axes.iter().any(|a| Some(a.axis.letter()) == letter) {
            bail!(
                "{}: found the column {}, needed only axes of the machine {} ({})",
                arguments.positions.display(),
                column.name,
                tables.settings().name,
                tables.settings().chain
            );
        }
    }
    let text = match axis_count(&tables) {
        3 => evaluate::<3>(arguments, &tables, &positions)?,
        4 => evaluate::<4>(arguments, &tables, &positions)?,
        5 => evaluate::<5>(arguments, &tables, &positions)?,
        _ => evaluate::<6>(arguments, &tables, &positions)?,
    };
    put(&text, arguments.output.as_deref())
}

fn evaluate<const N: usize>(arguments: &Arguments, tables: &Tcomp<'_>, positions: &Rows<6>) -> Result<String> {
    let machine = tables.settings();
    let axes = step_axes::<N>(machine).map_err(|error| anyhow::anyhow!("{error}"))?;
    let passes = arguments.inverse_passes.unwrap_or(tables.inverse_passes());
    let kelvin = arguments.temperature_c.map_or(0.0, |t| t - machine.reference_temperature_c);
    let mut thermal = [ThermalLine::default(); N];
    for (line, axis) in thermal.iter_mut().zip(axes) {
        if let Some(settings) = machine.axes.iter().find(|a| a.axis == axis) {
            let Some(grown) = ThermalLine::for_axis(&settings.thermal, kelvin) else {
                bail!(
                    "--temperature-c: found {kelvin} K above the reference, needed a growth of at most 10 mm and 1e-3"
                );
            };
            *line = grown;
        }
    }
    let reverse = [if arguments.reverse { usize::MAX } else { 0 }; N];
    with_compensation::<N, _>(tables, passes, |compensation| {
        let mut text = format!("{},ex_um,ey_um,ez_um,cx_mm,cy_mm,cz_mm\n", positions.header.join(","));
        let bar = progress(positions.rows.len(), "positions");
        let mut at_edge = 0u64;
        for (line, values, cells) in &positions.rows {
            let command: [f64; N] = std::array::from_fn(|place| values[axes[place].index()]);
            for (axis, q) in axes.iter().zip(command) {
                let Some(settings) = machine.axes.iter().find(|a| a.axis == *axis) else { continue };
                let [low, high] = settings.travel;
                if q < low || q > high {
                    let column = COLUMNS[axis.index()].name;
                    return Err(positions.error(*line, column, q, format!("the declared travel, {low} to {high}")));
                }
            }
            let at = compensation.coordinates(&command);
            let mut held = 0;
            let error = compensation.errors(&at, &reverse, &thermal, &mut held);
            let correction = compensation.correction(&at, &at, &reverse, &thermal, &mut 0);
            at_edge += u64::from(held != 0);
            let [ex, ey, ez] = [0, 1, 2].map(|k| error[k] * 1e3);
            let [cx, cy, cz] = [0, 1, 2].map(|k| command[k] + correction[k]);
            writeln!(text, "{},{ex},{ey},{ez},{cx},{cy},{cz}", cells.join(","))?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        if at_edge > 0 {
            eprintln!(
                "note: {at_edge} of {} positions lie beyond a table's end, where its edge value is held",
                positions.rows.len()
            );
        }
        Ok(text)
    })
}
