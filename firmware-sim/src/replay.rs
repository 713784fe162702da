//! `firmware-sim replay`: its arguments and output.

use crate::console::{put, tell};
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis::contour::{Path, Span};
use trueaxis::tcomp::Tcomp;
use trueaxis::{HostServo, ServoLoop};
use trueaxis_recording::{Cycle, Recording};
use trueaxis_sim::servo::with_tables;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;

/// Arguments of `replay`.
#[derive(Args)]
#[command(after_help = "Examples:
  trueaxis tables compile mill -o mill.tcomp
  firmware-sim record --machine mill --rate-hz 1000 -o run.rec
  firmware-sim replay run.rec mill.tcomp -o run.csv       what the step was given and what it sent, cycle by cycle

Columns, for every axis: x_cmd_mm (command), x_mm (encoder), x_drive_mm (sent to the drive), and for every cycle elapsed_ns,
homed, enable, reset, encoder_alarm and limited (a bit for every axis) and fault (its code). Rotary axes in degrees. Numbers have the
digits that say them exactly: a controller of your own that is given the commands and the readings must send these.")]
pub(crate) struct ReplayArgs {
    /// The recording, of `firmware-sim record`.
    recording: PathBuf,
    /// Compiled tables of the machine that it was recorded on.
    tables: PathBuf,
    /// The CSV [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

pub(crate) fn replay(args: &ReplayArgs) -> Result<()> {
    let mut outputs = Outputs::of([args.recording.clone(), args.tables.clone()]);
    if let Some(output) = &args.output {
        outputs.refuse_input(output)?;
    }
    let read = |path: &PathBuf| std::fs::read(path).with_context(|| path.display().to_string());
    let (recording, bytes) = (read(&args.recording)?, read(&args.tables)?);
    let tables = Tcomp::parse(&bytes).map_err(|error| anyhow!("{}: {error}", args.tables.display()))?;
    let rows = match tables.settings().step_axes().count() {
        3 => rows::<3>(args, &recording, &tables),
        4 => rows::<4>(args, &recording, &tables),
        5 => rows::<5>(args, &recording, &tables),
        _ => rows::<6>(args, &recording, &tables),
    }?;
    match &args.output {
        None => put(&rows),
        Some(output) => {
            outputs.put(output, rows.as_bytes())?;
            outputs.commit()?;
            tell(format_args!("written  {}  {}", output.display(), counted(rows.lines().count() - 1, "cycle")));
            Ok(())
        }
    }
}

fn rows<const N: usize>(args: &ReplayArgs, bytes: &[u8], tables: &Tcomp<'_>) -> Result<String> {
    let file = args.recording.display();
    let recording = Recording::<N>::parse(bytes).map_err(|error| anyhow!("{file}: {error}"))?;
    let header = recording.header();
    if header.machine_id != tables.machine_id() {
        bail!("{file}: found a recording of another machine than {}, needed one of it", args.tables.display());
    }
    if header.gauge || header.exchange_at.is_some() {
        bail!("{file}: found a recording with a gauge or other tables in motion, needed one without (`firmware-sim compare` has them)");
    }
    let mut text = String::new();
    let letters: Vec<_> = tables.settings().step_axes().collect();
    for of in ["_cmd", "", "_drive"] {
        for axis in &letters {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            write!(text, "{}{of}_{unit},", axis.letter().to_ascii_lowercase())?;
        }
    }
    text.push_str("elapsed_ns,homed,enable,reset,encoder_alarm,limited,fault\n");
    with_tables(tables, header.period_ns, |servo: &ServoLoop<'_, f64, f64, N>| run(&recording, servo, &mut text))?;
    Ok(text)
}

fn run<const N: usize>(recording: &Recording<'_, N>, servo: &HostServo<'_, N>, text: &mut String) -> Result<()> {
    let spans: Vec<Span<f64, f64>> = recording.path().collect();
    let path = Path::new(&spans, 0, false);
    let mut state = servo.start();
    for number in 0..recording.header().cycles {
        let Some(cycle) = recording.cycle(number) else { break };
        let input = cycle.input::<f64>();
        let output = servo.step(&mut state, &input, path.on(cycle.place::<f64>()), ());
        for value in input.command.iter().chain(&input.feedback).chain(&output.drive) {
            write!(text, "{value},")?;
        }
        let Cycle { elapsed_ns, homed, enable, reset, encoder_alarm, .. } = cycle;
        let [homed, enable, reset] = [homed, enable, reset].map(u8::from);
        let (limited, fault) = (output.record.limited, u8::from(output.record.fault));
        writeln!(text, "{elapsed_ns},{homed},{enable},{reset},{encoder_alarm},{limited},{fault}")?;
    }
    Ok(())
}
