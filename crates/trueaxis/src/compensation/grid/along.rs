//! Nodes along one axis of a grid.

use crate::machine::GridData;
use crate::real::Real;

/// Nodes along an axis; empty if the grid does not span it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Along<'a, R> {
    /// X (0), Y or Z.
    axis: u8,
    /// Stored numbers from one node to the next; 0 if the grid does not span the axis.
    stride: u32,
    /// Number of cells; 0 if the grid does not span the axis.
    cells: u16,
    first: R,
    end: R,
    /// Cells per mm of equidistant nodes.
    rate: R,
    /// Positions of free nodes, mm.
    knots: &'a [[u8; 8]],
}

/// Place of a position along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<R> {
    /// Index of the cell.
    pub(super) index: usize,
    /// From 0 at its first node to 1 at its second.
    pub(super) t: R,
    /// Beyond the first or the last node.
    pub(super) edge: bool,
}

impl<'a, R: Real> Along<'a, R> {
    pub(super) fn new(data: &GridData<'a>, axis: usize, stride: usize) -> Self {
        let along = data.header().axes.get(axis).copied().unwrap_or_default();
        let cells = along.nodes.saturating_sub(1);
        let [first, end] = if along.is_there() { along.ends } else { [-R::MAX.to_f64(), R::MAX.to_f64()] };
        let rate = if along.is_there() { f64::from(cells) / (end - first) } else { 0.0 };
        Along {
            axis: axis as u8,
            stride: if along.is_there() { stride as u32 } else { 0 },
            cells,
            first: R::of(first),
            end: R::of(end),
            rate: R::of(rate),
            knots: data.stored(axis).as_chunks().0,
        }
    }

    /// X (0), Y or Z.
    #[inline(always)]
    pub(super) fn axis(&self) -> usize {
        usize::from(self.axis)
    }

    /// Stored numbers from one node to the next; 0 if the grid does not span the axis.
    #[inline(always)]
    pub(super) fn stride(&self) -> usize {
        self.stride as usize
    }

    /// Whether the grid spans the axis.
    #[inline(always)]
    pub(super) fn is_there(&self) -> bool {
        self.cells > 0
    }

    fn knot(&self, index: usize) -> R {
        self.knots.get(index).map_or(self.end, |bytes| R::of(f64::from_le_bytes(*bytes)))
    }

    /// The cell of a position; beyond the nodes, the end of the outermost cell.
    #[inline(always)]
    pub(super) fn place(&self, q: R) -> Place<R> {
        let edge = (q < self.first) | (q > self.end);
        if self.knots.is_empty() {
            let place = ((q - self.first) * self.rate).limit(R::ZERO, R::of_i32(i32::from(self.cells)));
            let index = place.to_i32().min(i32::from(self.cells.saturating_sub(1)));
            return Place { index: index as usize, t: place - R::of_i32(index), edge };
        }
        self.search(q, edge)
    }

    /// Bisection among free nodes: as many halvings as the number of cells has bits.
    #[inline(never)]
    fn search(&self, q: R, edge: bool) -> Place<R> {
        let (mut index, mut rest) = (0usize, usize::from(self.cells));
        while rest > 1 {
            let half = rest / 2;
            if q >= self.knot(index + half) {
                index += half;
            }
            rest -= half;
        }
        let (low, high) = (self.knot(index), self.knot(index + 1));
        Place { index, t: ((q - low) / (high - low)).limit(R::ZERO, R::ONE), edge }
    }

    /// First and second node of a cell, mm.
    pub(super) fn nodes_of(&self, index: usize) -> [R; 2] {
        if !self.knots.is_empty() {
            return [self.knot(index), self.knot(index + 1)];
        }
        let node = |index: usize| {
            if index >= usize::from(self.cells) { self.end } else { self.first + R::of_i32(index as i32) / self.rate }
        };
        [node(index), node(index + 1)]
    }

    /// First and last node, mm.
    pub(super) fn ends(&self) -> [R; 2] {
        [self.first, self.end]
    }
}
