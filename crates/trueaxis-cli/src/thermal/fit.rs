//! `trueaxis thermal fit`.

use crate::output::{json, print, progress};
use crate::{csv_in, model, report};
use anyhow::Result;
use clap::Args;
use maud::html;
use std::path::PathBuf;
use trueaxis_evaluation::thermal::{COLUMNS, FittedRecording, Recording, residuals, settings, with_rate, written};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  firmware-sim thermal --report out
  trueaxis thermal fit out/record.csv -o thermal.toml";

pub(super) const HELP: &str = "\
RECORD.csv has one row a reading of the instrument, in order of time, with the columns:
  t_s: time
  cycle: number of the duty cycle; at least 3, each uninterrupted
  T1_c … T16_c: sensors, degrees Celsius
  spindle_rpm: speed of the spindle
  ex_um,ey_um,ez_um: drift of the axes that were measured
  x_mm,y_mm,z_mm: axis positions at the measuring point
  tool_mm: length from the spindle's nose to the measuring point
After a rest of 4 h or more the machine counts as in equilibrium. One cycle is held out, or each in turn. Drift is \
of the tool relative to the workpiece, actual − ideal; it is zero where a cycle begins, or wherever the instrument was set to \
zero before it. Two positions of an axis separate its slope from its offset, two lengths tilt from growth. Visit \
several points one after the other, every few minutes. Vary speed, coolant and air from cycle to cycle, so that \
their shares can be separated.

The model:
  e = c + Σ_j [O_j(θ_j) + S_j(θ_j) (q − q0)] + Σ_k x_k (G_k + Θ_k L)
  θ_j' = (T_j − θ_j)/τ_j
  x_k' = (h_k(n) − x_k)/τ
Curves are found by least squares, lags by search. A sensor is included if it makes the cycles predict one another \
better; one that adds nothing to the others is left out. The remaining error is reported for the cycles held out, by \
the task's own code, beside what no model of these sensors predicts: how much cycles differ at the same temperatures.

Refused: sensors that jump (a heated bed passes if it is as fast in other cycles or over several rows), stick or run \
together, records in which nothing moves, rows missing for longer than a lag. Shorter gaps in an otherwise even record are reported.

`trueaxis thermal compile` turns the thermal.toml of -o into a file for the controller.

More examples:
  trueaxis thermal fit warm-up.csv --machine mymill --hold-out 3 --without T7 \\
      -o mymill/thermal.toml";

#[derive(Args)]
pub(crate) struct ThermalFitArgs {
    /// Recorded cycles.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// Machine that states reference temperature and datums [default: 20 °C, 0 mm].
    #[arg(long, value_name = "M")]
    machine: Option<PathBuf>,
    /// Cycles to exclude from the fit; all of them: each in turn, with sensors and lags chosen for all together [default: the
    /// last].
    #[arg(long, value_name = "N,…", value_delimiter = ',')]
    hold_out: Vec<u32>,
    /// Sensors to omit, by name: T3.
    #[arg(long, value_name = "T,…", value_delimiter = ',')]
    without: Vec<String>,
    /// Largest rate at which a sensor warms or cools, K/min; a faster change is refused as a jump. Above 5, it becomes the
    /// rate_k_per_min of the sensors [default: 3, or twice what the sensor shows at another time].
    #[arg(long, value_name = "R")]
    rate_k_per_min: Option<f64>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write thermal.html with the drift measured, computed and remaining into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the result as a thermal.toml.
    #[arg(short, long, value_name = "TOML")]
    output: Option<PathBuf>,
}

pub(super) fn run(arguments: &ThermalFitArgs) -> Result<()> {
    let machine = arguments.machine.as_deref().map(model::machine).transpose()?;
    let inputs = arguments.machine.iter().flat_map(|machine| model::files(machine));
    let mut outputs = Outputs::of(inputs.chain([arguments.record.clone()]));
    if let Some(output) = &arguments.output {
        outputs.refuse_input(output)?;
    }
    let settings = settings(machine.as_ref().map(|machine| &machine.settings), arguments.hold_out.clone());
    let settings = with_rate(settings, arguments.rate_k_per_min)?;
    let recording = Recording::read(csv_in::open(&arguments.record, &COLUMNS, "rows")?, &arguments.without)?;
    let bar = progress(0, "fitting").with_style(indicatif::ProgressStyle::default_spinner());
    let found = FittedRecording::of(recording, &settings, &mut |cause| {
        bar.set_message(format!("fitting: {cause} included"));
        bar.tick();
    });
    bar.finish_and_clear();
    let found = found?;
    let document = found.document();
    if let Some(directory) = &arguments.report {
        let axes = &found.recording.record.axes;
        let figures = [("Remaining drift", html! { @for axis in axes { (residuals(&found, *axis)) } })];
        report::stage(&mut outputs, (directory, "thermal.html"), &arguments.record, &document.shown(&found), figures)?;
    }
    if let Some(output) = &arguments.output {
        outputs.put(output, written(&found).as_bytes())?;
    }
    outputs.commit()?;
    if arguments.json { json(&document) } else { print(&document.shown(&found).text()) }
}
