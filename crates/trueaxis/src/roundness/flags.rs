//! GaugeFlags of a revolution.

use serde::{Deserialize, Serialize};

/// Events of a cycle or a revolution, as bits; see the constants.
///
/// All but the last group end the revolution that is being sampled: it is discarded whole, and sampling begins again at
/// the next θ = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GaugeFlags(pub u16);

impl GaugeFlags {
    /// No index pulse has been seen yet, or none that can be relied on: θ is unknown, or known by counting on only.
    pub const NO_INDEX: GaugeFlags = GaugeFlags(1);
    /// An index pulse did not come.
    pub const INDEX_MISSING: GaugeFlags = GaugeFlags(1 << 1);
    /// An index pulse came at another count than before: counts were lost, or the pulse is a disturbance.
    pub const INDEX_SHIFTED: GaugeFlags = GaugeFlags(1 << 2);
    /// The spindle's count changed by more than a quarter turn in a cycle.
    pub const SPINDLE_JUMP: GaugeFlags = GaugeFlags(1 << 3);
    /// A probe is outside its range, or gave no finite reading.
    pub const PROBE_RANGE: GaugeFlags = GaugeFlags(1 << 4);
    /// The arm's angle is outside ±90°. Or, found while a revolution is worked on, it contradicts the linkage: then the
    /// profile stands, but its motion does not count and the infeed is not updated.
    pub const ARM: GaugeFlags = GaugeFlags(1 << 5);
    /// θ ran backwards by more than a point.
    pub const REVERSED: GaugeFlags = GaugeFlags(1 << 6);
    /// θ passed more than two points in a cycle.
    pub const TOO_FAST: GaugeFlags = GaugeFlags(1 << 7);
    /// The spindle stood.
    pub const STOPPED: GaugeFlags = GaugeFlags(1 << 8);
    /// The speed changed by more than a quarter within the revolution; resampling takes account of it.
    pub const SPEED: GaugeFlags = GaugeFlags(1 << 9);
    /// In a cycle: the revolution that has just ended is skipped whole, because the work on one before was not finished.
    /// Of a revolution: some before it were skipped.
    pub const SKIPPED: GaugeFlags = GaugeFlags(1 << 10);
    /// The infeed correction was not updated: it was limited or not followed, or would have passed its bound, the wheel
    /// was idle, the size of the part did not change steadily (nothing is known of that after a discarded revolution), or
    /// the arm is in doubt.
    pub const INFEED_FROZEN: GaugeFlags = GaugeFlags(1 << 11);
    /// The infeed correction was limited over several revolutions and has been made smaller.
    pub const INFEED_REDUCED: GaugeFlags = GaugeFlags(1 << 12);

    /// Whether all bits of `other` are set.
    pub const fn has(self, other: GaugeFlags) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether any bit that ends a revolution is set.
    pub const fn discards(self) -> bool {
        self.0 & (GaugeFlags::SPEED.0 - 1) != 0
    }

    /// No bit set.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline(always)]
    pub(super) const fn set(&mut self, other: GaugeFlags) {
        self.0 |= other.0;
    }
}
