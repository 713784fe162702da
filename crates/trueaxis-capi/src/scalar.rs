//! The two kinds of numbers that the interface is made of.

/// Scalar of the arithmetic: `double`, with `TRUEAXIS_SINGLE` `float`.
#[cfg(not(feature = "single"))]
pub type Real = f64;
/// Scalar of the arithmetic: `double`, with `TRUEAXIS_SINGLE` `float`.
#[cfg(feature = "single")]
pub type Real = f32;

/// Position of an axis: mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` 32-bit integers of 1e-6 mm = 1 nm
/// (1e-6 degrees).
#[cfg(not(feature = "single"))]
pub type Position = f64;
/// Position of an axis: mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` 32-bit integers of 1e-6 mm = 1 nm
/// (1e-6 degrees).
#[cfg(feature = "single")]
pub type Position = i32;
