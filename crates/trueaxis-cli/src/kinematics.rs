//! `trueaxis kinematics`.

use crate::csv_in::{Column, Row, Rows};
use crate::model;
use crate::output::{Writer, tell};
use anyhow::{Result, anyhow, bail};
use clap::{Args, Subcommand, ValueEnum};
use serde_json::Value;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::glam::DVec3;
use trueaxis::kinematics::{BranchTracker, Choice, InverseError, Kinematics, Solution, Tool};
use trueaxis::machine::{AXES, MachineSettings};
use trueaxis_tables::text::counted;

pub(crate) const HELP: &str = "\
The tool's tip and axis (unit vector from the tip to the spindle) are in workpiece coordinates, which at all axes zero
coincide with the machine's. A machine has X, Y, Z and up to two of A, B, C, each on either side of its structural code.

  forward  IN.csv: x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg], axes of the machine in any order, 0 where absent
           out: the same + tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k,singularity_margin_deg
  inverse  IN.csv: tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k
           out: the same + x_mm,y_mm,z_mm, the rotary axes (a_deg, …), branch, singularity_margin_deg

singularity_margin_deg: angle between the tool and the rotary axis nearest the workpiece (in the code); below the machine's
singular_cone_deg an inverse is refused. 90 on machines with less than two rotary axes.

Example: trueaxis kinematics forward --machine compensation-tables/mill-5axis axes.csv -o tool.csv
         trueaxis kinematics inverse --machine compensation-tables/mill-5axis tool.csv";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// From axis positions to the tool in workpiece coordinates.
    #[command(after_help = HELP)]
    Forward(Common),
    /// From the tool in workpiece coordinates to axis positions.
    #[command(after_help = HELP)]
    Inverse(Inverse),
}

#[derive(Args)]
pub(crate) struct Common {
    /// machine.toml, its folder, or a compiled .tcomp.
    #[arg(long, value_name = "M")]
    machine: PathBuf,
    /// Axis positions (forward) or tools (inverse).
    #[arg(value_name = "IN.csv")]
    input: PathBuf,
    /// A tool on the tool axis: distance from its tip to the origin of the last tool-side frame (on a swivelling head the
    /// pivot length), mm [default: the machine's tool_mm].
    #[arg(long, value_name = "L", conflicts_with = "tool_mm")]
    tool_length_mm: Option<f64>,
    /// Tip from the last tool-side frame at all axes zero, mm [default: the machine's tool_mm].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_delimiter = ',', num_args = 1)]
    tool_mm: Option<Vec<f64>>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

/// Which of two poses of the rotary axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BranchChoice {
    /// The shorter way from the row before.
    Nearest,
    /// The rotary axis nearest the tool turns it right-handed, 0 … 180 degrees, from where it is nearest to the other axis.
    #[value(name = "1")]
    First,
    /// The other way.
    #[value(name = "2")]
    Second,
}

#[derive(Args)]
pub(crate) struct Inverse {
    #[command(flatten)]
    common: Common,
    /// Pose of the rotary axes.
    #[arg(long, value_enum, default_value = "nearest")]
    branch: BranchChoice,
    /// Both poses, two rows each.
    #[arg(long, conflicts_with_all = ["branch", "max_step_deg"])]
    both: bool,
    /// Where the machine's rotary axes stand before the first row, in the order A, B, C, degrees [default: zero].
    #[arg(long, value_name = "DEG,…", allow_hyphen_values = true, value_delimiter = ',', num_args = 1)]
    start: Option<Vec<f64>>,
    /// Refuse a tool nearer than this to the singular pose, 0 … 45 degrees [default: the machine's].
    #[arg(long, value_name = "D")]
    singular_cone_deg: Option<f64>,
    /// Refuse a change of branch, and a step of a rotary axis above this, from row to row.
    #[arg(long, value_name = "DEG")]
    max_step_deg: Option<f64>,
}

const AXIS_COLUMNS: [&str; AXES] = ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"];
const TOOL_COLUMNS: [&str; 6] = ["tip_x_mm", "tip_y_mm", "tip_z_mm", "tool_i", "tool_j", "tool_k"];
const MARGIN: &str = "singularity_margin_deg";
const BRANCH: &str = "branch";

/// A result on its way out: cells as they stood in the input, then the values found.
struct Sheet<'p> {
    names: Vec<String>,
    csv: Option<Writer<'p>>,
    json: Option<Writer<'p>>,
    first: bool,
}

pub(crate) fn run(command: Command) -> Result<()> {
    match command {
        Command::Forward(common) => {
            let settings = model::machine(&common.machine)?.settings;
            forward(&common, &settings)
        }
        Command::Inverse(arguments) => {
            let settings = model::machine(&arguments.common.machine)?.settings;
            inverse(&arguments, &settings)
        }
    }
}

/// The machine with the tool asked for.
fn kinematics(common: &Common, settings: &MachineSettings) -> Result<Kinematics<f64>> {
    let kinematics =
        Kinematics::<f64>::new(settings).map_err(|error| anyhow!("{}: {error}", common.machine.display()))?;
    let finite = |name: &str, value: f64| {
        if value.is_finite() && value.abs() <= 1e6 {
            Ok(value)
        } else {
            Err(anyhow!("{name}: found {value}, needed a finite number of at most 1e6 mm"))
        }
    };
    Ok(match (&common.tool_mm, common.tool_length_mm) {
        (Some(tool), _) => {
            let &[x, y, z] = tool.as_slice() else {
                bail!("--tool-mm: found {} numbers, needed three: X,Y,Z", tool.len());
            };
            let [x, y, z] = [finite("--tool-mm", x)?, finite("--tool-mm", y)?, finite("--tool-mm", z)?];
            kinematics.with_tool(DVec3::new(x, y, z))
        }
        (None, Some(length)) => kinematics.with_tool_length(finite("--tool-length-mm", length)?),
        (None, None) => kinematics,
    })
}

fn forward(common: &Common, settings: &MachineSettings) -> Result<()> {
    let kinematics = kinematics(common, settings)?;
    let columns = AXIS_COLUMNS.map(|name| Column { name, needed: false });
    let mut rows = Rows::open(&common.input, &columns, "positions")?;
    for (axis, (column, present)) in Axis::ALL.into_iter().zip(AXIS_COLUMNS.iter().zip(rows.present)) {
        if present && !kinematics.has(axis) {
            bail!(
                "{}: found the column {column}, needed only axes of the machine {} ({})",
                common.input.display(),
                settings.name,
                settings.chain
            );
        }
    }
    let found = TOOL_COLUMNS.into_iter().chain([MARGIN]).map(str::to_owned);
    let mut sheet = Sheet::new(common, settings, rows.header.iter().cloned().chain(found).collect())?;
    while let Some(Row { line, values: axes }) = rows.next()? {
        for known in &settings.axes {
            let ([low, high], place) = (known.travel, known.axis.index());
            if axes[place] < low || axes[place] > high {
                let needed = format!("the declared travel, {low} to {high}");
                return Err(rows.error(line, AXIS_COLUMNS[place], axes[place], needed));
            }
        }
        let Tool { tip, axis } = kinematics.forward(&axes);
        let margin = kinematics.singularity_margin_deg(&axes);
        sheet.row(rows.cells(), [tip.x, tip.y, tip.z, axis.x, axis.y, axis.z, margin])?;
    }
    sheet.finish()
}

/// Columns of the input: the tool, then what a forward or an inverse result has besides.
const INVERSE_COLUMNS: [&str; 14] = [
    TOOL_COLUMNS[0],
    TOOL_COLUMNS[1],
    TOOL_COLUMNS[2],
    TOOL_COLUMNS[3],
    TOOL_COLUMNS[4],
    TOOL_COLUMNS[5],
    AXIS_COLUMNS[0],
    AXIS_COLUMNS[1],
    AXIS_COLUMNS[2],
    AXIS_COLUMNS[3],
    AXIS_COLUMNS[4],
    AXIS_COLUMNS[5],
    BRANCH,
    MARGIN,
];

fn inverse(arguments: &Inverse, settings: &MachineSettings) -> Result<()> {
    let common = &arguments.common;
    let mut kinematics = kinematics(common, settings)?;
    if let Some(cone) = arguments.singular_cone_deg {
        if !(0.0..=45.0).contains(&cone) {
            bail!("--singular-cone-deg: found {cone}, needed 0 to 45 degrees");
        }
        kinematics = kinematics.with_singular_cone_deg(cone);
    }
    if let Some(step) = arguments.max_step_deg.filter(|step| step.is_nan() || *step <= 0.0) {
        bail!("--max-step-deg: found {step}, needed a positive number of degrees");
    }
    let used: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| kinematics.has(*axis)).collect();
    let columns = INVERSE_COLUMNS.map(|name| Column { name, needed: TOOL_COLUMNS.contains(&name) });
    let mut rows = Rows::open(&common.input, &columns, "tools")?;
    let is_tool = |name: &String| TOOL_COLUMNS.contains(&name.as_str());
    let ignored: Vec<&str> = rows.header.iter().filter(|name| !is_tool(name)).map(String::as_str).collect();
    if !ignored.is_empty() {
        tell(format_args!("note: {}: columns {} are not read", common.input.display(), ignored.join(", ")));
    }
    let kept: Vec<bool> = rows.header.iter().map(is_tool).collect();
    let names = rows.header.iter().filter(|name| is_tool(name)).cloned();
    let found = used.iter().map(|axis| AXIS_COLUMNS[axis.index()]).chain([BRANCH, MARGIN]).map(str::to_owned);
    let mut sheet = Sheet::new(common, settings, names.chain(found).collect())?;
    let mut walk = Walk { near: start(arguments, &used)?, follow: None, left_out: 0 };
    while let Some(Row { line, values }) = rows.next()? {
        let [x, y, z, i, j, k, ..] = values;
        let tool = Tool { tip: DVec3::new(x, y, z), axis: DVec3::new(i, j, k) };
        let found = walk.solve(arguments, &kinematics, &tool).map_err(|error| told(&common.input, line, error))?;
        for solution in found {
            let positions = used.iter().map(|axis| solution.axes[axis.index()]);
            let more = [f64::from(solution.branch as u8), solution.singularity_margin_deg];
            let cells = rows.cells().zip(&kept).filter(|(_, kept)| **kept).map(|(cell, _)| cell);
            sheet.row(cells, positions.chain(more))?;
        }
    }
    if walk.left_out > 0 {
        tell(format_args!(
            "note: {} with one solution only: the other leaves the travel",
            counted(walk.left_out, "row")
        ));
    }
    sheet.finish()
}

/// Where the rotary axes stand before the first row.
fn start(arguments: &Inverse, used: &[Axis]) -> Result<[f64; AXES]> {
    let mut near = [0.0; AXES];
    let Some(start) = &arguments.start else { return Ok(near) };
    let rotary: Vec<Axis> = used.iter().copied().filter(|axis| axis.is_rotary()).collect();
    if rotary.len() != start.len() {
        let letters: String = rotary.iter().map(|axis| axis.letter()).collect();
        bail!("--start: found {} angles, needed one for each rotary axis ({letters})", start.len());
    }
    for (axis, angle) in rotary.into_iter().zip(start) {
        if !angle.is_finite() || angle.abs() > 1e6 {
            bail!("--start: found {angle}, needed an angle of at most 1e6 degrees");
        }
        near[axis.index()] = *angle;
    }
    Ok(near)
}

/// The way from row to row.
struct Walk {
    near: [f64; AXES],
    follow: Option<BranchTracker<f64>>,
    /// Rows of which only one solution was given.
    left_out: usize,
}

impl Walk {
    fn solve(
        &mut self,
        arguments: &Inverse,
        kinematics: &Kinematics<f64>,
        tool: &Tool<f64>,
    ) -> Result<Vec<Solution<f64>>, InverseError> {
        if let Some(follow) = &mut self.follow {
            return Ok(vec![follow.next(kinematics, tool)?]);
        }
        let solutions = kinematics.solutions(tool, &self.near)?;
        let chosen = solutions.choose(match arguments.branch {
            BranchChoice::Nearest => Choice::Nearest,
            BranchChoice::First => Choice::First,
            BranchChoice::Second => Choice::Second,
        })?;
        self.near = chosen.axes;
        self.follow = arguments.max_step_deg.map(|step| BranchTracker::new(&chosen, step));
        if !arguments.both {
            return Ok(vec![chosen]);
        }
        let both = [solutions.first, solutions.second];
        self.left_out += usize::from(both.iter().any(|s| s.is_err_and(|error| error != InverseError::OneBranch)));
        Ok(both.into_iter().flatten().collect())
    }
}

/// The error at its place in the file.
fn told(file: &Path, line: u32, error: InverseError) -> anyhow::Error {
    let place = match error {
        InverseError::NotADirection { .. } | InverseError::Unreachable { .. } | InverseError::SingularPose { .. } => {
            "column tool_i, tool_j, tool_k: "
        }
        _ => "",
    };
    anyhow!("{}:{line}: {place}{error}", file.display())
}

impl<'p> Sheet<'p> {
    fn new(common: &'p Common, settings: &MachineSettings, names: Vec<String>) -> Result<Sheet<'p>> {
        let inputs = model::files(&common.machine).into_iter().chain([common.input.clone()]);
        let mut csv = (!common.json || common.output.is_some())
            .then(|| Writer::new(common.output.as_deref(), inputs))
            .transpose()?;
        if let Some(csv) = &mut csv {
            csv.put(format_args!("{}\n", names.join(",")))?;
        }
        let mut json = common.json.then(|| Writer::new(None, [])).transpose()?;
        if let Some(json) = &mut json {
            let [machine, chain] = [settings.name.as_str(), settings.chain.as_str()].map(Value::from);
            json.put(format_args!("{{\n  \"machine\": {machine},\n  \"chain\": {chain},\n  \"rows\": ["))?;
        }
        Ok(Sheet { names, csv, json, first: true })
    }

    fn row<'c>(
        &mut self,
        cells: impl Iterator<Item = Cow<'c, str>> + Clone,
        values: impl IntoIterator<Item = f64> + Clone,
    ) -> Result<()> {
        if let Some(csv) = &mut self.csv {
            for cell in cells.clone() {
                csv.put(format_args!("{cell},"))?;
            }
            for (i, value) in values.clone().into_iter().enumerate() {
                csv.put(format_args!("{}{value}", if i > 0 { "," } else { "" }))?;
            }
            csv.put(format_args!("\n"))?;
        }
        if let Some(json) = &mut self.json {
            json.put(format_args!("{}\n    {{", if self.first { "" } else { "," }))?;
            // Cells were read as numbers before.
            let numbers = cells.filter_map(|cell| cell.parse::<f64>().ok()).chain(values);
            for (i, (name, value)) in self.names.iter().zip(numbers).enumerate() {
                let number = if name == BRANCH { Value::from(value as u8) } else { Value::from(value) };
                json.put(format_args!("{}\"{name}\": {number}", if i > 0 { ", " } else { " " }))?;
            }
            json.put(format_args!(" }}"))?;
        }
        self.first = false;
        Ok(())
    }

    fn finish(self) -> Result<()> {
        if let Some(csv) = self.csv {
            csv.finish()?;
        }
        if let Some(mut json) = self.json {
            json.put(format_args!("\n  ]\n}}\n"))?;
            json.finish()?;
        }
        Ok(())
    }
}
