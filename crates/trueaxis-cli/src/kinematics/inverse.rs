//! `trueaxis kinematics inverse`: from the tool to axis positions.

use super::common::{AXIS_COLUMNS, BRANCH, Common, LEFT, MARGIN, TOOL_COLUMNS, kinematics};
use super::sheet::Sheet;

use crate::csv_in::{self, Column, Row};
use crate::numbers::{Numbers, numbers};
use crate::output::report_line;
use anyhow::{Result, anyhow, bail};
use clap::{Args, ValueEnum};
use std::path::Path;
use trueaxis::Axis;
use trueaxis::glam::DVec3;
use trueaxis::kinematics::{Choice, InverseError, Tool};
use trueaxis::machine::MachineSettings;
use trueaxis_evaluation::inverse::Walk;
use trueaxis_tables::text::counted;

/// One of two poses of the rotary axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BranchChoice {
    /// The pose nearer to that of the row before.
    Nearest,
    /// The rotary axis nearest the tool has turned it by 0 … 180 degrees, right-handed, from where it is nearest to the other
    /// axis.
    #[value(name = "1")]
    First,
    /// The other pose.
    #[value(name = "2")]
    Second,
}

#[derive(Args)]
pub(crate) struct InverseArgs {
    #[command(flatten)]
    pub(super) common: Common,
    /// Pose of the rotary axes.
    #[arg(long, value_enum, default_value = "nearest", help_heading = "Rotary axes")]
    branch: BranchChoice,
    /// Write both poses, two rows for each row of the input.
    #[arg(long, conflicts_with_all = ["branch", "max_step_deg"], help_heading = "Rotary axes")]
    both: bool,
    /// Angles of the machine's rotary axes before the first row, in the order A, B, C, degrees [default: zero].
    #[arg(long, value_name = "DEG,…", value_parser = numbers, allow_hyphen_values = true, help_heading = "Rotary axes")]
    start: Option<Numbers>,
    /// Hold or guide the axis nearest the workpiece within this angle of the singular pose, 0 … 45 degrees [default: the
    /// machine's].
    #[arg(long, value_name = "D", help_heading = "Rotary axes")]
    singular_cone_deg: Option<f64>,
    /// Refuse a change of branch (except through the singular pose) and a larger step of a rotary axis between two rows.
    #[arg(long, value_name = "DEG", help_heading = "Rotary axes")]
    max_step_deg: Option<f64>,
}

/// Columns of the input: the tool, and the other columns of a forward or inverse result.
const COLUMNS: [&str; 15] = {
    let [x, y, z, i, j, k] = TOOL_COLUMNS;
    let [qx, qy, qz, a, b, c] = AXIS_COLUMNS;
    [x, y, z, i, j, k, qx, qy, qz, a, b, c, BRANCH, MARGIN, LEFT]
};

pub(super) fn run(arguments: &InverseArgs, settings: &MachineSettings) -> Result<()> {
    let common = &arguments.common;
    let mut kinematics = kinematics(common, settings)?;
    if let Some(cone) = arguments.singular_cone_deg {
        if !(0.0..=45.0).contains(&cone) {
            bail!("--singular-cone-deg: found {cone}, needed 0 to 45 degrees");
        }
        kinematics = kinematics.with_singular_cone_deg(cone);
    }
    let choice = match arguments.branch {
        BranchChoice::Nearest => Choice::Nearest,
        BranchChoice::First => Choice::First,
        BranchChoice::Second => Choice::Second,
    };
    let mut walk = Walk::new(choice, arguments.max_step_deg).map_err(|error| anyhow!("--max-step-deg: {error}"))?;
    if let Some(start) = &arguments.start {
        walk = walk.from_angles(&kinematics, start).map_err(|error| anyhow!("--start: {error}"))?;
    }
    // Rows for which only one solution was written.
    let mut left_out = 0;
    let used: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| kinematics.has(*axis)).collect();
    let columns = COLUMNS.map(|name| Column { name, needed: TOOL_COLUMNS.contains(&name) });
    let mut rows = csv_in::open(&common.input, &columns, "tools")?;
    let is_tool = |name: &String| TOOL_COLUMNS.contains(&name.as_str());
    let ignored: Vec<&str> = rows.header.iter().filter(|name| !is_tool(name)).map(String::as_str).collect();
    if !ignored.is_empty() {
        let (file, names) = (common.input.display(), ignored.join(", "));
        if ignored.len() == 1 {
            report_line(format_args!("note: {file}: column {names} is not read"));
        } else {
            report_line(format_args!("note: {file}: columns {names} are not read"));
        }
    }
    let kept: Vec<bool> = rows.header.iter().map(is_tool).collect();
    let names = rows.header.iter().filter(|name| is_tool(name)).cloned();
    let found = used.iter().map(|axis| AXIS_COLUMNS[axis.index()]).chain([BRANCH, MARGIN, LEFT]).map(str::to_owned);
    let mut sheet = Sheet::new(common, settings, names.chain(found).collect())?;
    while let Some(Row { line, values }) = rows.next()? {
        let [x, y, z, i, j, k, ..] = values;
        let tool = Tool { tip: DVec3::new(x, y, z), axis: DVec3::new(i, j, k) };
        let found = walk.next(&kinematics, &tool).map_err(|error| at_line(&common.input, line, error))?;
        let solutions = match found.both.filter(|_| arguments.both) {
            Some(both) => {
                let both = [both.first, both.second];
                left_out += usize::from(both.iter().any(|s| s.is_err_and(|error| error != InverseError::OneBranch)));
                both.map(Result::ok)
            }
            None => [Some(found.chosen), None],
        };
        for solution in solutions.into_iter().flatten() {
            let positions = used.iter().map(|axis| solution.axes[axis.index()]);
            let more =
                [f64::from(solution.branch as u8), solution.singularity_margin_deg, solution.direction_error_deg];
            let cells = rows.cells().zip(&kept).filter(|(_, kept)| **kept).map(|(cell, _)| cell);
            sheet.row(cells, positions.chain(more))?;
        }
    }
    if left_out > 0 {
        report_line(format_args!(
            "note: {} with one solution only: the other leaves the travel",
            counted(left_out, "row")
        ));
    }
    sheet.finish()
}

/// An error with the line of the file.
fn at_line(file: &Path, line: u32, error: InverseError) -> anyhow::Error {
    let columns = match error {
        InverseError::NotADirection { .. } | InverseError::Unreachable { .. } | InverseError::SingularPose { .. } => {
            "column tool_i, tool_j, tool_k: "
        }
        _ => "",
    };
    anyhow!("{}:{line}: {columns}{error}", file.display())
}
