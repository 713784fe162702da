//! Incremental encoders: positions from counters that wrap.

use crate::Position;
use crate::opaque;
use crate::plugin::{CorePosition, from_core};
use crate::pointer::check;
use crate::result::{self, ERROR_ARGUMENT, ResultCode};
use trueaxis::sample::{EncoderScale, WrappingCounter};

/// Words of a `trueaxis_encoder_t`.
pub const ENCODER_WORDS: usize = 8;

/// An incremental encoder and its count so far. Belongs to the thread that reads it.
#[repr(C)]
#[derive(Debug)]
pub struct Encoder {
    words: [u64; ENCODER_WORDS],
}

/// Scale and counter.
pub(crate) struct Counted {
    scale: EncoderScale<CorePosition>,
    counter: WrappingCounter,
}

/// Starts an encoder: position = `offset` + counts · `resolution`, mm (rotary: degrees). The position continues where
/// the counter wraps.
///
/// `resolution`: size of one count, at most 1; negative if the counts fall while the position rises. `span`: number of
/// counts after which the counter restarts at 0, 4 to 4294967296: 65536 for 16 bits, 4294967296 for 32 bits, or the
/// counts per turn. `nearest`: the first reading is interpreted as the count nearest to this one; with 0, counters of
/// 16 and 32 bits start as signed numbers. Start the encoder again after counts were lost. Real-time safe. Errors:
/// `_ARGUMENT` (resolution or span out of range, or an offset that is not a usable position).
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_encoder_start(
    encoder: *mut Encoder,
    encoder_size: usize,
    offset: f64,
    resolution: f64,
    span: u64,
    nearest: i64,
) -> ResultCode {
    let work = || {
        let place = opaque::place(encoder, encoder_size)?;
        let scale = EncoderScale::new(offset, resolution).map_err(|_| ERROR_ARGUMENT)?;
        let counter = WrappingCounter::new(span).map_err(|_| ERROR_ARGUMENT)?.near(nearest);
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, Counted { scale, counter }) };
        Ok(())
    };
    result::of(work())
}

/// Position of the encoder at a reading of its counter, for `trueaxis_input_t.feedback`.
///
/// `counts`: the reading; if the span is a power of two, higher bits are ignored. A change of more than a quarter of
/// the span since the last reading is ambiguous: `position` is then NaN (in single precision `INT32_MIN`), which the
/// step treats as a dropout, and the counter waits for a reading within a quarter of the span of the last one. Do not
/// call this function for a missing reading; until the next reading the axis may move by a quarter of the span.
/// Real-time safe.
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses the encoder.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_encoder_position(
    encoder: *mut Encoder,
    counts: u32,
    position: *mut Position,
) -> ResultCode {
    let work = || {
        check(position)?;
        // SAFETY: the caller's promise.
        let Counted { scale, counter } = unsafe { opaque::content_mut(encoder) }?;
        #[cfg(not(feature = "single"))]
        let found = scale.position_beyond(counter, counts);
        #[cfg(feature = "single")]
        let found = scale.nanometres_beyond(counter, counts);
        // SAFETY: checked; writable by the caller's promise.
        unsafe { position.write(from_core(found)) };
        Ok(())
    };
    result::of(work())
}
