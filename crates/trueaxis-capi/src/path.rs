//! The programmed path, in memory that the caller lends.

use crate::Real;
use crate::cycle::Reference;
use crate::error::{Error, Refusal, explained};
use crate::opaque::{self, Storage};
use crate::plugin::{CorePosition, PathSpan};
use crate::pointer::{apart, check, memory, slice, vector};
use crate::status::{self, ERROR_ARGUMENT, Status};
use core::ffi::c_void;
use trueaxis::contour::{self, PathError, Segment, convert};
use trueaxis::glam::DVec3;

/// Words of a `trueaxis_path_t`.
pub const PATH_WORDS: usize = 12;

/// Bytes that a piece of a path takes in the memory lent for it. A line takes a piece every 16 mm, an arc one every 30°
/// or less, a spline some for every span of its knots.
#[cfg(not(feature = "single"))]
pub const SPAN_BYTES: usize = 296;
/// Bytes that a piece of a path takes in the memory lent for it. A line takes a piece every 16 mm, an arc one every 30°
/// or less, a spline some for every span of its knots.
#[cfg(feature = "single")]
pub const SPAN_BYTES: usize = 168;
const _: () = assert!(size_of::<PathSpan>() <= SPAN_BYTES && align_of::<PathSpan>() <= align_of::<u64>());

/// A programmed path: lines, arcs and splines, converted into pieces in memory that the caller lends.
#[repr(C)]
#[derive(Debug)]
pub struct Path {
    words: [u64; PATH_WORDS],
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for Path {
    type Content = Pieces;
    const MAGIC: u32 = 0x5452_0003;
}

/// What a path is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pieces {
    spans: *mut PathSpan,
    capacity: usize,
    count: usize,
    first: u32,
    segments: u32,
    plane: [f64; 3],
    closed: bool,
}

/// Squared distance of two points, mm².
fn squared_distance(a: [CorePosition; 3], b: [CorePosition; 3]) -> f64 {
    a.into_iter().zip(b).fold(0.0, |sum, (a, b)| {
        let difference: f64 = trueaxis::Position::since(a, b);
        sum + difference * difference
    })
}

impl Pieces {
    #[inline(always)]
    fn spans(&self) -> &[PathSpan] {
        // SAFETY: `count` pieces were written there by `append`, and the caller of `trueaxis_path_start` lent the memory.
        unsafe { core::slice::from_raw_parts(self.spans, self.count) }
    }

    /// Converts a segment behind the last piece; the path is as before if that is refused.
    fn append(&mut self, segment: &Segment<'_>) -> Result<(), Refusal> {
        let (start, mut count, mut full) = (self.spans, self.count, false);
        let capacity = self.capacity;
        let mut end = self.spans().last().map(|span| span.position(1.0));
        let converted = convert(segment, self.segments, self.plane, |span: PathSpan| {
            let gap = end.take().map_or(0.0, |end| squared_distance(span.position(0.0), end));
            if gap > JOINED_WITHIN_MM * JOINED_WITHIN_MM {
                let needed = "at most 4e-4 mm² between it and the end before";
                return Err(PathError { field: "start", index: None, found: gap, needed });
            }
            if count == capacity {
                full = true;
                return Err(PathError { field: "memory", index: None, found: count as f64, needed: "more pieces" });
            }
            // SAFETY: within the memory lent, which is aligned for pieces.
            unsafe { start.add(count).write(span) };
            count += 1;
            Ok(())
        });
        match converted {
            Err(_) if full => Err(Refusal::Memory(capacity * size_of::<PathSpan>(), (capacity + 1) * SPAN_BYTES)),
            Err(error) => Err(Refusal::Path(error)),
            Ok(()) => {
                self.count = count;
                self.segments = self.segments.wrapping_add(1);
                self.closed = false;
                Ok(())
            }
        }
    }
}

/// Starts an empty path in `memory`: 8-byte aligned, `TRUEAXIS_SPAN_BYTES` for every piece, the caller's as long as the
/// path is used.
///
/// `path`, `path_size`: the caller's, `sizeof(trueaxis_path_t)`. `first_span`: sequence number of the first piece, 0 for a
/// path by itself. A host with a long program slides a window over it: each window is a path of its own whose
/// `first_span` goes on counting, so that the search finds its last foot again.
///
/// Segments are numbered from 0 in the order in which they are appended. All functions that change a path are not
/// real-time safe (those that append take up to 8 KiB of stack), and must not run while a step uses it: fill another one
/// and pass that.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_ARGUMENT` (memory overlaps path).
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
) -> Status {
    let work = || {
        let place = opaque::place(path, path_size)?;
        let start = self::memory(memory, memory_size)?;
        if !apart((start.addr(), memory_size), (path.addr(), path_size)) {
            return Err(ERROR_ARGUMENT);
        }
        let pieces = Pieces {
            spans: start.cast(),
            capacity: memory_size / size_of::<PathSpan>(),
            count: 0,
            first: first_span,
            segments: 0,
            plane: [0.0, 0.0, 1.0],
            closed: false,
        };
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, pieces) };
        Ok(())
    };
    status::of(work())
}

/// Normal of the machining plane for the segments appended from now on (G17: 0, 0, 1, as at the start); signs of the
/// contour error's components refer to it.
///
/// `normal`: three numbers, of any length above 1e-6. `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_ARGUMENT`.
///
/// # Safety
/// Pointers are null or point to what their types say, `normal` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_plane(path: *mut Path, normal: *const f64) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let (normal, pieces) = unsafe { (vector(normal)?, opaque::content_mut(path)?) };
        let [x, y, z] = normal;
        if !(normal.iter().all(|x| x.abs() <= 1e9) && x * x + y * y + z * z >= 1e-12) {
            return Err(ERROR_ARGUMENT);
        }
        pieces.plane = normal;
        Ok(())
    };
    status::of(work())
}

/// Appends a straight line, mm: u = 0..1 proportional to length.
///
/// `start`, `end`: three numbers each, X, Y, Z; every segment begins where the one before ends. `error`: may be `NULL`.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (shorter than 1e-9 mm, not finite, or beginning
/// more than 0.02 mm from the end of the segment before: so for every segment), `_MEMORY`.
///
/// # Safety
/// Pointers are null or point to what their types say, coordinates to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_line(
    path: *mut Path,
    start: *const f64,
    end: *const f64,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let (start, end, pieces) = unsafe { (vector(start)?, vector(end)?, opaque::content_mut(path)?) };
        pieces.append(&Segment::Line { start: start.into(), end: end.into() })
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Appends a circular arc about `normal` (right hand), a helix where start and end differ along it, mm: u = 0..1
/// proportional to the angle. Start and end at the same angle make a full circle.
///
/// `start`, `end`, `center`, `normal`: three numbers each; `center` any point of the axis, `normal` of any length.
/// `turns`: full turns beyond the first arc. `error`: may be `NULL`.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (radii that differ by more than 0.02 mm, …),
/// `_MEMORY`.
///
/// # Safety
/// Pointers are null or point to what their types say, coordinates to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_arc(
    path: *mut Path,
    start: *const f64,
    end: *const f64,
    center: *const f64,
    normal: *const f64,
    turns: u32,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let (start, end, center, normal) = unsafe { (vector(start)?, vector(end)?, vector(center)?, vector(normal)?) };
        // SAFETY: the caller's promise.
        let pieces = unsafe { opaque::content_mut(path) }?;
        pieces.append(&Segment::Arc {
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

/// Appends a spline (NURBS), mm: u over `knots[degree]` to `knots[point_count]`.
///
/// `degree`: 1 to 5. `knots`: `point_count + degree + 1` ascending numbers. `points`: `3 * point_count` numbers, X, Y, Z of
/// one control point after the other. `weights`: `point_count` positive numbers, or `NULL` for weights of one. `error`:
/// may be `NULL`.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (`error->index`: which element), `_MEMORY`.
///
/// # Safety
/// Pointers are null or point to what their types say, lists to as many numbers as above.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_nurbs(
    path: *mut Path,
    degree: u32,
    knots: *const f64,
    points: *const f64,
    weights: *const f64,
    point_count: usize,
    error: *mut Error,
) -> Status {
    let work = || {
        let degree = degree as usize;
        let knot_count = point_count.checked_add(degree).and_then(|sum| sum.checked_add(1)).ok_or(ERROR_ARGUMENT)?;
        // SAFETY: the caller's promise; points of three numbers lie one behind the other.
        let (knots, points) = unsafe { (slice(knots, knot_count)?, slice(points.cast::<DVec3>(), point_count)?) };
        // SAFETY: the caller's promise.
        let weights = if weights.is_null() { &[][..] } else { unsafe { slice(weights, point_count) }? };
        // SAFETY: the caller's promise.
        let pieces = unsafe { opaque::content_mut(path) }?;
        pieces.append(&Segment::Nurbs { degree, knots, points, weights })
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// The path is closed: behind the last piece the first one follows. Appending a segment opens it again.
///
/// `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (end and start are more than 0.02 mm apart, or the path is
/// empty).
///
/// # Safety
/// `path` is null or points to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_close(path: *mut Path) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let pieces = unsafe { opaque::content_mut(path) }?;
        let ([start, ..], [.., end]) = (pieces.spans(), pieces.spans()) else {
            return Err(status::ERROR_PATH);
        };
        if squared_distance(start.position(0.0), end.position(1.0)) > JOINED_WITHIN_MM * JOINED_WITHIN_MM {
            return Err(status::ERROR_PATH);
        }
        pieces.closed = true;
        Ok(())
    };
    status::of(work())
}

/// As far as the end points of an arc may be from its circle.
const JOINED_WITHIN_MM: f64 = 0.02;

/// Takes all segments out; memory, plane and the number of the first piece stay.
///
/// `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`.
///
/// # Safety
/// `path` is null or points to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_clear(path: *mut Path) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let pieces = unsafe { opaque::content_mut(path) }?;
        *pieces = Pieces { count: 0, segments: 0, closed: false, ..*pieces };
        Ok(())
    };
    status::of(work())
}

/// How many segments the path has, and how many pieces they were converted into. Either may be `NULL`.
///
/// Real-time safe. `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`.
///
/// # Safety
/// Pointers are null or point to what their types say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_count(path: *const Path, segments: *mut u32, spans: *mut u32) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let pieces = unsafe { opaque::content(path) }?;
        let found = [(segments, pieces.segments), (spans, pieces.count as u32)];
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
    status::of(work())
}

/// The place on the path at which segment `segment` (from 0) has parameter `u`: what `trueaxis_step` wants as
/// `reference`. Parameters beyond the segment's are held at its ends.
///
/// Real-time safe: a search by halving over the pieces.
///
/// `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_ARGUMENT` (no such segment, `u` not finite).
///
/// # Safety
/// Pointers are null or point to what their types say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_path_reference(
    path: *const Path,
    segment: u32,
    u: f64,
    reference: *mut Reference,
) -> Status {
    let work = || {
        check(reference)?;
        // SAFETY: the caller's promise.
        let pieces = unsafe { opaque::content(path) }?;
        let spans = pieces.spans();
        if segment >= pieces.segments || !u.is_finite() {
            return Err(ERROR_ARGUMENT);
        }
        // The first piece that ends behind u, or the segment's last one.
        let behind = spans.partition_point(|span| {
            let [_, end] = span.u_range();
            span.segment() < segment || (span.segment() == segment && end < u)
        });
        let last = spans.partition_point(|span| span.segment() <= segment).saturating_sub(1);
        let place = behind.min(last);
        let span = spans.get(place).ok_or(ERROR_ARGUMENT)?;
        // SAFETY: checked; writable by the caller's promise.
        unsafe { reference.write(Reference { span: pieces.first.wrapping_add(place as u32), t: span.t_of(u) }) };
        Ok(())
    };
    status::of(work())
}

/// Where a cycle's command lies.
pub(crate) struct Place<'a> {
    pub(crate) path: contour::Path<'a, Real, CorePosition>,
    pub(crate) reference: contour::Reference<Real>,
}

/// Path and reference of a cycle; without both of them nothing is measured.
///
/// # Safety
/// `path` is null, misaligned, or points to a path whose memory nobody writes while the view lives; `reference` is null,
/// misaligned, or points to a readable reference.
#[inline(always)]
pub(crate) unsafe fn place<'a>(path: *const Path, reference: *const Reference) -> Result<Place<'a>, Status> {
    let nowhere = Place { path: contour::Path::new(&[], 0, false), reference: contour::Reference::default() };
    if path.is_null() {
        return Ok(nowhere);
    }
    // SAFETY: the caller's promise.
    let pieces: &'a Pieces = unsafe { opaque::content(path) }?;
    if reference.is_null() {
        return Ok(nowhere);
    }
    check(reference)?;
    // SAFETY: not null, aligned, readable by the caller's promise; any bits are a value.
    let Reference { span, t } = unsafe { reference.read() };
    // A place that is no place: measured nowhere rather than somewhere.
    if !(0.0..=1.0).contains(&t) {
        return Ok(nowhere);
    }
    let path = contour::Path::new(pieces.spans(), pieces.first, pieces.closed);
    Ok(Place { path, reference: contour::Reference { span, t } })
}
