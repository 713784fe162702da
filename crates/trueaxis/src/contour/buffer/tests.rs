use crate::contour::{PathBuffer, PathError, Segment, Span, convert, span_count};
use crate::{HostPath, Nanometres};
use glam::DVec3;

const FLAT: [f64; 3] = [0.0, 0.0, 1.0];
const KNOTS: [f64; 8] = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
const SPLINE: [DVec3; 4] =
    [DVec3::new(30.0, 10.0, 0.0), DVec3::new(30.0, 25.0, 0.0), DVec3::new(10.0, 25.0, 5.0), DVec3::new(0.0, 30.0, 5.0)];

fn line_arc_spline() -> HostPath<32> {
    let mut path = HostPath::new();
    path.line([0.0; 3], [20.0, 0.0, 0.0]).unwrap();
    path.arc([20.0, 0.0, 0.0], [30.0, 10.0, 0.0], [20.0, 10.0, 0.0], FLAT).unwrap();
    path.nurbs(3, &KNOTS, &SPLINE, &[]).unwrap();
    path
}

#[test]
fn segments_become_the_spans_that_conversion_makes() {
    let path = line_arc_spline();
    let segments = [
        Segment::Line { start: [0.0; 3].into(), end: DVec3::new(20.0, 0.0, 0.0) },
        Segment::Arc {
            start: DVec3::new(20.0, 0.0, 0.0),
            end: DVec3::new(30.0, 10.0, 0.0),
            center: DVec3::new(20.0, 10.0, 0.0),
            normal: FLAT.into(),
            turns: 0,
        },
        Segment::Nurbs { degree: 3, knots: &KNOTS, points: &SPLINE, weights: &[] },
    ];
    let mut spans = std::vec::Vec::<Span<f64, f64>>::new();
    for (number, segment) in (0..).zip(&segments) {
        convert(segment, number, FLAT, |span| {
            spans.push(span);
            Ok(())
        })
        .unwrap();
    }
    assert_eq!(&path.spans[..], &spans[..]);
    assert_eq!(path.builder.segments(), 3);
}

#[test]
fn a_place_is_found_by_segment_and_parameter() {
    let path = line_arc_spline();
    for (segment, u, wanted) in [
        (0, 0.25, [5.0, 0.0, 0.0]),
        (1, 1.0, [30.0, 10.0, 0.0]),
        (2, 0.0, SPLINE[0].to_array()),
        (2, 1.0, SPLINE[3].to_array()),
    ] {
        let on = path.at(segment, u);
        let found = on.path.span(on.reference.span).unwrap().position(on.reference.t);
        assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 1e-12), "{segment} {u}: {found:?}");
    }
    assert!(path.at(3, 0.0).reference.t.is_nan());
}

#[test]
fn a_gap_and_a_full_buffer_leave_the_path_as_it_was() {
    let mut path = line_arc_spline();
    let before = path.clone();
    let gap = path.line([0.0, 30.021, 5.0], [0.0, 40.0, 5.0]).unwrap_err();
    assert_eq!((gap.field, (gap.found * 1e6).round()), ("start", 21_000.0));
    // 32 spans have room for 26 more of 16 mm, not 63.
    let full = path.line(SPLINE[3], [0.0, 1030.0, 5.0]).unwrap_err();
    assert_eq!(full, PathError { field: "path", index: None, found: 32.0, needed: "room for more spans" });
    assert_eq!((&path.spans, path.builder.segments()), (&before.spans, 3));
    // The builder's end is still that of the spline.
    path.line([0.0, 30.019, 5.0], [0.0, 40.0, 5.0]).unwrap();
    assert_eq!(path.builder.segments(), 4);
}

#[test]
fn only_a_path_that_ends_where_it_begins_is_closed() {
    let mut path = line_arc_spline();
    assert!(path.close().is_err() && !path.closed);
    path.line(SPLINE[3], [0.0; 3]).unwrap();
    path.close().unwrap();
    assert!(path.closed);
    path.line([0.0; 3], [1.0, 0.0, 0.0]).unwrap();
    assert!(!path.closed, "a further segment opens it");
    path.clear();
    assert!(path.path().span(0).is_none());
    path.line([7.0; 3], [8.0; 3]).unwrap();
    assert_eq!(path.path().span(0).unwrap().segment(), 0);
}

#[test]
fn integers_and_single_precision_take_the_same_segments() {
    let mut path = PathBuffer::<f32, Nanometres, 8>::new();
    path.set_plane([0.0, 2.0, 0.0]);
    let arc = Segment::Arc {
        start: DVec3::new(5.0, 0.0, 0.0),
        end: DVec3::new(5.0, 0.0, 3.0),
        center: [0.0; 3].into(),
        normal: FLAT.into(),
        turns: 0,
    };
    assert!(span_count(&arc).unwrap() > 8);
    assert!(path.append(&arc).is_err());
    path.line([0.0; 3], [100.0, 0.0, 0.0]).unwrap();
    assert_eq!(path.spans.len(), 7);
    assert_eq!(path.spans[0].plane, [0.0, 1.0, 0.0]);
}
