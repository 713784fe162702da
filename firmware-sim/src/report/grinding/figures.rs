//! Surfaces, harmonics and motion of the two runs.

use crate::grinding::{Grinding, Harmonic, Outcome, Run};
use maud::Markup;
use std::f64::consts::TAU;
use trueaxis_evaluation::simulated::grinding::RUNS;
use trueaxis_report::{
    Colour, Figure, Scale, Stroke, colour,
    number::{count, quantity, round_down},
    side_by_side,
};

/// Share of the drawn radius occupied by the largest deviation.
const SHARE: f64 = 0.22;
/// Points of a drawn surface: peaks of harmonic 100 are drawn within 0.3 %.
const DRAWN: usize = 2048;

/// Name, colour and data of both runs.
fn both(outcome: &Outcome) -> [(&'static str, Colour, &Run); 2] {
    [(RUNS[0], colour::UNCOMPENSATED, &outcome.uncorrected), (RUNS[1], colour::COMPENSATED, &outcome.corrected)]
}

/// Number of the first corrected harmonic.
fn first_corrected(grinding: &Grinding) -> usize {
    grinding.machine.settings.roundness.and_then(|gauge| gauge.infeed).map_or(2, |infeed| infeed.band.first.into())
}

/// A surface as deviations in µm at equidistant angles, with name and colour.
type Surface<'a> = (&'static str, Colour, &'a [f64]);

pub(super) fn surfaces(grinding: &Grinding, outcome: &Outcome) -> Markup {
    let pin_mm = grinding.machine.settings.roundness.and_then(|gauge| gauge.arm).map_or(10.0, |arm| arm.lengths.pin_mm);
    let [rough, off] = &outcome.uncorrected.surfaces;
    let [_, on] = &outcome.corrected.surfaces;
    let [(without, orange, _), (with, blue, _)] = both(outcome);
    let on: Surface<'_> = (with, blue, on);
    side_by_side([
        surface(pin_mm, &[("before grinding", colour::FOURTH, rough), (without, orange, off), on]),
        surface(pin_mm, &[on]),
    ])
}

/// Surfaces around the pin, with magnified deviations.
fn surface(pin_mm: f64, surfaces: &[Surface<'_>]) -> Figure {
    let largest = surfaces.iter().flat_map(|(.., of)| of.iter()).fold(0.0, |worst: f64, um| worst.max(um.abs()));
    let magnification = if largest > 0.0 { round_down(SHARE * pin_mm / (1e-3 * largest)) } else { 1.0 };
    let round = |surface: &[f64]| -> Vec<[f64; 2]> {
        let step = (surface.len() / DRAWN).max(1);
        let points = (0..=surface.len()).step_by(step).filter_map(|j| {
            let radius = pin_mm + magnification * 1e-3 * surface.get(j % surface.len().max(1))?;
            let (sin, cos) = (TAU * j as f64 / surface.len() as f64).sin_cos();
            Some([radius * cos, radius * sin])
        });
        points.collect()
    };
    let scale = || Scale::exact("mm", -1.3 * pin_mm, 1.3 * pin_mm);
    let mut figure = Figure::square("the pin's surface with deviations from its circle magnified", scale(), scale());
    figure.curve("least-squares circle", round(&[0.0; 360]), Stroke::new(colour::NOMINAL, 0.9));
    for (name, colour, surface) in surfaces {
        figure.curve(*name, round(surface), Stroke::new(*colour, 1.2));
    }
    figure.caption(format!(
        "True surface about its least-squares circle; deviations magnified {} times, largest {}. The angle is that of \
         the pin's surface, counterclockwise.",
        count(magnification as u64),
        quantity(largest, "µm")
    ));
    figure
}

pub(super) fn harmonics(grinding: &Grinding, outcome: &Outcome) -> Figure {
    let first = first_corrected(grinding);
    let last = outcome.corrected.average.len().max(first + 1);
    let amplitudes = |run: &Run| -> Vec<[f64; 2]> {
        let all = run.average.iter().enumerate().skip(first);
        all.map(|(k, [a, b]): (usize, &Harmonic)| [k as f64, a.hypot(*b)]).collect()
    };
    let values = both(outcome).into_iter().flat_map(|(.., run)| amplitudes(run)).map(|point| point[1]);
    let y = Scale::decades("amplitude in µm", values);
    let x = Scale::exact("undulations per revolution", first as f64 - 0.6, last as f64 - 0.4).ticks(24);
    let description = "amplitudes of the surface's harmonics, uncorrected and corrected";
    let mut figure = Figure::full(description, 270, x, y);
    for ((name, colour, run), reach) in both(outcome).into_iter().zip([[-0.38, -0.02], [0.02, 0.38]]) {
        figure.columns(amplitudes(run), reach, colour).area_key(name, colour);
    }
    let averaged = outcome.corrected.averaged;
    figure.caption(format!("Amplitudes of the true surface, averaged over the last {averaged} revolutions."));
    figure
}

pub(super) fn correction(grinding: &Grinding, outcome: &Outcome) -> Figure {
    let first = first_corrected(grinding);
    let degrees = |n: usize, of: usize| 360.0 * n as f64 / of.max(1) as f64;
    let table = &outcome.corrected.correction;
    let fed: Vec<[f64; 2]> = (0..=table.len())
        .filter_map(|n| Some([degrees(n, table.len()), *table.get(n % table.len().max(1))?]))
        .collect();
    let deviation = |n: usize| {
        let angle = TAU * n as f64 / 720.0;
        let terms = outcome.uncorrected.average.iter().enumerate().skip(first);
        terms.map(|(k, [a, b])| a * (k as f64 * angle).cos() + b * (k as f64 * angle).sin()).sum::<f64>()
    };
    let deviation: Vec<[f64; 2]> = (0..=720).map(|n| [degrees(n, 720), deviation(n)]).collect();
    let x = Scale::exact("angle of the surface in degrees", 0.0, 360.0);
    let y = Scale::linear("infeed in µm", fed.iter().chain(&deviation).map(|point| point[1])).margin(0.06);
    let mut figure = Figure::full("infeed correction over the angle of the surface", 250, x, y);
    let wide = Stroke::new(colour::UNCOMPENSATED, 3.0).opacity(0.45);
    figure
        .curve("deviation of the uncorrected surface", deviation, wide)
        .curve("correction learned by the gauge", fed, Stroke::new(colour::COMPENSATED, 1.4))
        .caption("Where the surface would be high, the wheel is fed in further.");
    figure
}

/// A closed curve in the plane, without its mean and optionally without its first harmonic.
fn centred(points: &[[f64; 2]], first_too: bool) -> Vec<[f64; 2]> {
    let n = points.len().max(1) as f64;
    let mut terms = [[0.0; 3]; 2];
    for (k, point) in points.iter().enumerate() {
        let (sin, cos) = (TAU * k as f64 / n).sin_cos();
        for (terms, value) in terms.iter_mut().zip(point) {
            for (term, weight) in terms.iter_mut().zip([1.0, 2.0 * cos, 2.0 * sin]) {
                *term += value * weight / n;
            }
        }
    }
    let rest = |(k, point): (usize, &[f64; 2])| {
        let (sin, cos) = (TAU * k as f64 / n).sin_cos();
        std::array::from_fn(|i| {
            let [mean, a, b] = terms[i];
            point[i] - mean - if first_too { a * cos + b * sin } else { 0.0 }
        })
    };
    points.iter().enumerate().chain(points.first().map(|first| (0, first))).map(rest).collect()
}

pub(super) fn orbits(outcome: &Outcome) -> Markup {
    let [x, y] = &outcome.corrected.motion;
    let seen: Vec<[f64; 2]> = x.iter().zip(y).map(|(x, y)| [*x, *y]).collect();
    let figure = |first_too: bool, caption: &str| {
        let (truth, seen) = (centred(&outcome.orbit, first_too), centred(&seen, first_too));
        let scale = |caption| Scale::symmetric(caption, truth.iter().chain(&seen).flatten().copied());
        let mut figure = Figure::square(caption, scale("R_X in µm"), scale("R_Y in µm"));
        let wide = Stroke::new(colour::FOURTH, 3.0).opacity(0.45);
        figure
            .curve("true, mean revolution", truth, wide)
            .curve("gauge, latest revolution", seen, Stroke::new(colour::COMPENSATED, 1.2))
            .caption(caption);
        figure
    };
    side_by_side([
        figure(false, "Motion of the pin's centre about its mean position."),
        figure(true, "The same without the first harmonic: error motion."),
    ])
}
