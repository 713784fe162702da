use crate::{Figure, Scale, Stroke, colour};

/// Explanation of the bars, for a figure's caption.
pub const BARS: &str = "Bars: expanded uncertainty, 95 %, to either side.";

/// Up to three measured curves, of X, Y and Z, with bars of their expanded uncertainties (95 %) to either side: points `[x,
/// value, half-width]`.
#[must_use]
pub fn error_bars(description: &str, x: Scale, unit: &str, curves: &[(&str, Vec<[f64; 3]>)]) -> Figure {
    let reach = |[_, value, half]: &[f64; 3]| [value - half, value + half];
    let ends = curves.iter().flat_map(|(_, points)| points.iter().flat_map(reach)).chain([0.0]);
    let y = Scale::linear(&format!("error in {unit}"), ends).margin(0.06);
    let mut figure = Figure::full(description, 300, x, y);
    for ((name, points), colour) in curves.iter().zip(colour::AXES) {
        let values = || points.iter().map(|[x, value, _]| [*x, *value]);
        figure.curve(*name, values(), Stroke::new(colour, 1.4)).dots(values(), colour);
        for point in points {
            figure.line(reach(point).map(|end| [point[0], end]), Stroke::new(colour, 1.0).opacity(0.7));
        }
    }
    figure
}

/// Root mean square of the residuals in µm at every position, beside the sigma of a reading.
#[must_use]
pub fn residuals(description: &str, x: Scale, points: &[[f64; 2]], sigma_um: f64) -> Figure {
    let y = Scale::from_zero("residual in µm", points.iter().map(|point| point[1]).chain([sigma_um]));
    let steps = points.windows(2).map(|pair| pair[1][0] - pair[0][0]).filter(|step| *step > 0.0);
    let half = 0.35 * steps.fold(10.0, f64::min);
    let mut figure = Figure::full(description, 230, x, y);
    figure
        .columns(points.iter().copied(), [-half, half], colour::GREY)
        .across(sigma_um, colour::LIMIT)
        .area_key("root mean square of the residuals at one angle", colour::GREY)
        .key("sigma of a reading, pooled", Stroke::new(colour::LIMIT, 1.2).dashed());
    figure
}
