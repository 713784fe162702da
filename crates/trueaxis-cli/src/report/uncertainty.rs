//! The figures on the page of `trueaxis uncertainty`.

use maud::{Markup, Render};
use trueaxis_evaluation::uncertainty::UncertaintyDocument;
use trueaxis_report::{Figure, Scale, Stroke, colour, heat_map, side_by_side};

/// Number of contributions drawn.
const BARS: usize = 12;

/// Sections with the figures.
pub(crate) fn figures(document: &UncertaintyDocument) -> [(&'static str, Markup); 2] {
    [
        ("Where", side_by_side([layer(document), distribution(document)])),
        ("Largest contributions", bars(document).render()),
    ]
}

/// Radii in the plane of X and Y through the worst point.
fn layer(document: &UncertaintyDocument) -> Figure {
    let [[x0, x1], [y0, y1], _] = document.ranges;
    let (x, y) = (Scale::exact("X in mm", x0, x1), Scale::exact("Y in mm", y0, y1));
    let mut figure = heat_map("Radius of the expanded uncertainty over X and Y", x, y, &document.layer, "µm");
    figure.caption(format!(
        "Radius within which the tip lies with {} %, in the plane of X and Y through the worst point.",
        document.confidence_percent
    ));
    figure
}

/// Distribution over the machines drawn: distance of the tip from its ideal position.
fn distribution(document: &UncertaintyDocument) -> Figure {
    let distances = document.distances_um();
    let radius = document.worst.jacobian.radius_um;
    let x = Scale::from_zero("distance in µm", distances.iter().copied().chain([radius]));
    let mut figure = Figure::half("Distribution of the distance", 420, x, Scale::exact("share in %", 0.0, 100.0));
    let steps = distances.len().saturating_sub(1).max(1) as f64;
    let curve = distances.iter().enumerate().map(|(step, distance)| [*distance, 100.0 * step as f64 / steps]);
    let limit = Stroke::new(colour::LIMIT, 1.2).dashed();
    figure
        .curve("machines drawn", curve, Stroke::new(colour::COMPENSATED, 1.6))
        .curve("radius by derivatives", [[radius, 0.0], [radius, 100.0]], limit)
        .across(document.confidence_percent, colour::GREY)
        .caption("Share of the machines drawn whose tip lies within a distance, at the worst point.");
    figure
}

fn bars(document: &UncertaintyDocument) -> Figure {
    let largest: Vec<_> = document.contributions.iter().take(BARS).collect();
    let x = Scale::exact("contributions in order of their share", 0.5, largest.len() as f64 + 0.5);
    let y = Scale::from_zero("standard uncertainty in µm", largest.iter().flat_map(|own| [own.rms_um, own.worst_um]));
    let mut figure = Figure::full("Contributions to the standard uncertainty", 280, x, y);
    let points = |take: fn(&trueaxis_evaluation::uncertainty::Share) -> f64| -> Vec<[f64; 2]> {
        (1..).zip(&largest).map(|(number, own)| [f64::from(number), take(own)]).collect()
    };
    figure
        .columns(points(|own| own.rms_um), [-0.35, 0.0], colour::COMPENSATED)
        .columns(points(|own| own.worst_um), [0.0, 0.35], colour::UNCOMPENSATED)
        .labels_above((1..).zip(&largest).map(|(number, own)| (f64::from(number), own.term.clone())))
        .area_key("RMS over the working volume", colour::COMPENSATED)
        .area_key("at the worst point", colour::UNCOMPENSATED);
    figure
}
