//! Paths and queries of the contour search.

use crate::Random;
use trueaxis::contour::{ContourError, ContourSearch, ContourState, Method, Path, Reference, Segment, Span, convert};
use trueaxis::glam::DVec3;

const BUTTERFLY: &str = include_str!("../../crates/trueaxis/tests/data/butterfly.csv");

/// A cubic spline as given in a program.
#[derive(Clone, Debug, Default)]
pub struct Spline {
    /// Knots.
    pub knots: Vec<f64>,
    /// Control points, mm.
    pub points: Vec<DVec3>,
    /// Weights; empty for weights of one.
    pub weights: Vec<f64>,
}

impl Spline {
    /// The butterfly of the test data, degree 3, rational.
    pub fn butterfly() -> Self {
        let mut spline = Spline::default();
        for line in BUTTERFLY.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
            let numbers: Vec<f64> = line.split(',').map(|x| x.parse().expect("a number")).collect();
            match numbers[..] {
                [knot] => spline.knots.push(knot),
                [x, y, weight] => {
                    spline.points.push(DVec3::new(x, y, 0.0));
                    spline.weights.push(weight);
                }
                _ => panic!("neither a knot nor a point: {line}"),
            }
        }
        spline
    }

    /// The butterfly with all weights one.
    pub fn polynomial() -> Self {
        Spline { weights: Vec::new(), ..Spline::butterfly() }
    }

    /// The spline as a segment of a path.
    pub fn segment(&self) -> Segment<'_> {
        Segment::Nurbs { degree: 3, knots: &self.knots, points: &self.points, weights: &self.weights }
    }
}

/// Shape of the searched path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// The butterfly.
    RationalCubic,
    /// The butterfly with weights of one.
    PolynomialCubic,
    /// A semicircle of 30 mm.
    Arc,
    /// A straight line of 100 mm.
    Line,
}

/// The spans of a shape.
pub fn spans(shape: Shape) -> Vec<Span<f64, f64>> {
    let (butterfly, polynomial) = (Spline::butterfly(), Spline::polynomial());
    let segment = match shape {
        Shape::RationalCubic => butterfly.segment(),
        Shape::PolynomialCubic => polynomial.segment(),
        Shape::Arc => Segment::Arc {
            start: DVec3::new(30.0, 0.0, 0.0),
            end: DVec3::new(-30.0, 0.0, 0.0),
            center: [0.0; 3].into(),
            normal: DVec3::new(0.0, 0.0, 1.0),
            turns: 0,
        },
        Shape::Line => Segment::Line { start: [0.0; 3].into(), end: DVec3::new(80.0, 60.0, 0.0) },
    };
    let mut spans = Vec::new();
    convert(&segment, 0, [0.0, 0.0, 1.0], |span| {
        spans.push(span);
        Ok(())
    })
    .expect("a valid path");
    spans
}

/// A warm search and the query of the next cycle.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// The search.
    pub search: ContourSearch<f64>,
    /// Path that is searched.
    pub path: Path<'static, f64, f64>,
    /// State of the search.
    pub state: ContourState<f64>,
    /// Position of the interpolator.
    pub reference: Reference<f64>,
    /// Position of the tool, mm.
    pub point: [f64; 3],
}

impl Query {
    /// Runs one cycle.
    #[inline(always)]
    pub fn run(&mut self) -> ContourError<f64> {
        self.search.update(&mut self.state, &self.path, self.reference, self.point)
    }

    /// Runs the cycle on a copy of the state, so that it can be repeated.
    #[inline(always)]
    pub fn repeat(&self) -> ContourError<f64> {
        let mut state = self.state;
        let found = self.search.update(&mut state, &self.path, self.reference, self.point);
        std::hint::black_box(&state);
        found
    }
}

/// A path for queries.
#[derive(Clone, Copy, Debug)]
pub struct Track(Path<'static, f64, f64>, u32);

/// Cycles after which a stationary search is warm.
const WARM: usize = 100;

impl Track {
    /// Converts the shape, which stays in memory until the process ends.
    pub fn new(shape: Shape) -> Self {
        let spans = spans(shape);
        let count = spans.len() as u32;
        Track(Path::new(spans.leak(), 0, false), count)
    }

    /// The path.
    pub fn path(&self) -> Path<'static, f64, f64> {
        self.0
    }

    /// Number of spans.
    pub fn pieces(&self) -> u32 {
        self.1
    }

    /// Query number `seed`: warm at a random point, then up to 50 µm further along the path, with the tool up to 20 µm off the
    /// path and up to 20 µm away along it.
    pub fn query(&self, seed: u64) -> Query {
        let mut random = Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
        let number = ((random.unit() * f64::from(self.1)) as u32).min(self.1 - 1);
        self.near(number, random.unit(), &mut random)
    }

    /// A query in the middle of span `number`.
    pub fn middle(&self, number: u32) -> Query {
        self.near(number, 0.5, &mut Random(7))
    }

    fn near(&self, number: u32, t: f64, random: &mut Random) -> Query {
        let span = self.0.span(number).expect("a piece of the path");
        let nearby = |random: &mut Random, place: [f64; 3]| {
            [place[0] + 0.02 * random.signed(), place[1] + 0.02 * random.signed(), place[2] + 0.02 * random.signed()]
        };
        let mut query = Query {
            search: ContourSearch::new(1.0, Method::Guarded).expect("a valid lag"),
            path: self.0,
            state: ContourState::default(),
            reference: Reference { span: number, t },
            point: nearby(random, span.position(t)),
        };
        for _ in 0..WARM {
            query.run();
        }
        let step = 0.05 * random.unit();
        let next = span.arc_length(t) + step;
        let ahead = self.0.span(number + 1).filter(|_| next > span.length());
        let (span, number, t) = match ahead {
            Some(ahead) => (ahead, number + 1, ahead.t_at(next - span.length())),
            None => (span, number, span.t_at(next)),
        };
        query.reference = Reference { span: number, t };
        query.point = nearby(random, span.position(t));
        query
    }
}
