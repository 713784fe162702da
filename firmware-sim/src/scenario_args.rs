//! Arguments of every command that simulates a program, and the scenario made of them.

use crate::machine_arg::read_machine;
use crate::program_args::ProgramArgs;
use anyhow::{Result, anyhow, bail};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis::machine::ErrorModel;
use trueaxis_sim::motion::MotionSettings;
use trueaxis_sim::placement::Placement;
use trueaxis_sim::plant::fault::FaultScript;
use trueaxis_sim::scenario::{Scenario, middle_of_travel};
use trueaxis_tables::Machine;

#[derive(Args)]
pub(crate) struct ScenarioArgs {
    /// Machine: a machine.toml, its folder, or the name of a sample (mill-3axis, mill-5axis, mill-turn).
    #[arg(long, value_name = "M", default_value = "mill-3axis")]
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) program: ProgramArgs,
    /// Error model that the step corrects by [default: the machine file's].
    #[arg(long, value_name = "MODEL", value_enum)]
    model: Option<Model>,
    /// Whether the tool's direction is corrected too, through the rotary axes; only with the volumetric model [default: the
    /// machine file's].
    #[arg(long, value_name = "on|off", value_enum, num_args = 0..=1, require_equals = true, default_missing_value = "on")]
    orientation: Option<Switch>,
    /// Servo rate.
    #[arg(long, value_name = "HZ", default_value_t = 10_000.0)]
    rate_hz: f64,
    /// Machine coordinates of the place that the program's controller calls zero: program zero where nothing shifts it
    /// [default: 0,0,0 with --offsets, else the middle of the declared travels].
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true)]
    origin_mm: Option<Vec<f64>>,
    /// Seed of the encoders' noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Time a step may take [default: a tenth of the period].
    #[arg(long, value_name = "NS")]
    budget_ns: Option<u64>,
    /// Temperature of the machine, °C [default: the tables' reference temperature].
    #[arg(long, value_name = "C", allow_hyphen_values = true)]
    temperature_c: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Model {
    /// Nine one-dimensional tables; angular errors have no lever.
    Nine,
    /// All errors of every axis, carried to the tool tip.
    Volumetric,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

pub(crate) fn prepare(args: &ScenarioArgs, faults: &[String]) -> Result<Scenario> {
    if !(100.0..=100_000.0).contains(&args.rate_hz) {
        bail!("--rate-hz: found {}, needed 100 to 100000", args.rate_hz);
    }
    let mut machine = read_machine("--machine", &args.machine)?;
    choose_model(&mut machine, args)?;
    let program = args.program.read()?;
    program.check_axes(&machine.settings, &args.program.file.display().to_string())?;
    program.check_duration(
        args.rate_hz,
        MotionSettings::default().rapid_mm_per_min,
        &args.program.file.display().to_string(),
    )?;
    let origin_mm = match args.origin_mm.as_deref() {
        None if args.program.offsets.is_some() => [0.0; 3],
        None => middle_of_travel(&machine),
        Some(&[x, y, z]) if [x, y, z].iter().all(|c| c.is_finite()) => [x, y, z],
        Some(other) => bail!("--origin-mm: found {other:?}, needed three finite numbers X,Y,Z"),
    };
    let kelvin = args.temperature_c.map_or(0.0, |t| t - machine.settings.reference_temperature_c);
    let faults = FaultScript::parse(faults).map_err(|e| anyhow!("--fault: {e}"))?;
    let placement = Placement::new(&machine, origin_mm)?;
    let scenario = Scenario {
        five_axis: program.is_five_axis(),
        placement,
        machine,
        program,
        origin_mm,
        rate_hz: args.rate_hz,
        seed: args.seed,
        faults,
        kelvin,
        budget_ns: args.budget_ns.unwrap_or((1e8 / args.rate_hz) as u64),
    };
    stays_in_travel(&scenario)?;
    Ok(scenario)
}

/// What the options say in place of the machine file's `[compensation]`.
fn choose_model(machine: &mut Machine, args: &ScenarioArgs) -> Result<()> {
    let settings = &mut machine.settings.compensation;
    match args.model {
        Some(Model::Nine) => (settings.model, settings.orientation) = (ErrorModel::Nine, false),
        Some(Model::Volumetric) => settings.model = ErrorModel::Volumetric,
        None => {}
    }
    if let Some(switch) = args.orientation {
        settings.orientation = switch == Switch::On;
    }
    if settings.orientation && settings.model == ErrorModel::Nine {
        bail!("--orientation: found on with the nine-term model, needed --model volumetric");
    }
    Ok(())
}

/// A program that leaves the declared travel would only run into the plugin's stop request.
fn stays_in_travel(scenario: &Scenario) -> Result<()> {
    for step in &scenario.program.moves {
        let (first, last) = step.curve.domain();
        for i in 0..=64 {
            let point = scenario.placement.axes(step, first + (last - first) * f64::from(i) / 64.0);
            let counted = scenario.machine.settings.axes.iter().filter(|a| scenario.five_axis || !a.axis.is_rotary());
            for settings in counted {
                let (q, [low, high]) = (point[settings.axis.index()], settings.travel);
                if q < low || q > high {
                    let (unit, hint) =
                        if settings.axis.is_rotary() { ("°", "") } else { (" mm", " (see --origin-mm)") };
                    bail!(
                        "{}, line {}: axis {} goes to {q:.3}{unit}, needed within its travel {low} to {high}{unit}{hint}",
                        scenario.program.name,
                        step.line,
                        settings.axis.letter()
                    );
                }
            }
        }
    }
    Ok(())
}
