use crate::{
    Colour, Figure, Scale, Stroke, colour,
    number::{nearest_round, round_down, significant},
    size::{HALF_PX, inside},
};

/// The largest deviation is drawn at about this share of the figure's width.
const SHARE: f64 = 0.06;
/// Number of deviation vectors along the path.
const VECTORS: usize = 120;
/// Smallest extent, mm, at which a path is drawn.
const LEAST_MM: f64 = 1e-3;
/// Height of the strip for the scale bar, px.
const STRIP_PX: f64 = 40.0;
const MM_PER_UM: f64 = 1e-3;

/// A plane view of a path and curves that deviate from it, with deviations magnified.
#[derive(Clone, Debug, PartialEq)]
pub struct View<'t> {
    /// First words of the caption.
    pub caption: &'t str,
    /// Names of the two axes, horizontal first.
    pub axes: [&'t str; 2],
    /// The path in mm.
    pub path_mm: Vec<[f64; 2]>,
    /// Number of the uninterrupted cut that each point belongs to.
    pub runs: Vec<u32>,
    /// The curves in the order in which they are drawn; thin vectors lead to the first.
    pub curves: Vec<Deviated<'t>>,
}

/// A curve beside the path.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviated<'t> {
    /// Name in the legend.
    pub name: &'t str,
    /// Colour of the curve.
    pub colour: Colour,
    /// Deviation from each point of the path, µm.
    pub deviation_um: Vec<[f64; 2]>,
}

impl Deviated<'_> {
    /// Largest magnitude of the deviation in this view, µm.
    #[must_use]
    pub fn largest_um(&self) -> f64 {
        self.deviation_um.iter().map(|[a, b]| a.hypot(*b)).fold(0.0, f64::max)
    }
}

impl View<'_> {
    /// The figure, with equal scales on both axes and a bar that relates path and deviation.
    #[must_use]
    pub fn figure(&self) -> Figure {
        let largest_um = self.curves.iter().map(Deviated::largest_um).fold(0.0, f64::max);
        let [x, y] = [0, 1].map(|axis| range(self.path_mm.iter().map(|point| point[axis])));
        let size = (x[1] - x[0]).max(y[1] - y[0]).max(LEAST_MM);
        let magnification = if largest_um > 0.0 { nearest_round(SHARE * size / (largest_um * MM_PER_UM)) } else { 1.0 };
        let moved: Vec<Vec<[f64; 2]>> =
            self.curves.iter().map(|curve| self.moved(curve, magnification * MM_PER_UM)).collect();
        let frame = Frame::around(self.path_mm.iter().chain(moved.iter().flatten()), size);
        let mut figure = frame.figure(self.axes);
        self.draw(&mut figure, &moved);
        frame.bar(&mut figure, magnification);
        figure.caption(format!(
            "{}, {}{} view: deviations magnified {} times; largest in this view {} µm.",
            self.caption,
            self.axes[0],
            self.axes[1],
            significant(magnification, 1),
            significant(largest_um, 3)
        ));
        figure
    }

    fn moved(&self, curve: &Deviated<'_>, scale: f64) -> Vec<[f64; 2]> {
        let both = self.path_mm.iter().zip(&curve.deviation_um);
        both.map(|(point, deviation)| [point[0] + scale * deviation[0], point[1] + scale * deviation[1]]).collect()
    }

    fn draw(&self, figure: &mut Figure, moved: &[Vec<[f64; 2]>]) {
        if let (Some(curve), Some(ends)) = (self.curves.first(), moved.first()) {
            let every = self.path_mm.len().div_ceil(VECTORS).max(1);
            for (point, end) in self.path_mm.iter().zip(ends).step_by(every) {
                figure.line([*point, *end], Stroke::new(curve.colour, 0.8).opacity(0.4));
            }
        }
        let mut curves = vec![("programmed", self.path_mm.as_slice(), Stroke::new(colour::NOMINAL, 1.0))];
        for (curve, points) in self.curves.iter().zip(moved) {
            curves.push((curve.name, points, Stroke::new(curve.colour, 1.6)));
        }
        for (name, points, stroke) in curves {
            figure.key(name, stroke);
            let numbered: Vec<(&[f64; 2], &u32)> = points.iter().zip(&self.runs).collect();
            for run in numbered.chunk_by(|one, next| one.1 == next.1) {
                figure.line(run.iter().map(|(point, _)| **point), stroke);
            }
        }
    }
}

/// The visible part of the plane, mm, and the scale of the figure.
struct Frame {
    corner: [f64; 2],
    extent: [f64; 2],
    height_px: i32,
    mm_per_px: f64,
}

impl Frame {
    /// Frames all points with a margin and a free strip below them for the scale bar.
    fn around<'p>(points: impl Iterator<Item = &'p [f64; 2]> + Clone, size: f64) -> Frame {
        let [x, y] = [0, 1].map(|axis| range(points.clone().map(move |point| point[axis])));
        let margin = 0.05 * (x[1] - x[0]).max(y[1] - y[0]);
        let least = x[1] - x[0] + 2.0 * margin;
        let strip = STRIP_PX * least.max(size) / f64::from(inside(HALF_PX, 0)[0]);
        let (width, height) = (least, y[1] - y[0] + 2.0 * margin + strip);
        let height_px = (f64::from(HALF_PX) * (height / width).clamp(0.45, 1.0)).round() as i32;
        let inside_px = inside(HALF_PX, height_px).map(f64::from);
        let mm_per_px = (width / inside_px[0]).max(height / inside_px[1]);
        let extent = inside_px.map(|px| mm_per_px * px);
        let corner = [0.5 * (x[0] + x[1] - extent[0]), 0.5 * (y[0] + y[1] - strip - extent[1])];
        Frame { corner, extent, height_px, mm_per_px }
    }

    fn figure(&self, axes: [&str; 2]) -> Figure {
        let scale = |axis: usize| {
            let low = self.corner[axis];
            Scale::exact(&format!("{} in mm", axes[axis]), low, low + self.extent[axis]).ticks(7)
        };
        let description = format!("{}{} view of the path with deviations magnified", axes[0], axes[1]);
        Figure::half(&description, self.height_px, scale(0), scale(1))
    }

    fn bar(&self, figure: &mut Figure, magnification: f64) {
        let length = round_down(0.25 * self.extent[0]);
        let from = self.corner[0] + 0.5 * (self.extent[0] - length);
        let y = self.corner[1] + 0.4 * STRIP_PX * self.mm_per_px;
        let text = format!(
            "path {} mm = deviation {} µm",
            significant(length, 2),
            significant(length / magnification / MM_PER_UM, 2)
        );
        figure
            .line([[from, y], [from + length, y]], Stroke::new(colour::NOMINAL, 2.5))
            .text_above([from + 0.5 * length, y], text);
    }
}

/// Lowest and highest value; zeros without values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let range = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    if range[0] <= range[1] { range } else { [0.0, 0.0] }
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
