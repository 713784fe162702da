//! `firmware-sim compare`: arguments and output.

use crate::console::{conclude, report_line};
use crate::machine_arg::{outputs_of, read_machine};
use crate::record::{self, How};
use crate::scenario_args::{ScenarioArgs, prepare};
use anyhow::{Result, anyhow, bail};
use clap::{Args, ValueEnum};
use firmware_sim::compare::Inputs;
use firmware_sim::compare::image::{self, Core};
use firmware_sim::compare::warming;
use firmware_sim::report;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trueaxis::tcomp::machine_id;

const HELP: &str = "\
Needs qemu-system-arm and, unless built images are given, the Rust target thumbv7em-none-eabihf. In the same scalar \
both must agree in every bit; single and double precision within 2 nm.

Exit code 1: host and image do not agree.

More examples:
  # With faults, a gauge, and other tables in motion:
  firmware-sim compare --machine firmware-sim/cortex-m/machine \\
      --program short-tour --rate-hz 1000 --drill --exchange-at 12000 \\
      --second firmware-sim/cortex-m/machine/warm.toml
  # With the thermal task:
  trueaxis thermal compile thermal.toml --machine mymill -o mymill.ttherm
  firmware-sim compare --machine mymill --rate-hz 1000 --cycles 20000 \\
      --growth mymill.ttherm --temperatures readings.csv";

/// Arguments of `compare`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim compare --rate-hz 1000 --cycles 20000 --report out", after_help = HELP)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    #[command(flatten)]
    how: How,
    /// Tables that are requested in motion, with --exchange-at: another machine.toml of the same machine.
    #[arg(long, value_name = "M", requires = "exchange_at")]
    second: Option<PathBuf>,
    /// Thermal growth of the machine, compiled (`trueaxis thermal compile`), with --temperatures.
    #[arg(long, value_name = "TTHERM", requires = "temperatures")]
    growth: Option<PathBuf>,
    /// Readings of its sensors over the run: CSV t_s, T1_c … in the order of the growth's sensors, and spindle_rpm; even times,
    /// the first row in the first cycle; an empty cell is a missing reading. The growth of a row is in force half an interval later.
    #[arg(long, value_name = "CSV", requires = "growth")]
    temperatures: Option<PathBuf>,
    /// Core of the image.
    #[arg(long, value_enum, default_value_t = Cores::Both)]
    core: Cores,
    /// A built image for the Cortex-M4F [default: built with cargo].
    #[arg(long, value_name = "ELF")]
    image_m4f: Option<PathBuf>,
    /// A built image for the Cortex-M7 [default: built with cargo].
    #[arg(long, value_name = "ELF")]
    image_m7: Option<PathBuf>,
    /// Folder for tables, recording and the data that the images send.
    #[arg(short, long, alias = "folder", value_name = "DIR", default_value = "target/compare")]
    output: PathBuf,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write compare.html into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Cores {
    /// Cortex-M4F, single precision.
    M4f,
    /// Cortex-M7, double precision.
    M7,
    /// Both.
    Both,
}

/// Runs the comparison; returns whether host and image agree.
pub(crate) fn compare(args: &CompareArgs) -> Result<bool> {
    if args.how.exchange_at.is_some() && args.second.is_none() {
        bail!("--exchange-at: found no tables to request, needed --second");
    }
    let machines = [Some(args.scenario.machine.as_path()), args.second.as_deref()].into_iter().flatten();
    let images = [&args.image_m4f, &args.image_m7].into_iter().flatten().map(PathBuf::as_path);
    let warming = [&args.growth, &args.temperatures].into_iter().flatten().map(PathBuf::as_path);
    let outputs = outputs_of(machines, images.chain(args.scenario.files()).chain(warming));
    for file in Inputs::files(&args.output).into_iter().chain(args.report.iter().map(|dir| dir.join("compare.html"))) {
        outputs.refuse_input(&file)?;
    }
    let scenario = Arc::new(prepare(&args.scenario, &[])?);
    let compile = |machine: &trueaxis_tables::Machine| trueaxis_tables::compile(machine).map_err(|e| anyhow!("{e}"));
    let second = args.second.as_deref().map(|given| read_machine("--second", given)).transpose()?;
    if let Some(second) = &second
        && (&second.settings.name, &second.settings.chain)
            != (&scenario.machine.settings.name, &scenario.machine.settings.chain)
    {
        bail!("--second: found machine {}, needed {}", second.settings.name, scenario.machine.settings.name);
    }
    let settings = &scenario.machine.settings;
    let id = machine_id(&settings.name, &settings.chain);
    let note = |how| report_line(format_args!("note: {how}"));
    let inputs = Inputs {
        warming: match (&args.growth, &args.temperatures) {
            (Some(growth), Some(temperatures)) => {
                Some(warming::read(growth, temperatures, scenario.period_s(), id, note)?)
            }
            _ => None,
        },
        tables: compile(&scenario.machine)?,
        second: second.as_ref().map(compile).transpose()?,
        recording: record::bytes(&scenario, &args.how)?,
    };
    let wanted = |core: Cores| args.core == core || args.core == Cores::Both;
    let mut images = Vec::new();
    for (chosen, core, given) in [(Cores::M4f, Core::M4f, &args.image_m4f), (Cores::M7, Core::M7, &args.image_m7)] {
        if !wanted(chosen) {
            continue;
        }
        let elf = match given {
            Some(elf) => elf.clone(),
            None => {
                report_line(format_args!("building the image for {}", core.title()));
                image::build(core, &std::path::absolute(args.output.join("build").join(core.name()))?)?
            }
        };
        images.push((core, elf));
    }
    let images: Vec<(Core, &Path)> = images.iter().map(|(core, elf)| (*core, elf.as_path())).collect();
    let outcome = inputs.compare(&images, &args.output)?;
    let shown = outcome.shown();
    conclude(args.json, &outcome.json(), &shown, (args.report.as_deref(), outputs), || {
        vec![("compare.html".into(), report::compare::render(&outcome, &shown))]
    })?;
    Ok(outcome.is_good())
}
