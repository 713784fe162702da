//! Building and starting a gauge of three probes. Its results are in [`crate::evaluation`], its cycle in
//! [`crate::gauge_ride`].

use crate::Real;
use crate::error::{Error, explained};
use crate::opaque::{self, Filled};
use crate::part::{GAUGE, need};
use crate::pointer::slice;
use crate::result::{self, ERROR_GAUGE, ResultCode};
use trueaxis::roundness::{self, Cycle, Followed, GaugeSettings, Probes};
use trueaxis::tcomp::Tcomp;

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

/// Angles, multipliers and limits of a gauge. Immutable; may be copied and may be read from any thread.
#[repr(C)]
#[derive(Debug)]
pub struct Gauge {
    words: [u64; GAUGE_WORDS],
}

/// State and results of a gauge of 1024 points. Belongs to the thread that steps it. Large: make it static.
#[repr(C)]
#[derive(Debug)]
pub struct GaugeState {
    words: [u64; GAUGE_STATE_WORDS],
}

/// State and results of a gauge of 512 points, half as large: pass `(trueaxis_gauge_state_t *)&it` and its own size.
#[repr(C)]
#[derive(Debug)]
pub struct GaugeState512 {
    words: [u64; GAUGE_STATE_512_WORDS],
}

/// Runs the same code for both numbers of points.
macro_rules! either {
    ($points:expr, $gauge:ident, $state:ident => $work:expr) => {
        match $points {
            $crate::gauge::Points::Points1024($gauge, $state) => $work,
            $crate::gauge::Points::Points512($gauge, $state) => $work,
        }
    };
}
pub(crate) use either;

/// Content of a [`Gauge`].
pub(crate) struct BuiltGauge {
    points: AnyGauge,
    update: Update,
    infeed_slot: Option<usize>,
}

/// A gauge with its number of points.
#[allow(clippy::large_enum_variant)]
enum AnyGauge {
    Points1024(roundness::Gauge<Real, 1024>),
    Points512(roundness::Gauge<Real, 512>),
}

/// A gauge and a state for the same number of points.
pub(crate) struct Pair<'a> {
    built: &'a BuiltGauge,
    pub(crate) points: Points<'a>,
}

/// One cycle of a gauge.
pub(crate) type Update = fn(&mut Pair<'_>, &Probes<Real>, Followed) -> Cycle<Real>;

fn update(pair: &mut Pair<'_>, probes: &Probes<Real>, followed: Followed) -> Cycle<Real> {
    either!(&mut pair.points, gauge, state => gauge.update(state, probes, followed))
}

impl Pair<'_> {
    pub(crate) fn update(&self) -> Update {
        self.built.update
    }

    pub(crate) fn infeed_slot(&self) -> Option<usize> {
        self.built.infeed_slot
    }
}

/// References to a gauge and a state for the same number of points.
pub(crate) enum Points<'a> {
    Points1024(&'a roundness::Gauge<Real, 1024>, &'a mut roundness::GaugeState<Real, 1024>),
    Points512(&'a roundness::Gauge<Real, 512>, &'a mut roundness::GaugeState<Real, 512>),
}

/// Returns gauge and state if they belong together.
///
/// # Safety
/// Pointers are null, misaligned, or point to whole storages (the state to one for the gauge's number of points) that
/// nobody else writes while the references live.
#[inline(always)]
pub(crate) unsafe fn pair<'a>(gauge: *const Gauge, state: *mut GaugeState) -> Result<Pair<'a>, ResultCode> {
    // SAFETY: the caller's promise.
    let built: &'a BuiltGauge = unsafe { opaque::content(gauge) }?;
    let points = match &built.points {
        // SAFETY: the caller's promise.
        AnyGauge::Points1024(gauge) => Points::Points1024(gauge, unsafe { opaque::content_mut(state) }?),
        AnyGauge::Points512(gauge) => {
            let state = state.cast::<GaugeState512>();
            // SAFETY: the caller's promise; the magic word of the smaller state is another one.
            Points::Points512(gauge, unsafe { opaque::content_mut(state) }?)
        }
    };
    Ok(Pair { built, points })
}

/// Builds the gauge of a table file (`[roundness]` of its machine), with 1024 or 512 points per revolution.
///
/// Arguments as for `trueaxis_loop_build`. Not real-time; about 117 KiB of stack, 65 KiB in single precision. Errors:
/// `_TABLES`, `_CONFIG` (also the period), `_GAUGE`.
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_build(
    gauge: *mut Gauge,
    gauge_size: usize,
    file: *const u8,
    length: usize,
    period_ns: u32,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(GAUGE)?;
        let place = opaque::place(gauge, gauge_size)?;
        // SAFETY: the caller's promise.
        let file = unsafe { slice(file, length) }?;
        let mut tables = Tcomp::empty();
        tables.read(file)?;
        let settings: &GaugeSettings = tables.settings().roundness.as_ref().ok_or(ERROR_GAUGE)?;
        let points = match settings.points {
            1024 => AnyGauge::Points1024(roundness::Gauge::build(settings, period_ns)?),
            512 => AnyGauge::Points512(roundness::Gauge::build(settings, period_ns)?),
            _ => return Err(ERROR_GAUGE.into()),
        };
        let infeed_slot = match &points {
            AnyGauge::Points1024(gauge) => gauge.infeed_slot(),
            AnyGauge::Points512(gauge) => gauge.infeed_slot(),
        };
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, BuiltGauge { points, update, infeed_slot }) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Starts a new state: nothing is fed in before a whole revolution has been sampled, and the wheel is that of the file.
///
/// `state_size`: size of `trueaxis_gauge_state_t`, or for 512 points of `trueaxis_gauge_state_512_t`. Not real-time;
/// about 65 KiB of stack, 33 KiB in single precision.
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_restart(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    state_size: usize,
) -> ResultCode {
    let work = || {
        need(GAUGE)?;
        // SAFETY: the caller's promise.
        match &unsafe { opaque::content(gauge) }?.points {
            AnyGauge::Points1024(gauge) => {
                let place: *mut Filled<GaugeState> = opaque::place(gauge_state, state_size)?;
                // SAFETY: storage of the size that the caller vouched for.
                unsafe { opaque::fill(place, gauge.start()) };
            }
            AnyGauge::Points512(gauge) => {
                let place: *mut Filled<GaugeState512> = opaque::place(gauge_state.cast(), state_size)?;
                // SAFETY: storage of the size that the caller vouched for.
                unsafe { opaque::fill(place, gauge.start()) };
            }
        }
        Ok(())
    };
    result::of(work())
}

/// Sets the radius of the wheel, mm (wear, dressing), from the next evaluated revolution on.
///
/// Call it between two cycles. Errors: `_CONFIG` (the gauge has no following arm, or the linkage cannot close).
///
/// # Safety
/// Pointers are null or point to objects of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_gauge_set_wheel(
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    wheel_mm: f64,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(GAUGE)?;
        // SAFETY: the caller's promise.
        Ok(either!(unsafe { pair(gauge, gauge_state) }?.points, gauge, state => gauge.set_wheel(state, wheel_mm))?)
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}
