//! The cells of the tables in which command and feedback lie, kept from cycle to cycle.
//!
//! Along an axis the error is a polynomial of its position alone, squareness and thermal growth included, and stays the
//! same one until the axis leaves the interval between two points of its table, its *cell*. With `t` the distance of the
//! position from the start of the cell in the position's own steps,
//!
//! ```text
//! E = Σ over X, Y, Z of  k0 + k1 t  (+ k2 t² + k3 t³)
//! ```
//!
//! so that a cycle within its cells computes no index, clamps nothing and costs on a free grid what it costs on any other.
//! A cell goes on a little beyond its ends, as far as a fixed share of the inverse's tolerance lets it, so that a reading
//! that dithers about a point of the table does not leave it in every cycle. Beyond the ends of a table the cell is the rest of the axis.
//!
//! Beside grids a cell also ends where the box does in which their sum is one polynomial: while no cell is left, no box is.

mod cell;
mod kept;
mod source;
mod tables;

pub(crate) use kept::Cells;
pub(crate) use source::Source;
pub(crate) use tables::Tables;

/// Linear axes, which alone have cells.
const LINEAR: usize = 3;
