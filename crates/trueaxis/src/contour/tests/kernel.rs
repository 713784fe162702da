//! The foot-point kernel against bisection.

use super::*;
use crate::contour::kernel::{Evaluation, evaluate, evaluate_end, foot};
use crate::position::Nanometres;

/// Wherever the kernel trusts its result, the distance is correct to 1e-6 nm, compared with bisection of the same span.
#[test]
fn the_kernel_is_exact_wherever_it_trusts_itself() {
    let mut random = Noise::new(5);
    let (mut trusted, mut all_queries, mut worst) = (0, 0, 0.0_f64);
    let mut singles = Vec::new();
    for round in 0..60 {
        let spline =
            if round == 0 { Spline::butterfly() } else { Spline::random(&mut random, 2 + round % 4, round % 2 == 0) };
        let double = spans::<f64, f64>(&[spline.segment()]);
        let single = spans::<f32, Nanometres>(&[spline.segment()]);
        for (span, small) in double.iter().zip(&single) {
            for _ in 0..30 {
                let t = 0.05 + 0.9 * random.unit();
                let e = evaluate(span, &[0.0; 3], t);
                let speed = e.straight.sqrt();
                // 10 µm beside the path, started 5 to 20 µm along it.
                let offset = [random.signed(), random.signed(), random.signed()].map(|x| 0.01 * x);
                let p = add(point(span, t), offset);
                let guess = t + 0.02 * random.signed() / speed;
                let local = span.relative(&p);
                let found = foot(span, &local, guess);
                all_queries += 1;
                if found.trusted {
                    trusted += 1;
                    let (mut low, mut high) = ((found.t - 1e-3).max(0.0), (found.t + 1e-3).min(1.0));
                    if evaluate(span, &local, low).g < 0.0 && evaluate(span, &local, high).g > 0.0 {
                        for _ in 0..80 {
                            let middle = 0.5 * (low + high);
                            if evaluate(span, &local, middle).g < 0.0 { low = middle } else { high = middle }
                        }
                        let truth = norm(evaluate(span, &local, 0.5 * (low + high)).vector);
                        worst = worst.max((norm(found.vector) - truth).abs());
                        let p = p.map(Nanometres::of);
                        let rounded =
                            norm(evaluate(span, &span.relative(&p.map(|x| x.to_f64())), 0.5 * (low + high)).vector);
                        let f = foot(small, &small.relative(&p), guess as f32);
                        if f.trusted {
                            singles.push((norm(f.vector.map(f64::from)) - rounded).abs());
                        }
                    }
                }
            }
        }
    }
    assert!(f64::from(trusted) > 0.94 * f64::from(all_queries), "{trusted} of {all_queries}");
    assert!(worst < 1e-12, "{worst:e} mm");
    singles.sort_by(f64::total_cmp);
    let p999 = singles[singles.len() * 999 / 1000];
    assert!(p999 < 2e-6, "f32: {p999:e} mm");
}

/// An evaluation at an end without products equals the general one, in both scalars.
#[test]
fn an_evaluation_at_an_end_is_the_general_one() {
    fn compare<R: Real, P: Position>(random: &mut Noise, all: &[Span<R, P>]) {
        for span in all {
            let point = [random.signed(), random.signed(), random.signed()].map(R::of);
            for (t, at_start) in [(R::ZERO, true), (R::ONE, false)] {
                let (one, other) = (evaluate(span, &point, t), evaluate_end(span, &point, at_start));
                let parts = |e: Evaluation<R>| ([e.g, e.slope, e.straight], e.vector, e.tangent, e.bend);
                assert_eq!(parts(one), parts(other), "{span:?} at {t:?}");
            }
        }
    }
    let mut random = Noise::new(29);
    for round in 0..200 {
        let spline = Spline::random(&mut random, 2 + round % 4, round % 2 == 0);
        let arc = Segment::Arc {
            start: DVec3::new(3.0, 0.0, 0.0),
            end: DVec3::new(-3.0, 0.0, random.signed()),
            center: DVec3::ZERO,
            normal: Z.into(),
            turns: 0,
        };
        compare(&mut random, &spans::<f64, f64>(&[spline.segment(), arc]));
        compare(&mut random, &spans::<f32, Nanometres>(&[spline.segment(), arc]));
    }
}
