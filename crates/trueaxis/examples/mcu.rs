//! The step on a processor without double precision: no heap, positions in whole nanometres.
use trueaxis::{ConfigError, McuServo, Nanometres, Position, Tcomp};

static TABLES: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/mill-3axis.tcomp"));
const PERIOD_NS: u32 = 250_000; // servo cycles at 4 kHz
const SCALARS: usize = 4100; // at least what `trueaxis tables show` prints for the tables

fn main() -> Result<(), ConfigError> {
    let tables = Tcomp::parse(TABLES).expect("tables in flash are whole");
    let mut memory = [0.0_f32; SCALARS]; // in firmware a static, lent once
    let servo = McuServo::<3>::load(&tables, PERIOD_NS, &mut memory)?;
    let mut state = servo.start();

    let mut largest = 0; // correction of X, nm
    // From here on the servo interrupt.
    for cycle in 0..2000 {
        let command = [Nanometres(20_000_000 + 5_000 * cycle), Nanometres(0), Nanometres::of(-200.0)];
        let input = servo.input(command, command); // readings come from the encoders
        let output = servo.step(&mut state, &input, (), ());
        if output.has_drive() {
            let [x, ..] = output.drive; // command + correction: these positions go to the drives
            largest = largest.max((x.0 - command[0].0).abs());
        }
        assert!(!output.stop_requested(), "{}", output.record.fault);
    }
    assert!(largest > 1_000, "found X corrected by {largest} nm, needed more than a micrometre");
    Ok(())
}
