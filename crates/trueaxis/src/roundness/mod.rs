//! Roundness and spindle error, separated by three probes while the servo loop runs.
//!
//! ```text
//! probes ──────┐
//! spindle, arm ┴─► counter ─► resample ─► one revolution ─► transform, 1/G, inverse ─► profile ─► harmonics, LSC
//!                  counts      to θ        (the one before     in slices of a fixed   └► R_X, R_Y ─► spindle error
//!                  to angles   θ = α + β    is worked on)      size, some a cycle    └► infeed of the next revolutions
//! ```
//!
//! Three displacement probes measure a turning workpiece from angles φ1 = 0, φ2, φ2 + φ3. Each reads the profile r under it
//! and the motion of the workpiece's centre:
//!
//! ```text
//! h1(θ) = r(θ)           + R_Y cos β            + R_X sin β
//! h2(θ) = r(θ + φ2)      + R_Y cos(φ2 + β)      + R_X sin(φ2 + β)
//! h3(θ) = r(θ + φ2 + φ3) + R_Y cos(φ2 + φ3 + β) + R_X sin(φ2 + φ3 + β)
//! ```
//!
//! Weighted as in `Gain` (`angles.rs`), their sum does not contain the centre's motion; divided by G in the frequency
//! domain it is the profile; two readings minus the profile give the motion:
//!
//! ```text
//! R_X = [cos β (h2 − r(θ+φ2)) − cos(φ2+β) (h1 − r(θ))] / sin φ2
//! R_Y = [sin(φ2+β) (h1 − r(θ)) − sin β (h2 − r(θ+φ2))] / sin φ2
//! ```
//!
//! Y lies along probe 1 at β = 0. Lengths are in µm here, angles at the interface in degrees.
//!
//! [`Gauge`] is the immutable half, built once; [`GaugeState`] is the mutable half. [`Gauge::update`] processes a cycle's
//! readings in bounded time and evaluates one revolution while the next one is sampled. A revolution with any fault is
//! discarded whole ([`GaugeFlags`]); one that ends before the previous work is finished is skipped whole; both are counted.
//!
//! # Example
//!
//! ```
//! use trueaxis::roundness::{Followed, Gauge, Probes};
//!
//! # use trueaxis::roundness::{GaugeSettings, ProbeAngles};
//! # let settings = GaugeSettings::with_defaults(256, ProbeAngles::Slots { p: 44, q: 57 }, 1 << 20);
//! # struct Tables(GaugeSettings);
//! # impl Tables {
//! #     fn gauge(&self, period_ns: u32) -> Result<Option<Gauge<f32, 256>>, trueaxis::ConfigError> {
//! #         Gauge::build(&self.0, period_ns).map(Some)
//! #     }
//! # }
//! # let tables = Tables(settings);
//! // `tables` is a `Tcomp`.
//! let gauge: Gauge<f32, 256> = tables.gauge(100_000)?.expect("the machine has a gauge");
//! let mut state = gauge.start();
//!
//! // From here on the servo interrupt, or ServoLoop::step with a GaugeRide:
//! for count in (0..4 << 20).step_by(500) {
//!     let turned = count >> 20 != (count - 500) >> 20;
//!     let index = turned.then_some(count & !((1 << 20) - 1));
//!     let probes = Probes { readings: [0.4, 0.4, 0.4], spindle: count, index, ..Probes::default() };
//!     let cycle = gauge.update(&mut state, &probes, Followed::Whole);
//!     if cycle.finished {
//!         let of = state.latest().unwrap();
//!         assert!(of.flags.is_empty() && of.peak_to_valley_um < 1e-4);
//!     }
//! }
//! # assert_eq!(state.counts().evaluated, 2); // of four turns: up to the first index, two whole ones, one in work
//! # Ok::<(), trueaxis::ConfigError>(())
//! ```
//!
//! Source: Tian Y., Li M., CN1927535 (arm and separation; R_Y corrected here: the published formula does not solve the
//! equations); ISO 12181-1, ISO 16610-21 (roundness, filter); ISO 230-7 (spindle).

mod angles;
mod arm;
mod counter;
#[cfg(not(feature = "bench"))]
mod filter;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod filter;
mod flags;
mod gauge;
mod infeed;
mod motion;
mod plan;
mod resample;
mod sampling;
mod settings;
mod state;
mod tasks;
mod transform;
mod work;

pub use flags::GaugeFlags;
pub use gauge::Gauge;
pub use motion::ErrorMotion;
pub use state::GaugeState;
pub use work::HARMONICS;

bench!(use angles::{Band, Gain, ProbeAngles});
bench!(use arm::{Arm, arm_angle});
bench!(use settings::{
    ArmSettings, FEWEST_POINTS, GaugeSettings, INFEED_NOISE_GAIN_LIMIT, InfeedSettings, MOST_COUNTS, MOST_POINTS,
    NOISE_GAIN_LIMIT, ProbeSettings, SpindleEncoder, gain_limit,
});
bench!(use state::Counts);

/// Readings in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Probes<R> {
    /// Raw values of the three probes, in the units of their gains.
    pub readings: [R; 3],
    /// Counts of the spindle encoder, wrapping.
    pub spindle: i32,
    /// Counts latched by an index pulse since the last cycle; if the hardware has no latch, the counts of this cycle.
    pub index: Option<i32>,
    /// Counts of the arm's encoder, 0 where the arm points along the line of centres, within ±90°; unused without an arm.
    pub arm: i32,
    /// Another workpiece: returns the correction to zero (through the limiter) and restarts the evaluation of the spindle.
    pub new_part: bool,
    /// The wheel is not grinding: the gauge still measures, but does not update the infeed.
    pub idle: bool,
}

/// How far the drive followed the infeed of the previous cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Followed {
    /// In full.
    #[default]
    Whole,
    /// As far as the axis's limits permitted.
    Limited,
    /// Not at all: corrections are switched off, frozen or held.
    Not,
}

/// Results of one revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Evaluation<R> {
    /// Number of the revolution, counting those sampled whole from 1, wrapping.
    pub revolution: u32,
    /// Events of this revolution.
    pub flags: GaugeFlags,
    /// Peak-to-valley roundness about the least-squares circle, after the filter (if any), µm.
    pub peak_to_valley_um: R,
    /// Error motion along X (across probe 1), over the last full window.
    pub x: ErrorMotion<R>,
    /// Error motion along Y (along probe 1), over the last full window.
    pub y: ErrorMotion<R>,
    /// Revolutions in that window; 0 until one is full.
    pub revolutions: u16,
}

/// Result of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(not(feature = "bench"), non_exhaustive)]
pub struct Cycle<R> {
    /// Infeed correction, mm in the sense of its axis; 0 without an infeed axis, or while θ is unknown.
    pub infeed: R,
    /// Events of this cycle.
    pub flags: GaugeFlags,
    /// Whether a revolution has just been evaluated.
    pub finished: bool,
}

#[cfg(test)]
mod tests;
