//! Negative controls: each can panic, or needs an allocator, and must not link.

use crate::Proved;

#[cfg(feature = "variable-index")]
#[unsafe(no_mangle)]
#[inline(never)]
pub fn control(table: &[f32; 16], place: usize) -> f32 {
    table[place]
}

#[cfg(feature = "variable-division")]
#[unsafe(no_mangle)]
#[inline(never)]
pub fn control(dividend: i32, divisor: i32) -> i32 {
    dividend / divisor
}

#[cfg(feature = "allocation")]
mod allocation {
    extern crate alloc;

    #[unsafe(no_mangle)]
    #[inline(never)]
    pub fn control(count: u8) -> alloc::vec::Vec<u8> {
        alloc::vec::Vec::with_capacity(count.into())
    }
}
#[cfg(feature = "allocation")]
use allocation::control;

/// The control that the feature selects.
pub static TABLE: &[Proved] = &[
    #[cfg(any(feature = "variable-index", feature = "variable-division", feature = "allocation"))]
    Proved(control as *const ()),
];
