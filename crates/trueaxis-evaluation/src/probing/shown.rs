//! Tables and plots of a probing test.

use super::{Feature, ProbingDocument, Record, Spread};
use crate::shown::{Cell, Curve, Look, Plot, Shown, Table};
use trueaxis_report::number::significant;
use trueaxis_tables::text::counted;

impl ProbingDocument {
    /// The figures of all runs as text: name and value.
    pub fn figures(&self) -> Vec<(&'static str, String)> {
        let um = |value: f64| significant(value, 3);
        let three = |of: Spread| {
            let [x, y, z] = of.range_um.map(um);
            let deviation = of.standard_deviation_um.map_or_else(String::new, |s| {
                let [x, y, z] = s.map(um);
                format!(", standard deviation {x}, {y}, {z} µm")
            });
            format!("range {x}, {y}, {z} µm along X, Y, Z{deviation}")
        };
        let mut figures = Vec::new();
        figures.extend(
            self.p_ftu_um
                .zip(self.p_ftu_name)
                .map(|(value, name)| (name, format!("{} µm, the largest of the runs", um(value)))),
        );
        figures.extend(self.point_repeatability.map(|of| ("repeatability of the point", three(of))));
        figures.extend(self.location_repeatability.map(|of| ("repeatability of the location", three(of))));
        figures.extend(self.tip_offset.map(|of| {
            let [x, y] = [of.x_um, of.y_um].map(|v| format!("{} ± {}", um(v.value), significant(v.standard_error, 2)));
            ("offset of the stylus tip", format!("X {x}, Y {y} µm, together {} µm", um(of.length_um)))
        }));
        figures
            .extend(self.effective_tip_diameter_mm.map(|mm| ("effective diameter of the tip", format!("{mm:.4} mm"))));
        figures.extend(self.diameter_range_um.map(|of| ("range of the diameters", format!("{} µm", um(of)))));
        figures
    }

    /// Tables and plot of the document's record.
    pub fn shown(&self, record: &Record) -> Shown {
        let figures = self.figures().into_iter().map(|(name, of)| vec![name.into(), of.into()]);
        let runs = self.runs.iter().map(|run| {
            let centre = run.centre_mm.map(|mm| Cell::fixed(mm, 4));
            [format!("run {}", run.run).into(), Cell::count(run.points)]
                .into_iter()
                .chain(centre)
                .chain([Cell::fixed(run.diameter_mm, 4), Cell::number(run.form_um, 3)])
                .collect()
        });
        Shown {
            title: "Probing test",
            summary: vec![self.feature.into(), counted(self.runs.len(), "run")],
            notes: self.notes.clone(),
            tables: vec![
                Table { caption: "Figures of ISO 230-10", header: vec!["figure", "value"], rows: figures.collect() },
                Table {
                    caption: "Runs",
                    header: vec!["ISO 230-10", "points", "X, mm", "Y, mm", "Z, mm", "diameter, mm", "P_FTU, µm"],
                    rows: runs.collect(),
                },
            ],
            plots: form(record).into_iter().collect(),
            map: None,
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
    })
}
