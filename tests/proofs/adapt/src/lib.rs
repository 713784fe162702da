//! The law of a friction figure's factor for one scalar each: `adapt.py` reads its LLVM code.
//!
//! The source is the product's, by its path: the law is not public. The compiler knows nothing about the arguments: the
//! proof covers every value that memory can hold.

#![no_std]
#![allow(dead_code, private_interfaces)]

#[path = "../../../../crates/trueaxis/src/dynamic/adapt.rs"]
mod adapt;

mod real {
    pub use trueaxis::Real;
}

use adapt::{Bounds, Factor};

macro_rules! functions {
    ($scalar:ty, $follow:ident, $used:ident) => {
        #[unsafe(no_mangle)]
        #[inline(never)]
        pub extern "C" fn $follow(bounds: &Bounds<$scalar>, factor: &mut Factor<$scalar>, error: $scalar) {
            bounds.follow(factor, error);
        }
        #[unsafe(no_mangle)]
        #[inline(never)]
        pub extern "C" fn $used(bounds: &Bounds<$scalar>, factor: &Factor<$scalar>) -> $scalar {
            bounds.used(factor)
        }
    };
}

functions!(f32, follow_f32, used_f32);
functions!(f64, follow_f64, used_f64);
