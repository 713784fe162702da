//! Names of the axes: the lowest module, which imports nothing.

use serde::{Deserialize, Serialize};

/// Largest number of axes of one machine.
pub const AXES: usize = 6;

/// A machine axis, named as in ISO 841: X, Y, Z are linear, A, B, C rotate about X, Y, Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Axis {
    /// Linear, along X.
    X,
    /// Linear, along Y.
    Y,
    /// Linear, along Z.
    Z,
    /// Rotary, about X.
    A,
    /// Rotary, about Y.
    B,
    /// Rotary, about Z.
    C,
}

impl Axis {
    /// All six, in their order.
    pub const ALL: [Axis; AXES] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C];

    /// The letter, upper case.
    pub const fn letter(self) -> char {
        match self {
            Axis::X => 'X',
            Axis::Y => 'Y',
            Axis::Z => 'Z',
            Axis::A => 'A',
            Axis::B => 'B',
            Axis::C => 'C',
        }
    }

    /// The axis of an upper-case letter.
    pub fn from_letter(letter: char) -> Option<Axis> {
        Axis::ALL.into_iter().find(|axis| axis.letter() == letter)
    }

    /// Whether the axis is A, B or C.
    pub const fn is_rotary(self) -> bool {
        self as u8 >= Axis::A as u8
    }

    /// Position in `ALL`, 0 to 5. In an error table it is also the component of the axis' positioning error (`EXX` is
    /// component 0 of X, `ECC` component 5 of C).
    pub const fn index(self) -> usize {
        self as usize
    }
}
