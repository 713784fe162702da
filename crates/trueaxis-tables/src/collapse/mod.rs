//! The best nine tables for a machine with angular errors, and the error that they leave.
//!
//! **Fit.** d(x, y, z) is the exact error of the tool tip for one tool and one pose of the rotary axes. On the tensor grid of
//! the tables' nodes within the working volume, the nearest sum of one-dimensional functions consists of means (least squares
//! with trapezoidal weights: each node counts for its share of the length):
//!
//! ```text
//! d ≈ D + Σ_i (M_i(q_i) − D)     D: mean over the volume,  M_i: mean over the volume's section at q_i
//! ```
//!
//! A two-sided axis has each node twice, once per direction of travel with half the weight. Its columns therefore differ by
//! the mean effect of its reversal, levers of its angular errors included.
//!
//! **Constant.** Any table could carry the constant. Here both cross terms of an axis are zero at the reference position in
//! positive travel, and its positioning error carries the rest: with f_ci the table of axis i in direction c and r the
//! reference,
//! ```text
//! f_ci(q) = M_ci(q) − M_ci(r_i)   i ≠ c          f_cc(q) = M_cc(q) + Σ_{i ≠ c} M_ci(r_i) − (n − 1) D_c
//! ```
//!
//! n is the number of linear axes. In a direction without a linear axis, the first axis carries the constant. The choice does
//! not change the sum.
//!
//! **Other settings.** Squareness moves from the location errors into the tables; `measured_at_mm` becomes zero, because the
//! tables apply to the whole volume. Backlash, thermal growth, limits and the rotary axes stay as they are. In the nine-term
//! form, a rotary axis' table corrects its angular positioning error and its translations; the linear tables correct the rest
//! of both. The errors of the rotary axes are those in positive travel.
//!
//! **Grids.** A machine's existing grids stay, and the tables are fitted to the machine's errors without them. A grid of a
//! stated size is then fitted to the error that the tables leave, and the result states whether the machine needs it.
//!
//! The sum is optimal only *at the nodes*; between them each table is interpolated as its axis' setting says. Beyond the
//! volume the edge value applies.

mod additive;
mod grid;
mod residual;
mod volume;

pub use grid::GridAdvice;
pub use residual::{Cause, Deviation};

use crate::exact::table::ErrorTable;
use crate::exact::{Geometry, GeometryError};
use crate::{Machine, Table, compile};
use additive::{Level, MainEffects, levels};
use residual::with_nine_terms;
use thiserror::Error;
use trueaxis::error::ConfigError;
use trueaxis::machine::{AXES, Axis, ErrorModel, Row};
use volume::Volume;

/// The linear axes in their order.
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Nodes of an axis without a table.
const FREE_NODES: usize = 11;
/// Up to this many cells, the means are formed over all nodes.
const MOST_CELLS: usize = 4_000_000;
/// Nodes per axis over which the means are formed above that.
const THINNED: usize = 41;
/// Nodes along each axis of the grid that is tried in addition to the tables.
const GRID_NODES_TRIED: usize = 5;
/// Tables are stored in steps of 1e-7 µm: short decimals.
const STEPS_PER_UM: f64 = 1e7;

/// Tool, volume and pose for which a machine is collapsed to nine tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollapseOptions {
    /// Tool tip from the last tool-side frame at all axes zero, mm; the machine's own if `None`.
    pub tool_mm: Option<[f64; 3]>,
    /// Position at which the cross terms are zero, mm; the middle of the volume if `None`. Entries for axes that the machine
    /// lacks are ignored.
    pub reference_mm: Option<[f64; 3]>,
    /// Lower and upper end of the working volume for X, Y, Z, mm; `None`: the declared travel, or the table's range.
    pub volume_mm: [Option<[f64; 2]>; 3],
    /// Angles of the rotary axes, degrees; zero for an axis that is not listed.
    pub pose_deg: Vec<(Axis, f64)>,
    /// Nodes along X, Y, Z of the grid that is tried in addition to the tables; 5 each if `None`.
    pub grid: Option<[usize; 3]>,
}

/// Why a machine cannot be collapsed.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CollapseError {
    /// An option does not fit the machine.
    #[error("{option}{}: found {found}, needed {needed}", axis.map_or(String::new(), |axis| format!(" of axis {}", axis.letter())))]
    Option {
        /// `volume`, `pose`, `tool` or `reference`.
        option: &'static str,
        /// The axis, if the option is about one.
        axis: Option<Axis>,
        /// Found value.
        found: String,
        /// Needed value.
        needed: String,
    },
    /// The structural code is invalid.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The controller's checks refuse the collapsed machine.
    #[error("the collapsed tables: {0}")]
    Config(ConfigError),
}

/// Nine tables and how good they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Collapsed {
    /// The machine with the collapsed tables, model nine, `tool_mm` the tool for which they hold.
    pub machine: Machine,
    /// The working volume; zero length for an axis that the machine lacks, mm.
    pub volume_mm: [[f64; 2]; 3],
    /// Position at which the cross terms are zero, mm.
    pub reference_mm: [f64; 3],
    /// Points and directions at which the deviations below were evaluated.
    pub evaluated: usize,
    /// Error of the tool tip as it is.
    pub before: Deviation,
    /// Error left by the collapsed tables.
    pub after: Deviation,
    /// Error left by the original tables if they are used unchanged as nine terms, with the machine's squareness.
    pub original: Deviation,
    /// Share of each axis' angular errors in the residual that no nine tables can express, largest first.
    pub causes: Vec<Cause>,
    /// Residual that an additional grid would leave, if one makes sense.
    pub grid: Option<GridAdvice>,
}

/// The best nine tables over a working volume.
///
/// Cost: one exact evaluation (about 1 µs) per node of the volume's grid, both directions of every two-sided axis; above four
/// million evaluations the means are formed over at most 41 nodes an axis.
///
/// # Errors
/// A volume, reference, tool or pose that is not a number or that the machine does not reach; a machine without a linear axis;
/// a pose other than zero of a rotary axis that carries a linear one (the nine terms would turn with it); tables that the
/// controller would refuse.
pub fn collapse(machine: &Machine, options: &CollapseOptions) -> Result<Collapsed, CollapseError> {
    let mut source = machine.clone();
    if let Some(tool) = options.tool_mm {
        if let Some(found) = tool.iter().find(|mm| !mm.is_finite() || mm.abs() > 1e6) {
            return Err(wrong("tool", None, found, "finite lengths below 1e6 mm"));
        }
        source.settings.tool_mm = tool;
    }
    let volume = Volume::new(&source, options)?;
    let target = corrected_in_rotary_axes(&source);
    let geometry = Geometry::new(&target, 0.0)?;

    let mut collapsed = source.clone();
    collapsed.grids.clear();
    collapsed.settings.compensation.model = ErrorModel::Nine;
    // The nine-term form cannot correct the tool direction.
    collapsed.settings.compensation.orientation = false;
    let location = &mut collapsed.settings.location;
    (location.a0z, location.b0z, location.c0y) = (0.0, 0.0, 0.0);
    for slot in volume.slots.into_iter().flatten() {
        collapsed.tables[slot] = None;
        collapsed.settings.axes[slot].measured_at_mm = [0.0; 3];
    }
    let mut without_periods = collapsed.clone();
    without_periods.settings.periodic.clear();
    let of_rotary_axes = with_nine_terms(&without_periods, |tip| tip(&volume.position([0.0; 3]), &[0.0; AXES]))
        .map_err(CollapseError::Config)?;

    let mut without_backlash = without_separate_settings(&target, &volume);
    without_backlash.grids.clear();
    let fitted = Geometry::new(&without_backlash, 0.0)?;
    let error = |cell: [Level; 3]| {
        let at = volume.position(cell.map(|level| level.position));
        let d = fitted.tip_error(&at, &volume.direction(cell.map(|level| level.reverse)));
        std::array::from_fn(|c| d[c] - of_rotary_axes[c])
    };
    fill(&mut collapsed, &volume, &means(&volume, error));
    collapsed.grids.clone_from(&source.grids);
    compile(&collapsed).map_err(CollapseError::Config)?;

    let mut as_it_is = source.clone();
    as_it_is.settings.compensation.model = ErrorModel::Nine;
    as_it_is.settings.compensation.orientation = false;
    let deviations = residual::evaluate(&volume, &geometry, [&as_it_is, &collapsed]).map_err(CollapseError::Config)?;
    let causes = residual::causes(&volume, &without_backlash)?;
    let nodes = options.grid.unwrap_or([GRID_NODES_TRIED; 3]);
    let grid =
        grid::advice(&volume, &geometry, &collapsed, &deviations.left[1], nodes).map_err(CollapseError::Config)?;
    Ok(Collapsed {
        machine: collapsed,
        volume_mm: volume.ends,
        reference_mm: volume.reference,
        evaluated: deviations.count,
        before: deviations.before,
        original: deviations.left[0],
        after: deviations.left[1],
        causes,
        grid,
    })
}

fn wrong(option: &'static str, axis: Option<Axis>, found: impl ToString, needed: impl Into<String>) -> CollapseError {
    CollapseError::Option { option, axis, found: found.to_string(), needed: needed.into() }
}

/// The machine as the tip sees it once each rotary axis' own table corrects it in its own position.
fn corrected_in_rotary_axes(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    machine.settings.periodic.retain(|period| !period.axis.is_rotary());
    for (own, table) in machine.settings.axes.iter_mut().zip(&mut machine.tables) {
        if own.axis.is_rotary() {
            own.backlash = 0.0;
            for row in table.iter_mut().flat_map(|table| &mut table.rows) {
                row.forward[own.axis.index()] = 0.0;
                row.reverse[own.axis.index()] = 0.0;
            }
        }
    }
    machine
}

/// Backlash and periods of the linear axes are separate settings and stay out of the tables.
fn without_separate_settings(machine: &Machine, volume: &Volume) -> Machine {
    let mut machine = machine.clone();
    machine.settings.periodic.clear();
    for slot in volume.slots.into_iter().flatten() {
        machine.settings.axes[slot].backlash = 0.0;
    }
    machine
}

/// Means at every node.
fn means(volume: &Volume, error: impl Fn([Level; 3]) -> [f64; 3]) -> MainEffects {
    let full: [Vec<Level>; 3] = std::array::from_fn(|i| levels(&volume.nodes[i], volume.two_sided_table[i]));
    if full.iter().map(Vec::len).product::<usize>() <= MOST_CELLS {
        return MainEffects::of(&full, error);
    }
    let few: [Vec<Level>; 3] = std::array::from_fn(|i| levels(&thinned(&volume.nodes[i]), volume.two_sided_table[i]));
    let mut effects = MainEffects::of(&few, &error);
    for i in 0..3 {
        let mut mixed = few.clone();
        mixed[i].clone_from(&full[i]);
        effects.marginal[i] = std::mem::take(&mut MainEffects::of(&mixed, &error).marginal[i]);
    }
    effects
}

/// At most `THINNED` of the nodes, evenly spaced, ends included.
fn thinned(nodes: &[f64]) -> Vec<f64> {
    if nodes.len() <= THINNED {
        return nodes.to_vec();
    }
    (0..THINNED).map(|k| nodes[k * (nodes.len() - 1) / (THINNED - 1)]).collect()
}

/// Writes the tables of the linear axes.
fn fill(machine: &mut Machine, volume: &Volume, effects: &MainEffects) {
    let mut constant = effects.grand.map(|grand| -grand * (volume.slots.iter().flatten().count() as f64 - 1.0));
    for (i, slot) in volume.slots.iter().enumerate() {
        let Some(slot) = *slot else { continue };
        let (nodes, means) = (&volume.nodes[i], &effects.marginal[i]);
        let twist = |[x, y, z]: [f64; 3]| [x, y, z, 0.0, 0.0, 0.0];
        let back = if volume.two_sided_table[i] { nodes.len() } else { 0 };
        let rows: Vec<Row> = nodes
            .iter()
            .enumerate()
            .map(|(k, &position)| Row { position, forward: twist(means[k]), reverse: twist(means[k + back]) })
            .collect();
        let at_reference = ErrorTable::new(&machine.settings.axes[slot], &rows).at(volume.reference[i], 0.0);
        let given = [true, true, true, false, false, false];
        let mut table = Table { given, bidirectional: false, rows };
        for row in &mut table.rows {
            for c in 0..3 {
                row.forward[c] -= at_reference[c];
                row.reverse[c] -= at_reference[c];
            }
        }
        for c in 0..3 {
            constant[c] += at_reference[c];
        }
        machine.tables[slot] = Some(table);
    }
    for (c, constant) in constant.into_iter().enumerate() {
        let Some(slot) = volume.slots[c].or(volume.slots.iter().flatten().next().copied()) else { continue };
        for row in machine.tables[slot].iter_mut().flat_map(|table| &mut table.rows) {
            row.forward[c] += constant;
            row.reverse[c] += constant;
        }
    }
    for slot in volume.slots.into_iter().flatten() {
        let Some(table) = machine.tables[slot].as_mut() else { continue };
        for value in table.rows.iter_mut().flat_map(|row| row.forward.iter_mut().chain(&mut row.reverse)) {
            // In µm and then / 1e3, as the reader does, so that it reads back as the same double; + 0 turns −0 into 0.
            *value = (*value * 1e3 * STEPS_PER_UM).round() / STEPS_PER_UM / 1e3 + 0.0;
        }
        table.bidirectional = table.rows.iter().any(|row| row.forward != row.reverse);
    }
}
