//! A height map as a solid: bilinear between its points, nothing beside them.

use super::way::{CONTACT, Way};
use glam::DVec3;

/// Heights over a grid of X and Y in machine coordinates, mm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeightMap {
    /// Along X and Y, ascending.
    pub(super) nodes: [Vec<f64>; 2],
    /// X outermost.
    pub(super) heights: Vec<f64>,
}

/// Gap over a piece of the way within one cell: the polynomial through three values.
struct Piece {
    from: f64,
    to: f64,
    /// gap = c0 + c1 t + c2 t², t = 0 to 1 from `from` to `to`.
    coefficients: [f64; 3],
}

impl Piece {
    fn share(&self, of_way: f64) -> f64 {
        (of_way - self.from) / (self.to - self.from)
    }

    /// Gap at a share of the way.
    fn at(&self, of_way: f64) -> f64 {
        let [c0, c1, c2] = self.coefficients;
        let t = self.share(of_way);
        c0 + t * (c1 + t * c2)
    }

    /// Has the sign of the gap's change at a share of the way.
    fn slope(&self, of_way: f64) -> f64 {
        let [_, c1, c2] = self.coefficients;
        c1 + 2.0 * self.share(of_way) * c2
    }

    /// Shares of the way at which the gap is zero, ascending.
    fn roots(&self) -> impl Iterator<Item = f64> {
        let [c0, c1, c2] = self.coefficients;
        let discriminant = c1 * c1 - 4.0 * c2 * c0;
        // The sum of equal signs keeps both roots accurate.
        let half = -0.5 * (c1 + discriminant.max(0.0).sqrt().copysign(c1));
        let mut roots = if discriminant < 0.0 { [f64::NAN; 2] } else { [half / c2, c0 / half] };
        roots.sort_by(f64::total_cmp);
        let (from, to) = (self.from, self.to);
        roots.into_iter().filter(|t| (0.0..=1.0).contains(t)).map(move |t| from + t * (to - from))
    }
}

/// The cell of a position between nodes, and the share of it; `None` beside them.
fn cell(nodes: &[f64], at: f64) -> Option<(usize, f64)> {
    let upper = nodes.partition_point(|node| *node <= at).min(nodes.len().checked_sub(1)?);
    let (low, high) = (*nodes.get(upper.checked_sub(1)?)?, *nodes.get(upper)?);
    (at <= high).then(|| (upper - 1, (at - low) / (high - low)))
}

impl HeightMap {
    /// Gap of a ball above the map; infinite beside it.
    pub(super) fn gap(&self, tip: DVec3, radius: f64) -> f64 {
        self.height(tip).map_or(f64::INFINITY, |height| tip.z - radius - height)
    }

    fn height(&self, at: DVec3) -> Option<f64> {
        let [x, y] = &self.nodes;
        let ((i, u), (j, v)) = (cell(x, at.x)?, cell(y, at.y)?);
        let node = |i: usize, j: usize| self.heights.get(i * y.len() + j).copied();
        let along = |j: usize| Some((1.0 - u) * node(i, j)? + u * node(i + 1, j)?);
        Some((1.0 - v) * along(j)? + v * along(j + 1)?)
    }

    /// The pieces of a way above the map, in order.
    fn pieces(&self, way: &Way, radius: f64) -> impl Iterator<Item = Piece> {
        let crossing = |nodes: &[f64], start: f64, change: f64| {
            nodes.iter().map(|node| (node - start) / change).filter(|s| (0.0..=1.0).contains(s)).collect::<Vec<_>>()
        };
        let [x, y] = &self.nodes;
        let mut ends =
            [vec![0.0, 1.0], crossing(x, way.start.x, way.change.x), crossing(y, way.start.y, way.change.y)].concat();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let pieces: Vec<Piece> = ends
            .windows(2)
            .filter_map(|ends| {
                let [from, to] = *ends else { return None };
                // Three inner points, because the ends may be rounded to beside the map.
                let [first, middle, last] = [0.25, 0.5, 0.75].map(|t| self.gap(way.at(from + t * (to - from)), radius));
                let (slope, bend) = (2.0 * (last - first), 8.0 * (first - 2.0 * middle + last));
                let coefficients = [middle - 0.5 * slope + 0.25 * bend, slope - bend, bend];
                middle.is_finite().then_some(Piece { from, to, coefficients })
            })
            .collect();
        pieces.into_iter()
    }

    /// As [`super::surface::Solid::entry`].
    pub(super) fn entry(&self, way: &Way, radius: f64) -> Option<f64> {
        self.pieces(way, radius)
            .find_map(|piece| if piece.at(piece.from) <= 0.0 { Some(piece.from) } else { piece.roots().next() })
    }

    /// As [`super::surface::Solid::exit`].
    pub(super) fn exit(&self, way: &Way, radius: f64, from: f64) -> Option<f64> {
        let mut end = from;
        for piece in self.pieces(way, radius).filter(|piece| piece.to > from) {
            if piece.from > end {
                // Beside the map.
                return Some(end);
            }
            let rises = |share: f64| piece.slope(share) > 0.0;
            let start = from.max(piece.from);
            if piece.at(start).abs() <= CONTACT && rises(start) {
                return Some(start);
            }
            if let Some(root) = piece.roots().find(|share| *share >= from && rises(*share)) {
                return Some(root);
            }
            end = piece.to;
        }
        (end < 1.0).then_some(end)
    }
}
