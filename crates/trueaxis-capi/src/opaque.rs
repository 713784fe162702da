//! Objects with hidden contents, in storage that the caller provides.
//!
//! The storage begins with a magic word that identifies its content. Storage that was zeroed, that contains something
//! else, or that another build of the library has filled is refused; the content is read only if the word is right.

use crate::pointer::check;
use crate::result::{ERROR_SIZE, ERROR_UNBUILT, ResultCode};
use core::mem::{align_of, size_of};

/// Storage of the header: `uint64_t words[]`.
///
/// # Safety
/// `#[repr(C)]`, one array of `u64`. The content fits: `Filled::<Self>::FITS` is evaluated where storage is filled.
pub(crate) unsafe trait Storage {
    /// Content of the filled storage.
    type Content;
    /// First word of filled storage; different for every kind.
    const MAGIC: u32;
}

/// Layout of a filled [`Storage`].
#[repr(C)]
pub(crate) struct Filled<S: Storage> {
    magic: u32,
    content: S::Content,
}

impl<S: Storage> Filled<S> {
    const FITS: () = assert!(size_of::<Self>() <= size_of::<S>() && align_of::<Self>() <= align_of::<S>());
    // A library of one precision refuses storage of the other; likewise storage of another major version.
    const WORD: u32 = S::MAGIC ^ crate::version::ABI_VERSION & 0xffff_0000;
}

/// Storage that can be filled; `size` is the size that the caller assumes.
pub(crate) fn place<S: Storage>(storage: *mut S, size: usize) -> Result<*mut Filled<S>, ResultCode> {
    const { Filled::<S>::FITS };
    check(storage)?;
    if size == size_of::<S>() { Ok(storage.cast()) } else { Err(ERROR_SIZE) }
}

/// Fills storage.
///
/// # Safety
/// `place` comes from [`place`], and the caller vouched for storage of that size which nobody else uses now.
pub(crate) unsafe fn fill<S: Storage>(place: *mut Filled<S>, content: S::Content) {
    // SAFETY: aligned and large enough (`place`), writable by the caller's promise. Nothing in it needs to be dropped:
    // contents are `Copy` or hold no resources.
    unsafe { place.write(Filled { magic: Filled::<S>::WORD, content }) }
}

/// Fills storage in place, with a content that is too large to be moved there.
///
/// # Safety
/// As for [`fill`]; `build` writes the whole content, or fails and writes nothing.
pub(crate) unsafe fn fill_with<S: Storage, E>(
    place: *mut Filled<S>,
    build: impl FnOnce(*mut S::Content) -> Result<(), E>,
) -> Result<(), E> {
    // SAFETY: aligned and large enough (`place`), writable by the caller's promise.
    unsafe {
        build(&raw mut (*place).content)?;
        (&raw mut (*place).magic).write(Filled::<S>::WORD);
    }
    Ok(())
}

/// Content of filled storage.
///
/// # Safety
/// `storage` is null, misaligned, or points to a whole readable storage that nobody writes while the reference lives and
/// whose bytes, if they begin with the magic word, were written by [`fill`] or [`fill_with`].
#[inline(always)]
pub(crate) unsafe fn content<'a, S: Storage>(storage: *const S) -> Result<&'a S::Content, ResultCode> {
    check(storage)?;
    let filled = storage.cast::<Filled<S>>();
    // SAFETY: not null, aligned, readable; a plain word.
    if unsafe { (&raw const (*filled).magic).read() } != Filled::<S>::WORD {
        return Err(ERROR_UNBUILT);
    }
    // SAFETY: with the magic word in front, this is what `fill` or `fill_with` wrote.
    Ok(unsafe { &(*filled).content })
}

/// Mutable content of filled storage.
///
/// # Safety
/// As for [`content`], and nobody else uses the storage while the reference lives.
#[inline(always)]
pub(crate) unsafe fn content_mut<'a, S: Storage>(storage: *mut S) -> Result<&'a mut S::Content, ResultCode> {
    check(storage)?;
    let filled = storage.cast::<Filled<S>>();
    // SAFETY: not null, aligned, readable; a plain word.
    if unsafe { (&raw const (*filled).magic).read() } != Filled::<S>::WORD {
        return Err(ERROR_UNBUILT);
    }
    // SAFETY: with the magic word in front, this is what `fill` or `fill_with` wrote, and ours alone for now.
    Ok(unsafe { &mut (*filled).content })
}

/// Bytes that the content of a storage needs, and bytes that the header gives.
pub(crate) const fn sizes<S: Storage>() -> (usize, usize) {
    (size_of::<Filled<S>>(), size_of::<S>())
}
