//! Segments appended to a path.

use crate::error::{Error, explained};
use crate::opaque;
use crate::part::{CURVES, TOOLPATH, need};
use crate::path::Path;
use crate::pointer::{slice, vector};
use crate::result::{ERROR_ARGUMENT, ResultCode};
use trueaxis::contour::Segment;
use trueaxis::glam::DVec3;

/// Appends a straight line, mm: u = 0 to 1, proportional to length.
///
/// `start`, `end`: X, Y, Z. Errors: `_MEMORY`, `_PATH` (shorter than 1e-9 mm, not finite; as for every segment: start
/// more than 0.02 mm from the end of the previous segment).
///
/// # Safety
/// Pointers are null or point to objects of their types, coordinates to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_line(
    path: *mut Path,
    start: *const f64,
    end: *const f64,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        // SAFETY: the caller's promise.
        let (start, end, spans) = unsafe { (vector(start)?, vector(end)?, opaque::content_mut(path)?) };
        spans.append(&Segment::Line { start: start.into(), end: end.into() })
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Appends a circular arc about `normal` (right-hand rule), or a helix if start and end differ along it, mm: u = 0 to
/// 1, proportional to the angle. A start and end at the same angle define a full circle.
///
/// `center`: any point on the axis. `normal`: of any length. `turns`: full turns in addition to the first arc. Errors:
/// `_MEMORY`, `_PATH` (also: radii that differ by more than 0.02 mm).
///
/// # Safety
/// Pointers are null or point to objects of their types, coordinates to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_arc(
    path: *mut Path,
    start: *const f64,
    end: *const f64,
    center: *const f64,
    normal: *const f64,
    turns: u32,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(CURVES)?;
        // SAFETY: the caller's promise.
        let (start, end, center, normal) = unsafe { (vector(start)?, vector(end)?, vector(center)?, vector(normal)?) };
        // SAFETY: the caller's promise.
        let spans = unsafe { opaque::content_mut(path) }?;
        spans.append(&Segment::Arc {
            start: start.into(),
            end: end.into(),
            center: center.into(),
            normal: normal.into(),
            turns,
        })
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Appends a spline (NURBS), mm: u from `knots[degree]` to `knots[point_count]`.
///
/// `degree`: 1 to 5. `knots`: `point_count + degree + 1` ascending numbers. `points`: X, Y, Z of each control point.
/// `weights`: `point_count` positive numbers, or `NULL` if all are 1. Errors: `_MEMORY`, `_PATH` (`error->index`: the
/// element).
///
/// # Safety
/// Pointers are null or point to objects of their types, lists to as many numbers as above.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_nurbs(
    path: *mut Path,
    degree: u32,
    knots: *const f64,
    points: *const f64,
    weights: *const f64,
    point_count: usize,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(CURVES)?;
        let degree = degree as usize;
        let knot_count = point_count.checked_add(degree).and_then(|sum| sum.checked_add(1)).ok_or(ERROR_ARGUMENT)?;
        // SAFETY: the caller's promise; points of three numbers lie one behind the other.
        let (knots, points) = unsafe { (slice(knots, knot_count)?, slice(points.cast::<DVec3>(), point_count)?) };
        // SAFETY: the caller's promise.
        let weights = if weights.is_null() { &[][..] } else { unsafe { slice(weights, point_count) }? };
        // SAFETY: the caller's promise.
        let spans = unsafe { opaque::content_mut(path) }?;
        spans.append(&Segment::Nurbs { degree, knots, points, weights })
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Appends a rotation of the tool about its stationary tip; u = 0 to 1. Only in a tool path; set the directions first
/// with `trueaxis_path_axes` or `trueaxis_path_directions`. Errors: `_MEMORY`, `_PATH`, `_ARGUMENT` (not the path of a
/// tool).
///
/// # Safety
/// Pointers are null or point to objects of their types, `point` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_turning(path: *mut Path, point: *const f64, error: *mut Error) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        // SAFETY: the caller's promise.
        let (point, spans) = unsafe { (vector(point)?, opaque::content_mut(path)?) };
        if !spans.is_of_tool() {
            return Err(ERROR_ARGUMENT.into());
        }
        spans.append(&Segment::Turning { point: point.into() })
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}
