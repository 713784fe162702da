//! Spans of a move.

use crate::error::{Result, SimError};
use crate::placement::Placement;
use crate::program::{Curve, Move, Program};
use glam::DVec3;
use trueaxis::contour::{Segment, Span, Turn, convert, span_count};

/// Largest distance between a cubic and the curve of the tip, at equal parameters, mm.
const TOLERANCE_MM: f64 = 1.0e-6;
/// Most spans of a program.
pub const MOST_SPANS: usize = 50_000_000;
/// A move is halved at most this often.
const DEEPEST_HALVING: u32 = 16;

/// Appends the spans of a move, and the rotation of its rotary axes along them.
pub(super) fn add_move(
    program: &Program,
    (index, step): (usize, &Move),
    origin_mm: [f64; 3],
    machine: &Placement,
    five_axis: bool,
    (spans, turns): (&mut Vec<Span<f64, f64>>, &mut Vec<Turn<f64>>),
) -> Result<()> {
    let first = spans.len();
    let mut add = |segment: &Segment<'_>| {
        // Counting first refuses too many spans before it makes any.
        span_count(segment)
            .and_then(|_| {
                convert(segment, index as u32, step.plane_normal, |span| {
                    spans.push(span);
                    Ok(())
                })
            })
            .map_err(|error| SimError::Path { program: program.name.clone(), line: step.line, error })
    };
    if !five_axis {
        return programmed(step, origin_mm, &mut add);
    }
    tip_path(step, machine, &mut add)?;
    let (begin, end) = step.curve.domain();
    let turn = |span: &Span<f64, f64>| Turn::axes(span, [begin, end], step.turn.start, step.turn.end());
    turns.extend(spans.iter().skip(first).map(turn));
    Ok(())
}

pub(super) fn too_many_spans(program: &Program, step: &Move) -> SimError {
    SimError::Line {
        program: program.name.clone(),
        line: step.line,
        found: format!("found more than {MOST_SPANS} pieces of path up to here"),
        needed: "at most so many".into(),
    }
}

/// The programmed curve itself, shifted.
fn programmed(step: &Move, shift_mm: [f64; 3], add: &mut impl FnMut(&Segment<'_>) -> Result<()>) -> Result<()> {
    let shift = |p: &[f64; 3]| DVec3::from_array(*p) + DVec3::from_array(shift_mm);
    match &step.curve {
        Curve::Line { start, end } => add(&Segment::Line { start: shift(start), end: shift(end) }),
        Curve::Arc { start, end, center, normal, turns } => add(&Segment::Arc {
            start: shift(start),
            end: shift(end),
            center: shift(center),
            normal: (*normal).into(),
            turns: *turns,
        }),
        Curve::Nurbs { degree, knots, points, weights } => {
            let shifted: Vec<DVec3> = points.iter().map(shift).collect();
            add(&Segment::Nurbs { degree: *degree, knots, points: &shifted, weights })
        }
    }
}

/// The tip's path in workpiece coordinates: unchanged if it is programmed there, otherwise as cubics with parameter u.
fn tip_path(step: &Move, machine: &Placement, add: &mut impl FnMut(&Segment<'_>) -> Result<()>) -> Result<()> {
    let (first, last) = step.curve.domain();
    let stationary = Segment::Turning { point: machine.place(step, first).tip };
    if step.tool_center {
        let moves = step.curve.length() > 0.0;
        return if moves { programmed(step, machine.zero().to_array(), add) } else { add(&stationary) };
    }
    if let (Curve::Line { .. }, [0.0, 0.0, 0.0]) = (&step.curve, step.turn.change) {
        let [start, end] = [first, last].map(|u| machine.place(step, u).tip);
        return add(&Segment::Line { start, end });
    }
    let mut any = false;
    for piece in step.curve.breaks().windows(2) {
        any |= add_cubics(step, machine, [piece[0], piece[1]], DEEPEST_HALVING, add)?;
    }
    if any { Ok(()) } else { add(&stationary) }
}

/// Returns whether there was anything to add.
fn add_cubics(
    step: &Move,
    machine: &Placement,
    [a, b]: [f64; 2],
    depth: u32,
    add: &mut impl FnMut(&Segment<'_>) -> Result<()>,
) -> Result<bool> {
    let third = (b - a) / 3.0;
    // At a knot, the derivative from inside.
    let inside = 1.0e-9 * (b - a);
    let (p, q) = (machine.place(step, a).tip, machine.place(step, b).tip);
    let points =
        [p, p + third * machine.tip_velocity(step, a + inside), q - third * machine.tip_velocity(step, b - inside), q];
    let off = (1..8).any(|i| {
        let t = f64::from(i) / 8.0;
        machine.place(step, a + t * (b - a)).tip.distance(bezier(&points, t)) > TOLERANCE_MM
    });
    if off && depth > 0 {
        let middle = 0.5 * (a + b);
        let before = add_cubics(step, machine, [a, middle], depth - 1, add)?;
        return Ok(add_cubics(step, machine, [middle, b], depth - 1, add)? || before);
    }
    if points.iter().all(|point| point.distance(p) < TOLERANCE_MM) {
        return Ok(false);
    }
    add(&Segment::Nurbs { degree: 3, knots: &[a, a, a, a, b, b, b, b], points: &points, weights: &[] })?;
    Ok(true)
}

fn bezier(points: &[DVec3; 4], t: f64) -> DVec3 {
    let s = 1.0 - t;
    let [p, q, r, e] = points;
    *p * (s * s * s) + *q * (3.0 * s * s * t) + *r * (3.0 * s * t * t) + *e * (t * t * t)
}
