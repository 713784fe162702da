//! Polar plot of the profile with its reference circles.

use super::Evaluation;
use crate::circle::Drawn;
use std::f64::consts::TAU;
use trueaxis_report::{CIRCLES, Circle, Figure};
use trueaxis_tables::text::counted;

/// Number of points of a drawn circle.
const FINE: usize = 360;

/// Polar plot of the mean profile with the requested circles, as limaçons.
pub fn polar(evaluation: &Evaluation, drawn: Drawn) -> Figure {
    let (profile, circles) = (&evaluation.profile, &evaluation.circles);
    let base = circles.lsc.radius;
    let turn = |i: usize, count: usize| TAU * i as f64 / count as f64;
    let measured = profile.iter().enumerate().map(|(i, value)| [turn(i, profile.len()), value - base]);
    let half_zone = 0.5 * circles.mzc.zone;
    let found = [
        (&circles.lsc, vec![0.0]),
        (&circles.mzc, vec![-half_zone, half_zone]),
        (&circles.mcc, vec![0.0]),
        (&circles.mic, vec![0.0]),
    ];
    let kept = CIRCLES.into_iter().zip(found).zip(drawn).filter(|(_, drawn)| *drawn);
    let drawn = kept.map(|(((name, colour), (circle, offsets)), _)| {
        let limacon = |offset: f64| {
            let departure = |i| {
                let (sin, cos) = turn(i, FINE).sin_cos();
                circle.radius + offset + circle.centre[0] * cos + circle.centre[1] * sin - base
            };
            (0..FINE).map(departure).collect()
        };
        Circle { name, colour, zone_um: circle.zone, curves: offsets.into_iter().map(limacon).collect() }
    });
    let caption = format!(
        "Mean of {}. The circles are limaçons: the radius of the part is not known.",
        counted(evaluation.document.revolutions, "revolution")
    );
    trueaxis_report::polar("profile", &measured.collect::<Vec<_>>(), &drawn.collect::<Vec<_>>(), &caption)
}
