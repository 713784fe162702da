//! The figures on the page of a comparison.

use crate::compare::outputs::Row as Cycle;
use crate::compare::{Comparison, Outcome};
use maud::{Markup, html};
use trueaxis::contour::Flags;
use trueaxis_evaluation::shown::Shown;
use trueaxis_report::{Colour, Figure, Scale, Stroke, colour, decimate, side_by_side};

/// Buckets of a curve: the width of the widest figure in px.
const BUCKETS: usize = 1040;

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn render(outcome: &Outcome, shown: &Shown) -> String {
    let period_s = 1e-9 * f64::from(outcome.header.period_ns);
    shown.page("", outcome.comparisons.iter().map(|one| (one.core.title(), core(one, period_s))))
}

/// A curve over time with its entry in the legend.
struct Curve {
    name: &'static str,
    colour: Colour,
    points: Vec<[f64; 2]>,
}

impl Curve {
    fn new(name: &'static str, colour: Colour, points: impl Iterator<Item = [f64; 2]>) -> Curve {
        Curve { name, colour, points: decimate(&points.collect::<Vec<_>>(), BUCKETS) }
    }
}

/// Common scale of several figures, so that they can be compared.
fn scale(caption: &str, curves: &[&[Curve]]) -> Scale {
    let curves = curves.iter().copied().flatten();
    let values = curves.flat_map(|curve| curve.points.iter().map(|point| point[1]));
    Scale::linear(caption, values.chain([0.0])).margin(0.05)
}

fn draw(figure: fn(&str, i32, Scale, Scale) -> Figure, caption: &str, y: Scale, curves: Vec<Curve>) -> Figure {
    let times = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point[0]));
    let mut figure = figure(caption, 240, Scale::linear("time in s", times), y);
    for curve in curves {
        figure.curve(curve.name, curve.points, Stroke::new(curve.colour, 1.2));
    }
    figure.caption(caption);
    figure
}

/// Two figures with the same scale.
fn pair(name: &str, caption: &str, host: Vec<Curve>, image: Vec<Curve>) -> Markup {
    let y = scale(caption, &[&host, &image]);
    side_by_side([
        draw(Figure::half, &format!("{name}: on the host."), y.clone(), host),
        draw(Figure::half, &format!("{name}: in the image."), y, image),
    ])
}

/// A contour error if the foot is known; NaN while the search has yet to find it.
fn found(cycle: &Cycle, error: f64) -> f64 {
    let unknown = Flags::COLD.and(Flags::NOT_FOUND).bits();
    if cycle.flags & unknown == 0 { error } else { f64::NAN }
}

fn core(one: &Comparison, period_s: f64) -> Markup {
    let time = |cycle: &Cycle| f64::from(cycle.sequence) * period_s;
    let corrections = |cycles: &[Cycle]| -> Vec<Curve> {
        let axes = ["X", "Y", "Z"].into_iter().zip(colour::AXES).enumerate();
        let points = |axis: usize| cycles.iter().map(move |cycle| [time(cycle), 1e3 * cycle.correction[axis]]);
        axes.map(|(axis, (name, colour))| Curve::new(name, colour, points(axis))).collect()
    };
    let contour = |cycles: &[Cycle]| -> Vec<Curve> {
        let points =
            |value: fn(&Cycle) -> f64| cycles.iter().map(move |cycle| [time(cycle), 1e3 * found(cycle, value(cycle))]);
        vec![
            Curve::new("plain encoder position", colour::UNCOMPENSATED, points(|cycle| cycle.encoder)),
            Curve::new("estimated tool tip", colour::COMPENSATED, points(|cycle| cycle.tip)),
        ]
    };
    let apart = |name, colour, value: fn(&Cycle) -> f64| {
        let both = one.image.iter().zip(&one.double);
        Curve::new(name, colour, both.map(|(a, b)| [time(a), 1e6 * (value(a) - value(b))]))
    };
    let [x, y, z] = colour::AXES;
    let differences = vec![
        apart("correction of X", x, |cycle| cycle.correction[0]),
        apart("correction of Y", y, |cycle| cycle.correction[1]),
        apart("correction of Z", z, |cycle| cycle.correction[2]),
        apart("contour error of the tip", colour::FOURTH, |cycle| found(cycle, cycle.tip)),
    ];
    let nm = scale("difference in nm", &[&differences]);
    html! {
        (pair("Correction", "correction in µm", corrections(&one.host), corrections(&one.image)))
        (pair("Contour error", "contour error in µm", contour(&one.host), contour(&one.image)))
        (draw(Figure::full, "The image less the host in double precision, cycle by cycle.", nm, differences))
    }
}
