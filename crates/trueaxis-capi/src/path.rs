//! The programmed path, in memory that the caller lends. Its segments are appended in [`crate::segments`].

use crate::contour::Reference;
use crate::opaque::{self, Storage};
use crate::part::{TOOLPATH, need};
use crate::pointer::{apart, check, memory, vector};
use crate::result::{self, ERROR_ARGUMENT, ResultCode};
use crate::spans::{Direction, Spans};
use core::ffi::c_void;

/// Words of a `trueaxis_path_t`.
pub const PATH_WORDS: usize = 28;

/// A programmed path: lines, arcs and splines as spans in lent memory.
#[repr(C)]
#[derive(Debug)]
pub struct Path {
    words: [u64; PATH_WORDS],
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for Path {
    type Content = Spans;
    const MAGIC: u32 = 0x5452_0003;
}

/// Starts an empty path in `memory`: 8-byte aligned, `TRUEAXIS_SPAN_BYTES` per span, in use as long as the path is.
///
/// `first_span`: number of the first span, 0 for a path by itself. A host with a long program slides a window over it:
/// each window is another path whose numbers go on, so that the search finds its last foot again.
///
/// Segments are numbered from 0. Functions that change a path are not real-time (up to 8 KiB of stack) and must not run
/// while a step uses it: fill another one and pass that. `_ARGUMENT` (memory overlaps path).
///
/// # Safety
/// Pointers are null or point to what their types and sizes say.
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

/// The same for a tool in workpiece coordinates: `TRUEAXIS_TOOL_SPAN_BYTES` per span, each with directions.
///
/// # Safety
/// Pointers are null or point to what their types and sizes say.
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
/// As above.
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

/// Normal of the machining plane for the segments that follow, three numbers; 0, 0, 1 (G17) at the start. It gives the
/// contour error's components their signs. `_ARGUMENT` (not finite, shorter than 1e-6).
///
/// # Safety
/// Pointers are null or point to what their types say, `normal` to three numbers.
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

/// Positions of A, B, C (three numbers each, degrees) at start and end of the next segment of a tool path, linear in its
/// parameter; segments after it keep the end. All zero at the start. `_ARGUMENT` (not finite; no path of a tool).
///
/// # Safety
/// Pointers are null or point to what their types say, positions to three numbers.
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

/// The same by directions of the tool in workpiece coordinates (of any length): the great circle from `start` to `end`.
/// `_ARGUMENT` (also: opposite directions).
///
/// # Safety
/// Pointers are null or point to what their types say, directions to three numbers.
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

/// Closes the path: the first span follows the last one, until a segment is appended. `_PATH` (ends more than 0.02 mm
/// apart, or no segment).
///
/// # Safety
/// `path` is null or points to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_close(path: *mut Path) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { opaque::content_mut(path) }.and_then(Spans::close))
}

/// Removes all segments; memory, plane, directions and the first number stay.
///
/// # Safety
/// `path` is null or points to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_clear(path: *mut Path) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { opaque::content_mut(path) }.map(Spans::clear))
}

/// Numbers of segments and of spans; either may be `NULL`. Real-time safe.
///
/// # Safety
/// Pointers are null or point to what their types say.
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

/// The point of a path at parameter `u` of a segment (from 0); beyond the segment, its end. Real-time safe. `_ARGUMENT` (no
/// such segment, `u` not finite).
///
/// # Safety
/// Pointers are null or point to what their types say.
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
