//! Writes a table file with half the errors of another one: the second tables of the C example.
//!
//! `cargo run -p trueaxis-capi --example halved_tables -- FIRST.tcomp SECOND.tcomp`
use std::error::Error;
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::{Machine, compile};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, to] = &arguments[..] else {
        return Err("two file names are needed".into());
    };
    let bytes = std::fs::read(from)?;
    let mut machine = Machine::from_tcomp(&Tcomp::parse(&bytes)?);
    for row in machine.tables.iter_mut().flatten().flat_map(|table| &mut table.rows) {
        row.forward = row.forward.map(|error| 0.5 * error);
        row.reverse = row.reverse.map(|error| 0.5 * error);
    }
    std::fs::write(to, compile(&machine)?)?;
    Ok(())
}
