//! The points of a part's features, with the axes where the drives bring them while cutting.

use super::locate::{self, Circle, length, turn};
use super::part::{FeatureKind, Part};
use super::temperature::{Lines, Warm};
use crate::compensate::{Model, NoCorrection, Place, Settings, with_model};
use crate::positions::{Travel, in_order};
use crate::uncertainty::terms::Along;
use anyhow::{Result, anyhow, bail};
use glam::DVec3;
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis};
use trueaxis_sim::placement::Placement;
use trueaxis_sim::program::{Curve, Move, Program, ProgramError};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::limits::Clipped;

/// Spacing of the points of a feature, mm, and about how many of them a feature has at least and at most (an arc: on a full
/// turn). They are equally spaced, since all have the same weight in a fit.
const SPACING: f64 = 2.0;
const POINTS: [f64; 2] = [17.0, 250.0];
const TURN_POINTS: [f64; 2] = [72.0, 180.0];
/// Positions on an arc or curve that is no feature: they follow the directions of travel and find the ends of its travel.
const BETWEEN: usize = 64;
/// Share of a line at its ends without a point: an axis that reverses there has moved beyond its hysteresis.
const END: f64 = 1e-3;

/// A point of a feature.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Programmed point, mm: in workpiece coordinates from the program's zero. With the rotary axes at zero these are the
    /// program's.
    pub(super) nominal: DVec3,
    pub(super) uncorrected: Reached,
    pub(super) corrected: Reached,
    /// Programmed point from the origin of the workpiece's frame, mm.
    ideal: DVec3,
    /// Move of the program, and parameter on its curve.
    pub(super) place: (usize, f64),
    /// Growth of the axes when it is cut.
    growth: Lines,
}

/// Where the drives bring the axes at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    /// Positions by [`Axis::index`], mm.
    pub(super) sent: [f64; AXES],
    /// 1 for an axis in negative travel, else 0.
    reverse: [f64; AXES],
}

/// Which command reaches the drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Uncorrected,
    Corrected,
}

/// A feature in the program.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    pub(super) kind: FeatureKind,
    pub(super) points: Vec<Point>,
    /// First and last of its moves in the order of the program.
    pub(super) moves: [usize; 2],
    /// Normal of the plane that is active where it is cut, in workpiece coordinates.
    pub(super) normal: DVec3,
    /// Centre and radius of a circle.
    pub(super) circle: Option<Circle>,
}

impl Cut {
    /// Leaves as many of the ends of a circle's chords as a circle has points.
    fn thin(&mut self) {
        if self.kind == FeatureKind::Circle && self.circle.is_none() {
            let every = self.points.len().div_ceil(TURN_POINTS[1] as usize).max(1);
            self.points = self.points.iter().step_by(every).cloned().collect();
        }
    }

    /// Whether a move is a chord of this circle, of which only the end is on it.
    fn is_chord(&self, step: &Move) -> bool {
        let is_straight = step.tool_center || step.turn.change == [0.0; 3];
        self.kind == FeatureKind::Circle && self.circle.is_none() && is_straight
    }
}

impl Point {
    /// The point that is cut, in the coordinates of the programmed one, mm; `along`: errors of the axes along themselves.
    pub(super) fn cut<'a>(
        &self,
        machine: &Machine,
        geometry: &Geometry,
        state: State,
        along: impl Iterator<Item = &'a Along>,
    ) -> DVec3 {
        let reached = if state == State::Corrected { &self.corrected } else { &self.uncorrected };
        let mut sent = reached.sent;
        for one in along {
            let index = one.axis.index();
            sent[index] += one.moves(reached.sent[index], reached.reverse[index]);
        }
        sent.iter_mut().zip(reached.sent).zip(&self.growth).for_each(|((to, at), growth)| *to += growth.at(at));
        let slots = |by_axis| in_order(machine.settings.axes.iter().map(|own| own.axis), by_axis);
        let tip = DVec3::from(geometry.actual_pose(&slots(&sent), &slots(&reached.reverse)).tip_mm);
        self.nominal + (tip - self.ideal)
    }
}

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
    program.check_axes(&machine.settings)?;
    let placement =
        Placement::new(machine, part.at_mm).map_err(|error| anyhow!("{}: {error}", machine.settings.name))?;
    let found = |feature| locate::found(program, part, feature, &placement);
    let mut cuts = part.features.iter().map(found).collect::<Result<Vec<_>>>()?;
    let spacings: Vec<f64> = cuts.iter().map(|cut| spacing(program, cut, &placement)).collect();
    let mut clipped = Clipped::default();
    with_model(machine, &Settings::default(), |model| {
        let mut drives = Drives::new(machine, model);
        for (index, step) in program.moves.iter().enumerate() {
            let used = |cut: &Cut| (cut.moves[0]..=cut.moves[1]).contains(&index);
            let is_feature = !step.rapid && cuts.iter().any(used);
            let spacing = cuts.iter().zip(&spacings).filter(|(cut, _)| used(cut)).map(|(_, spacing)| *spacing);
            let spacing = spacing.reduce(f64::min).filter(|_| is_feature);
            let is_chord = is_feature && cuts.iter().any(|cut| used(cut) && cut.is_chord(step));
            for u in if is_chord { vec![step.curve.domain().1] } else { parameters(step, spacing, &placement) } {
                let command = placement.axes(step, u);
                within_travel(machine, program, step, &command)?;
                let place = (index, u);
                let growth = warm.map(|warm| warm.at(place)).unwrap_or_default();
                let ([uncorrected, corrected], wanted) = drives.reach(command, &growth)?;
                if is_feature {
                    clipped.add(&machine.settings, &command, &wanted);
                    let ideal = placement.place_of(&command).tip;
                    let nominal = ideal - placement.zero();
                    let point = Point { nominal, uncorrected, corrected, ideal, place, growth };
                    cuts.iter_mut().filter(|cut| used(cut)).for_each(|cut| cut.points.push(point.clone()));
                }
            }
        }
        Ok(())
    })?;
    cuts.iter_mut().for_each(Cut::thin);
    Ok((cuts, clipped))
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

fn within_travel(machine: &Machine, program: &Program, step: &Move, command: &[f64; AXES]) -> Result<()> {
    // A rotary axis that the program does not turn stays where it is.
    let counted = |axis: Axis| !axis.is_rotary() || program.is_five_axis();
    for own in machine.settings.axes.iter().filter(|own| counted(own.axis)) {
        let (q, [low, high]) = (command[own.axis.index()], own.travel);
        if q < low || q > high {
            let unit = if own.axis.is_rotary() { "degrees" } else { "mm" };
            let found = format!("axis {} at {q:.3} {unit}", own.axis.letter());
            let needed = format!("within its travel, {low} to {high} {unit}, with the part at at_mm");
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

    /// Positions and directions, without and with correction, and the correction without its limits.
    fn reach(&mut self, command: [f64; AXES], growth: &Lines) -> Result<([Reached; 2], [f64; AXES])> {
        let reverse = |all: [Direction; AXES]| all.map(|one| if one == Direction::POSITIVE { 0.0 } else { 1.0 });
        let directions = self.uncorrected.arrive(&command, |_| Ok::<_, NoCorrection>([0.0; AXES]))?;
        let uncorrected = Reached { sent: command, reverse: reverse(directions) };
        let (model, most) = (self.model, self.most);
        let wanted = |&directions: &[Direction; AXES]| {
            let cold = model.correction(&Place { command, directions })?;
            let whole = |index: usize| cold[index] + growth[index].correction(command[index] + cold[index]);
            Ok::<_, NoCorrection>(std::array::from_fn(whole))
        };
        let limited = |wanted: [f64; AXES]| std::array::from_fn(|index| wanted[index].clamp(-most[index], most[index]));
        let directions = self.corrected.arrive(&command, |directions| wanted(directions).map(limited))?;
        let wanted = wanted(&directions)?;
        let correction: [f64; AXES] = limited(wanted);
        let sent = std::array::from_fn(|index| command[index] + correction[index]);
        Ok(([uncorrected, Reached { sent, reverse: reverse(directions) }], wanted))
    }
}
