//! One lookup of the tables.

use super::{Direction, ThermalLine};

/// All inputs of the tables' errors: positions in table coordinates
/// ([`Compensation::coordinates`](super::Compensation::coordinates)), directions of travel and thermal growth, all in the
/// step's order.
#[derive(Clone, Copy, Debug)]
pub struct Query<'q, R, const N: usize> {
    /// Command.
    pub command: &'q [R; N],
    /// Feedback, for tables that are configured to be looked up there.
    pub feedback: &'q [R; N],
    /// Directions of travel.
    pub directions: &'q [Direction; N],
    /// Thermal growth.
    pub thermal: &'q [ThermalLine<R>; N],
}

impl<'q, R, const N: usize> Query<'q, R, N> {
    /// Queries everything at one position.
    #[inline(always)]
    pub const fn at(position: &'q [R; N], directions: &'q [Direction; N], thermal: &'q [ThermalLine<R>; N]) -> Self {
        Query { command: position, feedback: position, directions, thermal }
    }
}
