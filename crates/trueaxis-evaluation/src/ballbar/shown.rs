//! Tables of a circular test.

use super::{BallbarDocument, Test, Ways};
use crate::shown::{Cell, Quantity, Shown, Table, Uncertainty};
use serde_json::Value;

impl BallbarDocument {
    /// The figures of ISO 230-4, the values of all causes, their shares, the fit, and polar plots of the test.
    pub fn shown(&self, test: &Test) -> Shown {
        let um = |um: Option<f64>| Cell::number(um, 4);
        let row = |name: &str, both: Option<f64>, of: Ways| vec![name.into(), um(both), um(of.ccw), um(of.cw)];
        let only = |name: &str, of: Ways| vec![name.into(), "".into(), um(of.ccw), um(of.cw)];
        let iso = [
            row("G, circular deviation", self.g_b_um, self.g_um),
            only("F max", self.f_max_um),
            only("F min", self.f_min_um),
            vec!["H, hysteresis".into(), um(self.h_um), "".into(), "".into()],
        ];
        let shares = self
            .shares
            .iter()
            .map(|of| vec![of.cause.as_str().into(), Cell::percent(of.share), Cell::number(of.rms_um, 3)]);
        let fit = [
            ("sigma of a reading, µm", Cell::number(self.sigma_um, 3)),
            ("degrees of freedom", Cell::count(self.degrees_of_freedom)),
            ("condition number", Cell::number(self.condition, 4)),
        ];
        Shown {
            title: "Circular test".into(),
            summary: vec![
                format!("{} readings", self.readings),
                format!("plane {}, radius {} mm", self.plane, self.radius_mm),
            ],
            notes: self.warnings.clone(),
            tables: vec![
                Table::new("ISO 230-4", ["µm", "both directions", "counterclockwise", "clockwise"], iso),
                Table::quantities("Values of the causes", self.quantities()),
                Table::new("Causes in the order of their shares", ["cause", "share, %", "RMS, µm"], shares).bars(1),
                Table::figures("Fit", fit),
            ],
            polars: test.polars(),
            ..Shown::default()
        }
    }

    /// The value of every cause, and radius and centre of the circle.
    fn quantities(&self) -> Vec<Quantity> {
        let uncertainty = |key: &str, part: &dyn Fn(&Value) -> Option<f64>| {
            Uncertainty::expanded(self.expanded_uncertainties.get(key).and_then(part))
        };
        let whole = |key: &str| uncertainty(key, &Value::as_f64);
        let letters: Vec<char> = self.plane.chars().collect();
        let mismatch = letters.iter().map(char::to_string).collect::<Vec<_>>().join(" − ");
        let squareness = format!("squareness {}", self.squareness);
        let mut values = vec![
            Quantity::new(squareness, "µrad", self.squareness_urad, whole("squareness_urad")),
            Quantity::new(
                format!("scale mismatch {mismatch}"),
                "ppm",
                self.scale_mismatch_ppm,
                whole("scale_mismatch_ppm"),
            ),
            Quantity::new(
                format!("servo mismatch {mismatch}"),
                "µm",
                self.servo_mismatch_um,
                whole("servo_mismatch_um"),
            ),
        ];
        for (name, key, pair) in [
            ("backlash", "backlash_um", &self.backlash_um),
            ("reversal spikes", "reversal_um", &self.reversal_um),
            ("lateral play", "lateral_play_um", &self.lateral_play_um),
            ("straightness", "straightness_um", &self.straightness_um),
            ("cyclic error", "cyclic_um", &self.cyclic_um),
        ] {
            for letter in &letters {
                let own = letter.to_ascii_lowercase();
                let known = uncertainty(key, &|of| of.get(own.to_string())?.as_f64());
                values.push(Quantity::new(format!("{name} {letter}"), "µm", pair.get(&own).copied().flatten(), known));
            }
        }
        values.push(Quantity::new("radius", "µm", self.radius_deviation_um, whole("radius_deviation_um")));
        for (k, (letter, value)) in letters.iter().zip(self.centre_um).enumerate() {
            let known = uncertainty("centre_um", &|of| of.get(k)?.as_f64());
            values.push(Quantity::new(format!("centre {letter}"), "µm", value, known));
        }
        values
    }
}
