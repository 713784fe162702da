//! Features in a program: the moves that cut them, in workpiece coordinates.

use super::circle::{Circle, NEAR};
use super::cut::Cut;
use super::kinds::FeatureKind;
use super::part::{Feature, Part};
use anyhow::Result;
use glam::{DMat3, DVec3};
use trueaxis_sim::placement::Placement;
use trueaxis_sim::program::{Curve, Move, Program, ProgramError, Turn};

/// Sine of the angle by which a drilled hole may deviate from its direction: the rounding of rotary words.
const ASIDE: f64 = 1e-6;
/// Chords by which the length of a path is measured that is not a curve of the program.
const CHORDS: usize = 64;

/// The circle of an arc; none for another curve or a helix.
pub(super) fn circle_of(step: &Move) -> Option<Circle> {
    let Curve::Arc { start, end, center, normal, .. } = &step.curve else { return None };
    let [start, end, center, axis] = [start, end, center, normal].map(|point| DVec3::from(*point));
    let centre = center + axis * (start - center).dot(axis);
    let is_level = (end - centre).dot(axis).abs() <= NEAR;
    is_level.then(|| Circle { centre, radius: (start - centre).length() })
}

/// Start and end of a move.
pub(super) fn ends(step: &Move) -> [DVec3; 2] {
    let (first, last) = step.curve.domain();
    [first, last].map(|u| DVec3::from(step.curve.position(u)))
}

/// Angle of an arc, rad.
pub(super) fn turn(arc: &Curve) -> f64 {
    let (Curve::Arc { center, .. }, (first, last)) = (arc, arc.domain()) else { return std::f64::consts::TAU };
    let [start, end] = [first, last].map(|u| DVec3::from(arc.position(u)));
    let radius = 0.5 * ((start - DVec3::from(*center)).length() + (end - DVec3::from(*center)).length());
    arc.length() / radius.max(f64::MIN_POSITIVE)
}

/// Length of the tip's path on the workpiece, mm.
pub(super) fn length(placement: &Placement, step: &Move) -> f64 {
    if step.keeps_its_curve() {
        return step.curve.length();
    }
    let (first, last) = step.curve.domain();
    let at = |k: usize| placement.place(step, first + (last - first) * k as f64 / CHORDS as f64).tip;
    (0..CHORDS).map(|k| (at(k + 1) - at(k)).length()).sum()
}

/// Programmed directions in workpiece coordinates where a move begins: columns X, Y, Z.
fn directions(placement: &Placement, step: &Move) -> DMat3 {
    if step.tool_center || step.turn.start == [0.0; 3] {
        return DMat3::IDENTITY;
    }
    let axes = placement.axes(step, step.curve.domain().0);
    let tip = |by: DVec3| {
        let [x, y, z, a, b, c] = axes;
        placement.place_of(&[x + by.x, y + by.y, z + by.z, a, b, c]).tip
    };
    let [x, y, z] = DVec3::AXES.map(|axis| tip(axis) - tip(DVec3::ZERO));
    DMat3::from_cols(x, y, z)
}

/// The circle that an arc cuts on the workpiece; none if it is a helix, or if a rotary axis turns the workpiece meanwhile.
fn circle_on_workpiece(placement: &Placement, step: &Move) -> Option<Circle> {
    if !step.keeps_its_curve() {
        return None;
    }
    let Circle { centre, radius } = circle_of(step)?;
    let first = step.curve.domain().0;
    let start = placement.place(step, first).tip - placement.zero();
    let centre = start + directions(placement, step) * (centre - DVec3::from(step.curve.position(first)));
    Some(Circle { centre, radius })
}

/// A feature without its points, from the moves of its lines.
pub(super) fn found(program: &Program, part: &Part, feature: &Feature, placement: &Placement) -> Result<Cut> {
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
    if let (FeatureKind::Line, Some(_)) = (feature.kind, feature.side) {
        let along = |step: &Move| {
            let [start, end] = ends(step);
            end - start
        };
        if let Some((_, back)) = cutting.iter().find(|(_, other)| along(other).dot(along(step)) < 0.0) {
            return Err(refuse(
                back,
                "a pass in the other direction",
                "one direction, since side is seen along the path",
            ));
        }
    }
    let plane = DVec3::from(step.plane_normal);
    let is_turned = step.turn != Turn::default();
    let normal = match feature.kind {
        FeatureKind::Hole if is_turned => placement.place(step, step.curve.domain().0).direction,
        _ => directions(placement, step) * plane,
    };
    let has_arcs = cutting.iter().any(|(_, step)| matches!(step.curve, Curve::Arc { .. }));
    let mut circle: Option<Circle> = None;
    for (_, step) in &cutting {
        match (feature.kind, &step.curve) {
            (FeatureKind::Circle, Curve::Arc { .. }) => {
                let own = circle_on_workpiece(placement, step);
                let own = own.filter(|own| circle.get_or_insert(*own).is_near(own));
                if own.is_none() {
                    return Err(refuse(step, "an arc about another centre", "arcs of one circle"));
                }
            }
            // The chords of a circle: their ends have to be on it.
            (FeatureKind::Circle, Curve::Line { .. }) if !has_arcs => {}
            (FeatureKind::Circle, _) => return Err(refuse(step, "a line or curve", "arcs of one circle alone")),
            (FeatureKind::Hole, Curve::Line { start, end }) => {
                let along = directions(placement, step) * (DVec3::from(*end) - DVec3::from(*start)).normalize_or_zero();
                if along.cross(normal).length() > ASIDE {
                    let needed =
                        if is_turned { "motion along the tool" } else { "motion along the normal of G17, G18 or G19" };
                    return Err(refuse(step, "motion across the hole", needed));
                }
            }
            (FeatureKind::Hole | FeatureKind::Line | FeatureKind::Flank, Curve::Arc { .. } | Curve::Nurbs { .. }) => {
                return Err(refuse(step, "an arc or curve", "straight lines"));
            }
            (FeatureKind::Line | FeatureKind::Plane | FeatureKind::Flank | FeatureKind::Profile, _) => {}
        }
    }
    let (kind, moves, points) = (feature.kind, [*first, *last], Vec::new());
    let Feature { setup, tool, side, gear, .. } = *feature;
    let (to_part, zero, normals) = (DMat3::IDENTITY, DVec3::ZERO, Vec::new());
    Ok(Cut { kind, points, moves, normal, circle, setup, to_part, zero, tool, side, gear, normals })
}
