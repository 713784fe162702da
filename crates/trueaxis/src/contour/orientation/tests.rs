#![allow(clippy::indexing_slicing)]

use crate::contour::{
    ContourError, ContourSearch, ContourState, Flags, Method, OrientationError, Path, Reference, Segment, Span,
    ToolPath, Turn, convert,
};
use crate::position::{Nanometres, Position};
use crate::real::Real;
use crate::vector::V3;
use glam::DVec3;
use proptest::prelude::*;
use std::{vec, vec::Vec};

const Z: [f64; 3] = [0.0, 0.0, 1.0];
const CORNER: [f64; 3] = [10.0, 5.0, 2.0];

/// Head A on C: the tool's direction is R_z(C) R_x(A) z, in doubles, with std.
fn head([a, _, c]: [f64; 3]) -> [f64; 3] {
    let (a, c) = (a.to_radians(), c.to_radians());
    [a.sin() * c.sin(), -a.sin() * c.cos(), a.cos()]
}

fn of_axes<R: Real>(axes: [R; 3]) -> R::Vec3 {
    V3::<R>::of(head(axes.map(R::to_f64))).glam()
}

fn angle_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (V3::<f64>::of(a), V3::<f64>::of(b));
    a.cross(b).norm().atan2(a.dot(b))
}

/// Segments and the rotary positions at their ends.
fn build<R: Real, P: Position>(segments: &[(Segment<'_>, [f64; 3], [f64; 3])]) -> (Vec<Span<R, P>>, Vec<Turn<R>>) {
    let (mut spans, mut turns) = (Vec::new(), Vec::new());
    for (number, (segment, start, end)) in segments.iter().enumerate() {
        convert(segment, number as u32, Z, |span| {
            turns.push(Turn::axes(&span, [0.0, 1.0], *start, *end));
            spans.push(span);
            Ok(())
        })
        .unwrap();
    }
    (spans, turns)
}

/// Along X, a turn by 60 degrees of A and 20 of C in place, then along Y.
fn corner<R: Real, P: Position>() -> (Vec<Span<R, P>>, Vec<Turn<R>>) {
    let [x, y, z] = CORNER;
    build(&[
        (Segment::Line { start: DVec3::new(x - 12.0, y, z), end: CORNER.into() }, [10.0, 0.0, 0.0], [10.0, 0.0, 0.0]),
        (Segment::Turning { point: CORNER.into() }, [10.0, 0.0, 0.0], [70.0, 0.0, 20.0]),
        (Segment::Line { start: CORNER.into(), end: DVec3::new(x, y + 12.0, z) }, [70.0, 0.0, 20.0], [70.0, 0.0, 20.0]),
    ])
}

fn foot<R: Real>(span: u32, t: f64) -> ContourError<R> {
    ContourError { span, t: R::of(t), flags: Flags::BRACKETED, ..ContourError::none() }
}

/// The search resolves a tilt of one microradian about any direction, with its size and sign.
fn resolves_a_microradian<R: Real, P: Position>(permitted: f64) {
    let (spans, turns) = build::<R, P>(&[(
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(10.0, 0.0, 0.0) },
        [20.0, 0.0, -30.0],
        [41.0, 0.0, 15.0],
    )]);
    let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
    for i in 0..200 {
        let t = f64::from(i) / 199.0;
        let a = V3::<f64>::of(head([20.0 + 21.0 * t, 0.0, -30.0 + 45.0 * t]));
        let any = V3::new((i as f64).sin(), (i as f64 * 1.7).cos(), 0.3);
        let w = a.cross(any) * (1e-6 / a.cross(any).norm());
        let b = V3::<R>::of((a + w.cross(a)).array()).glam();
        let reference = Reference { span: 0, t: R::of(t) };
        let found = path.orientation(reference, &foot(0, t), b, of_axes);
        assert!((found.angle.to_f64() - 1e-6).abs() < permitted, "{}", found.angle.to_f64());
        let vector = V3::<f64>::of(found.vector.into().map(R::to_f64));
        assert!((vector - w).norm() < permitted, "{vector:?} {w:?}");
        assert_eq!(found.evaluations, 1);
    }
}

#[test]
fn a_microradian_is_resolved_in_doubles() {
    resolves_a_microradian::<f64, f64>(1e-12);
}

#[test]
fn a_microradian_is_resolved_in_singles() {
    // Components of a unit vector are rounded to 6e-8, the rotary positions to 2e-6 degrees.
    resolves_a_microradian::<f32, Nanometres>(0.25e-6);
}

#[test]
fn rotary_axes_move_linearly_in_the_angle_of_an_arc() {
    let arc = Segment::Arc {
        start: DVec3::new(30.0, 0.0, 0.0),
        end: DVec3::new(-30.0, 0.0, 0.0),
        center: [0.0; 3].into(),
        normal: Z.into(),
        turns: 0,
    };
    let (spans, turns) = build::<f64, f64>(&[(arc, [-725.0, 0.0, 5.0], [-635.0, 0.0, 25.0])]);
    assert!(spans.len() > 4);
    for (span, turn) in spans.iter().zip(&turns) {
        for i in 0..=20 {
            let t = f64::from(i) / 20.0;
            let u = span.u_of(t);
            let truth = head([-725.0 + 90.0 * u, 0.0, 5.0 + 20.0 * u]);
            let found = turn.direction(t, of_axes).to_array();
            assert!(angle_between(truth, found) < 1e-9, "{t}: {:e}", angle_between(truth, found));
        }
    }
}

#[test]
fn a_great_circle_is_the_shortest_way_at_a_constant_rate() {
    let span = Span::<f64, f64>::turning([0.0; 3], 0, Z);
    let (a, b) = ([1.0, 2.0, 3.0], [-2.0, 0.5, 0.25]);
    let turn = Turn::directions(&span, [0.0, 1.0], a, b).unwrap();
    let whole = angle_between(a, b);
    for i in 0..=10 {
        let t = f64::from(i) / 10.0;
        let d = turn.direction(t, of_axes).to_array();
        assert!((V3::<f64>::of(d).norm() - 1.0).abs() < 1e-14);
        assert!((angle_between(a, d) - t * whole).abs() < 1e-14);
        assert!((angle_between(d, b) - (1.0 - t) * whole).abs() < 1e-14);
    }
    let line = Segment::Line { start: [0.0; 3].into(), end: DVec3::new(40.0, 0.0, 0.0) };
    convert::<f64, f64>(&line, 0, Z, |span| {
        let piece = Turn::directions(&span, [0.0, 1.0], a, b).unwrap();
        let middle = piece.direction(0.5, of_axes).to_array();
        let u = 0.5 * (span.u_range()[0] + span.u_range()[1]);
        assert!((angle_between(a, middle) - u * whole).abs() < 1e-14);
        Ok(())
    })
    .unwrap();
    let still = Turn::directions(&span, [0.0, 1.0], a, a).unwrap();
    assert!(angle_between(still.direction(0.7, of_axes).to_array(), a) < 1e-15);
    assert!(Turn::directions(&span, [0.0, 1.0], [0.0; 3], b).is_none());
    assert!(Turn::directions(&span, [0.0, 1.0], a, a.map(|x| -x)).is_none());
    assert!(Turn::directions(&span, [0.0, 1.0], [f64::NAN, 0.0, 1.0], b).is_none());
}

/// In a turn in place the foot is the nearest orientation: compared with ten thousand samples of the turn.
#[test]
fn the_nearest_orientation_of_a_turn_on_the_spot_is_found() {
    let (spans, turns) = corner::<f64, f64>();
    let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
    for i in 0..=100 {
        let s = f64::from(i) / 100.0;
        let off = 0.3 * (f64::from(i) * 0.9).sin();
        let actual = head([10.0 + 60.0 * s + off, 0.0, 20.0 * s - off]);
        let samples = (-5000..=5000).map(|i| (s + f64::from(i) * 4e-6).clamp(0.0, 1.0));
        let brute = samples.map(|s| angle_between(head([10.0 + 60.0 * s, 0.0, 20.0 * s]), actual)).fold(9.0, f64::min);
        // The reference leads by six degrees.
        let reference = Reference { span: 1, t: (s + 0.1).min(1.0) };
        let found = path.orientation(reference, &foot(0, 1.0), V3::<f64>::of(actual).glam(), of_axes);
        assert!(found.angle <= brute + 1e-10 && found.angle > brute - 2.5e-6, "{s}: {} {brute}", found.angle);
        assert!(found.evaluations <= 27);
        // With the reference already past the turn, and the foot on either side of the point.
        for at in [foot(0, 1.0), foot(2, 0.0)] {
            let found = path.orientation(Reference { span: 2, t: 1e-3 }, &at, V3::<f64>::of(actual).glam(), of_axes);
            assert!(found.angle <= brute + 1e-6, "{s}: {} {brute}", found.angle);
        }
    }
}

/// Two axes turn one after the other in place, with tool and reference on different sides of the border.
#[test]
fn turns_on_the_spot_follow_each_other() {
    let (spans, turns) = build::<f64, f64>(&[
        (Segment::Turning { point: CORNER.into() }, [0.0, 0.0, 10.0], [40.0, 0.0, 10.0]),
        (Segment::Turning { point: CORNER.into() }, [40.0, 0.0, 10.0], [40.0, 0.0, 100.0]),
    ]);
    let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
    let search = ContourSearch::new(1.0, Method::Guarded).unwrap();
    let mut state = ContourState::default();
    for i in -20..400 {
        // A cold search takes some cycles.
        let place = f64::from(i.max(0)) / 200.0;
        let reference = Reference { span: place as u32, t: place.fract() };
        let back = (place - 0.02).max(0.0);
        let axes = if back < 1.0 { [40.0 * back, 0.0, 10.0] } else { [40.0, 0.0, 10.0 + 90.0 * (back - 1.0)] };
        let tip = search.update(&mut state, &path.path, reference, [CORNER[0] + 0.003, CORNER[1], CORNER[2] - 0.004]);
        if i < 0 {
            continue;
        }
        assert!((tip.error - 0.005).abs() < 1e-12, "{tip:?}");
        let found = path.orientation(reference, &tip, V3::<f64>::of(head(axes)).glam(), of_axes);
        assert!(found.angle < 1e-6, "{place}: {found:?}");
        assert_eq!(found.span, back as u32, "{place}");
    }
}

/// Distance from the nearer of the corner's two legs.
fn to_legs(p: [f64; 3]) -> f64 {
    let [x, y, z] = core::array::from_fn(|k| p[k] - CORNER[k]);
    let (first, second) = (x.min(0.0), y.clamp(0.0, 12.0));
    let a = ((x - first).powi(2) + y * y + z * z).sqrt();
    let b = (x * x + (y - second).powi(2) + z * z).sqrt();
    a.min(b)
}

/// A machine with a lag of 1 ms and disturbances of some micrometres follows along X, turns in place and leaves along Y.
fn walks_the_corner<R: Real, P: Position>(permitted_mm: f64) {
    let (spans, turns) = corner::<R, P>();
    let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
    let search = ContourSearch::<R>::new(1.0, Method::Guarded).unwrap();
    let mut state = ContourState::default();
    let (mut tip, mut axes) = (path.path.span(0).unwrap().position(R::ZERO).map(Position::to_f64), [10.0, 0.0, 0.0]);
    let mut before = None::<f64>;
    let mut on_the_turn = 0;
    for i in 0..9000 {
        // 50 mm/s, 60 degrees in 0.3 s, at 10 kHz.
        let time = f64::from(i) * 1e-4;
        let (span, s) = match time {
            t if t < 0.24 => (0, t / 0.24),
            t if t < 0.54 => (1, (t - 0.24) / 0.3),
            t => (2, ((t - 0.54) / 0.24).min(1.0)),
        };
        let command = match span {
            0 => ([CORNER[0] - 12.0 * (1.0 - s), CORNER[1], CORNER[2]], [10.0, 0.0, 0.0]),
            1 => (CORNER, [10.0 + 60.0 * s, 0.0, 20.0 * s]),
            _ => ([CORNER[0], CORNER[1] + 12.0 * s, CORNER[2]], [70.0, 0.0, 20.0]),
        };
        for k in 0..3 {
            tip[k] += 0.1 * (command.0[k] - tip[k]);
            axes[k] += 0.1 * (command.1[k] - axes[k]);
        }
        let stray = [0.003 * (40.0 * time).sin(), 0.002 * (55.0 * time).cos(), 0.001];
        let actual: [f64; 3] = core::array::from_fn(|k| tip[k] + stray[k]);
        let reference = Reference { span, t: R::of(s) };
        let at = search.update(&mut state, &path.path, reference, actual.map(P::of));
        let error = at.error.to_f64();
        assert!(at.evaluations <= 6 && error.is_finite() && at.lag.is_finite());
        if i > 60 {
            assert!((error - to_legs(actual)).abs() < permitted_mm, "{time}: {error} {} {at:?}", to_legs(actual));
        }
        let found = path.orientation(reference, &at, V3::<R>::of(head(axes)).glam(), of_axes);
        assert!(found.evaluations <= 27 && found.angle.is_finite());
        let angle = found.angle.to_f64();
        on_the_turn += u32::from(found.span == 1);
        if let Some(last_angle) = before {
            // If the tool moves on before the turn is complete, the remaining turn counts less than the motion of the tip.
            assert!((angle - last_angle).abs() < 0.6e-3, "{time}: {last_angle} {angle}");
        }
        // In place both axes lag alike: no error, although the reference is 0.2 degrees ahead.
        if (0.25..0.54).contains(&time) {
            assert!(angle < 2e-6, "{time}: {angle}");
        }
        before = Some(angle);
    }
    assert!(on_the_turn > 2900, "{on_the_turn}");
}

#[test]
fn a_turn_on_the_spot_is_crossed_in_doubles() {
    walks_the_corner::<f64, f64>(1e-9);
}

#[test]
fn a_turn_on_the_spot_is_crossed_in_singles() {
    walks_the_corner::<f32, Nanometres>(3e-6);
}

#[test]
fn a_path_without_turns_has_no_orientation_error() {
    let (spans, _) = corner::<f64, f64>();
    let path = ToolPath::new(Path::new(&spans, 0, false), &[]);
    let found = path.orientation(Reference { span: 0, t: 0.5 }, &foot(0, 0.5), V3::<f64>::of(Z).glam(), of_axes);
    assert_eq!(found, OrientationError::none());
    let found =
        path.orientation(Reference { span: 0, t: 0.5 }, &ContourError::none(), V3::<f64>::of(Z).glam(), of_axes);
    assert!(!found.is_measured());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(3000) as u32, ..ProptestConfig::default() })]

    /// For any turns, directions, tips and orders of spans the result is finite and bounded, and the tip search still finds
    /// the nearest foot.
    #[test]
    fn nothing_makes_it_fail(
        kinds in prop::collection::vec((any::<bool>(), -400.0..400.0f64, -400.0..400.0f64), 1..6),
        closed in any::<bool>(),
        walk in prop::collection::vec((0u32..7, 0.0..=1.0f64, -0.05..0.05f64, -180.0..180.0f64), 40),
    ) {
        let mut segments = vec![];
        let (mut at, mut axes) = ([0.0; 3], [0.0; 3]);
        for (stationary, a, c) in kinds {
            let end = if stationary { at } else { [at[0] + 3.0, at[1] + a / 100.0, at[2]] };
            let next = [a, 0.0, c];
            let segment = if stationary { Segment::Turning { point: at.into() } } else { Segment::Line { start: at.into(), end: end.into() } };
            segments.push((segment, axes, next));
            (at, axes) = (end, next);
        }
        let (spans, turns) = build::<f32, Nanometres>(&segments);
        let path = ToolPath::new(Path::new(&spans, 0, closed), &turns);
        let search = ContourSearch::<f32>::new(1.0, Method::Guarded).unwrap();
        let mut state = ContourState::default();
        for (span, t, off, angle) in walk {
            let reference = Reference { span, t: t as f32 };
            let point = path.path.span(span).map_or([Nanometres(0); 3], |s| s.position(t as f32));
            let point = [point[0].plus(off as f32), point[1], point[2].plus(-off as f32)];
            let tip = search.update(&mut state, &path.path, reference, point);
            prop_assert!(tip.error.is_finite() && tip.lag.is_finite() && tip.t.is_finite() && tip.evaluations <= 6);
            prop_assert!(tip.normal.is_finite() && tip.binormal.is_finite() && tip.tangential.is_finite());
            let found = path.orientation(reference, &tip, V3::<f32>::of(head([angle, 0.0, 3.0 * angle])).glam(), of_axes);
            prop_assert!(found.angle.is_finite() && (0.0..=std::f32::consts::PI).contains(&found.angle));
            prop_assert!(found.evaluations <= 27 && (0.0..=1.0).contains(&found.t));
        }
    }
}
