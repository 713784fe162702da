//! C interface of trueaxis: one static library, one header (`include/trueaxis.h`, generated from this crate).
//!
//! Every function checks its pointers, sizes and objects, returns a [`Status`], never panics, allocates or prints, and
//! leaves all outputs untouched when it refuses (but for `ERROR_NO_OUTPUT`, which leaves the drives' alone). The documentation of the items here is that of the header: it speaks to
//! the C programmer and gives the names of the header.
//!
//! `unsafe` stands here and in the square root: what a pointer of the caller is worth is decided in `pointer` and
//! `opaque`, and nowhere else.
#![no_std]
#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks, clippy::indexing_slicing)]

// On a host the standard library brings the panic handler that a static library needs; nothing else of it is used.
#[cfg(not(target_os = "none"))]
extern crate std;

mod cycle;
mod error;
mod fault;
mod follow;
mod frame;
mod gauge;
mod opaque;
mod path;
mod plugin;
mod pointer;
mod ride;
mod scalar;
mod servo;
mod status;
mod tables;
mod text;
mod version;

pub use cycle::*;
pub use error::*;
pub use fault::*;
pub use follow::*;
pub use frame::*;
pub use gauge::*;
pub use path::*;
pub use ride::*;
pub use scalar::*;
pub use servo::*;
pub use status::*;
pub use tables::*;
pub use version::*;

/// Nothing here panics; should it happen all the same, the core stops where a debugger finds it.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
