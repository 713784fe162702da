//! The plane of points in space.

use trueaxis::glam::DVec3;

/// Sweeps of Jacobi's rotations: a 3 by 3 matrix is diagonal to the last bit after four or five.
const SWEEPS: usize = 12;

/// The least-squares plane: minimises the squares of the points' distances from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal; its largest component is positive.
    pub normal: [f64; 3],
    /// Largest minus smallest distance of the points from the plane, mm.
    pub flatness_mm: f64,
    /// Unit vectors in the plane, and the plane's distance from the origin along the normal, mm.
    across: [DVec3; 2],
    height: f64,
}

impl Plane {
    /// The plane of points, mm, and the points' coordinates in it.
    pub(super) fn of(points: &[[f64; 3]]) -> (Plane, Vec<[f64; 2]>) {
        let points: Vec<DVec3> = points.iter().copied().map(DVec3::from).collect();
        let mean = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let normal = principal(points.iter().map(|point| *point - mean))[0].1;
        let most = normal.abs().max_element();
        let normal = if normal.min_element() == -most { -normal } else { normal };
        let auxiliary = if normal.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let first = (auxiliary - normal * auxiliary.dot(normal)).normalize();
        let across = [first, normal.cross(first)];
        let heights = points.iter().map(|point| (*point - mean).dot(normal));
        let [low, high] =
            heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
        let flat = points.iter().map(|point| across.map(|along| point.dot(along))).collect();
        let flatness_mm = (high - low).max(0.0);
        (Plane { normal: normal.to_array(), flatness_mm, across, height: mean.dot(normal) }, flat)
    }

    /// The point in space, mm, of a point in the plane.
    pub fn at(&self, [one, other]: [f64; 2]) -> [f64; 3] {
        let [first, second] = self.across;
        (first * one + second * other + DVec3::from(self.normal) * self.height).to_array()
    }
}

/// Sums of the squares of the offsets along their principal directions, ascending, and these directions: by Jacobi's rotations of
/// the moments.
pub(crate) fn principal(offsets: impl Iterator<Item = DVec3>) -> [(f64, DVec3); 3] {
    let mut moments = [[0.0; 3]; 3];
    for offset in offsets.map(|offset| offset.to_array()) {
        for (row, one) in moments.iter_mut().zip(offset) {
            row.iter_mut().zip(offset).for_each(|(moment, other)| *moment += one * other);
        }
    }
    let mut turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(3 * SWEEPS) {
        if moments[p][q] == 0.0 {
            continue;
        }
        let (sin, cos) = (0.5 * (2.0 * moments[p][q]).atan2(moments[q][q] - moments[p][p])).sin_cos();
        let turn = |row: &mut [f64; 3]| (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
        moments.iter_mut().for_each(turn);
        turned.iter_mut().for_each(turn);
        let [one, other] = [moments[p], moments[q]];
        moments[p] = std::array::from_fn(|k| cos * one[k] - sin * other[k]);
        moments[q] = std::array::from_fn(|k| sin * one[k] + cos * other[k]);
    }
    let mut found = [0, 1, 2].map(|k| (moments[k][k], DVec3::from(turned.map(|row| row[k])).normalize()));
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}
