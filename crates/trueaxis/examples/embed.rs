//! The plugin in a controller: tables in, corrected positions out.
use trueaxis::compensation::Storage;
use trueaxis::contour::{Path, Reference};
use trueaxis::{Config, Input, tcomp::Tcomp};

const TABLES: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/mill-3axis.tcomp"));

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let tables = Tcomp::parse(TABLES)?; // any damage is refused
    let (mut lines, mut knots, mut guide) = ([0.0; 6144], [0.0; 256], [0; 512]);
    let memory = Storage { lines: &mut lines, knots: &mut knots, guide: &mut guide };
    let servo = Config::of(&tables, 100_000).build::<f64, f64, 3, _>(|axis| tables.table(axis), memory)?;
    let mut state = servo.start(100_000).map_err(|fault| format!("{fault:?}"))?;
    let path = Path::new(&[], 0, false); // what the interpolator follows, as spans

    // From here on the servo interrupt:
    let command = [12.5, -30.0, -200.0];
    let input = Input { command, feedback: command, homed: true, enable: true, ..Input::at_rest(100_000) };
    let output = servo.step(&mut state, &input, path.on(Reference::default()), ());
    assert_eq!(output.drive, command); // the first cycle never moves; then the correction is led in
    assert!(!output.stop_requested());
    Ok(())
}
