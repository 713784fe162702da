//! Points in a plane or along lines of it: a plate on a coordinate measuring machine, a scale under a camera, a printed grid.
//!
//! ```text
//! Points ─► models ─► predictions of held-out points ─► the chosen model: document, machine
//!                                          other points ─► transfer test
//! ```
//!
//! The deviations along the two free axes are those of the plate's placement and of the machine's errors over these axes.
//! Everything else that a machine states stays, and is subtracted first.

mod document;
mod errors;
mod machine;
mod model;
mod selection;
mod shown;
mod transfer;

pub use document::{CandidateDocument, PlaneDocument, PlaneTerm};
pub use errors::{Grid, PlaneErrors, Tables};
pub use transfer::{LEVEL, Transfer};

use super::{Options, Points};
use anyhow::{Result, bail};
use model::{Fitted, PlanePoint};
use selection::{Candidate, select};
use std::ops::Range;
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;

/// The linear axes.
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Range of a coordinate below which it is constant, mm.
const CONSTANT_MM: f64 = 1e-3;
/// Share of the points' length below which their width is that of a line.
const LINE: f64 = 1e-3;
/// Fewest points: twice as many readings as affine terms need, and a few for their noise.
const LEAST: usize = 10;

/// Result of [`identify_plane`].
#[derive(Clone, Debug)]
pub struct PlaneFit {
    /// Indices of the free axes in X, Y, Z, ascending.
    pub axes: [usize; 2],
    /// Errors of the chosen model, without the placement of the plate.
    pub errors: PlaneErrors,
    /// Shift of the plate along the free axes, mm, and its rotation from the first toward the second, rad.
    pub placement: [f64; 3],
    /// Whether the errors help another record; `None` without one.
    pub transfer: Option<Transfer>,
    /// The machine with the errors; `None` without a machine, without errors, and if they do not transfer.
    pub machine: Option<Machine>,
    /// Remarks on what is written into the machine.
    pub changes: Vec<String>,
    points: Vec<PlanePoint>,
    candidates: Vec<Candidate>,
    chosen: usize,
}

impl Points {
    /// Whether the points vary along two linear axes at most: [`identify_plane`] then evaluates them.
    pub fn are_flat(&self) -> bool {
        self.free().len() < 3
    }

    /// Indices of the axes along which the points vary.
    fn free(&self) -> Vec<usize> {
        let range = |k: usize| super::found::range(self.points.iter().map(|point| point.command_mm[k]));
        (0..3).filter(|k| range(*k)[1] - range(*k)[0] >= CONSTANT_MM).collect()
    }

    /// Lines of the file, as text.
    fn lines(&self) -> Range<u32> {
        let lines = || self.points.iter().map(|point| point.line);
        lines().min().unwrap_or_default()..lines().max().unwrap_or_default()
    }

    /// The free axes of points that determine a model.
    fn plane(&self) -> Result<[usize; 2]> {
        let (count, Range { start, end }) = (self.points.len(), self.lines());
        if count < LEAST {
            bail!("lines {start} to {end}: found {count} points in a plane, needed at least {LEAST}");
        }
        if self.tools_mm.len() > 1 {
            let found = self.tools_mm.len();
            bail!("column tool_x_mm: found {found} reflector offsets, needed one for points in a plane");
        }
        let needed =
            "needed a plane or several lines along two axes; for a scale along one axis: tables import --from iso230-2";
        let [u, v] = match self.free()[..] {
            [u, v] => [u, v],
            _ => bail!("lines {start} to {end}: found all points on one line, {needed}"),
        };
        let mean = |of: &dyn Fn([f64; 3]) -> f64| {
            self.points.iter().map(|point| of(point.command_mm)).sum::<f64>() / self.points.len() as f64
        };
        let middle = [mean(&|at| at[u]), mean(&|at| at[v])];
        let moment = |i: usize, j: usize| mean(&|at| (at[[u, v][i]] - middle[i]) * (at[[u, v][j]] - middle[j]));
        let (half, product) = ((moment(0, 0) + moment(1, 1)) / 2.0, moment(0, 0) * moment(1, 1) - moment(0, 1).powi(2));
        // Principal variances: half ± √(half² − product); the smaller one without cancellation.
        let long = half + (half * half - product).max(0.0).sqrt();
        if product / long < (LINE * LINE) * long {
            bail!("lines {start} to {end}: found all points on one line, {needed}");
        }
        Ok([u, v])
    }
}

/// The errors over the two axes along which the points vary, by the model that predicts held-out points best; and whether they
/// help the points of another record. `machine`: what the rest of it states is subtracted, and the errors are added to it.
///
/// Cost: some 150 fits of up to 81 unknowns.
///
/// # Errors
/// Too few points, points on one line, points that determine no model, a machine without the free axes.
pub fn identify_plane(
    points: &Points,
    machine: Option<&Machine>,
    options: &Options,
    other: Option<(&Points, &str)>,
) -> Result<PlaneFit> {
    let axes = points.plane()?;
    if let Some(name) = options.without.first() {
        bail!("--without: found {name}, needed none: points in a plane do not show angular errors");
    }
    let readings = machine::without_rest(points, machine, axes)?;
    let ends = ends(&readings);
    let (candidates, chosen) = select(&readings, ends, options.nodes.map(|nodes| axes.map(|axis| nodes[axis])));
    let Some(chosen) = chosen else {
        bail!("found points that determine no model, needed points over the whole plane")
    };
    let fitted = &candidates[chosen].fitted;
    let (errors, placement) = errors::errors(fitted, &candidates[0].fitted, &readings);
    let transfer = match other {
        Some((other, name)) if errors != PlaneErrors::None => {
            let there = other.plane().and_then(|there| Ok((there, machine::without_rest(other, machine, axes)?)));
            let (there, other) = there.map_err(|error| error.context(name.to_owned()))?;
            if there != axes {
                let letters = |axes: [usize; 2]| axes.map(|axis| LINEAR[axis].letter()).map(String::from).join(" and ");
                bail!("{name}: found points over {}, needed {} as in the first record", letters(there), letters(axes));
            }
            Some(transfer::test(fitted, &other, name))
        }
        _ => None,
    };
    let helps = transfer.as_ref().is_none_or(|test| test.transfers);
    let (machine, changes) = match machine {
        Some(machine) if helps => machine::filled(machine, axes, &errors, points)?,
        _ => (None, Vec::new()),
    };
    Ok(PlaneFit { axes, errors, placement, transfer, machine, changes, points: readings, candidates, chosen })
}

/// Range of the points along both axes, mm.
fn ends(points: &[PlanePoint]) -> [[f64; 2]; 2] {
    [0, 1].map(|k| super::found::range(points.iter().map(|point| point.at[k])))
}

impl PlaneFit {
    fn fitted(&self) -> &Fitted {
        &self.candidates[self.chosen].fitted
    }

    /// Name of the chosen model.
    pub fn model(&self) -> String {
        self.fitted().model.name()
    }

    /// Deviation at a position of the free axes by the chosen model, mm: errors and placement.
    pub fn deviation_mm(&self, at: [f64; 2]) -> [f64; 2] {
        self.fitted().at(at)
    }

    /// Letters of the free axes.
    pub fn letters(&self) -> [char; 2] {
        self.axes.map(|axis| LINEAR[axis].letter())
    }
}
