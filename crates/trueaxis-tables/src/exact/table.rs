//! Interpolates an error table for the simulated machine.

use trueaxis::machine::{AxisSettings, Interpolation, Row, Twist};

/// Value and slope (per mm or degree) of the six errors at one line.
#[derive(Clone, Copy, Debug)]
struct Node {
    value: Twist,
    slope: Twist,
}

/// An axis' errors as a function of its position and of the side of its lost motion.
#[derive(Clone, Debug)]
pub(crate) struct ErrorTable {
    positions: Vec<f64>,
    forward: Vec<Node>,
    reverse: Option<Vec<Node>>,
    cubic: bool,
    wraps: bool,
}

impl ErrorTable {
    pub(crate) fn new(settings: &AxisSettings, rows: &[Row]) -> ErrorTable {
        let positions: Vec<f64> = rows.iter().map(|row| row.position).collect();
        let span = match (positions.first(), positions.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        };
        let wraps = settings.axis.is_rotary() && (span - 360.0).abs() < 1e-9;
        let forward: Vec<Twist> = rows.iter().map(|row| row.forward).collect();
        let reverse: Vec<Twist> = rows.iter().map(|row| row.reverse).collect();
        ErrorTable {
            forward: nodes(&positions, &forward, wraps),
            reverse: (forward != reverse).then(|| nodes(&positions, &reverse, wraps)),
            cubic: settings.interpolation == Interpolation::Cubic,
            wraps,
            positions,
        }
    }

    /// The six errors at `position`; `reverse` is 0 in positive and 1 in negative travel, in between while the axis traverses
    /// its lost motion. Outside the table the edge value applies; a full turn repeats.
    pub(crate) fn at(&self, position: f64, reverse: f64) -> Twist {
        let (Some(&first), Some(&last)) = (self.positions.first(), self.positions.last()) else {
            return [0.0; 6];
        };
        let folded = if self.wraps { first + (position - first).rem_euclid(360.0) } else { position };
        let q = folded.max(first).min(last);
        let right = self.positions.partition_point(|&p| p <= q).min(self.positions.len() - 1);
        let left = right.saturating_sub(1);
        let forward = self.between(&self.forward, left, right, q);
        match &self.reverse {
            Some(nodes) if reverse > 0.0 => {
                let back = self.between(nodes, left, right, q);
                std::array::from_fn(|i| forward[i] + reverse * (back[i] - forward[i]))
            }
            _ => forward,
        }
    }

    fn between(&self, nodes: &[Node], left: usize, right: usize, q: f64) -> Twist {
        let h = self.positions[right] - self.positions[left];
        if h <= 0.0 {
            return nodes[left].value;
        }
        let t = (q - self.positions[left]) / h;
        let (a, b) = (&nodes[left], &nodes[right]);
        if !self.cubic {
            return std::array::from_fn(|i| a.value[i] + t * (b.value[i] - a.value[i]));
        }
        let s = 1.0 - t;
        let (h00, h01) = (s * s * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t));
        let (h10, h11) = (h * t * s * s, -h * t * t * s);
        std::array::from_fn(|i| h00 * a.value[i] + h01 * b.value[i] + h10 * a.slope[i] + h11 * b.slope[i])
    }
}

fn nodes(positions: &[f64], values: &[Twist], wraps: bool) -> Vec<Node> {
    let mut nodes: Vec<Node> = values.iter().map(|&value| Node { value, slope: [0.0; 6] }).collect();
    for component in 0..6 {
        let column: Vec<f64> = values.iter().map(|value| value[component]).collect();
        for (node, slope) in nodes.iter_mut().zip(pchip_slopes(positions, &column, wraps)) {
            node.slope[component] = slope;
        }
    }
    nodes
}

/// Slopes of the monotone cubic: weighted harmonic mean inside (Fritsch and Butland 1984), at the ends the non-centred
/// three-point formula, kept monotone (Moler 2004, Numerical Computing with MATLAB, section 3.6). A wrapping table has no
/// ends: its first and last line are the same point.
fn pchip_slopes(x: &[f64], y: &[f64], wraps: bool) -> Vec<f64> {
    let h: Vec<f64> = x.windows(2).map(|p| p[1] - p[0]).collect();
    let d: Vec<f64> = y.windows(2).zip(&h).map(|(p, h)| (p[1] - p[0]) / h).collect();
    let m = h.len();
    match m {
        0 => return vec![0.0; x.len()],
        1 => return vec![if wraps { 0.0 } else { d[0] }; 2],
        _ => {}
    }
    let inside = |i: usize, j: usize| {
        if d[i] * d[j] <= 0.0 {
            return 0.0;
        }
        let (w1, w2) = (2.0 * h[j] + h[i], h[j] + 2.0 * h[i]);
        (w1 + w2) / (w1 / d[i] + w2 / d[j])
    };
    let end = |i: usize, j: usize| {
        let slope = ((2.0 * h[i] + h[j]) * d[i] - h[i] * d[j]) / (h[i] + h[j]);
        if slope * d[i] <= 0.0 {
            0.0
        } else if d[i] * d[j] < 0.0 && slope.abs() > 3.0 * d[i].abs() {
            3.0 * d[i]
        } else {
            slope
        }
    };
    let (first, last) = if wraps { (inside(m - 1, 0), inside(m - 1, 0)) } else { (end(0, 1), end(m - 1, m - 2)) };
    std::iter::once(first).chain((1..m).map(|k| inside(k - 1, k))).chain(std::iter::once(last)).collect()
}
