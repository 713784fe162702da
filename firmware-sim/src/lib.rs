//! Host simulator of compensated servo cycles.

pub mod motion;
pub mod plant;
pub mod program;
pub mod report;
