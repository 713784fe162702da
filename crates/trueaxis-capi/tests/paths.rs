//! Programmed paths through the C interface.

use crate::machines::*;
use std::ptr::{null, null_mut};
use trueaxis_capi::*;

#[test]
fn points_are_found_by_segment_and_parameter() {
    let mut square = Programmed::new(32, 100);
    let corners = [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [40.0, 10.0, 0.0], [0.0, 10.0, 0.0]];
    for side in 0..4 {
        assert_eq!(square.line(corners[side], corners[(side + 1) % 4]), OK);
    }
    // A side of 40 mm is divided into three spans of at most 16 mm, one of 10 mm is a single span.
    assert_eq!(square.count(), (4, 8));
    for (segment, u, span, t) in [
        (0, 0.0, 100, 0.0),
        (0, 0.5, 101, 0.5),
        (0, 1.0, 102, 1.0),
        (0, -3.0, 100, 0.0),
        (0, 7.0, 102, 1.0),
        (1, 0.25, 103, 0.25),
        (2, 0.9, 106, 0.7),
        (3, 1.0, 107, 1.0),
    ] {
        let found = square.reference(segment, u).unwrap();
        assert_eq!(found.span, span, "segment {segment}, u {u}");
        assert!((f64::from(found.t as f32) - t).abs() < 1e-6, "segment {segment}, u {u}: {}", found.t);
    }
    assert_eq!(square.reference(4, 0.0).unwrap_err(), ERROR_ARGUMENT);
    assert_eq!(square.reference(0, f64::NAN).unwrap_err(), ERROR_ARGUMENT);

    // SAFETY: all pointers and sizes match their types.
    unsafe {
        assert_eq!(trueaxis_path_close(&mut *square.path), OK);
        assert_eq!(trueaxis_path_clear(&mut *square.path), OK);
        assert_eq!(square.count(), (0, 0));
        assert_eq!(trueaxis_path_close(&mut *square.path), ERROR_PATH);
    }
    assert_eq!(square.reference(0, 0.0).unwrap_err(), ERROR_ARGUMENT);
    assert_eq!(square.line(corners[0], corners[2]), OK);
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_path_close(&mut *square.path) }, ERROR_PATH, "its ends are apart");
}

#[test]
fn a_segment_that_does_not_fit_changes_nothing() {
    let mut path = Programmed::new(3, 0);
    assert_eq!(path.line([0.0; 3], [30.0, 0.0, 0.0]), OK);
    assert_eq!(path.count(), (1, 2));
    let mut error = error();
    let (from, to) = ([30.0, 0.0, 0.0], [60.0, 0.0, 0.0]);
    // SAFETY: all pointers and sizes match their types.
    let result = unsafe { trueaxis_path_line(&mut *path.path, from.as_ptr(), to.as_ptr(), &mut error) };
    assert_eq!((result, error.result), (ERROR_MEMORY, ERROR_MEMORY));
    assert_eq!(path.count(), (1, 2));
    assert_eq!(path.line(from, [40.0, 0.0, 0.0]), OK);
    assert_eq!(path.count(), (2, 3));
    assert_eq!(path.reference(1, 1.0).unwrap().span, 2);
}

#[test]
fn invalid_paths_are_refused() {
    let mut path = Programmed::new(32, 0);
    let mut error = error();
    let zero = [0.0; 3];
    let (up, end) = ([0.0, 0.0, 1.0], [0.0, 20.0, 0.0]);
    let start = [10.0, 0.0, 0.0];
    assert_eq!(path.line(zero, zero), ERROR_PATH);
    assert_eq!(path.line(zero, [f64::NAN, 0.0, 0.0]), ERROR_PATH);
    let mut memory = vec![0_u64; 8];
    // SAFETY: invalid arguments are null, misaligned, or no path.
    unsafe {
        let raw: *mut Path = &mut *path.path;
        let [zero, up, end, start] = [&zero, &up, &end, &start].map(|v| v.as_ptr());
        assert_eq!(trueaxis_path_arc(raw, start, end, zero, up, 0, &mut error), ERROR_PATH);
        assert_eq!(text(&error.field), "end");
        assert!((error.found - 10.0).abs() < 1e-9 && text(&error.text).contains("needed the same radius"));
        assert_eq!(trueaxis_path_arc(raw, start, start, zero, zero, 0, null_mut()), ERROR_PATH);
        assert_eq!(trueaxis_path_arc(raw, null(), start, zero, up, 0, null_mut()), ERROR_NULL);
        assert_eq!(trueaxis_path_line(null_mut(), start, end, null_mut()), ERROR_NULL);
        assert_eq!(trueaxis_path_line(raw, start, null(), null_mut()), ERROR_NULL);
        assert_eq!(trueaxis_path_line(memory.as_mut_ptr().cast(), start, end, null_mut()), ERROR_UNBUILT);
        assert_eq!(trueaxis_path_plane(raw, zero), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_plane(raw, [f64::NAN, 0.0, 1.0].as_ptr()), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_plane(raw, [0.0, 1.0, 0.0].as_ptr()), OK);

        // A clamped quadratic spline, then one with descending knots, and one with too many elements in every list.
        let points = [0.0, 0.0, 0.0, 5.0, 5.0, 0.0, 10.0, 0.0, 0.0];
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let weights = [1.0, 2.0, 1.0];
        let (knots_, points_, weights_) = (knots.as_ptr(), points.as_ptr(), weights.as_ptr());
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, points_, null(), 3, &mut error), OK);
        // The first spline ends 10 mm from the start of the second.
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, points_, weights_, 3, &mut error), ERROR_PATH);
        assert_eq!((text(&error.field).as_str(), error.found), ("start", 10.0));
        let onward = [10.0, 0.0, 0.0, 15.0, 5.0, 0.0, 20.0, 0.0, 0.0];
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, onward.as_ptr(), weights_, 3, &mut error), OK);
        let descending = [0.0, 0.0, 0.0, 1.0, 0.5, 1.0];
        assert_eq!(trueaxis_path_nurbs(raw, 2, descending.as_ptr(), points_, null(), 3, &mut error), ERROR_PATH);
        assert_eq!((text(&error.field).as_str(), error.index), ("knots", 4));
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, points_, null(), usize::MAX, &mut error), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, points_, null(), usize::MAX / 8, &mut error), ERROR_SIZE);
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, null(), null(), 3, &mut error), ERROR_NULL);
    }
    assert_eq!(path.count().0, 2);
    assert!(path.memory.iter().any(|word| *word != 0));
}

#[test]
fn memory_of_a_path_is_checked() {
    let (mut path, mut memory) = (zeroed::<Path>(), vec![0_u64; 64]);
    let (path, memory, size) = (&raw mut *path, memory.as_mut_ptr(), size_of::<Path>());
    // SAFETY: invalid arguments are null, misaligned or have a wrong size stated.
    unsafe {
        assert_eq!(trueaxis_path_start(null_mut(), size, memory.cast(), 512, 0), ERROR_NULL);
        assert_eq!(trueaxis_path_start(path, size - 8, memory.cast(), 512, 0), ERROR_SIZE);
        assert_eq!(trueaxis_path_start(path, size, null_mut(), 512, 0), ERROR_NULL);
        assert_eq!(trueaxis_path_start(path, size, memory.cast::<u8>().add(4).cast(), 500, 0), ERROR_ALIGNMENT);
        assert_eq!(trueaxis_path_start(path, size, path.cast(), size, 0), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_count(path, null_mut(), null_mut()), ERROR_UNBUILT);
        assert_eq!(trueaxis_path_start(path, size, memory.cast(), 0, 0), OK);
        assert_eq!(trueaxis_path_count(path, null_mut(), null_mut()), OK);
        let (start, end) = ([0.0; 3], [1.0; 3]);
        assert_eq!(trueaxis_path_line(path, start.as_ptr(), end.as_ptr(), null_mut()), ERROR_MEMORY);
    }
}

#[test]
fn a_reference_outside_the_path_is_flagged() {
    let built = mill_loop();
    let mut state = started(&built.servo);
    let mut path = Programmed::new(8, 0);
    assert_eq!(path.line([10.0, 20.0, -200.0], [50.0, 20.0, -200.0]), OK);
    let at = input([10.0, 20.0, -200.0, 0.0, 0.0, 0.0], [10.0, 20.0, -200.0, 0.0, 0.0, 0.0]);
    let mut out = output();
    let mut flags = |against: &mut Measure| {
        // SAFETY: all pointers and sizes match their types.
        assert_eq!(unsafe { trueaxis_step(&*built.servo, &mut *state, &at, against, null_mut(), &mut out) }, OK);
        assert_eq!(out.record.status & STATUS_CONTOUR == 0, out.record.tip.flags & CONTOUR_NOT_FOUND != 0);
        out.record.tip.flags
    };
    let mut good = Measure { path: &*path.path, ..measure(MEASURE_PATH) };
    // The search is cold in the first cycles; under Miri the loop ends before it is complete.
    for _ in 0..if cfg!(miri) { 2 } else { 60 } {
        flags(&mut good);
    }
    assert!(flags(&mut good) & CONTOUR_NOT_FOUND == 0 || cfg!(miri));
    assert_eq!(flags(&mut measure(MEASURE_NOTHING)) & CONTOUR_NOT_FOUND, CONTOUR_NOT_FOUND);
    for t in [Real::NAN, Real::INFINITY] {
        let flags = flags(&mut Measure { reference: Reference { span: 0, t }, ..good });
        assert_eq!(flags & CONTOUR_NOT_FOUND, CONTOUR_NOT_FOUND, "{t}");
    }
    // A parameter outside its span is clamped to the nearer end. A wrong span gives any result, but no harm.
    for t in [-0.1, 1.1] {
        let flags = flags(&mut Measure { reference: Reference { span: 0, t }, ..good });
        assert_eq!(flags & CONTOUR_REFERENCE, CONTOUR_REFERENCE, "{t}");
    }
    for span in [3, u32::MAX] {
        flags(&mut Measure { reference: Reference { span, t: 0.5 }, ..good });
    }
}
