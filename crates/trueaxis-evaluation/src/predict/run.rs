//! The points of a part's features along the program, in the order in which they are cut.

use super::cut::{Cut, Point, Reached};
use super::kinds::FeatureKind;
use super::locate::{self, length, turn};
use super::part::{Feature, Part};
use super::temperature::{Lines, Warm};
use crate::compensate::{self, Model, NoCorrection, Settings, with_model};
use crate::positions::Travel;
use anyhow::{Result, anyhow, bail};
use glam::DVec3;
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis};
use trueaxis_sim::placement::{Place, Placement};
use trueaxis_sim::program::{Curve, Move, Program, ProgramError};
use trueaxis_tables::Machine;
use trueaxis_tables::limits::Clipped;

/// Spacing of the points of a feature, mm, and about how many of them a feature has at least and at most (an arc: on a full
/// turn). They are equally spaced, since all have the same weight in a fit.
const SPACING: f64 = 2.0;
const POINTS: [f64; 2] = [17.0, 250.0];
const TURN_POINTS: [f64; 2] = [72.0, 180.0];
/// Largest angle between points on an arc of a profile, rad.
const MOST_TURN: f64 = 0.1;
/// Share of a move over which its direction is taken.
const AROUND: f64 = 1e-4;
/// Positions on an arc or curve that is no feature: they follow the directions of travel and find the ends of its travel.
const BETWEEN: usize = 64;
/// Share of a line at its ends without a point: an axis that reverses there has moved beyond its hysteresis.
const END: f64 = 1e-3;

/// The features of a part as the program cuts them on a machine, and how far the limits of the axes reduce the correction at
/// their points.
///
/// # Errors
/// A machine without X, Y or Z, or without a rotary axis that the program turns; a program that leaves the travel; features
/// that its lines do not cut.
pub(super) fn features(
    machine: &Machine,
    program: &Program,
    part: &Part,
    warm: Option<&Warm<'_>>,
) -> Result<(Vec<Cut>, Clipped)> {
    has_linear(machine)?;
    let mut clipped = Clipped::default();
    let mut cuts: Vec<Option<Cut>> = vec![None; part.features.len()];
    for setup in std::iter::once(None).chain((0..part.setups.len()).map(Some)) {
        let own = part.features.iter().enumerate().filter(|(_, feature)| feature.setup == setup);
        let (indices, features): (Vec<usize>, Vec<&Feature>) = own.unzip();
        let held = setup.and_then(|setup| part.setups.get(setup));
        let at_mm = held.map_or(part.at_mm, |held| held.at_mm);
        let placement =
            Placement::new(machine, at_mm).map_err(|error| anyhow!("{}: {error}", machine.settings.name))?;
        if let Some(missing) = held.filter(|held| held.program.is_none()) {
            return Err(part
                .wrong(missing.line, format!("no program {}", missing.file), "the set-up's program")
                .into());
        }
        let program = part.program_of(setup, program);
        let of_setup = in_setup(machine, program, part, (setup, &features), (&placement, warm), &mut clipped)?;
        for (index, mut cut) in indices.into_iter().zip(of_setup) {
            if let Some(held) = held {
                cut.place(held.to_part(), DVec3::from(held.zero_mm));
            }
            cuts[index] = Some(cut);
        }
    }
    Ok((cuts.into_iter().flatten().collect(), clipped))
}

/// The features of one set-up, in the coordinates of its program.
fn in_setup(
    machine: &Machine,
    program: &Program,
    part: &Part,
    (setup, features): (Option<usize>, &[&Feature]),
    (placement, warm): (&Placement, Option<&Warm<'_>>),
    clipped: &mut Clipped,
) -> Result<Vec<Cut>> {
    program.check_axes(&machine.settings)?;
    let held = setup.and_then(|setup| part.setups.get(setup));
    let at = held.map_or_else(|| String::from("at_mm"), |held| format!("at_mm of the set-up {}", held.name));
    let found = |feature: &&Feature| locate::found(program, part, feature, placement);
    let mut cuts = features.iter().map(found).collect::<Result<Vec<_>>>()?;
    let spacings: Vec<f64> = cuts.iter().map(|cut| spacing(program, cut, placement)).collect();
    with_model(machine, &Settings::default(), |model| {
        let mut drives = Drives::new(machine, model);
        for (index, step) in program.moves.iter().enumerate() {
            let used = |cut: &Cut| (cut.moves[0]..=cut.moves[1]).contains(&index);
            let is_feature = !step.rapid && cuts.iter().any(used);
            let spacing = cuts.iter().zip(&spacings).filter(|(cut, _)| used(cut)).map(|(_, spacing)| *spacing);
            let spacing = spacing.reduce(f64::min).filter(|_| is_feature);
            let is_chord = is_feature && cuts.iter().any(|cut| used(cut) && cut.is_chord(step));
            let is_profile = is_feature && cuts.iter().any(|cut| used(cut) && cut.kind == FeatureKind::Profile);
            let parameters = match spacing {
                _ if is_chord => vec![step.curve.domain().1],
                Some(_) if is_profile => to_end(step, placement),
                _ => parameters(step, spacing, placement),
            };
            for u in parameters {
                let command = placement.axes(step, u);
                within_travel(machine, program, step, &command, &at)?;
                let place = (index, u);
                let growth = warm.map(|warm| warm.at((setup, place))).unwrap_or_default();
                let Arrived { uncorrected, corrected, wanted, warm } = drives.reach(command, &growth)?;
                if is_feature {
                    clipped.add(&machine.settings, &command, &wanted);
                    let Place { tip: ideal, direction: pointing } = placement.place_of(&command);
                    let nominal = ideal - placement.zero();
                    let tangent = if is_profile { tangent(step, u, placement) } else { DVec3::ZERO };
                    let joint = u >= 1.0 && is_straight(step) && program.moves.get(index + 1).is_some_and(is_straight);
                    let everything = corrected;
                    let point = Point {
                        nominal,
                        tangent,
                        larger: DVec3::ZERO,
                        joint,
                        command,
                        uncorrected,
                        corrected,
                        everything,
                        drives: Vec::new(),
                        ideal,
                        place,
                        warm,
                        growth,
                        pointing,
                    };
                    cuts.iter_mut().filter(|cut| used(cut)).for_each(|cut| cut.points.push(point.clone()));
                }
            }
        }
        Ok(())
    })?;
    cuts.iter_mut().for_each(|cut| cut.thin(TURN_POINTS[1] as usize));
    Ok(cuts)
}

/// Refuses a machine without X, Y or Z.
fn has_linear(machine: &Machine) -> Result<()> {
    let has = |axis: Axis| machine.settings.axis(axis).is_some();
    if ![Axis::X, Axis::Y, Axis::Z].into_iter().all(has) {
        let letters: Vec<String> =
            Axis::ALL.into_iter().filter(|axis| has(*axis)).map(|axis| axis.letter().into()).collect();
        bail!("{}: found axes {}, needed X, Y and Z", machine.settings.name, letters.join(", "));
    }
    Ok(())
}

/// `at`: the key that states where the part is.
fn within_travel(machine: &Machine, program: &Program, step: &Move, command: &[f64; AXES], at: &str) -> Result<()> {
    // A rotary axis that the program does not turn stays where it is.
    let counted = |axis: Axis| !axis.is_rotary() || program.is_five_axis();
    for own in machine.settings.axes.iter().filter(|own| counted(own.axis)) {
        let (q, [low, high]) = (command[own.axis.index()], own.travel);
        if q < low || q > high {
            let unit = if own.axis.is_rotary() { "degrees" } else { "mm" };
            let found = format!("axis {} at {q:.3} {unit}", own.axis.letter());
            let needed = format!("within its travel, {low} to {high} {unit}, with the part at {at}");
            return Err(ProgramError::new(&program.file, step.line, found, needed).into());
        }
    }
    Ok(())
}

/// Distance between the points of a feature, mm.
fn spacing(program: &Program, cut: &Cut, placement: &Placement) -> f64 {
    let moves = program.moves[cut.moves[0]..=cut.moves[1]].iter().filter(|step| !step.rapid);
    let length: f64 = moves.map(|step| length(placement, step)).sum();
    length / (length / SPACING).clamp(POINTS[0], POINTS[1])
}

/// Parameters at which a move is evaluated; `spacing`: of the feature that it cuts.
pub(super) fn parameters(step: &Move, spacing: Option<f64>, placement: &Placement) -> Vec<f64> {
    let (first, last) = step.curve.domain();
    let between = |count: usize, from: f64| -> Vec<f64> {
        let share = |k: usize| from + (1.0 - 2.0 * from) * k as f64 / (count.max(2) - 1) as f64;
        (0..count.max(2)).map(|k| first + (last - first) * share(k)).collect()
    };
    match (spacing, &step.curve) {
        (None, Curve::Line { .. }) if step.turn.change == [0.0; 3] => vec![last],
        (None, _) => between(BETWEEN, 0.0),
        (Some(_), Curve::Arc { .. }) => {
            let turns = turn(&step.curve) / std::f64::consts::TAU;
            let per_turn = (step.curve.length() / turns / SPACING).clamp(TURN_POINTS[0], TURN_POINTS[1]);
            let count = (per_turn * turns).ceil().max(5.0);
            // The middles of equal parts: the ends of a full turn would count twice.
            (0..count as usize).map(|k| first + (last - first) * (k as f64 + 0.5) / count).collect()
        }
        (Some(spacing), _) => between(1 + (length(placement, step) / spacing).ceil() as usize, END),
    }
}

/// Parameters at the ends of equal parts of a profile's move; it is thinned afterwards.
fn to_end(step: &Move, placement: &Placement) -> Vec<f64> {
    let (first, last) = step.curve.domain();
    let parts = length(placement, step) / (0.5 * SPACING);
    let count = match &step.curve {
        Curve::Line { .. } => parts,
        Curve::Arc { .. } => parts.max(turn(&step.curve) / MOST_TURN),
        // Its speed differs from place to place.
        Curve::Nurbs { .. } => 4.0 * parts,
    };
    let count = count.ceil().max(1.0);
    (1..=count as usize).map(|k| first + (last - first) * k as f64 / count).collect()
}

/// Direction of the tip's path on the workpiece. Of the second order: turned by as little as half of a step, the normals of a
/// full circle would make its size a rotation.
fn tangent(step: &Move, u: f64, placement: &Placement) -> DVec3 {
    let (first, last) = step.curve.domain();
    let [here, before, earlier] =
        [0.0, 1.0, 2.0].map(|steps| placement.place(step, u - steps * AROUND * (last - first)).tip);
    (4.0 * (here - before) - (here - earlier)).normalize_or_zero()
}

/// Whether a move cuts along a line.
fn is_straight(step: &Move) -> bool {
    !step.rapid && matches!(step.curve, Curve::Line { .. }) && step.keeps_its_curve()
}

/// Where the drives bring the axes for a command.
struct Arrived {
    uncorrected: Reached,
    corrected: Reached,
    /// The correction without its limits.
    wanted: [f64; AXES],
    /// What its part for the growth adds to that of the cold machine, both within the limits.
    warm: [f64; AXES],
}

/// The drives along the program, with and without correction.
struct Drives<'m> {
    model: &'m dyn Model,
    uncorrected: Travel,
    corrected: Travel,
    /// Largest correction that the step sends to each axis.
    most: [f64; AXES],
}

impl<'m> Drives<'m> {
    fn new(machine: &Machine, model: &'m dyn Model) -> Drives<'m> {
        let travel = Travel::new(machine, Axis::ALL.into_iter());
        let most = Axis::ALL.map(|axis| machine.settings.axis(axis).map_or(0.0, |own| own.limits.magnitude));
        Drives { model, uncorrected: travel.clone(), corrected: travel, most }
    }

    fn reach(&mut self, command: [f64; AXES], growth: &Lines) -> Result<Arrived> {
        let reverse = |all: [Direction; AXES]| all.map(|one| if one == Direction::POSITIVE { 0.0 } else { 1.0 });
        let directions = self.uncorrected.arrive(&command, |_| Ok::<_, NoCorrection>([0.0; AXES]))?;
        let uncorrected = Reached { sent: command, reverse: reverse(directions) };
        let (model, most) = (self.model, self.most);
        let cold = |&directions: &[Direction; AXES]| model.correction(&compensate::Place { command, directions });
        let wanted = |directions: &[Direction; AXES]| {
            let cold = cold(directions)?;
            let whole = |index: usize| cold[index] + growth[index].correction(command[index] + cold[index]);
            Ok::<_, NoCorrection>(std::array::from_fn(whole))
        };
        let limited = |wanted: [f64; AXES]| std::array::from_fn(|index| wanted[index].clamp(-most[index], most[index]));
        let directions = self.corrected.arrive(&command, |directions| wanted(directions).map(limited))?;
        let (cold, wanted) = (limited(cold(&directions)?), wanted(&directions)?);
        let correction: [f64; AXES] = limited(wanted);
        let sent = std::array::from_fn(|index| command[index] + correction[index]);
        let warm = std::array::from_fn(|index| correction[index] - cold[index]);
        Ok(Arrived { uncorrected, corrected: Reached { sent, reverse: reverse(directions) }, wanted, warm })
    }
}
