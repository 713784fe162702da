//! Choice of the drive of one axis.

use serde::{Deserialize, Serialize};

/// The drive of one axis: that of all axes, or a [`Variant`](super::Variant) of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisDrive {
    /// That of all axes.
    #[default]
    Common,
    /// [`Variant::Stiff`](super::Variant::Stiff)
    Stiff,
    /// [`Variant::Usual`](super::Variant::Usual)
    Usual,
    /// [`Variant::Soft`](super::Variant::Soft)
    Soft,
    /// [`Variant::Worn`](super::Variant::Worn)
    Worn,
}

impl AxisDrive {
    /// Names in settings.
    pub(crate) const NAMES: [&'static str; 5] = ["common", "stiff", "usual", "soft", "worn"];
}
