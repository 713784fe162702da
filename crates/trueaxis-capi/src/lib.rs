//! C interface of trueaxis: one static library, one header (`include/trueaxis.h`, generated from this crate).
//!
//! Every function checks its pointers, sizes and objects, returns a [`ResultCode`], never panics, allocates or prints, and
//! leaves all outputs untouched when it refuses (but for `ERROR_NO_OUTPUT`, which leaves the drives' alone). The
//! documentation of the items is that of the header: it speaks to the C programmer in the names of the header.
//!
//! Pointers of the caller are checked in `pointer` and `opaque`, and nowhere else.
#![no_std]
#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks, clippy::indexing_slicing)]

// On a host the standard library brings the panic handler that a static library needs; nothing else of it is used.
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
pub use tables::*;
pub use thermal::*;
pub use version::*;

/// Nothing here panics; should it happen all the same, the core stops where a debugger finds it.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
