//! The surface of a bed over X and Y, as grids.

use super::Imported;
use super::decimal::{to_nanometre, to_six_places};
use crate::error::FileError;
use crate::grid::{Grid, GridSource};
use crate::origin::Origin;
use trueaxis::error::Figure;
use trueaxis::machine::GRID_NODES;
use trueaxis::range;

/// Mean height from which a note advises moving it into the Z offset, mm.
const LARGE_MEAN: f64 = 0.5;

/// Commanded heights between which a surface fades, and the height to which it does; `None`: to the mean.
#[derive(Clone, Copy)]
pub(super) struct Fade {
    pub(super) heights: [f64; 2],
    pub(super) target: Option<f64>,
}

/// Heights of a bed, mm. Where the bed is high by m, the nozzle is m too low relative to it: EZ = −m.
pub(super) struct Surface {
    /// Nodes along X and Y.
    pub(super) nodes: [Vec<f64>; 2],
    /// One row for every Y, along X.
    pub(super) heights: Vec<Vec<f64>>,
    pub(super) fade: Option<Fade>,
}

impl Surface {
    /// The grids: the surface above the height to which it fades, and that height itself without fade.
    pub(super) fn imported(
        self,
        probed: &[Vec<f64>],
        mut notes: Vec<String>,
        origin: &Origin,
    ) -> Result<Imported, FileError> {
        let Surface { nodes: [x, y], heights, fade } = self;
        let mean = mean(&heights);
        let target = fade.map_or(0.0, |fade| fade.target.unwrap_or(mean));
        if let Some(Fade { heights: [start, end], .. }) = fade {
            let to = if target == 0.0 { String::from("nothing") } else { format!("the height {}", Figure(target)) };
            notes.push(format!("fades from Z {} to {to} at Z {}", Figure(start), Figure(end)));
        }
        if mean.abs() >= LARGE_MEAN {
            let left = probed.iter().flatten().fold(0.0, |most: f64, height| most.max((height - mean).abs()));
            notes.push(format!(
                "the heights are {} mm on average: with that in the Z offset of the machine, {} mm remain to be corrected",
                Figure(mean),
                Figure(to_nanometre(left))
            ));
        }
        let given = [false, false, true, false, false, false];
        let whole = (target != 0.0).then(|| {
            let ends = |nodes: &[f64]| nodes.first().into_iter().chain(nodes.last()).copied().collect();
            let nodes = [ends(&x), ends(&y), Vec::new()];
            GridSource { values: vec![[0.0, 0.0, -target, 0.0, 0.0, 0.0]; 4], nodes, given, ..GridSource::default() }
        });
        // Lines of constant Y become nodes with Y innermost.
        let values = (0..x.len())
            .flat_map(|x| heights.iter().map(move |row| [0.0, 0.0, to_nanometre(target - row[x]), 0.0, 0.0, 0.0]))
            .collect();
        let fade_mm = fade.map(|Fade { heights: [start, end], .. }| {
            let raised = [start + mean, end + target];
            // A mesh higher than the length of its fade is refused as too steep, as in Klipper.
            if raised[1] - raised[0] < range::LEAST_PITCH { [start, end] } else { raised }
        });
        let source = GridSource { values, nodes: [x, y, Vec::new()], given, fade_mm, ..GridSource::default() };
        let grids = std::iter::once(source).chain(whole).map(|source| {
            Grid::new(source).map_err(|error| origin.whole(format!("{error:?}"), "heights that 16 bits hold"))
        });
        let grids = grids.collect::<Result<_, _>>()?;
        Ok(Imported { grids, notes, replaces_grids: true, ..Imported::default() })
    }
}

/// Mean of the heights, to 0.01 mm.
fn mean(heights: &[Vec<f64>]) -> f64 {
    let count = heights.iter().map(Vec::len).sum::<usize>().max(1);
    (heights.iter().flatten().sum::<f64>() / count as f64 * 100.0).round() / 100.0 + 0.0
}

/// `count` equidistant nodes between two ends, to a nanometre; `line` and `name` are those of an error.
pub(super) fn equidistant(
    [from, to]: [f64; 2],
    count: usize,
    (line, name): (u32, &str),
    origin: &Origin,
) -> Result<Vec<f64>, FileError> {
    if !(2..=GRID_NODES).contains(&count) {
        return Err(origin.at(line, name, format!("{count} points"), format!("2 to {GRID_NODES}")));
    }
    for end in [from, to] {
        if !range::POSITION.linear.contains(end) {
            return Err(origin.at(line, name, Figure(end), range::POSITION.linear.needed));
        }
    }
    let cells = count - 1;
    if to - from < cells as f64 * range::LEAST_PITCH {
        return Err(origin.at(line, name, format!("{} to {}", Figure(from), Figure(to)), "an end above the start"));
    }
    let node = |index: usize| to_six_places(from + (to - from) * index as f64 / cells as f64, 1.0);
    Ok((0..cells).map(node).chain([to]).collect())
}

/// A height in its range, mm.
pub(super) fn height(line: u32, column: &str, text: &str, origin: &Origin) -> Result<f64, FileError> {
    let height = origin.number(line, column, text)?;
    if range::GRID_TRANSLATION.contains(height) {
        return Ok(height);
    }
    Err(origin.at(line, column, format!("{} mm", Figure(height)), range::GRID_TRANSLATION.needed))
}
