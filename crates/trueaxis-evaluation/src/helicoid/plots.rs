//! Displacements over one parameter, with one curve for each of several values of the other.

use super::{HelicoidDocument, Point};
use crate::shown::{Curve, Plot};
use trueaxis_report::number::shortest;

/// Colours of the curves.
const COLOURS: [usize; 5] = [6, 5, 7, 3, 8];
/// Most points of a curve.
const DRAWN: usize = 2000;

/// A value of a point.
type Of = fn(&Point) -> f64;

/// The five displacements: name, unit, value.
pub(super) const DISPLACEMENTS: [(&str, &str, Of); 5] = [
    ("X", "mm", |point| point.x_mm),
    ("Y", "mm", |point| point.y_mm),
    ("Z", "mm", |point| point.z_mm),
    ("A", "degrees", |point| point.a_deg),
    ("C", "degrees", |point| point.c_deg),
];

/// A plot for each displacement: along θ, or along u if θ has a single value.
pub(super) fn displacements(document: &HelicoidDocument) -> Vec<Plot> {
    let (rows, columns) = (document.inputs.u_rad.count, document.inputs.theta_rad.count);
    let is_along_theta = columns > 1 || rows == 1;
    let (count, length) = if is_along_theta { (rows, columns) } else { (columns, rows) };
    let every = length.div_ceil(DRAWN).max(1);
    // First and last, and evenly spaced ones between them.
    let shown = count.min(COLOURS.len());
    let picked = (0..shown).map(|i| if shown > 1 { i * (count - 1) / (shown - 1) } else { 0 });
    let curves: Vec<Vec<&Point>> = picked
        .map(|i| {
            let along = (0..length).filter(|k| k % every == 0 || k + 1 == length);
            let index = |k| if is_along_theta { i * columns + k } else { k * columns + i };
            along.filter_map(|k| document.points.get(index(k))).collect()
        })
        .collect();
    let [along, across]: [Of; 2] = if is_along_theta {
        [|point| point.theta_rad, |point| point.u_rad]
    } else {
        [|point| point.u_rad, |point| point.theta_rad]
    };
    let [letter, other] = if is_along_theta { ["θ", "u"] } else { ["u", "θ"] };
    let named = |points: &[&Point]| {
        points.first().map_or(String::new(), |point| format!("{other} = {} rad", shortest(across(point))))
    };
    let plot = |(name, unit, of): (&'static str, &'static str, Of)| {
        let values = |points: &Vec<&Point>| points.iter().map(|point| of(point)).collect::<Vec<f64>>();
        let drawn: Vec<Vec<f64>> = curves.iter().map(values).collect();
        let same = |one: &[f64], other: &[f64]| one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-9);
        let are_one = drawn.len() > 1 && drawn.windows(2).all(|pair| same(&pair[0], &pair[1]));
        let curve =
            |((points, values), colour): ((&Vec<&Point>, Vec<f64>), usize)| Curve::new(named(points), colour, values);
        Plot {
            section: "Displacements of the five axes",
            title: format!("Displacement of {name} over {letter} in rad"),
            x: (letter.into(), "rad"),
            y: (name, unit),
            caption: if are_one { "The curves lie on one another." } else { "" },
            at: curves.first().map_or(Vec::new(), |points| points.iter().map(|point| along(point)).collect()),
            curves: curves.iter().zip(drawn).zip(COLOURS).map(curve).collect(),
            ..Plot::default()
        }
    };
    DISPLACEMENTS.map(plot).into()
}
