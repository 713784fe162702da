//! `trueaxis roundness`.

use crate::csv_in;
use crate::numbers::triple;
use crate::output::{Writer, json, progress, report_line};
use crate::probes::ProbeArgs;
use crate::report;
use anyhow::Result;
use clap::Args;
use maud::Render;
use std::path::PathBuf;
use trueaxis_evaluation::probes::Probes;
use trueaxis_evaluation::roundness::{COLUMNS, Plan, Readings, Request, orbit, polar};
use trueaxis_metrology::separation::{NOISE_GAIN_LIMIT, Separation};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis roundness tests/reference/separation_probes.csv --n 64 \\
      --phi2-deg 66.1 --phi3-deg 125.4 --harmonics 2..12 --arm 60,300,30
  trueaxis roundness tests/reference/separation_five_probes.csv --n 64 \\
      --angles-deg 0,39.2,101.3,158.9,243.3 --harmonics 2..12 \\
      --arm 60,300,30 --json";

pub(crate) const HELP: &str = "\
PROBES.csv has the columns h1_um,h2_um,h3_um and whole revolutions of N rows, equidistant in θ, the angle over the \
part's surface, from 0:
  h1 = r(θ) + RY cos β + RX sin β
Probe 2 is φ2 further in the sense of θ, probe 3 φ2 + φ3. Without --arm β is 0. With --angles-deg the columns are h1_um \
to h4_um, h5_um or h6_um. More than three probes add less noise, and contradict one another if one is wrong: five or six \
name it, and the errors of their angles and sensitivities are stated against probe 1 (--json and --report).
With a column theta_deg the file may have any number of rows at any increasing angles; the angle may restart every \
360°. The readings are then resampled to N a revolution, and the interpolation error is stated (in JSON: \
resampling).

OUT.csv has the columns theta_deg,r_um,rx_um,ry_um of all revolutions: the profile (high is above 0; before --upr), \
and the motion of the centre across and along the direction of probe 1.

Zones are peak to valley (LSC, MZC, MIC, MCC of ISO 12181-1) of the profile averaged over the revolutions, after \
--upr. Harmonic k is A cos(k θ + phase). The mean and the first harmonic are motion of the centre and not in the \
profile. Spindle error motion is given after ISO 230-7, with the once-per-revolution part separate.

With N = 1024 and harmonics 2..100 the published angles (90°, 181.05° and 60.82°, 240.12°) let noise grow 19 times \
in the worst harmonic, the slots p 188, q 667 (66.094°, 234.492°) 3.1 times: see `trueaxis probe-angles --help`.";

#[derive(Args)]
pub(crate) struct RoundnessArgs {
    /// Readings of the probes, µm.
    #[arg(value_name = "PROBES.csv")]
    readings: PathBuf,
    #[command(flatten)]
    probes: ProbeArgs,
    /// Angles of three to six probes from probe 1, in the sense of θ, instead of a pair: the readings of all of them are used by
    /// least squares.
    #[arg(
        long,
        value_name = "DEG,DEG,DEG…",
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with_all = ["p", "q", "phi2_deg", "phi3_deg"],
        help_heading = "Probes"
    )]
    angles_deg: Option<Vec<f64>>,
    /// Crank throw, wheel radius and pin radius, mm, of an arm that follows the pin [default: a fixed arm].
    #[arg(long, value_name = "R,RS,RW", value_parser = arm, allow_hyphen_values = true, help_heading = "Probes")]
    arm: Option<Lengths>,
    /// Cut-off of the Gaussian filter in undulations per revolution: 15, 50, 150 or 500 [default: no filter].
    #[arg(long, value_name = "UPR")]
    upr: Option<u16>,
    /// Noise gain above which a harmonic is suppressed and marked.
    #[arg(long, value_name = "GAIN", default_value_t = NOISE_GAIN_LIMIT, allow_negative_numbers = true)]
    noise_gain_limit: f64,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
    /// Write roundness.html with figures into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Profile and motion of the centre [default: standard output, unless --json].
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

/// Crank throw, wheel radius, pin radius, mm.
type Lengths = [f64; 3];

fn arm(text: &str) -> Result<Lengths, String> {
    triple(text).map_err(|_| "needed three lengths R,RS,RW in mm, as in 60,300,30".to_owned())
}

pub(crate) fn run(arguments: &RoundnessArgs) -> Result<()> {
    let plan = arguments.asked().plan()?;
    let mut rows = csv_in::open(&arguments.readings, &COLUMNS, "readings")?;
    let readings = plan.read(&mut rows)?;
    if let Some(note) = readings.note(plan.points()) {
        report_line(format_args!("note: {note}"));
    }
    let separations = separate(&plan, &readings)?;
    // Only the document and the page show circles, harmonics and motion.
    let evaluation =
        (arguments.json || arguments.report.is_some()).then(|| plan.evaluate(&separations, &readings)).transpose()?;
    let warnings = match &evaluation {
        Some(evaluation) => evaluation.document.warnings.clone(),
        None => plan.warnings(&separations, &readings)?,
    };
    for warning in warnings {
        report_line(format_args!("warning: {warning}"));
    }
    let mut outputs = Outputs::of([&arguments.readings]);
    if let (Some(directory), Some(evaluation)) = (&arguments.report, &evaluation) {
        let figures = [("Profile", polar(evaluation, [true; 4]).render()), ("Spindle", orbit(evaluation).render())];
        let shown = plan.shown(evaluation);
        report::stage(&mut outputs, (directory, "roundness.html"), &arguments.readings, &shown, figures)?;
    }
    if arguments.output.is_some() || !arguments.json {
        let writer = Writer::new(arguments.output.as_deref(), [arguments.readings.clone()])?;
        write(&separations, plan.points(), writer)?;
    }
    outputs.commit()?;
    match &evaluation {
        Some(evaluation) if arguments.json => json(&evaluation.document),
        _ => Ok(()),
    }
}

impl RoundnessArgs {
    fn asked(&self) -> Request {
        let RoundnessArgs { arm, upr, noise_gain_limit, .. } = *self;
        let probes = Probes { angles_deg: self.angles_deg.clone(), ..self.probes.asked() };
        Request { probes, arm, upr, noise_gain_limit }
    }
}

fn separate(plan: &Plan, readings: &Readings) -> Result<Vec<Separation>> {
    let bar = progress(readings.probes.first().map_or(0, |probe| probe.len() / plan.points()) as u64, "revolutions");
    let separations = plan.separate(readings, || bar.inc(1));
    bar.finish_and_clear();
    separations
}

fn write(separations: &[Separation], points: usize, mut out: Writer<'_>) -> Result<()> {
    out.put(format_args!("theta_deg,r_um,rx_um,ry_um\n"))?;
    for parts in separations {
        for (i, ((r, x), y)) in parts.profile.iter().zip(&parts.x).zip(&parts.y).enumerate() {
            out.put(format_args!("{},{r},{x},{y}\n", 360.0 * i as f64 / points as f64))?;
        }
    }
    out.finish()
}
