//! A gauge in a servo cycle.

use crate::Real;
use crate::gauge::{Gauge, GaugeState, Pair, pair};
use crate::part::{GAUGE, need};
use crate::pointer::{Sized32, read_sized};
use crate::result::ResultCode;
use trueaxis::roundness::{Cycle, Followed, Probes};

/// A gauge of three probes in a cycle: its readings, and its results in the members marked "Written".
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct GaugeRide {
    /// `sizeof(trueaxis_gauge_ride_t)`.
    pub size: u32,
    /// Counts of the spindle's encoder, wrapping.
    pub spindle: i32,
    /// With `has_index`: counts latched by the index pulse, or those of this cycle.
    pub index: i32,
    /// Counts of the arm's encoder, 0 where the arm points along the line of centres; ignored without an arm.
    pub arm: i32,
    /// The gauge.
    pub gauge: *const Gauge,
    /// Its state; one for 512 points cast from `trueaxis_gauge_state_512_t *`.
    pub state: *mut GaugeState,
    /// Raw values of the three probes, in the unit of their gain.
    pub readings: [Real; 3],
    /// Not 0: an index pulse has come since the last cycle.
    pub has_index: u8,
    /// Not 0: another workpiece; the infeed returns to zero and the evaluation restarts.
    pub new_part: u8,
    /// Not 0: the wheel does not grind; the gauge measures but does not update the infeed.
    pub idle: u8,
    /// Written: 1 if a revolution has just been evaluated.
    pub finished: u8,
    /// Written: `TRUEAXIS_GAUGE_…` bits of this cycle.
    pub flags: u16,
    /// Ignored.
    pub reserved: [u8; 2],
    /// Written: infeed requested of its axis, mm in the axis' sense; `drive` includes as much of it as the limits
    /// allow.
    pub infeed: Real,
}

// SAFETY: repr(C), `size` first, numbers and pointers only.
unsafe impl Sized32 for GaugeRide {}

impl GaugeRide {
    fn probes(&self) -> Probes<Real> {
        Probes {
            readings: self.readings,
            spindle: self.spindle,
            index: (self.has_index != 0).then_some(self.index),
            arm: self.arm,
            new_part: self.new_part != 0,
            idle: self.idle != 0,
        }
    }
}

/// The gauge in a cycle of the core's step, or no gauge.
///
/// It is called through a pointer stored in the gauge, so that a program that builds no gauge does not link it.
pub(crate) struct Riding<'a> {
    pair: Option<Pair<'a>>,
    probes: Probes<Real>,
    cycle: Cycle<Real>,
}

impl Riding<'_> {
    /// # Safety
    /// `gauge` is null, misaligned, or points to a ride whose pointers are null, misaligned, or point to whole objects;
    /// nobody else uses the state while this lives.
    #[inline(always)]
    pub(crate) unsafe fn of(gauge: *const GaugeRide) -> Result<Self, ResultCode> {
        if gauge.is_null() {
            return Ok(Riding { pair: None, probes: Probes::default(), cycle: Cycle::default() });
        }
        need(GAUGE)?;
        // SAFETY: the caller's promise.
        let ride = unsafe { read_sized(gauge) }?;
        // SAFETY: the caller's promise.
        let pair = unsafe { pair(ride.gauge, ride.state) }?;
        Ok(Riding { pair: Some(pair), probes: ride.probes(), cycle: Cycle::default() })
    }

    /// Runs a cycle in which the gauge measures but feeds nothing in.
    pub(crate) fn measure_on(&mut self) {
        self.update(Followed::Not);
        self.cycle.infeed = 0.0;
    }

    fn update(&mut self, followed: Followed) -> Real {
        if let Some(pair) = &mut self.pair {
            self.cycle = (pair.update())(pair, &self.probes, followed);
        }
        self.cycle.infeed
    }

    /// Writes the gauge's results to the caller's structure.
    ///
    /// # Safety
    /// `to` must be the pointer that was passed to [`Riding::of`], and writable.
    #[inline(always)]
    pub(crate) unsafe fn deliver(&self, to: *mut GaugeRide) {
        if self.pair.is_none() {
            return;
        }
        // SAFETY: not null, aligned, of the right size; writable by the caller's promise.
        unsafe {
            (&raw mut (*to).finished).write(self.cycle.finished.into());
            (&raw mut (*to).flags).write(self.cycle.flags.0);
            (&raw mut (*to).infeed).write(self.cycle.infeed);
        }
    }
}

impl trueaxis::Ride<Real> for &mut Riding<'_> {
    #[inline(always)]
    fn infeed_slot(&self) -> Option<usize> {
        self.pair.as_ref()?.infeed_slot()
    }
    #[inline(always)]
    fn update(&mut self, followed: Followed) -> Real {
        Riding::update(self, followed)
    }
}
