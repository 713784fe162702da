//! The two kinds of numbers that the interface is made of.

/// Scalar: `double`, with `TRUEAXIS_SINGLE` `float`.
#[cfg(not(feature = "single"))]
pub type Real = f64;
/// Scalar: `double`, with `TRUEAXIS_SINGLE` `float`.
#[cfg(feature = "single")]
pub type Real = f32;

/// Position of an axis, mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` `int32_t` in 1e-6 mm (1e-6 degrees).
#[cfg(not(feature = "single"))]
pub type Position = f64;
/// Position of an axis, mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` `int32_t` in 1e-6 mm (1e-6 degrees).
#[cfg(feature = "single")]
pub type Position = i32;
