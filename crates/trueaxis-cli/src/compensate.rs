//! `trueaxis compensate`.

use crate::csv_in::{self, Rows};
use crate::model;
use crate::output::{Writer, report_line};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis::machine::{AXES, Axis, ErrorModel};
use trueaxis_evaluation::compensate::{Arrival, NoCorrection, PoseError, Settings, with_model};
use trueaxis_evaluation::positions::{COLUMNS, next};
use trueaxis_tables::limits::Clipped;
use trueaxis_tables::text::counted;
use trueaxis_tables::{Machine, Warning};

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis compensate compensation-tables/mill-3axis records/positions.csv";

pub(crate) const HELP: &str = "\
POSITIONS.csv has the commanded positions x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg], columns in any order.
The result has the same columns and:
  ex_um,ey_um,ez_um: error of the tool tip at the uncorrected command
  cx_mm,cy_mm,cz_mm: corrected command, which puts the tool at the position
With --orientation (volumetric and exact) it also has:
  ea_urad,eb_urad,ec_urad: error of the tool's orientation, a small rotation
  ca_deg,cb_deg,cc_deg: corrected command of the machine's rotary axes
Errors are actual − ideal in machine coordinates.

With --orientation the corrected rotary axes give the tool its ideal direction, except near the singular pose \
(fade_deg in [compensation]); cx, cy and cz also cancel the motion that they cause. Without it only X, Y and Z are \
corrected; with the model nine, by all tables that give their errors.

A two-sided table is read in positive travel, every position for itself; with --reverse in negative travel, backlash \
included; with --in-order in the direction in which the drive, position plus correction, has come from the rows \
before.

Corrections are not limited. A note counts those that the step's magnitude limit would reduce.";

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
pub(crate) struct CompensateArgs {
    /// machine.toml, its folder, or a compiled .tcomp.
    #[arg(value_name = "M")]
    machine: PathBuf,
    /// Positions to evaluate.
    #[arg(value_name = "POSITIONS.csv")]
    positions: PathBuf,
    /// Error model [default: the machine's own, key model of compensation].
    #[arg(long, value_enum, help_heading = "Error model")]
    model: Option<Model>,
    /// Passes of the exact inverse, 1 to 8 [default: as many as 1e-3 µm needs; exact: until it converges].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8), help_heading = "Error model")]
    inverse_passes: Option<u8>,
    /// All axes travel in negative direction.
    #[arg(long, help_heading = "Direction of travel and temperature")]
    reverse: bool,
    /// The machine approaches the positions in their order, the first in positive travel.
    #[arg(long, conflicts_with = "reverse", help_heading = "Direction of travel and temperature")]
    in_order: bool,
    /// Temperature of the machine, °C, for its thermal growth [default: its reference temperature].
    #[arg(long, value_name = "C", allow_hyphen_values = true, help_heading = "Direction of travel and temperature")]
    temperature_c: Option<f64>,
    /// Also compute the error of the tool's orientation, and the rotary axes' commands that correct its direction.
    #[arg(long, help_heading = "Error model")]
    orientation: bool,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

pub(crate) fn run(arguments: &CompensateArgs) -> Result<()> {
    let mut machine = model::machine(&arguments.machine)?;
    if !machine.states_errors() {
        report_line(format_args!("note: {}", Warning::NoErrorsStated));
    }
    let mut positions = csv_in::open(&arguments.positions, &COLUMNS, "positions")?;
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
    let own = match machine.settings.compensation.model {
        ErrorModel::Nine => Model::Nine,
        ErrorModel::Volumetric => Model::Volumetric,
    };
    let model = arguments.model.unwrap_or(own);
    machine.settings.compensation.orientation = arguments.orientation;
    let inputs = model::files(&arguments.machine).into_iter().chain([arguments.positions.clone()]);
    let mut result = Written {
        out: Writer::new(arguments.output.as_deref(), inputs)?,
        rotary: Vec::new(),
        clamped: 0,
        clipped: Clipped::default(),
    };
    match model {
        Model::Nine if arguments.orientation => {
            let found = if arguments.model.is_some() { "--model nine" } else { "model nine of the machine" };
            bail!("--orientation: found {found}, which has no orientation, needed --model volumetric or --model exact")
        }
        Model::Nine => machine.settings.compensation.model = ErrorModel::Nine,
        Model::Volumetric => machine.settings.compensation.model = ErrorModel::Volumetric,
        Model::Exact => {}
    }
    let settings = Settings {
        exact: model == Model::Exact,
        passes: arguments.inverse_passes,
        kelvin: model::rise(arguments.temperature_c, &machine)?,
    };
    let mut arrival = match (arguments.reverse, arguments.in_order) {
        (_, true) => Arrival::in_order(&machine),
        (true, _) => Arrival::Negative,
        (false, false) => Arrival::Positive,
    };
    with_model(&machine, &settings, |model| {
        result.header(arguments, &machine, &positions)?;
        while let Some(row) = next(&machine, &mut positions)? {
            let refused =
                |NoCorrection| positions.error(row.line, COLUMNS[0].name, NoCorrection::FOUND, NoCorrection::NEEDED);
            let at = arrival.at(model, row.values).map_err(refused)?;
            let correction = model.correction(&at).map_err(refused)?;
            let corrected = std::array::from_fn(|axis| row.values[axis] + correction[axis]);
            result.clipped.add(&machine.settings, &row.values, &correction);
            result.row(arguments, &positions, &model.error(&at), &corrected)?;
        }
        Ok(())
    })?;
    result.finish(&machine, positions.count)
}

/// A result being written.
struct Written<'p> {
    out: Writer<'p>,
    /// Rotary axes with a corrected command.
    rotary: Vec<Axis>,
    /// Positions beyond a table's end.
    clamped: usize,
    /// Corrections beyond their limits.
    clipped: Clipped,
}

impl Written<'_> {
    fn header(&mut self, arguments: &CompensateArgs, machine: &Machine, positions: &Rows<6>) -> Result<()> {
        self.out.put(format_args!("{},ex_um,ey_um,ez_um,cx_mm,cy_mm,cz_mm", positions.header.join(",")))?;
        if arguments.orientation {
            self.out.put(format_args!(",ea_urad,eb_urad,ec_urad"))?;
            self.rotary = machine.settings.axes.iter().map(|own| own.axis).filter(|axis| axis.is_rotary()).collect();
            for axis in &self.rotary {
                self.out.put(format_args!(",c{}_deg", axis.letter().to_ascii_lowercase()))?;
            }
        }
        self.out.put(format_args!("\n"))
    }

    fn row(
        &mut self,
        arguments: &CompensateArgs,
        positions: &Rows<6>,
        error: &PoseError,
        corrected: &[f64; AXES],
    ) -> Result<()> {
        for cell in positions.cells() {
            self.out.put(format_args!("{cell},"))?;
        }
        let [ex, ey, ez] = error.tip.map(|mm| mm * 1e3);
        let [cx, cy, cz, ..] = *corrected;
        self.out.put(format_args!("{ex},{ey},{ez},{cx},{cy},{cz}"))?;
        if arguments.orientation {
            let [ea, eb, ec] = error.orientation.map(|rad| rad * 1e6);
            self.out.put(format_args!(",{ea},{eb},{ec}"))?;
            for axis in &self.rotary {
                self.out.put(format_args!(",{}", corrected[axis.index()]))?;
            }
        }
        self.clamped += usize::from(error.clamped);
        self.out.put(format_args!("\n"))
    }

    fn finish(self, machine: &Machine, count: usize) -> Result<()> {
        if self.clamped > 0 {
            report_line(format_args!(
                "note: {} of {} beyond a table's end, where its edge value is used",
                self.clamped,
                counted(count, "position")
            ));
        }
        for note in self.clipped.notes(&machine.settings, "position") {
            report_line(format_args!("note: {note}"));
        }
        self.out.finish()
    }
}
