//! The order of a machine's axes: in its list, in the step's slots, and in the six letters.

use super::{AxisSettings, MachineSettings};
use crate::axis::{AXES, Axis};
use crate::error::{ConfigError, Field};

/// The axes of a step with `N` axes by slot: X, Y, Z, always all three, then the machine's rotary axes in alphabetical
/// order.
///
/// Created once, when a machine's settings are read; all code that depends on the order uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisOrder<const N: usize>([Axis; N]);

impl<const N: usize> AxisOrder<N> {
    /// The order of a machine's axes.
    ///
    /// # Errors
    /// The machine has more or fewer rotary axes than `N − 3`.
    pub fn of(machine: &MachineSettings) -> Result<Self, ConfigError> {
        Self::filled(machine.step_axes())
    }

    /// The order of a machine's axes in a step that may have more slots: the spare ones come last and hold rotary axes that
    /// the machine does not have, in alphabetical order.
    ///
    /// # Errors
    /// The machine has more rotary axes than `N − 3`.
    pub fn with_spare_slots(machine: &MachineSettings) -> Result<Self, ConfigError> {
        let spare = N.saturating_sub(machine.step_axes().count());
        let absent = Axis::ALL.into_iter().filter(|axis| axis.is_rotary() && machine.axis(*axis).is_none());
        Self::filled(machine.step_axes().chain(absent.take(spare)))
    }

    fn filled(mut found: impl Iterator<Item = Axis>) -> Result<Self, ConfigError> {
        let mut axes = [Axis::X; N];
        for axis in &mut axes {
            *axis = found.next().ok_or(ConfigError::new(Field::Axes, N as f64, "no more axes than the machine has"))?;
        }
        match found.next() {
            None => Ok(AxisOrder(axes)),
            Some(_) => Err(ConfigError::new(Field::Axes, N as f64, "a step with as many axes as the machine has")),
        }
    }

    /// The axes by slot.
    #[inline(always)]
    pub const fn axes(&self) -> [Axis; N] {
        self.0
    }

    /// Slot of an axis.
    pub fn slot(&self, axis: Axis) -> Option<usize> {
        self.0.iter().position(|known| *known == axis)
    }

    /// Settings by slot; `None` for an absent linear axis.
    pub fn settings<'m>(&self, machine: &'m MachineSettings) -> [Option<&'m AxisSettings>; N] {
        self.0.map(|axis| machine.axis(axis))
    }

    /// Maps the six letters, in the order of [`Axis::index`], to slots.
    #[inline(always)]
    pub fn slots<T>(&self, of: impl FnMut(Axis) -> T) -> [T; N] {
        self.0.map(of)
    }

    /// Maps slots to the six letters; `empty` for axes that the step does not have.
    #[inline(always)]
    pub fn letters<S, T: Copy>(&self, slots: &[S; N], empty: T, of: impl Fn(Axis, &S) -> T) -> [T; AXES] {
        let mut letters = [empty; AXES];
        for (axis, slot) in self.0.iter().zip(slots) {
            if let Some(letter) = letters.get_mut(axis.index()) {
                *letter = of(*axis, slot);
            }
        }
        letters
    }
}

impl MachineSettings {
    /// The axes of the machine's step by slot, for a caller that does not know their number yet; see [`AxisOrder`].
    pub fn step_axes(&self) -> impl Iterator<Item = Axis> + '_ {
        let rotary = self.axes.iter().map(|known| known.axis).filter(|axis| axis.is_rotary());
        [Axis::X, Axis::Y, Axis::Z].into_iter().chain(rotary)
    }

    /// Settings of an axis, if the machine has it.
    pub fn axis(&self, axis: Axis) -> Option<&AxisSettings> {
        self.axes.iter().find(|known| known.axis == axis)
    }
}
