//! Figures of a circular test, and the curves in them.

use super::Test;
use serde::Serialize;
use trueaxis_report::{Figure, PolarTrace, colour, polar_traces};

/// Readings of one direction, in order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trace {
    /// The direction.
    pub counterclockwise: bool,
    /// Angles of the command on its circle, from 0 to 360.
    pub angle_deg: Vec<f64>,
    /// Deviation of the radius about the fitted centre.
    pub deviation_um: Vec<f64>,
    /// Deviation less the fitted causes, µm.
    pub left_um: Vec<f64>,
}

/// The recorded directions, counterclockwise first.
pub fn traces(test: &Test) -> Vec<Trace> {
    let all = [true, false].map(|counterclockwise| {
        let own = test.readings.iter().zip(&test.found.centred);
        let own: Vec<_> = own.filter(|(reading, _)| reading.counterclockwise == counterclockwise).collect();
        let um = |part: usize| own.iter().map(|(_, deviation)| 1e3 * deviation[part]).collect();
        Trace {
            counterclockwise,
            angle_deg: own.iter().map(|(reading, _)| reading.angle_rad.to_degrees().rem_euclid(360.0)).collect(),
            deviation_um: um(0),
            left_um: um(1),
        }
    });
    all.into_iter().filter(|trace| !trace.angle_deg.is_empty()).collect()
}

/// Deviation of the radius about the fitted centre, both directions.
pub fn polar(test: &Test) -> Figure {
    drawn(test, |trace| &trace.deviation_um, "Deviation of the radius, seen from the circle's centre.")
}

/// Residuals of the fit.
pub fn left(test: &Test) -> Figure {
    drawn(test, |trace| &trace.left_um, "Residuals of the causes.")
}

fn drawn(test: &Test, take: fn(&Trace) -> &Vec<f64>, caption: &str) -> Figure {
    let traces: Vec<PolarTrace<'_>> = traces(test)
        .iter()
        .map(|trace| {
            let (name, colour) = match trace.counterclockwise {
                true => ("counterclockwise", colour::COMPENSATED),
                false => ("clockwise", colour::UNCOMPENSATED),
            };
            let points = trace.angle_deg.iter().zip(take(trace)).map(|(degrees, um)| [degrees.to_radians(), *um]);
            PolarTrace { name, colour, points: points.collect() }
        })
        .collect();
    polar_traces("Polar plot of the circular test", &traces, caption)
}
