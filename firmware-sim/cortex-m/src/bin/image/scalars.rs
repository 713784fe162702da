//! The image's scalar and position types.

use trueaxis::contour::Span;
use trueaxis::{Output, ServoLoop, State, roundness};

/// Axes of the step.
pub const AXES: usize = 3;
/// Points of a revolution.
pub const POINTS: usize = 1024;

#[cfg(not(feature = "double"))]
mod numbers {
    pub type Scalar = f32;
    pub type Place = trueaxis::Nanometres;
}
#[cfg(feature = "double")]
mod numbers {
    pub type Scalar = f64;
    pub type Place = f64;
}
pub use numbers::{Place, Scalar};

/// The step's immutable half.
pub type Loop = ServoLoop<'static, Scalar, Place, AXES>;
/// The step's state.
pub type LoopState = State<Scalar, Place, AXES>;
/// Output of a cycle.
pub type StepOutput = Output<Scalar, Place, AXES>;
/// A span of the path.
pub type Piece = Span<Scalar, Place>;
/// The gauge's immutable half.
pub type GaugePlan = roundness::Gauge<Scalar, POINTS>;
/// The gauge's state.
pub type GaugeState = roundness::GaugeState<Scalar, POINTS>;
/// The gauge's output of a cycle.
pub type GaugeCycle = roundness::Cycle<Scalar>;
