//! `trueaxis compensate`.

mod exact;
mod step;

use crate::csv_in::{Column, Rows};
use crate::model::{self, axis_count};
use crate::output::put;
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis::compensation::ThermalLine;
use trueaxis::machine::ErrorModel;
use trueaxis_tables::Machine;

pub(crate) const HELP: &str = "\
POSITIONS.csv: x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg], commanded positions, columns in any order.
Output: the same columns and
  ex_um,ey_um,ez_um   error of the tool tip at the uncorrected command: actual − ideal, machine coordinates
  cx_mm,cy_mm,cz_mm   corrected command: where the axes must be sent so that the tool is at the position
and with --orientation (volumetric and exact)
  ea_urad,eb_urad,ec_urad   error of the tool's orientation: small rotation, actual − ideal, machine coordinates
  ca_deg,cb_deg,cc_deg      corrected command of the machine's rotary axes; the tool's direction becomes the ideal one away
                            from its singular pose ([compensation] fade_deg), and cx, cy, cz take back what they move
Without --orientation only X, Y and Z are corrected (nine: whatever the tables say of them).
A two-sided table is read in positive travel (--reverse: in negative travel, backlash included).

Example: trueaxis compensate compensation-tables/mill-3axis positions.csv -o corrected.csv";

/// Which model is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Model {
    /// Axis-wise: nine one-dimensional functions, one per direction and moving axis (and the translations of rotary axes).
    Nine,
    /// Volumetric: the six errors of every axis, carried to the tool tip by its lever; first order, as in the servo step.
    Volumetric,
    /// Exact products of rigid transforms along the machine's chain.
    Exact,
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
    /// Look-ups of the exact inverse, 1 to 8 [default: what the machine needs for 1e-3 µm; exact: until it stands].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    inverse_passes: Option<u8>,
    /// All axes travel in negative direction.
    #[arg(long)]
    reverse: bool,
    /// Temperature of the machine, °C, for its thermal growth [default: its reference temperature].
    #[arg(long, value_name = "C", allow_hyphen_values = true)]
    temperature_c: Option<f64>,
    /// Also the error of the tool's orientation, and the rotary axes' commands that correct its direction.
    #[arg(long)]
    orientation: bool,
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
    let mut machine = model::machine(&arguments.machine)?;
    let positions = Rows::read(&arguments.positions, &COLUMNS)?;
    for (column, present) in COLUMNS.iter().zip(positions.present).skip(3) {
        let letter = column.name.chars().next().map(|c| c.to_ascii_uppercase());
        if present && !machine.settings.axes.iter().any(|a| Some(a.axis.letter()) == letter) {
            bail!(
                "{}: found the column {}, needed only axes of the machine {} ({})",
                arguments.positions.display(),
                column.name,
                machine.settings.name,
                machine.settings.chain
            );
        }
    }
    inside_travel(&machine, &positions)?;
    if arguments.model == Model::Nine && machine.settings.compensation.model == ErrorModel::Volumetric {
        eprintln!(
            "note: the machine file sets the volumetric model for the controller; this is the nine-term one (--model volumetric)"
        );
    }
    machine.settings.compensation.orientation = arguments.orientation;
    let evaluated = match arguments.model {
        Model::Exact => exact::evaluate(arguments, &machine, &positions)?,
        Model::Nine if arguments.orientation => bail!(
            "--orientation: found --model nine, which has no orientation, needed --model volumetric or --model exact"
        ),
        Model::Nine | Model::Volumetric => {
            let nine = arguments.model == Model::Nine;
            machine.settings.compensation.model = if nine { ErrorModel::Nine } else { ErrorModel::Volumetric };
            match axis_count(&machine) {
                3 => step::evaluate::<3>(arguments, &machine, &positions)?,
                4 => step::evaluate::<4>(arguments, &machine, &positions)?,
                5 => step::evaluate::<5>(arguments, &machine, &positions)?,
                _ => step::evaluate::<6>(arguments, &machine, &positions)?,
            }
        }
    };
    let inputs = model::files(&arguments.machine).into_iter().chain([arguments.positions.clone()]);
    put(&written(arguments, &machine, &positions, &evaluated)?, arguments.output.as_deref(), inputs)
}

/// What is known about one position.
struct Evaluated {
    /// Tip error, mm.
    error: [f64; 3],
    /// Orientation error, rad.
    orientation: [f64; 3],
    /// Commands of X Y Z A B C, mm and degrees.
    corrected: [f64; 6],
    /// Beyond a table's end.
    held: bool,
}

fn inside_travel(machine: &Machine, positions: &Rows<6>) -> Result<()> {
    for (line, values, _) in &positions.rows {
        for settings in &machine.settings.axes {
            let place = settings.axis.index();
            let (q, [low, high]) = (values[place], settings.travel);
            if q < low || q > high {
                let needed = format!("the declared travel, {low} to {high}");
                return Err(positions.error(*line, COLUMNS[place].name, q, needed));
            }
        }
    }
    Ok(())
}

/// Kelvin above the reference temperature.
fn rise(arguments: &Arguments, machine: &Machine) -> Result<f64> {
    let kelvin = arguments.temperature_c.map_or(0.0, |t| t - machine.settings.reference_temperature_c);
    for settings in &machine.settings.axes {
        if ThermalLine::<f64>::for_axis(&settings.thermal, kelvin).is_none() {
            bail!("--temperature-c: found {kelvin} K above the reference, needed a growth of at most 10 mm and 1e-3");
        }
    }
    Ok(kelvin)
}

fn written(arguments: &Arguments, machine: &Machine, positions: &Rows<6>, evaluated: &[Evaluated]) -> Result<String> {
    let rotary = || machine.settings.axes.iter().map(|settings| settings.axis).filter(|axis| axis.is_rotary());
    let mut text = format!("{},ex_um,ey_um,ez_um,cx_mm,cy_mm,cz_mm", positions.header.join(","));
    if arguments.orientation {
        text.push_str(",ea_urad,eb_urad,ec_urad");
        rotary().for_each(|axis| text.push_str(&format!(",c{}_deg", axis.letter().to_ascii_lowercase())));
    }
    text.push('\n');
    for ((_, _, cells), at) in positions.rows.iter().zip(evaluated) {
        let [ex, ey, ez] = at.error.map(|mm| mm * 1e3);
        let [cx, cy, cz, ..] = at.corrected;
        write!(text, "{},{ex},{ey},{ez},{cx},{cy},{cz}", cells.join(","))?;
        if arguments.orientation {
            let [ea, eb, ec] = at.orientation.map(|rad| rad * 1e6);
            write!(text, ",{ea},{eb},{ec}")?;
            for axis in rotary() {
                write!(text, ",{}", at.corrected[axis.index()])?;
            }
        }
        text.push('\n');
    }
    let held = evaluated.iter().filter(|at| at.held).count();
    if held > 0 {
        eprintln!(
            "note: {held} of {} positions lie beyond a table's end, where its edge value is held",
            evaluated.len()
        );
    }
    Ok(text)
}
