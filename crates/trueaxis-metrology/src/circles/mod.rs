//! Reference circles: least squares, minimum zone, maximum inscribed, minimum circumscribed.
//!
//! Point sets are evaluated in the plane ([`least_squares()`], [`minimum_zone()`], [`minimum_circumscribed`],
//! [`maximum_inscribed`]), profiles of a roundness instrument with unknown radius in the limaçon approximation ([`limacon`]).
//! Terms after ISO 12181-1:2011: LSC (LSCI), MZC (MZCI), MCC (MCCI), MIC (MICI). [`smallest_width`] is the minimum zone of a
//! straight line.
//!
//! The minimum zone, the inscribed and the circumscribed circle are vertices of an arrangement: two or three linear equations
//! give each of them in closed form, and the search only decides which points determine it. The search is finite; no result
//! depends on a convergence tolerance. All circles are computed about a local origin from e = |p|² − R², formed with twice the
//! digits, so that a zone keeps its relative accuracy far from the origin of the coordinates and even if it is many orders of
//! magnitude smaller than the radius.
//!
//! ```
//! use trueaxis_metrology::circles::{maximum_inscribed, minimum_circumscribed, minimum_zone};
//!
//! let points = [[10.0, 0.0], [0.0, 10.2], [-10.0, 0.0], [0.0, -10.2]];
//! let zone = minimum_zone(&points)?;
//! assert!((zone.zone - 0.2).abs() < 1e-12 && zone.contacts == [0, 1, 2, 3]);
//! assert!((minimum_circumscribed(&points)?.radius - 10.2).abs() < 1e-12);
//! assert!(maximum_inscribed(&points).is_ok());
//! # Ok::<(), trueaxis_metrology::circles::NoCircle>(())
//! ```

mod circumscribed;
mod inscribed;
mod least_squares;
pub mod limacon;
mod local;
mod minimum_zone;
mod width;

pub use circumscribed::minimum_circumscribed;
pub use inscribed::maximum_inscribed;
pub use least_squares::least_squares;
pub use minimum_zone::minimum_zone;
pub use width::{hull, smallest_width};

use std::vec::Vec;

/// A reference circle and the zone of all points about its centre, in the unit of the points.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceCircle {
    /// Centre; for a limaçon the coefficients of cos θ and sin θ.
    pub centre: [f64; 2],
    /// LSC: mean distance of the points; MCC: outer; MIC: inner; MZC: mean of outer and inner.
    pub radius: f64,
    /// Width of the zone, outer − inner, formed without cancellation.
    pub zone: f64,
    /// Largest distance of a point from the centre.
    pub outer: f64,
    /// Smallest distance of a point from the centre.
    pub inner: f64,
    /// Ascending indices of the points that determine the circle: three or four for a zone, three for an inscribed, two or
    /// three for a circumscribed circle; empty for least squares, where all points do.
    pub contacts: Vec<usize>,
}

/// Why the points have no reference circle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoCircle {
    /// Fewer than three points.
    TooFew {
        /// Number of points.
        found: usize,
    },
    /// A coordinate, angle or reading is not finite.
    NonFinite {
        /// Index of the point.
        index: usize,
    },
    /// All points are collinear or coincident, or a straight strip contains them at least as closely as any circle.
    Straight,
    /// Some points are so much farther away than others that rounding hides the best circle.
    Unresolved,
    /// The points leave half a turn or more open: a circle could move out through the gap, so no extremum exists.
    PartArc,
    /// The numbers of angles and readings differ.
    Lengths {
        /// Number of angles.
        angles: usize,
        /// Number of readings.
        readings: usize,
    },
}

impl core::fmt::Display for NoCircle {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooFew { found } => write!(f, "points: found {found}, needed at least 3"),
            Self::NonFinite { index } => write!(f, "found a value that is not finite at index {index}"),
            Self::Straight => f.write_str("found points that fit a straight line as well as any circle"),
            Self::Unresolved => {
                f.write_str("found points so much farther away than others that rounding hides the circle")
            }
            Self::PartArc => {
                f.write_str("found a part arc that leaves half a turn or more open, needed points all round")
            }
            Self::Lengths { angles, readings } => {
                write!(f, "found {angles} angles and {readings} readings, needed as many of both")
            }
        }
    }
}

impl core::error::Error for NoCircle {}

/// Refuses inputs without any reference circle: fewer than three points, values that are not finite, and points within
/// rounding of one line.
fn check(points: &[[f64; 2]]) -> Result<(), NoCircle> {
    if points.len() < 3 {
        return Err(NoCircle::TooFew { found: points.len() });
    }
    // Squares must not overflow either.
    if let Some(index) = points.iter().position(|p| !p.iter().all(|v| v.abs() < 1e150)) {
        return Err(NoCircle::NonFinite { index });
    }
    let farthest = |from: [f64; 2]| {
        let distance = |p: &[f64; 2]| (p[0] - from[0]).hypot(p[1] - from[1]);
        points.iter().fold((from, 0.0), |best, p| if distance(p) > best.1 { (*p, distance(p)) } else { best })
    };
    let (a, _) = farthest(points[0]);
    let (b, length) = farthest(a);
    let line = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    let height = points.iter().map(|p| ((p[0] - a[0]) * line[1] - (p[1] - a[1]) * line[0]).abs()).fold(0.0, f64::max);
    let largest = points.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    // Rounding moves points by up to half a unit in the last place of the largest coordinate.
    if height <= 4.0 * f64::EPSILON * largest { Err(NoCircle::Straight) } else { Ok(()) }
}

/// Largest angle, rad, between neighbouring directions.
fn largest_gap(directions: impl Iterator<Item = f64>) -> f64 {
    let mut angles: Vec<f64> = directions.collect();
    angles.sort_by(f64::total_cmp);
    let around = match (angles.first(), angles.last()) {
        (Some(first), Some(last)) => first + core::f64::consts::TAU - last,
        _ => core::f64::consts::TAU,
    };
    angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max)
}
