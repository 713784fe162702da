//! `trueaxis kinematics`.

mod common;
mod forward;
mod inverse;
mod sheet;

use crate::model;
use anyhow::Result;
use clap::Subcommand;
use common::Common;

pub(crate) const HELP: &str = "\
The tool's tip and axis (unit vector from the tip to the spindle) are in workpiece coordinates, which at all axes zero
coincide with the machine's. A machine has X, Y, Z and up to two of A, B, C, each on either side of its structural code.

  forward  IN.csv: x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg], axes of the machine in any order, 0 where absent
           out: the same + tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k,singularity_margin_deg
  inverse  IN.csv: tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k
           out: the same + x_mm,y_mm,z_mm, the rotary axes (a_deg, …), branch, singularity_margin_deg,
           direction_error_deg

singularity_margin_deg: angle between the tool and the rotary axis nearest the workpiece (in the code). Below the machine's
singular_cone_deg that axis is held, or guided to the angle at which it leaves, and direction_error_deg is the angle between the
tool reached and the one asked for; elsewhere 0. 90 on machines with less than two rotary axes.

Example: trueaxis kinematics forward --machine compensation-tables/mill-5axis axes.csv -o tool.csv
         trueaxis kinematics inverse --machine compensation-tables/mill-5axis tool.csv";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Convert axis positions to the tool in workpiece coordinates.
    #[command(after_help = HELP)]
    Forward(Common),
    /// Convert the tool in workpiece coordinates to axis positions.
    #[command(after_help = HELP)]
    Inverse(inverse::Arguments),
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
