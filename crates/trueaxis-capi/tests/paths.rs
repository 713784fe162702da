//! Programmed paths through the C interface.

#![allow(unsafe_code)]

mod machines;

use machines::*;
use std::ptr::{null, null_mut};
use trueaxis_capi::*;

struct Programmed {
    path: Box<Path>,
    memory: Vec<u64>,
}

impl Programmed {
    fn new(spans: usize, first: u32) -> Self {
        let (mut path, mut memory) = (zeroed::<Path>(), vec![0_u64; spans * SPAN_BYTES / 8]);
        let bytes = memory.len() * 8;
        // SAFETY: everything is as the types say.
        let status =
            unsafe { trueaxis_path_start(&mut *path, size_of::<Path>(), memory.as_mut_ptr().cast(), bytes, first) };
        assert_eq!(status, OK);
        Programmed { path, memory }
    }

    fn line(&mut self, start: [f64; 3], end: [f64; 3]) -> Status {
        // SAFETY: everything is as the types say.
        unsafe { trueaxis_path_line(&mut *self.path, start.as_ptr(), end.as_ptr(), null_mut()) }
    }

    fn count(&self) -> (u32, u32) {
        let (mut segments, mut spans) = (0, 0);
        // SAFETY: everything is as the types say.
        assert_eq!(unsafe { trueaxis_path_count(&*self.path, &mut segments, &mut spans) }, OK);
        (segments, spans)
    }

    fn reference(&self, segment: u32, u: f64) -> Result<Reference, Status> {
        let mut reference = Reference { span: 99, t: 9.0 };
        // SAFETY: everything is as the types say.
        match unsafe { trueaxis_path_reference(&*self.path, segment, u, &mut reference) } {
            OK => Ok(reference),
            status => {
                assert_eq!((reference.span, reference.t), (99, 9.0));
                Err(status)
            }
        }
    }
}

#[test]
fn places_are_found_by_segment_and_parameter() {
    let mut square = Programmed::new(32, 100);
    let corners = [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [40.0, 10.0, 0.0], [0.0, 10.0, 0.0]];
    for side in 0..4 {
        assert_eq!(square.line(corners[side], corners[(side + 1) % 4]), OK);
    }
    // 40 mm make three pieces of at most 16 mm, 10 mm one.
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

    // SAFETY: everything is as the types say.
    unsafe {
        assert_eq!(trueaxis_path_close(&mut *square.path), OK);
        assert_eq!(trueaxis_path_clear(&mut *square.path), OK);
        assert_eq!(square.count(), (0, 0));
        assert_eq!(trueaxis_path_close(&mut *square.path), ERROR_PATH);
    }
    assert_eq!(square.reference(0, 0.0).unwrap_err(), ERROR_ARGUMENT);
    assert_eq!(square.line(corners[0], corners[2]), OK);
    // SAFETY: everything is as the types say.
    assert_eq!(unsafe { trueaxis_path_close(&mut *square.path) }, ERROR_PATH, "its ends are apart");
}

#[test]
fn a_segment_that_does_not_fit_changes_nothing() {
    let mut path = Programmed::new(3, 0);
    assert_eq!(path.line([0.0; 3], [30.0, 0.0, 0.0]), OK);
    assert_eq!(path.count(), (1, 2));
    let mut error = error();
    let (from, to) = ([30.0, 0.0, 0.0], [60.0, 0.0, 0.0]);
    // SAFETY: everything is as the types say.
    let status = unsafe { trueaxis_path_line(&mut *path.path, from.as_ptr(), to.as_ptr(), &mut error) };
    assert_eq!((status, error.status), (ERROR_MEMORY, ERROR_MEMORY));
    assert_eq!(path.count(), (1, 2));
    assert_eq!(path.line(from, [40.0, 0.0, 0.0]), OK);
    assert_eq!(path.count(), (2, 3));
    assert_eq!(path.reference(1, 1.0).unwrap().span, 2);
}

#[test]
fn what_is_no_path_is_refused() {
    let mut path = Programmed::new(32, 0);
    let mut error = error();
    let zero = [0.0; 3];
    let (up, end) = ([0.0, 0.0, 1.0], [0.0, 20.0, 0.0]);
    let start = [10.0, 0.0, 0.0];
    assert_eq!(path.line(zero, zero), ERROR_PATH);
    assert_eq!(path.line(zero, [f64::NAN, 0.0, 0.0]), ERROR_PATH);
    let mut memory = vec![0_u64; 8];
    // SAFETY: what is wrong is null, misaligned, or no path.
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

        // A clamped quadratic spline, then one whose knots descend, and one with too many of everything.
        let points = [0.0, 0.0, 0.0, 5.0, 5.0, 0.0, 10.0, 0.0, 0.0];
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let weights = [1.0, 2.0, 1.0];
        let (knots_, points_, weights_) = (knots.as_ptr(), points.as_ptr(), weights.as_ptr());
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, points_, null(), 3, &mut error), OK);
        // It ends 10 mm from where the same would begin again.
        assert_eq!(trueaxis_path_nurbs(raw, 2, knots_, points_, weights_, 3, &mut error), ERROR_PATH);
        assert_eq!((text(&error.field).as_str(), error.found), ("start", 100.0));
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
    // SAFETY: what is wrong is null, misaligned or said to be of another size.
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
fn a_place_that_is_none_measures_nothing() {
    let built = built(mill());
    let mut state = started(&built.servo);
    let mut path = Programmed::new(8, 0);
    assert_eq!(path.line([10.0, 20.0, -200.0], [50.0, 20.0, -200.0]), OK);
    let at = input([10.0, 20.0, -200.0, 0.0, 0.0, 0.0], [10.0, 20.0, -200.0, 0.0, 0.0, 0.0]);
    let mut out = output();
    let mut measured = |path: *const Path, reference: *const Reference| {
        // SAFETY: everything is as the types say, or null.
        assert_eq!(unsafe { trueaxis_step(&*built.servo, &mut *state, &at, path, reference, &mut out) }, OK);
        out.record.status & STATUS_CONTOUR != 0
    };
    let good = Reference { span: 0, t: 0.0 };
    // The search is cold in the first cycles; Miri does not wait for it.
    for _ in 0..if cfg!(miri) { 2 } else { 60 } {
        measured(&*path.path, &good);
    }
    assert!(measured(&*path.path, &good) || cfg!(miri));
    assert!(!measured(null(), &good));
    assert!(!measured(&*path.path, null()));
    for t in [Real::NAN, -0.1, 1.1, Real::INFINITY] {
        assert!(!measured(&*path.path, &Reference { span: 0, t }));
    }
    for span in [3, u32::MAX] {
        measured(&*path.path, &Reference { span, t: 0.5 });
    }
}
