//! State carried from cycle to cycle, and the output for the host.

#![deny(clippy::indexing_slicing)]

use crate::compensation::volumetric::TangentCache;
use crate::compensation::{Cells, NearGrids, Reversal, ThermalLine};
use crate::contour::PairState;
use crate::dynamic::DynamicState;
use crate::error::{ConfigError, Field};
use crate::output::OutputState;
use crate::position::Position;
use crate::real::Real;
use crate::sample::SampleState;
use crate::telemetry::{Record, Status};

/// Mutable half of the servo loop: the state carried from cycle to cycle.
///
/// The field order is the memory order: data that every cycle needs comes first, within reach of a Cortex-M's float load
/// (1020 bytes).
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct State<R, P: Position, const N: usize> {
    pub(super) sample: SampleState<R, P, N>,
    pub(super) output: OutputState<R, P, N>,
    pub(super) reversal: [Reversal<P>; N],
    pub(super) sequence: u32,
    /// Axes whose correction was limited in the last cycle, one bit each.
    pub(super) limited: u8,
    /// Whether the machine was homed in the last cycle.
    pub(super) homed: bool,
    pub(super) feet: PairState<R>,
    pub(super) cells: Cells<R, P>,
    pub(super) dynamic: DynamicState<R, P, N>,
    pub(super) thermal: [ThermalLine<R>; N],
    /// The machine's grids around command and feedback.
    pub(super) grids: NearGrids<R, P>,
    /// Tangents of the volumetric model.
    pub(super) poses: TangentCache<R, P, N>,
}

impl<R: Real, P: Position, const N: usize> State<R, P, N> {
    /// Sets the thermal growth of the axis in a slot (0 = X); takes effect in the next cycle, through the limiter.
    ///
    /// # Errors
    /// The step has no such slot; the state is then unchanged.
    pub fn set_thermal(&mut self, slot: usize, line: ThermalLine<R>) -> Result<(), ConfigError> {
        let Some(own) = self.thermal.get_mut(slot) else {
            return Err(ConfigError::new(Field::Axes, slot as f64, "a slot of the step"));
        };
        *own = line;
        self.cells.forget();
        self.poses.forget();
        Ok(())
    }

    /// Freezes the friction of all axes where it is, or lets it adapt again
    /// (`[axis.*.friction] adapt`).
    pub fn freeze_friction(&mut self, frozen: bool) {
        self.dynamic.freeze_friction(frozen);
    }

    /// Returns to the identified friction of all axes and forgets a fault of it; takes effect in the next cycle, through
    /// the limiter.
    pub fn reset_friction(&mut self) {
        self.dynamic.reset_friction();
    }
}

/// A stage of the step, in execution order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Stage {
    /// Command and readings checked ([`crate::sample`]).
    Sample,
    /// Errors looked up at command and feedback, inverse solved ([`crate::compensation`]).
    Compensation,
    /// Foot points of the estimated tip and of the plain encoder position ([`crate::contour`]).
    Contour,
    /// Correction rate-limited and applied, or output held ([`crate::limiter`]).
    Output,
    /// Record filled ([`crate::telemetry`]).
    Telemetry,
}

/// Output of a cycle.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Output<R: Real, P, const N: usize> {
    /// Corrected positions for the drives, mm (deg). Do not write them while [`Output::has_drive`] returns false.
    pub drive: [P; N],
    /// Feedback for the host, without the correction, so that the host sees no following error that does not exist.
    pub feedback: [P; N],
    /// The cycle's telemetry: correction, contour error, flags, fault.
    pub record: Record<R, P, N>,
}

impl<R: Real, P: Position, const N: usize> Output<R, P, N> {
    /// The output before the first cycle: nothing to write, nothing measured. Buffer for [`crate::ServoLoop::step_into`].
    #[inline(always)]
    pub fn none() -> Self {
        let zero = [P::default(); N];
        Output { drive: zero, feedback: zero, record: Record::none() }
    }

    /// Whether the output holds and the host must stop the machine.
    pub fn stop_requested(&self) -> bool {
        self.record.status.has(Status::STOP_REQUEST)
    }

    /// Whether `drive` may be written. It may not from a first cycle without a usable command until every axis has been
    /// read; from then on the step holds that position and accepts a reset near it. Until then leave the drives off or
    /// unchanged.
    pub fn has_drive(&self) -> bool {
        !self.record.status.has(Status::NO_OUTPUT)
    }
}
