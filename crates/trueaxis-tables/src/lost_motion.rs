//! Lost motion of the axes, and the time and distance that its correction takes to ramp in.

use crate::Machine;
use std::fmt;
use trueaxis::check;
use trueaxis::limiter::ramp_in_s;
use trueaxis::machine::{Axis, AxisSettings, PeriodicSettings};

/// Longest time without a warning, s: friction disturbs a reversal for about as long.
pub(crate) const SWIFT_S: f64 = 5e-3;

/// Lost motion of an axis, and the ramp of its correction after a reversal.
///
/// For a rotary axis, read every mm as degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostMotion {
    /// The axis.
    pub axis: Axis,
    /// Largest |error in negative travel − error in positive travel|, backlash and periods included, mm.
    pub play: f64,
    /// Time in which the axis' limits allow it to be corrected, s.
    pub ramp_in_s: f64,
    /// Highest feed of the axis, mm/s.
    pub feed_per_s: f64,
    /// Distance travelled in that time at that feed, during which up to the whole play is uncorrected, mm.
    pub way: f64,
}

/// Every axis with lost motion.
pub fn lost_motion(machine: &Machine) -> Vec<LostMotion> {
    let of = |(own, _): (&AxisSettings, _)| {
        let [least, most] = check::lost_motion(own, machine.rows(own.axis));
        let within: f64 = machine.settings.periods_of(own.axis).map(PeriodicSettings::most_lost).sum();
        let play = least.abs().max(most.abs()) + within;
        let ramp_in_s = ramp_in_s(&own.limits, play);
        let (axis, feed_per_s) = (own.axis, own.max_feed_per_s);
        (play > 0.0).then_some(LostMotion { axis, play, ramp_in_s, feed_per_s, way: ramp_in_s * feed_per_s })
    };
    machine.axes().filter_map(of).collect()
}

impl fmt::Display for LostMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rotary = self.axis.is_rotary();
        let (play, micro) = if rotary { (self.play.to_radians() * 1e6, "µrad") } else { (self.play * 1e3, "µm") };
        let unit = if rotary { "deg" } else { "mm" };
        write!(
            f,
            "axis {}: lost motion of up to {play:.1} {micro} is corrected within {:.1} ms of a reversal, {:.2} {unit} at {} {unit}/s",
            self.axis.letter(),
            self.ramp_in_s * 1e3,
            self.way,
            (self.feed_per_s * 1e3).round() / 1e3
        )
    }
}
