//! Wall time compared with other libraries, in one run on the same work.
#![allow(missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use interpn::one_dim::linear::LinearHoldLast1D;
use interpn::one_dim::{Interp1D, RegularGrid1D};
use kurbo::{CubicBez, ParamCurveNearest, Point};
use std::hint::black_box;
use truck_geometry::prelude::{BSplineCurve, KnotVec, NurbsCurve, Point3, SPHint1D, SearchNearestParameter, Vector4};
use trueaxis::compensation::Direction;
use trueaxis::contour::Span;
use trueaxis_benches::Random;
use trueaxis_benches::contour::{Query, Shape, Spline, Track};
use trueaxis_benches::tables::{CELL_MM, FIRST_MM, Grid, nine_terms, position, rows};

const QUERIES: u64 = 256;

/// Warm queries whose foot is inside a span.
fn queries(shape: Shape) -> Vec<Query> {
    let track = Track::new(shape);
    (0..4 * QUERIES).map(|seed| track.query(seed)).filter(|q| { *q }.run().evaluations == 2).take(256).collect()
}

/// The cubic through four points of the span, at t = 0, 1/3, 2/3, 1: identical to the span.
fn bezier(span: &Span<f64, f64>) -> CubicBez {
    let at = |t: f64| {
        let [x, y, _] = span.position(t);
        kurbo::Vec2::new(x, y)
    };
    let (p0, a, b, p3) = (at(0.0), at(1.0 / 3.0), at(2.0 / 3.0), at(1.0));
    let p1 = (-5.0 * p0 + 18.0 * a - 9.0 * b + 2.0 * p3) / 6.0;
    let p2 = (2.0 * p0 - 9.0 * a + 18.0 * b - 5.0 * p3) / 6.0;
    CubicBez::new(p0.to_point(), p1.to_point(), p2.to_point(), p3.to_point())
}

fn ours(queries: &[Query]) -> f64 {
    queries.iter().map(|query| query.repeat().error).sum()
}

/// 256 feet on spans of the polynomial butterfly. kurbo receives the span, while trueaxis finds it in a warm search.
fn against_kurbo(c: &mut Criterion) {
    let queries = queries(Shape::PolynomialCubic);
    let pieces: Vec<(CubicBez, Point)> = queries
        .iter()
        .map(|query| {
            let span = query.path.span(query.reference.span).expect("a piece");
            (bezier(span), Point::new(query.point[0], query.point[1]))
        })
        .collect();
    let mut group = c.benchmark_group("polynomial cubic, 256 feet");
    group.bench_function("trueaxis", |b| b.iter(|| ours(black_box(&queries))));
    group.bench_function("kurbo", |b| {
        b.iter(|| black_box(&pieces).iter().map(|(piece, p)| piece.nearest(*p, 1e-9).distance_sq).sum::<f64>())
    });
    group.finish();
}

/// 256 feet on the butterfly: truck starts from the reference's parameter, or searches the whole curve.
fn against_truck(c: &mut Criterion) {
    let queries = queries(Shape::RationalCubic);
    let spline = Spline::butterfly();
    let points = spline.points.iter().zip(&spline.weights).map(|(p, w)| Vector4::new(p.x * w, p.y * w, p.z * w, *w));
    let curve = NurbsCurve::new(BSplineCurve::new(KnotVec::from(spline.knots.clone()), points.collect()));
    let feet: Vec<(Point3, f64)> = queries
        .iter()
        .map(|query| {
            let span = query.path.span(query.reference.span).expect("a piece");
            (Point3::from(query.point), span.u_of(query.reference.t))
        })
        .collect();
    let mut group = c.benchmark_group("butterfly, 256 feet");
    group.bench_function("trueaxis", |b| b.iter(|| ours(black_box(&queries))));
    group.bench_function("truck, from the reference", |b| {
        b.iter(|| {
            let near = |(p, u): &(Point3, f64)| {
                curve.search_nearest_parameter(*p, SPHint1D::Parameter(*u), 100).unwrap_or(0.0)
            };
            black_box(&feet).iter().map(near).sum::<f64>()
        })
    });
    group.sample_size(10);
    group.bench_function("truck, without a hint", |b| {
        b.iter(|| {
            let near = |(p, _): &(Point3, f64)| curve.search_nearest_parameter(*p, SPHint1D::None, 100).unwrap_or(0.0);
            black_box(&feet).iter().map(near).sum::<f64>()
        })
    });
    group.finish();
}

/// Nine values from nine functions of 128 points at 256 positions of three axes; interpn evaluates one function at a time.
fn against_interpn(c: &mut Criterion) {
    let compensation = nine_terms(Grid::Equidistant);
    let mut random = Random(3);
    let places: Vec<[f64; 3]> = (0..QUERIES).map(|_| position(&mut random)).collect();
    let values: Vec<Vec<f64>> = (0..9)
        .map(|k| rows(Grid::Equidistant, 1 + k / 3).iter().map(|row| row.forward[k as usize % 3]).collect())
        .collect();
    let functions: Vec<_> = values
        .iter()
        .map(|values| LinearHoldLast1D::new(RegularGrid1D::new(FIRST_MM, CELL_MM, values).expect("a grid")))
        .collect();
    let mut group = c.benchmark_group("nine linear functions, 256 positions");
    group.bench_function("trueaxis", |b| {
        b.iter(|| {
            let mut held = 0;
            let sum_at = |place: &[f64; 3]| {
                let [x, y, z] =
                    compensation.plain_terms(&compensation.coordinates(place), &[Direction::POSITIVE; 3], &mut held);
                x + y + z
            };
            black_box(&places).iter().map(sum_at).sum::<f64>()
        })
    });
    group.bench_function("interpn", |b| {
        b.iter(|| {
            let sum_at = |place: &[f64; 3]| {
                let one = |(k, f): (usize, &LinearHoldLast1D<_>)| f.eval_one(place[k / 3]).unwrap_or(0.0);
                functions.iter().enumerate().map(one).sum::<f64>()
            };
            black_box(&places).iter().map(sum_at).sum::<f64>()
        })
    });
    group.finish();
}

criterion_group!(side_by_side, against_kurbo, against_truck, against_interpn);
criterion_main!(side_by_side);
