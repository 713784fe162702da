//! The bench mathematics, compared with independent values.

mod ballbar;
mod calibration;
#[cfg(feature = "std")]
mod circles;
#[cfg(feature = "std")]
mod circles_nist;
mod friction;
#[cfg(feature = "std")]
mod limacon;
#[cfg(feature = "std")]
mod periodic;
#[cfg(feature = "std")]
mod planes;
mod plant;
mod resonance;
mod thermal;
mod uncertainty;
