//! The nearest foot on a whole path, without prior knowledge: for planners and files, not for servo cycles.

mod part;
pub(super) mod survey;

use super::ContourError;
use super::convert::REACH;
use super::refine::dot;
use super::search::{Method, components};
use super::span::{Path, Reference, Span};
use crate::position::Position;
use crate::real::Real;
use survey::Survey;

/// Allowance for rounding, added to a span's reach, mm.
const SLACK: f64 = 1e-3;
/// Largest distance of a span's points from its origin, in lengths of the span: the origin is the middle between the ends or,
/// of an arc, the middle of the arc, which lies beside it by less than tan(7.5°)/2 of the length.
const HALF_LENGTH: f64 = 0.57;

impl<R: Real, P: Position> Path<'_, R, P> {
    /// Contour error of `point` (mm): its distance from the nearest foot of the whole path.
    ///
    /// The foot is a minimum of the distance, an end or a corner; of two equally near ones, the first. `lag` is zero,
    /// since the query has no reference. Without a span, or for a point that is infinite or not a number, nothing is
    /// measured. Near the centre of an arc, where all points are equally far to rounding, the foot may be any of them,
    /// and need not be flagged *bracketed*.
    ///
    /// No foot is missed: a span is skipped only if a lower bound of its distance permits it, from its length or from
    /// its polynomial in Bernstein's basis, and halved until each part contains a single minimum or none.
    ///
    /// Not for a servo cycle: some thirty instructions for a distant span; two evaluations and a call of the kernel for one
    /// that may be nearest, or the closed form on lines. `evaluations` saturates at 255.
    pub fn nearest(&self, point: [P; 3]) -> ContourError<R> {
        let (Some(first), true) = (self.spans.first(), point.iter().all(|x| x.is_usable())) else {
            return ContourError::none();
        };
        let numbered = || self.spans.iter().enumerate().map(|(i, span)| (self.first.wrapping_add(i as u32), span));
        let (mut seed, mut nearest) = (self.first, squared_from_origin(first, &point));
        for (number, span) in numbered() {
            let squared = squared_from_origin(span, &point);
            if squared < nearest {
                (seed, nearest) = (number, squared);
            }
        }
        let mut survey = Survey {
            path: *self,
            point,
            method: Method::Guarded,
            counting: false,
            guess: Reference { span: seed, t: R::HALF },
            minimum: None,
            end: None,
            minima: 0,
            spent: 0,
        };
        survey.look(seed, R::ZERO, R::ONE);
        let mut far = survey.nearest().sqrt();
        for (number, span) in numbered() {
            let reach = far + reach(span);
            if squared_from_origin(span, &point) <= reach * reach && number != seed {
                survey.look(number, R::ZERO, R::ONE);
                far = survey.nearest().sqrt();
            }
        }
        let Some(found) = survey.answer() else { return ContourError::none() };
        let error = dot(&found.vector, &found.vector).sqrt();
        components(self, &found, error, R::ZERO, survey.spent)
    }
}

/// Largest distance of a span's points from its origin, mm.
#[inline(always)]
fn reach<R: Real, P: Position>(span: &Span<R, P>) -> R {
    (R::of(HALF_LENGTH) * span.length()).min(R::of(REACH)) + R::of(SLACK)
}

#[inline(always)]
fn squared_from_origin<R: Real, P: Position>(span: &Span<R, P>, point: &[P; 3]) -> R {
    let ([x, y, z], [ox, oy, oz]) = (*point, span.origin);
    let away = [x.since(ox), y.since(oy), z.since(oz)];
    dot(&away, &away)
}

#[cfg(test)]
mod random;
#[cfg(test)]
mod tests;
