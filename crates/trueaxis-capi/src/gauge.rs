//! A gauge of three probes: built, started, asked for results. It is stepped in [`crate::ride`].

use crate::Real;
use crate::error::{Error, explained};
use crate::opaque::{self, Kept, Storage};
use crate::pointer::{Sized32, check, check_sized, slice};
use crate::status::{self, ERROR_ARGUMENT, ERROR_BUFFER, ERROR_GAUGE, ERROR_NOT_YET, ERROR_NULL, ERROR_SIZE, Status};
use trueaxis::roundness::{self, ErrorMotion, GaugeSettings, HARMONICS};
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::{ROUNDNESS_FRAME_BYTES, RoundnessFrame};

/// Words of a `trueaxis_gauge_t`.
#[cfg(not(feature = "single"))]
pub const GAUGE_WORDS: usize = 6400;
/// Words of a `trueaxis_gauge_t`.
#[cfg(feature = "single")]
pub const GAUGE_WORDS: usize = 3200;
/// Words of a `trueaxis_gauge_state_t`.
#[cfg(not(feature = "single"))]
pub const GAUGE_STATE_WORDS: usize = 18048;
/// Words of a `trueaxis_gauge_state_t`.
#[cfg(feature = "single")]
pub const GAUGE_STATE_WORDS: usize = 9088;
/// Words of a `trueaxis_gauge_state_512_t`.
#[cfg(not(feature = "single"))]
pub const GAUGE_STATE_512_WORDS: usize = 9216;
/// Words of a `trueaxis_gauge_state_512_t`.
#[cfg(feature = "single")]
pub const GAUGE_STATE_512_WORDS: usize = 4672;

/// The immutable half of a gauge: angles, multipliers, limits. May be copied and read from any thread.
#[repr(C)]
#[derive(Debug)]
pub struct Gauge {
    words: [u64; GAUGE_WORDS],
}

/// The mutable half of a gauge of 1024 points, and its results. Belongs to the thread that steps it. Large: a static.
#[repr(C)]
#[derive(Debug)]
pub struct GaugeState {
    words: [u64; GAUGE_STATE_WORDS],
}

/// The same for a gauge of 512 points, in half the memory: pass `(trueaxis_gauge_state_t *)&it` and its own size.
#[repr(C)]
#[derive(Debug)]
pub struct GaugeState512 {
    words: [u64; GAUGE_STATE_512_WORDS],
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for Gauge {
    type Content = AnyGauge;
    const MAGIC: u32 = 0x5452_0004;
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for GaugeState {
    type Content = roundness::GaugeState<Real, 1024>;
    const MAGIC: u32 = 0x5452_0005;
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for GaugeState512 {
    type Content = roundness::GaugeState<Real, 512>;
    const MAGIC: u32 = 0x5452_0006;
}

/// What a `trueaxis_gauge_t` holds.
#[allow(clippy::large_enum_variant)]
pub(crate) enum AnyGauge {
    Points1024(roundness::Gauge<Real, 1024>),
    Points512(roundness::Gauge<Real, 512>),
}

/// A gauge with a state of its number of points.
pub(crate) enum Pair<'a> {
    Points1024(&'a roundness::Gauge<Real, 1024>, &'a mut roundness::GaugeState<Real, 1024>),
    Points512(&'a roundness::Gauge<Real, 512>, &'a mut roundness::GaugeState<Real, 512>),
}

/// Gauge and state, if they belong together.
///
/// # Safety
/// Pointers are null, misaligned, or point to whole storages (the state's that of the gauge's number of points) that
/// nobody else writes while the references live.
#[inline(always)]
pub(crate) unsafe fn pair<'a>(gauge: *const Gauge, state: *mut GaugeState) -> Result<Pair<'a>, Status> {
    // SAFETY: the caller's promise.
    match unsafe { opaque::content(gauge) }? {
        // SAFETY: the caller's promise.
        AnyGauge::Points1024(gauge) => Ok(Pair::Points1024(gauge, unsafe { opaque::content_mut(state) }?)),
        AnyGauge::Points512(gauge) => {
            let state = state.cast::<GaugeState512>();
            // SAFETY: the caller's promise; the magic word of the smaller state is another one.
            Ok(Pair::Points512(gauge, unsafe { opaque::content_mut(state) }?))
        }
    }
}

/// Runs the same code for both numbers of points.
macro_rules! either {
    ($pair:expr, $gauge:ident, $state:ident => $work:expr) => {
        match $pair {
            $crate::gauge::Pair::Points1024($gauge, $state) => $work,
            $crate::gauge::Pair::Points512($gauge, $state) => $work,
        }
    };
}
pub(crate) use either;

/// Builds the gauge that a table file describes (its machine's `[roundness]` section): 1024 or 512 points a revolution.
///
/// `gauge`, `gauge_size`: the caller's, `sizeof(trueaxis_gauge_t)`. `file`, `length`: the bytes of the `.tcomp`; may be
/// freed afterwards. `period_ns`: servo period, 1,000 to 100,000,000 ns. `error`: may be `NULL`.
///
/// Not real-time; takes about 117 KiB of stack, 65 KiB in single precision.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_TABLES`, `_CONFIG` (period out of range), `_GAUGE` (no gauge, or of
/// another number of points).
///
/// # Safety
/// Pointers are null or point to what their types and sizes say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_build(
    gauge: *mut Gauge,
    gauge_size: usize,
    file: *const u8,
    length: usize,
    period_ns: u32,
    error: *mut Error,
) -> Status {
    let work = || {
        let place = opaque::place(gauge, gauge_size)?;
        // SAFETY: the caller's promise.
        let tables = Tcomp::parse(unsafe { slice(file, length) }?)?;
        let settings: &GaugeSettings = tables.settings().roundness.as_ref().ok_or(ERROR_GAUGE)?;
        let built = match settings.points {
            1024 => AnyGauge::Points1024(roundness::Gauge::build(settings, period_ns)?),
            512 => AnyGauge::Points512(roundness::Gauge::build(settings, period_ns)?),
            _ => return Err(ERROR_GAUGE.into()),
        };
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, built) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Makes a state new: nothing is measured or fed in until another revolution is whole, and the wheel is that of the file.
///
/// `gauge_state`, `state_size`: the caller's; `sizeof(trueaxis_gauge_state_t)` for a gauge of 1024 points,
/// `sizeof(trueaxis_gauge_state_512_t)` for one of 512.
///
/// Not real-time: it clears all of the state; takes about 65 KiB of stack, 33 KiB in single precision.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`.
///
/// # Safety
/// Pointers are null or point to what their types and sizes say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_restart(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    state_size: usize,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        match unsafe { opaque::content(gauge) }? {
            AnyGauge::Points1024(gauge) => {
                let place: *mut Kept<GaugeState> = opaque::place(gauge_state, state_size)?;
                // SAFETY: storage of the size that the caller vouched for.
                unsafe { opaque::fill(place, gauge.start()) };
            }
            AnyGauge::Points512(gauge) => {
                let place: *mut Kept<GaugeState512> = opaque::place(gauge_state.cast(), state_size)?;
                // SAFETY: storage of the size that the caller vouched for.
                unsafe { opaque::fill(place, gauge.start()) };
            }
        }
        Ok(())
    };
    status::of(work())
}

/// Sets the radius of the wheel, mm (wear, dressing); in force from the next revolution that is worked on.
///
/// `error`: may be `NULL`. `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_CONFIG` (no following arm, or the
/// linkage could not close).
///
/// # Safety
/// Pointers are null or point to what their types say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_set_wheel(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    wheel_mm: f64,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        Ok(either!(unsafe { pair(gauge, gauge_state) }?, gauge, state => gauge.set_wheel(state, wheel_mm))?)
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// No index pulse has been seen yet, or none that can be relied on.
pub const GAUGE_NO_INDEX: u16 = 1;
/// An index pulse did not come.
pub const GAUGE_INDEX_MISSING: u16 = 1 << 1;
/// An index pulse came at another count than before.
pub const GAUGE_INDEX_SHIFTED: u16 = 1 << 2;
/// The spindle's count changed by more than a quarter turn in a cycle.
pub const GAUGE_SPINDLE_JUMP: u16 = 1 << 3;
/// A probe is outside its range, or gave no finite reading.
pub const GAUGE_PROBE_RANGE: u16 = 1 << 4;
/// The arm's angle is outside ±90°, or contradicts the linkage.
pub const GAUGE_ARM: u16 = 1 << 5;
/// The part turned backwards by more than a point.
pub const GAUGE_REVERSED: u16 = 1 << 6;
/// More than two points passed in a cycle.
pub const GAUGE_TOO_FAST: u16 = 1 << 7;
/// The spindle stood.
pub const GAUGE_STOPPED: u16 = 1 << 8;
/// The speed changed by more than a quarter within the revolution. From here on, the revolution counts all the same.
pub const GAUGE_SPEED: u16 = 1 << 9;
/// Revolutions were skipped whole, because the work on one before was not finished.
pub const GAUGE_SKIPPED: u16 = 1 << 10;
/// The infeed correction was not updated.
pub const GAUGE_INFEED_FROZEN: u16 = 1 << 11;
/// The infeed correction was limited over several revolutions and has been made smaller.
pub const GAUGE_INFEED_REDUCED: u16 = 1 << 12;

/// Error motion of the spindle in one direction, µm.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Synchronous, without the once-per-revolution part.
    pub synchronous_um: Real,
    /// Asynchronous; 0 over a single revolution.
    pub asynchronous_um: Real,
    /// Amplitude of cos θ: eccentricity and fundamental.
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

/// What is known about the latest revolution, and how all of them fared.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// `sizeof(trueaxis_evaluation_t)`, set by the caller once; stays as it is.
    pub size: u32,
    /// Counts whole revolutions that were sampled, from 1, wrapping.
    pub revolution: u32,
    /// Revolutions sampled whole so far.
    pub sampled: u32,
    /// Revolutions evaluated so far.
    pub evaluated: u32,
    /// Revolutions skipped whole so far.
    pub skipped: u32,
    /// Revolutions discarded whole so far.
    pub discarded: u32,
    /// `TRUEAXIS_GAUGE_…` bits: what this revolution met.
    pub flags: u16,
    /// Revolutions in the window of the error motions; 0 until one is full.
    pub revolutions: u16,
    /// 1 while no work is under way: all of this is of one revolution then.
    pub settled: u8,
    /// 0.
    pub reserved: [u8; 3],
    /// Peak-to-valley roundness about the least-squares circle, after the filter if there is one, µm.
    pub peak_to_valley_um: Real,
    /// Error motion across probe 1.
    pub x: Motion,
    /// Error motion along probe 1.
    pub y: Motion,
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Evaluation {}

/// The latest revolution evaluated.
///
/// Real-time safe; to be called between two cycles. `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_NOT_YET`.
///
/// # Safety
/// Pointers are null or point to what their types say; nobody else uses the state meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_latest(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    evaluation: *mut Evaluation,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        unsafe { check_sized(evaluation) }?;
        // SAFETY: the caller's promise.
        let (latest, counts, settled) = either!(unsafe { pair(gauge, gauge_state) }?, _gauge, state => {
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
    status::of(work())
}

/// Amplitudes of cos kθ and sin kθ in the latest profile, µm: two numbers to `amplitudes_um`. Zero outside the band of the
/// file and where a harmonic is suppressed.
///
/// Real-time safe; to be called between two cycles. `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_NOT_YET`,
/// `_ARGUMENT` (harmonics are kept up to 127).
///
/// # Safety
/// Pointers are null or point to what their types say, `amplitudes_um` to two numbers; nobody else uses the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_harmonic(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    harmonic: u32,
    amplitudes_um: *mut Real,
) -> Status {
    let work = || {
        check(amplitudes_um)?;
        let k = harmonic as usize;
        // SAFETY: the caller's promise.
        let found = either!(unsafe { pair(gauge, gauge_state) }?, _gauge, state => {
            state.latest().map(|_| (k < HARMONICS).then(|| state.harmonic(k)))
        });
        let amplitudes = found.ok_or(ERROR_NOT_YET)?.ok_or(ERROR_ARGUMENT)?;
        // SAFETY: checked; two writable numbers by the caller's promise.
        unsafe { amplitudes_um.cast::<[Real; 2]>().write(amplitudes) };
        Ok(())
    };
    status::of(work())
}

/// A buffer of this size holds the frame of any revolution.
pub const GAUGE_FRAME_BYTES: usize = 1280;
const _: () = assert!(GAUGE_FRAME_BYTES == ROUNDNESS_FRAME_BYTES);

/// Writes the telemetry frame of the latest revolution: postcard in COBS, its last byte 0, at most
/// `TRUEAXIS_GAUGE_FRAME_BYTES`.
///
/// `machine_id`: goes into the frame. `buffer`, `size`: where to. `written`: receives the number of bytes. Bounded time,
/// but not part of the cycle; takes about 4 KiB of stack.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_NOT_YET`, `_BUFFER`.
///
/// # Safety
/// Pointers are null or point to what their types say, `buffer` to `size` bytes; nobody else uses the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_frame_encode(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    machine_id: u32,
    buffer: *mut u8,
    size: usize,
    written: *mut usize,
) -> Status {
    let work = || {
        check(written)?;
        if buffer.is_null() {
            return Err(ERROR_NULL);
        }
        if size > isize::MAX as usize {
            return Err(ERROR_SIZE);
        }
        // SAFETY: the caller's promise.
        let frame = either!(unsafe { pair(gauge, gauge_state) }?, gauge, state => {
            RoundnessFrame::of(machine_id, gauge, state)
        });
        let mut whole = [0; GAUGE_FRAME_BYTES];
        let frame = frame.ok_or(ERROR_NOT_YET)?;
        let frame = frame.encode(&mut whole).map_err(|_| ERROR_BUFFER)?;
        if frame.len() > size {
            return Err(ERROR_BUFFER);
        }
        // SAFETY: the buffer has at least as many bytes, and is the caller's and not this function's; `written` was checked.
        unsafe {
            buffer.copy_from_nonoverlapping(frame.as_ptr(), frame.len());
            written.write(frame.len());
        }
        Ok(())
    };
    status::of(work())
}
