//! Smallest width of a point set: the limit of the zone when the centre goes to infinity.

use std::vec::Vec;

fn cross(o: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

/// Convex hull, counter-clockwise (Andrew 1979).
pub fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    // Adding 0 makes −0 and 0 equal in the total order.
    let mut sorted: Vec<[f64; 2]> = points.iter().map(|p| p.map(|v| v + 0.0)).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |ordered: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in ordered {
            while let [.., a, b] = chain.as_slice()
                && cross(*a, *b, p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut sorted.iter().copied());
    lower.extend(half(&mut sorted.iter().rev().copied()));
    lower
}

/// Width of the narrowest strip between parallel lines that contains all points: the minimum zone of a straight line (ISO
/// 12780-1, MZLI). One of the lines passes through an edge of the hull (Houle and Toussaint 1988). 0 if all points are on one
/// line. n log n.
pub fn smallest_width(points: &[[f64; 2]]) -> f64 {
    let hull = hull(points);
    let n = hull.len();
    let mut opposite = 1;
    let mut smallest = f64::INFINITY;
    for i in 0..n {
        let (a, b) = (hull[i], hull[(i + 1) % n]);
        // The opposite point only moves forward, once round in total.
        for _ in 0..n {
            if cross(a, b, hull[(opposite + 1) % n]) <= cross(a, b, hull[opposite]) {
                break;
            }
            opposite = (opposite + 1) % n;
        }
        smallest = smallest.min(cross(a, b, hull[opposite]) / (b[0] - a[0]).hypot(b[1] - a[1]));
    }
    if smallest.is_finite() { smallest.max(0.0) } else { 0.0 }
}
