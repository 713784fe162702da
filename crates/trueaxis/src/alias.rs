//! Type aliases for the usual scalars.

use crate::contour::PathBuffer;
use crate::{Nanometres, ServoLoop};

/// A servo loop on a host with double precision: positions in mm (degrees).
pub type HostServo<'a, const N: usize> = ServoLoop<'a, f64, f64, N>;
/// A path of at most `SPANS` spans for a [`HostServo`].
pub type HostPath<const SPANS: usize> = PathBuffer<f64, f64, SPANS>;

/// A servo loop on a microcontroller with single precision: positions in integers of 1e-6 mm (degrees).
///
/// ```
#[doc = include_str!("../examples/mcu.rs")]
/// ```
pub type McuServo<'a, const N: usize> = ServoLoop<'a, f32, Nanometres, N>;
