//! Tables and plots of a probing test.

use super::{Feature, Offset, ProbingDocument, Record, Spread};
use crate::shown::{Cell, Curve, Look, Plot, Quantity, Shown, Table, Uncertainty};
use trueaxis_tables::text::counted;

impl ProbingDocument {
    /// The figures of all runs: one row each, or one along X, Y and Z.
    fn figures(&self) -> Vec<Quantity> {
        let figure = |name: &str, unit, value: f64| Quantity::new(name, unit, value, Uncertainty::Unknown);
        let along = |name: String, um: [f64; 3]| {
            ["X", "Y", "Z"].into_iter().zip(um).map(move |(axis, um)| figure(&format!("{name}, {axis}"), "µm", um))
        };
        let spread = |name: &str, of: Spread| {
            let deviation = of.standard_deviation_um.map(|um| along(format!("standard deviation of {name}"), um));
            along(format!("range of {name}"), of.range_um).chain(deviation.into_iter().flatten())
        };
        let mut figures = Vec::new();
        figures.extend(
            self.p_ftu_um
                .zip(self.p_ftu_name)
                .map(|(um, name)| figure(name, "µm", um).noted("the largest of the runs")),
        );
        figures.extend(self.point_repeatability.into_iter().flat_map(|of| spread("the point", of)));
        figures.extend(self.location_repeatability.into_iter().flat_map(|of| spread("the location", of)));
        if let Some(Offset { x_um, y_um, length_um }) = self.tip_offset {
            for (name, of) in [("X", x_um), ("Y", y_um)] {
                figures.push(Quantity::new(
                    format!("offset of the stylus tip, {name}"),
                    "µm",
                    of.value,
                    of.uncertainty(),
                ));
            }
            figures.push(figure("offset of the stylus tip", "µm", length_um));
        }
        figures.extend(
            self.effective_tip_diameter_mm.map(|mm| figure("effective diameter of the tip", "mm", mm).decimals(4)),
        );
        figures.extend(self.diameter_range_um.map(|um| figure("range of the diameters", "µm", um)));
        figures
    }

    /// Tables and plot of the document's record.
    pub fn shown(&self, record: &Record) -> Shown {
        let runs = self.runs.iter().map(|run| {
            let centre = run.centre_mm.map(|mm| Cell::fixed(mm, 4));
            [format!("run {}", run.run).into(), Cell::count(run.points)]
                .into_iter()
                .chain(centre)
                .chain([Cell::fixed(run.diameter_mm, 4), Cell::number(run.form_um, 3)])
                .collect()
        });
        Shown {
            title: "Probing test".into(),
            summary: vec![self.feature.into(), counted(self.runs.len(), "run")],
            notes: self.notes.clone(),
            tables: vec![
                Table::quantities("Figures of ISO 230-10", self.figures()),
                Table::new(
                    "Runs",
                    ["ISO 230-10", "points", "X, mm", "Y, mm", "Z, mm", "diameter, mm", "P_FTU, µm"],
                    runs,
                ),
            ],
            plots: form(record).into_iter().collect(),
            ..Shown::default()
        }
    }
}

/// Distance of every point from its run's centre, minus half the run's diameter; `None` for single points.
fn form(record: &Record) -> Option<Plot> {
    let (mut angles, mut distances) = (Vec::new(), Vec::new());
    for run in &record.runs {
        let radius = 0.5 * run.diameter?;
        let flat = record.feature == Feature::Ring;
        for point in &run.points {
            let [x, y, z] = [0, 1, 2].map(|c| point[c] - run.centre[c]);
            let distance = if flat { x.hypot(y) } else { (x * x + y * y + z * z).sqrt() };
            angles.push(y.atan2(x).to_degrees());
            distances.push(1e3 * (distance - radius));
        }
    }
    let (at, order) = Plot::ascending(&angles);
    let values = order.iter().map(|i| distances[*i]).collect();
    Some(Plot {
        section: "Form",
        title: "Distance of the points from the centre".into(),
        x: ("direction in the XY plane".into(), "degrees"),
        y: ("distance", "µm"),
        look: Look::Points,
        caption: "Less half the diameter of the run's least-squares circle or sphere.",
        at,
        curves: vec![Curve::new("all runs", 0, values)],
        ..Plot::default()
    })
}
