//! Names of the inverse's solutions.

/// One of the two poses of the rotary axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Branch {
    /// The rotary axis nearest the tool has turned the tool by 0 … 180 degrees, right-handed (relative to the workpiece), from
    /// the position where the tool comes nearest to the other axis.
    First = 1,
    /// The rotary axis nearest the tool has turned it by 0 … −180 degrees.
    Second = 2,
}
