//! Servo loops built from compiled tables, as a controller builds them.

use crate::error::{Result, SimError};
use self_cell::{MutBorrow, self_cell};
use trueaxis::compensation::requirement;
use trueaxis::tcomp::Tcomp;
use trueaxis::{Config, ConfigError, Input, Measure, Output, Position, Real, Ride, ServoLoop, State};
use trueaxis_tables::Machine;

/// A servo loop's construction and its step, compiled here once for three slots and once for six. Programs that simulate
/// call these instead of compiling their own copies.
///
/// A machine without rotary axes runs on three slots. Any other runs on six, some of them spare
/// ([`AxisOrder::with_spare_slots`](trueaxis::machine::AxisOrder::with_spare_slots)): its outputs are those of a step with as
/// many slots as it has axes, to the bit.
pub trait Compiled<const N: usize> {
    /// [`ServoLoop::load`], with spare slots.
    ///
    /// # Errors
    /// As [`ServoLoop::load`].
    fn load<'a>(
        tcomp: &Tcomp<'a>,
        period_ns: u32,
        memory: &'a mut [f64],
    ) -> core::result::Result<ServoLoop<'a, f64, f64, N>, ConfigError>;

    /// [`ServoLoop::step`], whatever is measured and with or without a gauge.
    fn step(
        servo: &ServoLoop<'_, f64, f64, N>,
        state: &mut State<f64, f64, N>,
        input: &Input<f64, N>,
        measure: &mut dyn Measure<f64, f64, N>,
        gauge: &mut dyn Ride<f64>,
    ) -> Output<f64, f64, N>;
}

/// Three or six slots.
#[derive(Clone, Copy, Debug)]
pub struct Axes;

/// Builds the servo loop of a machine from its compiled tables and lends it out.
///
/// # Errors
/// The tables do not compile or build.
pub fn with_loop<const N: usize, T, E: From<SimError>>(
    machine: &Machine,
    period_ns: u32,
    user: impl FnOnce(&ServoLoop<'_, f64, f64, N>) -> Result<T, E>,
) -> Result<T, E>
where
    Axes: Compiled<N>,
{
    let bytes = trueaxis_tables::compile(machine).map_err(SimError::from)?;
    let tcomp = Tcomp::parse(&bytes).map_err(SimError::from)?;
    let mut memory = vec![0.0; tcomp.requirement()];
    let servo = Axes::load(&tcomp, period_ns, &mut memory).map_err(SimError::from)?;
    user(&servo)
}

/// Builds the servo loop of compiled tables, in any scalar, and lends it out.
///
/// # Errors
/// The tables do not build.
pub fn with_tables<R: Real, P: Position, const N: usize, T, E: From<SimError>>(
    tcomp: &Tcomp<'_>,
    period_ns: u32,
    user: impl FnOnce(&ServoLoop<'_, R, P, N>) -> Result<T, E>,
) -> Result<T, E> {
    let mut memory = vec![R::ZERO; tcomp.requirement()];
    let servo = ServoLoop::load(tcomp, period_ns, &mut memory).map_err(SimError::from)?;
    user(&servo)
}

/// One servo cycle, using the compiled copy of the step with `N` slots.
pub fn step<const N: usize>(
    servo: &ServoLoop<'_, f64, f64, N>,
    state: &mut State<f64, f64, N>,
    input: &Input<f64, N>,
    measure: &mut dyn Measure<f64, f64, N>,
    gauge: &mut dyn Ride<f64>,
) -> Output<f64, f64, N>
where
    Axes: Compiled<N>,
{
    Axes::step(servo, state, input, measure, gauge)
}

/// A servo loop together with the file and the memory that it uses, so that a run can own both.
pub(crate) trait Owned<const N: usize>: Send + Sized {
    /// Compiles and builds the tables of a machine.
    fn build(machine: &Machine, period_ns: u32) -> Result<Self>;
    /// The loop.
    fn servo(&self) -> &ServoLoop<'_, f64, f64, N>;
}

/// Data that a loop reads in its cycles: the compiled file, which keeps its grids, and the memory in which the loop is built.
pub(crate) struct Lent {
    bytes: Vec<u8>,
    memory: MutBorrow<Vec<f64>>,
}

/// `self_cell` does not support generic cells: one for each number of slots.
macro_rules! owned {
    ($module:ident, $axes:literal) => {
        pub(crate) mod $module {
            use super::*;

            type Loop<'a> = ServoLoop<'a, f64, f64, $axes>;

            impl Compiled<$axes> for Axes {
                fn load<'a>(
                    tcomp: &Tcomp<'a>,
                    period_ns: u32,
                    memory: &'a mut [f64],
                ) -> core::result::Result<Loop<'a>, ConfigError> {
                    Config::of(tcomp, period_ns).build_with_spare_slots(tcomp.rows(), memory)
                }

                fn step(
                    servo: &Loop<'_>,
                    state: &mut State<f64, f64, $axes>,
                    input: &Input<f64, $axes>,
                    measure: &mut dyn Measure<f64, f64, $axes>,
                    gauge: &mut dyn Ride<f64>,
                ) -> Output<f64, f64, $axes> {
                    servo.step(state, input, measure, gauge)
                }
            }

            self_cell! {
                pub(crate) struct Cell {
                    owner: Lent,
                    #[covariant]
                    dependent: Loop,
                }
            }

            impl Owned<$axes> for Cell {
                fn build(machine: &Machine, period_ns: u32) -> Result<Self> {
                    let bytes = trueaxis_tables::compile(machine)?;
                    let memory = vec![0.0; requirement(&machine.settings, |axis| machine.rows(axis))];
                    Cell::try_new(Lent { bytes, memory: MutBorrow::new(memory) }, |lent| {
                        let tcomp = Tcomp::parse(&lent.bytes)?;
                        Axes::load(&tcomp, period_ns, lent.memory.borrow_mut()).map_err(SimError::from)
                    })
                }

                fn servo(&self) -> &ServoLoop<'_, f64, f64, $axes> {
                    self.borrow_dependent()
                }
            }
        }
    };
}

owned!(three, 3);
owned!(six, 6);
