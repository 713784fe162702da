//! Minimum zone of points near a plane: flatness after ISO 12781-1 (MZPL).

use core::f64::consts::SQRT_2;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use std::vec::Vec;

/// Offset in the plane that keeps any three points off one line, as a share of the extent: rows of points have many on one.
const APART: f64 = 1e-9;
/// Multiples of it and of √2 are spread evenly over 0 to 1.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// A point that exceeds the zone by less than this share of the extent is in it.
const ROUNDING: f64 = 1e-14;
/// Square of the slope below which a plane is that of its frame: the zone is then as wide along the frame's normal as along
/// its own.
const LEVEL: f64 = 1e-12;
/// Most frames, each with the normal found in the one before.
const FRAMES: usize = 20;

/// Two parallel planes that enclose all points, in the unit of the points.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneZone {
    /// Unit normal, of either sign.
    pub normal: [f64; 3],
    /// Distance of the two planes.
    pub width: f64,
    /// Indices of the points that determine it: two on each plane, or three on one and one on the other; empty if all points
    /// are in one plane.
    pub contacts: Vec<usize>,
}

/// Why points have no minimum zone plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoPlane {
    /// Fewer than four points.
    TooFew {
        /// Number of points.
        found: usize,
    },
    /// A coordinate is not finite.
    NonFinite {
        /// Index of the point.
        index: usize,
    },
    /// All points are on one line.
    Straight,
}

impl core::fmt::Display for NoPlane {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooFew { found } => write!(f, "points: found {found}, needed at least 4"),
            Self::NonFinite { index } => write!(f, "found a value that is not finite at index {index}"),
            Self::Straight => f.write_str("found points on one line, needed points that span a plane"),
        }
    }
}

impl core::error::Error for NoPlane {}

/// Two parallel planes at the smallest distance that enclose all points between them.
///
/// In a frame whose third axis is near the normal, four points with Σλ = Σλx = Σλy = 0 and Σ|λ| = 1 bound the zone of every
/// plane from below,
///
/// 2 |Σ λᵢ zᵢ| <= width,
///
/// since the sum is the same for z − ax − by − c. The plane with |z − ax − by − c| = |Σλz| at the four points reaches that
/// bound for them. Exchange: the point farthest outside replaces the one of the four that raises the bound most, until none is
/// outside; then bound and zone are equal, which proves the minimum. The bound grows with every exchange, so no set occurs
/// twice. Signs of λ: two and two, or three and one.
///
/// This is repeated in the frame of the plane found, so that the distance is the one along the normal. Points that are W wide
/// in the plane have one such minimum if W is much more than the width w; another is smaller by 2 (w/W)² of it at most.
///
/// Cost: linear in the points, some ten passes.
///
/// # Errors
///
/// [`NoPlane::TooFew`], [`NoPlane::NonFinite`], [`NoPlane::Straight`].
///
/// # Source
///
/// Stiefel, *Note on Jordan elimination, linear programming and Tchebycheff approximation*, Numer. Math. 2 (1960).
///
/// # Example
///
/// ```
/// // A saddle: opposite corners are on the same plane.
/// let saddle = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.01], [100.0, 100.0, 0.0], [0.0, 100.0, 0.01]];
/// let zone = trueaxis_metrology::planes::minimum_zone(&saddle)?;
/// assert!((zone.width - 0.01).abs() < 1e-12);
/// # Ok::<(), trueaxis_metrology::planes::NoPlane>(())
/// ```
pub fn minimum_zone(points: &[[f64; 3]]) -> Result<PlaneZone, NoPlane> {
    if points.len() < 4 {
        return Err(NoPlane::TooFew { found: points.len() });
    }
    // Squares must not overflow either.
    if let Some(index) = points.iter().position(|p| !p.iter().all(|v| v.abs() < 1e150)) {
        return Err(NoPlane::NonFinite { index });
    }
    let count = points.len() as f64;
    let mean = points.iter().map(|p| Vector3::from(*p) / count).sum::<Vector3<f64>>();
    let centred: Vec<Vector3<f64>> = points.iter().map(|p| Vector3::from(*p) - mean).collect();
    let moments = SymmetricEigen::new(centred.iter().map(|p| p * p.transpose()).sum::<Matrix3<f64>>());
    let mut normal = moments.eigenvectors.column(moments.eigenvalues.imin()).into_owned();
    let mut zone = Frame::new(&centred, normal).zone()?;
    for _ in 0..FRAMES {
        let [a, b] = zone.slopes;
        if a * a + b * b < LEVEL {
            break;
        }
        normal = zone.normal;
        zone = Frame::new(&centred, normal).zone()?;
    }
    let along = centred.iter().map(|p| p.dot(&zone.normal));
    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    Ok(PlaneZone { normal: zone.normal.into(), width: high - low, contacts: zone.contacts })
}

/// Points along the axes of a frame.
struct Frame {
    axes: [Vector3<f64>; 3],
    points: Vec<[f64; 3]>,
    extent: f64,
}

/// A zone in a frame.
struct Zone {
    slopes: [f64; 2],
    normal: Vector3<f64>,
    contacts: Vec<usize>,
}

/// The plane z = ax + by + c with all four points at the distance |bound| along z.
struct Levelled {
    a: f64,
    b: f64,
    c: f64,
    bound: f64,
}

impl Frame {
    fn new(centred: &[Vector3<f64>], normal: Vector3<f64>) -> Frame {
        let first = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
        let axes = [first, normal.cross(&first), normal];
        let extent = centred.iter().map(|p| p.norm()).fold(0.0, f64::max);
        let off = |k: usize, by: f64| APART * extent * ((k + 1) as f64 * by).fract();
        let local = |(k, p): (usize, &Vector3<f64>)| {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| p.dot(&axes[axis]));
            [x + off(k, GOLDEN), y + off(k, SQRT_2), z]
        };
        Frame { axes, points: centred.iter().enumerate().map(local).collect(), extent }
    }

    fn zone(&self) -> Result<Zone, NoPlane> {
        let mut four = self.first()?;
        let mut plane = self.levelled(&four);
        // Every exchange raises the bound; the limit only guards against cycling due to rounding.
        for _ in 0..self.points.len() + 100 {
            let outside = |p: &[f64; 3]| (p[2] - plane.a * p[0] - plane.b * p[1] - plane.c).abs();
            let (far, most) = self.farthest(outside);
            if most <= plane.bound + ROUNDING * self.extent || four.contains(&far) {
                break;
            }
            let exchanged = (0..4).map(|k| {
                let mut next = four;
                next[k] = far;
                (self.levelled(&next), next)
            });
            let Some((next, with)) = exchanged.max_by(|one, other| one.0.bound.total_cmp(&other.0.bound)) else {
                break;
            };
            if next.bound <= plane.bound {
                break;
            }
            (plane, four) = (next, with);
        }
        let [x, y, z] = &self.axes;
        let normal = (z - plane.a * x - plane.b * y).normalize();
        let mut contacts = if plane.bound > ROUNDING * self.extent { four.to_vec() } else { Vec::new() };
        contacts.sort_unstable();
        Ok(Zone { slopes: [plane.a, plane.b], normal, contacts })
    }

    /// Index and value of the largest value.
    fn farthest(&self, of: impl Fn(&[f64; 3]) -> f64) -> (usize, f64) {
        let mut best = (0, f64::NEG_INFINITY);
        for (index, value) in self.points.iter().map(of).enumerate() {
            if value > best.1 {
                best = (index, value);
            }
        }
        best
    }

    /// Four points: three far apart, and the one farthest from their plane.
    fn first(&self) -> Result<[usize; 4], NoPlane> {
        let apart = |from: usize| {
            let [x, y, _] = self.points[from];
            self.farthest(|p| (p[0] - x).hypot(p[1] - y)).0
        };
        let (a, _) = self.farthest(|p| p[0].hypot(p[1]));
        let b = apart(a);
        let (c, area) = self.farthest(|p| turn(&self.points[a], &self.points[b], p).abs());
        if area <= 10.0 * APART * self.extent * self.extent {
            return Err(NoPlane::Straight);
        }
        let rest = (0..self.points.len()).filter(|k| ![a, b, c].contains(k)).map(|k| [a, b, c, k]);
        let bound = |four: &[usize; 4]| self.levelled(four).bound;
        rest.max_by(|one, other| bound(one).total_cmp(&bound(other))).ok_or(NoPlane::Straight)
    }

    fn levelled(&self, four: &[usize; 4]) -> Levelled {
        let p = four.map(|k| self.points[k]);
        // Twice the signed area of the triangle of the other three.
        let shares = [
            turn(&p[1], &p[2], &p[3]),
            -turn(&p[0], &p[2], &p[3]),
            turn(&p[0], &p[1], &p[3]),
            -turn(&p[0], &p[1], &p[2]),
        ];
        let whole: f64 = shares.iter().map(|share| share.abs()).sum();
        let bound = shares.iter().zip(&p).map(|(share, p)| share * p[2]).sum::<f64>() / whole;
        // The plane of the three with the largest triangle.
        let out = (0..4).max_by(|i, j| shares[*i].abs().total_cmp(&shares[*j].abs())).unwrap_or(0);
        let mut three =
            (0..4).filter(|k| *k != out).map(|k| [p[k][0], p[k][1], p[k][2] - bound.copysign(bound * shares[k])]);
        let mut next = || three.next().unwrap_or_default();
        let [q, r, s] = [next(), next(), next()];
        let [[ux, uy, uz], [vx, vy, vz]] = [r, s].map(|one| [one[0] - q[0], one[1] - q[1], one[2] - q[2]]);
        let area = ux * vy - uy * vx;
        let (a, b) = ((uz * vy - uy * vz) / area, (ux * vz - uz * vx) / area);
        Levelled { a, b, c: q[2] - a * q[0] - b * q[1], bound: bound.abs() }
    }
}

/// Twice the area of a triangle in the plane of the frame, positive if it is counter-clockwise.
fn turn(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
