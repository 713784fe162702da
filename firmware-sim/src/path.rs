//! The program as the plugin's path: spans, and where on them the interpolator is.

use crate::program::{Curve, Program};
use anyhow::{Result, anyhow};
use trueaxis::contour::{Reference, Segment, Span, convert};

/// The path of a whole program, converted once.
#[derive(Debug)]
pub struct PlannedPath {
    /// All spans in path order.
    pub spans: Vec<Span<f64, f64>>,
    /// First span of every move, and one past the last.
    first: Vec<u32>,
}

impl PlannedPath {
    /// Converts a program whose zero lies at `origin_mm` in machine coordinates.
    ///
    /// # Errors
    /// A move that is no path (the program reader refuses those before).
    pub fn new(program: &Program, origin_mm: [f64; 3]) -> Result<PlannedPath> {
        let shift = |p: &[f64; 3]| std::array::from_fn(|k| p[k] + origin_mm[k]);
        let mut path = PlannedPath { spans: Vec::new(), first: Vec::new() };
        for (index, step) in program.moves.iter().enumerate() {
            path.first.push(path.spans.len() as u32);
            let shifted: Vec<[f64; 3]>;
            let segment = match &step.curve {
                Curve::Line { start, end } => Segment::Line { start: shift(start), end: shift(end) },
                Curve::Arc { start, end, center, normal, turns } => Segment::Arc {
                    start: shift(start),
                    end: shift(end),
                    center: shift(center),
                    normal: *normal,
                    turns: *turns,
                },
                Curve::Nurbs { degree, knots, points, weights } => {
                    shifted = points.iter().map(shift).collect();
                    Segment::Nurbs { degree: *degree, knots, points: &shifted, weights }
                }
            };
            convert(&segment, index as u32, step.plane_normal, |span| {
                path.spans.push(span);
                Ok(())
            })
            .map_err(|e| anyhow!("{}, line {}: {e}", program.name, step.line))?;
        }
        path.first.push(path.spans.len() as u32);
        Ok(path)
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
