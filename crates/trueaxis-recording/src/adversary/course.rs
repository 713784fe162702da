//! Paths on which the foot-point search is hard.

use super::random::Random;
use heapless::Vec;
use trueaxis::contour::{Path, PathError, Segment, Span, convert};
use trueaxis::glam::DVec3;
use trueaxis::{Position, Real};

/// Number of different courses.
pub const COURSES: usize = 16;
/// Maximum number of spans of a course.
const SPANS: usize = 96;
/// Normal of the machining plane.
const PLANE: [f64; 3] = [0.0, 0.0, 1.0];

/// A path that begins at a point of the tables of all three axes.
#[derive(Clone, Debug)]
pub struct Course<R, P> {
    spans: Vec<Span<R, P>, SPANS>,
    closed: bool,
}

impl<R: Real, P: Position> Course<R, P> {
    /// Course `number` of [`COURSES`]: two of each kind.
    ///
    /// | | |
    /// |---|---|
    /// | 0 | straight lines in space, 0.2 to 5 mm, with corners of any angle |
    /// | 1 | out and back: legs of 3 mm, 30 µm apart or on each other |
    /// | 2 | lines of 15 to 60 µm |
    /// | 3 | closed: two lines and two semicircles of 0.3 or 1 mm |
    /// | 4 | rational cubic spline, narrow bends, weights 0.3 to 3 |
    /// | 5 | helix and a spline of degree 5 |
    /// | 6 | cubics with cusps and loops |
    /// | 7 | closed circle of 0.25 or 0.6 mm: its centre is as near as the path |
    pub fn new(number: usize) -> Self {
        let mut course = Course { spans: Vec::new(), closed: matches!(number % 8, 3 | 7) };
        let second = number >= 8;
        let start = if second { DVec3::new(100.0, -50.0, -250.0) } else { DVec3::new(0.0, 0.0, -200.0) };
        let mut random = Random::new(1000 + number as u32);
        match number % 8 {
            0 => course.lines(start, 24, |_| {
                let length = 0.2 + 4.8 * random.unit::<f64>() * random.unit::<f64>();
                direction(&mut random) * length
            }),
            1 => course.hairpins(start, if second { 0.0 } else { 0.03 }),
            2 => course.lines(start, SPANS, |_| direction(&mut random) * (0.015 + 0.045 * random.unit::<f64>())),
            3 => course.racetrack(start, if second { 1.0 } else { 0.3 }),
            4 => course.rational(start, &mut random),
            5 => course.turns(start, &mut random),
            6 => course.cusps(start, &mut random),
            _ => course.circle(start, if second { 0.6 } else { 0.25 }),
        }
        course
    }

    /// The path for the step.
    pub fn path(&self) -> Path<'_, R, P> {
        Path::new(&self.spans, 0, self.closed)
    }

    /// Number of spans.
    pub(super) fn len(&self) -> u32 {
        self.spans.len() as u32
    }

    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    /// Leaves out a segment that is not a path or does not fit.
    fn add(&mut self, segment: &Segment<'_>) {
        let held = self.spans.len();
        let full = PathError { field: "course", index: None, found: SPANS as f64, needed: "fewer spans" };
        let spans = &mut self.spans;
        if convert(segment, held as u32, PLANE, |span| spans.push(span).map_err(|_| full)).is_err() {
            self.spans.truncate(held);
        }
    }

    fn lines(&mut self, mut start: DVec3, count: usize, mut step: impl FnMut(usize) -> DVec3) {
        for number in 0..count {
            let end = start + step(number);
            self.add(&Segment::Line { start, end });
            start = end;
        }
    }

    fn hairpins(&mut self, start: DVec3, apart: f64) {
        self.lines(start, 40, |number| match number % 4 {
            0 => DVec3::new(3.0, 0.0, 0.0),
            2 => DVec3::new(-3.0, 0.0, 0.0),
            _ if apart > 0.0 => DVec3::new(0.0, apart, 0.0),
            _ => DVec3::new(0.0, 0.0, 0.2),
        });
    }

    fn arc(&mut self, start: DVec3, end: DVec3, turns: u32) {
        let middle = 0.5 * (start + end);
        let center = DVec3::new(middle.x, middle.y, start.z);
        self.add(&Segment::Arc { start, end, center, normal: PLANE.into(), turns });
    }

    fn racetrack(&mut self, a: DVec3, radius: f64) {
        let b = a + DVec3::new(2.0, 0.0, 0.0);
        let across = DVec3::new(0.0, 2.0 * radius, 0.0);
        self.add(&Segment::Line { start: a, end: b });
        self.arc(b, b + across, 0);
        self.add(&Segment::Line { start: b + across, end: a + across });
        self.arc(a + across, a, 0);
    }

    fn circle(&mut self, start: DVec3, radius: f64) {
        let opposite = start - DVec3::new(2.0 * radius, 0.0, 0.0);
        self.arc(start, opposite, 0);
        self.arc(opposite, start, 0);
    }

    fn rational(&mut self, start: DVec3, random: &mut Random) {
        const POINTS: usize = 14;
        let mut points = [start; POINTS];
        let mut weights = [1.0; POINTS];
        let mut at = start;
        for (point, weight) in points.iter_mut().zip(&mut weights) {
            *point = at;
            *weight = 0.3 + 2.7 * random.unit::<f64>();
            at += direction(random) * (0.2 + 1.5 * random.unit::<f64>());
        }
        let knots: [f64; POINTS + 4] = core::array::from_fn(|i| i.saturating_sub(3).min(POINTS - 3) as f64);
        self.add(&Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights: &weights });
    }

    fn turns(&mut self, start: DVec3, random: &mut Random) {
        let end = start + DVec3::new(-1.6, 0.0, 0.7);
        self.arc(start, end, 1);
        let mut points = [end; 8];
        let mut at = end;
        for point in &mut points {
            *point = at;
            at += direction(random) * (0.3 + 1.2 * random.unit::<f64>());
        }
        let knots: [f64; 14] = core::array::from_fn(|i| i.saturating_sub(5).min(3) as f64);
        self.add(&Segment::Nurbs { degree: 5, knots: &knots, points: &points, weights: &[] });
    }

    fn cusps(&mut self, mut start: DVec3, random: &mut Random) {
        for number in 0..6 {
            // The inner points swap order: at 3/2 of the chord the curve is nearly a cusp, beyond it a loop.
            let reach = 1.0 + 0.25 * f64::from(number);
            let chord = DVec3::new(1.5, 0.4 * random.signed::<f64>(), 0.0);
            let up = DVec3::new(0.0, 0.8, 0.2);
            let points = [start, start + reach * chord + up, start + (1.0 - reach) * chord + up, start + chord];
            let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
            self.add(&Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights: &[] });
            start += chord;
        }
    }
}

/// A random direction, length about 1.
fn direction(random: &mut Random) -> DVec3 {
    let any = DVec3::new(random.signed(), random.signed(), 0.5 * random.signed::<f64>());
    any / any.abs().max_element().max(0.01)
}
