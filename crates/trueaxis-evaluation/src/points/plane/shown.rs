//! Tables and plots of points in a plane.

use super::{Lie, PlaneDocument, PlaneErrors, PlaneFit};
use crate::points::Left;
use crate::points::shown::{cells, over};
use crate::shown::{Cell, Curve, EXPANDED, Look, Plot, Shown, Table, Uncertainty, half_width, unit};
use trueaxis_report::BARS;
use trueaxis_report::number::significant;

impl PlaneDocument {
    /// Tables and plots of the points and the errors found.
    pub fn shown(&self, found: &PlaneFit) -> Shown {
        let models = self.models.iter().map(|of| {
            let chosen = if of.model == self.model { "chosen" } else { "" };
            let numbers = [Cell::count(of.unknowns), Cell::count(of.rank), Cell::number(of.held_out_um, 3)];
            let left = [Cell::number(of.left_um, 3), Cell::count(of.degrees_of_freedom), chosen.into()];
            [of.model.as_str().into()].into_iter().chain(numbers).chain(left).collect()
        });
        let header = ["model", "unknowns", "rank", "held out, µm", "residuals, µm", "degrees of freedom", ""];
        let row = |name: &str, of: Left| {
            let numbers = [Cell::number(of.max_um, 3), Cell::number(of.rms_um, 3), Cell::count(of.line as usize)];
            [name.into(), Cell::count(of.points)].into_iter().chain(numbers).collect()
        };
        let residuals = [row("measured", self.before), row("left", self.left), row("held out", self.held_out)];
        let terms = self.terms.iter().map(|term| {
            let value = term.of.uncertainty().value(term.of.value);
            let unit = if term.unit == "ppm" { "ppm" } else { unit(term.unit) };
            vec![term.name.as_str().into(), value.clone(), value, term.of.uncertainty().cell(), unit.into()]
        });
        let functions = self.functions.iter().map(|of| {
            let uncertainty = Uncertainty::of(of.standard_error, self.degrees_of_freedom as f64);
            let [low, high] = of.range.map(|value| uncertainty.value(value));
            vec![of.name.as_str().into(), low, high, uncertainty.cell(), unit(of.unit).into()]
        });
        let map = self.map_um.into_iter().flat_map(|um| {
            self.plane
                .into_iter()
                .zip(um)
                .map(|(letter, um)| (format!("largest error along {letter}, µm"), Cell::number(um, 3)))
        });
        let grid = self
            .grid_off_um
            .map(|um| ("largest difference of the grid from the map, µm".to_owned(), Cell::number(um, 2)));
        let figures: Vec<(String, Cell)> = map
            .chain(grid)
            .chain([
                ("sigma of a coordinate, µm".into(), Cell::number(self.sigma_um, 3)),
                ("degrees of freedom".into(), Cell::count(self.degrees_of_freedom)),
                ("unknowns".into(), Cell::count(self.unknowns)),
            ])
            .collect();
        let transfer = self.transfer.iter().map(|test| {
            let numbers = [Some(test.before_um), Some(test.after_um), test.own_um].map(|um| Cell::number(um, 3));
            [test.record.as_str().into()].into_iter().chain(numbers).chain([Cell::number(test.p, 2)]).collect()
        });
        let transfer_header = ["RMS, µm", "aligned", "with these terms", "own terms, held out", "p"];
        Shown {
            title: format!("Measured points {}", if self.shape == "line" { "on a line" } else { "in a plane" }),
            summary: vec![
                self.points_sentence(found),
                self.model.clone(),
                format!("rank {} of {}", self.rank, self.unknowns),
            ],
            result: self.result(),
            notes: self.notes.clone(),
            tables: vec![
                Table::new("Models, by their errors at held-out points", header, models),
                Table::new("Residuals in the plane", ["µm", "points", "largest", "RMS", "largest in line"], residuals),
                Table::new("Terms in another record", transfer_header, transfer),
                Table::new("Errors", ["error", "from", "to", EXPANDED, "unit"], functions.chain(terms)),
                Table::figures("Fit", figures.iter().map(|(name, cell)| (name.as_str(), cell.clone()))),
            ],
            plots: plots(self, found),
            map: (found.lie == Lie::Plane([0, 1])).then(|| {
                let left = found.left_of(found.chosen);
                let at = found.points.iter().zip(left).map(|(point, [u, v])| (point.at, u.hypot(v)));
                cells(&at.collect::<Vec<_>>())
            }),
            ..Shown::default()
        }
    }

    fn result(&self) -> String {
        let [before, held_out, left] = [self.before, self.held_out, self.left].map(|of| significant(of.rms_um, 3));
        format!(
            "Of {before} µm RMS the chosen model ({}) leaves {held_out} µm at held-out points and {left} µm where it was fitted; \
             a coordinate scatters by {} µm.",
            self.model,
            significant(self.sigma_um, 3)
        )
    }
}

/// Residuals over both axes, and the errors of the tables.
fn plots(document: &PlaneDocument, found: &PlaneFit) -> Vec<Plot> {
    let letters = found.letters();
    let left = found.left_of(found.chosen);
    let seen = found.lie.free().len();
    let mut plots = Vec::new();
    for (k, letter) in letters.iter().enumerate().take(seen) {
        let places: Vec<f64> = found.points.iter().map(|point| point.at[k]).collect();
        plots.push(over(letter, &places, |order| {
            let um = |c: usize| order.iter().map(|i| 1e3 * left[*i][c]).collect();
            let curve = |(c, of): (usize, &char)| Curve::new(format!("along {of}"), found.axes[c], um(c));
            letters.iter().enumerate().map(curve).collect()
        }));
    }
    let PlaneErrors::Tables(tables) = &found.errors else { return plots };
    if let Lie::Inclined(..) = found.lie {
        return plots;
    }
    for (k, letter) in letters.iter().enumerate().take(seen) {
        let curve = |(c, of): (usize, &char)| {
            let um = |values: &[f64]| values.iter().map(|mm| 1e3 * mm).collect::<Vec<f64>>();
            let freedom = document.degrees_of_freedom as f64;
            let expanded =
                um(&tables.standard_errors[k][c]).into_iter().map(|error| half_width(error, freedom)).collect();
            Curve { expanded, ..Curve::new(format!("E{of}{letter}"), found.axes[c], um(&tables.errors[k][c])) }
        };
        plots.push(Plot {
            section: "Errors",
            title: format!("Errors over {letter}"),
            x: (letter.to_string(), "mm"),
            y: ("error", "µm"),
            look: Look::Dotted,
            caption: BARS,
            at: tables.nodes_mm[k].clone(),
            curves: letters.iter().enumerate().map(curve).collect(),
            ..Plot::default()
        });
    }
    plots
}
