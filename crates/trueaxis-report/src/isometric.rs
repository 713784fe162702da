use crate::deviations::range;
use crate::{
    Colour, Figure, Scale, Stroke, colour,
    number::{nearest_round, significant},
};

/// Width of the figure, px, and its least and greatest height as shares of it.
const WIDTH_PX: i32 = 760;
const HEIGHTS: [f64; 2] = [0.4, 0.75];
/// The largest deviation is drawn at about this share of the part's width.
const SHARE: f64 = 0.05;
/// Margin about the part as a share of its width: labels are centred about a point.
const MARGIN: f64 = 0.09;
/// Number of deviation vectors of a line.
const VECTORS: usize = 24;
const MM_PER_UM: f64 = 1e-3;
/// Smallest extent, mm, at which a part is drawn.
const LEAST_MM: f64 = 1e-3;

/// A line of an [`isometric`] figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge<'t> {
    /// Text beside its middle.
    pub label: String,
    /// Name in the legend, which lists each name once.
    pub name: &'t str,
    /// Colour of the line.
    pub colour: Colour,
    /// Whether it is dashed.
    pub dashed: bool,
    /// Points, mm.
    pub points_mm: Vec<[f64; 3]>,
    /// Deviations of the points, µm.
    pub deviation_um: Vec<[f64; 3]>,
}

/// A part seen from the front, above and the left, X to the right and Y away: its lines as programmed, and where their
/// deviations lead, magnified by a round factor that the caption states.
#[must_use]
pub fn isometric(description: &str, caption: &str, edges: &[Edge<'_>]) -> Figure {
    let points = || edges.iter().flat_map(|edge| &edge.points_mm).map(|point| flat(*point));
    let [x, y] = [0, 1].map(|axis| range(points().map(move |point| point[axis])));
    let size = (x[1] - x[0]).max(y[1] - y[0]).max(LEAST_MM);
    let lengths = edges.iter().flat_map(|edge| &edge.deviation_um);
    let largest_um = lengths.map(|um| um.iter().map(|part| part * part).sum::<f64>().sqrt()).fold(0.0, f64::max);
    let magnification = if largest_um > 0.0 { nearest_round(SHARE * size / (largest_um * MM_PER_UM)) } else { 1.0 };
    let margin = MARGIN * size;
    let (width, height) = (x[1] - x[0] + 2.0 * margin, y[1] - y[0] + 2.0 * margin);
    let height_px = f64::from(WIDTH_PX) * (height / width).clamp(HEIGHTS[0], HEIGHTS[1]);
    let mm_per_px = (width / f64::from(WIDTH_PX)).max(height / height_px);
    let scale = |[low, high]: [f64; 2], px: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * px * mm_per_px);
        Scale::exact("", middle - half, middle + half)
    };
    let px = [WIDTH_PX, height_px.round() as i32];
    let mut figure = Figure::without_axes(description, "full", px, scale(x, f64::from(WIDTH_PX)), scale(y, height_px));
    let mut named: Vec<&str> = Vec::new();
    for edge in edges {
        let programmed: Vec<[f64; 2]> = edge.points_mm.iter().map(|point| flat(*point)).collect();
        let moved: Vec<[f64; 2]> = edge
            .points_mm
            .iter()
            .zip(&edge.deviation_um)
            .map(|(point, um)| flat(std::array::from_fn(|k| point[k] + magnification * MM_PER_UM * um[k])))
            .collect();
        figure.line(programmed.iter().copied(), Stroke::new(colour::NOMINAL, 0.8));
        let every = programmed.len().div_ceil(VECTORS).max(1);
        for (from, to) in programmed.iter().zip(&moved).step_by(every) {
            figure.line([*from, *to], Stroke::new(edge.colour, 0.8).opacity(0.5));
        }
        let stroke = Stroke::new(edge.colour, 2.0);
        let stroke = if edge.dashed { stroke.dashed() } else { stroke };
        figure.line(moved, stroke);
        if !named.contains(&edge.name) {
            named.push(edge.name);
            figure.key(edge.name, stroke);
        }
    }
    // Last, so that no line crosses them.
    for edge in edges {
        if let Some(at) = edge.points_mm.get(edge.points_mm.len() / 2) {
            figure.text_above(flat(*at), edge.label.clone());
        }
    }
    let (times, largest) = (significant(magnification, 1), significant(largest_um, 3));
    figure.key("programmed", Stroke::new(colour::NOMINAL, 0.8));
    figure.caption(format!("{caption}: deviations magnified {times} times, the largest {largest} µm."));
    figure
}

/// A point of space in the plane of the figure.
fn flat([x, y, z]: [f64; 3]) -> [f64; 2] {
    let (sine, cosine) = std::f64::consts::FRAC_PI_6.sin_cos();
    [cosine * (x - y), sine * (x + y) + z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_lengths_along_x_y_and_z_are_equal_on_the_page() {
        let origin = flat([0.0; 3]);
        for point in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let [u, v] = flat(point);
            assert!(((u - origin[0]).hypot(v - origin[1]) - 1.0).abs() < 1e-12, "{point:?}");
        }
        // X to the right and Y to the left, both away from the reader, Z up.
        assert!(flat([1.0, 0.0, 0.0])[0] > 0.0 && flat([0.0, 1.0, 0.0])[0] < 0.0 && flat([0.0, 0.0, 1.0])[1] > 0.9);
    }

    #[test]
    fn a_name_is_once_in_the_legend_and_every_label_in_the_figure() {
        let edge = |label: &str, name: &'static str, z: f64| Edge {
            label: label.into(),
            name,
            colour: colour::COMPENSATED,
            dashed: false,
            points_mm: vec![[0.0, 0.0, z], [50.0, 0.0, z], [50.0, 30.0, z]],
            deviation_um: vec![[0.0, 0.0, 5.0]; 3],
        };
        let edges = [edge("front", "conforms", 0.0), edge("back", "conforms", 10.0), edge("bore", "undecided", 5.0)];
        let html = isometric("a part", "Part", &edges).to_html();
        for (text, count) in [("conforms", 1), ("undecided", 1), ("front", 1), ("back", 1), ("bore", 1)] {
            assert_eq!(html.matches(text).count(), count, "{text} in {html}");
        }
        assert!(html.contains("magnified 500 times, the largest 5.00 µm"), "{html}");
        assert!(isometric("a part", "Part", &[]).to_html().contains("nothing to draw"));
    }
}
