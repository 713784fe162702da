//! The servo cycle with a gauge riding along.

use crate::Real;
use crate::cycle::{Input, Output, Reference};
use crate::gauge::{Gauge, GaugeState, Pair, either, pair};
use crate::opaque;
use crate::path::{self, Path};
use crate::pointer::{Sized32, check_sized, read_sized};
use crate::servo::{Built, Loop, Running, State};
use crate::status::{self, Status};
use trueaxis::GaugeRide;
use trueaxis::roundness::{Cycle, Probes as CoreProbes};

/// Readings of the gauge in a cycle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Probes {
    /// `sizeof(trueaxis_probes_t)`, set by the caller once.
    pub size: u32,
    /// Counts of the spindle's encoder, wrapping.
    pub spindle: i32,
    /// Counts latched by an index pulse since the last cycle (without a latch the counts of this cycle), if `has_index`.
    pub index: i32,
    /// Counts of the arm's encoder, 0 where the arm points along the line of centres; unused without an arm.
    pub arm: i32,
    /// Raw values of the three probes, in the unit of their gain.
    pub readings: [Real; 3],
    /// Not 0: an index pulse came since the last cycle.
    pub has_index: u8,
    /// Not 0: another workpiece; correction back to zero, evaluation begun anew.
    pub new_part: u8,
    /// Not 0: the wheel does not grind; measured all the same, but nothing is learnt for the infeed.
    pub idle: u8,
    /// Not looked at.
    pub reserved: [u8; 5],
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Probes {}

/// What the gauge gives back in a cycle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct GaugeCycle {
    /// `sizeof(trueaxis_gauge_cycle_t)`, set by the caller once; stays as it is.
    pub size: u32,
    /// `TRUEAXIS_GAUGE_…` bits: what this cycle met.
    pub flags: u16,
    /// 1: a revolution has just been evaluated.
    pub finished: u8,
    /// 0.
    pub reserved: u8,
    /// Infeed correction that was asked of its axis, mm in the axis' sense; it is part of `drive` as far as the limits
    /// allow.
    pub infeed: Real,
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for GaugeCycle {}

/// `trueaxis_step` with a gauge of three probes riding along: some units of its work a cycle, its infeed correction added
/// to what the tables want of that axis, through the same limiter.
///
/// Arguments as there; `probes->size` and `cycle->size` must be set as well. While the step is not active, and in a bypass,
/// the gauge measures on but nothing is fed in. Real-time safe.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_NO_OUTPUT`.
///
/// # Safety
/// Pointers are null or point to what their types say; nobody else uses the states or writes any other of them meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_step_with_gauge(
    r#loop: *const Loop,
    state: *mut State,
    input: *const Input,
    path: *const Path,
    reference: *const Reference,
    gauge: *const Gauge,
    gauge_state: *mut GaugeState,
    probes: *const Probes,
    output: *mut Output,
    cycle: *mut GaugeCycle,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        unsafe {
            check_sized(output)?;
            check_sized(cycle)?;
        }
        // SAFETY: the caller's promise.
        let (input, probes) = unsafe { (read_sized(input)?, read_sized(probes)?) };
        // SAFETY: the caller's promise.
        let place = unsafe { path::place(path, reference) }?;
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        // SAFETY: the caller's promise.
        let gauge = unsafe { pair(gauge, gauge_state) }?;
        let (result, its) = ride(built, running, &input, &place, gauge, &probes.to_core())?;
        let its = GaugeCycle {
            size: size_of::<GaugeCycle>() as u32,
            flags: its.flags.0,
            finished: its.finished.into(),
            reserved: 0,
            infeed: its.infeed,
        };
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe {
            cycle.write(its);
            result.deliver(output)
        }
    };
    status::of(work())
}

impl Probes {
    fn to_core(self) -> CoreProbes<Real> {
        CoreProbes {
            readings: self.readings,
            spindle: self.spindle,
            index: (self.has_index != 0).then_some(self.index),
            arm: self.arm,
            new_part: self.new_part != 0,
            idle: self.idle != 0,
        }
    }
}

fn ride(
    built: &Built,
    running: &mut Running,
    input: &Input,
    place: &path::Place<'_>,
    gauge: Pair<'_>,
    probes: &CoreProbes<Real>,
) -> Result<(Output, Cycle<Real>), Status> {
    either!(gauge, gauge, gauge_state => {
        crate::servo::with_servo!(built, running,
            servo(loop_, state) => {
                let mut ride = GaugeRide::new(gauge, gauge_state, probes);
                let on = place.path.on(place.reference);
                let output = loop_.step(state, &input.to_core(), on, &mut ride);
                (Output::of(&output), ride.cycle())
            },
            bypass(state) => {
                let cycle = gauge.update(gauge_state, probes, trueaxis::roundness::Followed::Not);
                (Output::of(&state.step::<Real>(&input.to_core())), Cycle { infeed: 0.0, ..cycle })
            }
        )
    })
}
