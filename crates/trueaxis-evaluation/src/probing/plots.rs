//! Figures of a probing test.

use super::record::Record;
use trueaxis_report::{Figure, Scale, Stroke, colour};

/// Distance of every point from its run's centre, less half its diameter; `None` for single points.
pub fn form(record: &Record) -> Option<Figure> {
    let mut points = Vec::new();
    for run in &record.runs {
        let radius = 0.5 * run.diameter?;
        let flat = record.feature == super::Feature::Ring;
        for point in &run.points {
            let [x, y, z] = [0, 1, 2].map(|c| point[c] - run.centre[c]);
            let distance = if flat { x.hypot(y) } else { (x * x + y * y + z * z).sqrt() };
            points.push([y.atan2(x).to_degrees(), 1e3 * (distance - radius)]);
        }
    }
    let x = Scale::exact("direction in the XY plane in degrees", -180.0, 180.0);
    let y = Scale::symmetric("distance in µm", points.iter().map(|point| point[1])).margin(0.06);
    let mut figure = Figure::full("Distance of the points from the centre", 280, x, y);
    figure.key("all runs", Stroke::new(colour::MEASURED, 1.4)).dots(points, colour::MEASURED);
    figure.caption("Less half the diameter of the run's least-squares circle or sphere.");
    Some(figure)
}
