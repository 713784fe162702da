//! The programmed path, in memory that the caller lends. Its segments are appended in [`crate::segments`].

use crate::contour::Reference;
use crate::opaque;
use crate::part::{TOOLPATH, need};
use crate::pointer::{apart, check, memory, vector};
use crate::result::{self, ERROR_ARGUMENT, ResultCode};
use crate::spans::{Direction, Spans};
use core::ffi::c_void;

/// Words of a `trueaxis_path_t`.
pub const PATH_WORDS: usize = 28;

/// A programmed path: lines, arcs and splines, stored as spans in lent memory.
#[repr(C)]
#[derive(Debug)]
pub struct Path {
    words: [u64; PATH_WORDS],
}

/// Starts an empty path.
///
/// `memory`: 8-byte aligned, `TRUEAXIS_SPAN_BYTES` per span; the path uses it as long as it exists. `first_span`:
/// number of the first span, 0 for a path that is complete. A host with a long program slides a window over it: each
/// window is another path that continues the numbering, so that the search finds its last foot again.
///
/// Segments are numbered from 0. Functions that change a path are not real-time (up to 8 KiB of stack) and must not run
/// while a step uses it: fill another path and pass that. Errors: `_ARGUMENT` (memory overlaps path).
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_start(
    path: *mut Path,
    path_size: usize,
    memory: *mut c_void,
    memory_size: usize,
    first_span: u32,
) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { start(path, path_size, memory, memory_size, first_span, false) })
}

/// Starts an empty path of a tool in workpiece coordinates. Like `trueaxis_path_start`, but each span also stores
/// directions and takes `TRUEAXIS_TOOL_SPAN_BYTES`.
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_start_tool(
    path: *mut Path,
    path_size: usize,
    memory: *mut c_void,
    memory_size: usize,
    first_span: u32,
) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        // SAFETY: the caller's promise.
        unsafe { start(path, path_size, memory, memory_size, first_span, true) }
    };
    result::of(work())
}

/// # Safety
/// As for [`trueaxis_path_start`].
unsafe fn start(
    path: *mut Path,
    path_size: usize,
    memory: *mut c_void,
    memory_size: usize,
    first_span: u32,
    of_tool: bool,
) -> Result<(), ResultCode> {
    let place = opaque::place(path, path_size)?;
    let start = self::memory(memory, memory_size)?;
    if !apart((start.addr(), memory_size), (path.addr(), path_size)) {
        return Err(ERROR_ARGUMENT);
    }
    // SAFETY: storage of the size that the caller vouched for.
    unsafe { opaque::fill(place, Spans::new(start, memory_size, first_span, of_tool)) };
    Ok(())
}

/// Sets the normal of the machining plane for the segments that follow, three numbers; initially 0, 0, 1 (G17). The
/// signs of the contour error's components depend on it. Errors: `_ARGUMENT` (not finite, shorter than 1e-6).
///
/// # Safety
/// Pointers are null or point to objects of their types, `normal` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_plane(path: *mut Path, normal: *const f64) -> ResultCode {
    let work = || {
        // SAFETY: the caller's promise.
        let (normal, spans) = unsafe { (vector(normal)?, opaque::content_mut(path)?) };
        let [x, y, z] = normal;
        if !(normal.iter().all(|x| x.abs() <= 1e9) && x * x + y * y + z * z >= 1e-12) {
            return Err(ERROR_ARGUMENT);
        }
        spans.set_plane(normal);
        Ok(())
    };
    result::of(work())
}

/// Sets the positions of A, B, C (three numbers each, degrees) at start and end of the next segment of a tool path,
/// linear in its parameter; the segments after it keep the end position. Initially all are zero. Errors: `_ARGUMENT`
/// (not finite; not the path of a tool).
///
/// # Safety
/// Pointers are null or point to objects of their types, positions to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_axes(path: *mut Path, start: *const f64, end: *const f64) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        // SAFETY: the caller's promise.
        let (start, end, spans) = unsafe { (vector(start)?, vector(end)?, opaque::content_mut(path)?) };
        spans.set_direction(Direction::Axes(start, end))
    };
    result::of(work())
}

/// Sets the directions of the tool at start and end of the next segment, in workpiece coordinates (vectors of any
/// length). The tool turns along the great circle from `start` to `end`; the segments after it keep the end direction.
/// Errors: `_ARGUMENT` (not finite, zero or opposite directions; not the path of a tool).
///
/// # Safety
/// Pointers are null or point to objects of their types, directions to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_directions(path: *mut Path, start: *const f64, end: *const f64) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        // SAFETY: the caller's promise.
        let (start, end, spans) = unsafe { (vector(start)?, vector(end)?, opaque::content_mut(path)?) };
        spans.set_direction(Direction::Vectors(start, end))
    };
    result::of(work())
}

/// Closes the path, so that its first span follows the last one until another segment is appended. Errors: `_PATH`
/// (ends more than 0.02 mm apart, or no segment).
///
/// # Safety
/// `path` is null or points to an object of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_close(path: *mut Path) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { opaque::content_mut(path) }.and_then(Spans::close))
}

/// Removes all segments. Memory, plane, directions and the number of the first span are unchanged.
///
/// # Safety
/// `path` is null or points to an object of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_clear(path: *mut Path) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { opaque::content_mut(path) }.map(Spans::clear))
}

/// Reads the number of segments and of spans; either pointer may be `NULL`. Real-time safe.
///
/// # Safety
/// Pointers are null or point to objects of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_count(path: *const Path, segments: *mut u32, spans: *mut u32) -> ResultCode {
    let work = || {
        // SAFETY: the caller's promise.
        let content = unsafe { opaque::content(path) }?;
        let found = [(segments, content.segments()), (spans, content.spans().len() as u32)];
        for (to, _) in found {
            if !to.is_null() {
                check(to)?;
            }
        }
        for (to, count) in found {
            if !to.is_null() {
                // SAFETY: checked; writable by the caller's promise.
                unsafe { to.write(count) };
            }
        }
        Ok(())
    };
    result::of(work())
}

/// Computes the reference for parameter `u` of a segment (numbered from 0); if `u` is beyond the segment, its end.
/// Real-time safe. Errors: `_ARGUMENT` (no such segment, `u` not finite).
///
/// # Safety
/// Pointers are null or point to objects of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_reference(
    path: *const Path,
    segment: u32,
    u: f64,
    reference: *mut Reference,
) -> ResultCode {
    let work = || {
        check(reference)?;
        // SAFETY: the caller's promise.
        let spans = unsafe { opaque::content(path) }?;
        if segment >= spans.segments() || !u.is_finite() {
            return Err(ERROR_ARGUMENT);
        }
        let found = spans.path().at(segment, u).reference;
        // SAFETY: checked; writable by the caller's promise.
        unsafe { reference.write(Reference { span: found.span, t: found.t }) };
        Ok(())
    };
    result::of(work())
}
