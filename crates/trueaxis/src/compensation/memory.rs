//! Memory for tables on a host, which has an allocator.

use super::{Requirement, Storage};
use crate::real::Real;
use std::vec;
use std::vec::Vec;

/// Memory that holds the tables of a machine; lent to a build, it has to outlive what was built.
///
/// ```
/// use trueaxis::compensation::Requirement;
/// let need = Requirement { lines: 48, knots: 0, guide: 0 };
/// let mut memory = need.memory::<f64>();
/// assert_eq!(memory.lend().lines.len(), 48);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Memory<R> {
    lines: Vec<R>,
    knots: Vec<R>,
    guide: Vec<u16>,
}

impl Requirement {
    /// As much memory as is required.
    pub fn memory<R: Real>(&self) -> Memory<R> {
        Memory { lines: vec![R::ZERO; self.lines], knots: vec![R::ZERO; self.knots], guide: vec![0; self.guide] }
    }
}

impl<R> Memory<R> {
    /// All of it.
    pub fn lend(&mut self) -> Storage<'_, R> {
        Storage { lines: &mut self.lines, knots: &mut self.knots, guide: &mut self.guide }
    }
}
