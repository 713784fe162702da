//! `trueaxis kinematics`.

mod common;
mod forward;
mod inverse;
mod sheet;

use crate::model;
use anyhow::Result;
use clap::Subcommand;
use common::Common;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis kinematics forward --machine compensation-tables/mill-5axis \\
      records/axes.csv";

const INVERSE: &str = "\
Example:
  trueaxis kinematics forward --machine compensation-tables/mill-5axis \\
      records/axes.csv -o tool.csv
  trueaxis kinematics inverse --machine compensation-tables/mill-5axis \\
      tool.csv";

const HELP: &str = "\
The tool's tip and axis (unit vector from the tip to the spindle) are in workpiece coordinates. At all axes zero \
these are parallel to the machine's, and the tip is at tool_mm plus the tool-side axes' offset_mm minus the \
workpiece-side ones'. A machine has X, Y, Z and up to two of A, B, C, each on either side of its structural code. It \
needs no error table.

forward reads axis positions and adds the tool:
  IN.csv: x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg] in any order, 0 where absent
  adds: tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k,
        singularity_margin_deg
inverse reads the tool and adds axis positions:
  IN.csv: tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k
  adds: x_mm,y_mm,z_mm and the rotary axes (a_deg, …),
        branch,singularity_margin_deg,direction_error_deg

singularity_margin_deg is the angle between the tool and the rotary axis nearest the workpiece (in the code); 90 on \
machines with fewer than two rotary axes. Below the machine's singular_cone_deg that axis is held, or guided to the \
angle at which it leaves. direction_error_deg is then the angle between the tool reached and the one asked for; \
elsewhere it is 0.";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Convert axis positions to the tool in workpiece coordinates.
    #[command(before_help = EXAMPLE, after_help = HELP)]
    Forward(Common),
    /// Convert the tool in workpiece coordinates to axis positions.
    #[command(before_help = INVERSE, after_help = HELP)]
    Inverse(inverse::InverseArgs),
}

pub(crate) fn run(command: Command) -> Result<()> {
    match command {
        Command::Forward(common) => {
            let settings = model::machine(&common.machine)?.settings;
            forward::run(&common, &settings)
        }
        Command::Inverse(arguments) => {
            let settings = model::machine(&arguments.common.machine)?.settings;
            inverse::run(&arguments, &settings)
        }
    }
}
