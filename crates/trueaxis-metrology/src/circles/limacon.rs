//! Reference circles of a profile without a known radius, in the limaçon approximation.
//!
//! A roundness instrument reads r(θ) with an unknown constant; a circle of radius R off centre by (a, b) appears as
//!
//! r = R + a cos θ + b sin θ          (limaçon; exact to first order in the eccentricity over the radius).
//!
//! Angles in rad, readings in any unit of length, positive outwards; results in that unit, `centre` = [a, b]. Distances are
//! residuals r − a cos θ − b sin θ, so that `radius`, `inner` and `outer` contain the profile's arbitrary constant and may be
//! negative. All four problems are linear. Least squares has a direct solution. The others are linear programmes: the simplex
//! method exchanges the few readings that determine a circle for worse ones until no reading is outside, and the circle is
//! then solved exactly on those few (where the exchange does not end, the worst reading joins the few, until no reading is
//! outside; no reading joins twice, so the search is finite). Cost: linear, some ten passes.
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
use nalgebra::{Matrix4, Vector4};
use std::vec::Vec;

/// Least-squares circle of readings equidistant over one turn, θᵢ = 2πi/N: R = mean, a = 2/N Σ r cos θ, b = 2/N Σ r sin θ.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn least_squares(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    Profile::new(&Directions::equidistant(profile.len()), profile)?.least_squares()
}

/// Minimum zone circle of readings equidistant over one turn: the smallest range of the residuals.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn minimum_zone(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let directions = Directions::equidistant(profile.len());
    let profile = Profile::new(&directions, profile)?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Zone))
}

/// Minimum circumscribed circle of readings equidistant over one turn: the smallest maximum of the residuals.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn minimum_circumscribed(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let directions = Directions::equidistant(profile.len());
    let profile = Profile::new(&directions, profile)?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Outer))
}

/// Maximum inscribed circle of readings equidistant over one turn: the largest minimum of the residuals.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
pub fn maximum_inscribed(profile: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let directions = Directions::equidistant(profile.len());
    let profile = Profile::new(&directions, profile)?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Inner))
}

/// Directions of N readings equidistant over one turn, for many profiles of N readings.
#[derive(Clone, Debug)]
pub struct Turn(Directions);

impl Turn {
    /// The directions of `points` readings.
    #[must_use]
    pub fn new(points: usize) -> Self {
        Self(Directions::equidistant(points))
    }

    /// Returns the four circles of a profile: least squares, minimum zone, maximum inscribed, minimum circumscribed. They equal
    /// the circles computed one by one; what they share is computed once.
    ///
    /// # Errors
    ///
    /// [`NoCircle::Lengths`], [`NoCircle::TooFew`], [`NoCircle::NonFinite`].
    pub fn four_circles(&self, profile: &[f64]) -> Result<[ReferenceCircle; 4], NoCircle> {
        let profile = Profile::new(&self.0, profile)?;
        let least_squares = profile.least_squares()?;
        let solve = |aim| profile.solve(least_squares.centre, aim);
        let [zone, inscribed, circumscribed] = [Aim::Zone, Aim::Inner, Aim::Outer].map(solve);
        Ok([least_squares, zone, inscribed, circumscribed])
    }
}

/// Least-squares circle of readings at any angles.
///
/// # Errors
///
/// [`NoCircle::Lengths`], [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`] (fewer than three directions).
pub fn least_squares_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    Profile::new(&Directions::at(theta), r)?.least_squares()
}

/// Minimum zone circle of readings at any angles: exact Chebyshev approximation by 1, cos θ, sin θ. Radius: mean of outer and
/// inner.
///
/// # Errors
///
/// [`NoCircle::Lengths`], [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`] (fewer than three directions).
pub fn minimum_zone_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let directions = Directions::at(theta);
    let profile = Profile::new(&directions, r)?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Zone))
}

/// Minimum circumscribed circle of readings at any angles. Radius: outer.
///
/// # Errors
///
/// As [`minimum_zone_at`]; [`NoCircle::PartArc`] if half a turn or more has no reading.
pub fn minimum_circumscribed_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let directions = Directions::at(theta);
    let profile = Profile::new(&directions, r)?;
    profile.closed()?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Outer))
}

/// Maximum inscribed circle of readings at any angles. Radius: inner.
///
/// # Errors
///
/// As [`minimum_circumscribed_at`].
pub fn maximum_inscribed_at(theta: &[f64], r: &[f64]) -> Result<ReferenceCircle, NoCircle> {
    let directions = Directions::at(theta);
    let profile = Profile::new(&directions, r)?;
    profile.closed()?;
    Ok(profile.solve(profile.least_squares()?.centre, Aim::Inner))
}

/// Directions θ of the readings.
#[derive(Clone, Debug)]
struct Directions {
    cos: Vec<f64>,
    sin: Vec<f64>,
    /// Sums of cos θ, sin θ, cos² θ, cos θ sin θ, sin² θ.
    sums: [f64; 5],
    /// First angle that is not finite.
    unusable: Option<usize>,
    equidistant: bool,
}

impl Directions {
    fn at(theta: &[f64]) -> Self {
        let (sin, cos): (Vec<f64>, Vec<f64>) = theta.iter().map(|theta| theta.sin_cos()).unzip();
        let mut sums = [0.0; 5];
        for (c, s) in cos.iter().zip(&sin) {
            sums.iter_mut().zip([*c, *s, c * c, c * s, s * s]).for_each(|(sum, term)| *sum += term);
        }
        let unusable = theta.iter().position(|theta| !theta.is_finite());
        Self { cos, sin, sums, unusable, equidistant: false }
    }

    fn equidistant(points: usize) -> Self {
        let theta: Vec<f64> = (0..points).map(|i| TAU * i as f64 / points as f64).collect();
        Self { equidistant: true, ..Self::at(&theta) }
    }

    /// θ, −π to π.
    fn angles(&self) -> impl Iterator<Item = f64> {
        self.sin.iter().zip(&self.cos).map(|(sin, cos)| sin.atan2(*cos))
    }
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    /// cos θ, sin θ.
    direction: [f64; 2],
    r: f64,
    index: usize,
}

impl Reading {
    fn residual(&self, centre: [f64; 2]) -> f64 {
        residual(self.direction[0], self.direction[1], self.r, centre)
    }
}

fn residual(cos: f64, sin: f64, r: f64, centre: [f64; 2]) -> f64 {
    r - (cos * centre[0] + sin * centre[1])
}

/// Smallest and largest residual, with the first reading of the block in which each stands.
type Extremes = [(f64, usize); 2];

/// Readings of a block.
const BLOCK: usize = 64;

/// In lanes, which the compiler puts into vectors.
fn extremes(directions: &Directions, r: &[f64], centre: [f64; 2]) -> Extremes {
    const LANES: usize = 8;
    let blocks = directions.cos.chunks(BLOCK).zip(directions.sin.chunks(BLOCK)).zip(r.chunks(BLOCK));
    let mut found = [(f64::INFINITY, 0), (f64::NEG_INFINITY, 0)];
    for (block, ((cos, sin), r)) in blocks.enumerate() {
        let (mut least, mut most) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        let mut take = |lane: usize, (cos, sin, r): (f64, f64, f64)| {
            let value = residual(cos, sin, r, centre);
            least[lane] = if value < least[lane] { value } else { least[lane] };
            most[lane] = if value > most[lane] { value } else { most[lane] };
        };
        let (cos, cos_rest) = cos.as_chunks::<LANES>();
        let (sin, sin_rest) = sin.as_chunks::<LANES>();
        let (r, r_rest) = r.as_chunks::<LANES>();
        for ((cos, sin), r) in cos.iter().zip(sin).zip(r) {
            for lane in 0..LANES {
                take(lane, (cos[lane], sin[lane], r[lane]));
            }
        }
        for ((cos, sin), r) in cos_rest.iter().zip(sin_rest).zip(r_rest) {
            take(0, (*cos, *sin, *r));
        }
        let least = least.into_iter().fold(f64::INFINITY, f64::min);
        let most = most.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let [low, high] = &mut found;
        if least < low.0 {
            *low = (least, block * BLOCK);
        }
        if most > high.0 {
            *high = (most, block * BLOCK);
        }
    }
    found
}

/// Quantity to be minimised.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aim {
    Zone,
    Outer,
    Inner,
}

struct Profile<'a> {
    directions: &'a Directions,
    /// Readings minus the middle of their range.
    r: Vec<f64>,
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

impl<'a> Profile<'a> {
    fn new(directions: &'a Directions, r: &[f64]) -> Result<Self, NoCircle> {
        let angles = directions.cos.len();
        if angles != r.len() {
            return Err(NoCircle::Lengths { angles, readings: r.len() });
        }
        if r.len() < 3 {
            return Err(NoCircle::TooFew { found: r.len() });
        }
        let unusable = r.iter().position(|r| r.is_nan() || r.abs() >= 1e150);
        if let Some(index) = [directions.unusable, unusable].into_iter().flatten().min() {
            return Err(NoCircle::NonFinite { index });
        }
        let [(least, _), (most, _)] = extremes(directions, r, [0.0; 2]);
        let middle = 0.5 * (most + least);
        Ok(Self { directions, r: r.iter().map(|r| r - middle).collect(), middle })
    }

    fn reading(&self, index: usize) -> Reading {
        let Directions { cos, sin, .. } = self.directions;
        Reading { direction: [cos[index], sin[index]], r: self.r[index], index }
    }

    fn readings(&self) -> impl Iterator<Item = Reading> {
        (0..self.r.len()).map(|index| self.reading(index))
    }

    fn residuals(&self, centre: [f64; 2]) -> impl Iterator<Item = f64> {
        let Directions { cos, sin, .. } = self.directions;
        cos.iter().zip(sin).zip(&self.r).map(move |((cos, sin), r)| residual(*cos, *sin, *r, centre))
    }

    fn extremes(&self, centre: [f64; 2]) -> Extremes {
        extremes(self.directions, &self.r, centre)
    }

    /// The first reading with an extreme residual.
    fn reading_at(&self, centre: [f64; 2], (value, from): (f64, usize)) -> Reading {
        let mut block = (from..self.r.len().min(from + BLOCK)).map(|index| self.reading(index));
        block.find(|p| p.residual(centre) == value).unwrap_or(self.reading(from))
    }

    fn range(&self, centre: [f64; 2]) -> Range {
        let [low, high] = self.extremes(centre).map(|extreme| (extreme.0, self.reading_at(centre, extreme)));
        Range { high, low }
    }

    fn least_squares(&self) -> Result<ReferenceCircle, NoCircle> {
        let n = self.r.len() as f64;
        let [c, s, cc, cs, ss] = self.directions.sums;
        let (cc, cs, ss) = (cc - c * c / n, cs - c * s / n, ss - s * s / n);
        let determinant = cc * ss - cs * cs;
        if determinant.is_nan() || determinant <= 1e-24 * n * n {
            return Err(NoCircle::Straight);
        }
        let mut centre = [0.0; 2];
        // The second pass removes the rounding error of the first.
        for _ in 0..2 {
            let [mut cr, mut sr, mut r] = [0.0; 3];
            for ((cos, sin), value) in self.directions.cos.iter().zip(&self.directions.sin).zip(self.residuals(centre))
            {
                cr += cos * value;
                sr += sin * value;
                r += value;
            }
            let (cr, sr) = (cr - c * r / n, sr - s * r / n);
            centre = [centre[0] + (cr * ss - sr * cs) / determinant, centre[1] + (sr * cc - cr * cs) / determinant];
        }
        let mean = self.residuals(centre).sum::<f64>() / n;
        Ok(ReferenceCircle { radius: mean + self.middle, ..self.circle(centre, &self.range(centre), Vec::new()) })
    }

    /// Refuses readings that leave half a turn open.
    fn closed(&self) -> Result<(), NoCircle> {
        let gap = largest_gap(self.directions.angles());
        if gap >= PI * (1.0 - 1e-12) { Err(NoCircle::PartArc) } else { Ok(()) }
    }

    /// The circle about a centre with the range of the residuals there.
    fn circle(&self, centre: [f64; 2], at: &Range, mut contacts: Vec<usize>) -> ReferenceCircle {
        contacts.sort_unstable();
        contacts.dedup();
        let (high, low) = (at.high.0, at.low.0);
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
        let [mut highest, mut lowest] = self.exchanged(aim).unwrap_or_else(|| self.around(start));
        let (mut best, mut all) = loop {
            let vertex = Vertex::best(&highest, &lowest, aim).unwrap_or(Vertex::of(start, &[]));
            let all = self.range(vertex.centre);
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
                break (vertex, all);
            }
        };
        // Two opposite readings alone leave the centre free along a line: the least-squares centre is then as good.
        if aim != Aim::Zone {
            let at = self.range(start);
            if aim.value(&at) <= best.value + 8.0 * f64::EPSILON * best.value.abs() {
                (best, all) = (Vertex::of(start, &[]), at);
            }
        }
        let touching = self.touching(best.centre, &all, aim);
        // With symmetry, readings that do not touch can determine the same centre.
        if best.contacts.is_empty() || best.contacts.iter().any(|i| !touching.contains(i)) {
            best.contacts = touching;
        }
        let circle = self.circle(best.centre, &all, best.contacts);
        let radius = match aim {
            Aim::Zone => circle.radius,
            Aim::Outer => circle.outer,
            Aim::Inner => circle.inner,
        };
        ReferenceCircle { radius, ..circle }
    }

    /// Readings on the relevant circles, to rounding.
    fn touching(&self, centre: [f64; 2], at: &Range, aim: Aim) -> Vec<usize> {
        let size = centre[0].hypot(centre[1]) + at.high.0.abs().max(at.low.0.abs());
        let tie = 64.0 * f64::EPSILON * size;
        let above = if aim == Aim::Inner { f64::INFINITY } else { at.high.0 - tie };
        let below = if aim == Aim::Outer { f64::NEG_INFINITY } else { at.low.0 + tie };
        (0..).zip(self.residuals(centre)).filter(|(_, v)| *v >= above || *v <= below).map(|(index, _)| index).collect()
    }

    /// The high and the low readings that determine the circle of an equidistant profile, by the simplex method.
    ///
    /// Dual of the linear programme: weights λ ≥ 0 of high and μ ≥ 0 of low readings with Σλ = Σμ = 1 and Σλ d = Σμ d,
    /// d = (cos θ, sin θ), for which Σλ r − Σμ r is largest. Four readings carry the weights; in each step the reading
    /// farthest outside takes the place of one of them. `None` if the steps do not end: readings level to rounding can take
    /// each other's places for ever.
    fn exchanged(&self, aim: Aim) -> Option<[Vec<Reading>; 2]> {
        const STEPS: usize = 64;
        let n = self.r.len();
        if !self.directions.equidistant || n < 4 {
            return None;
        }
        let around = |side| [0, n / 3, 2 * n / 3].map(|index| Column::of(self.reading(index), side));
        let with = |still, [a, b, c]: [Column; 3]| [a, b, c, Column::still(still)];
        let mut few = match aim {
            // Two chords that cross.
            Aim::Zone => [(0, HIGH), (n / 2, HIGH), (n / 4, LOW), (3 * n / 4, LOW)]
                .map(|(index, side)| Column::of(self.reading(index), side)),
            Aim::Outer => with(LOW, around(HIGH)),
            Aim::Inner => with(HIGH, around(LOW)),
        };
        for _ in 0..STEPS {
            let inverse = Matrix4::from_columns(&few.map(|column| column.entries)).try_inverse()?;
            let costs = Vector4::from(few.map(|column| column.cost));
            let [high, minus_low, x, y]: [f64; 4] = inverse.tr_mul(&costs).into();
            let centre = [x, y];
            let [least, most] = self.extremes(centre);
            let outside = [most.0 - high, -least.0 - minus_low];
            let side = match aim {
                Aim::Zone if outside[LOW] > outside[HIGH] => LOW,
                Aim::Zone | Aim::Outer => HIGH,
                Aim::Inner => LOW,
            };
            let worst = self.reading_at(centre, if side == HIGH { most } else { least });
            let level = outside[side] <= 4.0 * f64::EPSILON * (high.abs() + minus_low.abs() + x.abs() + y.abs());
            if level
                || few
                    .iter()
                    .any(|column| column.side == side && column.reading.is_some_and(|p| p.index == worst.index))
            {
                let on =
                    |side| few.iter().filter(move |column| column.side == side).filter_map(|column| column.reading);
                let mut lists = [on(HIGH).collect::<Vec<_>>(), on(LOW).collect()];
                // A side that does not count has one reading all the same.
                lists.iter_mut().filter(|list| list.is_empty()).for_each(|list| list.push(worst));
                return Some(lists);
            }
            let joining = Column::of(worst, side);
            let weights = inverse.column(0) + inverse.column(1);
            let change = inverse * joining.entries;
            let steps = (0..4).filter(|i| change[*i] > 1e-12).map(|i| (weights[i] / change[i], i));
            let (_, leaving) = steps.min_by(|a, b| a.0.total_cmp(&b.0))?;
            few[leaving] = joining;
        }
        None
    }

    /// Extreme readings about the least-squares circle in five equally large groups, in the order of their angles, and three
    /// readings that surround the centre: without these the few could have no optimum.
    fn around(&self, start: [f64; 2]) -> [Vec<Reading>; 2] {
        let mut sorted: Vec<(f64, Reading)> = self.directions.angles().zip(self.readings()).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let order = |a: &&(f64, Reading), b: &&(f64, Reading)| a.1.residual(start).total_cmp(&b.1.residual(start));
        let groups = || sorted.chunks(sorted.len().div_ceil(5));
        let mut lists = [
            groups().filter_map(|group| group.iter().max_by(order)).map(|(_, p)| *p).collect::<Vec<Reading>>(),
            groups().filter_map(|group| group.iter().min_by(order)).map(|(_, p)| *p).collect(),
        ];
        // The first reading and the readings next to its opposite on both sides.
        let first = self.reading(0);
        let angle = first.direction[1].atan2(first.direction[0]);
        let turned = |p: &&(f64, Reading)| (p.0 - angle).rem_euclid(TAU);
        let left = sorted.iter().filter(|p| turned(p) <= PI).max_by(|a, b| turned(a).total_cmp(&turned(b)));
        let right = sorted.iter().filter(|p| turned(p) >= PI).min_by(|a, b| turned(a).total_cmp(&turned(b)));
        for list in &mut lists {
            for p in [Some(first), left.map(|p| p.1), right.map(|p| p.1)].into_iter().flatten() {
                if !list.iter().any(|other| other.index == p.index) {
                    list.push(p);
                }
            }
        }
        lists
    }
}

/// A column of the dual programme.
#[derive(Clone, Copy, Debug)]
struct Column {
    side: usize,
    /// `None` on a side that does not count.
    reading: Option<Reading>,
    /// Its part in Σλ, Σμ and in x and y of Σλ d − Σμ d.
    entries: Vector4<f64>,
    cost: f64,
}

const HIGH: usize = 0;
const LOW: usize = 1;

impl Column {
    fn of(reading: Reading, side: usize) -> Self {
        let [x, y] = reading.direction;
        let (entries, cost) =
            if side == HIGH { ([1.0, 0.0, x, y], reading.r) } else { ([0.0, 1.0, -x, -y], -reading.r) };
        Self { side, reading: Some(reading), entries: entries.into(), cost }
    }

    fn still(side: usize) -> Self {
        let entries = if side == HIGH { Vector4::x() } else { Vector4::y() };
        Self { side, reading: None, entries, cost: 0.0 }
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
