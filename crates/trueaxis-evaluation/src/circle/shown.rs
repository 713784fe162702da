//! Table of the reference circles.

use super::{Evaluation, Fitted, Section};
use crate::shown::{Cell, Shown, Table};
use trueaxis_metrology::circles::ReferenceCircle;
use trueaxis_report::number::{decimals, significant};

/// Names of the circles, in the order of [`trueaxis_report::CIRCLES`].
pub(crate) const NAMES: [&str; 4] =
    ["LSC, least squares", "MZC, minimum zone", "MCC, minimum circumscribed", "MIC, maximum inscribed"];

impl Evaluation {
    /// The circles, each with the lines of the points that determine it; a note for every circle that does not exist.
    pub fn shown(&self) -> Shown {
        let mut summary = vec![format!("{} points", self.points.len()), "ISO 12181-1".into()];
        if let Section::Space(plane) = &self.section {
            let normal = plane.normal.map(|part| decimals(part, 6)).join(", ");
            let flat = significant(1e3 * plane.flatness_mm, 4);
            summary.push(format!("in the plane fitted to them: normal {normal}, flat within {flat} µm"));
        }
        let centre = self.section.letters().into_iter().map(|letter| format!("centre {letter}, mm"));
        let others = ["radius, mm", "zone, µm", "inner radius, mm", "outer radius, mm", "lines"].map(String::from);
        let header = std::iter::once("circle".to_owned()).chain(centre).chain(others);
        let none = |(name, circle): (&str, &Fitted)| Some(format!("{name}: none: {}", circle.as_ref().err()?));
        let circles = || NAMES.into_iter().zip(&self.circles);
        Shown {
            title: "Reference circles".into(),
            summary,
            notes: circles().filter_map(none).collect(),
            tables: vec![Table::new(
                format!("Reference circles of {} points, ISO 12181-1", self.points.len()),
                header,
                circles().map(|(name, circle)| self.row(name, circle.as_ref().ok())),
            )],
            ..Shown::default()
        }
    }

    fn row(&self, name: &str, circle: Option<&ReferenceCircle>) -> Vec<Cell> {
        let mm = |of: fn(&ReferenceCircle) -> f64| Cell::fixed(circle.map(of), 6);
        let centre = self.section.centre(circle.map_or([f64::NAN; 2], |circle| circle.centre));
        let contacts = circle.iter().flat_map(|circle| &circle.contacts);
        let lines: Vec<String> = contacts.filter_map(|at| self.lines.get(*at)).map(u32::to_string).collect();
        let zone = Cell::fixed(circle.map(|circle| 1e3 * circle.zone), 3);
        std::iter::once(name.into())
            .chain(centre.into_iter().map(|(_, mm)| Cell::fixed(mm, 6)))
            .chain([mm(|of| of.radius), zone, mm(|of| of.inner), mm(|of| of.outer), lines.join(" ").into()])
            .collect()
    }
}
