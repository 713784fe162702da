//! Results of a gauge.

use crate::Real;
use crate::gauge::{Gauge, GaugeState, either, pair};
use crate::part::{GAUGE, need};
use crate::pointer::{Buffer, Sized32, check, check_sized};
use crate::result::{self, ERROR_ARGUMENT, ERROR_BUFFER, ERROR_NOT_YET, ResultCode};
use trueaxis::roundness::{ErrorMotion, HARMONICS};
use trueaxis::telemetry::{ROUNDNESS_FRAME_BYTES, RoundnessFrame};

/// No index pulse has been seen yet, or none is reliable.
pub const GAUGE_NO_INDEX: u16 = 1;
/// An expected index pulse was missing.
pub const GAUGE_INDEX_MISSING: u16 = 1 << 1;
/// An index pulse came at a different count than before.
pub const GAUGE_INDEX_SHIFTED: u16 = 1 << 2;
/// The spindle's count changed by more than a quarter turn in one cycle.
pub const GAUGE_SPINDLE_JUMP: u16 = 1 << 3;
/// A probe is outside its range or not finite.
pub const GAUGE_PROBE_RANGE: u16 = 1 << 4;
/// The arm's angle is outside ±90°, or contradicts the linkage.
pub const GAUGE_ARM: u16 = 1 << 5;
/// The part turned backwards by more than one point.
pub const GAUGE_REVERSED: u16 = 1 << 6;
/// The part turned by more than two points in one cycle.
pub const GAUGE_TOO_FAST: u16 = 1 << 7;
/// The spindle has stopped.
pub const GAUGE_STOPPED: u16 = 1 << 8;
/// The speed changed by more than a quarter within the revolution. A revolution with this or one of the following flags
/// is still evaluated.
pub const GAUGE_SPEED: u16 = 1 << 9;
/// Revolutions were skipped because the work on an earlier one was not finished.
pub const GAUGE_SKIPPED: u16 = 1 << 10;
/// The infeed was not updated.
pub const GAUGE_INFEED_FROZEN: u16 = 1 << 11;
/// The infeed was limited over several revolutions and has been reduced.
pub const GAUGE_INFEED_REDUCED: u16 = 1 << 12;

/// Error motion of the spindle in one direction, µm.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Synchronous, without the once-per-revolution part.
    pub synchronous_um: Real,
    /// Asynchronous; 0 for a single revolution.
    pub asynchronous_um: Real,
    /// Amplitude of cos θ: eccentricity and fundamental error motion.
    pub cosine_um: Real,
    /// Amplitude of sin θ.
    pub sine_um: Real,
    /// Total.
    pub total_um: Real,
}

impl Motion {
    fn of(motion: &ErrorMotion<Real>) -> Self {
        let [cosine_um, sine_um] = motion.once_per_revolution_um;
        Motion {
            synchronous_um: motion.synchronous_um,
            asynchronous_um: motion.asynchronous_um,
            cosine_um,
            sine_um,
            total_um: motion.total_um,
        }
    }
}

/// The latest revolution, and counters of all revolutions.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// `sizeof(trueaxis_evaluation_t)`.
    pub size: u32,
    /// Number of the revolution, from 1, wrapping.
    pub revolution: u32,
    /// Number of revolutions sampled completely so far.
    pub sampled: u32,
    /// Number of revolutions evaluated so far.
    pub evaluated: u32,
    /// Number of revolutions skipped completely so far.
    pub skipped: u32,
    /// Number of revolutions discarded completely so far.
    pub discarded: u32,
    /// `TRUEAXIS_GAUGE_…` bits of this revolution.
    pub flags: u16,
    /// Number of revolutions in the window of the error motions; 0 until the window is full.
    pub revolutions: u16,
    /// 1: no work is pending, and all members describe the same revolution.
    pub settled: u8,
    /// 0.
    pub reserved: [u8; 3],
    /// Peak-to-valley roundness about the least-squares circle, filtered, µm.
    pub peak_to_valley_um: Real,
    /// Error motion across probe 1.
    pub x: Motion,
    /// Error motion along probe 1.
    pub y: Motion,
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Evaluation {}

/// Reads the results of the latest revolution evaluated.
///
/// Call it between two cycles; real-time safe. Errors: `_NOT_YET`.
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses the state during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_latest(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    evaluation: *mut Evaluation,
) -> ResultCode {
    let work = || {
        need(GAUGE)?;
        // SAFETY: the caller's promise.
        unsafe { check_sized(evaluation) }?;
        // SAFETY: the caller's promise.
        let (latest, counts, settled) = either!(unsafe { pair(gauge, gauge_state) }?.points, _gauge, state => {
            (state.latest(), state.counts(), state.is_settled())
        });
        let latest = latest.ok_or(ERROR_NOT_YET)?;
        let result = Evaluation {
            size: size_of::<Evaluation>() as u32,
            revolution: latest.revolution,
            sampled: counts.sampled,
            evaluated: counts.evaluated,
            skipped: counts.skipped,
            discarded: counts.discarded,
            flags: latest.flags.0,
            revolutions: latest.revolutions,
            settled: settled.into(),
            reserved: [0; 3],
            peak_to_valley_um: latest.peak_to_valley_um,
            x: Motion::of(&latest.x),
            y: Motion::of(&latest.y),
        };
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe { evaluation.write(result) };
        Ok(())
    };
    result::of(work())
}

/// Reads the amplitudes of cos kθ and sin kθ in the latest profile, two numbers, µm; 0 outside the file's band and for
/// a suppressed harmonic.
///
/// `harmonic`: k. Call it between two cycles; real-time safe. Errors: `_NOT_YET`, `_ARGUMENT` (k above 127).
///
/// # Safety
/// Pointers are null or point to objects of their types, `amplitudes_um` to two numbers; nobody else uses the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_harmonic(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    harmonic: u32,
    amplitudes_um: *mut Real,
) -> ResultCode {
    let work = || {
        need(GAUGE)?;
        check(amplitudes_um)?;
        let k = harmonic as usize;
        // SAFETY: the caller's promise.
        let found = either!(unsafe { pair(gauge, gauge_state) }?.points, _gauge, state => {
            state.latest().map(|_| (k < HARMONICS).then(|| state.harmonic(k)))
        });
        let amplitudes = found.ok_or(ERROR_NOT_YET)?.ok_or(ERROR_ARGUMENT)?;
        // SAFETY: checked; two writable numbers by the caller's promise.
        unsafe { amplitudes_um.cast::<[Real; 2]>().write(amplitudes) };
        Ok(())
    };
    result::of(work())
}

/// Largest telemetry frame of a revolution, bytes.
pub const GAUGE_FRAME_BYTES: usize = 1280;
const _: () = assert!(GAUGE_FRAME_BYTES == ROUNDNESS_FRAME_BYTES);

/// Writes the telemetry frame of the latest revolution: postcard in COBS, terminated by 0.
///
/// `machine_id` is copied into the frame. `written`: number of bytes written. Not real-time; about 4 KiB of stack.
/// Errors: `_NOT_YET`, `_BUFFER`.
///
/// # Safety
/// Pointers are null or point to objects of their types, `buffer` to `size` bytes; nobody else uses the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_frame_encode(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    machine_id: u32,
    buffer: *mut u8,
    size: usize,
    written: *mut usize,
) -> ResultCode {
    let work = || {
        need(GAUGE)?;
        let buffer = Buffer::new(buffer, size, written)?;
        // SAFETY: the caller's promise.
        let frame = either!(unsafe { pair(gauge, gauge_state) }?.points, gauge, state => {
            RoundnessFrame::of(machine_id, gauge, state)
        });
        let mut whole = [0; GAUGE_FRAME_BYTES];
        let frame = frame.ok_or(ERROR_NOT_YET)?;
        let frame = frame.encode(&mut whole).map_err(|_| ERROR_BUFFER)?;
        // SAFETY: the caller's promise; the bytes are this function's own.
        unsafe { buffer.fill(frame) }
    };
    result::of(work())
}
