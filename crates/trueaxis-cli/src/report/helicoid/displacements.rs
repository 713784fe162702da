//! Displacements over one parameter, with one curve for each of several values of the other.

use maud::Markup;
use trueaxis_evaluation::helicoid::{DISPLACEMENTS, HelicoidDocument, Job, Point};
use trueaxis_report::{Colour, Figure, Scale, Stroke, colour, number::shortest, side_by_side};

/// One colour per curve.
const COLOURS: [Colour; 5] =
    [colour::COMPENSATED, colour::UNCOMPENSATED, colour::SERVO, colour::FOURTH, colour::MEASURED];
/// Most points of a curve.
const DRAWN: usize = 2000;

/// The grid as curves: along θ, or along u if θ has a single value.
struct Curves<'d> {
    caption: &'static str,
    /// Name and points, and where along the curve each point lies.
    curves: Vec<(String, Vec<&'d Point>)>,
    along: fn(&Point) -> f64,
}

fn curves<'d>(job: &Job, document: &'d HelicoidDocument) -> Curves<'d> {
    let (rows, columns) = (job.u.count, job.theta.count);
    let is_along_theta = columns > 1 || rows == 1;
    let (count, length) = if is_along_theta { (rows, columns) } else { (columns, rows) };
    // First and last, and evenly spaced ones between them.
    let shown = count.min(COLOURS.len());
    let picked = (0..shown).map(|i| if shown > 1 { i * (count - 1) / (shown - 1) } else { 0 });
    let every = length.div_ceil(DRAWN).max(1);
    let curves = picked.map(|i| {
        let points: Vec<&Point> = (0..length)
            .filter(|k| k % every == 0 || k + 1 == length)
            .filter_map(|k| document.points.get(if is_along_theta { i * columns + k } else { k * columns + i }))
            .collect();
        let name = points.first().map_or(String::new(), |point| {
            if is_along_theta {
                format!("u = {} rad", shortest(point.u_rad))
            } else {
                format!("θ = {} rad", shortest(point.theta_rad))
            }
        });
        (name, points)
    });
    Curves {
        caption: if is_along_theta { "θ in rad" } else { "u in rad" },
        curves: curves.collect(),
        along: if is_along_theta { |point| point.theta_rad } else { |point| point.u_rad },
    }
}

pub(super) fn figures(job: &Job, document: &HelicoidDocument) -> Markup {
    let Curves { caption, curves, along } = curves(job, document);
    let all = || curves.iter().flat_map(|(_, points)| points.iter().copied());
    side_by_side(DISPLACEMENTS.map(|(name, unit, of)| {
        let x = Scale::linear(caption, all().map(along));
        let y = Scale::linear(&format!("{name} in {unit}"), all().map(of)).margin(0.04);
        let mut figure = Figure::half(&format!("Displacement of {name} over {caption}"), 300, x, y);
        for ((label, points), colour) in curves.iter().zip(COLOURS) {
            figure.curve(label, points.iter().map(|point| [along(point), of(point)]), Stroke::new(colour, 1.6));
        }
        let [first, others @ ..] = curves.as_slice() else { return figure };
        let is_one =
            |other: &[&Point]| other.iter().zip(&first.1).all(|(one, other)| (of(one) - of(other)).abs() < 1e-9);
        if !others.is_empty() && others.iter().all(|(_, points)| is_one(points)) {
            figure.caption("The curves lie on one another.");
        }
        figure
    }))
}
