//! Points in a plane or along lines of it: a plate on a coordinate measuring machine, a scale under a camera, a printed grid.
//!
//! ```text
//! Points ─► models ─► predictions of held-out points ─► the chosen model: document, machine
//!                                          other points ─► transfer test
//! ```
//!
//! The deviations along the two free axes are those of the plate's placement and of the machine's errors over these axes.
//! Everything else that a machine states stays, and is subtracted first.
//!
//! A line along an axis shows that axis: positioning, and straightness across the line without its slope, as the line's direction
//! is that of its setting. A plane inclined to the axes shows the scales and squarenesses that its rank allows.

mod document;
mod errors;
mod inclined;
mod lie;
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
use lie::Lie;
use model::{Fitted, PlanePoint};
use selection::{Candidate, select};
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;

/// The linear axes.
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Fewest points: twice as many readings as affine terms need, and a few for their noise.
const LEAST: usize = 10;
/// Fewest points on a line, of whose readings scale and placement take four.
const LEAST_ON_LINE: usize = 5;
/// Inclination to the axes, rad, that counts as the alignment of a set-up: an error across it enters with this share at most.
const SET_UP: f64 = 0.02;

/// Result of [`identify_plane`].
#[derive(Clone, Debug)]
pub struct PlaneFit {
    /// Indices in X, Y, Z of the axes of the plane, ascending; or of the line's axis and the axis across it. For an inclined plane,
    /// those next to its two directions.
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
    /// Range of the points across their plane or line, as a share of their length.
    tilt: f64,
    /// Direction across a line that was measured and is not evaluated.
    unused: Option<usize>,
    lie: Lie,
    /// Terms of an inclined plane, and the combinations that it leaves open.
    inclined: (Vec<inclined::Term>, Vec<String>),
    points: Vec<PlanePoint>,
    candidates: Vec<Candidate>,
    chosen: usize,
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
    let lie = points.lie()?;
    let axes = lie.axes();
    if let Some(name) = options.without.first() {
        bail!("--without: found {name}, needed none: points in a plane do not show angular errors");
    }
    let readings = machine::without_rest(points, machine, lie)?;
    let ends = ends(&readings);
    let (candidates, chosen) = select(&readings, ends, lie, options.nodes.map(|nodes| axes.map(|axis| nodes[axis])));
    let Some(chosen) = chosen else {
        bail!("found points that determine no model, needed points over the whole plane")
    };
    let fitted = &candidates[chosen].fitted;
    let inclined = match lie {
        Lie::Inclined(_, across) => inclined::terms(&candidates[1].fitted, across)?,
        _ => Default::default(),
    };
    let (errors, placement) = errors::errors(fitted, &candidates[0].fitted, &readings);
    let transfer = match other {
        Some((other, name)) if errors != PlaneErrors::None => {
            let there = other.lie().and_then(|there| Ok((there, machine::without_rest(other, machine, lie)?)));
            let (there, other) = there.map_err(|error| error.context(name.to_owned()))?;
            if !lie.is_like(there) {
                bail!("{name}: found {}, needed {} as in the first record", there.sentence(), lie.sentence());
            }
            Some(transfer::test(fitted, &other, name))
        }
        _ => None,
    };
    let helps = transfer.as_ref().is_none_or(|test| test.transfers);
    let (machine, changes) = match machine {
        Some(machine) if helps && errors != PlaneErrors::None => {
            let (machine, changes) = match lie {
                Lie::Inclined(..) => inclined::added(machine, &inclined.0, points),
                _ => machine::filled(machine, lie, &errors, points)?,
            };
            (Some(machine), changes)
        }
        _ => (None, Vec::new()),
    };
    let (tilt, unused, points) = (lie.tilt(points), lie.unused(points), readings);
    Ok(PlaneFit {
        axes,
        errors,
        placement,
        transfer,
        machine,
        changes,
        tilt,
        unused,
        lie,
        inclined,
        points,
        candidates,
        chosen,
    })
}

/// Range of the points along both axes, mm.
fn ends(points: &[PlanePoint]) -> [[f64; 2]; 2] {
    [0, 1].map(|k| super::found::range(points.iter().map(|point| point.at[k])))
}

impl PlaneFit {
    fn fitted(&self) -> &Fitted {
        &self.candidates[self.chosen].fitted
    }

    /// Residuals of the points by the chosen model, mm, along the two axes of the plane.
    pub fn left_mm(&self) -> Vec<[f64; 2]> {
        self.left_of(self.chosen)
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
