//! Loops and states for every number of axes.

use crate::Real;
use crate::axes::AXES_MAX;
use crate::cycle::{Input, Output};
use crate::gauge_ride::Riding;
use crate::plugin::{CorePosition, Servo, ServoState};
use crate::result::{ERROR_AXES, ERROR_PERIOD, ERROR_STATE, ResultCode};
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::Method;
use trueaxis::machine::{Axis, GridData, ThermalGrowth};
use trueaxis::tcomp::Tcomp;
use trueaxis::{Bypass, Config, ConfigError, Fault, Measure};

/// Words of a `trueaxis_loop_t`.
#[cfg(not(feature = "single"))]
pub const LOOP_WORDS: usize = 1264;
/// Words of a `trueaxis_loop_t`.
#[cfg(feature = "single")]
pub const LOOP_WORDS: usize = 736;
/// Words of a `trueaxis_state_t`.
#[cfg(not(feature = "single"))]
pub const STATE_WORDS: usize = 952;
/// Words of a `trueaxis_state_t`.
#[cfg(feature = "single")]
pub const STATE_WORDS: usize = 504;

/// Tables, limits and settings of a machine. Immutable; may be copied and may be read from any thread.
#[repr(C)]
#[derive(Debug)]
pub struct Loop {
    words: [u64; LOOP_WORDS],
}

/// State that one cycle passes to the next. Belongs to the thread that steps it; a copy may be restored between two
/// cycles.
#[repr(C)]
#[derive(Debug)]
pub struct State {
    words: [u64; STATE_WORDS],
}

/// Content of a [`Loop`].
pub(crate) struct Built {
    pub(crate) servo: AnyServo,
    period_ns: u32,
    /// 0 in a bypass.
    pub(crate) machine_id: u32,
    /// Thermal growth of the axes, in the order of the step.
    growth: [ThermalGrowth; AXES_MAX],
    /// The axes in the order of the step; all `None` in a bypass.
    order: [Option<Axis>; AXES_MAX],
}

/// Writes a loop to its place; `?` would copy it once more.
///
/// # Safety
/// `place` is aligned, writable and nobody else's.
#[inline(always)]
unsafe fn put<S>(
    place: *mut AnyServo,
    built: Result<S, ConfigError>,
    any: impl FnOnce(S) -> AnyServo,
) -> Result<(), ConfigError> {
    match built {
        Ok(servo) => {
            // SAFETY: the caller's promise.
            unsafe { place.write(any(servo)) };
            Ok(())
        }
        Err(error) => Err(error),
    }
}

/// A servo loop with its number of axes.
#[allow(clippy::large_enum_variant)] // storage has the size of the largest anyway
pub(crate) enum AnyServo {
    Three(Servo<3>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    Four(Servo<4>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    Five(Servo<5>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    Six(Servo<6>),
    /// Commands pass uncorrected.
    Bypass {
        axes: usize,
        reason: Fault,
    },
}

/// Content of a [`State`].
#[allow(clippy::large_enum_variant)] // as above
pub(crate) enum Running {
    Three(ServoState<3>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    Four(ServoState<4>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    Five(ServoState<5>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    Six(ServoState<6>),
    BypassThree(Bypass<CorePosition, 3>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    BypassFour(Bypass<CorePosition, 4>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    BypassFive(Bypass<CorePosition, 5>),
    #[cfg(all(feature = "rotary", not(feature = "three")))]
    BypassSix(Bypass<CorePosition, 6>),
}

/// Runs the same code for every number of axes, or refuses a loop and a state that do not belong together.
macro_rules! with_servo {
    ($built:expr, $running:expr, servo($servo:ident, $state:ident) => $work:expr, bypass($passing:pat) => $pass:expr) => {{
        use $crate::built::{AnyServo, Running};
        match (&$built.servo, $running) {
            (AnyServo::Three($servo), Running::Three($state)) => Ok($work),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            (AnyServo::Four($servo), Running::Four($state)) => Ok($work),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            (AnyServo::Five($servo), Running::Five($state)) => Ok($work),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            (AnyServo::Six($servo), Running::Six($state)) => Ok($work),
            (AnyServo::Bypass { axes: 3, .. }, Running::BypassThree($passing)) => Ok($pass),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            (AnyServo::Bypass { axes: 4, .. }, Running::BypassFour($passing)) => Ok($pass),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            (AnyServo::Bypass { axes: 5, .. }, Running::BypassFive($passing)) => Ok($pass),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            (AnyServo::Bypass { axes: 6, .. }, Running::BypassSix($passing)) => Ok($pass),
            (servo, running) => Err($crate::built::mismatch(servo, running)),
        }
    }};
}
pub(crate) use with_servo;

/// Error of a loop and a state that do not belong together.
#[cold]
pub(crate) fn mismatch(servo: &AnyServo, running: &Running) -> ResultCode {
    if servo.axes() == running.axes() { ERROR_STATE } else { ERROR_AXES }
}

impl AnyServo {
    pub(crate) fn axes(&self) -> usize {
        match self {
            AnyServo::Three(_) => 3,
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Four(_) => 4,
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Five(_) => 5,
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Six(_) => 6,
            AnyServo::Bypass { axes, .. } => *axes,
        }
    }
}

impl Running {
    pub(crate) fn axes(&self) -> usize {
        match self {
            Running::Three(_) | Running::BypassThree(_) => 3,
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            Running::Four(_) | Running::BypassFour(_) => 4,
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            Running::Five(_) | Running::BypassFive(_) => 5,
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            Running::Six(_) | Running::BypassSix(_) => 6,
        }
    }
}

impl Built {
    /// Builds a loop at `place`: every move of a loop would take 4 kB of stack. After an error nothing is written.
    ///
    /// # Safety
    /// `place` is aligned, writable and nobody else's.
    pub(crate) unsafe fn build_at(
        place: *mut Self,
        tables: &Tcomp<'_>,
        grids: &[GridData<'static>],
        period_ns: u32,
        memory: &'static mut [Real],
    ) -> Result<(), ConfigError> {
        let config = Config {
            machine: tables.settings(),
            grids,
            machine_id: tables.machine_id(),
            tables_crc: tables.crc(),
            period_ns,
            inverse_passes: tables.inverse_passes(),
            method: Method::Guarded,
        };
        let rows = tables.rows();
        let (mut growth, mut order) = ([ThermalGrowth::default(); AXES_MAX], [None; AXES_MAX]);
        let slots = crate::tables::slots(tables);
        for ((growth, name), (axis, settings)) in growth.iter_mut().zip(&mut order).zip(slots) {
            *growth = settings.map_or(*growth, |settings| settings.thermal);
            *name = Some(axis);
        }
        // SAFETY: the caller's promise; every field is written.
        unsafe {
            let servo = &raw mut (*place).servo;
            match crate::tables::axes_of(tables) {
                3 => put(servo, config.build(rows, memory), AnyServo::Three),
                #[cfg(all(feature = "rotary", not(feature = "three")))]
                4 => put(servo, config.build(rows, memory), AnyServo::Four),
                #[cfg(all(feature = "rotary", not(feature = "three")))]
                5 => put(servo, config.build(rows, memory), AnyServo::Five),
                #[cfg(all(feature = "rotary", not(feature = "three")))]
                _ => put(servo, config.build(rows, memory), AnyServo::Six),
                #[cfg(not(all(feature = "rotary", not(feature = "three"))))]
                _ => put(servo, config.build(rows, memory), AnyServo::Three), // refuses the other axes
            }?;
            (&raw mut (*place).period_ns).write(period_ns);
            (&raw mut (*place).machine_id).write(tables.machine_id());
            (&raw mut (*place).growth).write(growth);
            (&raw mut (*place).order).write(order);
        }
        Ok(())
    }

    pub(crate) fn bypass(axes: usize, reason: Fault, period_ns: u32) -> Self {
        let servo = AnyServo::Bypass { axes, reason };
        let growth = [ThermalGrowth::default(); AXES_MAX];
        Built { servo, period_ns, machine_id: 0, growth, order: [None; AXES_MAX] }
    }

    pub(crate) fn start(&self, period_ns: u32) -> Result<Running, ResultCode> {
        if period_ns.abs_diff(self.period_ns) > self.period_ns / 1000 {
            return Err(ERROR_PERIOD);
        }
        Ok(match &self.servo {
            AnyServo::Three(servo) => Running::Three(servo.start()),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Four(servo) => Running::Four(servo.start()),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Five(servo) => Running::Five(servo.start()),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Six(servo) => Running::Six(servo.start()),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Bypass { axes: 4, reason } => Running::BypassFour(Bypass::new(*reason)),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Bypass { axes: 5, reason } => Running::BypassFive(Bypass::new(*reason)),
            #[cfg(all(feature = "rotary", not(feature = "three")))]
            AnyServo::Bypass { axes: 6, reason } => Running::BypassSix(Bypass::new(*reason)),
            AnyServo::Bypass { reason, .. } => Running::BypassThree(Bypass::new(*reason)),
        })
    }

    /// Slot of an axis; `None` if the step has no such axis.
    pub(crate) fn slot(&self, axis: Axis) -> Option<usize> {
        self.order.iter().position(|own| *own == Some(axis))
    }

    /// Growth of an axis at a temperature above the reference; `None` if either is invalid.
    pub(crate) fn growth(&self, axis: usize, kelvin: f64) -> Option<ThermalLine<Real>> {
        let growth = self.growth.get(axis).filter(|_| axis < self.servo.axes() && kelvin.is_finite())?;
        ThermalLine::for_axis(growth, kelvin)
    }
}

/// A measure for any number of axes.
#[cfg(all(feature = "rotary", not(feature = "three")))]
pub(crate) trait AnyMeasure:
    Measure<Real, CorePosition, 3>
    + Measure<Real, CorePosition, 4>
    + Measure<Real, CorePosition, 5>
    + Measure<Real, CorePosition, 6>
{
}
#[cfg(all(feature = "rotary", not(feature = "three")))]
impl<M> AnyMeasure for M where
    M: Measure<Real, CorePosition, 3>
        + Measure<Real, CorePosition, 4>
        + Measure<Real, CorePosition, 5>
        + Measure<Real, CorePosition, 6>
{
}
/// A measure for three axes.
#[cfg(not(all(feature = "rotary", not(feature = "three"))))]
pub(crate) trait AnyMeasure: Measure<Real, CorePosition, 3> {}
#[cfg(not(all(feature = "rotary", not(feature = "three"))))]
impl<M> AnyMeasure for M where M: Measure<Real, CorePosition, 3> {}

/// Runs one cycle of a loop and a state that belong together.
#[inline(always)]
pub(crate) fn cycle(
    built: &Built,
    running: &mut Running,
    input: &Input,
    measure: impl AnyMeasure,
    gauge: &mut Riding<'_>,
) -> Result<Output, ResultCode> {
    if cfg!(not(feature = "fast")) {
        let mut measure = measure;
        return shared_cycle(built, running, input, &mut measure, gauge);
    }
    with_servo!(built, running,
        servo(servo, state) => Output::of(&servo.step(state, &input.to_core(), measure, gauge)),
        bypass(bypass) => {
            gauge.measure_on();
            Output::of(&bypass.step::<Real>(&input.to_core()))
        }
    )
}

/// [`cycle`] for a library in which one copy of the step serves every measure.
#[inline(never)]
fn shared_cycle(
    built: &Built,
    running: &mut Running,
    input: &Input,
    measure: &mut dyn AnyMeasure,
    gauge: &mut Riding<'_>,
) -> Result<Output, ResultCode> {
    with_servo!(built, running,
        servo(servo, state) => shared_step(servo, state, input, measure, gauge),
        bypass(bypass) => {
            gauge.measure_on();
            Output::of(&bypass.step::<Real>(&input.to_core()))
        }
    )
}

fn shared_step<const N: usize>(
    servo: &Servo<N>,
    state: &mut ServoState<N>,
    input: &Input,
    measure: &mut dyn Measure<Real, CorePosition, N>,
    gauge: &mut Riding<'_>,
) -> Output {
    Output::of(&servo.step(state, &input.to_core(), measure, gauge))
}
