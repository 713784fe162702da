//! Recordings of a LinuxCNC machine that trueaxis corrects: compared with the library sample by sample, and drawn.

mod plot;
mod recording;
mod replay;

use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// What to do with a recording.
#[derive(Debug, Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Runs the recorded commands and readings through the library and compares the drives' commands.
    Replay {
        /// Compiled tables that the component had in force.
        tables: PathBuf,
        /// RECORDING.json and RECORDING.f64.
        recording: PathBuf,
        /// Axis of joint 0, 1, …
        #[arg(long)]
        joints: String,
        /// Name of the component's instance.
        #[arg(long, default_value = "ta")]
        instance: String,
        /// Servo period.
        #[arg(long, default_value_t = 1_000_000)]
        period_ns: u32,
        /// Largest difference that is still agreement, mm (deg).
        #[arg(long, default_value_t = 1e-12)]
        within: f64,
    },
    /// Draws pins over time, as an oscilloscope shows them.
    Plot {
        /// RECORDING.json and RECORDING.f64.
        recording: PathBuf,
        /// The SVG to write.
        out: PathBuf,
        /// A panel: "UNIT*SCALE; LABEL = PIN; LABEL = PIN - PIN".
        #[arg(long = "panel", required = true)]
        panels: Vec<String>,
        /// Start, s.
        #[arg(long, default_value_t = 0.0)]
        from_s: f64,
        /// End, s.
        #[arg(long, default_value_t = f64::MAX)]
        to_s: f64,
        /// Servo period.
        #[arg(long, default_value_t = 1_000_000)]
        period_ns: u32,
    },
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().what {
        What::Replay { tables, recording, joints, instance, period_ns, within } => {
            let bytes = std::fs::read(&tables)?;
            let recording = recording::Recording::load(&recording)?;
            let agreement = replay::replay(&bytes, &recording, &joints, &instance, period_ns)?;
            println!("{}", serde_json::to_string(&agreement)?);
            anyhow::ensure!(agreement.largest_difference <= within, "the recording differs from the library");
            Ok(())
        }
        What::Plot { recording, out, panels, from_s, to_s, period_ns } => {
            let recording = recording::Recording::load(&recording)?;
            plot::plot(&recording, &panels, from_s, to_s, period_ns, &out)
        }
    }
}
