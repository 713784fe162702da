//! Mathematics of trueaxis for the bench, not for the servo cycle.
//!
//! - [`identification`]: the six errors of a rotary axis from a measured ball. The part for a single angle needs neither the
//!   feature `std` nor an allocator and may run on the controller.
//! - [`helicoid`]: involute helicoid, gear data, and the five axis positions that align a tool with its normal.
//! - [`friction`]: friction and drive figures of an axis from recorded circles.
//! - [`accuracy`]: accuracy and repeatability of positioning after ISO 230-2.
//! - [`ballbar`]: circular test after ISO 230-4, with its causes separated.
//! - [`diagonal`]: diagonal and step-diagonal tests after ISO 230-6, squareness and scales.
//! - [`drift`]: ranges of a drift over stated periods (ISO 230-3); [`sphere`]: the least-squares sphere.
//! - [`linear_fit`]: least squares with rank and inseparable unknowns.
//! - [`periodic`]: errors that repeat within the pitch of a screw, a motor or a gear, apart from the slow error.
//! - [`volumetric`]: the 21 errors of three axes from points measured throughout the volume.
//! - [`thermal`]: growth of the axes from a recorded warm-up after ISO 230-3.
//! - [`uncertainty`]: uncertainty of a point and of ISO 230-2 figures; factors, intervals, decisions.
//! - [`calibration`]: terms of a machine from probe touches on artefacts of known size.
//! - [`cores`]: parallel iterators on multi-core hosts; [`order`]: sorting by a number.
//! - [`learning`]: a correction over path length, learned from part to part.
//! - [`circles`]: exact reference circles (LSC, MZC, MIC, MCC); [`planes`]: the exact minimum zone of a plane.
//! - [`separation`]: roundness and motion of the centre from recorded probe readings; [`spindle`]: error motion of a spindle
//!   over its revolutions; [`pair_search`]: the best slots for three probes; [`probe_places`]: the best places
//!   of three to six.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "std"))]
extern crate std;

#[cfg(feature = "std")]
pub mod accuracy;
#[cfg(feature = "std")]
pub mod ballbar;
#[cfg(feature = "std")]
pub mod calibration;
#[cfg(feature = "std")]
pub mod circles;
#[cfg(feature = "std")]
pub mod cores;
#[cfg(feature = "std")]
pub mod diagonal;
#[cfg(feature = "std")]
pub mod drift;
pub mod error;
#[cfg(feature = "std")]
pub mod friction;
pub mod helicoid;
pub mod identification;
#[cfg(feature = "std")]
pub mod learning;
#[cfg(feature = "std")]
pub mod linear_fit;
#[cfg(feature = "std")]
pub mod order;
#[cfg(feature = "std")]
pub mod pair_search;
#[cfg(feature = "std")]
pub mod periodic;
#[cfg(feature = "std")]
pub mod planes;
#[cfg(feature = "std")]
pub mod probe_places;
#[cfg(feature = "separation")]
pub mod separation;
#[cfg(feature = "std")]
pub mod sphere;
#[cfg(feature = "std")]
pub mod spindle;
#[cfg(feature = "std")]
pub mod thermal;
#[cfg(feature = "std")]
pub mod uncertainty;
#[cfg(feature = "std")]
pub mod volumetric;

/// The README's example.
#[cfg(all(doctest, feature = "std"))]
#[doc = include_str!("../README.md")]
struct Readme;
