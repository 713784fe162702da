//! Passes side by side that cut one surface.

use super::path::{Piece, corners, distance, normal};
use crate::predict::circle::NEAR;
use crate::predict::kinds::FeatureKind;
use glam::DVec3;
use trueaxis_sim::program::{Move, Turn};

/// Farthest distance of neighbouring rows, as a share of their length.
const BESIDE: f64 = 0.25;
/// A row closer to another than this share of the distance of rows cuts the surface again.
const AGAIN: f64 = 0.5;

/// A surface so far: its pieces, and the middles and paths of its rows.
struct Surface {
    first: usize,
    last: usize,
    rows: Vec<(DVec3, Vec<DVec3>)>,
    /// Distance of the first two rows.
    apart: f64,
}

/// The pieces with rows in space joined to surfaces.
pub(super) fn joined(moves: &[Move], pieces: Vec<Piece>) -> Vec<Piece> {
    let mut surfaces: Vec<Surface> = Vec::new();
    for (k, piece) in pieces.iter().enumerate() {
        let Some(row) = row(moves, piece) else { continue };
        let last = surfaces.last_mut().filter(|surface| {
            let between = &pieces[surface.last + 1..k];
            between.iter().all(|other| other.kind == FeatureKind::Line) && surface.goes_on(&row)
        });
        match last {
            Some(surface) => {
                if let [(_, path)] = &surface.rows[..] {
                    surface.apart = distance(row.0, path);
                }
                surface.rows.push(row);
                surface.last = k;
            }
            None => surfaces.push(Surface { first: k, last: k, rows: vec![row], apart: 0.0 }),
        }
    }
    let ends: Vec<(usize, u32)> = pieces.iter().map(|piece| (piece.moves.end, piece.lines[1])).collect();
    let mut joined = Vec::new();
    for (k, mut piece) in pieces.into_iter().enumerate() {
        match surfaces.iter().find(|surface| (surface.first..=surface.last).contains(&k)) {
            Some(surface) if surface.first == k => {
                (piece.moves.end, piece.lines[1]) = ends[surface.last];
                joined.push(piece);
            }
            Some(_) => {}
            None => joined.push(piece),
        }
    }
    joined
}

/// Middle and path of a free form in space; `None` for another piece or one at one height.
fn row(moves: &[Move], piece: &Piece) -> Option<(DVec3, Vec<DVec3>)> {
    let first = &moves[piece.moves.start];
    // Between indexed positions the same coordinates are other places on the workpiece.
    if piece.kind != FeatureKind::Profile || !first.tool_center && first.turn != Turn::default() {
        return None;
    }
    let axis = normal(first);
    let path = corners(moves[piece.moves.clone()].iter());
    let first = *path.first()?;
    let is_level = path.iter().all(|corner| (*corner - first).dot(axis).abs() <= NEAR);
    (!is_level).then(|| (path[path.len() / 2], path))
}

impl Surface {
    fn goes_on(&self, (middle, path): &(DVec3, Vec<DVec3>)) -> bool {
        let Some((_, before)) = self.rows.last() else { return false };
        let length: f64 = path.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let far = distance(*middle, before);
        far <= BESIDE * length
            && self.rows.iter().all(|(_, other)| distance(*middle, other) > AGAIN * self.apart.max(2.0 * NEAR))
    }
}
