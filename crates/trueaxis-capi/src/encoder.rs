//! Encoders that count: positions of counters that wrap.

use crate::Position;
use crate::opaque::{self, Storage};
use crate::plugin::{CorePosition, from_core};
use crate::pointer::check;
use crate::result::{self, ERROR_ARGUMENT, ResultCode};
use trueaxis::sample::{EncoderScale, WrappingCounter};

/// Words of a `trueaxis_encoder_t`.
pub const ENCODER_WORDS: usize = 8;

/// An encoder that counts, and how far it has counted. Belongs to the thread that reads it.
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

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for Encoder {
    type Content = Counted;
    const MAGIC: u32 = 0x5452_000e;
}

/// Starts an encoder: position = `offset` + counts · `resolution`, mm (rotary: degrees), counts followed beyond the end of
/// the counter.
///
/// `resolution`: of one count, negative where counts fall as the axis goes on; up to 1. `span`: counts after which the
/// counter begins again at 0: 65536 of 16 bits, 4294967296 of 32 bits, or the counts of a turn; 4 to 4294967296.
/// `nearest`: the first reading is taken as the count nearest to this one; with 0 counters of 16 and 32 bits start as signed
/// numbers. Start again after a loss of counts. Real-time safe. `_ARGUMENT` (resolution, span, an offset that is no usable
/// position).
///
/// # Safety
/// Pointers are null or point to what their types and sizes say.
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
/// `counts`: of a power of two the bits that the counter has, the others are ignored. A step of more than a quarter of the
/// span since the last reading could as well be one the other way round: `position` is then not a number, in single
/// precision `INT32_MIN`, which the step takes for a dropout, and the counter waits for counts within a quarter of its last.
/// A reading that is missing is not handed in; while it is, the axis may move a quarter of the span. Real-time safe.
///
/// # Safety
/// Pointers are null or point to what their types say; nobody else uses the encoder.
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
