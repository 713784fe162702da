//! Sizes and header of the file of a learned correction.

#![deny(clippy::indexing_slicing)]

use core::num::NonZeroU64;

/// First eight bytes of the file.
pub const MAGIC: [u8; 8] = *b"TRUELRND";
/// Format version.
pub const VERSION: u16 = 1;
/// Bytes before the nodes.
pub const HEADER_BYTES: usize = 40;
/// Bytes of a node.
pub const NODE_BYTES: usize = 6;
/// Largest spacing of the nodes, nm.
pub const WIDEST_SPACING_NM: u32 = 1_000_000_000;
/// Coarsest resolution of the nodes, pm.
pub const COARSEST_RESOLUTION_PM: u32 = 1_000_000;
/// Path lengths of a program count as equal within this, nm.
pub const LENGTH_TOLERANCE_NM: u64 = 1_000;

/// Header of the file: everything except its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LearnedHeader {
    /// Parts learned from.
    pub parts: u16,
    /// Id of the machine, [`crate::Tcomp::machine_id`].
    pub machine_id: u32,
    /// Id of the program, [`super::ProgramId`].
    pub program_id: u32,
    /// Path length of the program, nm.
    pub length_nm: u64,
    /// Spacing of the nodes, nm.
    pub spacing_nm: u32,
    /// Correction of a node's 1, pm.
    pub resolution_pm: u32,
}

impl LearnedHeader {
    /// Number of nodes: the path length over the spacing, rounded up, plus one. `None` for a spacing of zero.
    pub fn nodes(&self) -> Option<u64> {
        let spacing = NonZeroU64::new(self.spacing_nm.into())?;
        Some(self.length_nm.div_ceil(spacing.get()).saturating_add(1))
    }

    /// The header's bytes in the file.
    pub fn to_bytes(self) -> [u8; HEADER_BYTES] {
        let nodes = u32::try_from(self.nodes().unwrap_or(0)).unwrap_or(u32::MAX);
        let mut bytes = [0; HEADER_BYTES];
        let fields = MAGIC
            .into_iter()
            .chain(VERSION.to_le_bytes())
            .chain(self.parts.to_le_bytes())
            .chain(self.machine_id.to_le_bytes())
            .chain(self.program_id.to_le_bytes())
            .chain(self.length_nm.to_le_bytes())
            .chain(self.spacing_nm.to_le_bytes())
            .chain(self.resolution_pm.to_le_bytes())
            .chain(nodes.to_le_bytes());
        bytes.iter_mut().zip(fields).for_each(|(byte, field)| *byte = field);
        bytes
    }
}
