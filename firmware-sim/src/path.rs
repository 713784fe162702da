//! The program as the plugin's path: spans, and where on them the interpolator is.

use crate::placement::Placement;
use crate::program::{Curve, Move, Program};
use anyhow::{Result, anyhow};
use glam::DVec3;
use trueaxis::contour::{Reference, Segment, Span, convert};

/// Largest distance of a cubic piece from the curve that the tip describes, at the same parameter, mm.
const TOLERANCE_MM: f64 = 1.0e-6;
/// A move is halved at most this often.
const DEEPEST_HALVING: u32 = 16;

/// The path of a whole program, converted once.
///
/// A program of X, Y, Z alone: in machine coordinates. One with rotary axes: the tip in workpiece coordinates.
#[derive(Debug)]
pub struct PlannedPath {
    /// All spans in path order.
    pub spans: Vec<Span<f64, f64>>,
    /// Rotary axes along each span; none for a program of X, Y, Z alone.
    pub turns: Vec<SpanTurn>,
    /// First span of every move, and one past the last.
    first: Vec<u32>,
}

/// A, B, C along a span: start + t · change, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpanTurn {
    /// At the span's start.
    pub start: [f64; 3],
    /// From there to its end.
    pub change: [f64; 3],
}

impl PlannedPath {
    /// Converts a program whose zero lies at `origin_mm` in machine coordinates.
    ///
    /// # Errors
    /// A move that is no path (the program reader refuses those before).
    pub fn new(program: &Program, origin_mm: [f64; 3], machine: &Placement) -> Result<PlannedPath> {
        let five_axis = program.is_five_axis();
        let mut path = PlannedPath { spans: Vec::new(), turns: Vec::new(), first: Vec::new() };
        for (index, step) in program.moves.iter().enumerate() {
            path.first.push(path.spans.len() as u32);
            let mut add = |segment: &Segment<'_>| {
                convert(segment, index as u32, step.plane_normal, |span| {
                    path.spans.push(span);
                    Ok(())
                })
                .map_err(|e| anyhow!("{}, line {}: {e}", program.name, step.line))
            };
            if five_axis {
                tip_path(step, machine, &mut add)?;
                path.add_turns(step);
            } else {
                programmed(step, origin_mm, &mut add)?;
            }
        }
        path.first.push(path.spans.len() as u32);
        Ok(path)
    }

    fn add_turns(&mut self, step: &Move) {
        for span in self.spans.iter().skip(self.turns.len()) {
            let [start, end] = span.u_range().map(|u| step.rotary(u));
            self.turns.push(SpanTurn { start, change: std::array::from_fn(|k| end[k] - start[k]) });
        }
    }

    /// Span and local parameter of a place in the program. `near` carries the span from call to call.
    pub fn reference(&self, move_index: usize, u: f64, near: &mut u32) -> Reference<f64> {
        let (first, end) = match self.first.get(move_index..move_index + 2) {
            Some([first, end]) => (*first, *end),
            _ => (0, 0),
        };
        // A move that leaves the tip where it is has no span: the end of what came before.
        if first == end {
            return match first.checked_sub(1) {
                Some(before) => Reference { span: before, t: 1.0 },
                None => Reference { span: 0, t: 0.0 },
            };
        }
        let last = end - 1;
        *near = (*near).clamp(first, last);
        while *near < last && self.spans[*near as usize].u_range()[1] < u {
            *near += 1;
        }
        while *near > first && self.spans[*near as usize].u_range()[0] > u {
            *near -= 1;
        }
        Reference { span: *near, t: self.spans[*near as usize].t_of(u) }
    }
}

/// The programmed curve itself, shifted.
fn programmed(step: &Move, shift_mm: [f64; 3], add: &mut impl FnMut(&Segment<'_>) -> Result<()>) -> Result<()> {
    let shift = |p: &[f64; 3]| std::array::from_fn(|k| p[k] + shift_mm[k]);
    match &step.curve {
        Curve::Line { start, end } => add(&Segment::Line { start: shift(start), end: shift(end) }),
        Curve::Arc { start, end, center, normal, turns } => add(&Segment::Arc {
            start: shift(start),
            end: shift(end),
            center: shift(center),
            normal: *normal,
            turns: *turns,
        }),
        Curve::Nurbs { degree, knots, points, weights } => {
            let shifted: Vec<[f64; 3]> = points.iter().map(shift).collect();
            add(&Segment::Nurbs { degree: *degree, knots, points: &shifted, weights })
        }
    }
}

/// The way of the tip in workpiece coordinates: straight lines as they are, everything else as cubics with parameter u.
fn tip_path(step: &Move, machine: &Placement, add: &mut impl FnMut(&Segment<'_>) -> Result<()>) -> Result<()> {
    let (first, last) = step.curve.domain();
    let straight = matches!(step.curve, Curve::Line { .. }) && (step.tool_center || step.turn.change == [0.0; 3]);
    if straight {
        let [start, end] = [first, last].map(|u| machine.place(step, u).tip.to_array());
        // Only the rotary axes turn, about the tip.
        return if start == end { Ok(()) } else { add(&Segment::Line { start, end }) };
    }
    for piece in step.curve.breaks().windows(2) {
        add_cubics(step, machine, [piece[0], piece[1]], DEEPEST_HALVING, add)?;
    }
    Ok(())
}

fn add_cubics(
    step: &Move,
    machine: &Placement,
    [a, b]: [f64; 2],
    depth: u32,
    add: &mut impl FnMut(&Segment<'_>) -> Result<()>,
) -> Result<()> {
    let third = (b - a) / 3.0;
    // At a knot, the derivative of the piece inside.
    let inside = 1.0e-9 * (b - a);
    let (p, q) = (machine.place(step, a).tip, machine.place(step, b).tip);
    let points = [
        p,
        p + third * machine.tip_velocity(step, a + inside),
        q - third * machine.tip_velocity(step, b - inside),
        q,
    ];
    let off = (1..8).any(|i| {
        let t = f64::from(i) / 8.0;
        machine.place(step, a + t * (b - a)).tip.distance(bezier(&points, t)) > TOLERANCE_MM
    });
    if off && depth > 0 {
        let middle = 0.5 * (a + b);
        add_cubics(step, machine, [a, middle], depth - 1, add)?;
        return add_cubics(step, machine, [middle, b], depth - 1, add);
    }
    if points.iter().all(|point| point.distance(p) < TOLERANCE_MM) {
        return Ok(());
    }
    let points = points.map(|point| point.to_array());
    add(&Segment::Nurbs { degree: 3, knots: &[a, a, a, a, b, b, b, b], points: &points, weights: &[] })
}

fn bezier(points: &[DVec3; 4], t: f64) -> DVec3 {
    let s = 1.0 - t;
    let [p, q, r, e] = points;
    *p * (s * s * s) + *q * (3.0 * s * s * t) + *r * (3.0 * s * t * t) + *e * (t * t * t)
}
