//! A machine's error model in memory.

use anyhow::{Result, anyhow};
use trueaxis::Axis;
use trueaxis::compensation::{Compensation, requirement};
use trueaxis_tables::Machine;

/// Builds the model that the machine's settings name, of `N` axes, and lends it out. `passes`: look-ups of the exact inverse.
///
/// # Errors
/// As [`Compensation::build`]; and those of `user`.
pub fn with_compensation<const N: usize, T>(
    machine: &Machine,
    passes: u8,
    user: impl FnOnce(&Compensation<'_, f64, f64, N>) -> Result<T>,
) -> Result<T> {
    let rows = |axis: Axis| machine.rows(axis);
    let mut memory = vec![0.0; requirement(&machine.settings, rows)];
    let compensation =
        Compensation::build(&machine.settings, rows, passes, &mut memory).map_err(|error| anyhow!("{error}"))?;
    user(&compensation)
}

/// Calls a function generic over the number of axes of the step with that number.
#[macro_export]
macro_rules! by_axes {
    ($count:expr, $($function:ident)::+ ($($argument:expr),*)) => {
        match $count {
            3 => $($function)::+::<3>($($argument),*),
            4 => $($function)::+::<4>($($argument),*),
            5 => $($function)::+::<5>($($argument),*),
            _ => $($function)::+::<6>($($argument),*),
        }
    };
}
pub use by_axes;
