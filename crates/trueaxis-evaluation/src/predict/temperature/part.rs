//! `[temperature]` of a part's file.

use crate::calibrate::ranges::number;
use trueaxis_tables::Section;
use trueaxis_tables::error::FileError;

/// Temperature at which parts are measured, °C (ISO 1).
const MEASURED_C: f64 = 20.0;
/// Temperatures of a machine or a part, °C.
const CELSIUS: [f64; 2] = [-20.0, 200.0];

/// Temperatures while a part is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartTemperature {
    /// Of the machine, °C, the same at all of its sensors and constant.
    pub machine_c: Option<f64>,
    /// Of the part.
    pub part: Option<Expansion>,
}

/// Temperature and expansion of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expansion {
    /// Temperature while it is cut, °C.
    pub celsius: f64,
    /// Coefficient of expansion, 1/K.
    pub per_k: f64,
    /// Standard uncertainty of the temperature, K; `None`: not stated.
    pub u_k: Option<f64>,
}

impl Expansion {
    /// Length of the part when it is measured, as a share of its length when it is cut.
    pub(crate) fn measured(&self) -> f64 {
        1.0 / (1.0 + self.per_k * (self.celsius - MEASURED_C))
    }
}

/// # Errors
/// Values out of their range, one of the part's temperature and expansion without the other, unknown keys.
pub(in crate::predict) fn read_temperature(section: Section<'_>) -> Result<PartTemperature, FileError> {
    let machine_c = number(&section, "machine_c", CELSIUS, " degrees Celsius")?;
    let celsius = number(&section, "part_c", CELSIUS, " degrees Celsius")?;
    let expansion = number(&section, "part_expansion_um_per_m_k", [0.0, 200.0], " um/(m K)")?;
    let u_k = number(&section, "part_u_k", [0.0, 100.0], " K")?;
    let part = match (celsius, expansion) {
        (Some(celsius), Some(expansion)) => Some(Expansion { celsius, per_k: 1e-6 * expansion, u_k }),
        (None, Some(_)) => return Err(section.missing_here("part_c", "the part's temperature while it is cut")),
        (Some(_), None) => {
            let needed = "the expansion of the part's material, um/(m K)";
            return Err(section.missing_here("part_expansion_um_per_m_k", needed));
        }
        (None, None) if u_k.is_some() => {
            return Err(section.missing_here("part_c", "the part's temperature while it is cut"));
        }
        (None, None) => None,
    };
    if machine_c.is_none() && part.is_none() {
        return Err(section.missing_here("machine_c", "machine_c, or part_c with part_expansion_um_per_m_k"));
    }
    section.finish(None)?;
    Ok(PartTemperature { machine_c, part })
}
