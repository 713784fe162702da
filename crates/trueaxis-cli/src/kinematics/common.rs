//! Arguments and columns shared by both directions.

use crate::numbers::triple;
use anyhow::{Result, anyhow};
use clap::Args;
use std::path::PathBuf;
use trueaxis::glam::DVec3;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::{AXES, MachineSettings};

#[derive(Args)]
pub(crate) struct Common {
    /// machine.toml, its folder, or a compiled .tcomp.
    #[arg(long, value_name = "M")]
    pub(super) machine: PathBuf,
    /// Axis positions (forward) or tools (inverse).
    #[arg(value_name = "IN.csv")]
    pub(super) input: PathBuf,
    /// A tool on the tool axis: distance from its tip to the origin of the last tool-side frame (on a swivelling head the
    /// pivot length), mm [default: the machine's tool_mm].
    #[arg(long, value_name = "L", conflicts_with = "tool_mm", help_heading = "Tool")]
    pub(super) tool_length_mm: Option<f64>,
    /// Tip from the last tool-side frame at all axes zero, mm [default: the machine's tool_mm].
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "Tool")]
    pub(super) tool_mm: Option<[f64; 3]>,
    /// Print one JSON document.
    #[arg(long)]
    pub(super) json: bool,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    pub(super) output: Option<PathBuf>,
}

pub(super) const AXIS_COLUMNS: [&str; AXES] = ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"];
pub(super) const TOOL_COLUMNS: [&str; 6] = ["tip_x_mm", "tip_y_mm", "tip_z_mm", "tool_i", "tool_j", "tool_k"];
pub(super) const MARGIN: &str = "singularity_margin_deg";
pub(super) const LEFT: &str = "direction_error_deg";
pub(super) const BRANCH: &str = "branch";

/// The machine with the requested tool.
pub(super) fn kinematics(common: &Common, settings: &MachineSettings) -> Result<Kinematics<f64>> {
    let kinematics =
        Kinematics::<f64>::new(settings).map_err(|error| anyhow!("{}: {error}", common.machine.display()))?;
    let finite = |name: &str, value: f64| {
        if value.is_finite() && value.abs() <= 1e6 {
            Ok(value)
        } else {
            Err(anyhow!("{name}: found {value}, needed a finite number of at most 1e6 mm"))
        }
    };
    Ok(match (common.tool_mm, common.tool_length_mm) {
        (Some(tool), _) => {
            for value in tool {
                finite("--tool-mm", value)?;
            }
            kinematics.with_tool(DVec3::from(tool))
        }
        (None, Some(length)) => kinematics.with_tool_length(finite("--tool-length-mm", length)?),
        (None, None) => kinematics,
    })
}
