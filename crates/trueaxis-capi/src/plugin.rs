//! The plugin's types as this build of the library uses them.

use crate::{Position, Real};
use trueaxis::{ServoLoop, State, contour};

/// A servo loop over tables in memory that the caller has promised to keep.
pub(crate) type Servo<const N: usize> = ServoLoop<'static, Real, CorePosition, N>;
/// State of a servo loop.
pub(crate) type ServoState<const N: usize> = State<Real, CorePosition, N>;
/// A span of a path.
pub(crate) type PathSpan = contour::Span<Real, CorePosition>;

/// A window of the last commands.
pub(crate) type Window = contour::CommandWindow<Real, CorePosition, { crate::COMMAND_WINDOW_SPANS }>;

/// The core's position type, represented in C by [`Position`].
#[cfg(not(feature = "single"))]
pub(crate) type CorePosition = f64;
#[cfg(feature = "single")]
pub(crate) type CorePosition = trueaxis::Nanometres;

/// Converts a position to the core's type.
#[inline(always)]
pub(crate) fn to_core(position: Position) -> CorePosition {
    #[cfg(not(feature = "single"))]
    return position;
    #[cfg(feature = "single")]
    return trueaxis::Nanometres(position);
}

/// Converts a position of the core to the C type.
#[inline(always)]
pub(crate) fn from_core(position: CorePosition) -> Position {
    #[cfg(not(feature = "single"))]
    return position;
    #[cfg(feature = "single")]
    return position.0;
}
