//! A programmed circle.

use glam::DVec3;

/// Distance below which programmed points are equal, mm: the rounding of a program.
pub(super) const NEAR: f64 = 2e-3;

/// A programmed circle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Circle {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

impl Circle {
    /// Whether two circles are equal within the rounding of a program.
    pub(super) fn is_near(&self, other: &Circle) -> bool {
        (self.centre - other.centre).length() <= NEAR && (self.radius - other.radius).abs() <= NEAR
    }
}

/// The first of some points, the one farthest from it, and the one farthest from the line through both; none if all are one.
pub(super) fn apart(points: &[DVec3]) -> Option<[DVec3; 3]> {
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        points.iter().copied().max_by(|one, other| distance(*one).total_cmp(&distance(*other)))
    };
    let one = *points.first()?;
    let other = farthest(&|point| (point - one).length())?;
    let along = (other - one).try_normalize()?;
    Some([one, other, farthest(&|point| (point - one).reject_from_normalized(along).length())?])
}

/// The circle through points, with its normal; none if they are within a millimetre of a line.
pub(super) fn circle_through(points: &[DVec3]) -> Option<(Circle, DVec3)> {
    let [one, other, third] = apart(points)?;
    let (a, b) = (other - one, third - one);
    let normal = a.cross(b);
    if normal.length() < a.length() {
        return None;
    }
    let to_centre =
        (b.length_squared() * normal.cross(a) + a.length_squared() * b.cross(normal)) / (2.0 * normal.length_squared());
    Some((Circle { centre: one + to_centre, radius: to_centre.length() }, normal.normalize()))
}
