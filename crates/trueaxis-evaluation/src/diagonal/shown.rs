//! Tables and plots of a diagonal test.

use super::{DiagonalDocument, Shape, Value};
use crate::shown::{Cell, Curve, EXPANDED, Look, Plot, Quantity, Shown, Table, Uncertainty, half_width};
use trueaxis_metrology::diagonal::Test;
use trueaxis_report::BARS;

impl DiagonalDocument {
    /// Tables and plots of the document's test.
    pub fn shown(&self, test: &Test) -> Shown {
        let row = |name: String, [length, targets]: [Cell; 2], um: [Option<f64>; 4]| {
            [name.into(), length, targets].into_iter().chain(um.map(|um| Cell::number(um, 4))).collect::<Vec<Cell>>()
        };
        let rows = self.diagonals.iter().map(|d| {
            let size = [Cell::number(d.length_mm, 5), Cell::count(d.targets)];
            row(format!("diagonal {}", d.diagonal), size, [Some(d.e_um), d.b_um, Some(d.m_um), d.r_um])
        });
        let all = [Some(self.e_d_um), self.b_d_um, Some(self.m_d_um), self.r_d_um];
        let largest = row("largest".into(), ["".into(), "".into()], all);
        let head = ["ISO 230-6", "length, mm", "targets", "E(D), µm", "B(D), µm", "M(D), µm", "R(D), µm"];
        let figures = Table::new("Figures of ISO 230-6", head, rows.chain([largest]));
        let known = |name: &str, unit, of: Value| Quantity::new(name, unit, of.value, of.uncertainty());
        let mut terms = vec![
            known("squareness A0Z", "µrad", self.a0z),
            known("squareness B0Z", "µrad", self.b0z),
            known("squareness C0Y", "µrad", self.c0y),
            known("diagonal scale", "ppm", self.scale),
        ];
        let mut fit = vec![("condition number", Cell::number(self.condition, 3))];
        if let Some(steps) = &self.steps {
            let names = ["scale X", "scale Y", "scale Z"];
            terms.extend(names.into_iter().enumerate().map(|(k, name)| match steps.scales_ppm {
                Some(scales) => known(name, "ppm", scales[k]),
                None => {
                    Quantity::new(name, "ppm", None, Uncertainty::Unknown).noted("not known without --alignment-urad")
                }
            }));
            terms.extend(steps.scales_if_aligned_ppm.into_iter().zip(names).map(|(value, name)| {
                Quantity::new(format!("{name}, mirror square"), "ppm", value, Uncertainty::Unknown)
            }));
            fit.push(("sigma of a step, µm", Cell::number(steps.sigma_um, 3)));
            fit.push(("degrees of freedom", Cell::count(steps.degrees_of_freedom)));
        }
        let terms = Table::quantities("Results of the diagonals", terms);
        let shapes = self.steps.iter().flat_map(|steps| &steps.shapes).map(|shape| self.shape(shape));
        Shown {
            title: "Diagonal displacement test".into(),
            summary: vec![
                format!("{} test", self.test),
                format!("{} readings", self.readings),
                format!("rank {} of 4", self.rank),
            ],
            notes: self.limits.clone(),
            tables: [figures, terms, Table::figures("Fit", fit)].into_iter().chain(shapes).collect(),
            plots: std::iter::once(deviations(test)).chain(self.shapes()).collect(),
            ..Shown::default()
        }
    }

    /// Degrees of freedom of the shapes.
    fn freedom(&self) -> f64 {
        self.steps.as_ref().map_or(0.0, |steps| steps.degrees_of_freedom as f64)
    }

    /// The errors of an axis by position.
    fn shape(&self, shape: &Shape) -> Table {
        let axis = shape.axis;
        let columns = ["X", "Y", "Z"].map(|of| [format!("E{of}{axis}, µm"), format!("{EXPANDED}, E{of}{axis}")]);
        let head = std::iter::once(format!("{axis}, mm")).chain(columns.into_iter().flatten());
        let rows = shape.points.iter().map(|point| {
            let errors = point.error_um.into_iter().zip(point.standard_error_um);
            let cells = errors.flat_map(|(value, error)| {
                let uncertainty = Uncertainty::of(error, self.freedom());
                [uncertainty.value(value), uncertainty.cell()]
            });
            std::iter::once(Cell::fixed(point.position_mm, 3)).chain(cells).collect()
        });
        Table::new(format!("Errors of {axis}, slopes removed"), head, rows)
    }

    /// Shapes of the errors of every axis, slopes removed.
    fn shapes(&self) -> impl Iterator<Item = Plot> {
        self.steps.iter().flat_map(|steps| &steps.shapes).map(|shape| {
            let axis = shape.axis;
            let curves = ["X", "Y", "Z"].into_iter().enumerate().map(|(c, of)| Curve {
                expanded: shape
                    .points
                    .iter()
                    .map(|point| half_width(point.standard_error_um[c], self.freedom()))
                    .collect(),
                ..Curve::new(format!("E{of}{axis}"), c, shape.points.iter().map(|point| point.error_um[c]).collect())
            });
            Plot {
                section: "Results of the steps",
                title: format!("Errors of {axis}, slopes removed"),
                x: (axis.to_string(), "mm"),
                y: ("error", "µm"),
                look: Look::Dotted,
                caption: BARS,
                at: shape.points.iter().map(|point| point.position_mm).collect(),
                curves: curves.collect(),
                ..Plot::default()
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
        ..Plot::default()
    }
}
