//! The plugin's types as this build of the library uses them.

use crate::{Position, Real};
use trueaxis::{ServoLoop, State, contour};

/// A servo loop over tables in memory that the caller has promised to keep.
pub(crate) type Servo<const N: usize> = ServoLoop<'static, Real, CorePosition, N>;
/// Its state.
pub(crate) type ServoState<const N: usize> = State<Real, CorePosition, N>;
/// A span of a path.
pub(crate) type PathSpan = contour::Span<Real, CorePosition>;

/// A window of the last commands.
pub(crate) type Window = contour::CommandWindow<Real, CorePosition, { crate::COMMAND_WINDOW_SPANS }>;

/// The position type of the core behind [`Position`].
#[cfg(not(feature = "single"))]
pub(crate) type CorePosition = f64;
#[cfg(feature = "single")]
pub(crate) type CorePosition = trueaxis::Nanometres;

/// A position as the core wants it.
#[inline(always)]
pub(crate) fn to_core(position: Position) -> CorePosition {
    #[cfg(not(feature = "single"))]
    return position;
    #[cfg(feature = "single")]
    return trueaxis::Nanometres(position);
}

/// A position of the core as C wants it.
#[inline(always)]
pub(crate) fn from_core(position: CorePosition) -> Position {
    #[cfg(not(feature = "single"))]
    return position;
    #[cfg(feature = "single")]
    return position.0;
}
