//! Local projection compared with SISL's: a foot near a guess on the butterfly, wall time in one run.
//!
//! SISL is a C library (Debian: `libsisl-dev`), linked for this comparison only.
#![allow(missing_docs, unsafe_code)]

use std::hint::black_box;
use std::time::Instant;
use trueaxis::contour::{ContourSearch, Method, Path, Reference};
use trueaxis_benches::Random;
use trueaxis_benches::contour::{Shape, Spline, Track};

/// Queries per pass, and number of passes, of which the fastest counts.
const QUERIES: usize = 512;
const PASSES: u32 = 60;
/// Half-window, mm.
const WINDOW_MM: f64 = 2.0;
/// Tolerance passed to SISL, mm.
const TOLERANCE_MM: f64 = 1e-9;

/// SISL's curve, used only through pointers.
#[repr(C)]
struct Curve {
    _private: [u8; 0],
}

#[link(name = "sisl", kind = "static")]
unsafe extern "C" {
    fn newCurve(
        points: i32,
        order: i32,
        knots: *mut f64,
        coefficients: *mut f64,
        kind: i32,
        dim: i32,
        copy: i32,
    ) -> *mut Curve;
    fn s1774(
        curve: *mut Curve,
        point: *mut f64,
        dim: i32,
        tolerance: f64,
        first: f64,
        last: f64,
        guess: f64,
        found: *mut f64,
        status: *mut i32,
    );
}

/// One spline in both libraries.
struct Pair {
    curve: *mut Curve,
    spline: Spline,
    path: Path<'static, f64, f64>,
    lengths: Vec<f64>,
}

/// A point, and a guess in both parametrisations.
struct Query {
    point: [f64; 3],
    guess: Reference<f64>,
    u: f64,
}

impl Pair {
    fn new(shape: Shape, spline: Spline) -> Pair {
        let track = Track::new(shape);
        let path = track.path();
        let rational = !spline.weights.is_empty();
        let (kind, mut coefficients) = (if rational { 2 } else { 1 }, Vec::new());
        for (i, point) in spline.points.iter().enumerate() {
            let weight = spline.weights.get(i).copied().unwrap_or(1.0);
            coefficients.extend((*point * weight).to_array());
            coefficients.extend(rational.then_some(weight));
        }
        let mut knots = spline.knots.clone();
        // SAFETY: arrays with the given lengths, which the function copies.
        let curve = unsafe {
            newCurve(spline.points.len() as i32, 4, knots.as_mut_ptr(), coefficients.as_mut_ptr(), kind, 3, 1)
        };
        assert!(!curve.is_null());
        let lengths = (0..track.pieces()).filter_map(|number| path.span(number)).map(|span| span.length()).collect();
        Pair { curve, spline, path, lengths }
    }

    /// Reference at an arc length from the start, clamped to the path.
    fn place(&self, mut arc: f64) -> Reference<f64> {
        let mut number = 0;
        while arc > self.lengths[number] && number + 1 < self.lengths.len() {
            arc -= self.lengths[number];
            number += 1;
        }
        let span = self.path.span(number as u32).expect("a span");
        Reference { span: number as u32, t: span.t_at(arc) }
    }

    /// Points up to 20 µm per axis from the path, evenly distributed along it; guesses `off` mm ahead or behind.
    fn queries(&self, off: f64) -> Vec<Query> {
        let mut random = Random(5);
        let whole: f64 = self.lengths.iter().sum();
        let one = |_| {
            let arc = WINDOW_MM + random.unit() * (whole - 2.0 * WINDOW_MM);
            let at = self.place(arc);
            let point = self.path.span(at.span).expect("a span").position(at.t).map(|x| x + 0.02 * random.signed());
            let guess = self.place(if random.unit() < 0.5 { arc - off } else { arc + off });
            Query { point, guess, u: self.path.span(guess.span).expect("a span").u_of(guess.t) }
        };
        (0..QUERIES).map(one).collect()
    }

    fn theirs(&self, query: &Query) -> f64 {
        let (mut found, mut status, mut point) = (0.0, 0, query.point);
        let (first, last) = (self.spline.knots[3], self.spline.knots[self.spline.points.len()]);
        // SAFETY: a curve from `newCurve`, a point of three coordinates, two results.
        unsafe {
            s1774(self.curve, point.as_mut_ptr(), 3, TOLERANCE_MM, first, last, query.u, &mut found, &mut status);
        }
        found
    }

    /// Distance at SISL's parameter.
    fn distance(&self, query: &Query, u: f64) -> f64 {
        let at = self.path.at(0, u).position().expect("a point of the path");
        (0..3).map(|k| (at[k] - query.point[k]).powi(2)).sum::<f64>().sqrt()
    }
}

fn fastest(queries: &[Query], mut work: impl FnMut(&Query)) -> f64 {
    let pass = |_| {
        let start = Instant::now();
        queries.iter().for_each(&mut work);
        start.elapsed().as_nanos() as f64 / queries.len() as f64
    };
    (0..PASSES).map(pass).fold(f64::MAX, f64::min)
}

fn main() {
    let search = ContourSearch::new(WINDOW_MM, Method::Guarded).expect("a valid window");
    for (shape, spline) in [(Shape::RationalCubic, Spline::butterfly()), (Shape::PolynomialCubic, Spline::polynomial())]
    {
        let pair = Pair::new(shape, spline);
        for off in [0.0, 0.02, 0.1, 1.0] {
            let queries = pair.queries(off);
            let (mut theirs_elsewhere, mut ours_elsewhere) = (0, 0);
            for query in &queries {
                let truth = pair.path.nearest(query.point).error;
                let ours = search.foot_near(&pair.path, query.guess, &query.point).expect("a foot");
                ours_elsewhere += u32::from((ours.distance() - truth).abs() > 1e-9);
                theirs_elsewhere += u32::from(pair.distance(query, pair.theirs(query)) - truth > 1e-7);
            }
            let theirs = fastest(&queries, |query| _ = black_box(pair.theirs(query)));
            let ours = fastest(&queries, |query| {
                _ = black_box(search.foot_near(&pair.path, black_box(query.guess), &query.point));
            });
            let window = fastest(&queries, |query| {
                _ = black_box(search.nearest(&pair.path, black_box(query.guess), query.point));
            });
            println!(
                "{shape:?}, guess {off} mm off: foot_near {ours:.0} ns, SISL {theirs:.0} ns, ratio 1/{:.1}; elsewhere than \
                 the nearest foot {ours_elsewhere} and {theirs_elsewhere} of {QUERIES}; all feet within 2 mm {window:.0} ns",
                theirs / ours
            );
        }
    }
}
