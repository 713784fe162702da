//! Name of a solution of the inverse.

/// Which of the two poses of the rotary axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Branch {
    /// The rotary axis nearest the tool has turned it by 0 … 180 degrees, right-handed (as the workpiece sees it), from
    /// where it comes nearest to the other axis.
    First = 1,
    /// By 0 … −180 degrees.
    Second = 2,
}
