//! The limiter's functions for one scalar each: `prove.py` reads their LLVM code.
//!
//! The compiler knows nothing about the arguments: the proof covers every value that memory can hold.

#![no_std]

use trueaxis::limiter::{Limiter, LimiterState};

macro_rules! functions {
    ($scalar:ty, $follow:ident, $freeze:ident, $hold:ident) => {
        #[unsafe(no_mangle)]
        #[inline(never)]
        pub extern "C" fn $follow(
            limiter: &Limiter<$scalar>,
            state: &mut LimiterState<$scalar>,
            wanted: $scalar,
        ) -> bool {
            limiter.follow(state, wanted)
        }
        #[unsafe(no_mangle)]
        #[inline(never)]
        pub extern "C" fn $freeze(limiter: &Limiter<$scalar>, state: &mut LimiterState<$scalar>) {
            limiter.freeze(state);
        }
        #[unsafe(no_mangle)]
        #[inline(never)]
        pub extern "C" fn $hold(limiter: &Limiter<$scalar>, state: &mut LimiterState<$scalar>) {
            limiter.hold(state);
        }
    };
}

functions!(f32, follow_f32, freeze_f32, hold_f32);
functions!(f64, follow_f64, freeze_f64, hold_f64);
