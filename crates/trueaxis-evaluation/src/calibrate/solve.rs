//! Solves for the machine's errors from a log.

use super::artefact::Kind;
use super::log::{Logged, read_log};
use super::observed::{Observed, observe};
use super::plan::Plan;
use super::sheet::read_sheet;
use super::source::Source;
use super::task::Task;
use super::trips::trips;
use anyhow::Result;
use std::path::Path;
use trueaxis::machine::AXES;
use trueaxis_metrology::calibration::{Network, Solution, Surface, Touch, Unknown};
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

/// Solves a task from the text of its log. `file` names the log in errors; unusual separators in it are reported to the
/// callback.
///
/// # Errors
/// As [`read_log`], [`Plan::new`], [`trips`] and [`calibrate`].
pub fn solved(
    task: &Task,
    machine: &Machine,
    text: &str,
    file: &Path,
    note: impl FnMut(String),
) -> Result<(Plan, Calibration)> {
    let (plan, trips) = if task.is_read() {
        let plan = Plan::new(task, machine)?;
        let trips = read_sheet(task, machine, &plan, (text, file), note)?;
        (plan, trips)
    } else {
        let log = read_log(text, file, task.dialect, note)?;
        let plan = Plan::new(task, machine)?;
        let trips = trips(task, &plan, &log, file)?;
        (plan, trips)
    };
    let found = calibrate(task, machine, &plan, &trips, file)?;
    Ok((plan, found))
}

/// Solves for the machine's terms; `file` names the log in errors.
///
/// # Errors
/// A set-up that cannot separate its unknowns, by their names; an artefact outside its size, a touch far off its artefact or a
/// drift above the measured effect, with the line of the log.
pub fn calibrate(task: &Task, machine: &Machine, plan: &Plan, trips: &[Logged], file: &Path) -> Result<Calibration> {
    if task.plate().is_some() {
        placements_hold(task, machine, plan, file)?;
    }
    let positions: Vec<[f64; AXES]> = trips.iter().map(|trip| trip.position).collect();
    settle(task, plan, trips, file, observe(task, machine, plan, &positions)?)
}

/// Checks that the placements of a plate of unknown places separate its unknowns as planned: off its places a plate seems to
/// separate what it does not, with enormous standard errors.
fn placements_hold(task: &Task, machine: &Machine, plan: &Plan, file: &Path) -> Result<()> {
    let nominal = observe(&Task { compensated: true, ..task.clone() }, machine, plan, &plan.nominal(&task.probe))?;
    let source = Source { task, plan, file, lines: Vec::new() };
    source.separates(&nominal)
}

/// Solves the network of these trips, with the checks of [`calibrate`].
///
/// # Errors
/// As [`calibrate`].
pub fn settle(task: &Task, plan: &Plan, trips: &[Logged], file: &Path, observed: Observed) -> Result<Calibration> {
    let lines: Vec<u32> = trips.iter().map(|trip| trip.line).collect();
    let source = Source { task, plan, file, lines };
    sizes_hold(&source, &observed)?;
    let solution = observed.network.solve().map_err(|refused| source.refused(&observed, refused))?;
    touches_hold(&source, &observed, &solution)?;
    deviations_hold(&source, &observed, &solution)?;
    drift_holds(&source, &observed, &solution)?;
    Ok(Calibration { observed, solution, lines: source.lines })
}

/// Compares rings and balls, place by place, with their stated diameters.
fn sizes_hold(source: &Source<'_>, observed: &Observed) -> Result<()> {
    for (index, artefact) in source.task.artefacts.iter().enumerate() {
        let sense = match artefact.kind {
            Kind::Ring { .. } => 1.0,
            Kind::Ball { .. } => -1.0,
            _ => continue,
        };
        let Some(size) = observed.sizes[index].first().copied() else { continue };
        for place in 0..artefact.places.len() {
            let own = |touch: usize| {
                let planned = &source.plan.touches[observed.planned[touch]];
                planned.artefact == index && planned.place == place && planned.feature == 0
            };
            let touches: Vec<usize> = (0..observed.planned.len()).filter(|touch| own(*touch)).collect();
            let stated = observed.network.unknowns[size].start;
            let Some(away) = fit_size_from_one_place(observed, &touches, size).map(|measured| measured - stated) else {
                continue;
            };
            if away.abs() > artefact.tolerance_mm {
                let line = touches.first().and_then(|touch| source.line(observed.planned[*touch]));
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

/// Checks that plate balls, gauge faces and lengths of blocks are within the artefact's tolerance of their stated sizes, and
/// points of a face within that of a straight line.
fn deviations_hold(source: &Source<'_>, observed: &Observed, solution: &Solution) -> Result<()> {
    let away = |index: usize| solution.values[index] - observed.network.unknowns[index].start;
    for (of, artefact) in source.task.artefacts.iter().enumerate() {
        let off = |index: &usize| !observed.angles.contains(index) && away(*index).abs() > artefact.tolerance_mm;
        let lengths = match &artefact.kind {
            Kind::Block(block) => &observed.sizes[of][..block.measured],
            Kind::Grid(_) => &observed.sizes[of],
            _ => &[],
        };
        if let Some(index) = observed.deviations[of].clone().chain(lengths.iter().copied()).find(off) {
            let from = match artefact.kind {
                Kind::Dial(_) => "a straight line",
                Kind::Grid(_) => "the place that its pitch states",
                _ => "the size that the task states",
            };
            let found = format!("{} {:.1} µm from {from}", observed.names[index], 1e3 * away(index));
            let needed = format!(
                "at most {} µm (tolerance_um): the right artefact, and its own sizes",
                1e3 * artefact.tolerance_mm
            );
            let file = source.task.file.clone();
            return Err(FileError { file, line: Some(artefact.line), column: None, found, needed }.into());
        }
    }
    Ok(())
}

/// Size of an artefact from the touches at one place, with the stated tip radius; `None` if they do not determine it.
fn fit_size_from_one_place(observed: &Observed, touches: &[usize], size: usize) -> Option<f64> {
    let network = &observed.network;
    let start = |index: usize| network.unknowns.get(index).map_or(0.0, |unknown| unknown.start);
    let held = |start: f64| Unknown { start, uncertainty: Some(1e-9) };
    let free = |index: usize| Unknown { start: start(index), uncertainty: None };
    // The unknowns of this smaller network: tip's radius, size, centre.
    let mut unknowns = vec![held(start(network.tip)), free(size)];
    let [tip, diameter, centre] = [0, 1, 2];
    let surface = match &network.touches.get(*touches.first()?)?.surface {
        Surface::Bore { centre: in_network, plane, .. } => {
            unknowns.extend((*in_network..in_network + 2).map(free));
            Surface::Bore { diameter, centre, plane: *plane }
        }
        Surface::Ball { origin, .. } => {
            unknowns.extend((*origin..origin + 3).map(free));
            Surface::Ball { diameter, origin: centre, offset: [0.0; 3], turn: None, own: None, length: None }
        }
        _ => return None,
    };
    let touches = touches.iter().filter_map(|touch| network.touches.get(*touch)).map(|touch| Touch {
        tip_mm: touch.tip_mm,
        surface: surface.clone(),
        response: Vec::new(),
        drift: Vec::new(),
        own_tip: None,
        weight: touch.weight,
    });
    let repeatability_mm = network.repeatability_mm;
    let one_place = Network { unknowns, terms: 0, tip, touches: touches.collect(), repeatability_mm };
    one_place.solve().ok()?.values.get(diameter).copied()
}

/// Checks that no touch disagrees with all the others.
fn touches_hold(source: &Source<'_>, observed: &Observed, solution: &Solution) -> Result<()> {
    let mut sizes: Vec<f64> = solution.residuals_mm.iter().map(|residual| residual.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or_default();
    let limit = (OFF_SIGMA * MEDIAN * median).max(OFF_SIGMA * source.task.probe.repeatability_mm).max(OFF_MM);
    let worst = solution.residuals_mm.iter().enumerate().max_by(|one, other| one.1.abs().total_cmp(&other.1.abs()));
    match worst {
        Some((touch, residual)) if residual.abs() > limit => {
            let (numbers, touch) = (observed.numbers(touch), observed.first(touch));
            let found = format!(
                "{} {numbers} on {} {:.1} µm off the position by the others",
                source.task.word(),
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
