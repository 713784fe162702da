//! Rate at which setpoints are generated: `cargo run --release -p trueaxis-sim --example setpoint_rate`.

use std::time::Instant;

use trueaxis_sim::motion::{Motion, MotionError, MotionSettings};
use trueaxis_sim::program::{BUILTIN_NAMES, Program};

fn main() -> Result<(), MotionError> {
    for program in BUILTIN_NAMES.iter().filter_map(|name| Program::builtin(name)?.ok()) {
        let start = Instant::now();
        let motion = Motion::plan(&program, MotionSettings::default())?;
        let planned = start.elapsed();
        let start = Instant::now();
        let sum: f64 = motion.setpoints(&program).map(|point| point.position[0]).sum();
        let rate = motion.cycles() as f64 / start.elapsed().as_secs_f64() / 1e6;
        println!(
            "{}: {:.1} mm, {:.2} s, planned in {:.1} ms, {rate:.1} million setpoints a second (check sum {sum:.3})",
            program.name,
            motion.length(),
            motion.duration(),
            planned.as_secs_f64() * 1e3
        );
    }
    Ok(())
}
