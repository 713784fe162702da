//! The plugin in a controller: tables in, corrected positions out.
use trueaxis::{HostPath, HostServo, Tcomp};

const TABLES: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/mill-3axis.tcomp"));
const PERIOD_NS: u32 = 100_000; // servo cycles at 10 kHz

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let tables = Tcomp::parse(TABLES)?; // any damage is refused
    let mut memory = vec![0.0; tables.requirement()]; // on bare metal an array; `trueaxis tables show` prints its size
    let servo = HostServo::<3>::load(&tables, PERIOD_NS, &mut memory)?;
    let mut state = servo.start();

    let mut path = HostPath::<16>::new(); // the interpolator's segments, in at most 16 spans
    let [a, b, c, d] = [[0.0, 0.0, -200.0], [20.0, 0.0, -200.0], [30.0, 10.0, -200.0], [30.0, 30.0, -200.0]];
    path.line(a, b)?;
    path.arc(b, c, [20.0, 10.0, -200.0], [0.0, 0.0, 1.0])?;
    path.nurbs(2, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &[c, [30.0, 20.0, -200.0], d].map(Into::into), &[])?;

    let mut largest = 0.0_f64; // correction of X, mm
    for (segment, u) in (0..3).flat_map(|segment| (0..1000).map(move |i| (segment, f64::from(i) / 1000.0))) {
        let on_path = path.at(segment, u);
        let command = on_path.position().ok_or("the path has ended")?; // readings come from the encoders
        let output = servo.step(&mut state, &servo.input(command, command), on_path, ());
        assert!(!output.stop_requested(), "{}", output.record.fault);
        if output.has_drive() {
            let [x, ..] = output.drive; // command + correction: these positions go to the drives
            largest = largest.max((x - command[0]).abs());
        }
    }
    assert!(largest > 0.001, "found X corrected by {largest} mm, needed more than a micrometre");
    Ok(())
}
