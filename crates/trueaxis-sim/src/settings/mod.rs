//! Settings of a simulation other than machine and program, and their TOML form.
//!
//! ```toml
//! rate_hz = 4000
//! faults = ["dropout:X@1.25s+3"]
//! events = ["off:correction@2.5s", "exchange:warm@3s"]
//!
//! [motion]
//! feed_percent = 80
//!
//! [drive]                     # all axes
//! variant = "usual"           # a tuned drive; the keys below it change its figures
//! position_gain_per_s = 55
//!
//! [encoder.linear]
//! noise_rms_mm = 1e-5
//!
//! [axis.Y]                    # differences from axis to axis
//! drive = "worn"              # in place of [drive]
//! lost_motion_mm = 0.002
//! ```
//!
//! Omitted keys keep their defaults. [`Settings::to_toml`] writes all keys except `drive.variant`, whose figures it writes.

mod overlay;

use crate::event::EventScript;
use crate::motion::MotionSettings;
use crate::plant::PlantSettings;
use crate::plant::drive::{Disagreement, DriveSettings, Variant};
use crate::plant::encoder::Encoders;
use crate::plant::fault::FaultScript;
use crate::plant::variation::Variations;
use crate::range::Range;
use serde::{Deserialize, Serialize};
use trueaxis::machine::Axis;

pub use overlay::SettingError;

/// Rate, seed, surroundings, faults, events, motion, drives and encoders of a simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Servo rate, Hz, 100 to 100000.
    pub rate_hz: f64,
    /// Seed of the encoders' noise, 0 to 2⁶³ − 1.
    pub seed: u64,
    /// Temperature of the machine, °C, −50 to 200; if omitted, the tables' reference temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Program zero in machine coordinates X, Y, Z, mm; if omitted, the middle of the declared travels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin_mm: Option<[f64; 3]>,
    /// Faults, in the form of [`crate::plant::fault`].
    pub faults: FaultScript,
    /// Events, in the form of [`crate::event`].
    pub events: EventScript,
    /// Motion along the path.
    pub motion: MotionSettings,
    /// Drives of all axes.
    pub drive: DriveSettings,
    /// Encoders.
    pub encoder: Encoders,
    /// Differences from axis to axis.
    pub axis: Variations,
}

impl Default for Settings {
    /// 10 kHz, seed 1, no faults or events, and the defaults of motion, drives and encoders.
    fn default() -> Settings {
        Settings {
            rate_hz: 10_000.0,
            seed: 1,
            temperature_c: None,
            origin_mm: None,
            faults: FaultScript::default(),
            events: EventScript::default(),
            motion: MotionSettings::default(),
            drive: DriveSettings::default(),
            encoder: Encoders::default(),
            axis: Variations::default(),
        }
    }
}

impl Settings {
    /// Reads TOML text on top of the defaults; `file` appears in errors.
    ///
    /// # Errors
    /// Text that is not TOML, an unknown key, a value of the wrong type or out of range; with its line.
    pub fn parse(text: &str, file: &str) -> Result<Settings, SettingError> {
        let mut settings = Settings::default();
        overlay::overlay(&mut settings, text, overlay::Extent::All).map_err(|error| error.in_file(file))?;
        Ok(settings)
    }

    /// Changes one setting: `key` (`drive.dead_time_s`) and `value` as in the TOML form.
    /// [`Settings::check`] compares it with the other settings, so that they can be changed in any order.
    ///
    /// # Errors
    /// As [`Settings::parse`], without a line.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), SettingError> {
        overlay::overlay(self, &format!("{key} = {value}"), overlay::Extent::Ranges)
    }

    /// Refuses settings out of range or in disagreement with each other; [`Settings::parse`] already does so.
    ///
    /// # Errors
    /// The first such setting.
    pub fn check(&self) -> Result<(), SettingError> {
        overlay::check(self, overlay::Extent::All, |_| 1)
    }

    /// All settings as TOML, which [`Settings::parse`] reads back unchanged.
    pub fn to_toml(&self) -> String {
        overlay::text(self)
    }

    /// Settings that differ from the default: key, value, default.
    pub fn changes(&self) -> Vec<(String, String, String)> {
        overlay::changes(self)
    }

    /// The plant with these settings, `temperature_rise_k` above the machine's reference temperature.
    pub fn plant(&self, temperature_rise_k: f64) -> PlantSettings {
        PlantSettings {
            drives: self.axis.all().map(|own| own.drive.map_or(self.drive, Variant::settings).varied(&own)),
            encoders: Axis::ALL.map(|axis| if axis.is_rotary() { self.encoder.rotary } else { self.encoder.linear }),
            lost_motion_mm: self.axis.all().map(|variation| variation.lost_motion_mm),
            temperature_rise_k,
            faults: self.faults.clone(),
        }
    }

    /// The first setting that does not agree with the others, with its key.
    fn disagreement(&self) -> Option<(String, Disagreement)> {
        let period_s = 1.0 / self.rate_hz;
        let common = self.drive.agree(period_s).err().map(|of| (format!("drive.{}", of.key), of));
        // A variant's figures agree with each other, but its resonance may be too high for the servo rate.
        let mut own = Axis::ALL.into_iter().zip(self.axis.all()).filter_map(|(axis, variation)| {
            let variant = variation.drive?;
            let of = variant.settings().agree(period_s).err()?;
            let found = format!("\"{}\" with its {} of {}", variant.name(), of.key, of.found);
            Some((format!("axis.{}.drive", axis.letter()), Disagreement { found, ..of }))
        });
        common.or_else(|| own.next())
    }

    /// The first setting out of range: key, value as found, range.
    fn out_of_range(&self) -> Option<(String, f64, String)> {
        let range = |key, found, low, high, unit| Range { key, found, low, high, unit };
        let optional = self.temperature_c.map(|found| range("temperature_c", found, -50.0, 200.0, "°C"));
        let origin = self.origin_mm.into_iter().flatten();
        // TOML integers end at 2⁶³ − 1, which f64 cannot distinguish from 2⁶³.
        let seed = i64::try_from(self.seed).map_or(f64::INFINITY, |seed| seed as f64);
        let own =
            [range("rate_hz", self.rate_hz, 100.0, 100_000.0, "Hz"), range("seed", seed, 0.0, i64::MAX as f64, "")];
        let own = own.into_iter().chain(optional).chain(origin.map(|q| range("origin_mm", q, -1e6, 1e6, "mm")));
        let encoders = [("encoder.linear.", self.encoder.linear), ("encoder.rotary.", self.encoder.rotary)];
        let axes = Axis::ALL.into_iter().zip(self.axis.all());
        own.map(|range| (String::new(), range))
            .chain(self.motion.ranges().map(|range| ("motion.".to_owned(), range)))
            .chain(self.drive.ranges().map(|range| ("drive.".to_owned(), range)))
            .chain(encoders.into_iter().flat_map(|(at, of)| of.ranges().map(|range| (at.to_owned(), range))))
            .chain(axes.flat_map(|(axis, of)| of.ranges().map(|range| (format!("axis.{}.", axis.letter()), range))))
            .find(|(_, range)| !range.holds())
            .map(|(at, range)| (at + range.key, range.found, range.needed()))
    }
}
