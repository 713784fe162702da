//! A machine that takes little work: three lines of errors along X.

use trueaxis::machine::{AXES, Row};
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::machine;

/// Travel of every axis, mm (deg), to either side.
pub const TRAVEL: f64 = 400.0;

/// The machine of a structural code, with errors of a few µm and µrad that differ in negative travel.
pub fn machine(chain: &str) -> Machine {
    let row = |(position, error): (f64, f64)| {
        let forward = [error, -0.5 * error, 0.3 * error, 1e-3 * error, 0.0, -1e-3 * error];
        Row { position, forward, reverse: forward.map(|error| 0.9 * error) }
    };
    let rows = [(-TRAVEL, -0.01), (0.0, 0.0), (TRAVEL, 0.02)].map(row).to_vec();
    let settings = machine::Machine::new(chain).name("small").travel([-TRAVEL, TRAVEL], 1.0).hysteresis(0.005);
    let settings = settings.settings();
    let mut tables = vec![None; settings.axes.len()];
    tables[0] = Some(Table { given: [true; AXES], bidirectional: true, rows });
    Machine { settings, tables, grids: Vec::new() }
}
