//! How far a part can be moved.

use super::Part;
use super::run::parameters;
use anyhow::{Result, anyhow};
use trueaxis::machine::Axis;
use trueaxis_sim::placement::Placement;
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;

/// How far a part can be moved down and up along X, Y and Z until its program leaves the travel, mm.
pub(super) fn room(machine: &Machine, program: &Program, part: &Part) -> Result<[[f64; 2]; 3]> {
    let placement =
        Placement::new(machine, part.at_mm).map_err(|error| anyhow!("{}: {error}", machine.settings.name))?;
    let [low, high] = run(program, &placement);
    Ok([Axis::X, Axis::Y, Axis::Z].map(|axis| {
        let [least, most] = machine.settings.axis(axis).map_or([0.0; 2], |own| own.travel);
        let k = axis.index();
        [(least - low[k]).min(0.0), (most - high[k]).max(0.0)]
    }))
}

/// Lowest and highest commands of X, Y, Z in the program.
fn run(program: &Program, placement: &Placement) -> [[f64; 3]; 2] {
    let mut range = [[f64::MAX; 3], [f64::MIN; 3]];
    for step in &program.moves {
        for u in parameters(step, None, placement) {
            let command = placement.axes(step, u);
            for k in 0..3 {
                range[0][k] = range[0][k].min(command[k]);
                range[1][k] = range[1][k].max(command[k]);
            }
        }
    }
    range
}
