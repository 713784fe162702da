//! `trueaxis predict`.

mod servo;
mod temperature;

use crate::output::{data, json, print, report_line};
use crate::{model, report};
use anyhow::Result;
use clap::Args;
use servo::ServoArgs;
use std::path::{Path, PathBuf, absolute};
use temperature::TemperatureArgs;
use trueaxis_evaluation::predict::{Advice, Options, PartFiles, advise, elsewhere, find, own_task, sections};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::uncertainty::Uncertainties;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis predict compensation-tables/mill-3axis records/plate/part.toml
  trueaxis predict records/retrofit records/plate/part.toml \\
    --advise -o task.toml";

pub(crate) const HELP: &str = "\
The part's file states where the program's zero is in the machine, the lines of the program that cut each feature, and the tolerances:
  name, program, at_mm = [X, Y, Z]
  [[feature]] with name, kind = circle, hole, line, plane, profile or flank, lines = [first, last]
    flank: module_mm, teeth, helix_angle_deg, face_mm; pressure_angle_deg, flank, axis_mm
  [[tolerance]] with feature, kind, and
    limits_um or limits_mm: size, distance (from = another feature)
    width_um or width_mm: position, straightness, flatness, roundness, parallelism,
      perpendicularity, angularity, profile (of a free form)
    association = minimum zone instead of least squares: straightness, flatness, roundness
    datums = [...]: position, profile (up to three); parallelism, perpendicularity, angularity (one)
    class, or width_um, of a slope limits_um: profile total, form or slope, helix total, form or slope
  [[setup]], a further one, with name, program, at_mm; zero_mm, turned_deg, uncertainty_um, uncertainty_urad,
    start_s or start_at
  [[tool]] with name, diameter_uncertainty_um, length_uncertainty_um
    a feature states setup, tool, and side if the diameter is uncertain: inside or outside (circle),
    left or right (line, profile), below or above (profile cut by the end of a ball)

The exact geometry of the machine gives the points that are cut, with lost motion by the direction in which each axis \
arrives, and with corrections as far as their limits in the machine.toml admit. Features are fitted by least squares. \
Machines drawn from the uncertainties and correlations in the machine.toml (see `trueaxis uncertainty`) give the interval \
that contains the true value with 95 %. A feature conforms if this interval is within the tolerance, does not conform if it is outside, and is \
otherwise undecided (ISO 14253-1). Verdicts, uncertainties and contributions are those of the corrected part.

--advise compares the measurements that the owner's instruments allow, stated in the part's file:
  [[instrument]] with kind = ball, ring, gauge block, square, ballbar, laser, or task with file = a task of
    calibrate; as far as the defaults are not right:
    minutes, uncertainty_um (square: uncertainty_urad, laser: uncertainty_um_per_m), at_mm,
    diameter_mm, length_mm, arm_mm, radius_mm, repeatability_um (ballbar, laser),
    planes (ring, square, ballbar), along (gauge block, laser)
  [probe] with dialect, tip_radius_mm, tip_uncertainty_um, repeatability_um
It names a short set with which most characteristics get a verdict if the predicted values hold (of up to 12 measurements the \
shortest of all sets), with minutes and every characteristic's uncertainty before and after; what no measurement shows; a \
better place in X and Y; features better cut in the other direction because of lost motion; and characteristics to which the \
correction gives another verdict. -o writes the task for \
`trueaxis calibrate plan`.

--thermal adds the growth of the machine at the time at which each point is cut: uncorrected in full, corrected as far as \
the limits of the axes admit. The growth is that of the thermal.toml beside the machine.toml, by the controller's thermal task, \
or of [axis.X.thermal] of the machine.toml at the record's first temperature. The times follow from the feeds, by the planner of \
the simulator. RECORD.csv has one row a reading, as for `trueaxis thermal fit`:
  t_s: time
  T1_c … T16_c: sensors, degrees Celsius
  spindle_rpm, tool_mm: speed of the spindle, length from its nose, as far as thermal.toml needs them
A [[setup]] that does not follow the one before at once has start_s (after the first row) or start_at = HH:MM (after midnight the next day's).
Without a record, the part's file may state constant temperatures:
  [temperature] with machine_c; part_c, part_expansion_um_per_m_k and part_u_k (its standard uncertainty): a part \
cut warm shrinks to 20 °C
Not known of the growth are the sensors (sensor_k of [uncertainty]), expansion_um_per_m_k, growth_um of \
[axis.X.uncertainty], or uncertainty_um of an axis in thermal.toml.

--servo runs the simulator's step and drives over the features, each with some moves before it: uncorrected, with the \
geometric correction, and with everything that the machine.toml configures, feed-forward, friction and contour feedback. The \
axes are then where the drives bring them; verdicts are those of everything on. The drives are those of [axis.X.drive] \
and [axis.X.friction], rigid; friction that is not stated is zero. Each figure with a standard uncertainty in \
[axis.X.drive.uncertainty] or [axis.X.friction.uncertainty], of an axis that moves in a feature, is simulated once more, off by \
it in the plant alone, and is drawn with the rest. With --advise, no measurement shows these figures, and places and directions \
are compared without the servo.

--find is a start for the part's file; it reads only program from it. It finds full circles of arcs or chords, holes, planes \
milled line by line, free forms (profile), and straight lines in the plane of G17, G18 or G19. Of passes that repeat one \
another the last is the feature; a comment names the others. Delete those that are not finished surfaces.

Sizes are those of a tool of exactly its nominal diameter.";

#[derive(Args)]
pub(crate) struct PredictArgs {
    /// machine.toml or its folder.
    #[arg(value_name = "MACHINE")]
    machine: PathBuf,
    /// The part's file.
    #[arg(value_name = "PART.toml")]
    part: PathBuf,
    /// G-code file [default: the part's `program`, beside its file].
    #[arg(long, value_name = "P.ngc")]
    program: Option<PathBuf>,
    /// Number of machines drawn at random, 200 to 1000000.
    #[arg(long, value_name = "N", default_value_t = Options::default().trials)]
    trials: u64,
    /// Seed of the machines drawn; the same seed draws the same machines.
    #[arg(long, value_name = "SEED", default_value_t = Options::default().seed)]
    seed: u64,
    /// Print the features that the program cuts, as sections for the part's file, and predict nothing.
    #[arg(long, conflicts_with_all = ["json", "report"])]
    find: bool,
    /// Advise what to measure, where to put the part and in which direction to cut.
    #[arg(long, conflicts_with = "find")]
    advise: bool,
    /// The task for `calibrate plan`, if the advice has measurements with the probe.
    #[arg(short, long, value_name = "TASK.toml", requires = "advise")]
    output: Option<PathBuf>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write a page: a folder (predict.html) or a file that ends in .html.
    #[arg(long, value_name = "DIR|FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    temperature: TemperatureArgs,
    #[command(flatten)]
    servo: ServoArgs,
}

pub(crate) fn run(arguments: &PredictArgs) -> Result<()> {
    if arguments.find {
        // Features and tolerances may be unfinished.
        let program = PartFiles::program_of(&arguments.part, arguments.program.as_deref(), "--program")?;
        let found = sections(&find(&program));
        return data(if found.is_empty() { "# no feature found\n" } else { found.trim_start() });
    }
    let PartFiles { part, program, path } =
        PartFiles::read(&arguments.part, arguments.program.as_deref(), "--program")?;
    let tasks =
        part.instruments.iter().filter_map(|of| of.file.as_ref()).map(|name| arguments.part.with_file_name(name));
    let setups = part.setups.iter().map(|setup| arguments.part.with_file_name(&setup.file));
    let inputs = model::files(&arguments.machine).into_iter().chain([arguments.part.clone(), path]);
    let inputs = inputs.chain(setups).chain(tasks);
    let inputs = inputs.chain(arguments.temperature.inputs(&part, &arguments.machine));
    let mut outputs = Outputs::of(inputs);
    if let Some(to) = &arguments.output {
        outputs.refuse_input(to)?;
    }
    let machine = model::source(&arguments.machine)?;
    let stated = Uncertainties::read(&arguments.machine)?;
    let part = arguments.temperature.apply(part, &machine, &arguments.machine)?;
    let options = Options { trials: arguments.trials, seed: arguments.seed };
    if arguments.advise {
        part.require_instruments()?;
    }
    let mut document = arguments.servo.predict((&machine, &stated), &program, &part, options)?;
    if arguments.advise {
        let read = |name: &str| own_task(&arguments.part, name, &arguments.machine);
        let mut advice = advise(&machine, &stated, &program, &part, &document, &read)?;
        advice.elsewhere = Some(elsewhere(&machine, &stated, &program, &part, &document)?);
        document.advice = Some(advice);
    }
    let written = match (&arguments.output, &document.advice) {
        (Some(to), Some(advice)) => stage_task(&mut outputs, to, &arguments.machine, advice)?,
        _ => None,
    };
    if let Some(to) = &arguments.report {
        let figures = vec![report::predict::picture(&document.shapes), report::predict::margins(&document)];
        let page = document.shown().page("", figures);
        report::write_to(&mut outputs, &page, to, "predict.html")?;
    }
    outputs.commit()?;
    written.iter().for_each(report_line);
    if arguments.json { json(&document) } else { print(&document.shown().text()) }
}

/// Stages the task of an advice; what to say about it.
fn stage_task(outputs: &mut Outputs, to: &Path, machine: &Path, advice: &Advice) -> Result<Option<String>> {
    let own: Vec<String> = advice.measurements.iter().filter_map(|of| of.file.as_ref()).map(next).collect();
    let own = own.join(" and ");
    let Some(task) = &advice.task else {
        let is_decided = advice.features.iter().all(|of| of.verdict_before != "undecided");
        let why = match (advice.measurements.is_empty(), is_decided) {
            (true, true) => "nothing has to be measured".into(),
            (true, false) => "no measurement helps".into(),
            _ if own.is_empty() => "no measurement with the probe is needed".into(),
            _ => format!("the advice has your own task; next, {own}"),
        };
        let stale = if to.exists() { "; the file of this name is not from this advice" } else { "" };
        return Ok(Some(format!("not written {}: {why}{stale}", to.display())));
    };
    let beside = to.parent().is_none_or(|folder| folder.as_os_str().is_empty());
    let machine = if beside { machine.to_owned() } else { absolute(machine)? };
    outputs.put(to, task.text(&machine.display().to_string()).as_bytes())?;
    let to = to.display();
    let own = if own.is_empty() { own } else { format!(", and {own}") };
    Ok(Some(format!("written {to}: next, trueaxis calibrate plan {to} -o probe.ngc{own}")))
}

/// The command for a task of the owner's.
fn next(file: impl std::fmt::Display) -> String {
    format!("trueaxis calibrate plan {file}")
}
