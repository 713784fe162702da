//! The flank with the tool on it, seen along the gear's axis and from the outside.

use maud::{Markup, html};
use trueaxis_evaluation::helicoid::{Job, Range};
use trueaxis_report::{Colour, Figure, Scale, Stroke, colour, side_by_side};

/// Lines of the flank in each direction, and points of a line.
const LINES: usize = 9;
const POINTS: usize = 60;
/// Tools drawn in each direction.
const TOOLS: usize = 3;

/// A direction of view: which axes point right and up.
struct View {
    name: &'static str,
    captions: [&'static str; 2],
    right: [f64; 3],
    up: [f64; 3],
}

/// Smallest and largest of the values.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `count` values of a range; one if the range has a single value.
fn values(range: Range, count: usize) -> Vec<f64> {
    Range { count: if range.count == 1 { 1 } else { count }, ..range }.values().collect()
}

/// The figures of the page, beside the displacements.
pub(crate) fn flank(job: &Job) -> (&'static str, Markup) {
    let middle = |range: Range| if range.count == 1 { range.start } else { 0.5 * (range.start + range.stop) };
    // Side view: the line of sight is the part of the outward normal perpendicular to the gear's axis.
    let [x, y, _] = job.surface.normal(middle(job.u), middle(job.theta));
    let length = x.hypot(y);
    let views = [
        View {
            name: "The flank seen along the gear's axis",
            captions: ["x in mm", "y in mm"],
            right: [1.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
        },
        View {
            name: "The flank seen from the side",
            captions: ["across in mm", "z in mm"],
            right: [y / length, -x / length, 0.0],
            up: [0.0, 0.0, 1.0],
        },
    ];
    let figures = html! {
        (side_by_side(views.map(|view| view.figure(job))))
        p { "Other inputs, the tool moved over the flank, both branches and travel limits: " code { "trueaxis desk" } "." }
    };
    ("The flank and the tool", figures)
}

/// Lines of constant u and θ on the flank, and the tool axis at some of its points.
struct Drawing {
    flank: Vec<Vec<[f64; 3]>>,
    tools: Vec<[[f64; 3]; 2]>,
}

impl Drawing {
    fn new(job: &Job) -> Drawing {
        let point = |u: f64, theta: f64| job.surface.point(u, theta);
        let (us, thetas) = (values(job.u, POINTS), values(job.theta, POINTS));
        let along_u = values(job.theta, LINES).into_iter().map(|theta| us.iter().map(|u| point(*u, theta)).collect());
        let along_theta =
            values(job.u, LINES).into_iter().map(|u| thetas.iter().map(|theta| point(u, *theta)).collect());
        let flank: Vec<Vec<[f64; 3]>> = along_u.chain(along_theta).collect();
        let spans = [0, 1, 2].map(|i| {
            let [low, high] = range(flank.iter().flatten().map(|point| point[i]));
            high - low
        });
        let length =
            (0.35 * spans.into_iter().map(|span| span * span).sum::<f64>().sqrt()).max(0.1 * job.surface.base_radius());
        let mut tools = Vec::new();
        for u in values(job.u, TOOLS) {
            for theta in values(job.theta, TOOLS) {
                let (tip, normal) = (point(u, theta), job.surface.normal(u, theta));
                tools.push([tip, std::array::from_fn(|i| tip[i] + length * normal[i])]);
            }
        }
        Drawing { flank, tools }
    }
}

impl View {
    fn onto(&self, point: [f64; 3]) -> [f64; 2] {
        [dot(point, self.right), dot(point, self.up)]
    }

    fn figure(&self, job: &Job) -> Figure {
        let drawing = Drawing::new(job);
        let all =
            || drawing.flank.iter().flatten().chain(drawing.tools.iter().flatten()).map(|point| self.onto(*point));
        let [scale_x, scale_y] = self.scales(all);
        let mut figure = Figure::square(self.name, scale_x, scale_y);
        let surface = Stroke::new(colour::COMPENSATED, 1.0).opacity(0.6);
        for line in &drawing.flank {
            figure.line(line.iter().map(|point| self.onto(*point)), surface);
        }
        let tool = Stroke::new(TOOL, 2.2);
        for axis in &drawing.tools {
            figure.line(axis.map(|point| self.onto(point)), tool).highlight(self.onto(axis[0]), TOOL);
        }
        figure.key("flank: lines of u and θ", surface).key("tool along the outward normal", tool);
        figure
    }

    /// Scales with the same length per millimetre in both directions.
    fn scales<P: Iterator<Item = [f64; 2]>>(&self, all: impl Fn() -> P) -> [Scale; 2] {
        let ranges = [0, 1].map(|i| range(all().map(|point| point[i])));
        let half = ranges.iter().map(|[low, high]| 0.5 * (high - low)).fold(1e-6, f64::max) * 1.06;
        [0, 1].map(|i| {
            let [low, high] = ranges[i];
            let centre = 0.5 * (low + high);
            Scale::exact(self.captions[i], centre - half, centre + half)
        })
    }
}

const TOOL: Colour = colour::UNCOMPENSATED;
