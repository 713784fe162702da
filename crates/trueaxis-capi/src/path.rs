//! The programmed path, in memory that the caller lends.

use crate::Real;
use crate::cycle::Reference;
use crate::opaque::{self, Storage};
use crate::plugin::{CorePosition, PathSpan};
use crate::pointer::check;
use crate::status::Status;
use trueaxis::contour;

/// Words of a `trueaxis_path_t`.
pub const PATH_WORDS: usize = 8;

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
    spans: *const PathSpan,
    count: usize,
    first: u32,
    closed: bool,
}

/// The path as the step follows it; none of it for a null pointer.
///
/// # Safety
/// `path` is null, misaligned, or points to a path whose memory nobody writes while the view lives.
#[inline(always)]
pub(crate) unsafe fn view<'a>(path: *const Path) -> Result<contour::Path<'a, Real, CorePosition>, Status> {
    if path.is_null() {
        return Ok(contour::Path::new(&[], 0, false));
    }
    // SAFETY: the caller's promise.
    let pieces = unsafe { opaque::content(path) }?;
    // SAFETY: `count` pieces were written there (`Pieces` is made by this module only), and the caller promised that they
    // stay.
    let spans = unsafe { core::slice::from_raw_parts(pieces.spans, pieces.count) };
    Ok(contour::Path::new(spans, pieces.first, pieces.closed))
}

/// Where a cycle's command lies.
pub(crate) struct Place<'a> {
    pub(crate) path: contour::Path<'a, Real, CorePosition>,
    pub(crate) reference: contour::Reference<Real>,
}

/// Path and reference of a cycle; without both of them nothing is measured.
///
/// # Safety
/// As for [`view`]; `reference` is null, misaligned, or points to a readable reference.
#[inline(always)]
pub(crate) unsafe fn place<'a>(path: *const Path, reference: *const Reference) -> Result<Place<'a>, Status> {
    // SAFETY: the caller's promise.
    let view = unsafe { view(path) }?;
    if reference.is_null() {
        return Ok(Place { path: contour::Path::new(&[], 0, false), reference: contour::Reference::default() });
    }
    check(reference)?;
    // SAFETY: not null, aligned, readable by the caller's promise; any bits are a value.
    let Reference { span, t } = unsafe { reference.read() };
    Ok(Place { path: view, reference: contour::Reference { span, t } })
}
