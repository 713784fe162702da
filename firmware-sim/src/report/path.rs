//! The programmed path with magnified deviations, before and after.

use super::{
    PathPoint, Report, Section,
    decimate::pick,
    figure::{Figure, Key, Scale, Stroke, colour, framed, plottable},
    number::{round_down, significant},
};

const WIDTH: i32 = 550;
/// The largest deviation is drawn at about this share of the figure's width.
const SHARE: f64 = 0.06;
/// Number of deviation vectors along the path.
const VECTORS: usize = 120;
/// The path counts as leaving its main plane above this, in mm.
const FLAT_MM: f64 = 1e-3;
/// Compensated deviations below this share of the others get a figure of their own.
const ENLARGE_BELOW: f64 = 0.4;
/// Height of the strip for the scale bar, in px.
const STRIP_PX: f64 = 40.0;
const MM_PER_UM: f64 = 1e-3;
const AXES: [&str; 3] = ["X", "Y", "Z"];

pub(super) fn section(report: &Report) -> Option<Section> {
    let points: Vec<PathPoint> = report.path.iter().copied().filter(drawable).collect();
    let mut html = String::new();
    if points.len() < 2 {
        html.push_str("<p class=\"empty\">No path was recorded.</p>\n");
    } else {
        let points = pick(
            &points,
            300,
            &[
                |point| point.nominal_mm[0],
                |point| point.nominal_mm[1],
                |point| length(point.uncompensated_um),
                |point| length(point.compensated_um),
            ],
        );
        html.push_str("<div class=\"figures\">\n");
        html.push_str(&projection(&points, [0, 1]));
        if extent(&points, 2) > FLAT_MM {
            html.push_str(&projection(&points, [0, 2]));
        }
        html.push_str("</div>\n");
    }
    Some(Section { heading: "Path with magnified deviations", html })
}

fn drawable(point: &PathPoint) -> bool {
    [point.nominal_mm, point.uncompensated_um, point.compensated_um].iter().flatten().all(|&value| plottable(value))
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

fn bounds(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

fn extent(points: &[PathPoint], axis: usize) -> f64 {
    let [low, high] = bounds(points.iter().map(|point| point.nominal_mm[axis]));
    high - low
}

/// Before-and-after figure of a projection; where the residue would vanish, a second one magnifies it further.
fn projection(points: &[PathPoint], plane: [usize; 2]) -> String {
    let largest = |deviation: fn(&PathPoint) -> [f64; 3]| {
        points.iter().map(|point| plane.map(|axis| deviation(point)[axis])).map(|[a, b]| a.hypot(b)).fold(0.0, f64::max)
    };
    let before = largest(|point| point.uncompensated_um);
    let after = largest(|point| point.compensated_um);
    let mut html = figure(points, plane, before.max(after), true);
    if after > 0.0 && after < ENLARGE_BELOW * before {
        html.push_str(&figure(points, plane, after, false));
    }
    html
}

fn figure(points: &[PathPoint], plane: [usize; 2], largest_um: f64, both: bool) -> String {
    let [a, b] = plane;
    let size = extent(points, a).max(extent(points, b)).max(FLAT_MM);
    let magnification = if largest_um > 0.0 { nearest_round(SHARE * size / (largest_um * MM_PER_UM)) } else { 1.0 };
    let nominal = |point: &PathPoint| [point.nominal_mm[a], point.nominal_mm[b]];
    let moved = |point: &PathPoint, deviation: [f64; 3]| {
        let scale = magnification * MM_PER_UM;
        [point.nominal_mm[a] + scale * deviation[a], point.nominal_mm[b] + scale * deviation[b]]
    };
    let before: Vec<[f64; 2]> =
        if both { points.iter().map(|point| moved(point, point.uncompensated_um)).collect() } else { Vec::new() };
    let after: Vec<[f64; 2]> = points.iter().map(|point| moved(point, point.compensated_um)).collect();
    let everything = || points.iter().map(nominal).chain(before.iter().copied()).chain(after.iter().copied());

    let [x_low, x_high] = bounds(everything().map(|point| point[0]));
    let [y_low, y_high] = bounds(everything().map(|point| point[1]));
    // Equal scales on both axes; a strip below the path is kept free for the scale bar.
    let margin = 0.05 * (x_high - x_low).max(y_high - y_low);
    let strip = STRIP_PX * (x_high - x_low + 2.0 * margin).max(size) / f64::from(Figure::inside(WIDTH, 0)[0]);
    let (mut width, mut height) = (x_high - x_low + 2.0 * margin, y_high - y_low + 2.0 * margin + strip);
    let px_height = (f64::from(WIDTH) * (height / width).clamp(0.45, 1.0)).round() as i32;
    let [inside_x, inside_y] = Figure::inside(WIDTH, px_height).map(f64::from);
    let mm_per_px = (width / inside_x).max(height / inside_y);
    (width, height) = (mm_per_px * inside_x, mm_per_px * inside_y);
    let left = 0.5 * (x_low + x_high - width);
    let bottom = 0.5 * (y_low + y_high - strip - height);

    let figure = Figure {
        description: format!("{}{} view of the path with deviations magnified", AXES[a], AXES[b]),
        width: WIDTH,
        height: px_height,
        x: Scale::exact(&format!("{} in mm", AXES[a]), left, left + width, 7),
        y: Scale::exact(&format!("{} in mm", AXES[b]), bottom, bottom + height, 7),
        head: 0,
        marks: Vec::new(),
    };
    let bar_mm = round_down(0.25 * width);
    let bar_from = left + 0.5 * (width - bar_mm);
    let bar_y = bottom + 0.4 * STRIP_PX * mm_per_px;
    let bar_text = format!(
        "path {} mm = deviation {} µm",
        significant(bar_mm, 2),
        significant(bar_mm / magnification / MM_PER_UM, 2)
    );
    let (deviated, vector_colour) = if both { (&before, colour::UNCOMPENSATED) } else { (&after, colour::COMPENSATED) };
    let svg = figure.draw(|plot| {
        for (point, end) in points.iter().zip(deviated).step_by(points.len().div_ceil(VECTORS)) {
            plot.line([nominal(point), *end], Stroke { colour: vector_colour, width: 0.8, opacity: 0.4 })?;
        }
        for run in points.chunk_by(|a, b| a.run == b.run) {
            plot.line(run.iter().map(nominal), Stroke::new(colour::NOMINAL, 1.0))?;
        }
        if both {
            for run in points.chunk_by(|a, b| a.run == b.run) {
                let moved = run.iter().map(|point| moved(point, point.uncompensated_um));
                plot.line(moved, Stroke::new(colour::UNCOMPENSATED, 1.6))?;
            }
        }
        for run in points.chunk_by(|a, b| a.run == b.run) {
            let moved = run.iter().map(|point| moved(point, point.compensated_um));
            plot.line(moved, Stroke::new(colour::COMPENSATED, 1.6))?;
        }
        let ends = [[bar_from, bar_y], [bar_from + bar_mm, bar_y]];
        plot.line(ends, Stroke::new(colour::NOMINAL, 2.5))?;
        plot.text_above([bar_from + 0.5 * bar_mm, bar_y], 5, &bar_text)
    });

    let mut keys = vec![Key { colour: colour::NOMINAL, dashed: false, text: "programmed" }];
    if both {
        keys.push(Key { colour: colour::UNCOMPENSATED, dashed: false, text: "uncompensated" });
    }
    keys.push(Key { colour: colour::COMPENSATED, dashed: false, text: "compensated" });
    let what = if both { "Before and after" } else { "What compensation leaves behind" };
    let caption = format!(
        "{what}, {}{} view: deviations magnified {} times; largest in this view {} µm.",
        AXES[a],
        AXES[b],
        significant(magnification, 1),
        significant(largest_um, 3)
    );
    framed("half", &keys, &svg, &caption)
}

/// The member of 1, 2, 5 × 10^n nearest to `value` in ratio.
fn nearest_round(value: f64) -> f64 {
    let below = round_down(value);
    let above = round_down(below * 2.5);
    if value * value > below * above { above } else { below }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_deviation_takes_about_six_percent_of_the_width() {
        for deviation_um in [0.003, 0.7, 12.0, 18.4, 49.0, 51.0, 900.0] {
            let wanted = SHARE * 50.0 / (deviation_um * MM_PER_UM);
            let factor = nearest_round(wanted);
            assert!((0.63..=1.59).contains(&(factor / wanted)), "{deviation_um} µm: {factor} for {wanted}");
            let mantissa = factor / 10_f64.powf(factor.log10().floor());
            assert!([1.0, 2.0, 5.0, 10.0].iter().any(|round| (mantissa - round).abs() < 1e-6), "{factor}");
        }
    }
}
