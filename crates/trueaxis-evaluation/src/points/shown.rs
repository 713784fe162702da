//! Tables and plots of measured points.

use super::{Left, Points, PointsDocument, PointsFit};
use crate::shown::{Cell, Curve, EXPANDED, Look, Map, Plot, Shown, Table, Uncertainty, half_width, unit};
use std::fmt::Display;
use trueaxis_metrology::volumetric::{AXES, COMPONENTS};
use trueaxis_report::BARS;

impl PointsDocument {
    /// Tables, plots and map of the points and the errors found.
    pub fn shown(&self, points: &Points, found: &PointsFit) -> Shown {
        let functions = self.functions.iter().map(|of| {
            let uncertainty = Uncertainty::of(of.standard_error, self.degrees_of_freedom as f64);
            let [low, high] = of.range.map(|value| uncertainty.value(value));
            vec![of.name.as_str().into(), low, high, uncertainty.cell(), unit(of.unit).into()]
        });
        let squareness = &self.squareness;
        let squareness = [("A0Z", squareness.a0z_urad), ("B0Z", squareness.b0z_urad), ("C0Y", squareness.c0y_urad)]
            .map(|(name, of)| {
                let value = of.uncertainty().value(of.value);
                vec![name.into(), value.clone(), value, of.uncertainty().cell(), "µrad".into()]
            });
        let left = |name: &str, of: Left| {
            let numbers = [Cell::number(of.max_um, 3), Cell::number(of.rms_um, 3), Cell::count(of.line as usize)];
            [name.into(), Cell::count(of.points)].into_iter().chain(numbers).collect()
        };
        let rows = [left("measured", self.before), left("left", self.left)];
        let rows = rows.into_iter().chain(self.held_out.map(|of| left("held out", of)));
        let fit = [
            ("sigma of a coordinate, µm", Cell::number(self.sigma_um, 3)),
            ("degrees of freedom", Cell::count(self.degrees_of_freedom)),
            ("unknowns", Cell::count(self.unknowns)),
            ("conventions", Cell::count(self.conventions)),
            ("condition number", Cell::number(self.condition, 3)),
        ];
        let [x, y, z] = self.nodes;
        Shown {
            title: "Measured points".into(),
            summary: vec![
                format!("{} points", self.points),
                format!("{x} × {y} × {z} nodes"),
                format!("rank {} of {}", self.rank, self.unknowns),
            ],
            notes: self.notes.clone(),
            tables: vec![
                Table::new("Residuals of the points", ["µm", "points", "largest", "RMS", "largest in line"], rows),
                Table::new("All errors", ["error", "from", "to", EXPANDED, "unit"], functions.chain(squareness)),
                Table::figures("Fit", fit),
            ],
            plots: residuals(points, found).chain(errors(found)).collect(),
            map: Some(map(points, found)),
            ..Shown::default()
        }
    }
}

/// Translations and rotations of every axis that the points determine, with their uncertainties.
fn errors(found: &PointsFit) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (axis, letter) in AXES.into_iter().enumerate() {
        for (first, unit, scale) in [(0, "µm", 1e3), (3, "µrad", 1e6)] {
            let mut curves = Vec::new();
            for c in (0..3).filter(|c| first == 0 || found.basis.seen[axis][first + c]) {
                let of = |values: &[f64]| -> Vec<f64> { values.iter().map(|value| scale * value).collect() };
                let name = format!("E{}{letter}", COMPONENTS[first + c]);
                let expanded = of(&found.errors.standard_errors[axis][first + c])
                    .into_iter()
                    .map(|error| half_width(error, found.errors.degrees_of_freedom as f64))
                    .collect();
                curves.push(Curve { expanded, ..Curve::new(name, c, of(&found.errors.errors[axis][first + c])) });
            }
            if curves.is_empty() {
                continue;
            }
            let names: Vec<&str> = curves.iter().map(|curve| curve.name.as_str()).collect();
            plots.push(Plot {
                section: "Errors",
                title: format!("{} over {letter}", names.join(", ")),
                x: (letter.to_string(), "mm"),
                y: ("error", unit),
                look: Look::Dotted,
                caption: BARS,
                at: found.basis.nodes_mm[axis].clone(),
                curves,
                ..Plot::default()
            });
        }
    }
    plots
}

/// Residuals of every point along X, Y and Z, each over that axis' position.
fn residuals(points: &Points, found: &PointsFit) -> impl Iterator<Item = Plot> {
    AXES.into_iter().enumerate().map(|(axis, letter)| {
        let places: Vec<f64> = points.points.iter().map(|point| point.command_mm[axis]).collect();
        over(letter, &places, |order| {
            Plot::along(&order.iter().map(|i| found.left_mm[*i].map(|mm| 1e3 * mm)).collect::<Vec<_>>())
        })
    })
}

/// Residuals over the positions of an axis, mm; `curves`: theirs, µm, with the points in a given order.
pub(super) fn over(letter: impl Display, places: &[f64], curves: impl FnOnce(&[usize]) -> Vec<Curve>) -> Plot {
    let (at, order) = Plot::ascending(places);
    Plot {
        section: "Residuals",
        title: format!("Residuals over {letter}"),
        x: (letter.to_string(), "mm"),
        y: ("left", "µm"),
        look: Look::Points,
        at,
        curves: curves(&order),
        ..Plot::default()
    }
}

/// Number of cells of the map in each direction.
const CELLS: usize = 12;

/// Root mean square of the residuals over X and Y, all heights together.
fn map(points: &Points, found: &PointsFit) -> Map {
    let of = |(point, left): (&super::Point, &[f64; 3])| ([point.command_mm[0], point.command_mm[1]], length(left));
    cells(&points.points.iter().zip(&found.left_mm).map(of).collect::<Vec<_>>())
}

fn length(of: &[f64]) -> f64 {
    of.iter().map(|mm| mm * mm).sum::<f64>().sqrt()
}

/// Root mean square over the cells of a plane, of values in mm at positions.
pub(super) fn cells(of: &[([f64; 2], f64)]) -> Map {
    let ends_mm = [0, 1].map(|axis| super::found::range(of.iter().map(|(at, _)| at[axis])));
    let mut sums = vec![vec![(0.0, 0_u32); CELLS]; CELLS];
    let cell = |value: f64, [low, high]: [f64; 2]| {
        (((value - low) / (high - low).max(f64::MIN_POSITIVE) * CELLS as f64) as usize).min(CELLS - 1)
    };
    for ([x, y], mm) in of {
        let (sum, count) = &mut sums[cell(*y, ends_mm[1])][cell(*x, ends_mm[0])];
        *sum += 1e6 * mm * mm;
        *count += 1;
    }
    let rms = |(sum, count): (f64, u32)| if count == 0 { f64::NAN } else { (sum / f64::from(count)).sqrt() };
    Map {
        title: "Root mean square of the residuals over X and Y",
        unit: "µm",
        caption: "All heights together; blank where no point was measured.",
        ends_mm,
        rows: sums.into_iter().map(|row| row.into_iter().map(rms).collect()).collect(),
    }
}
