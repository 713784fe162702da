//! Errors on a grid over two or three linear axes, read in place from a compiled file.

use super::Twist;
use crate::axis::Axis;

/// Largest number of grids of a machine.
pub const GRIDS: usize = 4;
/// Largest number of nodes along one axis of a grid.
pub const GRID_NODES: usize = 1000;

/// Nodes of a grid along one linear axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GridAxis {
    /// Number of nodes; 0 if the grid does not span this axis.
    pub nodes: u16,
    /// First and last node, mm.
    pub ends: [f64; 2],
    /// Whether the nodes are not equidistant, so that their positions are stored.
    pub free: bool,
}

impl GridAxis {
    /// Whether the grid spans this axis.
    pub const fn is_there(&self) -> bool {
        self.nodes > 0
    }

    const fn count(&self) -> usize {
        if self.nodes == 0 { 1 } else { self.nodes as usize }
    }

    /// Number of nodes whose positions are stored.
    const fn stored(&self) -> usize {
        if self.free { self.nodes as usize } else { 0 }
    }
}

/// Header of a grid: everything except its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GridHeader {
    /// Nodes along X, Y, Z.
    pub axes: [GridAxis; 3],
    /// Which errors a node has: bit 0 EX … bit 5 EC.
    pub given: u8,
    /// Value of a stored 1, mm (EX EY EZ) and rad (EA EB EC): the resolution; zero for errors that are not given.
    pub scales: Twist,
    /// Heights Z, mm, up to which the errors apply fully and from which on they are zero; linear in between.
    pub fade: Option<[f64; 2]>,
    /// Position, during measurement, of the linear axes that the grid does not span, mm; zero for the others.
    pub measured_at_mm: [f64; 3],
}

impl GridHeader {
    /// Number of errors per node.
    pub const fn columns(&self) -> usize {
        (self.given & 63).count_ones() as usize
    }

    /// Total number of nodes; `None` on overflow.
    pub fn count(&self) -> Option<usize> {
        self.axes.iter().try_fold(1usize, |count, axis| count.checked_mul(axis.count()))
    }

    /// Bytes of the positions of free nodes, and of the nodes; `None` on overflow.
    pub fn bytes(&self) -> Option<[usize; 2]> {
        let positions = self.axes.iter().map(GridAxis::stored).sum::<usize>().checked_mul(8)?;
        let nodes = self.count()?.checked_mul(self.columns())?.checked_mul(2)?;
        Some([positions, nodes])
    }

    /// The linear axes that the grid spans.
    pub fn letters(&self) -> impl Iterator<Item = Axis> + '_ {
        [Axis::X, Axis::Y, Axis::Z]
            .into_iter()
            .zip(&self.axes)
            .filter(|(_, along)| along.is_there())
            .map(|(axis, _)| axis)
    }
}

/// A grid inside a compiled file: the nodes stay in the file's bytes.
///
/// An error of a node is its stored 16-bit number times the scale. Nodes are ordered by position, with X outermost and
/// the nodes along Z contiguous; a node's errors are in the order EX EY EZ EA EB EC.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridData<'a> {
    header: GridHeader,
    positions: &'a [u8],
    nodes: &'a [u8],
}

impl<'a> GridData<'a> {
    /// Creates a grid from its header and the bytes after it: positions of free nodes as doubles, then the nodes. Also
    /// returns the remaining bytes; `None` if the bytes do not suffice.
    pub fn new(header: GridHeader, bytes: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let [positions, nodes] = header.bytes()?;
        let (positions, rest) = bytes.split_at_checked(positions)?;
        let (nodes, rest) = rest.split_at_checked(nodes)?;
        Some((GridData { header, positions, nodes }, rest))
    }

    /// Everything except the nodes.
    pub fn header(&self) -> &GridHeader {
        &self.header
    }

    /// The bytes after the header: positions of free nodes, then the nodes.
    pub fn stored_bytes(&self) -> [&'a [u8]; 2] {
        [self.positions, self.nodes]
    }

    /// Number of bytes of positions and nodes.
    pub fn size(&self) -> usize {
        self.positions.len() + self.nodes.len()
    }

    /// The nodes as stored, two bytes per number.
    pub(crate) fn nodes(&self) -> &'a [u8] {
        self.nodes
    }

    /// Stored positions of the nodes along X (0), Y or Z; empty if the nodes are equidistant.
    pub(crate) fn stored(&self, axis: usize) -> &'a [u8] {
        let before = self.header.axes.iter().take(axis).map(GridAxis::stored).sum::<usize>();
        let count = self.header.axes.get(axis).map_or(0, GridAxis::stored);
        self.positions.get(8 * before..8 * (before + count)).unwrap_or_default()
    }

    /// Position of a node along X (0), Y or Z, mm.
    pub fn position(&self, axis: usize, index: usize) -> Option<f64> {
        let along = self.header.axes.get(axis).filter(|along| index < usize::from(along.nodes))?;
        if along.free {
            return self.stored(axis).as_chunks::<8>().0.get(index).map(|bytes| f64::from_le_bytes(*bytes));
        }
        let [first, last] = along.ends;
        let cells = along.nodes.saturating_sub(1);
        if index == usize::from(cells) {
            return Some(last);
        }
        Some(first + (last - first) / f64::from(cells.max(1)) * index as f64)
    }

    /// Index of a node from its indices along X, Y and Z.
    fn place(&self, [x, y, z]: [usize; 3]) -> Option<usize> {
        let [along_x, along_y, along_z] = self.header.axes.map(|axis| axis.count());
        (x < along_x && y < along_y && z < along_z).then_some((x * along_y + y) * along_z + z)
    }

    /// The stored numbers of a node, zero for errors that are not given.
    pub fn raw(&self, index: [usize; 3]) -> Option<[i16; 6]> {
        let columns = self.header.columns();
        let start = self.place(index)?.checked_mul(2 * columns)?;
        let mut stored = self.nodes.get(start..start.checked_add(2 * columns)?)?.as_chunks::<2>().0.iter();
        let mut raw = [0; 6];
        for (component, raw) in raw.iter_mut().enumerate() {
            if self.header.given >> component & 1 == 1 {
                *raw = i16::from_le_bytes(*stored.next()?);
            }
        }
        Some(raw)
    }

    /// Errors of a node, mm and rad.
    pub fn node(&self, index: [usize; 3]) -> Option<Twist> {
        let raw = self.raw(index)?;
        Some(core::array::from_fn(|k| {
            f64::from(raw.get(k).copied().unwrap_or(0)) * self.header.scales.get(k).copied().unwrap_or(0.0)
        }))
    }

    /// Indices of all nodes, in storage order.
    pub fn indices(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let [x, y, z] = self.header.axes.map(|axis| axis.count());
        (0..x).flat_map(move |i| (0..y).flat_map(move |j| (0..z).map(move |k| [i, j, k])))
    }

    /// Largest |∂E/∂q| of each error along X, Y and Z within the cells, mm or rad per mm; exact, as the slope along an
    /// axis is largest at an edge of a cell. Smallest and largest value of each error.
    ///
    /// Cost: visits every node once.
    pub fn extremes(&self) -> GridExtremes {
        let mut found = GridExtremes { slopes: [[0.0; 3]; 6], values: [[f64::INFINITY, f64::NEG_INFINITY]; 6] };
        for index in self.indices() {
            let Some(node) = self.raw(index) else { continue };
            for axis in 0..3usize {
                let mut next = index;
                if let Some(next) = next.get_mut(axis) {
                    *next += 1;
                }
                let Some(there) = self.raw(next) else { continue };
                let at = index.get(axis).copied().unwrap_or(0);
                let width = self.position(axis, at + 1).zip(self.position(axis, at)).map_or(f64::NAN, |(b, a)| b - a);
                for (slopes, (from, to)) in found.slopes.iter_mut().zip(node.iter().zip(&there)) {
                    if let Some(slope) = slopes.get_mut(axis) {
                        *slope = slope.max((f64::from(*to) - f64::from(*from)).abs() / width);
                    }
                }
            }
            for (value, stored) in found.values.iter_mut().zip(node) {
                *value = [value[0].min(f64::from(stored)), value[1].max(f64::from(stored))];
            }
        }
        for ((slopes, values), scale) in found.slopes.iter_mut().zip(&mut found.values).zip(self.header.scales) {
            slopes.iter_mut().chain(values).for_each(|number| *number *= scale);
        }
        found
    }
}

/// Bounds of a grid's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridExtremes {
    /// Largest |∂E/∂q| of each error along X, Y and Z, mm or rad per mm.
    pub slopes: [[f64; 3]; 6],
    /// Smallest and largest value of each error, mm or rad.
    pub values: [[f64; 2]; 6],
}
