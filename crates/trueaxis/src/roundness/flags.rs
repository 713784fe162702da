//! Event flags of a cycle or a revolution.

use serde::{Deserialize, Serialize};

/// Events of a cycle or a revolution, as bits; see the constants.
///
/// All flags but the last group end the revolution being sampled: it is discarded whole, and sampling restarts at the next
/// θ = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GaugeFlags(pub u16);

impl GaugeFlags {
    /// No index pulse has been seen yet, or none is reliable: θ is unknown, or known only by counting since the last
    /// one.
    pub const NO_INDEX: GaugeFlags = GaugeFlags(1);
    /// An expected index pulse was missing.
    pub const INDEX_MISSING: GaugeFlags = GaugeFlags(1 << 1);
    /// An index pulse came at a different count than before: counts were lost, or the pulse is interference.
    pub const INDEX_SHIFTED: GaugeFlags = GaugeFlags(1 << 2);
    /// The spindle's count changed by more than a quarter turn in a cycle.
    pub const SPINDLE_JUMP: GaugeFlags = GaugeFlags(1 << 3);
    /// A probe is outside its range, or its reading is not finite.
    pub const PROBE_RANGE: GaugeFlags = GaugeFlags(1 << 4);
    /// The arm's angle is outside ±90°. For a processed revolution: the arm's reading contradicts the linkage; the
    /// profile is then valid, but the window of its motion starts over and the infeed is not updated.
    pub const ARM: GaugeFlags = GaugeFlags(1 << 5);
    /// θ ran backwards by more than a point.
    pub const REVERSED: GaugeFlags = GaugeFlags(1 << 6);
    /// θ passed more than two points in a cycle.
    pub const TOO_FAST: GaugeFlags = GaugeFlags(1 << 7);
    /// The spindle has stopped.
    pub const STOPPED: GaugeFlags = GaugeFlags(1 << 8);
    /// The speed changed by more than a quarter within the revolution; resampling allows for it.
    pub const SPEED: GaugeFlags = GaugeFlags(1 << 9);
    /// For a cycle: the revolution that has just ended is skipped whole because the work on a previous one was not finished. For
    /// a revolution: some revolutions before it were skipped.
    pub const SKIPPED: GaugeFlags = GaugeFlags(1 << 10);
    /// The infeed correction was not updated: it was limited or not followed, or would have exceeded its bound, the wheel was
    /// idle, the size of the part did not change steadily (after a discarded revolution this is unknown), or the arm is in
    /// doubt.
    pub const INFEED_FROZEN: GaugeFlags = GaugeFlags(1 << 11);
    /// The infeed correction was limited over several revolutions and has been reduced.
    pub const INFEED_REDUCED: GaugeFlags = GaugeFlags(1 << 12);

    /// Whether all bits of `other` are set.
    pub const fn has(self, other: GaugeFlags) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether any bit that ends a revolution is set.
    pub const fn discards(self) -> bool {
        self.0 & (GaugeFlags::SPEED.0 - 1) != 0
    }

    /// Whether no bit is set.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline(always)]
    pub(super) const fn set(&mut self, other: GaugeFlags) {
        self.0 |= other.0;
    }
}
