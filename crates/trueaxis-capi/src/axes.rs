//! Lists of as many elements as a machine may have axes.

use crate::Real;

/// Most axes of a machine.
pub const AXES_MAX: usize = 6;

/// Numbers of a machine's axes, 0 for those that it does not have.
#[inline(always)]
pub(crate) fn padded_numbers<const N: usize>(axes: &[Real; N]) -> [Real; AXES_MAX] {
    let mut numbers = [0.0; AXES_MAX];
    for (number, axis) in numbers.iter_mut().zip(axes) {
        *number = *axis;
    }
    numbers
}
