//! Tables and plots of the errors of a rotary axis.

use super::{IdentificationDocument, names};
use crate::shown::{Cell, Curve, EXPANDED, Look, Plot, Shown, Table, Uncertainty, half_width, unit};
use serde_json::Value;
use trueaxis::Axis;
use trueaxis_report::BARS;
use trueaxis_tables::text::counted;

/// Name and unit of the six errors.
fn errors(axis: Axis) -> [(String, &'static str); 6] {
    names(axis).map(|column| {
        let (name, of) = column.split_once('_').unwrap_or((&column, "um"));
        (name.to_owned(), unit(of))
    })
}

impl IdentificationDocument {
    /// Tables and plots of the errors of `axis`, the document's.
    pub fn shown(&self, axis: Axis) -> Shown {
        let freedom = self.degrees_of_freedom as f64;
        let all = names(axis).into_iter().zip(errors(axis)).enumerate().map(|(i, (column, (name, unit)))| {
            let values = || self.angles.iter().map(|angle| angle.values[i]);
            let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
            let expanded = self.expanded_uncertainties.get(&column.to_lowercase()).and_then(Value::as_f64);
            let uncertainty = Uncertainty::expanded(expanded);
            vec![name.into(), uncertainty.value(low), uncertainty.value(high), uncertainty.cell(), unit.into()]
        });
        let at = self.angles.iter().map(|angle| {
            let ends = [Cell::fixed(angle.residual_um, 3), Cell::fixed(angle.condition, 2)];
            let values = angle.values.map(|value| Cell::fixed(value, 3));
            std::iter::once(Cell::fixed(angle.angle_deg, 3)).chain(values).chain(ends).collect()
        });
        let columns = errors(axis).map(|(name, unit)| format!("{name}, {unit}"));
        let ends = ["residual, µm".into(), "condition number".into()];
        let head = std::iter::once(format!("{}, degrees", self.axis)).chain(columns).chain(ends);
        let offsets: Vec<Vec<Cell>> = self
            .set_ups
            .iter()
            .filter_map(|of| {
                let um = of.offset_um?.map(|um| Cell::fixed(um, 3));
                Some(std::iter::once(format!("L {} H {}", of.l_mm, of.h_mm).into()).chain(um).collect())
            })
            .collect();
        let worst = self.angles.iter().map(|angle| angle.condition).fold(0.0, f64::max);
        let rank = self.angles.iter().map(|angle| angle.rank).min().unwrap_or(0);
        let fit = [
            ("sigma of a reading, µm", Cell::number(self.sigma_um, 3)),
            ("degrees of freedom", Cell::count(self.degrees_of_freedom)),
            ("rank at every angle, of 6", Cell::count(rank.into())),
            ("condition number, at most", Cell::number(worst, 4)),
        ];
        let mut tables = vec![
            Table::new("Errors over all angles", ["error", "from", "to", EXPANDED, "unit"], all),
            Table::new("Errors at every angle", head, at),
            Table::figures("Fit", fit),
        ];
        if !offsets.is_empty() {
            tables.push(Table::new("Offsets of the set-ups", ["set-up, mm", "X, µm", "Y, µm", "Z, µm"], offsets));
        }
        Shown {
            title: format!("Errors of the axis {}", self.axis),
            summary: vec![
                counted(self.set_ups.len(), "set-up"),
                counted(self.angles.len(), "angle"),
                format!("location errors {}", self.location_sentence()),
            ],
            notes: self.warnings.clone(),
            tables,
            plots: [("Translations", 0), ("Rotations", 3)]
                .map(|(of, first)| self.plot(axis, of, first, freedom))
                .into(),
            ..Shown::default()
        }
    }

    /// Three errors over the angle, from the `first`.
    fn plot(&self, axis: Axis, section: &'static str, first: usize, freedom: f64) -> Plot {
        let own: Vec<(String, &'static str)> = errors(axis).into_iter().skip(first).take(3).collect();
        let of = |take: &dyn Fn(&super::Angle) -> f64| self.angles.iter().map(take).collect();
        let curves = own.iter().enumerate().map(|(c, (name, _))| Curve {
            expanded: of(&|angle| half_width(angle.deviations[first + c], freedom)),
            ..Curve::new(name.as_str(), c, of(&|angle| angle.values[first + c]))
        });
        Plot {
            section,
            title: format!(
                "{} over the angle",
                own.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
            ),
            x: (self.axis.clone(), "degrees"),
            y: ("error", own.first().map_or("", |(_, unit)| unit)),
            look: Look::Dotted,
            caption: BARS,
            at: of(&|angle| angle.angle_deg),
            curves: curves.collect(),
            ..Plot::default()
        }
    }
}
