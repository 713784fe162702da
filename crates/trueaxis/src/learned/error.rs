//! Reasons for refusing a file with a learned correction.

use core::fmt;

/// Why a file was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum LearnedError {
    /// Shorter than its header says.
    TooShort = 1,
    /// Longer than its header says.
    TooLong = 2,
    /// Another kind of file.
    Magic = 3,
    /// Another version of the format.
    Version = 4,
    /// Damaged: the sum over the file is wrong.
    Checksum = 5,
    /// Spacing of the nodes out of range, nm.
    Spacing(u32) = 6,
    /// Resolution of the nodes out of range, pm.
    Resolution(u32) = 7,
    /// Learned from zero parts.
    Parts = 8,
    /// The number of nodes does not match the path length and the spacing.
    Nodes {
        /// Number in the file.
        found: u32,
        /// Number from length and spacing.
        needed: u64,
    } = 9,
    /// The first or the last node is not zero.
    Ends = 10,
    /// The correction was learned on another program.
    WrongProgram {
        /// Id in the file.
        found: u32,
        /// Id of the program in use.
        needed: u32,
    } = 11,
    /// The program in use has another length.
    WrongLength {
        /// Length in the file, nm.
        found_nm: u64,
        /// Length of the program in use, nm.
        needed_nm: u64,
    } = 12,
    /// The correction was learned on another machine.
    WrongMachine {
        /// Id in the file.
        found: u32,
        /// Id of the machine in use.
        needed: u32,
    } = 13,
}

impl LearnedError {
    /// The numeric code.
    pub const fn code(&self) -> u8 {
        match self {
            LearnedError::TooShort => 1,
            LearnedError::TooLong => 2,
            LearnedError::Magic => 3,
            LearnedError::Version => 4,
            LearnedError::Checksum => 5,
            LearnedError::Spacing(_) => 6,
            LearnedError::Resolution(_) => 7,
            LearnedError::Parts => 8,
            LearnedError::Nodes { .. } => 9,
            LearnedError::Ends => 10,
            LearnedError::WrongProgram { .. } => 11,
            LearnedError::WrongLength { .. } => 12,
            LearnedError::WrongMachine { .. } => 13,
        }
    }
}

impl fmt::Display for LearnedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LearnedError::TooShort => f.write_str("the file is shorter than its header says"),
            LearnedError::TooLong => f.write_str("the file is longer than its header says"),
            LearnedError::Magic => f.write_str("not a learned correction (it does not start with TRUELRND)"),
            LearnedError::Version => {
                write!(f, "another version of the format (version {} is needed)", super::VERSION)
            }
            LearnedError::Checksum => f.write_str("the file is damaged (its CRC-32 is wrong)"),
            LearnedError::Spacing(found) => {
                write!(f, "found nodes every {found} nm, needed 1 to {} nm", super::WIDEST_SPACING_NM)
            }
            LearnedError::Resolution(found) => {
                write!(f, "found a resolution of {found} pm, needed 1 to {} pm", super::COARSEST_RESOLUTION_PM)
            }
            LearnedError::Parts => f.write_str("found a correction learned from no part, needed one part at least"),
            LearnedError::Nodes { found, needed } => {
                write!(f, "found {found} nodes, needed {needed} for the path length and the spacing")
            }
            LearnedError::Ends => f.write_str("found a correction at an end of the path, needed zero there"),
            LearnedError::WrongProgram { found, needed } => {
                write!(f, "learned on the program {found:08x}, needed {needed:08x}")
            }
            LearnedError::WrongLength { found_nm, needed_nm } => {
                let mm = |nm: u64| (nm / 1_000_000, nm % 1_000_000);
                let ((found, found_nm), (needed, needed_nm)) = (mm(*found_nm), mm(*needed_nm));
                write!(f, "learned on a path of {found}.{found_nm:06} mm, needed {needed}.{needed_nm:06} mm")
            }
            LearnedError::WrongMachine { found, needed } => {
                write!(f, "learned on the machine {found:08x}, needed {needed:08x}")
            }
        }
    }
}

impl core::error::Error for LearnedError {}
