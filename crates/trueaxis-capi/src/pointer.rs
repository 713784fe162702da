//! Checks of the caller's pointers: null, alignment and size. They precede everything else.

use crate::result::{ERROR_ALIGNMENT, ERROR_BUFFER, ERROR_NULL, ERROR_SIZE, ResultCode};
use core::mem::{align_of, size_of};

/// A structure of the header that begins with its own size, a `u32`.
///
/// # Safety
/// `#[repr(C)]`, first member `size: u32`, every bit pattern a valid value.
pub(crate) unsafe trait Sized32: Copy {}

/// Refuses null and misaligned pointers.
#[inline(always)]
pub(crate) fn check<T>(pointer: *const T) -> Result<(), ResultCode> {
    if pointer.is_null() {
        Err(ERROR_NULL)
    } else if !pointer.is_aligned() {
        Err(ERROR_ALIGNMENT)
    } else {
        Ok(())
    }
}

/// Refuses null and misaligned pointers, and a structure whose member `size` is not its size in this build.
///
/// # Safety
/// `pointer` is null, misaligned, or points to at least four readable bytes.
#[inline(always)]
pub(crate) unsafe fn check_sized<T: Sized32>(pointer: *const T) -> Result<(), ResultCode> {
    check(pointer)?;
    // SAFETY: not null and aligned; the caller vouches for four readable bytes, which `Sized32` begins with.
    let size = unsafe { pointer.cast::<u32>().read() };
    if size as usize == size_of::<T>() { Ok(()) } else { Err(ERROR_SIZE) }
}

/// A copy of a structure that the caller has filled.
///
/// # Safety
/// `pointer` is null, misaligned, or points to as many readable bytes as its member `size` says (at least four).
#[inline(always)]
pub(crate) unsafe fn read_sized<T: Sized32>(pointer: *const T) -> Result<T, ResultCode> {
    // SAFETY: the caller's promise covers the first four bytes.
    unsafe { check_sized(pointer) }?;
    // SAFETY: aligned, and its size is that of `T`; any bits are a value (`Sized32`).
    Ok(unsafe { pointer.read() })
}

/// Alignment required of memory that the caller lends.
const MEMORY_ALIGNMENT: usize = 8;

/// Start of the memory that the caller lends, if it is usable.
pub(crate) fn memory(pointer: *mut core::ffi::c_void, size: usize) -> Result<*mut u8, ResultCode> {
    let start = pointer.cast::<u8>();
    if start.is_null() {
        return Err(ERROR_NULL);
    }
    if start.addr() % MEMORY_ALIGNMENT != 0 {
        return Err(ERROR_ALIGNMENT);
    }
    if size > isize::MAX as usize {
        return Err(ERROR_SIZE);
    }
    Ok(start)
}

const _: () = assert!(align_of::<u64>() <= MEMORY_ALIGNMENT && align_of::<f64>() <= MEMORY_ALIGNMENT);

/// A buffer of the caller to be filled, with the place for the number of bytes written.
pub(crate) struct Buffer {
    start: *mut u8,
    size: usize,
    written: *mut usize,
}

impl Buffer {
    /// Refuses null, a misaligned `written` and an impossible size.
    pub(crate) fn new(start: *mut u8, size: usize, written: *mut usize) -> Result<Buffer, ResultCode> {
        check(written)?;
        if start.is_null() {
            return Err(ERROR_NULL);
        }
        if size > isize::MAX as usize {
            return Err(ERROR_SIZE);
        }
        Ok(Buffer { start, size, written })
    }

    /// Copies the bytes to the buffer; writes nothing if they do not fit.
    ///
    /// # Safety
    /// The buffer must have `size` writable bytes that do not overlap `bytes`, and the count must be writable.
    pub(crate) unsafe fn fill(self, bytes: &[u8]) -> Result<(), ResultCode> {
        if bytes.len() > self.size {
            return Err(ERROR_BUFFER);
        }
        // SAFETY: as many bytes at least, not overlapping, and a count that `new` has checked, by the caller's promise.
        unsafe {
            self.start.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
            self.written.write(bytes.len());
        }
        Ok(())
    }
}

/// Whether two ranges (address, size) have no byte in common.
pub(crate) fn apart((a, a_size): (usize, usize), (b, b_size): (usize, usize)) -> bool {
    a.saturating_add(a_size) <= b || b.saturating_add(b_size) <= a
}

/// Reads three numbers of the caller.
///
/// # Safety
/// `pointer` is null, misaligned, or points to three readable numbers.
pub(crate) unsafe fn vector(pointer: *const f64) -> Result<[f64; 3], ResultCode> {
    check(pointer)?;
    // SAFETY: not null, aligned, readable by the caller's promise; any bits are a number.
    Ok(unsafe { pointer.cast::<[f64; 3]>().read() })
}

/// A list of the caller as a slice.
///
/// # Safety
/// Every bit pattern of `T` is a value; `pointer` is null, misaligned, or points to `count` of them that are readable
/// and that nobody writes while the slice is in use.
pub(crate) unsafe fn slice<'a, T: Copy>(pointer: *const T, count: usize) -> Result<&'a [T], ResultCode> {
    check(pointer)?;
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(ERROR_SIZE);
    }
    // SAFETY: not null, aligned, of a possible length, readable and unchanged by the caller's promise.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}
