//! The page of `trueaxis identify`.

use super::{range, warnings};
use maud::html;
use trueaxis::Axis;
use trueaxis_evaluation::identify::{Document, names};
use trueaxis_evaluation::uncertainty::band_factor;
use trueaxis_report::{
    BARS, Figure, Page, Row, Scale, Table, error_bars,
    number::{quantity, significant},
    residuals, summary,
};

/// The whole page; `source` is the name of the readings' file.
pub(crate) fn page(source: &str, axis: Axis, found: &Document) -> String {
    let sigma = quantity(found.sigma_um, "µm");
    Page::new(format!("Errors of the axis {}", axis.letter()))
        .top(summary([
            html! { (source) },
            html! { (found.set_ups.len()) " set-ups" },
            html! { (found.angles.len()) " angles" },
            html! { "sigma of a reading " (sigma) ", " (found.degrees_of_freedom) " degrees of freedom" },
            html! { "location errors " (found.location_sentence()) },
        ]))
        .top(warnings(&found.warnings))
        .top(table(axis, found))
        .section("Translations", errors(axis, found, [0, 1, 2], "µm"))
        .section("Rotations", errors(axis, found, [3, 4, 5], "µrad"))
        .section("Residuals", residuals_of(axis, found))
        .document()
}

fn table(axis: Axis, found: &Document) -> Table {
    let row = |(i, name): (usize, &String)| {
        let [low, high] = range(found.angles.iter().map(|angle| angle.values[i]));
        let standard = found.standard_errors.get(&name.to_lowercase()).and_then(serde_json::Value::as_f64);
        let expanded = found.expanded_uncertainties.get(&name.to_lowercase()).and_then(serde_json::Value::as_f64);
        let [standard, expanded] = [standard, expanded].map(|error| significant(error.unwrap_or(f64::NAN), 2));
        Row::new(name, [significant(low, 3), significant(high, 3), standard, expanded])
    };
    Table::new(["error", "from", "to", "standard error", "± with 95 %"], names(axis).iter().enumerate().map(row))
}

fn angle_scale(axis: Axis, found: &Document) -> Scale {
    let angles = found.angles.iter().map(|angle| angle.angle_deg);
    Scale::linear(&format!("{} in degrees", axis.letter()), angles).margin(0.02)
}

fn errors(axis: Axis, found: &Document, shown: [usize; 3], unit: &str) -> Figure {
    let (names, factor) = (names(axis), band_factor(found.degrees_of_freedom as f64));
    let curve = |i: usize| {
        let points = found.angles.iter().map(|angle| [angle.angle_deg, angle.values[i], factor * angle.deviations[i]]);
        (names[i].as_str(), points.collect())
    };
    let description = format!("{} over the angle", shown.map(|i| names[i].as_str()).join(", "));
    let mut figure = error_bars(&description, angle_scale(axis, found), unit, &shown.map(curve));
    figure.caption(BARS);
    figure
}

fn residuals_of(axis: Axis, found: &Document) -> Figure {
    let points: Vec<[f64; 2]> = found.angles.iter().map(|angle| [angle.angle_deg, angle.residual_um]).collect();
    let description = "Root mean square of the residuals at every angle";
    let mut figure = residuals(description, angle_scale(axis, found), &points, found.sigma_um);
    figure.caption("Residuals are smaller than sigma: at every angle six of the readings go into the errors.");
    figure
}
