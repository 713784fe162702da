//! Tables and plots of a diagonal test.

use super::{DiagonalDocument, Value};
use crate::shown::{Cell, Curve, Look, Plot, Shown, Table};
use trueaxis_metrology::diagonal::Test;

impl DiagonalDocument {
    /// Tables and plots of the document's test.
    pub fn shown(&self, test: &Test) -> Shown {
        let figures = |name: String, e: f64, b: Option<f64>, m: f64, r: Option<f64>| {
            let cells = [Some(e), b, Some(m), r].map(|um| Cell::number(um, 4));
            std::iter::once(name.into()).chain(cells).collect::<Vec<Cell>>()
        };
        let rows =
            self.diagonals.iter().map(|d| figures(format!("diagonal {}", d.diagonal), d.e_um, d.b_um, d.m_um, d.r_um));
        let largest = figures("largest".into(), self.e_d_um, self.b_d_um, self.m_d_um, self.r_d_um);
        let figures = Table {
            caption: "Figures of ISO 230-6",
            header: vec!["ISO 230-6", "E(D), µm", "B(D), µm", "M(D), µm", "R(D), µm"],
            rows: rows.chain([largest]).collect(),
        };
        let mut rows = Vec::new();
        let mut put = |name: &str, unit: &str, value: f64, error: Option<f64>| {
            rows.push(vec![name.into(), Cell::number(value, 4), Cell::number(error, 2), unit.into()]);
        };
        let mut known = |name: &str, unit: &str, of: Value| put(name, unit, of.value, Some(of.standard_error));
        known("squareness A0Z", "µrad", self.a0z);
        known("squareness B0Z", "µrad", self.b0z);
        known("squareness C0Y", "µrad", self.c0y);
        known("diagonal scale", "ppm", self.scale);
        if let Some(steps) = &self.steps {
            for (of, name) in steps.scales_ppm.into_iter().flatten().zip(["scale X", "scale Y", "scale Z"]) {
                known(name, "ppm", of);
            }
            let names = ["scale X, mirror square", "scale Y, mirror square", "scale Z, mirror square"];
            for (value, name) in steps.scales_if_aligned_ppm.into_iter().zip(names) {
                put(name, "ppm", value, None);
            }
            put("sigma of a step", "µm", steps.sigma_um, None);
        }
        let terms = Table {
            caption: "Results of the diagonals",
            header: vec!["term", "value", "standard error", "unit"],
            rows,
        };
        Shown {
            title: "Diagonal displacement test",
            summary: vec![
                format!("{} test", self.test),
                format!("{} readings", self.readings),
                format!("rank {} of 4", self.rank),
            ],
            notes: self.limits.clone(),
            tables: vec![figures, terms],
            plots: std::iter::once(deviations(test)).chain(self.shapes()).collect(),
            map: None,
        }
    }

    /// Shapes of the errors of every axis, slopes removed.
    fn shapes(&self) -> impl Iterator<Item = Plot> {
        self.steps.iter().flat_map(|steps| &steps.shapes).map(|shape| {
            let axis = shape.axis;
            let curves = ["X", "Y", "Z"].into_iter().enumerate().map(|(c, of)| Curve {
                errors: shape.points.iter().map(|point| point.standard_error_um[c]).collect(),
                ..Curve::new(format!("E{of}{axis}"), c, shape.points.iter().map(|point| point.error_um[c]).collect())
            });
            Plot {
                section: "Results of the steps",
                title: format!("Errors of {axis}, slopes removed"),
                x: (axis.to_string(), "mm"),
                y: ("error", "µm"),
                look: Look::Dotted,
                caption: "End-to-end slopes removed. Bars: 2 standard errors to either side.",
                at: shape.points.iter().map(|point| point.position_mm).collect(),
                curves: curves.collect(),
            }
        })
    }
}

/// Distances along the diagonals closer than this are one, mm: the same target of a box whose numbers were rounded.
const SAME_MM: f64 = 1e-3;

/// Mean deviation along every diagonal, away and back.
fn deviations(test: &Test) -> Plot {
    let mut at: Vec<f64> = (0..4).flat_map(|k| test.on(k).map(|target| target.along_mm)).collect();
    at.sort_by(f64::total_cmp);
    at.dedup_by(|next, kept| *next - *kept < SAME_MM);
    let mut curves = Vec::new();
    for k in 0..4 {
        for (way, name) in ["away", "back"].into_iter().enumerate() {
            let mut values = vec![f64::NAN; at.len()];
            for target in test.on(k) {
                let after = at.partition_point(|along| *along <= target.along_mm);
                if let (Some(value), Some(mean)) = (values.get_mut(after.saturating_sub(1)), target.mean_mm[way]) {
                    *value = 1e3 * mean;
                }
            }
            if values.iter().any(|value| value.is_finite()) {
                curves.push(Curve { dashed: way == 1, ..Curve::new(format!("diagonal {}, {name}", k + 1), k, values) });
            }
        }
    }
    Plot {
        section: "Deviation",
        title: "Mean deviation along the four diagonals".into(),
        x: ("distance along the diagonal".into(), "mm"),
        y: ("deviation", "µm"),
        look: Look::Dotted,
        caption: "Targets on the diagonals: ISO 230-6.",
        at,
        curves,
    }
}
