//! Caches, from cycle to cycle, the table cells of command and feedback.
//!
//! Along an axis the error is a polynomial of its position alone, squareness and thermal growth included, and remains the
//! same polynomial until the axis leaves the interval between two points of its table, its *cell*. With `t` the distance
//! of the position from the start of the cell, in the position's own steps,
//!
//! ```text
//! E = Σ over X, Y, Z of  k0 + k1 t  (+ k2 t² + k3 t³)
//! ```
//!
//! so a cycle within its cells computes no index, clamps nothing and costs the same on a free grid as on any other. A
//! cell extends slightly beyond its ends, as far as a fixed share of the inverse's tolerance allows, so that a reading
//! that dithers around a table point does not leave it in every cycle. Beyond the ends of a table, the cell is the rest
//! of the axis.
//!
//! Without grids, a cycle fills at most one cell. A point without all of its cells is looked up in the tables themselves
//! meanwhile, so that no cycle costs more than that, however many cells an exchange or a reversal drops at once.
//!
//! With grids, a cell also ends where the box ends in which their sum is one polynomial: an axis that stays in its cells
//! stays in the box.

mod cache;
mod cell;
mod source;
mod tables;

pub(crate) use cache::Cells;
pub(crate) use source::Source;
pub(crate) use tables::{InverseEnd, Tables};

/// Number of linear axes; only they have cells.
const LINEAR: usize = 3;
