//! Polar plots of a circular test.

use super::Test;
use crate::shown::{Around, Polar};

impl Test {
    /// Deviation of the radius about the fitted centre, and its remainder after the fitted causes, over both directions recorded.
    pub fn polars(&self) -> Vec<Polar> {
        let parts = [
            ("Deviation", "Deviation of the radius, seen from the circle's centre"),
            ("Residuals", "Residuals of the causes"),
        ];
        let polar = |(part, (section, title)): (usize, (&'static str, &str))| Polar {
            section,
            title: title.into(),
            axes: self.options.axes.map(|axis| axis.letter().to_string()),
            curves: self.curves(part),
        };
        parts.into_iter().enumerate().map(polar).collect()
    }

    fn curves(&self, part: usize) -> Vec<Around> {
        let curve = |(name, colour, counterclockwise)| {
            let readings = self.readings.iter().zip(&self.found.centred);
            let own = readings.filter(|(reading, _)| reading.counterclockwise == counterclockwise);
            let point = own.map(|(reading, left)| (reading.angle_rad.to_degrees().rem_euclid(360.0), 1e3 * left[part]));
            let (angle_deg, um) = point.unzip();
            Around { name, colour, angle_deg, um }
        };
        let ways = [("counterclockwise", 6, true), ("clockwise", 5, false)];
        ways.map(curve).into_iter().filter(|curve| !curve.um.is_empty()).collect()
    }
}
