//! Simulation settings on the command line: a scenario file, flags for the most common settings, and any other setting by its
//! key.

use anyhow::{Context, Result, anyhow};
use clap::Args;
use std::path::{Path, PathBuf};
use trueaxis::machine::Axis;
use trueaxis_sim::Settings;
use trueaxis_sim::event::{EventKind, EventScript};
use trueaxis_sim::plant::drive::Variant;
use trueaxis_sim::plant::fault::FaultScript;

#[derive(Args)]
pub(crate) struct SettingsArgs {
    /// Settings from a TOML file, as `firmware-sim scenario` prints them; flags and --set take precedence.
    #[arg(long, value_name = "FILE.toml", help_heading = "Settings")]
    pub(crate) scenario: Option<PathBuf>,
    /// Any setting of the scenario file, e.g. --set axis.Y.lost_motion_mm=0.002 (may be given several times).
    #[arg(long, value_name = "KEY=VALUE", help_heading = "Settings")]
    set: Vec<String>,
    /// Servo rate [default: 10000].
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, help_heading = "Settings")]
    rate_hz: Option<f64>,
    /// Seed of the encoders' noise [default: 1].
    #[arg(long, help_heading = "Settings")]
    seed: Option<u64>,
    /// Temperature of the machine, °C [default: the tables' reference temperature].
    #[arg(long, value_name = "C", allow_hyphen_values = true, help_heading = "Settings")]
    temperature_c: Option<f64>,
    /// Machine coordinates of the zero of the program's controller: program zero unless an offset shifts it
    /// [default: 0,0,0 with --offsets, else the middle of the declared travels].
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true, help_heading = "Settings")]
    origin_mm: Option<Vec<f64>>,
    /// Feed override of programmed feeds [default: 100].
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, help_heading = "Settings")]
    feed_percent: Option<f64>,
    /// Largest acceleration along the path, mm/s² [default: 1000].
    #[arg(long, value_name = "MM/S2", allow_negative_numbers = true, help_heading = "Settings")]
    acceleration: Option<f64>,
    /// Largest jerk along the path, mm/s³ [default: 10000].
    #[arg(long, value_name = "MM/S3", allow_negative_numbers = true, help_heading = "Settings")]
    jerk: Option<f64>,
    /// Tuned drive of the simulated machine, of all axes or of one: stiff, usual, soft or worn; each has two masses and a
    /// resonance, `firmware-sim run --help` has their figures (may be given several times) [default: rigid].
    #[arg(long, value_name = "VARIANT[@AXIS]", help_heading = "Settings")]
    drive: Vec<String>,
    /// Position gain Kv of the drives, 1/s [default: 110].
    #[arg(long, value_name = "KV", allow_negative_numbers = true, help_heading = "Settings")]
    position_gain: Option<f64>,
    /// Share of the velocity that is fed forward, 0 to 1 [default: 0.93].
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, help_heading = "Settings")]
    feed_forward: Option<f64>,
    /// Coulomb friction, force per moved mass, mm/s² [default: 420].
    #[arg(long, value_name = "MM/S2", allow_negative_numbers = true, help_heading = "Settings")]
    friction: Option<f64>,
    /// Dead time between a command and the drives [default: 0].
    #[arg(long, value_name = "MS", allow_negative_numbers = true, help_heading = "Settings")]
    dead_time_ms: Option<f64>,
    /// Lost motion of X, Y, Z that the tables do not contain [default: 0].
    #[arg(long, value_name = "UM", allow_negative_numbers = true, help_heading = "Settings")]
    lost_motion_um: Option<f64>,
    /// Noise of the linear encoders, RMS [default: 0.005].
    #[arg(long, value_name = "UM", allow_negative_numbers = true, help_heading = "Settings")]
    noise_um: Option<f64>,
    /// Travel per count of the linear encoders [default: 0.01].
    #[arg(long, value_name = "UM", allow_negative_numbers = true, help_heading = "Settings")]
    resolution_um: Option<f64>,
}

/// What happens during a run.
#[derive(Args, Default)]
pub(crate) struct ActArgs {
    /// Inject a fault, e.g. dropout:X@1.25s+3, glitch:Y@0.5s+1=5mm, stuck:X@2s+500, scale:X@0s+5000=0.5, late@3s+1=2.5,
    /// nan-command:X@2s+1, jump-command:X@2s+1=3mm (may be given several times; time counts from the start of the program).
    #[arg(long, value_name = "FAULT", help_heading = "Faults and events")]
    fault: Vec<String>,
    /// Switch the plugin or a part of it off or on, or exchange its tables in motion, e.g. off:correction@2.5s,
    /// on:correction@3s, off:friction@3s (lag, acceleration, feedback, crosstalk, learned, take-up), on:trial@0s,
    /// off:adapt@3s, reset:adapt@3s, exchange:MACHINE@2s (may be given several times). In a scenario file, MACHINE counts from the file's folder.
    #[arg(long, value_name = "EVENT", help_heading = "Faults and events")]
    event: Vec<String>,
}

impl ActArgs {
    /// Faults alone.
    pub(crate) fn faults(fault: &[String]) -> ActArgs {
        ActArgs { fault: fault.to_vec(), event: Vec::new() }
    }
}

/// Resolves the machines of a scenario file's events relative to its folder.
fn from_folder_of(file: &Path, settings: &mut Settings) {
    let Some(folder) = file.parent() else { return };
    for event in &mut settings.events.items {
        if let EventKind::Exchange(name) = &mut event.kind {
            let resolved = folder.join(&name);
            // A path that does not exist may name a sample.
            if resolved.exists() {
                *name = resolved.display().to_string();
            }
        }
    }
}

/// Sets the drive `VARIANT[@AXIS]`.
fn choose_drive(settings: &mut Settings, drive: &str) -> Result<()> {
    let (name, axis) = drive.split_once('@').map_or((drive, None), |(name, axis)| (name, Some(axis)));
    let variant = Variant::named(name).map_err(|needed| anyhow!("--drive: found {name:?}, needed {needed}"))?;
    let key = match axis {
        None => "drive.variant".to_owned(),
        Some(letter) => {
            let known = Axis::ALL.into_iter().find(|axis| letter.eq_ignore_ascii_case(&axis.letter().to_string()));
            let axis =
                known.ok_or_else(|| anyhow!("--drive: found {drive:?}, needed {name}@AXIS of X, Y, Z, A, B, C"))?;
            format!("axis.{}.drive", axis.letter())
        }
    };
    settings.set(&key, &format!("\"{}\"", variant.name())).map_err(|e| anyhow!("--drive: {e}"))
}

impl SettingsArgs {
    /// The defaults, overridden by the file, the flags and --set, in that order; `acts` are added to those of the file.
    pub(crate) fn settings(&self, acts: &ActArgs) -> Result<Settings> {
        let mut settings = match &self.scenario {
            Some(path) => {
                let text = std::fs::read_to_string(path)
                    .with_context(|| format!("--scenario: cannot read {}", path.display()))?;
                let mut settings = Settings::parse(&text, &path.display().to_string())?;
                from_folder_of(path, &mut settings);
                settings
            }
            None => Settings::default(),
        };
        self.drive.iter().try_for_each(|drive| choose_drive(&mut settings, drive))?;
        for (flag, value, keys) in self.flags() {
            for key in keys {
                let taken = value.as_ref().map_or(Ok(()), |value| settings.set(key, value));
                // If the flag is in micrometres or milliseconds, the error names the setting and its unit too.
                let scaled = flag.ends_with("-um") || flag.ends_with("-ms");
                taken.map_err(|e| match scaled {
                    true => anyhow!("{flag}: {e}"),
                    false => anyhow!("{flag}: found {}, needed {}", e.found, e.needed),
                })?;
            }
        }
        for assignment in &self.set {
            let (key, value) =
                assignment.split_once('=').ok_or_else(|| anyhow!("--set: found {assignment}, needed KEY=VALUE"))?;
            settings.set(key.trim(), value.trim()).map_err(|e| anyhow!("--set {assignment}: {e}"))?;
        }
        settings.check()?;
        settings.faults.items.extend(FaultScript::parse(&acts.fault).map_err(|e| anyhow!("--fault: {e}"))?.items);
        settings.events.items.extend(EventScript::parse(&acts.event).map_err(|e| anyhow!("--event: {e}"))?.items);
        Ok(settings)
    }

    /// Flag, value in TOML, and the settings that it sets.
    fn flags(&self) -> Vec<(&'static str, Option<String>, &'static [&'static str])> {
        // Divided by 1000, not multiplied by 0.001, so that 5 nm becomes the f64 nearest to 5e-6 mm.
        let milli = |value: Option<f64>| value.map(|value| number(value / 1000.0));
        let plain = |value: Option<f64>| value.map(number);
        let origin = self.origin_mm.as_ref().map(|origin| {
            let numbers: Vec<String> = origin.iter().copied().map(number).collect();
            format!("[{}]", numbers.join(", "))
        });
        let lost_motion: &[&str] = &["axis.X.lost_motion_mm", "axis.Y.lost_motion_mm", "axis.Z.lost_motion_mm"];
        vec![
            ("--rate-hz", plain(self.rate_hz), &["rate_hz"]),
            ("--seed", self.seed.map(|seed| seed.to_string()), &["seed"]),
            ("--temperature-c", plain(self.temperature_c), &["temperature_c"]),
            ("--origin-mm", origin, &["origin_mm"]),
            ("--feed-percent", plain(self.feed_percent), &["motion.feed_percent"]),
            ("--acceleration", plain(self.acceleration), &["motion.acceleration_mm_per_s2"]),
            ("--jerk", plain(self.jerk), &["motion.jerk_mm_per_s3"]),
            ("--position-gain", plain(self.position_gain), &["drive.position_gain_per_s"]),
            ("--feed-forward", plain(self.feed_forward), &["drive.velocity_feed_forward"]),
            ("--friction", plain(self.friction), &["drive.coulomb_mm_per_s2"]),
            ("--dead-time-ms", milli(self.dead_time_ms), &["drive.dead_time_s"]),
            ("--lost-motion-um", milli(self.lost_motion_um), lost_motion),
            ("--noise-um", milli(self.noise_um), &["encoder.linear.noise_rms_mm"]),
            ("--resolution-um", milli(self.resolution_um), &["encoder.linear.resolution_mm"]),
        ]
    }
}

/// The number in TOML notation.
fn number(value: f64) -> String {
    if value.is_nan() { "nan".into() } else { format!("{value:?}") }
}
