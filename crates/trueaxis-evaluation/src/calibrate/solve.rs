//! Solves for the machine's errors from a log.

use super::artefact::Kind;
use super::log::Logged;
use super::observed::{Observed, observe};
use super::plan::Plan;
use super::task::Task;
use anyhow::{Result, anyhow};
use std::path::{Path, PathBuf};
use trueaxis::machine::AXES;
use trueaxis_metrology::calibration::{CalibrationRefusal, Network, Solution, Surface, Touch, Unknown};
use trueaxis_tables::Machine;
use trueaxis_tables::error::FileError;

/// A touch is an outlier if its residual exceeds this many standard deviations, estimated from the median.
const OFF_SIGMA: f64 = 8.0;
/// Smallest residual of an outlier, mm.
const OFF_MM: f64 = 5e-3;
/// Standard deviation of a normal distribution over its median magnitude.
const MEDIAN: f64 = 1.4826;

/// A solved calibration.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The network.
    pub observed: Observed,
    /// Solution of the network.
    pub solution: Solution,
    /// Log line of every touch.
    pub lines: Vec<u32>,
}

/// The log, with the names that errors need.
struct Source<'s> {
    task: &'s Task,
    plan: &'s Plan,
    file: &'s Path,
    lines: Vec<u32>,
}

impl Source<'_> {
    fn error(&self, line: Option<u32>, found: impl ToString, needed: impl ToString) -> anyhow::Error {
        let file: PathBuf = self.file.into();
        FileError { file, line, column: None, found: found.to_string(), needed: needed.to_string() }.into()
    }

    fn line(&self, touch: usize) -> Option<u32> {
        self.lines.get(touch).copied()
    }
}

/// Solves for the machine's terms; `file` names the log in errors.
///
/// # Errors
/// A set-up that cannot separate its unknowns, by their names; an artefact outside its size, a touch far off its artefact or a
/// drift above the measured effect, with the line of the log.
pub fn calibrate(task: &Task, machine: &Machine, plan: &Plan, trips: &[Logged], file: &Path) -> Result<Calibration> {
    let positions: Vec<[f64; AXES]> = trips.iter().map(|trip| trip.position).collect();
    settle(task, plan, trips, file, observe(task, machine, plan, &positions)?)
}

/// Solves the network of these trips, with the checks of [`calibrate`].
///
/// # Errors
/// As [`calibrate`].
pub fn settle(task: &Task, plan: &Plan, trips: &[Logged], file: &Path, observed: Observed) -> Result<Calibration> {
    let lines = trips.iter().map(|trip| trip.line).collect();
    let source = Source { task, plan, file, lines };
    sizes_hold(&source, &observed)?;
    let solution = observed.network.solve().map_err(|refused| source.refused(&observed, refused))?;
    touches_hold(&source, &solution)?;
    deviations_hold(&source, &observed, &solution)?;
    drift_holds(&source, &observed, &solution)?;
    Ok(Calibration { observed, solution, lines: source.lines })
}

/// Checks before measuring whether the places of a task separate its unknowns, and computes the standard errors from the
/// stated repeatability, with every touch at its planned position.
///
/// # Errors
/// The names of the unknowns that cannot be separated.
pub fn foresee(task: &Task, machine: &Machine, plan: &Plan) -> Result<Calibration> {
    let positions = planned(task, plan);
    foresee_observed(task, plan, observe(&Task { compensated: true, ..task.clone() }, machine, plan, &positions)?)
}

/// Axis positions at the touches of a plan if every artefact is where the task says: X, Y, Z, A, B, C.
pub fn planned(task: &Task, plan: &Plan) -> Vec<[f64; AXES]> {
    plan.touches
        .iter()
        .map(|touch| {
            let share = task.probe.approach_mm / (task.probe.approach_mm + task.probe.overtravel_mm);
            std::array::from_fn(|k| touch.start[k] + share * (touch.end[k] - touch.start[k]))
        })
        .collect()
}

/// [`foresee`] for a network of [`planned`] touches.
///
/// # Errors
/// As [`foresee`].
pub fn foresee_observed(task: &Task, plan: &Plan, observed: Observed) -> Result<Calibration> {
    let source = Source { task, plan, file: &task.file, lines: Vec::new() };
    let solution = observed.network.foresee().map_err(|refused| source.refused(&observed, refused))?;
    Ok(Calibration { observed, solution, lines: Vec::new() })
}

impl Source<'_> {
    fn refused(&self, observed: &Observed, refused: CalibrationRefusal) -> anyhow::Error {
        match refused {
            CalibrationRefusal::NotApart { combinations } => {
                let sentences: Vec<String> = combinations.iter().map(|parts| words(parts, observed)).collect();
                let one = sentences.first().cloned().unwrap_or_default();
                let more = match sentences.len() {
                    0 | 1 => String::new(),
                    2 => String::from(", and one more combination"),
                    count => format!(", and {} more combinations", count - 1),
                };
                let found = format!("a set-up that cannot {one}{more}");
                let needed = "artefacts or places that do (a known size along each of them, a ball for the tip's radius, a \
                              reversal), or fewer unknowns in [solve]";
                let file = self.task.file.clone();
                FileError { file, line: None, column: None, found, needed: needed.into() }.into()
            }
            CalibrationRefusal::Unsettled { touch, residual_mm } => {
                let found = format!("touch {} {residual_mm:.3} mm off {}", touch + 1, self.name(touch));
                self.error(self.line(touch), found, "touches on the artefact that the task names")
            }
            CalibrationRefusal::NotFinite { touch } => {
                self.error(self.line(touch), "a position that is not a number", "numbers")
            }
            refused => anyhow!("{}: {refused}", self.task.file.display()),
        }
    }

    fn name(&self, touch: usize) -> String {
        let of = self.plan.touches.get(touch).and_then(|touch| self.task.artefacts.get(touch.artefact));
        of.map_or(String::new(), |artefact| artefact.name.clone())
    }
}

/// Describes a combination in words, the machine's terms first.
fn words(parts: &[(usize, f64)], observed: &Observed) -> String {
    let mut parts = parts.to_vec();
    trueaxis_metrology::order::sort_by_number(&mut parts, |one| -one.1.abs());
    // Places only follow the terms: they are named only if nothing else can be.
    let sizes: Vec<&(usize, f64)> = parts.iter().filter(|(index, _)| is_size(*index, observed)).collect();
    let said = if sizes.is_empty() { parts.iter().collect() } else { sizes };
    let names: Vec<&str> =
        said.iter().take(6).filter_map(|(index, _)| observed.names.get(*index).map(String::as_str)).collect();
    let more = if said.len() > 6 { " and others" } else { "" };
    match names.split_last() {
        Some((last, [])) => format!("determine {last}, which no touch sees"),
        Some((last, rest)) => format!("separate {} and {last}{more}", rest.join(", ")),
        None => String::new(),
    }
}

fn is_size(index: usize, observed: &Observed) -> bool {
    index <= observed.network.tip || observed.sizes.contains(&Some(index))
}

/// Compares rings and balls, place by place, with their stated diameters.
fn sizes_hold(source: &Source<'_>, observed: &Observed) -> Result<()> {
    for (index, artefact) in source.task.artefacts.iter().enumerate() {
        let sense = match artefact.kind {
            Kind::Ring { .. } => 1.0,
            Kind::Ball { .. } => -1.0,
            _ => continue,
        };
        let Some(size) = observed.sizes[index] else { continue };
        for place in 0..artefact.places.len() {
            let own = |touch: usize| {
                let planned = &source.plan.touches[touch];
                planned.artefact == index && planned.place == place && planned.feature == 0
            };
            let touches: Vec<usize> = (0..source.plan.touches.len()).filter(|touch| own(*touch)).collect();
            let stated = observed.network.unknowns[size].start;
            let Some(away) = alone(observed, &touches, size).map(|measured| measured - stated) else { continue };
            if away.abs() > artefact.tolerance_mm {
                let line = touches.first().and_then(|touch| source.line(*touch));
                let measured = stated + away;
                let what = if sense > 0.0 { "inside" } else { "outside" };
                let found = format!(
                    "{} at place {} measured {measured:.4} mm {what}, {:.1} µm from its size",
                    artefact.name,
                    place + 1,
                    1e3 * away
                );
                let needed = format!(
                    "{stated} mm within {} µm: the right artefact, and the tip's radius",
                    1e3 * artefact.tolerance_mm
                );
                return Err(source.error(line, found, needed));
            }
        }
    }
    Ok(())
}

/// Checks that plate balls and gauge faces are within the artefact's tolerance of their certificate.
fn deviations_hold(source: &Source<'_>, observed: &Observed, solution: &Solution) -> Result<()> {
    for (artefact, own) in source.task.artefacts.iter().zip(&observed.deviations) {
        let off = |index: &usize| solution.values[*index].abs() > artefact.tolerance_mm;
        if let Some(index) = own.clone().find(off) {
            let found =
                format!("{} {:.1} µm from its certificate", observed.names[index], 1e3 * solution.values[index]);
            let needed = format!("at most {} µm: the right artefact, and its own sizes", 1e3 * artefact.tolerance_mm);
            return Err(source.error(None, found, needed));
        }
    }
    Ok(())
}

/// Size of an artefact from the touches at one place, with the stated tip radius; `None` if they do not determine it.
fn alone(observed: &Observed, touches: &[usize], size: usize) -> Option<f64> {
    let network = &observed.network;
    let start = |index: usize| network.unknowns.get(index).map_or(0.0, |unknown| unknown.start);
    let held = |start: f64| Unknown { start, uncertainty: Some(1e-9) };
    let free = |index: usize| Unknown { start: start(index), uncertainty: None };
    let first = &network.touches.get(*touches.first()?)?.surface;
    let (surface, at) = match first {
        Surface::Bore { centre, plane, .. } => {
            (Surface::Bore { diameter: 1, centre: 2, plane: *plane }, *centre..centre + 2)
        }
        Surface::Ball { origin, .. } => (
            Surface::Ball { diameter: 1, origin: 2, offset: [0.0; 3], turn: None, own: None, length: None },
            *origin..origin + 3,
        ),
        _ => return None,
    };
    let touches = touches.iter().filter_map(|touch| network.touches.get(*touch)).map(|touch| Touch {
        tip_mm: touch.tip_mm,
        surface: surface.clone(),
        response: Vec::new(),
        drift: Vec::new(),
    });
    let unknowns = [held(start(network.tip)), free(size)].into_iter().chain(at.map(free)).collect();
    let repeatability_mm = network.repeatability_mm;
    let found = Network { unknowns, terms: 0, tip: 0, touches: touches.collect(), repeatability_mm }.solve().ok()?;
    found.values.get(1).copied()
}

/// Checks that no touch disagrees with all the others.
fn touches_hold(source: &Source<'_>, solution: &Solution) -> Result<()> {
    let mut sizes: Vec<f64> = solution.residuals_mm.iter().map(|residual| residual.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or_default();
    let limit = (OFF_SIGMA * MEDIAN * median).max(OFF_SIGMA * source.task.probe.repeatability_mm).max(OFF_MM);
    let worst = solution.residuals_mm.iter().enumerate().max_by(|one, other| one.1.abs().total_cmp(&other.1.abs()));
    match worst {
        Some((touch, residual)) if residual.abs() > limit => {
            let found = format!(
                "touch {} on {} {:.1} µm off the position by the other touches",
                touch + 1,
                source.name(touch),
                1e3 * residual
            );
            Err(source.error(source.line(touch), found, format!("at most {:.1} µm", 1e3 * limit)))
        }
        _ => Ok(()),
    }
}

/// Checks that the drift between two visits to the reference is below the measured effect.
fn drift_holds(source: &Source<'_>, observed: &Observed, solution: &Solution) -> Result<()> {
    let at = |knot: Option<usize>, k: usize| knot.map_or(0.0, |index| solution.values[index + k]);
    let references: Vec<usize> =
        (0..source.plan.visits.len()).filter(|visit| source.plan.visits[*visit].reference).collect();
    let limit = solution.signal_mm.max(10.0 * source.task.probe.repeatability_mm);
    for (pair, knots) in references.windows(2).zip(observed.knots.windows(2)) {
        let [from, to] = [&source.plan.visits[pair[0]], &source.plan.visits[pair[1]]];
        if from.set_up != to.set_up {
            // The operator's pause may take any length of time.
            continue;
        }
        let moved = (0..3).map(|k| (at(knots[1].1, k) - at(knots[0].1, k)).powi(2)).sum::<f64>().sqrt();
        if moved > limit {
            let touch = source.plan.touches.iter().position(|touch| touch.visit == pair[1]);
            let found = format!("a drift of {:.1} µm since the last probing of the reference", 1e3 * moved);
            let needed = format!(
                "less than the measured errors, {:.1} µm: a warm machine, or the reference probed more often (reference.every)",
                1e3 * limit
            );
            return Err(source.error(touch.and_then(|touch| source.line(touch)), found, needed));
        }
    }
    Ok(())
}
