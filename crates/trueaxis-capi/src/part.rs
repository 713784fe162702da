//! Parts that a build of the library may leave out.

use crate::result::{ERROR_LEFT_OUT, ResultCode};

/// A part of the library: its feature, its number in errors (1 to 6 as in the core), and whether this build includes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) name: &'static str,
    pub(crate) code: u8,
    is_built: bool,
}

pub(crate) const CURVES: Part = of_core(trueaxis::Part::Curves, cfg!(feature = "curves"));
pub(crate) const DYNAMIC: Part = of_core(trueaxis::Part::Dynamic, cfg!(feature = "dynamic"));
pub(crate) const GAUGE: Part = of_core(trueaxis::Part::Gauge, cfg!(feature = "gauge"));
pub(crate) const TOOLPATH: Part = Part { name: "toolpath", code: 7, is_built: cfg!(feature = "toolpath") };
pub(crate) const GROWTH: Part = Part { name: "growth", code: 8, is_built: cfg!(feature = "growth") };

/// A part of the core.
const fn of_core(part: trueaxis::Part, is_built: bool) -> Part {
    Part { name: part.name(), code: part as u8, is_built }
}

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
