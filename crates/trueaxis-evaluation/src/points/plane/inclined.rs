//! Scales and squarenesses seen along directions that are inclined to the axes.
//!
//! With dx = sX·x − C0Y·y + B0Z·z, dy = sY·y − A0Z·z, dz = sZ·z the points of a plane show three combinations of these six terms:
//! the strains along two perpendicular directions and the shear between them; the rotation is the plate's. A term is determined
//! if a sum of the three is this term alone.

use super::model::Fitted;
use super::{LINEAR, PlaneFit, SET_UP};
use crate::points::Points;
use crate::points::found::{range, rounded, rounded_urad};
use anyhow::{Result, bail};
use trueaxis::glam::DVec3;
use trueaxis::machine::Row;
use trueaxis_metrology::linear_fit::LinearFit;
use trueaxis_report::number::{as_far_as, decimals};
use trueaxis_tables::limits::raise;
use trueaxis_tables::{Machine, Table};

/// The terms and their units.
const TERMS: [(&str, &str); 6] =
    [("scale X", "ppm"), ("scale Y", "ppm"), ("scale Z", "ppm"), ("A0Z", "urad"), ("B0Z", "urad"), ("C0Y", "urad")];

/// A scale or squareness, in 1 or rad.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Term {
    number: usize,
    pub(super) value: f64,
    pub(super) standard_error: f64,
}

impl Term {
    pub(super) const fn name(&self) -> &'static str {
        TERMS[self.number].0
    }

    pub(super) const fn unit(&self) -> &'static str {
        TERMS[self.number].1
    }
}

/// Deviation along one direction for a unit of the other, for every term of size 1.
fn seen(along: DVec3, over: DVec3) -> [f64; 6] {
    let scales = along * over;
    [scales.x, scales.y, scales.z, -along.y * over.z, along.x * over.z, -along.x * over.y]
}

/// A combination in words, and its value in ppm, which is µrad too.
fn combination(shares: [f64; 6], [value, error]: [f64; 2]) -> String {
    let mut text = String::new();
    for ((name, _), share) in TERMS.iter().zip(shares).filter(|(_, share)| share.abs() >= 0.005) {
        let sign = match (text.is_empty(), share < 0.0) {
            (true, false) => "",
            (true, true) => "−",
            (false, false) => " + ",
            (false, true) => " − ",
        };
        text += &format!("{sign}{}·{name}", decimals(share.abs(), 2));
    }
    let [value, error] = [value, error].map(|of| 1e6 * of);
    format!("{text} = {} ± {} ppm (standard error)", as_far_as(value, error, 2), as_far_as(error, error, 2))
}

/// The only combination of terms that points on an inclined line determine, in words.
pub(super) fn along(points: &Points, along: DVec3) -> String {
    let mut fit = LinearFit::new(2);
    for point in &points.points {
        let [at, off] = [point.command_mm, point.deviation_mm].map(|of| along.dot(DVec3::from(of)));
        fit.add(&[1.0, at], off, point.sigma_mm.recip());
    }
    let found = fit.solve();
    combination(seen(along, along), [found.values[1], found.sigma() * found.error_factors[1]])
}

/// The terms that points in an inclined plane determine, and the combinations of the others.
///
/// # Errors
/// No term is determined.
pub(super) fn terms(fitted: &Fitted, across: [DVec3; 2]) -> Result<(Vec<Term>, Vec<String>)> {
    let [a, b] = across;
    let shear = [seen(a, b), seen(b, a)];
    let rows = [seen(a, a), seen(b, b), std::array::from_fn(|k| shear[0][k] + shear[1][k])];
    let mut shares = [[0.0; 3]; 6];
    let mut determined = [false; 6];
    for term in 0..6 {
        let mut fit = LinearFit::new(3);
        for other in 0..6 {
            fit.add(&rows.map(|row| row[other]), f64::from(u8::from(other == term)), 1.0);
        }
        let found = fit.solve();
        determined[term] = found.squares.sqrt() <= SET_UP;
        shares[term] = std::array::from_fn(|k| found.values[k]);
    }
    let terms = (0..6).filter(|term| determined[*term]).map(|number| {
        let [value, standard_error] = fitted.strain(shares[number]);
        Term { number, value, standard_error }
    });
    let open = rows.iter().enumerate().filter_map(|(k, row)| {
        let left: [f64; 6] = std::array::from_fn(|term| if determined[term] { 0.0 } else { row[term] });
        let own: [f64; 3] = std::array::from_fn(|i| {
            let taken: f64 = (0..6).filter(|term| determined[*term]).map(|term| row[term] * shares[term][i]).sum();
            f64::from(u8::from(i == k)) - taken
        });
        let largest = left.iter().fold(0.0, |most: f64, share| most.max(share.abs()));
        (largest > SET_UP).then(|| combination(left, fitted.strain(own)))
    });
    let (terms, open): (Vec<Term>, Vec<String>) = (terms.collect(), open.collect());
    if terms.is_empty() {
        bail!(
            "found points in a plane inclined to all axes, which determine no scale and no squareness alone but {}; needed a plane \
             that contains an axis, or points throughout the volume",
            open.join("; ")
        );
    }
    Ok((terms, open))
}

/// The machine with the terms added to what it states.
pub(super) fn added(machine: &Machine, found: &[Term], points: &Points) -> (Machine, Vec<String>) {
    let mut machine = machine.clone();
    for term in found {
        let location = &mut machine.settings.location;
        match term.number {
            3 => location.a0z = rounded_urad(location.a0z + term.value),
            4 => location.b0z = rounded_urad(location.b0z + term.value),
            5 => location.c0y = rounded_urad(location.c0y + term.value),
            axis => {
                let own = machine.settings.axes.iter().position(|own| own.axis == LINEAR[axis]);
                let Some(slot) = own else { continue };
                let ends = range(points.points.iter().map(|point| point.command_mm[axis]));
                let row = |position| Row { position, forward: [0.0; 6], reverse: [0.0; 6] };
                let table = machine.tables[slot].get_or_insert_with(|| Table {
                    given: [false; 6],
                    bidirectional: false,
                    rows: ends.map(row).to_vec(),
                });
                table.given[axis] = true;
                let [low, high] = range(table.rows.iter().map(|row| row.position));
                let zero = 0.0_f64.clamp(low, high);
                for row in &mut table.rows {
                    for way in [&mut row.forward, &mut row.reverse] {
                        way[axis] = rounded(way[axis] + term.value * (row.position - zero), 1e3);
                    }
                }
            }
        }
    }
    let mut changes = vec!["the terms are those beyond what the machine states, and are added to it".to_owned()];
    changes.extend(raise(&mut machine));
    (machine, changes)
}

impl PlaneFit {
    /// The terms of points in an inclined plane.
    pub(super) fn inclined_terms(&self) -> &[Term] {
        &self.inclined.0
    }
}
