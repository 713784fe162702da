//! The result for an identified axis, as printed.

use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis::machine::Twist;
use trueaxis_evaluation::identify::Readings;
use trueaxis_metrology::identification::{Identified, Location};
use trueaxis_tables::text::counted;

/// The JSON document.
#[derive(Serialize)]
pub(crate) struct Document {
    pub(crate) axis: String,
    pub(crate) set_ups: Vec<SetUp>,
    pub(crate) angles: Vec<Angle>,
    /// Standard deviation of one reading, from the residuals of all angles.
    pub(crate) sigma_um: f64,
    /// Root mean square of the standard errors over the angles.
    pub(crate) standard_errors: Map<String, Value>,
    pub(crate) degrees_of_freedom: usize,
    /// Whether location errors are among the errors: "inside" or "removed".
    pub(crate) location: &'static str,
    /// Combinations that no reading sees and that the convention of free offsets fixes; 0 without.
    pub(crate) null_space: usize,
    pub(crate) warnings: Vec<String>,
}

#[derive(Serialize)]
pub(crate) struct SetUp {
    pub(crate) l_mm: f64,
    pub(crate) h_mm: f64,
    /// With free offsets: the offset found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) offset_um: Option<[f64; 3]>,
}

#[derive(Serialize)]
pub(crate) struct Angle {
    pub(crate) angle_deg: f64,
    #[serde(flatten)]
    errors: Map<String, Value>,
    pub(crate) residual_um: f64,
    pub(crate) condition: f64,
    pub(crate) rank: u8,
    standard_errors: Map<String, Value>,
    /// µm and µrad.
    #[serde(skip)]
    pub(crate) values: [f64; 6],
    #[serde(skip)]
    pub(crate) deviations: [f64; 6],
}

/// Names of the six errors as columns of a table, `EXC_um` to `ECC_urad`.
pub(crate) fn names(axis: Axis) -> [String; 6] {
    Axis::ALL.map(|moved| {
        let unit = if moved.is_rotary() { "urad" } else { "um" };
        format!("E{}{}_{unit}", moved.letter(), axis.letter())
    })
}

/// mm and rad to µm and µrad.
pub(crate) fn micro(twist: &Twist) -> [f64; 6] {
    let [x, y, z, a, b, c] = *twist;
    [1e3 * x, 1e3 * y, 1e3 * z, 1e6 * a, 1e6 * b, 1e6 * c]
}

fn named(axis: Axis, values: [f64; 6]) -> Map<String, Value> {
    names(axis).iter().zip(values).map(|(name, value)| (name.to_lowercase(), Value::from(value))).collect()
}

impl Document {
    pub(super) fn new(readings: &Readings, found: &Identified, warnings: Vec<String>) -> Document {
        let count = found.angles.len().max(1) as f64;
        let mean = std::array::from_fn(|i| {
            let squares = found.angles.iter().map(|angle| micro(&angle.standard_errors)[i].powi(2));
            (squares.sum::<f64>() / count).sqrt()
        });
        let set_ups = readings.balls.iter().enumerate().map(|(s, ball)| SetUp {
            l_mm: ball.vertical_mm,
            h_mm: ball.horizontal_mm,
            offset_um: found.offsets_mm.get(s).map(|offset| offset.map(|value| 1e3 * value)),
        });
        let angles = readings.angles_deg.iter().zip(&found.angles).map(|(&angle_deg, angle)| {
            let (values, deviations) = (micro(&angle.errors), micro(&angle.standard_errors));
            Angle {
                angle_deg,
                errors: named(found.axis, values),
                residual_um: 1e3 * angle.residual_mm,
                condition: angle.condition,
                rank: angle.rank,
                standard_errors: named(found.axis, deviations),
                values,
                deviations,
            }
        });
        Document {
            axis: found.axis.letter().to_string(),
            set_ups: set_ups.collect(),
            angles: angles.collect(),
            sigma_um: 1e3 * found.sigma_mm,
            standard_errors: named(found.axis, mean),
            degrees_of_freedom: found.degrees_of_freedom,
            location: match found.location {
                Location::Inside => "inside",
                Location::Removed => "removed",
            },
            null_space: found.null_space,
            warnings,
        }
    }

    /// Meaning of the errors, in a sentence.
    pub(crate) fn location_sentence(&self) -> &'static str {
        match (self.location, self.axis.as_str()) {
            ("inside", _) => "inside: the errors contain the axis' location errors and the zero of the gauges",
            (_, "C") => "removed: EXC, EYC, EZC have no mean; constant angular errors are inside",
            _ => {
                "removed: the translations have no mean, and of the angular errors what turns with the axis is left out"
            }
        }
    }

    /// A table to read.
    pub(super) fn table(&self, axis: Axis) -> Result<String, std::fmt::Error> {
        let mut text = format!(
            "axis {}, {}, {}\n\n",
            self.axis,
            counted(self.set_ups.len(), "set-up"),
            counted(self.angles.len(), "angle")
        );
        write!(text, "{:>9}", "angle_deg")?;
        for name in names(axis) {
            write!(text, " {name:>9}")?;
        }
        writeln!(text, " {:>11} {:>9}", "residual_um", "condition")?;
        for angle in &self.angles {
            write!(text, "{:>9.3}", angle.angle_deg)?;
            for value in angle.values {
                write!(text, " {value:>9.3}")?;
            }
            writeln!(text, " {:>11.3} {:>9.2}", angle.residual_um, angle.condition)?;
        }
        write!(text, "{:>9}", "std. err.")?;
        for value in names(axis).iter().filter_map(|name| self.standard_errors.get(&name.to_lowercase())) {
            write!(text, " {:>9.3}", value.as_f64().unwrap_or(f64::NAN))?;
        }
        writeln!(text, "   (root mean square over the angles)\n")?;
        let worst = self.angles.iter().map(|angle| angle.condition).fold(0.0, f64::max);
        let rank = self.angles.iter().map(|angle| angle.rank).min().unwrap_or(0);
        writeln!(text, "sigma of a reading  {:.3} µm, {} degrees of freedom", self.sigma_um, self.degrees_of_freedom)?;
        writeln!(text, "rank                {rank} of 6 at every angle, condition number at most {worst:.2}")?;
        writeln!(text, "location errors     {}", self.location_sentence())?;
        for set_up in &self.set_ups {
            if let Some([x, y, z]) = set_up.offset_um {
                writeln!(text, "offset at L {} H {}: {x:.3}, {y:.3}, {z:.3} µm", set_up.l_mm, set_up.h_mm)?;
            }
        }
        for warning in &self.warnings {
            writeln!(text, "note: {warning}")?;
        }
        Ok(text)
    }
}
