//! The library for three axes only: accepts a machine of three axes, refuses one of five.

use crate::machines::sample;
use std::ptr::null_mut;
use trueaxis_capi::*;

fn build(machine: &str) -> ResultCode {
    let file = sample(machine);
    let mut memory = vec![0_u64; 1 << 17];
    // SAFETY: zero is a valid value of the storage.
    let mut place: Box<Loop> = Box::new(unsafe { std::mem::zeroed() });
    // SAFETY: pointers and sizes are those of the objects above.
    unsafe {
        trueaxis_loop_build(
            &raw mut *place,
            size_of::<Loop>(),
            file.as_ptr(),
            file.len(),
            0,
            1_000_000,
            memory.as_mut_ptr().cast(),
            memory.len() * 8,
            null_mut(),
        )
    }
}

#[test]
fn five_axes_are_refused() {
    assert_eq!(build("mill-3axis"), OK);
    assert_eq!(build("mill-5axis"), ERROR_CONFIG);
}
