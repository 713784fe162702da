//! The evaluations, compared with independent values.

#[cfg(feature = "simulated")]
mod angular;
mod correlation;
mod covariance;
mod coverage;
mod diagonal;
mod field;
mod helicoid;
#[cfg(feature = "simulated")]
mod hour;
mod lines;
mod plane;
#[cfg(feature = "simulated")]
mod plate_on_edge;
mod points;
#[cfg(feature = "simulated")]
mod predict;
mod r_test;
#[cfg(feature = "simulated")]
mod self_calibration;
mod shop_tests;
mod shown_types;
