//! Incremental encoders through the C interface: followed beyond the ends of their counters, and refused.

use crate::machines::*;
use std::ptr::null_mut;
use trueaxis::Position as _;
use trueaxis_capi::*;

fn start(offset: f64, resolution: f64, span: u64, near: i64) -> Result<Box<Encoder>, ResultCode> {
    let mut encoder = zeroed::<Encoder>();
    // SAFETY: all pointers and sizes match their types.
    match unsafe { trueaxis_encoder_start(&mut *encoder, size_of::<Encoder>(), offset, resolution, span, near) } {
        OK => Ok(encoder),
        refused => Err(refused),
    }
}

fn at(encoder: &mut Encoder, counts: u32) -> Position {
    let mut found = position(9.0);
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_encoder_position(encoder, counts, &mut found) }, OK);
    found
}

/// Compares with a 64-bit count: 120 steps of a quarter of the span forwards, as many back.
#[test]
fn counts_go_on_beyond_the_ends_of_the_counter() {
    for (span, resolution) in [(1u64 << 16, 1e-3), (1 << 16, -1e-3), (1 << 32, 1e-9), (3_600_000, 1e-5)] {
        let mut encoder = start(-2.5, resolution, span, 7).unwrap();
        let mut truth = 7_i64;
        for n in 0..240 {
            let found = at(&mut encoder, truth.rem_euclid(span as i64) as u32);
            let exact = -2.5 + truth as f64 * resolution;
            // In single precision a count is wrong by 2^-33 nm.
            let rounding = 0.51e-6 + truth.unsigned_abs() as f64 * 1.2e-16;
            assert!((rust::from_c(found).to_f64() - exact).abs() < rounding, "{span} {n}: {found:?} {exact}");
            truth += if n < 120 { span as i64 / 4 } else { -(span as i64) / 4 };
        }
    }
}

#[test]
fn an_ambiguous_step_is_a_dropout() {
    let mut encoder = start(0.0, 1e-3, 1 << 16, 0).unwrap();
    assert_eq!(at(&mut encoder, 0xffff_ffff), position(-0.001));
    assert!(!rust::from_c(at(&mut encoder, 16_384)).is_usable());
    assert!(!rust::from_c(at(&mut encoder, 40_000)).is_usable());
    assert_eq!(at(&mut encoder, 16_383), position(16.383));
}

#[test]
fn invalid_encoders_are_refused() {
    for (offset, resolution, span) in [
        (f64::NAN, 1e-3, 1 << 16),
        (2e9, 1e-3, 1 << 16),
        (0.0, 0.0, 1 << 16),
        (0.0, 1.5, 1 << 16),
        (0.0, f64::NAN, 1 << 16),
        (0.0, 1e-3, 3),
        (0.0, 1e-3, (1 << 32) + 1),
    ] {
        assert_eq!(start(offset, resolution, span, 0).err(), Some(ERROR_ARGUMENT));
    }
    let mut encoder = zeroed::<Encoder>();
    let mut found = position(9.0);
    // SAFETY: invalid arguments are null, zeroed or have a wrong size stated.
    unsafe {
        assert_eq!(trueaxis_encoder_position(&mut *encoder, 1, &mut found), ERROR_UNBUILT);
        assert_eq!(trueaxis_encoder_position(null_mut(), 1, &mut found), ERROR_NULL);
        assert_eq!(trueaxis_encoder_start(null_mut(), size_of::<Encoder>(), 0.0, 1e-3, 65_536, 0), ERROR_NULL);
        assert_eq!(trueaxis_encoder_start(&mut *encoder, size_of::<Encoder>() - 8, 0.0, 1e-3, 65_536, 0), ERROR_SIZE);
    }
    let mut encoder = start(0.0, 1e-3, 1 << 16, 0).unwrap();
    // SAFETY: null.
    assert_eq!(unsafe { trueaxis_encoder_position(&mut *encoder, 1, null_mut()) }, ERROR_NULL);
    assert_eq!(found, position(9.0));
}
