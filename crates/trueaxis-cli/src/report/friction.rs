//! The page of `trueaxis friction`.

use super::warnings;
use maud::{Markup, html};
use trueaxis_evaluation::friction::{AxisFound, FrictionDocument};
use trueaxis_metrology::friction::{Identified, Spike};
use trueaxis_report::{
    Figure, Page, Row, Scale, Stroke, Table, colour,
    number::{quantity, significant},
    summary,
};

/// The whole page; `source` is the name of the record's file.
pub(crate) fn page(source: &str, document: &FrictionDocument, found: &[Identified]) -> String {
    let top = summary([
        html! { (source) },
        html! { (document.samples) " samples at " (quantity(1.0 / document.period_s, "Hz")) },
    ]);
    let page = Page::new("Friction at reversals").top(top).top(warnings(&document.warnings)).top(table(document));
    let sections = document.axes.iter().zip(found);
    sections
        .fold(page, |page, (own, found)| page.section(&format!("Spikes of axis {}", own.axis), spikes(own, found)))
        .document()
}

fn table(document: &FrictionDocument) -> Table {
    let row = |own: &AxisFound| {
        let (f, d, g) = (&own.friction, &own.drive, &own.glitch_um);
        let (fe, de) = (&own.standard_errors.friction, &own.standard_errors.drive);
        let with = |value: f64, error: Option<f64>| match error {
            Some(error) => format!("{} ± {}", significant(value, 4), significant(error, 2)),
            None => significant(value, 4),
        };
        Row::new(
            &own.axis,
            [
                with(f.coulomb_mm_per_s, fe.coulomb_mm_per_s),
                with(f.presliding_um, fe.presliding_um),
                with(f.stribeck_share, fe.stribeck_share),
                with(f.stribeck_velocity_mm_per_s, fe.stribeck_velocity_mm_per_s),
                with(f.viscous, fe.viscous),
                with(d.position_gain_per_s, de.position_gain_per_s),
                with(d.velocity_gain_per_s, de.velocity_gain_per_s),
                with(1e3 * d.reset_time_s, de.reset_time_s.map(|error| 1e3 * error)),
                with(d.velocity_feed_forward, de.velocity_feed_forward),
                format!("{} → {}", significant(g.before.max, 3), significant(g.after.max, 3)),
            ],
        )
    };
    let heads = [
        "axis",
        "F_c/K_vp, mm/s",
        "z, µm",
        "s",
        "v_s, mm/s",
        "d/K_vp",
        "K_v, 1/s",
        "K_vp, 1/s",
        "τ, ms",
        "k_ff",
        "largest spike, µm",
    ];
    Table::new(heads, document.axes.iter().map(row))
}

fn spikes(own: &AxisFound, found: &Identified) -> Markup {
    html! {
        @for spike in &found.glitch.spikes { (figure(own, spike)) }
    }
}

fn figure(own: &AxisFound, spike: &Spike) -> Figure {
    let points = |curve: &[f64]| -> Vec<[f64; 2]> {
        spike.time_s.iter().zip(curve).map(|(time, value)| [1e3 * time, 1e3 * value]).collect()
    };
    let curves = [
        ("before, recorded", points(&spike.before), colour::UNCOMPENSATED),
        ("predicted by the model", points(&spike.predicted), colour::MEASURED),
        ("after, predicted", points(&spike.after), colour::COMPENSATED),
    ];
    let x = Scale::linear("time after the reversal in ms", spike.time_s.iter().map(|time| 1e3 * time));
    let heights = curves.iter().flat_map(|(_, points, _)| points.iter().map(|point| point[1]));
    let y = Scale::linear("following error in µm", heights);
    let acceleration = significant(spike.acceleration, 3);
    let description = format!("Spike of axis {} where it turns with {acceleration} mm/s²", own.axis);
    let mut figure = Figure::full(&description, 240, x, y);
    for (name, points, colour) in curves {
        figure.curve(name, points, Stroke::new(colour, 1.4));
    }
    figure.caption(format!(
        "Mean of {} reversals at {acceleration} mm/s² (feed²/radius), turned into the new direction of travel. After: the record \
         minus the effect of the feed-forward with the parameters found, in the model.",
        spike.reversals
    ));
    figure
}
