//! Host simulator of compensated servo cycles.

pub mod latency;
pub mod motion;
pub mod pace;
pub mod plant;
pub mod program;
pub mod report;
