//! Configuration of a leg of the walk: axes, model, scalar, positions, measurement, gauge.

use std::fmt;
use trueaxis::machine::ErrorModel;

/// Scalar of the step and its position type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// f64, positions in mm as f64.
    Double,
    /// f32, positions in mm as f64.
    Mixed,
    /// f64, positions in whole nanometres.
    DoubleOnIntegers,
    /// f32, positions in whole nanometres.
    SingleOnIntegers,
}

/// Reference of the contour error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// No contour error is measured.
    Nothing,
    /// The programmed path.
    Path,
    /// The window of the latest commands.
    Window,
    /// Tip and tool direction on a path in workpiece coordinates; the tool is commanded on it now and then.
    ToolPath,
}

/// One of [`Combination::all`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Combination {
    /// Number of axes, 3 to 6.
    pub axes: usize,
    /// Error model.
    pub model: ErrorModel,
    /// Scalar and positions.
    pub numbers: Numbers,
    /// Reference of the contour error.
    pub measured: Measured,
    /// Whether a gauge of three probes runs.
    pub gauge: bool,
}

impl Combination {
    /// Every combination that the types allow: a tool path needs kinematics, which support at most two rotary axes.
    pub fn all() -> Vec<Combination> {
        let mut all = Vec::new();
        for numbers in [Numbers::Double, Numbers::SingleOnIntegers, Numbers::Mixed, Numbers::DoubleOnIntegers] {
            for axes in 3..=6 {
                for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
                    for measured in [Measured::Nothing, Measured::Path, Measured::Window, Measured::ToolPath] {
                        if measured == Measured::ToolPath && axes > 5 {
                            continue;
                        }
                        for gauge in [false, true] {
                            all.push(Combination { axes, model, numbers, measured, gauge });
                        }
                    }
                }
            }
        }
        all
    }
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model = if self.model == ErrorModel::Nine { "nine" } else { "volumetric" };
        let numbers = match self.numbers {
            Numbers::Double => "f64 on mm",
            Numbers::Mixed => "f32 on mm",
            Numbers::DoubleOnIntegers => "f64 on nm",
            Numbers::SingleOnIntegers => "f32 on nm",
        };
        let measured = match self.measured {
            Measured::Nothing => "nothing measured",
            Measured::Path => "path",
            Measured::Window => "command window",
            Measured::ToolPath => "tool path",
        };
        let gauge = if self.gauge { "gauge" } else { "no gauge" };
        write!(f, "{} axes, {model}, {numbers}, {measured}, {gauge}", self.axes)
    }
}
