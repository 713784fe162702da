//! The two number types of the interface.

/// Scalar type: `double`, or `float` with `TRUEAXIS_SINGLE`.
#[cfg(not(feature = "single"))]
pub type Real = f64;
/// Scalar type: `double`, or `float` with `TRUEAXIS_SINGLE`.
#[cfg(feature = "single")]
pub type Real = f32;

/// Position of an axis: `double` in mm (rotary: degrees), or with `TRUEAXIS_SINGLE` `int32_t` in 1e-6 mm (1e-6
/// degrees).
#[cfg(not(feature = "single"))]
pub type Position = f64;
/// Position of an axis: `double` in mm (rotary: degrees), or with `TRUEAXIS_SINGLE` `int32_t` in 1e-6 mm (1e-6
/// degrees).
#[cfg(feature = "single")]
pub type Position = i32;
