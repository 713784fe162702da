//! Parts that a build of the library may leave out.

use crate::result::{ERROR_LEFT_OUT, ResultCode};

/// A part of the library: its feature, its number in errors (1 to 6 as in the core), and whether this build includes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) name: &'static str,
    pub(crate) code: u8,
    is_built: bool,
}

pub(crate) const CURVES: Part =
    Part { name: "curves", code: trueaxis::Part::Curves as u8, is_built: cfg!(feature = "curves") };
pub(crate) const DYNAMIC: Part =
    Part { name: "dynamic", code: trueaxis::Part::Dynamic as u8, is_built: cfg!(feature = "dynamic") };
pub(crate) const GAUGE: Part =
    Part { name: "gauge", code: trueaxis::Part::Gauge as u8, is_built: cfg!(feature = "gauge") };
pub(crate) const TOOLPATH: Part = Part { name: "toolpath", code: 7, is_built: cfg!(feature = "toolpath") };
pub(crate) const GROWTH: Part = Part { name: "growth", code: 8, is_built: cfg!(feature = "growth") };

/// Refuses the functions of a part that this build leaves out. Called first in each of them, so that the remaining code
/// is not linked.
#[inline(always)]
pub(crate) const fn need(part: Part) -> Result<(), LeftOut> {
    if part.is_built { Ok(()) } else { Err(LeftOut(part)) }
}

/// A part that this build leaves out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeftOut(pub(crate) Part);

impl From<LeftOut> for ResultCode {
    fn from(_: LeftOut) -> Self {
        ERROR_LEFT_OUT
    }
}
