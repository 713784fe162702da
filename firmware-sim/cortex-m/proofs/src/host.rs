//! Entry and critical section on the host.

#![cfg(not(target_arch = "arm"))]

/// One thread: nothing to exclude.
struct Alone;
critical_section::set_impl!(Alone);

// SAFETY: the program has one thread and no interrupt.
unsafe impl critical_section::Impl for Alone {
    unsafe fn acquire() {}
    unsafe fn release((): ()) {}
}

#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    super::proved();
    0
}
