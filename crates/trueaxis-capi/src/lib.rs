//! C interface of trueaxis: one static library, one header (`include/trueaxis.h`, generated from this crate).
//!
//! Every function checks its pointers, sizes and objects, returns a [`ResultCode`], never panics, allocates or prints,
//! and leaves all outputs unchanged when it refuses (except with `ERROR_NO_OUTPUT`, which leaves only the drive
//! positions unchanged). The documentation of the items becomes that of the header: it is written for the C programmer
//! and uses the names of the header.
//!
//! The caller's pointers are checked only in `pointer` and `opaque`.
#![no_std]
#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks, clippy::indexing_slicing)]

// On a host the standard library supplies the panic handler that a static library needs; nothing else of it is used.
#[cfg(not(target_os = "none"))]
extern crate std;

mod axes;
mod built;
mod command_window;
mod contour;
mod cycle;
mod dynamic;
mod encoder;
mod error;
mod evaluation;
mod fault;
mod frame;
mod friction;
mod gauge;
mod gauge_ride;
mod kinematics;
mod learned;
mod measure;
mod opaque;
mod part;
mod path;
mod plugin;
mod pointer;
mod query;
mod result;
mod rtcp;
mod scalar;
mod segments;
mod servo;
mod spans;
mod step;
mod steps;
mod storages;
mod tables;
mod text;
mod thermal;
mod version;

pub use axes::*;
pub use built::*;
pub use command_window::*;
pub use contour::*;
pub use cycle::*;
pub use dynamic::*;
pub use encoder::*;
pub use error::*;
pub use evaluation::*;
pub use fault::*;
pub use frame::*;
pub use friction::*;
pub use gauge::*;
pub use gauge_ride::*;
pub use kinematics::*;
pub use learned::*;
pub use measure::*;
pub use path::*;
pub use query::*;
pub use result::*;
pub use rtcp::*;
pub use scalar::*;
pub use segments::*;
pub use servo::*;
pub use spans::*;
pub use step::*;
#[doc(hidden)]
pub use storages::storage_sizes;
pub use tables::*;
pub use thermal::*;
pub use version::*;

/// No code here panics; if it does nevertheless, the core stops where a debugger can find it.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
