//! `trueaxis contour`.

use crate::csv_in::{self, Column, Row};
use crate::output::{Writer, report_line};
use anyhow::{Result, anyhow};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis::contour::{ContourSearch, Method};
use trueaxis_evaluation::path::{Alive, Foot, PathFile, StuckAxis};
use trueaxis_tables::text::read_text;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis contour records/path.json records/actual.csv";

pub(crate) const HELP: &str = "\
PATH.json, in mm:
  {\"segments\":[
    {\"type\":\"line\",\"start\":[x,y,z],\"end\":[x,y,z]},
    {\"type\":\"arc\",\"start\":[…],\"end\":[…],\"center\":[…],\"normal\":[…],\"turns\":0},
    {\"type\":\"nurbs\",\"degree\":3,\"knots\":[…],\"points\":[…],\"weights\":[…]}]}
An arc turns right-handed about its normal; equal start and end make a full circle. A NURBS has degree 1 to 5.

ACTUAL.csv has the columns segment,u,x_mm,y_mm,z_mm; u is the place of the reference: 0 to 1 on lines and arcs, the \
knot domain on a NURBS.

The result has the columns segment,u,error_um,ex_um,ey_um,ez_um,evaluations,bracketed: the foot point, its distance, \
and the vector actual − foot. The nearest point within --max-lag-mm of path length on either side of the reference \
is found for each row separately.

A path is cut into spans that lie within 8 mm of their middle and turn by 30° at most; it may have 1,000,000 of them \
(16 km of straight line). Refused: a coordinate that keeps one value over eight rows and over a fifth of those in \
which the path moves along its axis.";

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Refinement {
    /// Newton steps guarded by bisection.
    Guarded,
    /// Plain bisection of the distance's derivative.
    Bisection,
}

#[derive(Args)]
pub(crate) struct ContourArgs {
    /// The programmed path.
    #[arg(value_name = "PATH.json")]
    path: PathBuf,
    /// Measured positions with the reference on the path.
    #[arg(value_name = "ACTUAL.csv")]
    actual: PathBuf,
    /// Method that narrows a bracket.
    #[arg(long, value_enum, default_value = "guarded")]
    method: Refinement,
    /// Path length searched on either side of the reference.
    #[arg(long, value_name = "MM", default_value_t = 1.0)]
    max_lag_mm: f64,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

const COLUMNS: [Column; 5] = [
    Column { name: "segment", needed: true },
    Column { name: "u", needed: true },
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
];

pub(crate) fn run(arguments: &ContourArgs) -> Result<()> {
    let text = read_text(&arguments.path, &[])?;
    let path = PathFile::read(&text, &arguments.path)?.cut(&mut |note| report_line(format_args!("note: {note}")))?;
    let mut actual = csv_in::open(&arguments.actual, &COLUMNS, "positions")?;
    let method = match arguments.method {
        Refinement::Guarded => Method::Guarded,
        Refinement::Bisection => Method::Bisection,
    };
    let search = ContourSearch::new(arguments.max_lag_mm, method).map_err(|error| anyhow!("--max-lag-mm: {error}"))?;
    let inputs = [arguments.path.clone(), arguments.actual.clone()];
    let mut out = Writer::new(arguments.output.as_deref(), inputs)?;
    out.put(format_args!("segment,u,error_um,ex_um,ey_um,ez_um,evaluations,bracketed\n"))?;
    let mut alive = Alive::default();
    while let Some(Row { line, values: [segment, u, x, y, z] }) = actual.next()? {
        let foot = path
            .foot(&search, [segment, u], [x, y, z])
            .map_err(|wrong| actual.error(line, wrong.field, wrong.found, wrong.needed))?;
        alive.put(line as usize, &foot, [x, y, z]);
        let Foot { segment, u, error_um, vector_um: [ex, ey, ez], evaluations, bracketed, .. } = foot;
        out.put(format_args!("{segment},{u},{error_um},{ex},{ey},{ez},{evaluations},{bracketed}\n"))?;
    }
    alive.check().map_err(|stuck| {
        actual.error(stuck.row as u32, COLUMNS[2 + stuck.axis].name, stuck.found, StuckAxis::NEEDED)
    })?;
    out.finish()
}
