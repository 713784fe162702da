//! Paths of a leg: lines, corners, arcs, a spline, hairpins, turns on the spot, in the middle of the machine's travel.

use super::dice::Dice;
use super::scalar::{Place, Scalar};
use trueaxis::contour::{PathError, Segment, Span, Turn, convert};
use trueaxis::glam::DVec3;

/// A path with the rotary positions along it.
#[derive(Clone, Debug)]
pub(super) struct Course<R: Scalar, P> {
    /// Spans in path order.
    pub spans: Vec<Span<R, P>>,
    /// Rotary positions, one for each span.
    pub turns: Vec<Turn<R>>,
    /// Whether start and end coincide.
    pub closed: bool,
}

impl<R: Scalar, P: Place> Course<R, P> {
    /// Draws a path about a centre, with lengths of about `size` mm.
    pub(super) fn draw(dice: &mut Dice, center: [f64; 3], size: f64, turning: bool) -> Self {
        let mut course = Course { spans: Vec::new(), turns: Vec::new(), closed: false };
        let mut at = DVec3::from(center);
        let mut rotary = [(); 3].map(|()| 5.0 + 20.0 * dice.unit());
        for number in 0..6 + dice.below(8) {
            let off = DVec3::new(dice.signed(), dice.signed(), 0.3 * dice.signed()) * size;
            let end = DVec3::from(center) + off;
            let after = rotary.map(|angle: f64| if turning { angle + 3.0 * dice.signed() } else { angle });
            let kind = dice.below(if turning { 6 } else { 5 });
            let middle = 0.5 * (at + end);
            let drawn = match kind {
                0 | 1 => course.add(number, &Segment::Line { start: at, end }, rotary, after),
                2 => {
                    let end = DVec3::new(end.x, end.y, at.z);
                    let center = DVec3::new(0.5 * (at.x + end.x), 0.5 * (at.y + end.y), at.z);
                    let normal = DVec3::Z * if dice.one_in(2) { 1.0 } else { -1.0 };
                    let arc = Segment::Arc { start: at, end, center, normal, turns: dice.below(2) as u32 };
                    course.add(number, &arc, rotary, after)
                }
                3 => {
                    let bend = DVec3::new(dice.signed(), dice.signed(), 0.0) * size;
                    let points = [at, middle + bend, middle - 0.5 * bend, end];
                    let weights = [1.0, dice.factor(0.3, 3.0), 1.0, 1.0];
                    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
                    course.add(
                        number,
                        &Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights: &weights },
                        rotary,
                        after,
                    )
                }
                // Out and back, on the same line or beside it.
                4 => {
                    let offset = DVec3::new(0.0, if dice.one_in(2) { 0.03 } else { 0.0 }, 0.0);
                    course.add(number, &Segment::Line { start: at, end: middle }, rotary, rotary)
                        && course.add(number, &Segment::Line { start: middle, end: at + offset }, rotary, after)
                }
                _ => course.add(number, &Segment::Turning { point: at }, rotary, after),
            };
            if let (true, Some(last)) = (drawn, course.spans.last()) {
                at = DVec3::from(last.position(R::ONE).map(P::to_f64));
                rotary = after;
            }
        }
        if let (Some(first), true) = (course.spans.first(), dice.one_in(3)) {
            let start = DVec3::from(first.position(R::ZERO).map(P::to_f64));
            course.closed = course.add(99, &Segment::Line { start: at, end: start }, rotary, rotary);
        }
        course
    }

    /// Adds a segment, unless it is not a valid path.
    fn add(&mut self, number: usize, segment: &Segment<'_>, start: [f64; 3], end: [f64; 3]) -> bool {
        let held = self.spans.len();
        let full = PathError { field: "course", index: None, found: 256.0, needed: "fewer spans" };
        let (spans, turns) = (&mut self.spans, &mut self.turns);
        let added = convert(segment, number as u32, [0.0, 0.0, 1.0], |span: Span<R, P>| {
            if spans.len() > 256 {
                return Err(full);
            }
            turns.push(Turn::axes(&span, [0.0, 1.0], start, end));
            spans.push(span);
            Ok(())
        });
        if added.is_err() {
            self.spans.truncate(held);
            self.turns.truncate(held);
        }
        added.is_ok()
    }
}
