//! `firmware-sim replay`: arguments and output.

use crate::console::{put, report_line};
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis::contour::{Path, Span};
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::{FRAME_BYTES, Frame};
use trueaxis::{HostServo, Input};
use trueaxis_recording::{RecordedCycle, Recording};
use trueaxis_sim::SimError;
use trueaxis_sim::servo::{self, Axes, Compiled};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;

const EXAMPLE: &str = "\
Example:
  trueaxis tables compile compensation-tables/mill-3axis -o mill.tcomp
  firmware-sim record --rate-hz 1000 -o run.rec
  firmware-sim replay run.rec mill.tcomp -o run.csv";

const HELP: &str = "\
Compare your own controller with the CSV: given the same commands and readings, it must send the same values. Every \
other host of trueaxis is compared with it too (docs/hosts.md).

The columns are for every axis:
  x_cmd_mm: command
  x_mm: encoder
  x_drive_mm: sent to the drive
and for every cycle:
  elapsed_ns, homed, enable, reset
  encoder_alarm, limited: a bit for every axis
  fault: its code
Rotary axes are in degrees. Numbers are exact.";

/// Arguments of `replay`.
#[derive(Args)]
#[command(before_help = EXAMPLE, after_help = HELP)]
pub(crate) struct ReplayArgs {
    /// Recording of `firmware-sim record`.
    recording: PathBuf,
    /// Compiled tables of the machine that it was recorded on.
    tables: PathBuf,
    /// The CSV [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
    /// The step's records as a controller sends them, for `trueaxis telemetry`.
    #[arg(long, value_name = "FRAMES")]
    telemetry: Option<PathBuf>,
}

pub(crate) fn replay(args: &ReplayArgs) -> Result<()> {
    let mut outputs = Outputs::of([args.recording.clone(), args.tables.clone()]);
    args.output.iter().chain(&args.telemetry).try_for_each(|output| outputs.refuse_input(output))?;
    let read = |path: &PathBuf| std::fs::read(path).with_context(|| path.display().to_string());
    let (recording, bytes) = (read(&args.recording)?, read(&args.tables)?);
    let tables = Tcomp::parse(&bytes).map_err(|error| anyhow!("{}: {error}", args.tables.display()))?;
    let sent = match tables.settings().step_axes().count() {
        3 => rows::<3, 3>(args, &recording, &tables),
        4 => rows::<4, 6>(args, &recording, &tables),
        5 => rows::<5, 6>(args, &recording, &tables),
        _ => rows::<6, 6>(args, &recording, &tables),
    }?;
    if let Some(output) = &args.output {
        outputs.put(output, sent.rows.as_bytes())?;
    }
    if let Some(output) = &args.telemetry {
        outputs.put(output, &sent.frames)?;
    }
    outputs.commit()?;
    for output in args.output.iter().chain(&args.telemetry) {
        report_line(format_args!("written  {}  {}", output.display(), counted(sent.rows.lines().count() - 1, "cycle")));
    }
    if args.output.is_none() { put(&sent.rows) } else { Ok(()) }
}

/// The step's inputs and outputs as CSV rows, and its records as frames.
#[derive(Default)]
struct Sent {
    rows: String,
    frames: Vec<u8>,
}

/// Replays a recording of `N` axes on a step with `SLOTS` slots.
fn rows<const N: usize, const SLOTS: usize>(args: &ReplayArgs, bytes: &[u8], tables: &Tcomp<'_>) -> Result<Sent>
where
    Axes: Compiled<SLOTS>,
{
    let file = args.recording.display();
    let recording = Recording::<N>::parse(bytes).map_err(|error| anyhow!("{file}: {error}"))?;
    let header = recording.header();
    if header.machine_id != tables.machine_id() {
        bail!("{file}: found a recording of another machine than {}, needed one of it", args.tables.display());
    }
    if header.gauge || header.exchange_at.is_some() {
        bail!(
            "{file}: found a recording with a gauge or other tables in motion, needed one without (`firmware-sim compare` has them)"
        );
    }
    let mut sent = Sent::default();
    let text = &mut sent.rows;
    let letters: Vec<_> = tables.settings().step_axes().collect();
    for of in ["_cmd", "", "_drive"] {
        for axis in &letters {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            write!(text, "{}{of}_{unit},", axis.letter().to_ascii_lowercase())?;
        }
    }
    text.push_str("elapsed_ns,homed,enable,reset,encoder_alarm,limited,fault\n");
    let mut memory = vec![0.0; tables.requirement()];
    let servo = Axes::load(tables, header.period_ns, &mut memory).map_err(SimError::from)?;
    run(&recording, &servo, &mut sent)?;
    Ok(sent)
}

fn run<const N: usize, const SLOTS: usize>(
    recording: &Recording<'_, N>,
    servo: &HostServo<'_, SLOTS>,
    sent: &mut Sent,
) -> Result<()>
where
    Axes: Compiled<SLOTS>,
{
    let spans: Vec<Span<f64, f64>> = recording.path().collect();
    let path = Path::new(&spans, 0, false);
    let mut state = servo.start();
    let mut buffer = [0; FRAME_BYTES];
    let text = &mut sent.rows;
    for number in 0..recording.header().cycles {
        let Some(cycle) = recording.cycle(number) else { break };
        let input = in_slots::<N, SLOTS>(&cycle.input::<f64>());
        let output = servo::step(servo, &mut state, &input, &mut path.on(cycle.place::<f64>()), &mut ());
        for value in [input.command, input.feedback, output.drive].iter().flat_map(|slots| &slots[..N]) {
            write!(text, "{value},")?;
        }
        let mut frame = Frame::of(&output.record);
        frame.axes.truncate(N);
        sent.frames.extend_from_slice(frame.encode(&mut buffer).context("a record that fits no frame")?);
        let RecordedCycle { elapsed_ns, homed, enable, reset, encoder_alarm, .. } = cycle;
        let [homed, enable, reset] = [homed, enable, reset].map(u8::from);
        let (limited, fault) = (output.record.limited, u8::from(output.record.fault));
        writeln!(text, "{elapsed_ns},{homed},{enable},{reset},{encoder_alarm},{limited},{fault}")?;
    }
    Ok(())
}

/// The input of a step that has spare slots.
fn in_slots<const N: usize, const SLOTS: usize>(input: &Input<f64, N>) -> Input<f64, SLOTS> {
    let mut wide = Input::at_rest(input.elapsed_ns);
    wide.command[..N].copy_from_slice(&input.command);
    wide.feedback[..N].copy_from_slice(&input.feedback);
    let Input { command: _, feedback: _, encoder_alarm, elapsed_ns, homed, enable, reset, refusal, dynamics, learned } =
        *input;
    Input { encoder_alarm, elapsed_ns, homed, enable, reset, refusal, dynamics, learned, ..wide }
}
