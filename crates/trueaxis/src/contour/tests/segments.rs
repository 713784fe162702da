//! Conversion of segments to spans.

use super::*;

#[test]
fn splines_of_every_degree_agree_with_de_boor_and_keep_their_bounds() {
    let mut random = Noise::new(11);
    for round in 0..120 {
        let spline =
            if round == 0 { Spline::butterfly() } else { Spline::random(&mut random, 1 + round % 5, round % 2 == 0) };
        let all = spans::<f64, f64>(&[spline.segment()]);
        let mut last = None::<V>;
        for span in &all {
            for i in 0..=10 {
                let t = f64::from(i) / 10.0;
                let truth = spline.at(span.u_of(t).min(spline.domain()[1] - 1e-13));
                assert!(norm(sub(point(span, t), truth)) < 1e-10, "degree {}: {t}", spline.degree);
                assert!(norm(span.local(t)) <= 8.0 + 1e-9);
                assert!((span.t_of(span.u_of(t)) - t).abs() < 1e-12);
            }
            if let Some(last) = last {
                assert!(norm(sub(last, point(span, 0.0))) < 1e-11, "gap");
            }
            last = Some(point(span, 1.0));
        }
    }
}

#[test]
fn the_butterfly_has_its_published_length() {
    let all = spans::<f64, f64>(&[Spline::butterfly().segment()]);
    let length: f64 = all.iter().map(Span::length).sum();
    assert!((length - 382.86).abs() < 0.005, "{length}");
}

#[test]
fn arcs_and_helices_are_exact_in_any_plane() {
    let mut random = Noise::new(3);
    for round in 0..300 {
        let n = [random.signed(), random.signed(), random.signed()];
        let n = n.map(|x| x / norm(n));
        let side = if n[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let cross = |a: V, b: V| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let e1 = cross(n, side);
        let e1 = e1.map(|x| x / norm(e1));
        let e2 = cross(n, e1);
        let radius = 10f64.powf(-1.5 + 4.0 * random.unit());
        let angle = 0.05 + 6.2 * random.unit();
        let turns = if round % 3 == 0 { 2 } else { 0 };
        let rise = if round % 2 == 0 { 0.0 } else { 20.0 * random.signed() };
        let center = [100.0 * random.signed(), 50.0, -30.0];
        let at = |angle: f64, rise: f64| -> V {
            core::array::from_fn(|k| center[k] + radius * (angle.cos() * e1[k] + angle.sin() * e2[k]) + rise * n[k])
        };
        let whole = angle + core::f64::consts::TAU * f64::from(turns);
        let segment = Segment::Arc {
            start: at(0.0, 0.0).into(),
            end: at(angle, rise).into(),
            center: center.into(),
            normal: n.map(|x| 3.0 * x).into(),
            turns,
        };
        let all = spans::<f64, f64>(&[segment]);
        let mut length = 0.0;
        for span in &all {
            for i in 0..=8 {
                let t = f64::from(i) / 8.0;
                let u = span.u_of(t);
                let truth = at(whole * u, rise * u);
                assert!(norm(sub(point(span, t), truth)) < 3e-10, "radius {radius}, rise {rise}");
                assert!((span.t_of(u) - t).abs() < 1e-12);
            }
            length += span.length();
        }
        assert!((length / (radius * whole).hypot(rise) - 1.0).abs() < 1e-9);
    }
}

/// Spans of an arc about the origin from r0 along X to r1 at an angle, and the largest distance of their points, `steps` per
/// span, from the curve whose radius grows with the angle.
fn spiral(r0: f64, r1: f64, angle: f64, steps: i32) -> (usize, f64) {
    let all = spans::<f64, f64>(&[Segment::Arc {
        start: DVec3::new(r0, 0.0, 0.0),
        end: DVec3::new(r1 * angle.cos(), r1 * angle.sin(), 0.0),
        center: [0.0; 3].into(),
        normal: Z.into(),
        turns: 0,
    }]);
    let off = |span: &Span<f64, f64>, t: f64| {
        let u = span.u_of(t);
        let r = r0 + u * (r1 - r0);
        norm(sub(point(span, t), [r * (u * angle).cos(), r * (u * angle).sin(), 0.0]))
    };
    let places = all.iter().flat_map(|span| (0..=steps).map(move |i| (span, f64::from(i) / f64::from(steps))));
    (all.len(), places.map(|(span, t)| off(span, t)).fold(0.0, f64::max))
}

#[test]
fn a_rounded_programs_radius_changes_linearly_with_the_angle() {
    let (_, worst) = spiral(10.0, 10.004, 2.0, 8);
    assert!(worst < 1e-8, "{worst}");
}

#[test]
fn a_spiral_is_within_its_bound_where_it_is_worst() {
    // One span with the largest turn, and the largest change of the radius: 0.8 of the growth per radian times k⁶.
    let (spans, worst) = spiral(10.0, 10.02, 0.5229, 64);
    assert!(spans == 1 && worst < 8e-6 * 0.02 && worst > 7e-6 * 0.02, "{worst}");
}

#[test]
fn segments_that_are_no_path_are_refused() {
    let refused = |segment: Segment<'_>| convert::<f64, f64>(&segment, 0, Z, |_| Ok(())).unwrap_err();
    let o = [0.0; 3];
    let e = refused(Segment::Line { start: o.into(), end: o.into() });
    assert_eq!((e.field, e.found), ("end", 0.0));
    assert_eq!(refused(Segment::Line { start: DVec3::new(f64::NAN, 0.0, 0.0), end: o.into() }).field, "start");
    let arc = |start, end, center, normal| Segment::Arc { start, end, center, normal, turns: 0 };
    assert_eq!(refused(arc([1.0, 0.0, 0.0].into(), [0.0, 1.1, 0.0].into(), o.into(), Z.into())).field, "end");
    assert_eq!(refused(arc(o.into(), [0.0, 1.0, 0.0].into(), o.into(), Z.into())).field, "center");
    // An end on the axis has no direction either, although it is within the tolerance of the radii.
    assert_eq!(refused(arc([1e-5, 0.0, 0.0].into(), [0.0, 0.0, 1.0].into(), o.into(), Z.into())).field, "center");
    assert_eq!(refused(arc([1.0, 0.0, 0.0].into(), [0.0, 1.0, 0.0].into(), o.into(), o.into())).field, "normal");
    let p = [o, [1.0, 0.0, 0.0], [2.0, 1.0, 0.0]].map(DVec3::from_array);
    let nurbs = |degree, knots, weights| Segment::Nurbs { degree, knots, points: &p, weights };
    assert_eq!(refused(nurbs(6, &[0.0; 10], &[])).field, "degree");
    assert_eq!(refused(nurbs(3, &[0.0; 7], &[])).field, "points");
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 1.0, 1.0], &[])).field, "knots");
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 2.0, 1.0, 1.0], &[])).index, Some(3));
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 0.5, 1.0, 1.0], &[1.0, 0.0, 1.0])).index, Some(1));
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, f64::INFINITY, 1.0, 1.0], &[])).field, "knots");
    assert_eq!(refused(nurbs(1, &[0.0, 0.0, 0.5, 1.0, 1.0], &[1.0])).field, "weights");
}

/// Every span is within 8 mm of its middle, even where a spline's speed is concentrated, and the number of spans is as
/// announced.
#[test]
fn no_span_reaches_farther_than_it_should() {
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let far = [[0.0; 3], [0.0, 1.0, 0.0], [2e6, 1.0, 0.0], [2e6, 0.0, 0.0]].map(DVec3::from_array);
    let near = [[0.0; 3], [1e3, 0.0, 0.0], [1e3, 1e3, 0.0], [0.0, 1e3, 5.0]].map(DVec3::from_array);
    let heavy = [1.0, 1e3, 1e-3, 1.0];
    let cases = [
        Segment::Nurbs { degree: 3, knots: &knots, points: &far, weights: &[] },
        Segment::Nurbs { degree: 3, knots: &knots, points: &near, weights: &heavy },
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(1e3, 7.0, 0.0) },
        Segment::Arc {
            start: DVec3::new(300.0, 0.0, 0.0),
            end: DVec3::new(300.0, 0.0, 9.0),
            center: [0.0; 3].into(),
            normal: Z.into(),
            turns: 3,
        },
        Segment::Turning { point: [1.0; 3].into() },
    ];
    for segment in &cases {
        let made: Vec<Span<f64, f64>> = spans(std::slice::from_ref(segment));
        assert_eq!(made.len() as u32, span_count(segment).unwrap(), "{segment:?}");
        for span in &made {
            // The middle of a line or a spline is that of its chord; the middle of an arc is on the arc.
            let ends = add(span.position(0.0), span.position(1.0)).map(|x| 0.5 * x);
            let middle = if matches!(segment, Segment::Arc { .. }) { span.position(0.5) } else { ends };
            for i in 0..=16 {
                let reach = norm(sub(span.position(f64::from(i) / 16.0), middle));
                assert!(reach <= 8.0 + 1e-6, "{segment:?}: {reach}");
            }
        }
    }
}

#[test]
fn weights_differ_by_no_more_than_a_million() {
    let points = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [6.0, -2.0, 1.0]].map(DVec3::from);
    let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let made = |weights: [f64; 3]| {
        let segment = Segment::Nurbs { degree: 2, knots: &knots, points: &points, weights: &weights };
        let mut shortest = f64::INFINITY;
        convert::<f64, f64>(&segment, 0, [0.0, 0.0, 1.0], |span| {
            shortest = shortest.min(span.length());
            Ok(())
        })
        .map(|()| shortest)
    };
    assert!(made([1e-9; 3]).unwrap() > 0.0);
    assert!(made([1.0, 1.0, 1e-6]).unwrap() > 0.0 && made([1e8, 1e3, 1e2]).unwrap() > 0.0);
    for (weights, which) in
        [([1.0, 1.0, 0.99e-6], 2), ([1.0, 1.01e6, 1.01e6], 0), ([1.0, 7e-155, 1.0], 1), ([1e-10; 3], 0)]
    {
        let error = made(weights).unwrap_err();
        assert_eq!((error.field, error.index, error.found), ("weights", Some(which), weights[which]));
    }
}

#[test]
fn a_domain_may_begin_anywhere_and_be_very_short() {
    let points = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [6.0, -2.0, 1.0]].map(DVec3::from);
    let made = |[first, last]: [f64; 2]| {
        let knots = [first, first, first, last, last, last];
        span_count(&Segment::Nurbs { degree: 2, knots: &knots, points: &points, weights: &[] })
    };
    for domain in [[0.0, 1e-100], [-1.0, 1.0], [-1.0, -0.5], [0.0, 1.0]] {
        assert_eq!(made(domain), made([0.0, 1.0]), "{domain:?}");
    }
    for domain in [[0.0, 0.99e-100], [0.0, 0.0], [1.0, 1.0]] {
        let error = made(domain).unwrap_err();
        assert_eq!((error.field, error.index, error.found), ("knots", Some(3), domain[1]));
    }
}

/// Arc length along a rational spline, whatever its weights, against the sum of short chords.
#[test]
fn the_arc_length_of_uneven_weights_is_that_of_the_curve() {
    let points = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [6.0, -2.0, 1.0], [9.0, 5.0, 0.0], [0.0; 3]].map(DVec3::from);
    let knots = [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0];
    for weight in [1e-6, 5e-4, 0.03, 40.0, 1e4] {
        let weights = [weight, 0.7, 1.0, 1.0, 1.0];
        let segment = Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights: &weights };
        convert::<f64, f64>(&segment, 0, Z, |span| {
            let (mut along, mut before) = (0.0, span.position(0.0));
            for i in 1..=1024 {
                let t = f64::from(i) / 1024.0;
                let here = span.position(t);
                along += norm(sub(here, before));
                before = here;
                let off = (span.arc_length(t) - along).abs();
                assert!(off <= 5e-3 * span.length() + 1e-9, "weight {weight}, t = {t}: {off} mm of {}", span.length());
            }
            Ok(())
        })
        .unwrap();
    }
}

#[test]
fn segments_without_end_are_refused_before_a_span_is_made() {
    let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let far = [[0.0; 3], [9e8, 0.0, 0.0], [9e8, 9e8, 0.0]].map(DVec3::from_array);
    let peak = [[0.0; 3], [9e8, 0.0, 0.0], [1.0, 0.0, 0.0]].map(DVec3::from_array);
    // These segments would need too many spans; they are refused by that number before any span is formed.
    for segment in [
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(1e8, 0.0, 0.0) },
        Segment::Arc {
            start: DVec3::new(1e6, 0.0, 0.0),
            end: DVec3::new(1e6, 0.0, 0.0),
            center: [0.0; 3].into(),
            normal: Z.into(),
            turns: 9999,
        },
        Segment::Nurbs { degree: 2, knots: &knots, points: &far, weights: &[] },
        Segment::Nurbs { degree: 2, knots: &knots, points: &peak, weights: &[] },
    ] {
        assert!(span_count(&segment).is_err(), "{segment:?}");
        let mut made = 0;
        let refused = convert::<f64, f64>(&segment, 0, Z, |_| {
            made += 1;
            Ok(())
        });
        assert!(refused.is_err() && made <= 1_000_000, "{segment:?}: {made}");
    }
}

#[test]
fn a_segment_and_its_parameter_are_a_place_on_the_path() {
    let [a, b, c] = [[0.0; 3], [10.0, 0.0, 0.0], [10.0, 10.0, 0.0]];
    // Segments 4, 5 and 7: 6 is missing. The window begins at span 100.
    let segments = [
        (4, Segment::Line { start: a.into(), end: b.into() }),
        (
            5,
            Segment::Arc {
                start: b.into(),
                end: c.into(),
                center: DVec3::new(10.0, 5.0, 0.0),
                normal: Z.into(),
                turns: 0,
            },
        ),
        (7, Segment::Line { start: c.into(), end: a.into() }),
    ];
    let mut all: Vec<Span<f64, f64>> = Vec::new();
    for (number, segment) in &segments {
        convert(segment, *number, Z, |span| {
            all.push(span);
            Ok(())
        })
        .unwrap();
    }
    let path = Path::new(&all, 100, false);
    let at = |segment, u| {
        let on = path.at(segment, u);
        path.span(on.reference.span).unwrap().position(on.reference.t)
    };
    for i in 0..=100 {
        let u = f64::from(i) / 100.0;
        let angle = core::f64::consts::PI * (u - 0.5);
        for (segment, truth) in [
            (4, [10.0 * u, 0.0, 0.0]),
            (5, [10.0 + 5.0 * angle.cos(), 5.0 + 5.0 * angle.sin(), 0.0]),
            (7, [10.0 - 10.0 * u, 10.0 - 10.0 * u, 0.0]),
        ] {
            assert!(norm(sub(at(segment, u), truth)) < 1e-9, "{segment} at {u}: {:?}", at(segment, u));
        }
    }
    // Beyond the ends of a segment: the nearer end.
    for (segment, [start, end]) in [(4, [a, b]), (5, [b, c]), (7, [c, a])] {
        assert!(norm(sub(at(segment, -0.5), start)) < 1e-9, "{segment}");
        assert!(norm(sub(at(segment, 1.5), end)) < 1e-9, "{segment}");
    }

    let search = ContourSearch::<f64>::new(1.0, Method::Guarded).unwrap();
    let empty = Path::new(&[], 0, false);
    for on in [path.at(3, 0.5), path.at(6, 0.5), path.at(8, 0.0), path.at(5, f64::NAN), empty.at(4, 0.5)] {
        let mut state = ContourState::default();
        let error = search.update(&mut state, &on.path, on.reference, [5.0, 0.1, 0.0]);
        assert!(!error.is_measured() && error.flags.has(Flags::REFERENCE), "{on:?}: {error:?}");
    }
    let on = path.at(4, 0.5);
    let mut state = ContourState::default();
    let mut error = ContourError::none();
    for _ in 0..15 {
        error = search.update(&mut state, &on.path, on.reference, [5.0, 0.1, 0.0]);
    }
    assert!(error.is_measured() && (error.normal - 0.1).abs() < 1e-9, "{error:?}");
}
