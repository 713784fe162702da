//! `machine.toml` with its tables, read, checked and compiled like on the command line.

use crate::execution::SLOWEST;
use crate::outcome::{accepted, refused, saw};
use crate::parts::{joined, split};
use crate::{Target, machines, no_repair};
use std::path::Path;
use trueaxis::tcomp::Tcomp;
use trueaxis_evaluation::check::{compiled, findings};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// All files of a machine in one text: the name of each on a separate line between `==` and `==`.
pub const TARGET: Target = Target {
    name: "machine",
    about: "machine.toml with axis tables and grids in CSV: read, checked, compiled",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/machine.dict"),
    slowest: SLOWEST,
};

const RATE_HZ: f64 = 10_000.0;

fn seeds() -> Vec<Vec<u8>> {
    machines::ALL.iter().map(|files| joined(files)).collect()
}

fn run(input: &[u8]) {
    let files = Memory::new(split(input, "machine.toml"));
    let name = Path::new("machine.toml");
    let machine = match Machine::read_from(&files, name, &mut |_| saw("dialect")) {
        Ok(machine) => machine,
        Err(error) => return refused(error),
    };
    match compiled(&machine, &files, name, RATE_HZ) {
        Err(error) => refused(error),
        Ok(bytes) => {
            let known = Uncertainties::read_from(&files, name).expect("compiled, uncertainties included");
            accepted();
            compiles(&machine, &known, &bytes);
        }
    }
}

/// The compiled file loads, agrees with the machine that was read, and can be shown.
fn compiles(machine: &Machine, known: &Uncertainties, bytes: &[u8]) {
    let file = Tcomp::parse(bytes).unwrap_or_else(|error| panic!("compiled, but refused where it is loaded: {error}"));
    let mut again = Machine::from_tcomp(&file);
    for (again, settings) in again.settings.axes.iter_mut().zip(&machine.settings.axes) {
        // The only setting that a compiled file omits.
        again.encoder_resolution = settings.encoder_resolution;
    }
    // A grid is rounded when compiled, and read back rounded.
    for (again, grid) in again.grids.iter_mut().zip(&machine.grids) {
        assert_eq!(again.data(), grid.data());
        *again = grid.clone();
    }
    assert_eq!(again, *machine);
    let found = findings(machine, known, &file, RATE_HZ);
    let texts = found.warnings.iter().map(ToString::to_string).chain([found.summary.to_string()]);
    for text in texts {
        // The machine's name may contain these words.
        let without_name = text.replace(machine.settings.name.as_str(), "");
        assert!(!text.is_empty() && !without_name.contains("NaN") && !without_name.contains("inf "), "{text}");
    }
    for warning in &found.warnings {
        saw(std::mem::discriminant(warning));
    }
}
