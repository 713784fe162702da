//! The points of a part's features, with the axes where the drives bring them while cutting.

use super::chords::circle_of_chords;
use super::part::{Feature, FeatureKind, Part};
use crate::compensate::{Model, NoCorrection, Place, Settings, with_model};
use crate::positions::{Travel, in_order};
use crate::uncertainty::terms::Along;
use anyhow::{Result, anyhow, bail};
use glam::DVec3;
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis};
use trueaxis_sim::program::{Curve, Move, Program, ProgramError, ROTARY_LETTERS};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{Commanded, Geometry};
use trueaxis_tables::limits::Clipped;

/// Spacing of the points of a feature, mm, and about how many of them a feature has at least and at most (an arc: on a full
/// turn). They are equally spaced, since all have the same weight in a fit.
const SPACING: f64 = 2.0;
const POINTS: [f64; 2] = [17.0, 250.0];
const TURN_POINTS: [f64; 2] = [72.0, 180.0];
/// Largest angle between points on an arc of a profile, rad.
const MOST_TURN: f64 = 0.1;
/// Positions on an arc or curve that is no feature: they follow the directions of travel and find the ends of its travel.
const BETWEEN: usize = 64;
/// Share of a line at its ends without a point: an axis that reverses there has moved beyond its hysteresis.
const END: f64 = 1e-3;

/// A point of a feature.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Programmed point, mm, in coordinates of the program.
    pub(super) nominal: DVec3,
    /// Direction of the pass.
    pub(super) tangent: DVec3,
    /// Whether two straight moves meet there.
    pub(super) joint: bool,
    pub(super) uncorrected: Reached,
    pub(super) corrected: Reached,
    /// Ideal pose.
    commanded: Commanded,
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
    /// Normal of the plane that is active where it is cut.
    pub(super) normal: DVec3,
    /// Centre and radius of a circle.
    pub(super) circle: Option<Circle>,
    /// Of a profile: normals at its points.
    pub(super) normals: Vec<DVec3>,
}

/// A circle in the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Circle {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

impl Circle {
    /// Whether another circle is the same within the rounding of a program.
    pub(super) fn is_near(&self, other: &Circle) -> bool {
        (self.centre - other.centre).length() <= NEAR && (self.radius - other.radius).abs() <= NEAR
    }
}

/// The circle of an arc; none for another curve or a helix.
pub(super) fn circle_of(step: &Move) -> Option<Circle> {
    let Curve::Arc { start, end, center, normal, .. } = &step.curve else { return None };
    let [start, end, center, axis] = [start, end, center, normal].map(|point| DVec3::from(*point));
    let centre = center + axis * (start - center).dot(axis);
    let is_level = (end - centre).dot(axis).abs() <= NEAR;
    is_level.then(|| Circle { centre, radius: (start - centre).length() })
}

impl Point {
    /// The point that is cut, in coordinates of the program, mm; `along`: errors of the axes along themselves.
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
        let slots = |by_axis| in_order(machine.settings.axes.iter().map(|own| own.axis), by_axis);
        let tip = geometry.pose_error_of(&self.commanded, &slots(&sent), &slots(&reached.reverse)).tip_mm;
        self.nominal + DVec3::from(tip)
    }
}

/// The features of a part as the program cuts them on a machine, and how far the limits of the axes reduce the correction at
/// their points.
///
/// # Errors
/// A machine without X, Y or Z; a program that turns rotary axes or leaves the travel; features that its lines do not cut.
pub(super) fn features(machine: &Machine, program: &Program, part: &Part) -> Result<(Vec<Cut>, Clipped)> {
    linear_only(program)?;
    has_linear(machine)?;
    let mut cuts = part.features.iter().map(|feature| found(program, part, feature)).collect::<Result<Vec<_>>>()?;
    let geometry = Geometry::new(machine, 0.0).map_err(|error| anyhow!("{}: {error}", machine.settings.name))?;
    let spacings: Vec<f64> = cuts.iter().map(|cut| spacing(program, cut)).collect();
    let mut clipped = Clipped::default();
    with_model(machine, &Settings::default(), |model| {
        let mut drives = Drives::new(machine, model);
        for (index, step) in program.moves.iter().enumerate() {
            let used = |cut: &Cut| (cut.moves[0]..=cut.moves[1]).contains(&index);
            let is_feature = !step.rapid && cuts.iter().any(used);
            let spacing = cuts.iter().zip(&spacings).filter(|(cut, _)| used(cut)).map(|(_, spacing)| *spacing);
            let spacing = spacing.reduce(f64::min).filter(|_| is_feature);
            let to_end = cuts.iter().any(|cut| used(cut) && cut.is_to_ends(step));
            for u in parameters(step, spacing, to_end) {
                let at = step.curve.derivatives(u);
                let (nominal, tangent) = (DVec3::from(at.position), DVec3::from(at.first).normalize_or_zero());
                let mut command = [0.0; AXES];
                command[..3].copy_from_slice(&(nominal + DVec3::from(part.at_mm)).to_array());
                within_travel(machine, program, step, &command)?;
                let ([uncorrected, corrected], wanted) = drives.reach(command)?;
                let commanded =
                    geometry.commanded(&in_order(machine.settings.axes.iter().map(|own| own.axis), &command));
                if is_feature {
                    clipped.add(&machine.settings, &command, &wanted);
                    let joint = u >= 1.0 && is_straight(step) && program.moves.get(index + 1).is_some_and(is_straight);
                    let point = Point { nominal, tangent, joint, uncorrected, corrected, commanded };
                    cuts.iter_mut().filter(|cut| used(cut)).for_each(|cut| cut.points.push(point.clone()));
                }
            }
        }
        Ok(())
    })?;
    Ok((cuts, clipped))
}

/// Refuses a program with rotary axes.
fn linear_only(program: &Program) -> Result<()> {
    let rotary = program.first.rotary.into_iter().zip(ROTARY_LETTERS);
    let words = rotary.filter_map(|(line, letter)| Some((line?, format!("a word of axis {letter}"))));
    let words = words.chain(program.first.tool_center.map(|line| (line, String::from("G43.4"))));
    match words.min() {
        Some((line, found)) => Err(ProgramError::new(&program.file, line, found, "motion of X, Y and Z alone").into()),
        None => Ok(()),
    }
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
    for own in machine.settings.axes.iter().filter(|own| !own.axis.is_rotary()) {
        let (q, [low, high]) = (command[own.axis.index()], own.travel);
        if q < low || q > high {
            let found = format!("axis {} at {q:.3} mm", own.axis.letter());
            let needed = format!("within its travel, {low} to {high} mm, with the part at at_mm");
            return Err(ProgramError::new(&program.file, step.line, found, needed).into());
        }
    }
    Ok(())
}

impl Cut {
    /// Without its points.
    fn of(feature: &Feature, moves: [usize; 2], normal: DVec3) -> Cut {
        Cut { kind: feature.kind, points: Vec::new(), moves, normal, circle: None, normals: Vec::new() }
    }

    /// Whether its points are those at the ends of this move and of equal parts of it: of a profile, and of a circle's chords.
    fn is_to_ends(&self, step: &Move) -> bool {
        self.kind == FeatureKind::Profile || self.kind == FeatureKind::Circle && is_straight(step)
    }
}

/// Whether a move cuts along a line.
fn is_straight(step: &Move) -> bool {
    !step.rapid && matches!(step.curve, Curve::Line { .. })
}

/// Distance between the points of a feature, mm.
fn spacing(program: &Program, cut: &Cut) -> f64 {
    if cut.is_to_ends(&program.moves[cut.moves[0]]) {
        // Only the ends of chords are on the circle; a profile is thinned afterwards.
        return if cut.kind == FeatureKind::Circle { f64::INFINITY } else { 0.5 * SPACING };
    }
    let moves = program.moves[cut.moves[0]..=cut.moves[1]].iter().filter(|step| !step.rapid);
    let length: f64 = moves.map(|step| step.curve.length()).sum();
    length / (length / SPACING).clamp(POINTS[0], POINTS[1])
}

/// Parameters at which a move is evaluated; `spacing`: of the feature that it cuts; `to_end`: at the ends of equal parts.
fn parameters(step: &Move, spacing: Option<f64>, to_end: bool) -> Vec<f64> {
    let (first, last) = step.curve.domain();
    let between = |count: usize, from: f64| -> Vec<f64> {
        let share = |k: usize| from + (1.0 - 2.0 * from) * k as f64 / (count.max(2) - 1) as f64;
        (0..count.max(2)).map(|k| first + (last - first) * share(k)).collect()
    };
    match (spacing, &step.curve) {
        (Some(spacing), _) if to_end => {
            let count = match &step.curve {
                Curve::Line { .. } => step.curve.length() / spacing,
                Curve::Arc { .. } => (step.curve.length() / spacing).max(turn(&step.curve) / MOST_TURN),
                // Its speed differs from place to place.
                Curve::Nurbs { .. } => 4.0 * step.curve.length() / spacing,
            };
            let count = count.ceil().max(1.0);
            (1..=count as usize).map(|k| first + (last - first) * k as f64 / count).collect()
        }
        (None, Curve::Line { .. }) => vec![last],
        (None, _) => between(BETWEEN, 0.0),
        (Some(_), Curve::Arc { .. }) => {
            let turns = turn(&step.curve) / std::f64::consts::TAU;
            let per_turn = (step.curve.length() / turns / SPACING).clamp(TURN_POINTS[0], TURN_POINTS[1]);
            let count = (per_turn * turns).ceil().max(5.0);
            // The middles of equal parts: the ends of a full turn would count twice.
            (0..count as usize).map(|k| first + (last - first) * (k as f64 + 0.5) / count).collect()
        }
        (Some(spacing), _) => between(1 + (step.curve.length() / spacing).ceil() as usize, END),
    }
}

/// Angle of an arc, rad.
pub(super) fn turn(arc: &Curve) -> f64 {
    let (Curve::Arc { center, .. }, (first, last)) = (arc, arc.domain()) else { return std::f64::consts::TAU };
    let [start, end] = [first, last].map(|u| DVec3::from(arc.position(u)));
    let radius = 0.5 * ((start - DVec3::from(*center)).length() + (end - DVec3::from(*center)).length());
    arc.length() / radius.max(f64::MIN_POSITIVE)
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
    fn reach(&mut self, command: [f64; AXES]) -> Result<([Reached; 2], [f64; AXES])> {
        let reverse = |all: [Direction; AXES]| all.map(|one| if one == Direction::POSITIVE { 0.0 } else { 1.0 });
        let directions = self.uncorrected.arrive(&command, |_| Ok::<_, NoCorrection>([0.0; AXES]))?;
        let uncorrected = Reached { sent: command, reverse: reverse(directions) };
        let (model, most) = (self.model, self.most);
        let wanted = |&directions: &[Direction; AXES]| model.correction(&Place { command, directions });
        let limited = |wanted: [f64; AXES]| std::array::from_fn(|index| wanted[index].clamp(-most[index], most[index]));
        let directions = self.corrected.arrive(&command, |directions| wanted(directions).map(limited))?;
        let wanted = wanted(&directions)?;
        let correction: [f64; AXES] = limited(wanted);
        let sent = std::array::from_fn(|index| command[index] + correction[index]);
        Ok(([uncorrected, Reached { sent, reverse: reverse(directions) }], wanted))
    }
}

/// A feature without its points, from the moves of its lines.
fn found(program: &Program, part: &Part, feature: &Feature) -> Result<Cut> {
    let [from, to] = feature.lines;
    let of_lines = |step: &Move| (from..=to).contains(&step.line);
    let cutting: Vec<(usize, &Move)> =
        program.moves.iter().enumerate().filter(|(_, step)| of_lines(step) && !step.rapid).collect();
    let (Some((first, step)), Some((last, _))) = (cutting.first(), cutting.last()) else {
        let motion = if program.moves.iter().any(of_lines) { "rapid motion alone" } else { "no motion" };
        let found = format!("{motion} in lines {from} to {to} of {}", program.file);
        let needed = format!("lines that cut {}", feature.name);
        return Err(part.wrong(feature.line, found, needed).into());
    };
    let refuse = |step: &Move, found: &str, needed: &str| -> anyhow::Error {
        let found = format!("{found}, in the lines of {}", feature.name);
        ProgramError::new(&program.file, step.line, found, needed).into()
    };
    let between = &program.moves[*first..=*last];
    if let Some(other) = between.iter().find(|step| !step.rapid && !of_lines(step)) {
        return Err(refuse(other, "another line that cuts between them", "lines that cut one after the other"));
    }
    let normal = DVec3::from(step.plane_normal);
    let mut circle = chords(&cutting, normal).filter(|_| feature.kind == FeatureKind::Circle);
    if circle.is_some() {
        return Ok(Cut { circle, ..Cut::of(feature, [*first, *last], normal) });
    }
    for (_, step) in &cutting {
        match (feature.kind, &step.curve) {
            (FeatureKind::Circle, Curve::Arc { .. }) => {
                let own = circle_of(step).filter(|own| circle.get_or_insert(*own).is_near(own));
                if own.is_none() {
                    return Err(refuse(step, "an arc about another centre", "arcs of one circle"));
                }
            }
            (FeatureKind::Circle, _) => {
                let needed = "arcs of one circle alone, or chords of at most 30 degrees with their ends on one circle";
                return Err(refuse(step, "a line or curve", needed));
            }
            (FeatureKind::Hole, Curve::Line { start, end }) => {
                let along = (DVec3::from(*end) - DVec3::from(*start)).normalize_or_zero();
                if along.cross(normal).length() > 1e-9 {
                    return Err(refuse(step, "motion across the hole", "motion along the normal of G17, G18 or G19"));
                }
            }
            (FeatureKind::Hole | FeatureKind::Line, Curve::Arc { .. } | Curve::Nurbs { .. }) => {
                return Err(refuse(step, "an arc or curve", "straight lines"));
            }
            (FeatureKind::Line | FeatureKind::Plane | FeatureKind::Profile, _) => {}
        }
    }
    Ok(Cut { circle, ..Cut::of(feature, [*first, *last], normal) })
}

/// The circle of moves that are all chords.
fn chords(cutting: &[(usize, &Move)], normal: DVec3) -> Option<Circle> {
    let lines = cutting.iter().map(|(_, step)| match &step.curve {
        Curve::Line { start, end } => Some([start, end].map(|point| DVec3::from(*point))),
        _ => None,
    });
    let lines = lines.collect::<Option<Vec<_>>>()?;
    let ends: Vec<DVec3> =
        lines.first().map(|[start, _]| *start).into_iter().chain(lines.iter().map(|[_, end]| *end)).collect();
    circle_of_chords(&ends, normal, NEAR).map(|of| Circle { centre: of.centre, radius: of.radius })
}

/// Distance below which programmed points are equal, mm: the rounding of a program.
pub(super) const NEAR: f64 = 2e-3;
