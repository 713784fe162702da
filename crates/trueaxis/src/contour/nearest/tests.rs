use crate::contour::{ContourSearch, Flags, Method, Path, PathBuffer, Reference, Segment, Span, convert};
use crate::{HostPath, Nanometres, Position, Real};
use glam::DVec3;
use proptest::prelude::*;
use std::vec::Vec;

const FLAT: [f64; 3] = [0.0, 0.0, 1.0];

/// The butterfly curve in the test data.
pub(super) fn butterfly() -> Vec<Span<f64, f64>> {
    let (mut knots, mut points, mut weights, mut spans) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let text = include_str!("../../../tests/data/butterfly.csv");
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        match line.split(',').map(|x| x.parse().unwrap()).collect::<Vec<f64>>()[..] {
            [knot] => knots.push(knot),
            [x, y, weight] => {
                points.push(DVec3::new(x, y, 0.0));
                weights.push(weight);
            }
            _ => panic!("{line}"),
        }
    }
    convert(&Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights: &weights }, 0, FLAT, |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    spans
}

/// Down and back along a hairpin whose legs are 10 mm apart, then a helix.
fn hairpin() -> HostPath<64> {
    let mut path = HostPath::new();
    path.line([0.0; 3], [100.0, 0.0, 0.0]).unwrap();
    path.arc([100.0, 0.0, 0.0], [100.0, 10.0, 0.0], [100.0, 5.0, 0.0], FLAT).unwrap();
    path.line([100.0, 10.0, 0.0], [0.0, 10.0, 0.0]).unwrap();
    path.arc([0.0, 10.0, 0.0], [0.0, 10.0, 6.0], [0.0, 20.0, 0.0], FLAT).unwrap();
    path
}

/// Smallest distance over many points, accurate to the square of their spacing.
fn sampled(path: &Path<'_, f64, f64>, point: [f64; 3]) -> f64 {
    let mut least = f64::MAX;
    for number in 0.. {
        let Some(span) = path.span(number) else { break };
        for i in 0..=400 {
            let at = span.position(f64::from(i) / 400.0);
            least = least.min((0..3).map(|k| (at[k] - point[k]).powi(2)).sum::<f64>());
        }
    }
    least.sqrt()
}

proptest! {
    #[test]
    fn no_point_of_the_path_is_nearer(x in -40.0..140.0f64, y in -30.0..50.0f64, z in -10.0..15.0f64) {
        let path = hairpin();
        let point = [x, y, z];
        let found = path.path().nearest(point);
        let foot = path.path().span(found.span).unwrap().position(found.t);
        let away = (0..3).map(|k| (foot[k] - point[k]).powi(2)).sum::<f64>().sqrt();
        prop_assert!((found.error - away).abs() < 1e-9, "{found:?}");
        prop_assert!(found.error <= sampled(&path.path(), point) + 1e-9, "{found:?}");
        prop_assert!(found.flags.has(Flags::BRACKETED), "{found:?}");
        // The search near the foot gives the same result.
        let search = ContourSearch::new(20.0, Method::Guarded).unwrap();
        let about = search.nearest(&path.path(), Reference { span: found.span, t: found.t }, point);
        prop_assert!((about.error - found.error).abs() < 1e-9, "{about:?} {found:?}");
    }
}

#[test]
fn ends_and_corners_are_feet_and_the_other_leg_is_seen() {
    let path = hairpin();
    let beyond = path.path().nearest([-3.0, -4.0, 0.0]);
    assert!(beyond.flags.has(Flags::AT_END) && (beyond.error - 5.0).abs() < 1e-12, "{beyond:?}");
    let second = path.path().nearest([50.0, 6.0, 0.0]);
    assert_eq!(path.path().span(second.span).unwrap().segment(), 2);
    assert!((second.error - 4.0).abs() < 1e-12 && (second.normal - 4.0).abs() < 1e-12, "{second:?}");
    let mut corner = HostPath::<8>::new();
    corner.line([0.0; 3], [10.0, 0.0, 0.0]).unwrap();
    corner.line([10.0, 0.0, 0.0], [10.0, 10.0, 0.0]).unwrap();
    let outside = corner.path().nearest([13.0, -4.0, 0.0]);
    assert!(outside.flags.has(Flags::AT_CORNER) && (outside.error - 5.0).abs() < 1e-12, "{outside:?}");
}

#[test]
fn nothing_is_measured_on_no_path_and_at_no_point() {
    assert!(!Path::<f64, f64>::new(&[], 0, false).nearest([0.0; 3]).is_measured());
    let path = hairpin();
    for bad in [f64::NAN, f64::INFINITY, 1e12] {
        assert!(!path.path().nearest([0.0, bad, 0.0]).is_measured());
    }
}

#[test]
fn single_precision_agrees_to_a_few_nanometres() {
    let double = hairpin();
    let mut single = PathBuffer::<f32, Nanometres, 64>::new();
    single.line([0.0; 3], [100.0, 0.0, 0.0]).unwrap();
    single.arc([100.0, 0.0, 0.0], [100.0, 10.0, 0.0], [100.0, 5.0, 0.0], FLAT).unwrap();
    single.line([100.0, 10.0, 0.0], [0.0, 10.0, 0.0]).unwrap();
    for i in 0..200 {
        let point = [0.5 * f64::from(i), 0.003 * f64::from(i % 7), 0.01];
        let (wide, narrow) = (double.path().nearest(point), single.path().nearest(point.map(Position::of)));
        assert!((wide.error - narrow.error.to_f64()).abs() < 5e-6, "{wide:?} {narrow:?}");
    }
}
