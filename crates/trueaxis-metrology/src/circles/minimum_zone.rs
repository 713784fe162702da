//! Minimum zone circle.

use super::circumscribed::about;
use super::local::{Extremes, Local, Point, equidistant, extremes};
use super::width::smallest_width;
use super::{NoCircle, ReferenceCircle, check, least_squares};
use std::vec::Vec;

/// Two concentric circles that enclose all points between them at the smallest difference of radii, MZC: the global minimum.
///
/// w(c) = max |pᵢ − c| − min |pᵢ − c| has its minima only where two farthest and two nearest points, or three of one kind and
/// one of the other, determine it: two linear equations for the centre. For any far point F and near point N
///
/// w(c) >= |F − c| − |N − c| = (f_F(c) − f_N(c))/(|F − c| + |N − c|),     f = |p|² − 2p·c,
///
/// a linear function over a convex one: where it is positive it is quasi-concave, and its minimum over a rectangle of centres
/// is at a corner. The search keeps a rectangle as long as this bound, for the extreme points of its middle, is below the best
/// zone known, together with the points that can be farthest or nearest somewhere in it. It halves the rectangle across the
/// side with the greater change until those points are few, and then tries all their centres. A far outlier makes the good
/// centres a valley, a million times longer than wide: squares would have to be as small as the valley is narrow. The
/// rectangles are aligned with the set. The search starts from the square outside which the zone must be wider: far away, w
/// approaches the width of the set. Zone and contacts are those of a vertex; only if more points share it than rounding can
/// resolve (exact symmetry) does the search end at rounding. On a part arc the zone exists as long as it is narrower than a
/// straight strip. Radius: mean of outer and inner.
///
/// Cost: n log n, below a microsecond a point for near-round points; some 20,000 rectangles with an outlier.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`] (collinear, or no circle better than a strip);
/// [`NoCircle::Unresolved`] if 150,000 rectangles are not enough: outliers 10⁶ and 10⁸ times farther away than the other
/// points.
pub fn minimum_zone(points: &[[f64; 2]]) -> Result<ReferenceCircle, NoCircle> {
    counted(points).0
}

/// The zone, and the number of rectangles of centres tried.
fn counted(points: &[[f64; 2]]) -> (Result<ReferenceCircle, NoCircle>, usize) {
    if let Err(error) = check(points) {
        return (Err(error), 0);
    }
    let (local, mean) = reference(points);
    let local = local.without_twins();
    let strip = smallest_width(points);
    let mut search = Search::new(&local, strip);
    // For nearly straight points this limits how far away the centre may be.
    if let Some([x, y]) = mean {
        search.offer([x - local.origin[0], y - local.origin[1]], &[]);
    }
    let half = search.start(strip);
    search.limit = half;
    search.narrow(Cell { m: [0.0; 2], half: [half; 2] });
    if search.trials > RECTANGLES {
        return (Err(NoCircle::Unresolved), search.trials);
    }
    if search.width >= strip * (1.0 - 1e-9) {
        return (Err(NoCircle::Straight), search.trials);
    }
    search.settle();
    (Ok(local.circle(search.centre, search.contacts)), search.trials)
}

/// A least-squares centre farther away than this many times the width of the set costs more digits than it saves.
const FAR: f64 = 1e3;

/// Points about the better of the least-squares and the circumscribed centre, and the least-squares centre.
fn reference(points: &[[f64; 2]]) -> (Local, Option<[f64; 2]>) {
    let zone = |local: &Local| {
        let at = local.extremes([0.0; 2]);
        local.width(at.high, at.low, [0.0; 2])
    };
    let around = about(points);
    let Ok((mean, c)) = least_squares::fit(points) else { return (around, None) };
    let centre = [mean.origin[0] + c[0], mean.origin[1] + c[1]];
    let better = mean.radius < FAR * around.radius && zone(&mean) <= zone(&around);
    (if better { mean } else { around }, Some(centre))
}

/// Number of groups of points whose extremes shrink the square of centres to the size of the zone.
const GROUPS: usize = 24;

/// Most rectangles tried on that sample before all points are used.
const TRIALS: usize = 10_000;

/// Number of rectangles after which the search ends without a result.
const RECTANGLES: usize = 150_000;

/// A rectangle is searched centre by centre once no more points than this can decide in it, far and near together.
const FEW: usize = 9;

/// A rectangle of centres: its middle, along and across the axis of the search, and its half sides.
///
/// Halving is exact in these coordinates, so neighbours share their border to the last bit: on it two points can be equally
/// far.
#[derive(Clone, Copy, Debug)]
struct Cell {
    m: [f64; 2],
    half: [f64; 2],
}

impl Cell {
    /// Halves a rectangle across the side with the greater change.
    fn halves(self, change: [f64; 2]) -> [Cell; 2] {
        let side = self.across(change);
        let mut half = self.half;
        half[side] *= 0.5;
        [-half[side], half[side]].map(|by| {
            let mut m = self.m;
            m[side] += by;
            Cell { m, half }
        })
    }

    /// The side to halve: the one with the greater change, unless it is already a thread.
    fn across(&self, change: [f64; 2]) -> usize {
        let [a, b] = self.half;
        let side = if change[0] >= change[1] { 0 } else { 1 };
        match side {
            0 if a < THREAD * b => 1,
            1 if b < THREAD * a => 0,
            side => side,
        }
    }
}

/// Least width of a rectangle relative to its length.
const THREAD: f64 = 1e-12;

struct Search<'a> {
    local: &'a Local,
    /// Smallest zone so far, its centre and the points that determine it.
    width: f64,
    centre: [f64; 2],
    contacts: Vec<usize>,
    sample: [Vec<Point>; 2],
    /// Unit vector along the set.
    axis: [f64; 2],
    /// Number of rectangles tried.
    trials: usize,
    /// Half the side of the square of all centres.
    limit: f64,
}

/// Zone of two points over a rectangle: in its middle, its minimum, and its change along each side.
struct Over {
    here: f64,
    least: f64,
    change: [f64; 2],
}

impl<'a> Search<'a> {
    fn new(local: &'a Local, strip: f64) -> Self {
        let sample = local.sample(GROUPS);
        // Along the set: from one far point to the point farthest from it.
        let far = local.extremes([0.0; 2]).far;
        let other = local.extremes([far.x, far.y]).far;
        let (x, y) = (far.x - other.x, far.y - other.y);
        let length = x.hypot(y);
        let axis = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
        let mut search =
            Self { local, width: strip, centre: [0.0; 2], contacts: Vec::new(), sample, axis, trials: 0, limit: 0.0 };
        search.offer([0.0; 2], &[]);
        search
    }

    /// Accepts a centre if its zone is the smallest so far.
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
    /// At a distance ρ beyond the set's radius s the zone is at least strip − s²/ρ. If no known circle is better than the
    /// strip, the search is limited to 10⁴ times the set's size.
    fn start(&self, strip: f64) -> f64 {
        let size = self.local.points.iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
        let most = if self.width < strip { 1e8 } else { 1e4 };
        size + (size * size / (strip - self.width).max(0.0)).min(most * size)
    }

    /// Halves a rectangle using a few points while it is large compared with the zone, because all points can still be
    /// farthest or nearest in it then.
    fn narrow(&mut self, cell: Cell) {
        self.trials += 1;
        if self.width <= 0.0 {
            return;
        }
        let m = self.place(cell.m);
        let at = extremes(&self.sample[0], &self.sample[1], m);
        let over = self.over(&at, cell);
        if over.least >= self.width {
            return;
        }
        if over.here - over.least > 4.0 * self.width && self.trials < TRIALS {
            for part in cell.halves(over.change) {
                self.narrow(part);
            }
            return;
        }
        let at = self.local.extremes(m);
        self.offer(m, &[]);
        if self.over(&at, cell).least < self.width {
            self.cut(cell, &self.local.points, &self.local.points, at);
        }
    }

    /// A centre given along and across the axis.
    fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.axis;
        [u * x - v * y, u * y + v * x]
    }

    /// Half of the change of f(p) − f(q) along each side of a rectangle.
    fn reach(&self, p: &Point, q: &Point, cell: Cell) -> [f64; 2] {
        let ([x, y], dx, dy) = (self.axis, p.x - q.x, p.y - q.y);
        [2.0 * (dx * x + dy * y).abs() * cell.half[0], 2.0 * (dy * x - dx * y).abs() * cell.half[1]]
    }

    /// The zone of two points over a rectangle.
    fn over(&self, at: &Extremes, cell: Cell) -> Over {
        let corner = |a: f64, b: f64| {
            let c = self.place([cell.m[0] + a * cell.half[0], cell.m[1] + b * cell.half[1]]);
            self.local.width(at.far.f(c), at.near.f(c), c)
        };
        let [low, left, right, high] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, -1.0), corner(1.0, 1.0)];
        let here = corner(0.0, 0.0);
        // The corners alone would miss a zone that is symmetric about the middle.
        let from_here = |a: f64, b: f64| (corner(a, b) - here).abs().max((corner(-a, -b) - here).abs());
        Over {
            here,
            least: low.min(left).min(right).min(high),
            change: [
                (right - low).abs().max((high - left).abs()).max(from_here(1.0, 0.0)),
                (left - low).abs().max((high - right).abs()).max(from_here(0.0, 1.0)),
            ],
        }
    }

    fn cut(&mut self, cell: Cell, far: &[Point], near: &[Point], at: Extremes) {
        self.trials += 1;
        if self.trials > RECTANGLES {
            return;
        }
        let (local, m) = (self.local, self.place(cell.m));
        let noise = local.noise(m[0].hypot(m[1]) + cell.half[0] + cell.half[1]);
        // If a is farthest in the middle, p can be farthest in the rectangle only if it overtakes a in a corner.
        let mut spread = [0.0_f64; 2];
        let mut kept = |p: &&Point, extreme: &Point, behind: f64| {
            let [along, across] = self.reach(p, extreme, cell);
            let keep = behind <= along + across + noise;
            if keep {
                spread = [spread[0].max(along), spread[1].max(across)];
            }
            keep
        };
        let far: Vec<Point> = far.iter().filter(|p| kept(p, &at.far, at.high - p.f(m))).copied().collect();
        let near: Vec<Point> = near.iter().filter(|p| kept(p, &at.near, p.f(m) - at.low)).copied().collect();
        if far.len() + near.len() <= FEW {
            return self.vertices(&far, &near);
        }
        let sum = local.distance(at.high, m) + local.distance(at.low, m);
        let change = self.over(&at, cell).change;
        let much = [0, 1].map(|side| change[side].max(2.0 * spread[side] / sum.max(f64::MIN_POSITIVE)));
        let mut parts = cell.halves(much).map(|part| {
            let m = self.place(part.m);
            let at = extremes(&far, &near, m);
            (self.over(&at, part).least, part, m, at)
        });
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (bound, part, m, at) in parts {
            let width = local.width(at.high, at.low, m);
            if width < self.width {
                (self.width, self.centre) = (width, m);
                self.contacts.clear();
            }
            let sum = local.distance(at.high, m) + local.distance(at.low, m);
            if bound + noise / sum.max(f64::MIN_POSITIVE) < self.width {
                self.cut(part, &far, &near, at);
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
        // Collinear points meet at infinity, or, by rounding, somewhere before.
        if c[0].abs().max(c[1].abs()) > self.limit {
            return;
        }
        // Few points first: a zone too wide for them is too wide for all.
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
        // With symmetry, points that do not touch can determine the same centre.
        let tie = self.tie(c);
        if contacts.iter().any(|p| p.f(c) < at.high - tie && p.f(c) > at.low + tie) {
            contacts.clear();
        }
        self.offer(c, &contacts);
    }

    /// Values of f closer than this count as equal.
    fn tie(&self, c: [f64; 2]) -> f64 {
        64.0 * self.local.noise(c[0].hypot(c[1]))
    }

    /// After a search that ended at rounding, or at points that do not touch: finds the points that are farthest and nearest
    /// there.
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

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// Near-round points with one or more far away, as left by a slip of the probe.
    fn with_outliers(outliers: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut noise = trueaxis_testing::noise::Noise::new(5);
        let mut random = || 0.5 * noise.signed();
        let round = (0..4000).map(|i| (TAU * f64::from(i) / 4000.0, 10.0 + 2e-3 * random()));
        round.map(|(a, r)| [r * a.cos(), r * a.sin()]).chain(outliers.iter().copied()).collect()
    }

    /// A trace sampled by time dwells at one of its points: more coincident points than can be resolved.
    #[test]
    fn points_in_one_place_cost_no_more_than_one() {
        for (round, twin) in [
            (&[[1.0, 0.0], [0.0, 1.0], [0.1, 0.0], [0.1, 0.001]][..], 3),
            (&[[1.0, 0.0], [0.0, 1.0], [-1.0, 0.001], [0.1, -1.0], [-0.6, 0.8]][..], 0),
        ] {
            let (once, few) = counted(round);
            let copies = std::iter::repeat_n(round[twin], 14);
            let (found, trials) = counted(&round.iter().copied().chain(copies).collect::<Vec<_>>());
            std::println!("{trials} rectangles, {few} without copies: {found:?} {once:?}");
            assert!(trials <= 4 * few + 200, "{trials} rectangles, {few} without copies");
            let zone = |of: Result<ReferenceCircle, NoCircle>| of.map(|circle| (circle.zone, circle.contacts));
            let (found, once) = (zone(found), zone(once));
            assert_eq!(found.as_ref().map(|of| &of.1), once.as_ref().map(|of| &of.1));
            let apart = found.iter().zip(&once).map(|(found, once)| (found.0 - once.0).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-14, "{apart}");
        }
    }

    /// Counts the work in rectangles of centres instead of timing it.
    #[test]
    fn outliers_cost_little() {
        for outliers in [
            &[][..],
            &[[1e3, 0.0]],
            &[[0.0, -1e5]],
            &[[3e6, 4e6]],
            &[[1e7, 0.0]],
            &[[-1e9, 2e8]],
            &[[1e7, 0.0], [0.0, 1e7]],
            &[[1e7, 0.0], [-1e7, 3.0]],
            &[[1e3, 0.0], [1e6, 10.0], [-1e9, 1e9]],
        ] {
            let (found, trials) = counted(&with_outliers(outliers));
            std::println!("{outliers:?}: {trials} rectangles, {found:?}");
            assert!(trials < 40_000, "{outliers:?}: {trials}");
        }
    }
}
