//! Minimum zone circle.

use super::circumscribed::about;
use super::local::{Extremes, Local, Point, QUARTERS, equidistant, extremes};
use super::width::smallest_width;
use super::{NoCircle, ReferenceCircle, check, least_squares};
use std::vec::Vec;

/// Two concentric circles that hold all points between them at the smallest difference of radii, MZC: the global minimum.
///
/// w(c) = max |pᵢ − c| − min |pᵢ − c| has its minima only where two farthest and two nearest points, or three of one kind and
/// one of the other, decide it: two linear equations for the centre. A square of centres is kept as long as its lower bound
///
/// w >= (f_far − f_near − 2(|Δx| + |Δy|)h)/(R + r + 2√2 h),     f = |p|² − 2p·c,
///
/// is below the best zone known, with the points that can be farthest or nearest somewhere in it; it is cut in four until
/// those are few, and then all their centres are tried. The start is the square outside which the zone must be wider: far away,
/// w approaches the width of the set. Zone and contacts are a vertex's; only where more points than can be told apart by
/// rounding share it (exact symmetry), is the search cut off, at rounding. On a part arc the zone exists as long as it is
/// narrower than a straight strip. Radius: mean of outer and inner.
///
/// Cost: n log n, for near-round points below a microsecond a point.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`] (collinear, or no circle better than a strip).
pub fn minimum_zone(points: &[[f64; 2]]) -> Result<ReferenceCircle, NoCircle> {
    check(points)?;
    let local = reference(points);
    let strip = smallest_width(points);
    let mut search = Search::new(&local, strip);
    let half = search.start(strip);
    search.limit = half;
    search.narrow([0.0; 2], half);
    if search.width >= strip * (1.0 - 1e-9) {
        return Err(NoCircle::Straight);
    }
    search.settle();
    Ok(local.circle(search.centre, search.contacts))
}

/// A least-squares centre this many times farther away than the set is wide costs more digits than it saves.
const FAR: f64 = 1e3;

/// Points about the better of the least-squares and the circumscribed centre.
fn reference(points: &[[f64; 2]]) -> Local {
    let zone = |local: &Local| {
        let at = local.extremes([0.0; 2]);
        local.width(at.high, at.low, [0.0; 2])
    };
    let around = about(points);
    match least_squares::fit(points) {
        Ok((mean, _)) if mean.radius < FAR * around.radius && zone(&mean) <= zone(&around) => mean,
        _ => around,
    }
}

/// Groups of points, the extremes of which shrink the square of centres to the size of the zone.
const GROUPS: usize = 24;

/// Squares that may be tried on that sample before all points are asked.
const TRIALS: usize = 10_000;

/// A square is searched centre by centre when no more points than this can decide in it, far and near together.
const FEW: usize = 9;

struct Search<'a> {
    local: &'a Local,
    /// Smallest zone so far, its centre and the points that determine it.
    width: f64,
    centre: [f64; 2],
    contacts: Vec<usize>,
    sample: [Vec<Point>; 2],
    trials: usize,
    /// Half the side of the square of all centres.
    limit: f64,
}

impl<'a> Search<'a> {
    fn new(local: &'a Local, strip: f64) -> Self {
        let sample = local.sample(GROUPS);
        let mut search =
            Self { local, width: strip, centre: [0.0; 2], contacts: Vec::new(), sample, trials: 0, limit: 0.0 };
        search.offer([0.0; 2], &[]);
        search
    }

    /// Takes a centre if its zone is the smallest so far.
    fn offer(&mut self, c: [f64; 2], contacts: &[&Point]) {
        let at = self.local.extremes(c);
        let width = self.local.width(at.high, at.low, c);
        if width < self.width || (width == self.width && self.contacts.is_empty()) {
            self.width = width;
            self.centre = c;
            self.contacts = contacts.iter().map(|p| p.index).collect();
        }
    }

    /// Half the side of a square about the origin outside which no zone is narrower than the best one.
    ///
    /// At a distance ρ beyond the set's radius s the zone is at least strip − s²/ρ.
    fn start(&self, strip: f64) -> f64 {
        let size = self.local.points.iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
        size + (size * size / (strip - self.width).max(0.0)).min(1e4 * size)
    }

    /// Cuts a square in four on a few points as long as it is large against the zone, because all points can still be
    /// farthest or nearest in it then.
    fn narrow(&mut self, m: [f64; 2], half: f64) {
        self.trials += 1;
        if self.width <= 0.0 {
            return;
        }
        let at = extremes(&self.sample[0], &self.sample[1], m);
        if self.bound(&at, m, half) >= self.width {
            return;
        }
        if half > 2.0 * self.width && self.trials < TRIALS {
            let quarter = 0.5 * half;
            for [x, y] in QUARTERS {
                self.narrow([m[0] + x * quarter, m[1] + y * quarter], quarter);
            }
            return;
        }
        let at = self.local.extremes(m);
        self.offer(m, &[]);
        if self.bound(&at, m, half) < self.width {
            self.cut(m, half, &self.local.points, &self.local.points, at);
        }
    }

    /// Lower bound of the zone in a square about m.
    fn bound(&self, at: &Extremes, m: [f64; 2], half: f64) -> f64 {
        let local = self.local;
        let reach = 2.0 * half * ((at.far.x - at.near.x).abs() + (at.far.y - at.near.y).abs());
        let sum = local.distance(at.high, m) + local.distance(at.low, m) + 2.0 * core::f64::consts::SQRT_2 * half;
        (at.high - at.low - reach) / sum
    }

    fn cut(&mut self, m: [f64; 2], half: f64, far: &[Point], near: &[Point], at: Extremes) {
        let local = self.local;
        let noise = local.noise(m[0].hypot(m[1]) + half);
        // Where a is farthest in the middle, p can be farthest in the square only if it overtakes a in a corner.
        let reach = |p: &Point, q: &Point| 2.0 * half * ((p.x - q.x).abs() + (p.y - q.y).abs()) + noise;
        let far: Vec<Point> = far.iter().filter(|p| p.f(m) + reach(p, &at.far) >= at.high).copied().collect();
        let near: Vec<Point> = near.iter().filter(|p| p.f(m) - reach(p, &at.near) <= at.low).copied().collect();
        if far.len() + near.len() <= FEW {
            return self.vertices(&far, &near);
        }
        let quarter = 0.5 * half;
        let mut parts = QUARTERS.map(|[x, y]| {
            let m = [m[0] + x * quarter, m[1] + y * quarter];
            let at = extremes(&far, &near, m);
            (self.bound(&at, m, quarter), m, at)
        });
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (bound, m, at) in parts {
            let width = local.width(at.high, at.low, m);
            if width < self.width {
                (self.width, self.centre) = (width, m);
                self.contacts.clear();
            }
            let sum = local.distance(at.high, m) + local.distance(at.low, m);
            if bound + noise / sum.max(f64::MIN_POSITIVE) < self.width {
                self.cut(m, quarter, &far, &near, at);
            }
        }
    }

    /// All centres that these points can determine.
    fn vertices(&mut self, far: &[Point], near: &[Point]) {
        for (i, a) in far.iter().enumerate() {
            for (j, b) in far.iter().enumerate().skip(i + 1) {
                for (k, c) in near.iter().enumerate() {
                    for d in &near[k + 1..] {
                        self.vertex(equidistant(a, b, c, d), &[a, b, c, d], far, near);
                    }
                }
                for c in &far[j + 1..] {
                    self.vertex(equidistant(a, b, a, c), &[a, b, c], far, near);
                }
            }
        }
        for (i, a) in near.iter().enumerate() {
            for (j, b) in near.iter().enumerate().skip(i + 1) {
                for c in &near[j + 1..] {
                    self.vertex(equidistant(a, b, a, c), &[a, b, c], far, near);
                }
            }
        }
    }

    fn vertex(&mut self, centre: Option<[f64; 2]>, of: &[&Point], far: &[Point], near: &[Point]) {
        let Some(c) = centre else { return };
        // Points of one line meet at infinity, or by rounding somewhere before.
        if c[0].abs().max(c[1].abs()) > self.limit {
            return;
        }
        // Few points first: what is too wide for them is too wide for all.
        let at = extremes(far, near, c);
        if self.local.width(at.high, at.low, c) > self.width {
            return;
        }
        let at = self.local.extremes(c);
        let mut contacts = of.to_vec();
        match of {
            [a, _, _] if a.f(c) > 0.5 * (at.high + at.low) => contacts.push(&at.near),
            [_, _, _] => contacts.push(&at.far),
            _ => {}
        }
        // By symmetry points that do not touch can name the same centre.
        let tie = self.tie(c);
        if contacts.iter().any(|p| p.f(c) < at.high - tie && p.f(c) > at.low + tie) {
            contacts.clear();
        }
        self.offer(c, &contacts);
    }

    /// Values of f closer than this are taken for equal.
    fn tie(&self, c: [f64; 2]) -> f64 {
        64.0 * self.local.noise(c[0].hypot(c[1]))
    }

    /// Where the search ended at rounding, or at points that do not touch: the points that are then farthest and nearest.
    fn settle(&mut self) {
        if !self.contacts.is_empty() {
            return;
        }
        let c = self.centre;
        let at = self.local.extremes(c);
        let tie = self.tie(c);
        let all = &self.local.points;
        let far: Vec<Point> = all.iter().filter(|p| p.f(c) >= at.high - tie).take(FEW).copied().collect();
        let near: Vec<Point> = all.iter().filter(|p| p.f(c) <= at.low + tie).take(FEW).copied().collect();
        // Another vertex may be wider by rounding.
        let sum = self.local.distance(at.high, c) + self.local.distance(at.low, c);
        self.width += tie / sum.max(f64::MIN_POSITIVE);
        self.vertices(&far, &near);
        if self.contacts.is_empty() {
            self.contacts = far.iter().take(2).chain(near.iter().take(2)).map(|p| p.index).collect();
        }
    }
}
