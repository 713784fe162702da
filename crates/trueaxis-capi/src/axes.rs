//! Arrays with one element for each axis that a machine may have.

use crate::Real;

/// Largest number of axes of a machine.
pub const AXES_MAX: usize = 6;

/// The values of a machine's axes, padded with zeros.
#[inline(always)]
pub(crate) fn padded_numbers<const N: usize>(axes: &[Real; N]) -> [Real; AXES_MAX] {
    let mut numbers = [0.0; AXES_MAX];
    for (number, axis) in numbers.iter_mut().zip(axes) {
        *number = *axis;
    }
    numbers
}
