//! `trueaxis kinematics inverse`: from the tool to axis positions.

use super::common::{AXIS_COLUMNS, BRANCH, Common, MARGIN, TOOL_COLUMNS, kinematics};
use super::sheet::Sheet;

use crate::csv_in::{self, Column, Row};
use crate::numbers::{Numbers, numbers};
use crate::output::tell;
use anyhow::{Result, anyhow, bail};
use clap::{Args, ValueEnum};
use std::path::Path;
use trueaxis::Axis;
use trueaxis::glam::DVec3;
use trueaxis::kinematics::{BranchTracker, Choice, InverseError, Kinematics, Solution, Tool};
use trueaxis::machine::{AXES, MachineSettings};
use trueaxis_tables::text::counted;

/// One of two poses of the rotary axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BranchChoice {
    /// The one nearer to the row before.
    Nearest,
    /// The rotary axis nearest the tool turns it right-handed, 0 … 180 degrees, from where it is nearest to the other axis.
    #[value(name = "1")]
    First,
    /// The other one.
    #[value(name = "2")]
    Second,
}

#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) common: Common,
    /// Pose of the rotary axes.
    #[arg(long, value_enum, default_value = "nearest")]
    branch: BranchChoice,
    /// Both poses, two rows each.
    #[arg(long, conflicts_with_all = ["branch", "max_step_deg"])]
    both: bool,
    /// Angles of the machine's rotary axes before the first row, in the order A, B, C, degrees [default: zero].
    #[arg(long, value_name = "DEG,…", value_parser = numbers, allow_hyphen_values = true)]
    start: Option<Numbers>,
    /// Refuse a tool nearer than this to the singular pose, 0 … 45 degrees [default: the machine's].
    #[arg(long, value_name = "D")]
    singular_cone_deg: Option<f64>,
    /// Refuse a change of branch, and a step of a rotary axis above this, from row to row.
    #[arg(long, value_name = "DEG")]
    max_step_deg: Option<f64>,
}

/// Columns of the input: the tool, then what a forward or an inverse result has besides.
const COLUMNS: [&str; 14] = {
    let [x, y, z, i, j, k] = TOOL_COLUMNS;
    let [qx, qy, qz, a, b, c] = AXIS_COLUMNS;
    [x, y, z, i, j, k, qx, qy, qz, a, b, c, BRANCH, MARGIN]
};

pub(super) fn run(arguments: &Arguments, settings: &MachineSettings) -> Result<()> {
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
    let columns = COLUMNS.map(|name| Column { name, needed: TOOL_COLUMNS.contains(&name) });
    let mut rows = csv_in::open(&common.input, &columns, "tools")?;
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
        let found = walk.solve(arguments, &kinematics, &tool).map_err(|error| at_line(&common.input, line, error))?;
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

/// Angles of the rotary axes before the first row.
fn start(arguments: &Arguments, used: &[Axis]) -> Result<[f64; AXES]> {
    let mut near = [0.0; AXES];
    let Some(start) = &arguments.start else { return Ok(near) };
    let rotary: Vec<Axis> = used.iter().copied().filter(|axis| axis.is_rotary()).collect();
    if rotary.len() != start.len() {
        let letters: String = rotary.iter().map(|axis| axis.letter()).collect();
        bail!("--start: found {} angles, needed one for each rotary axis ({letters})", start.len());
    }
    for (axis, angle) in rotary.into_iter().zip(start) {
        if angle.abs() > 1e6 {
            bail!("--start: found {angle}, needed an angle of at most 1e6 degrees");
        }
        near[axis.index()] = *angle;
    }
    Ok(near)
}

/// Solutions from row to row.
struct Walk {
    near: [f64; AXES],
    follow: Option<BranchTracker<f64>>,
    /// Rows of which only one solution was given.
    left_out: usize,
}

impl Walk {
    fn solve(
        &mut self,
        arguments: &Arguments,
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

/// An error at its line of the file.
fn at_line(file: &Path, line: u32, error: InverseError) -> anyhow::Error {
    let columns = match error {
        InverseError::NotADirection { .. } | InverseError::Unreachable { .. } | InverseError::SingularPose { .. } => {
            "column tool_i, tool_j, tool_k: "
        }
        _ => "",
    };
    anyhow!("{}:{line}: {columns}{error}", file.display())
}
