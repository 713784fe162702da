//! Wherever both feet are trusted, their distances are correct: compared with bisection of the same span.

use super::*;
use crate::testing::share::share;

/// Paths of one kind.
fn kind(random: &mut Noise, kind: usize) -> Vec<Span<f64, f64>> {
    let line = |end: V| Segment::Line { start: DVec3::ZERO, end: end.into() };
    let size = 10f64.powf(random.range(-0.5, 1.5));
    match kind {
        0 => spans(&[line(random.vector(size))]),
        1 | 2 => {
            let rise = if kind == 1 { 0.0 } else { size * random.signed() };
            let (sin, cos) = random.range(0.3, 6.0).sin_cos();
            spans(&[Segment::Arc {
                start: DVec3::new(size, 0.0, 0.0),
                end: DVec3::new(size * cos, size * sin, rise),
                center: DVec3::ZERO,
                normal: Z.into(),
                turns: 0,
            }])
        }
        3..=10 => spans(&[
            Spline::random(random, 2 + kind / 2 - 1 - usize::from(kind == 10), kind.is_multiple_of(2)).segment()
        ]),
        11 => {
            // Near a cusp: the inner control points of a cubic cross over.
            let (x, y) = (random.range(0.8, 1.6), 0.3 * random.signed());
            let points = [[0.0; 3], [x, 1.0, y], [1.0 - x, 1.0, -y], [1.0, 0.0, 0.0]].map(|p| p.map(|x| size * x));
            bezier(&points)
        }
        _ => {
            // Inflections, with feet that start exactly there.
            let bend = 0.4 * random.signed();
            let points = [[0.0; 3], [1.0, bend, 0.0], [2.0, -bend, 0.0], [3.0, 0.0, 0.0]].map(|p| p.map(|x| size * x));
            bezier(&points)
        }
    }
}

fn bezier(points: &[V; 4]) -> Vec<Span<f64, f64>> {
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let points = points.map(DVec3::from_array);
    spans(&[Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights: &[] }])
}

const KINDS: usize = 13;
const QUERIES: usize = 100_000;

/// Distances of one query in the step's scalar, `None` if not trusted.
fn query<R: Real, P: Position>(
    span: &Span<R, P>,
    position: [f64; 3],
    d: [R; 3],
    guess: f64,
) -> [Option<(f64, f64)>; 2] {
    let [mut tip, mut encoder] = [ContourError::none(); 2];
    let mut along = Tangent::NONE;
    let position = position.map(P::of);
    let start = Start { guess: R::of(guess), window: R::ONE, place: R::ZERO, max_lag: -R::ONE };
    let seen = feet(span, &position, &d, &start, &mut tip, &mut encoder, &mut along);
    let inside = |converged: bool, foot: &ContourError<R>| {
        (converged && foot.t.is_in_unit()).then(|| (foot.t.to_f64(), foot.error.to_f64()))
    };
    [inside(seen.tip(), &tip), inside(seen.encoder(), &encoder)]
}

#[test]
fn distances_of_both_feet_agree_with_bisection() {
    let mut random = Noise::new(41);
    let mut worst = [[0.0_f64; 2]; KINDS];
    let mut trusted = [[0; 2]; KINDS];
    let mut singles = [Vec::new(), Vec::new()];
    let mut asked = [0; KINDS];
    let mut queries = 0;
    while queries < share(QUERIES) {
        let number = queries % KINDS;
        let double = kind(&mut random, number);
        let single: Vec<Span<f32, Nanometres>> = double.iter().map(Span::rounded).collect();
        for (span, small) in double.iter().zip(&single).take(8) {
            for _ in 0..8 {
                queries += 1;
                asked[number] += 1;
                let t = random.unit();
                let at = span.position(t);
                // The tip up to 0.1 mm beside the path, the encoder up to 0.3 mm from it, often along the path.
                let tip = add(at, away(&mut random, -6.0, -1.0));
                let mut d = away(&mut random, -6.0, -0.52);
                if random.unit() < 0.3 {
                    let along = sub(span.position((t + 1e-4).min(1.0)), at);
                    let size = norm(d) / norm(along).max(1e-12);
                    d = along.map(|x| x * size);
                }
                let speed = span.arc_speed(t);
                let guess = t + 10f64.powf(random.range(-6.0, -1.0)) * random.signed() / speed;
                // The encoder at whole nanometres, and d in single precision: both scalars see the same points.
                let encoder = sub(tip, d).map(|x| (x * 1e6).round() / 1e6);
                let d = d.map(|x| f64::from(x as f32));
                let tip = add(encoder, d);
                let found = query(span, encoder, d, guess);
                let rounded = query(small, encoder, d.map(|x| x as f32), guess);
                for (which, p) in [tip, encoder].into_iter().enumerate() {
                    if let Some((t, error)) = found[which] {
                        trusted[number][which] += 1;
                        let truth = by_bisection(span, p, t);
                        let off = truth.map_or(f64::MAX, |truth| (error - truth).abs());
                        worst[number][which] = worst[number][which].max(off);
                    }
                    if let Some((t, error)) = rounded[which]
                        && let Some(truth) = by_bisection(span, p, t)
                    {
                        singles[which].push((error - truth).abs());
                    }
                }
            }
        }
    }
    for singles in &singles {
        // One in a thousand, plus three standard deviations of that count.
        let allowed = 1e-3 * singles.len() as f64;
        let beyond = singles.iter().filter(|off| **off >= 2e-6).count();
        assert!(beyond as f64 <= allowed + 3.0 * allowed.sqrt(), "f32: {beyond} of {}", singles.len());
    }
    for (number, worst) in worst.iter().enumerate() {
        assert!(worst.iter().all(|worst| *worst < 1e-12), "kind {number}: {worst:?} mm");
        // More than half, minus three standard deviations of that count.
        let (of_encoder, asked) = (f64::from(trusted[number][1]), f64::from(asked[number]));
        assert!(of_encoder > 0.5 * asked - 1.5 * asked.sqrt(), "kind {number}: {of_encoder} of {asked}");
    }
}
