//! The page of `trueaxis learn`.

use crate::learn::document::LearnDocument;
use maud::html;
use trueaxis_metrology::learning::Lesson;
use trueaxis_report::{Figure, Page, Row, Scale, Stroke, Table, colour, decimate, number::significant, summary};
use trueaxis_tables::text::counted;

/// Points per curve: as many as a figure can show.
const CURVE: usize = 1400;

/// The whole page; `source` is the name of the record, and the curves come from the lesson.
pub(crate) fn page(source: &str, found: &LearnDocument, lesson: &Lesson) -> String {
    let over = |values: &[[f64; 3]], what: &str, description: &str| over_length(found, values, what, description);
    Page::new("Learned correction")
        .top(summary([
            html! { (source) },
            html! { "program " (found.program_id) },
            html! { "machine " (found.machine_id) },
            html! { (counted(found.parts.into(), "part")) },
            html! { "gain " (found.gain) ", forgetting " (found.forget) ", cut-off " (found.cutoff_mm) " mm" },
        ]))
        .top(table(found))
        .section("Contour error of this part", over(&lesson.errors_mm, "error in µm", "Contour error over path length"))
        .section(
            "Correction for the next",
            over(&lesson.correction_mm, "correction in µm", "Correction over path length"),
        )
        .document()
}

fn table(found: &LearnDocument) -> Table {
    let sizes = [("this part", found.before), ("predicted for the next", found.predicted)];
    let rows = sizes.map(|(name, size)| Row::new(name, [significant(size.max_um, 3), significant(size.rms_um, 3)]));
    Table::new(["contour error", "largest in µm", "RMS in µm"], rows)
}

fn over_length(found: &LearnDocument, values: &[[f64; 3]], what: &str, description: &str) -> Figure {
    let curve = |i: usize| -> Vec<[f64; 2]> {
        let at = |(k, value): (usize, &[f64; 3])| [k as f64 * found.spacing_mm, 1e3 * value[i]];
        decimate(&values.iter().enumerate().map(at).collect::<Vec<_>>(), CURVE)
    };
    let curves = [0, 1, 2].map(curve);
    let y = Scale::linear(what, curves.iter().flatten().map(|point| point[1]).chain([0.0])).margin(0.06);
    let mut figure = Figure::full(description, 300, Scale::linear("path length in mm", [0.0, found.length_mm]), y);
    for ((name, points), colour) in ["X", "Y", "Z"].into_iter().zip(curves).zip(colour::AXES) {
        figure.curve(name, points, Stroke::new(colour, 1.2));
    }
    figure
}
