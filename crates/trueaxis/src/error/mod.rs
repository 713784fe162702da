//! The two kinds of error: an invalid configuration at build, a fault of a cycle at run time.

mod field;
mod figure;
mod key;

pub use field::Field;

bench!(use figure::Figure);
bench!(use key::Key);

use crate::axis::Axis;
use crate::part::{self, Part};
use core::fmt;

/// An invalid setting, with the value found and the one required.
#[derive(Clone, Copy, PartialEq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConfigError {
    /// The wrong setting.
    pub field: Field,
    /// The axis to which it belongs, if any.
    pub axis: Option<Axis>,
    /// Index of the element if the setting is a list (row of a table, from 0).
    pub index: Option<u32>,
    /// The value found, in the setting's unit inside the core (mm, degrees, seconds).
    pub found: f64,
    /// The value required.
    pub needed: &'static str,
    /// Value that completes `needed`, if it follows from other settings, in the unit of `found`.
    pub bound: Option<f64>,
    /// The part that the setting needs, if this build leaves it out.
    #[doc(hidden)]
    pub left_out: Option<Part>,
}

impl ConfigError {
    /// Creates an error of the machine as a whole.
    #[cold]
    #[doc(hidden)]
    pub fn new(field: Field, found: f64, needed: &'static str) -> Self {
        let needed = part::text(needed);
        ConfigError { field, axis: None, index: None, found, needed, bound: None, left_out: None }
    }

    /// Creates the error for a setting of a part that this build leaves out.
    #[cold]
    pub(crate) fn left_out(part: Part, field: Field) -> Self {
        ConfigError { left_out: Some(part), ..ConfigError::new(field, 0.0, part.name()) }
    }

    /// Adds the axis.
    #[doc(hidden)]
    pub fn on(self, axis: Axis) -> Self {
        ConfigError { axis: Some(axis), ..self }
    }

    /// The key or section of `machine.toml` to edit; `None` if the setting is not in the file.
    #[doc(hidden)]
    pub fn key(&self) -> Option<Key> {
        self.field.key(self.axis)
    }

    /// Adds the index of an element in a list.
    #[doc(hidden)]
    pub fn at(self, index: usize) -> Self {
        ConfigError { index: u32::try_from(index).ok(), ..self }
    }
}

impl fmt::Debug for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = f.debug_struct("ConfigError");
        text.field("field", &self.field).field("axis", &self.axis).field("index", &self.index);
        text.field("found", &self.found).field("needed", &self.needed).field("bound", &self.bound);
        if let Some(part) = &self.left_out {
            text.field("left_out", part);
        }
        text.finish()
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let key = self.key();
        if let Some(axis) = self.axis
            && !key.is_some_and(|key| key.names_its_axis())
        {
            write!(f, "axis {}: ", axis.letter())?;
        }
        match key {
            Some(key) => write!(f, "{key}")?,
            None => write!(f, "{:?}", self.field)?,
        }
        if let Some(index) = self.index {
            write!(f, " [{index}]")?;
        }
        if let Some(part) = self.left_out {
            return write!(f, ": needs the part {part}, which this build leaves out");
        }
        let figure = |value| Figure(key.map_or(value, |key| key.in_its_unit(value)));
        write!(f, ": found {}, needed {}", figure(self.found), self.needed)?;
        match self.bound {
            Some(bound) => write!(f, ": {}", figure(bound)),
            None => Ok(()),
        }
    }
}

impl core::error::Error for ConfigError {}

/// Fault of a servo cycle; reported in its output and telemetry.
///
/// Four classes. *Bad feedback* (1 to 11): the correction freezes, the command passes. *Friction* (12 to 15): reported until
/// a reset, while the correction continues with the identified friction. *Bad command* (16 to 31): the
/// output holds and a stop request is latched until a reset near the held position. *Refused at start* (32 and above):
/// the plugin stays inactive, the command passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(into = "u8", try_from = "u8")]
#[repr(u8)]
#[non_exhaustive]
pub enum Fault {
    /// No fault.
    #[default]
    None = 0,
    /// An encoder gave no finite reading.
    FeedbackNotFinite = 1,
    /// A reading changed more in a cycle than the axis can move, or lies more than 1 mm (1°) outside the joint.
    FeedbackJump = 2,
    /// A reading does not change although the axis was commanded to move.
    EncoderStuck = 3,
    /// The encoder interface reports an alarm (dropout).
    EncoderAlarm = 4,
    /// The cycle came late or early by more than a quarter of its period, or cycles have come faster than the period
    /// for so long that the corrections must pause ([`crate::Input::elapsed_ns`]).
    LateCycle = 5,
    /// A reading moves against the command, or by about half or twice as much: sign or scale of the encoder are wrong.
    FeedbackRatio = 6,
    /// An axis whose friction adapts sticks and slips: its friction is back at the identified figures.
    StickSlip = 12,
    /// The friction of an axis that adapts has the wrong sign at its reversals: it is back at the identified figures.
    FrictionReversed = 13,
    /// A command is infinite or not a number.
    CommandNotFinite = 16,
    /// A command lies outside the declared travel.
    CommandOutOfTravel = 17,
    /// A command changed more in a cycle than the axis can move.
    CommandJump = 18,
    /// Command plus correction leaves the range of the joint.
    JointRange = 19,
    /// No pose of the machine brings the tool to the commanded tip and direction.
    ToolUnreachable = 20,
    /// The commanded direction is near the one in which a rotary axis turns the tool about itself, and a travel keeps
    /// the tool farther from it than the singular cone.
    SingularPose = 21,
    /// The commanded direction requires the rotary axes to change to their other solution faster than they can.
    BranchChange = 22,
    /// The host's servo period is not the configured one.
    PeriodMismatch = 32,
    /// The table file is damaged, or of another format, version or machine.
    TablesRefused = 33,
    /// The tables need more memory than is available.
    CapacityTooSmall = 34,
    /// Host and plugin were built for different versions of the interface.
    AbiMismatch = 35,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Fault::None => "no fault",
            Fault::FeedbackNotFinite => "an encoder gives no finite reading",
            Fault::FeedbackJump => {
                "an encoder reading changed more in a cycle than the axis can move, or lies outside its range"
            }
            Fault::EncoderStuck => "an encoder reading is stuck although the axis is commanded to move",
            Fault::EncoderAlarm => "an encoder interface reports an alarm",
            Fault::LateCycle => {
                "the cycle came late or early by more than a quarter of its period, or too many came early"
            }
            Fault::FeedbackRatio => {
                "an encoder reading moves against the command, or by about half or twice as much: check its sign and scale"
            }
            Fault::StickSlip => "an axis sticks and slips, so that its friction no longer adapts",
            Fault::FrictionReversed => {
                "the friction of an axis has the wrong sign at its reversals, so that it no longer adapts"
            }
            Fault::CommandNotFinite => "a command is not a finite number",
            Fault::CommandOutOfTravel => "a command lies outside the travel of its axis",
            Fault::CommandJump => "a command changed more in a cycle than the axis can move",
            Fault::JointRange => "command plus correction leaves the range of the joint",
            Fault::ToolUnreachable => "no pose of the machine reaches the commanded tip and direction of the tool",
            Fault::SingularPose => "the commanded direction of the tool is too near to a singular pose",
            Fault::BranchChange => "the commanded direction asks the rotary axes to change to their other solution",
            Fault::PeriodMismatch => "the servo period of the host is not the configured one",
            Fault::TablesRefused => "the compensation tables are damaged or made for another machine or version",
            Fault::CapacityTooSmall => "the memory is too small for the compensation tables",
            Fault::AbiMismatch => "host and plugin were built for different versions of the interface",
        })
    }
}

impl core::error::Error for Fault {}

impl Fault {
    /// Whether the correction freezes and the command passes.
    pub const fn freezes(self) -> bool {
        (self as u8) > 0 && (self as u8) < 12
    }

    /// Whether the output holds and a stop is requested.
    pub const fn stops(self) -> bool {
        (self as u8) >= 16 && (self as u8) < 32
    }

    /// Whether the plugin is refused at start: the command passes uncorrected ([`crate::Bypass`]).
    pub const fn refuses(self) -> bool {
        (self as u8) >= 32
    }
}

impl From<Fault> for u8 {
    fn from(fault: Fault) -> u8 {
        fault as u8
    }
}

impl TryFrom<u8> for Fault {
    type Error = &'static str;

    fn try_from(code: u8) -> Result<Fault, &'static str> {
        [
            Fault::None,
            Fault::FeedbackNotFinite,
            Fault::FeedbackJump,
            Fault::EncoderStuck,
            Fault::EncoderAlarm,
            Fault::LateCycle,
            Fault::FeedbackRatio,
            Fault::StickSlip,
            Fault::FrictionReversed,
            Fault::CommandNotFinite,
            Fault::CommandOutOfTravel,
            Fault::CommandJump,
            Fault::JointRange,
            Fault::ToolUnreachable,
            Fault::SingularPose,
            Fault::BranchChange,
            Fault::PeriodMismatch,
            Fault::TablesRefused,
            Fault::CapacityTooSmall,
            Fault::AbiMismatch,
        ]
        .into_iter()
        .find(|fault| *fault as u8 == code)
        .ok_or("a known fault code")
    }
}

#[cfg(test)]
mod tests {
    use super::{ConfigError, Fault, Field};
    use crate::axis::Axis;
    use std::collections::BTreeSet;
    use std::string::ToString;

    #[test]
    fn figures_are_in_the_unit_of_their_key() {
        for (field, axis, found, text) in [
            (Field::Hysteresis, Some(Axis::X), 0.0003, "axis.X.hysteresis_um: found 0.3, "),
            (Field::Magnitude, Some(Axis::C), 12e-6_f64.to_degrees(), "axis.C.limits.magnitude_urad: found 12, "),
            (Field::LocationC0Y, None, 0.0525, "location.C0Y_urad: found 52500, "),
            (Field::LocationEx, Some(Axis::A), 1.001, "location.EX0A_um: found 1001, "),
            (Field::MaxFeed, Some(Axis::Y), 1e-6, "axis.Y.max_feed_mm_per_min: found 0.00006, "),
            (Field::ThermalOffset, Some(Axis::Z), 0.2, "axis.Z.thermal.offset_um_per_k: found 200, "),
            (Field::ThermalExpansion, Some(Axis::B), 0.002, "axis.B.thermal.expansion_urad_per_rad_k: found 2000, "),
            (Field::InfeedLimit, None, 20.0, "roundness.infeed.limit_um: found 20, "),
            (Field::Magnitude, Some(Axis::X), f64::NAN, "axis.X.limits.magnitude_um: found NaN, "),
            (Field::Magnitude, Some(Axis::X), f64::MAX, "axis.X.limits.magnitude_um: found inf, "),
        ] {
            let error = ConfigError { axis, ..ConfigError::new(field, found, "less") };
            assert!(error.to_string().starts_with(text), "{error} {text}");
        }
    }

    #[test]
    fn settings_keep_their_numbers() {
        let pinned = [
            (0, Field::Name),
            (22, Field::Hysteresis),
            (55, Field::MaxLag),
            (110, Field::CommandWindow),
            (111, Field::CommonLag),
        ];
        for (code, field) in pinned {
            assert_eq!((field.code(), Field::ALL.get(usize::from(code))), (code, Some(&field)));
        }
    }

    #[test]
    fn every_fault_has_a_sentence_of_its_own() {
        let faults: std::vec::Vec<Fault> = (0..=u8::MAX).filter_map(|code| Fault::try_from(code).ok()).collect();
        let sentences: BTreeSet<_> = faults.iter().map(ToString::to_string).collect();
        assert_eq!((faults.len(), sentences.len()), (20, 20));
        assert!(sentences.iter().all(|text| text.is_ascii() && text.len() > 7 && !text.ends_with('.')));
    }
}
