//! Features measured from their points: formulas of this test alone.

use super::plant::{V, dot, sub};

fn mean(points: &[[V; 2]], which: usize) -> V {
    std::array::from_fn(|i| points.iter().map(|point| point[which][i]).sum::<f64>() / points.len() as f64)
}

fn width(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let by = |of: fn(f64, f64) -> f64| values.iter().copied().reduce(of).unwrap();
    by(f64::max) - by(f64::min)
}

/// Centre, diameter and roundness of a full turn about the programmed centre: its first harmonics, repeated about the centre
/// found.
pub(super) fn circle(points: &[[V; 2]], [cx, cy]: [f64; 2]) -> ([f64; 2], f64, f64) {
    let mut centre = [cx, cy];
    let mut radius = 0.0;
    for _ in 0..5 {
        let count = points.len() as f64;
        let from = |is: &V| [is[0] - centre[0], is[1] - centre[1]];
        radius = points.iter().map(|[is, _]| from(is)[0].hypot(from(is)[1])).sum::<f64>() / count;
        let (mut x, mut y) = (0.0, 0.0);
        for [is, _] in points {
            let [dx, dy] = from(is);
            let r = dx.hypot(dy);
            x += (r - radius) * dx / r;
            y += (r - radius) * dy / r;
        }
        centre = [centre[0] + 2.0 * x / count, centre[1] + 2.0 * y / count];
    }
    let form = width(points.iter().map(|[is, _]| (is[0] - centre[0]).hypot(is[1] - centre[1])));
    (centre, 2.0 * radius, form)
}

/// Middle, unit direction and straightness of a line in XY.
pub(super) fn line(points: &[[V; 2]]) -> ([f64; 2], [f64; 2], f64) {
    let [mx, my, _] = mean(points, 0);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for [is, _] in points {
        let (x, y) = (is[0] - mx, is[1] - my);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    // The principal direction.
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (sine, cosine) = angle.sin_cos();
    let form = width(points.iter().map(|[is, _]| cosine * (is[1] - my) - sine * (is[0] - mx)));
    ([mx, my], [cosine, sine], form)
}

/// Slopes of a plane that is nearly level: z = a + b x + c y by Cramer's rule about the middle.
fn slopes(points: &[[V; 2]]) -> [f64; 2] {
    let middle = mean(points, 0);
    let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for [is, _] in points {
        let [x, y, z] = sub(*is, middle);
        (xx, xy, yy, xz, yz) = (xx + x * x, xy + x * y, yy + y * y, xz + x * z, yz + y * z);
    }
    let whole = xx * yy - xy * xy;
    [(xz * yy - yz * xy) / whole, (yz * xx - xz * xy) / whole]
}

/// Flatness of a plane that is nearly level.
pub(super) fn flatness(points: &[[V; 2]]) -> f64 {
    let [b, c] = slopes(points);
    width(points.iter().map(|[is, _]| dot(*is, [-b, -c, 1.0])))
}

/// The points of a feature with the part turned until the plane is level: seen along its normal, a point at depth z moves by
/// its slopes times z.
pub(super) fn levelled(points: &[[V; 2]], plane: &[[V; 2]]) -> Vec<[V; 2]> {
    let [b, c] = slopes(plane);
    points.iter().map(|[[x, y, z], was]| [[x + b * z, y + c * z, *z], *was]).collect()
}

/// Mean place of a hole's points.
pub(super) fn hole(points: &[[V; 2]]) -> [f64; 2] {
    let [x, y, _] = mean(points, 0);
    [x, y]
}

/// Width of the zone across `direction` … along it: of a line's points in XY.
pub(super) fn along(points: &[[V; 2]], [x, y]: [f64; 2]) -> f64 {
    width(points.iter().map(|[is, _]| is[0] * x + is[1] * y))
}
