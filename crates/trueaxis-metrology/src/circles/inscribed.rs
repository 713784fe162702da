//! Maximum inscribed circle.

use super::local::{Local, Point, QUARTERS, equidistant, extremes};
use super::{NoCircle, ReferenceCircle, check, largest_gap, least_squares};
use core::f64::consts::{FRAC_1_SQRT_2, PI};
use std::vec::Vec;

/// Largest circle that contains no point and is bounded by points on all sides, MIC.
///
/// Its centre lies strictly between the points it touches: three of them form an acute triangle around it (a vertex of the
/// nearest-point Voronoi diagram inside its own Delaunay triangle). The search for the largest is like that for the minimum
/// zone: it keeps squares of centres in which min |pᵢ − c| + √2 h exceeds the best radius, quarters them, and tries all
/// triples once few points can be nearest in a square. Radius: the circle's own, = inner.
///
/// The search compares squared distances. If points are as far away as S, a distance d is known to 16 ε S²/d, or to 4 √ε S if
/// that is less (ε = 2.2e-16): negligible for round sections, 60 mm for a circle of 5 mm among points 10⁹ mm away.
///
/// Cost: linear in the points, below a microsecond each for near-round ones.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`]; [`NoCircle::PartArc`] if the points leave half a
/// turn or more open as seen from the least-squares centre, or if no circle is bounded on all sides;
/// [`NoCircle::Unresolved`] if 150,000 squares are not enough: outliers 10⁶ and 10⁹ times farther away than the other points.
pub fn maximum_inscribed(points: &[[f64; 2]]) -> Result<ReferenceCircle, NoCircle> {
    check(points)?;
    let (local, c) = least_squares::fit(points).map_err(|_| NoCircle::PartArc)?;
    if largest_gap(local.points.iter().map(|p| (p.y - c[1]).atan2(p.x - c[0]))) >= PI {
        return Err(NoCircle::PartArc);
    }
    let range = |value: fn(&Point) -> f64| {
        let values = local.points.iter().map(value);
        [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)]
    };
    let (x, y) = (range(|p| p.x), range(|p| p.y));
    let middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
    let half = 0.5 * (x[1] - x[0]).max(y[1] - y[0]);
    let local = local.without_twins();
    let mut search = {
        let [_, near] = local.sample(GROUPS);
        Search::new(&local, near)
    };
    search.inflate();
    search.narrow(middle, half);
    if search.squares > SQUARES {
        return Err(NoCircle::Unresolved);
    }
    let (centre, contacts) = search.best.ok_or(NoCircle::PartArc)?;
    let circle = local.circle(centre, contacts);
    Ok(ReferenceCircle { radius: circle.inner, ..circle })
}

/// Number of groups of points whose extremes shrink the square of centres to the size of the zone.
const GROUPS: usize = 24;

/// Most squares tried on that sample before all points are used.
const TRIALS: usize = 10_000;

/// Number of squares after which the search ends without a result.
const SQUARES: usize = 150_000;

/// Most points that form the first circle, and most exchanges tried.
const MOST: usize = 24;
const EXCHANGES: usize = 60;

/// A square is searched triple by triple once no more points than this can be nearest in it.
const FEW: usize = 6;

struct Search<'a> {
    local: &'a Local,
    /// Best radius, as R² − R₀².
    square: f64,
    best: Option<([f64; 2], Vec<usize>)>,
    sample: Vec<Point>,
    /// Zone about the least-squares centre.
    zone: f64,
    /// Squares tried on the sample, and on all points.
    trials: usize,
    squares: usize,
}

impl<'a> Search<'a> {
    fn new(local: &'a Local, sample: Vec<Point>) -> Self {
        let at = local.extremes([0.0; 2]);
        let zone = local.width(at.high, at.low, [0.0; 2]);
        Self { local, square: f64::NEG_INFINITY, best: None, sample, zone, trials: 0, squares: 0 }
    }

    /// Finds a first circle: the best one of a few points all round, adding the nearest point until none is inside. For
    /// near-round points it is already the result.
    fn inflate(&mut self) {
        for groups in [8, 16, MOST / 2] {
            let [_, mut few] = self.local.sample(groups);
            for _ in 0..EXCHANGES {
                let mut inner = Self::new(self.local, Vec::new());
                inner.triples(&few, &few);
                let Some((c, _)) = inner.best else { break };
                let nearest = self.local.extremes(c).near;
                if few.iter().any(|p| p.index == nearest.index) {
                    self.triples(&few, &self.local.points);
                    break;
                }
                if few.len() == MOST {
                    // The dropped points are by now far from the circle.
                    few.sort_by(|a, b| a.f(c).total_cmp(&b.f(c)));
                    few.truncate(MOST / 2);
                }
                few.push(nearest);
            }
            if self.best.is_some() {
                return;
            }
        }
    }

    /// Upper bound of R² − R₀² in a square about m; the nearest point of a list there, and its f.
    fn bound(&self, list: &[Point], m: [f64; 2], half: f64) -> (f64, Point, f64) {
        let at = extremes(list, list, m);
        let reach = (at.near.x - m[0]).abs() + (at.near.y - m[1]).abs() + half;
        (at.low + m[0] * m[0] + m[1] * m[1] + 2.0 * half * reach, at.near, at.low)
    }

    /// Quarters a square using a few points while it is large compared with the zone, because all points can still be nearest
    /// in it then.
    fn narrow(&mut self, m: [f64; 2], half: f64) {
        self.trials += 1;
        if self.squares > SQUARES || self.bound(&self.sample, m, half).0 <= self.square {
            return;
        }
        if half > 2.0 * self.zone && self.trials < TRIALS {
            let quarter = 0.5 * half;
            for [x, y] in QUARTERS {
                self.narrow([m[0] + x * quarter, m[1] + y * quarter], quarter);
            }
            return;
        }
        let (bound, nearest, low) = self.bound(&self.local.points, m, half);
        if bound > self.square {
            self.cut(m, half, &self.local.points, (nearest, low));
        }
    }

    fn cut(&mut self, m: [f64; 2], half: f64, near: &[Point], (nearest, low): (Point, f64)) {
        self.squares += 1;
        if self.squares > SQUARES {
            return;
        }
        let noise = self.local.noise(m[0].hypot(m[1]) + half);
        let reach = |p: &Point| 2.0 * half * ((p.x - nearest.x).abs() + (p.y - nearest.y).abs()) + noise;
        let near: Vec<Point> = near.iter().filter(|p| p.f(m) - reach(p) <= low).copied().collect();
        if near.len() <= FEW {
            return self.triples(&near, &self.local.points);
        }
        if all_on_one_side(&near, m, half) {
            return;
        }
        let quarter = 0.5 * half;
        // Several points share the centre to rounding (exact symmetry): it cannot be resolved further.
        if quarter * self.local.steepest() <= noise {
            return self.tied(m, &near);
        }
        let mut parts = QUARTERS.map(|[x, y]| {
            let m = [m[0] + x * quarter, m[1] + y * quarter];
            let (bound, nearest, low) = self.bound(&near, m, quarter);
            (bound, m, (nearest, low))
        });
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (bound, m, at) in parts {
            if bound > self.square + noise {
                self.cut(m, quarter, &near, at);
            }
        }
    }

    fn triples(&mut self, near: &[Point], all: &[Point]) {
        for (i, a) in near.iter().enumerate() {
            for (j, b) in near.iter().enumerate().skip(i + 1) {
                for c in &near[j + 1..] {
                    if let Some(centre) = equidistant(a, b, a, c) {
                        self.offer(centre, [a, b, c], near, all);
                    }
                }
            }
        }
    }

    /// Accepts a circle on three points if it is the largest so far, contains no point, and is bounded on all sides.
    fn offer(&mut self, c: [f64; 2], on: [&Point; 3], near: &[Point], all: &[Point]) {
        let values = on.map(|p| p.f(c));
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let square = least + c[0] * c[0] + c[1] * c[1];
        if square <= self.square {
            return;
        }
        // The three agree to the rounding of their centre; points within it also touch.
        let tie = (most - least) + self.local.noise(c[0].hypot(c[1]));
        let inside = |p: &Point| p.f(c) < least - tie;
        if near.iter().any(inside) || all.iter().any(inside) {
            return;
        }
        let touching: Vec<&Point> = all.iter().filter(|p| p.f(c) <= most + tie).collect();
        if held(&touching, c) {
            self.square = square;
            self.best = Some((c, contacts(&touching, c)));
        }
    }

    /// Accepts the middle of a square that cannot be divided further, if the points hold it on all sides.
    fn tied(&mut self, m: [f64; 2], near: &[Point]) {
        let square = extremes(near, near, m).low + m[0] * m[0] + m[1] * m[1];
        let touching: Vec<&Point> = near.iter().collect();
        if square > self.square && held(&touching, m) {
            self.square = square;
            self.best = Some((m, contacts(&touching, m)));
        }
    }
}

/// Whether all points are on one side of a square, so that no centre in it is between them.
fn all_on_one_side(points: &[Point], m: [f64; 2], half: f64) -> bool {
    // Directions every 22.5 degrees: cos and sin of the first quadrant, and these rotated by right angles.
    const FAN: [[f64; 2]; 4] = [[1.0, 0.0], [0.92388, 0.38268], [FRAC_1_SQRT_2, FRAC_1_SQRT_2], [0.38268, 0.92388]];
    FAN.iter().flat_map(|&[x, y]| [[x, y], [-y, x]]).any(|[x, y]| {
        let along = points.iter().map(|p| (p.x - m[0]) * x + (p.y - m[1]) * y);
        let (least, most) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let reach = half * (x.abs() + y.abs());
        least > reach || most < -reach
    })
}

/// Whether the points surround the centre: no gap of more than half a turn between neighbours.
///
/// Exactly symmetric points hold a circle between two opposite ones, to the second order of their rounding: hence the small
/// margin above half a turn.
fn held(touching: &[&Point], c: [f64; 2]) -> bool {
    largest_gap(touching.iter().map(|p| (p.y - c[1]).atan2(p.x - c[0]))) <= PI * (1.0 + 1e-9)
}

/// Three of the touching points that hold the circle, or all of them.
fn contacts(touching: &[&Point], c: [f64; 2]) -> Vec<usize> {
    let angle = |p: &Point| (p.y - c[1]).atan2(p.x - c[0]);
    let index = |points: &[&Point]| points.iter().map(|p| p.index).collect();
    let Some(first) = touching.first() else { return Vec::new() };
    // The first point and the points next to its opposite on both sides.
    let turned = |p: &Point| (angle(p) - angle(first)).rem_euclid(2.0 * PI);
    let side = |left: bool| {
        touching
            .iter()
            .filter(|p| (turned(p) < PI) == left && turned(p) > 0.0)
            .min_by(|a, b| (turned(a) - PI).abs().total_cmp(&(turned(b) - PI).abs()))
    };
    match (side(true), side(false)) {
        (Some(a), Some(b)) if held(&[first, a, b], c) => index(&[first, a, b]),
        _ => index(touching),
    }
}
