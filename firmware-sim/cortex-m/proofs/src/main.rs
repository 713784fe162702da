//! A program of the servo step alone, which links only if no panic is reachable in it.
//!
//! The panic handler calls a function that does not exist. If the compiler cannot prove a panic unreachable, the
//! call remains, and the linker names it: `a_panic_can_be_reached`. The program has no allocator and no standard library,
//! so that an allocation does not build at all. `run.sh` links it, and checks that the negative controls fail.
//!
//! The compiler knows nothing about the arguments of a function: all are called through pointers in a table.

#![no_std]
#![no_main]

mod controls;
#[cfg(feature = "decoders")]
mod decoders;
mod host;
#[cfg(feature = "painted")]
mod painted;
#[cfg(not(feature = "alone"))]
mod symbols;

use core::hint::black_box;

/// One pointer to a function.
#[derive(Clone, Copy)]
pub struct Proved(#[allow(dead_code, reason = "it is there to be pointed to")] pub *const ());
// SAFETY: an address, never dereferenced.
unsafe impl Sync for Proved {}

#[cfg(not(feature = "painted"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_can_be_reached() -> !;
    }
    // SAFETY: never called, because it does not exist.
    unsafe { a_panic_can_be_reached() }
}

#[cfg(all(target_arch = "arm", not(feature = "painted")))]
#[cortex_m_rt::entry]
fn main() -> ! {
    proved();
    loop {
        cortex_m::asm::nop();
    }
}

/// Keeps every function that is proved, and the chosen negative control.
fn proved() {
    #[cfg(not(feature = "alone"))]
    black_box(symbols::TABLE);
    black_box(controls::TABLE);
    #[cfg(feature = "decoders")]
    black_box(decoders::TABLE);
}
