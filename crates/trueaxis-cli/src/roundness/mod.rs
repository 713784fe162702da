//! `trueaxis roundness`.

pub(crate) mod evaluation;
mod trace;

use crate::csv_in::{self, Column, Row};
use crate::numbers::triple;
use crate::output::{Writer, json, progress, tell};
use crate::probes::ProbeArguments;
use crate::report;
use anyhow::{Result, anyhow, bail};
use clap::Args;
use evaluation::Evaluation;
use rayon::prelude::*;
use std::path::PathBuf;
use trace::{InterpolationError, Resampling};
use trueaxis::error::Field;
use trueaxis::roundness::filter;
use trueaxis::roundness::{Arm, Band};
use trueaxis_metrology::separation::{NOISE_GAIN_LIMIT, Separation, Separator};
use trueaxis_tables::error::FileError;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;

pub(crate) const HELP: &str = "\
PROBES.csv: h1_um,h2_um,h3_um, whole revolutions of N rows, equidistant in θ (the angle over the part's surface) from 0.
    With a column theta_deg, any number of rows at any increasing angles: they are resampled to N a revolution, and the
    interpolation error is stated (here and in JSON, resampling). The angle may begin anew every 360°.
    h1 = r(θ) + RY cos β + RX sin β; probe 2 stands φ2, probe 3 φ2 + φ3 further in the sense of θ. β = 0 without --arm.
OUT.csv: theta_deg,r_um,rx_um,ry_um, all revolutions: profile (high is above 0, before --upr), motion of the centre across
    and along the direction of probe 1.
Zones (peak to valley; LSC, MZC, MIC, MCC of ISO 12181-1) are of the profile averaged over the revolutions, after --upr.
Harmonic k of the table: A cos(k θ + phase). Mean and first harmonic are motion of the centre and not in the profile.
Spindle error motion after ISO 230-7, the once-per-revolution part apart.

N = 1024, harmonics 2..100: the published angles (90°, 181.05°) and (60.82°, 240.12°) let noise grow 19 times in the worst
harmonic, the slots p 188, q 667 (66.094°, 234.492°) 3.1 times; see `trueaxis probe-angles --help`.

Example: trueaxis roundness probes.csv --n 1024 --p 188 --q 667 --arm 60,300,30 --upr 50 --report out -o r.csv";

#[derive(Args)]
pub(crate) struct Arguments {
    /// Readings of the three probes, µm.
    #[arg(value_name = "PROBES.csv")]
    readings: PathBuf,
    #[command(flatten)]
    probes: ProbeArguments,
    /// Crank throw, wheel radius and pin radius, mm, of an arm that follows the pin [default: it stands still].
    #[arg(long, value_name = "R,RS,RW", value_parser = arm, allow_hyphen_values = true)]
    arm: Option<Arm>,
    /// Cut-off of the Gaussian filter in undulations per revolution: 15, 50, 150 or 500 [default: no filter].
    #[arg(long, value_name = "UPR")]
    upr: Option<u16>,
    /// Harmonics whose noise gain is above this are left out and marked.
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

fn arm(text: &str) -> Result<Arm, String> {
    let [crank_mm, wheel_mm, pin_mm] =
        triple(text).map_err(|_| "needed three lengths R,RS,RW in mm, as in 60,300,30".to_owned())?;
    Ok(Arm { crank_mm, wheel_mm, pin_mm })
}

const COLUMNS: [Column; 4] = [
    Column { name: "h1_um", needed: true },
    Column { name: "h2_um", needed: true },
    Column { name: "h3_um", needed: true },
    Column { name: "theta_deg", needed: false },
];

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let (points, band) = (arguments.probes.points()?, arguments.probes.band()?);
    let separator = separator(arguments, band)?;
    if let Some(cut_off) = arguments.upr {
        filter::check(cut_off).map_err(|error| anyhow!("--upr: found {cut_off}, needed {}", error.needed))?;
    }
    let (probes, resampling) = read(arguments, points, band)?;
    let separations = separate(&separator, &probes)?;
    let warnings = warnings(arguments, &separator, points, band);
    for warning in &warnings {
        tell(format_args!("warning: {warning}"));
    }
    // Circles, harmonics and motion are nowhere but in the document and on the page.
    let evaluation = if arguments.json || arguments.report.is_some() {
        let mut evaluation = Evaluation::new(&separator, &separations, arguments.upr)?;
        (evaluation.document.resampling, evaluation.document.warnings) = (resampling, warnings);
        Some(evaluation)
    } else {
        None
    };
    let mut outputs = Outputs::of([&arguments.readings]);
    if let (Some(directory), Some(evaluation)) = (&arguments.report, &evaluation) {
        let source = arguments.readings.file_name().unwrap_or_default().to_string_lossy();
        let page = report::roundness::page(&source, evaluation, separator.gain(), arguments.noise_gain_limit);
        report::write(&mut outputs, &page, directory, "roundness.html")?;
    }
    if arguments.output.is_some() || !arguments.json {
        let writer = Writer::new(arguments.output.as_deref(), [arguments.readings.clone()])?;
        write(&separations, points, writer)?;
    }
    outputs.commit()?;
    match &evaluation {
        Some(evaluation) if arguments.json => json(&evaluation.document),
        _ => Ok(()),
    }
}

fn separator(arguments: &Arguments, band: Band) -> Result<Separator> {
    let ratio = match &arguments.arm {
        None => 0.0,
        Some(arm) => arm.ratio().map_err(|error| {
            let name = match error.field {
                Field::ArmWheel => "RS",
                Field::ArmPin => "RW",
                _ => "R",
            };
            anyhow!("--arm {name}: found {} mm, needed {}", error.found, error.needed)
        })?,
    };
    let limit = arguments.noise_gain_limit;
    if !(limit.is_finite() && limit > 0.0) {
        bail!("--noise-gain-limit: found {limit}, needed a number above 0");
    }
    let separator = Separator::new(arguments.probes.gain()?, band, limit, ratio)?;
    if separator.suppressed().count() == band.iter().count() {
        bail!("--noise-gain-limit: found {limit}, which leaves out every harmonic, needed a limit that keeps some");
    }
    Ok(separator)
}

/// The readings of each probe, all revolutions one after the other.
fn read(arguments: &Arguments, points: usize, band: Band) -> Result<([Vec<f64>; 3], Option<Resampling>)> {
    let mut rows = csv_in::open(&arguments.readings, &COLUMNS, "readings")?;
    if rows.present[3] {
        let (probes, resampling) = trace::read(&mut rows, points, band)?;
        let InterpolationError { max, rms } = resampling.interpolation_error_um;
        tell(format_args!(
            "note: {} rows resampled to {} revolutions of {points}; interpolation error at most {max:.2e} µm, {rms:.2e} µm RMS{}",
            resampling.rows,
            probes[0].len() / points,
            match resampling.unused_rows {
                0 => String::new(),
                unused => format!("; {unused} rows behind the last whole revolution are not used"),
            }
        ));
        return Ok((probes, Some(resampling)));
    }
    let mut probes = [const { Vec::new() }; 3];
    let mut last = None;
    while let Some(Row { line, values }) = rows.next()? {
        for (probe, value) in probes.iter_mut().zip(values) {
            probe.push(value);
        }
        last = Some(line);
    }
    let count = rows.count;
    if !count.is_multiple_of(points) {
        return Err(FileError {
            file: rows.file.clone(),
            line: last,
            column: None,
            found: format!(
                "{} ({} and {})",
                counted(count, "row"),
                counted(count / points, "revolution"),
                counted(count % points, "row")
            ),
            needed: format!("whole revolutions of {points} rows, or a column theta_deg with the angle of each row"),
        }
        .into());
    }
    Ok((probes, None))
}

fn separate(separator: &Separator, [h1, h2, h3]: &[Vec<f64>; 3]) -> Result<Vec<Separation>> {
    let points = separator.gain().points();
    let bar = progress((h1.len() / points) as u64, "revolutions");
    let separations = h1
        .par_chunks(points)
        .zip(h2.par_chunks(points))
        .zip(h3.par_chunks(points))
        .map_init(
            || separator.workspace(),
            |workspace, ((h1, h2), h3)| {
                bar.inc(1);
                Ok(separator.separate_in(workspace, [h1, h2, h3])?)
            },
        )
        .collect();
    bar.finish_and_clear();
    separations
}

fn warnings(arguments: &Arguments, separator: &Separator, points: usize, band: Band) -> Vec<String> {
    let mut warnings = Vec::new();
    let suppressed: Vec<String> = separator.suppressed().map(|k| k.to_string()).collect();
    if !suppressed.is_empty() {
        warnings.push(format!(
            "harmonics {} are left out: their noise gain is above {}",
            suppressed.join(", "),
            arguments.noise_gain_limit
        ));
    }
    if let Some(cut_off) = arguments.upr {
        if !filter::has_enough_points(points, cut_off) {
            let needed = 7 * u32::from(cut_off);
            warnings.push(format!("{points} points are few for {cut_off} UPR: ISO 12181-2 asks for at least {needed}"));
        }
        if cut_off > band.last {
            warnings.push(format!("the band ends at harmonic {}, below the cut-off of {cut_off} UPR", band.last));
        }
    }
    warnings
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
