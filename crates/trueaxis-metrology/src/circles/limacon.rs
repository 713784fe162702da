//! Reference circles of a profile without a known radius, in the limaçon approximation.
//!
//! A roundness instrument reads r(θ) with an unknown constant; a circle of radius R off centre by (a, b) appears as
//!
//! r = R + a cos θ + b sin θ          (limaçon; exact to first order in the eccentricity over the radius).
//!
//! Angles in rad, readings in any unit of length, positive outwards; results in that unit, `centre` = [a, b]. Distances are
//! residuals r − a cos θ − b sin θ, so that `radius`, `inner` and `outer` contain the profile's arbitrary constant and may be
//! negative. All four problems are linear. Least squares has a direct solution. The others are small linear programmes, solved
//! exactly on the few readings that determine them (cutting planes: the worst reading joins until no reading is outside; no
//! reading joins twice, so the search is finite). Cost: linear, some ten passes.
//!
//! ```
//! use trueaxis_metrology::circles::limacon;
//!
//! // 2 µm out of centre, three lobes of ±1 µm.
//! let profile: Vec<f64> = (0..360)
//!     .map(|i| f64::from(i).to_radians())
//!     .map(|theta| 5.0 + 2.0 * theta.cos() + (3.0 * theta).cos())
//!     .collect();
//! let circle = limacon::minimum_zone(&profile)?;
//! assert!((circle.zone - 2.0).abs() < 1e-12 && (circle.centre[0] - 2.0).abs() < 1e-12);
//! # Ok::<(), trueaxis_metrology::circles::NoCircle>(())
//! ```

use super::{NoCircle, ReferenceCircle, largest_gap};
use core::f64::consts::{PI, TAU};
use std::vec::Vec;

/// Least-squares circle of readings equidistant over one turn, θᵢ = 2πi/N: R = mean, a = 2/N Σ r cos θ, b = 2/N Σ r sin θ.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn least_squares(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    least_squares_at(&even(profile.len()), profile)
}

/// Minimum zone circle of readings equidistant over one turn: the smallest range of the residuals.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn minimum_zone(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    minimum_zone_at(&even(profile.len()), profile)
}

/// Minimum circumscribed circle of readings equidistant over one turn: the smallest maximum of the residuals.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn minimum_circumscribed(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    minimum_circumscribed_at(&even(profile.len()), profile)
}

/// Maximum inscribed circle of readings equidistant over one turn: the largest minimum of the residuals.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn maximum_inscribed(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    maximum_inscribed_at(&even(profile.len()), profile)
}

/// The four circles of readings equidistant over one turn: least squares, minimum zone, maximum inscribed, minimum
/// circumscribed. The same as one by one; what they share is computed once.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn four_circles(profile: &[f64]) -> Result<[ReferenceCircle; 4], NoCircle> {
    let profile = Profile::new(&even(profile.len()), profile)?;
    let least_squares = profile.least_squares()?;
    let solve = |aim| profile.solve(least_squares.centre, aim);
    let [zone, inscribed, circumscribed] = [Aim::Zone, Aim::Inner, Aim::Outer].map(solve);
    Ok([least_squares, zone, inscribed, circumscribed])
}

/// Least-squares circle of readings at any angles.
///
/// # Errors
///
/// [`NoCircle::Lengths`], [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`] (fewer than three directions).
pub fn least_squares_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    Profile::new(theta, r)?.least_squares()
}

/// Minimum zone circle of readings at any angles: exact Chebyshev approximation by 1, cos θ, sin θ. Radius: mean of outer and
/// inner.
///
/// # Errors
///
/// [`NoCircle::Lengths`], [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`] (fewer than three directions).
pub fn minimum_zone_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let profile = Profile::new(theta, r)?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Zone))
}

/// Minimum circumscribed circle of readings at any angles. Radius: outer.
///
/// # Errors
///
/// As [`minimum_zone_at`]; [`NoCircle::PartArc`] if half a turn or more has no reading.
pub fn minimum_circumscribed_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let profile = Profile::new(theta, r)?;
    profile.closed()?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Outer))
}

/// Maximum inscribed circle of readings at any angles. Radius: inner.
///
/// # Errors
///
/// As [`minimum_circumscribed_at`].
pub fn maximum_inscribed_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let profile = Profile::new(theta, r)?;
    profile.closed()?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Inner))
}

fn even(n: usize) -> Vec<f64> {
    (0..n).map(|i| TAU * i as f64 / n as f64).collect()
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    /// cos θ, sin θ.
    direction: [f64; 2],
    /// θ of the direction, −π to π.
    angle: f64,
    r: f64,
    index: usize,
}

impl Reading {
    fn residual(&self, centre: [f64; 2]) -> f64 {
        self.r - (self.direction[0] * centre[0] + self.direction[1] * centre[1])
    }
}

/// Quantity to be minimised.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aim {
    Zone,
    Outer,
    Inner,
}

struct Profile {
    /// Readings minus the middle of their range.
    points: Vec<Reading>,
    middle: f64,
}

/// Largest and smallest residual with their readings.
#[derive(Clone, Copy, Debug)]
struct Range {
    high: (f64, Reading),
    low: (f64, Reading),
}

fn range(highest: &[Reading], lowest: &[Reading], centre: [f64; 2]) -> Option<Range> {
    let valued = |p: &Reading| (p.residual(centre), *p);
    let high = highest.iter().map(valued).reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    let low = lowest.iter().map(valued).reduce(|a, b| if b.0 < a.0 { b } else { a })?;
    Some(Range { high, low })
}

impl Aim {
    fn value(self, range: &Range) -> f64 {
        match self {
            Self::Zone => range.high.0 - range.low.0,
            Self::Outer => range.high.0,
            Self::Inner => -range.low.0,
        }
    }

    /// Whether the value about a centre is below `best`; most centres are refused after a few readings.
    fn improves(self, highest: &[Reading], lowest: &[Reading], centre: [f64; 2], best: f64) -> bool {
        let (mut high, mut low) = match self {
            Self::Zone => (highest.first().map_or(f64::NEG_INFINITY, |p| p.residual(centre)), f64::INFINITY),
            Self::Outer => (f64::NEG_INFINITY, 0.0),
            Self::Inner => (0.0, f64::INFINITY),
        };
        let below = |high: f64, low: f64| high - low < best;
        (self == Self::Outer
            || lowest.iter().all(|p| {
                low = low.min(p.residual(centre));
                below(high, low)
            }))
            && (self == Self::Inner
                || highest.iter().all(|p| {
                    high = high.max(p.residual(centre));
                    below(high, low)
                }))
    }
}

impl Profile {
    fn new(theta: &[f64], r: &[f64]) -> Result<Self, NoCircle> {
        if theta.len() != r.len() {
            return Err(NoCircle::Lengths { angles: theta.len(), readings: r.len() });
        }
        if r.len() < 3 {
            return Err(NoCircle::TooFew { found: r.len() });
        }
        if let Some(index) = theta.iter().zip(r).position(|(t, r)| !(t.is_finite() && r.abs() < 1e150)) {
            return Err(NoCircle::NonFinite { index });
        }
        let most = r.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = r.iter().copied().fold(f64::INFINITY, f64::min);
        let middle = 0.5 * (most + least);
        let reading = |(index, (t, r)): (usize, (&f64, &f64))| {
            let (sin, cos) = t.sin_cos();
            Reading { direction: [cos, sin], angle: sin.atan2(cos), r: r - middle, index }
        };
        Ok(Self { points: theta.iter().zip(r).enumerate().map(reading).collect(), middle })
    }

    fn least_squares(&self) -> Result<ReferenceCircle, NoCircle> {
        let n = self.points.len() as f64;
        let mut centre = [0.0; 2];
        // The second pass removes the rounding error of the first.
        for _ in 0..2 {
            let mut sums = [0.0; 8];
            for p in &self.points {
                let value = p.residual(centre);
                let [c, s] = p.direction;
                let terms = [c, s, c * c, c * s, s * s, c * value, s * value, value];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            }
            let [c, s, cc, cs, ss, cr, sr, r] = sums;
            let (cc, cs, ss) = (cc - c * c / n, cs - c * s / n, ss - s * s / n);
            let (cr, sr) = (cr - c * r / n, sr - s * r / n);
            let determinant = cc * ss - cs * cs;
            if determinant.is_nan() || determinant <= 1e-24 * n * n {
                return Err(NoCircle::Straight);
            }
            centre = [centre[0] + (cr * ss - sr * cs) / determinant, centre[1] + (sr * cc - cr * cs) / determinant];
        }
        let mean = self.points.iter().map(|p| p.residual(centre)).sum::<f64>() / n;
        Ok(ReferenceCircle { radius: mean + self.middle, ..self.circle(centre, Vec::new()) })
    }

    /// Refuses readings that leave half a turn open.
    fn closed(&self) -> Result<(), NoCircle> {
        let gap = largest_gap(self.points.iter().map(|p| p.angle));
        if gap >= PI * (1.0 - 1e-12) { Err(NoCircle::PartArc) } else { Ok(()) }
    }

    fn circle(&self, centre: [f64; 2], mut contacts: Vec<usize>) -> ReferenceCircle {
        contacts.sort_unstable();
        contacts.dedup();
        let (high, low) = range(&self.points, &self.points, centre).map_or((0.0, 0.0), |r| (r.high.0, r.low.0));
        ReferenceCircle {
            centre,
            radius: self.middle + 0.5 * (high + low),
            zone: high - low,
            outer: self.middle + high,
            inner: self.middle + low,
            contacts,
        }
    }

    /// Extends the optimum over a few readings to all: the reading farthest outside joins.
    fn solve(&self, start: [f64; 2], aim: Aim) -> ReferenceCircle {
        let [mut highest, mut lowest] = self.around(start);
        let mut best = Vertex::of(start, &[]);
        loop {
            let vertex = Vertex::best(&highest, &lowest, aim).unwrap_or(Vertex::of(start, &[]));
            let Some(all) = range(&self.points, &self.points, vertex.centre) else { break };
            best = vertex;
            let mut grown = false;
            for (list, (_, worst), counts) in
                [(&mut highest, all.high, aim != Aim::Inner), (&mut lowest, all.low, aim != Aim::Outer)]
            {
                // A reading that is not among the few is outside them, or level with one of them.
                if counts && !list.iter().any(|p| p.index == worst.index) {
                    list.push(worst);
                    grown = true;
                }
            }
            if !grown {
                break;
            }
        }
        // Two opposite readings alone leave the centre free along a line: the least-squares centre is then as good.
        let as_good = |at: &Range| aim.value(at) <= best.value + 8.0 * f64::EPSILON * best.value.abs();
        if aim != Aim::Zone && range(&self.points, &self.points, start).as_ref().is_some_and(as_good) {
            best = Vertex::of(start, &[]);
        }
        let touching = self.touching(best.centre, aim);
        // With symmetry, readings that do not touch can determine the same centre.
        if best.contacts.is_empty() || best.contacts.iter().any(|i| !touching.contains(i)) {
            best.contacts = touching;
        }
        let circle = self.circle(best.centre, best.contacts);
        let radius = match aim {
            Aim::Zone => circle.radius,
            Aim::Outer => circle.outer,
            Aim::Inner => circle.inner,
        };
        ReferenceCircle { radius, ..circle }
    }

    /// Readings on the relevant circles, to rounding.
    fn touching(&self, centre: [f64; 2], aim: Aim) -> Vec<usize> {
        let Some(at) = range(&self.points, &self.points, centre) else { return Vec::new() };
        let size = centre[0].hypot(centre[1]) + at.high.0.abs().max(at.low.0.abs());
        let tie = 64.0 * f64::EPSILON * size;
        let touches = |p: &&Reading| {
            let value = p.residual(centre);
            (aim != Aim::Inner && value >= at.high.0 - tie) || (aim != Aim::Outer && value <= at.low.0 + tie)
        };
        self.points.iter().filter(touches).map(|p| p.index).collect()
    }

    /// Extreme readings about the least-squares circle in five equally large groups, in the order of their angles, and three
    /// readings that surround the centre: without these the few could have no optimum.
    fn around(&self, start: [f64; 2]) -> [Vec<Reading>; 2] {
        let mut sorted = self.points.clone();
        sorted.sort_by(|a, b| a.angle.total_cmp(&b.angle));
        let order = |a: &&Reading, b: &&Reading| a.residual(start).total_cmp(&b.residual(start));
        let groups = || sorted.chunks(sorted.len().div_ceil(5));
        let mut lists = [
            groups().filter_map(|group| group.iter().max_by(order)).copied().collect::<Vec<Reading>>(),
            groups().filter_map(|group| group.iter().min_by(order)).copied().collect(),
        ];
        // The first reading and the readings next to its opposite on both sides.
        let first = self.points[0];
        let turned = |p: &Reading| (p.angle - first.angle).rem_euclid(TAU);
        let left = sorted.iter().filter(|p| turned(p) <= PI).max_by(|a, b| turned(a).total_cmp(&turned(b)));
        let right = sorted.iter().filter(|p| turned(p) >= PI).min_by(|a, b| turned(a).total_cmp(&turned(b)));
        for list in &mut lists {
            for p in [Some(&first), left, right].into_iter().flatten() {
                if !list.iter().any(|other| other.index == p.index) {
                    list.push(*p);
                }
            }
        }
        lists
    }
}

/// A centre determined by some readings.
#[derive(Clone, Debug)]
struct Vertex {
    centre: [f64; 2],
    contacts: Vec<usize>,
    value: f64,
}

impl Vertex {
    fn of(centre: [f64; 2], contacts: &[&Reading]) -> Self {
        Self { centre, contacts: contacts.iter().map(|p| p.index).collect(), value: f64::INFINITY }
    }

    /// The best of all centres that the readings can determine: three level ones above or below, or two and two.
    fn best(highest: &[Reading], lowest: &[Reading], aim: Aim) -> Option<Self> {
        let mut best: Option<Self> = None;
        let mut offer = |a: &Reading, b: &Reading, c: &Reading, d: &Reading, triple: bool| {
            let Some(centre) = level(a, b, c, d) else { return };
            if !aim.improves(highest, lowest, centre, best.as_ref().map_or(f64::INFINITY, |best| best.value)) {
                return;
            }
            let Some(at) = range(highest, lowest, centre) else { return };
            let value = aim.value(&at);
            if best.as_ref().is_none_or(|best| value < best.value) {
                let of = match (triple, aim) {
                    (false, _) => [a, b, c, d].to_vec(),
                    (true, Aim::Zone) if a.residual(centre) > 0.5 * (at.high.0 + at.low.0) => {
                        [a, b, d, &at.low.1].to_vec()
                    }
                    (true, Aim::Zone) => [a, b, d, &at.high.1].to_vec(),
                    (true, _) => [a, b, d].to_vec(),
                };
                best = Some(Self { value, ..Self::of(centre, &of) });
            }
        };
        let mut triples = |list: &[Reading]| {
            for (i, a) in list.iter().enumerate() {
                for (j, b) in list.iter().enumerate().skip(i + 1) {
                    for c in &list[j + 1..] {
                        offer(a, b, a, c, true);
                    }
                }
            }
        };
        if aim != Aim::Inner {
            triples(highest);
        }
        if aim != Aim::Outer {
            triples(lowest);
        }
        if aim == Aim::Zone {
            for (i, a) in highest.iter().enumerate() {
                for b in &highest[i + 1..] {
                    for (k, c) in lowest.iter().enumerate() {
                        for d in &lowest[k + 1..] {
                            offer(a, b, c, d, false);
                        }
                    }
                }
            }
        }
        best
    }
}

/// The centre at which the residuals of a and b are equal, and those of c and d.
fn level(a: &Reading, b: &Reading, c: &Reading, d: &Reading) -> Option<[f64; 2]> {
    let (x1, y1, h1) = (a.direction[0] - b.direction[0], a.direction[1] - b.direction[1], a.r - b.r);
    let (x2, y2, h2) = (c.direction[0] - d.direction[0], c.direction[1] - d.direction[1], c.r - d.r);
    let determinant = x1 * y2 - x2 * y1;
    let centre = [(h1 * y2 - h2 * y1) / determinant, (x1 * h2 - x2 * h1) / determinant];
    (centre[0].is_finite() && centre[1].is_finite()).then_some(centre)
}
