//! Request for a grinding run, from the command line or a page.

use super::{Grinding, Process, fastest_rpm, speed_that_skips};
use crate::error::{Result, SimError};
use serde::{Deserialize, Serialize};
use trueaxis::roundness::gain_limit;
use trueaxis_tables::Machine;

/// Length, speed, gain and process of a run; omitted keys have their defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// Turns of the spindle, 8 to 10000; if omitted, 40, or 20 (skip + 1) if that is more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub revolutions: Option<u32>,
    /// Servo rate, Hz, 100 to 100000.
    pub rate_hz: f64,
    /// Speed of the spindle, rpm; with `skip`, replaced by the speed that skips so many revolutions.
    pub speed_rpm: f64,
    /// Gain of the correction c <- c + g r, at most half the stability limit; if omitted, the machine's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Whole revolutions that the gauge has to skip between two evaluated ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skip: Option<u32>,
    /// Feed that remains after roughing, µm of radius per revolution, 0 to 5.
    pub feed_um: f64,
    /// Seed of the rough surface and of every noise.
    pub seed: u64,
}

impl Default for Request {
    fn default() -> Self {
        Request {
            revolutions: None,
            rate_hz: 10_000.0,
            speed_rpm: 30.0,
            gain: None,
            skip: None,
            feed_um: Process::default().feed_um,
            seed: 1,
        }
    }
}

impl Request {
    /// The run on a machine.
    ///
    /// # Errors
    /// A value out of range, under the name of the command line's option; a machine without a gauge that corrects.
    pub fn grinding(&self, mut machine: Machine) -> Result<Grinding> {
        if let (Some(gain), Some(infeed)) =
            (self.gain, machine.settings.roundness.as_mut().and_then(|gauge| gauge.infeed.as_mut()))
        {
            let most = 0.5 * gain_limit(infeed.delay_revolutions);
            if !(gain > 0.0 && gain <= most) {
                let needed = format!(
                    "above 0 and at most {most:.4}, half the limit of stability at a delay of {} revolutions",
                    infeed.delay_revolutions
                );
                return Err(SimError::unsuited("--gain", gain.to_string(), needed));
            }
            infeed.gain = gain;
        }
        let mut grinding = Grinding {
            machine,
            rate_hz: self.rate_hz,
            speed_rpm: self.speed_rpm,
            revolutions: self.turns(),
            seed: self.seed,
            process: Process { feed_um: self.feed_um, ..Process::default() },
            events: Vec::new(),
        };
        let gauge = *grinding.gauge()?;
        if let Some(skip) = self.skip {
            grinding.speed_rpm = speed_that_skips(&gauge, self.rate_hz, skip)?;
        }
        let fastest = fastest_rpm(&gauge, self.rate_hz);
        if !(0.1..=fastest).contains(&grinding.speed_rpm) {
            let needed =
                format!("0.1 to {fastest:.1}, where {} points a revolution pass at {} Hz", gauge.points, self.rate_hz);
            return Err(SimError::unsuited("--speed-rpm", grinding.speed_rpm.to_string(), needed));
        }
        Ok(grinding)
    }

    /// Turns of the spindle.
    fn turns(&self) -> u32 {
        let needed = self.skip.map_or(40, |skip| skip.saturating_add(1).saturating_mul(20).clamp(40, 10_000));
        self.revolutions.unwrap_or(needed)
    }

    /// Checks the values that do not depend on the machine.
    ///
    /// # Errors
    /// A value out of range, under the name of the command line's option.
    pub fn check(&self) -> Result<()> {
        let refuse = |option: &str, found: String, needed: &str| Err(SimError::unsuited(option, found, needed));
        if !(100.0..=100_000.0).contains(&self.rate_hz) {
            return refuse("--rate-hz", self.rate_hz.to_string(), "100 to 100000");
        }
        if !(8..=10_000).contains(&self.turns()) {
            return refuse("--revolutions", self.turns().to_string(), "8 to 10000");
        }
        if !(0.0..=5.0).contains(&self.feed_um) {
            return refuse("--feed-um", self.feed_um.to_string(), "0 to 5");
        }
        Ok(())
    }
}
