//! The nearest foot of a whole path, with nothing known: for planners and files, not for cycles.

use super::ContourError;
use super::convert::REACH;
use super::offline::Best;
use super::refine::{at, dot};
use super::search::{ContourSearch, Method, components};
use super::span::{Path, Span};
use crate::position::Position;
use crate::real::Real;

/// Added to a span's reach, against rounding, mm.
const SLACK: f64 = 1e-3;

impl<R: Real, P: Position> Path<'_, R, P> {
    /// Contour error of `point` (mm): its distance from the nearest foot of the whole path.
    ///
    /// A minimum of the distance, an end or a corner; of two equally near ones the first. There is no reference: `lag` is
    /// zero. Without a span, or for a point that is infinite or not a number, nothing is measured.
    ///
    /// Not for a servo cycle: a span that may be nearer than the best so far takes 17 evaluations and at most 80 for each
    /// minimum in it, any other its distance from the point. `evaluations` saturates at 255.
    pub fn nearest(&self, point: [P; 3]) -> ContourError<R> {
        let (Some(first), true) = (self.spans.first(), point.iter().all(|x| x.is_usable())) else {
            return ContourError::none();
        };
        let whole = ContourSearch { max_lag: R::MAX, method: Method::Guarded };
        let numbered = || self.spans.iter().enumerate().map(|(i, span)| (self.first.wrapping_add(i as u32), span));
        let (mut seed, mut nearest) = ((self.first, first), R::MAX);
        for (number, span) in numbered() {
            let squared = squared_from_origin(span, &point);
            if squared < nearest {
                (seed, nearest) = ((number, span), squared);
            }
        }
        let mut spent = 0;
        let mut best = Best { minimum: None, sample: at(seed.1, seed.0, &point, R::HALF) };
        for (number, span) in numbered() {
            let far = R::of(REACH + SLACK) + dot(&best.sample.vector, &best.sample.vector).sqrt();
            if squared_from_origin(span, &point) <= far * far {
                whole.piece(self, number, R::ZERO, &point, &mut best, &mut 0, &mut spent);
            }
        }
        let found = best.answer();
        let error = dot(&found.vector, &found.vector).sqrt();
        components(self, &found, error, R::ZERO, spent)
    }
}

fn squared_from_origin<R: Real, P: Position>(span: &Span<R, P>, point: &[P; 3]) -> R {
    let ([x, y, z], [ox, oy, oz]) = (*point, span.origin);
    let away = [x.since(ox), y.since(oy), z.since(oz)];
    dot(&away, &away)
}

#[cfg(test)]
mod tests;
