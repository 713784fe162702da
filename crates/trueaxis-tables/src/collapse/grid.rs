//! How much of the error that nine tables leave a grid would remove.

use super::residual::{Deviation, evaluate, with_nine_terms};
use super::volume::Volume;
use crate::exact::Geometry;
use crate::grid::{Grid, GridSource};
use crate::{Machine, compile};
use trueaxis::error::ConfigError;
use trueaxis::machine::GRIDS;

/// A grid counts as needed if it removes more than this share of the RMS, and more than this amount, mm.
const WORTH_SHARE: f64 = 0.5;
const WORTH_MM: f64 = 1e-4;

/// A grid in addition to nine tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridAdvice {
    /// Nodes along X, Y, Z; 0 along an axis that it does not cover.
    pub nodes: [usize; 3],
    /// Size in flash, bytes.
    pub bytes: usize,
    /// Error left by the nine tables and the grid.
    pub left: Deviation,
    /// Whether it removes more than half of the RMS that the tables leave, and more than 0.1 µm.
    pub needed: bool,
}

/// A grid with equidistant nodes over the volume that holds the error left by the tables of `collapsed`, averaged over both
/// directions of travel. `None` if a grid is not possible: fewer than two axes, already four grids, errors outside its limits.
///
/// Cost: one more evaluation of the machine.
pub(super) fn advice(
    volume: &Volume,
    geometry: &Geometry,
    collapsed: &Machine,
    left: &Deviation,
    wanted: [usize; 3],
) -> Result<Option<GridAdvice>, ConfigError> {
    let mut nodes: [Vec<f64>; 3] = Default::default();
    for (axis, nodes) in nodes.iter_mut().enumerate() {
        let ([low, high], count) = (volume.ends[axis], wanted[axis]);
        if volume.slots[axis].is_some() && count >= 2 {
            let node =
                |k: usize| if k + 1 == count { high } else { low + (high - low) / (count - 1) as f64 * k as f64 };
            *nodes = (0..count).map(node).collect();
        }
    }
    if nodes.iter().filter(|nodes| !nodes.is_empty()).count() < 2 || collapsed.grids.len() >= GRIDS {
        return Ok(None);
    }
    let places = nodes.clone().map(|nodes| if nodes.is_empty() { vec![0.0] } else { nodes });
    let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (volume.ends[k][0] + volume.ends[k][1]));
    let values = with_nine_terms(collapsed, |tip| {
        let mut values = Vec::new();
        for x in &places[0] {
            for y in &places[1] {
                for z in &places[2] {
                    let at = [*x, *y, *z];
                    let point = std::array::from_fn(|k| if nodes[k].is_empty() { middle[k] } else { at[k] });
                    let position = volume.position(point);
                    let mut sum = [0.0; 6];
                    for reverse in [0.0, 1.0] {
                        let direction = volume.direction([reverse; 3]);
                        let (d, model) = (geometry.tip_error(&position, &direction), tip(&position, &direction));
                        (0..3).for_each(|c| sum[c] += 0.5 * (d[c] - model[c]));
                    }
                    values.push(sum);
                }
            }
        }
        values
    })?;
    let counts = nodes.each_ref().map(Vec::len);
    let given = [true, true, true, false, false, false];
    let Ok(grid) = Grid::new(GridSource { nodes, given, values, ..GridSource::default() }) else { return Ok(None) };
    let bytes = grid.data().size();
    let mut with_grid = collapsed.clone();
    with_grid.grids.push(grid);
    if compile(&with_grid).is_err() {
        return Ok(None);
    }
    let [_, with] = evaluate(volume, geometry, [collapsed, &with_grid])?.left;
    let needed = with.rms_mm < WORTH_SHARE * left.rms_mm && left.rms_mm - with.rms_mm > WORTH_MM;
    Ok(Some(GridAdvice { nodes: counts, bytes, left: with, needed }))
}
