//! The program as the plugin's path: spans, and where on them the interpolator is.

use crate::placement::Placement;
use crate::program::{Curve, Move, Program};
use anyhow::{Result, anyhow};
use glam::DVec3;
use trueaxis::contour::{Path, Reference, Segment, Span, ToolPath, Turn, convert};

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
    pub turns: Vec<Turn<f64>>,
    /// First span of every move, and one past the last.
    first: Vec<u32>,
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
                for span in path.spans.iter().skip(path.turns.len()) {
                    let (first, last) = step.curve.domain();
                    path.turns.push(Turn::axes(span, [first, last], step.turn.start, step.turn.end()));
                }
            } else {
                programmed(step, origin_mm, &mut add)?;
            }
        }
        path.first.push(path.spans.len() as u32);
        Ok(path)
    }

    /// The path as the step takes it.
    pub fn view(&self) -> Path<'_, f64, f64> {
        Path::new(&self.spans, 0, false)
    }

    /// The path with its directions, for a program with rotary axes.
    pub fn tool_view(&self) -> ToolPath<'_, f64, f64> {
        ToolPath::new(self.view(), &self.turns)
    }

    /// Span and local parameter of a place in the program. `near` carries the span from call to call.
    pub fn reference(&self, move_index: usize, u: f64, near: &mut u32) -> Reference<f64> {
        let (first, last) = match self.first.get(move_index..move_index + 2) {
            Some([first, end]) => (*first, end.saturating_sub(1)),
            _ => (0, 0),
        };
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

/// The way of the tip in workpiece coordinates: what is programmed there as it is, everything else as cubics with parameter u.
fn tip_path(step: &Move, machine: &Placement, add: &mut impl FnMut(&Segment<'_>) -> Result<()>) -> Result<()> {
    let (first, last) = step.curve.domain();
    let standing = Segment::Turning { point: machine.place(step, first).tip.to_array() };
    if step.tool_center {
        let moves = step.curve.length() > 0.0;
        return if moves { programmed(step, machine.zero().to_array(), add) } else { add(&standing) };
    }
    if let (Curve::Line { .. }, [0.0, 0.0, 0.0]) = (&step.curve, step.turn.change) {
        let [start, end] = [first, last].map(|u| machine.place(step, u).tip.to_array());
        return add(&Segment::Line { start, end });
    }
    let mut any = false;
    for piece in step.curve.breaks().windows(2) {
        any |= add_cubics(step, machine, [piece[0], piece[1]], DEEPEST_HALVING, add)?;
    }
    if any { Ok(()) } else { add(&standing) }
}

/// Whether there was anything to add.
fn add_cubics(
    step: &Move,
    machine: &Placement,
    [a, b]: [f64; 2],
    depth: u32,
    add: &mut impl FnMut(&Segment<'_>) -> Result<()>,
) -> Result<bool> {
    let third = (b - a) / 3.0;
    // At a knot, the derivative of the piece inside.
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
    let points = points.map(|point| point.to_array());
    add(&Segment::Nurbs { degree: 3, knots: &[a, a, a, a, b, b, b, b], points: &points, weights: &[] })?;
    Ok(true)
}

fn bezier(points: &[DVec3; 4], t: f64) -> DVec3 {
    let s = 1.0 - t;
    let [p, q, r, e] = points;
    *p * (s * s * s) + *q * (3.0 * s * s * t) + *r * (3.0 * s * t * t) + *e * (t * t * t)
}
