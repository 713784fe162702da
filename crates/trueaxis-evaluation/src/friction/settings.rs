//! What was found as sections of a `machine.toml`.

use anyhow::{Result, anyhow};
use std::fmt::Write;
use std::path::Path;
use trueaxis_metrology::friction::{Figure, Identified};
use trueaxis_report::number::significant;
use trueaxis_tables::merge_sections;
use trueaxis_tables::text::acts;

/// The sections `[axis.X.friction]` and, where they were found, `[axis.X.drive]`, as `machine.toml` has them, with the
/// standard error behind each figure; `record` is named in the first line.
pub fn sections(record: &Path, found: &[Identified]) -> String {
    let mut text = format!(
        "# Friction found in {} by `trueaxis friction`; behind ± the standard error, which is not read.\n",
        record.file_name().unwrap_or_default().to_string_lossy().replace(acts, " ")
    );
    for axis in found {
        let letter = axis.axis.letter();
        if let Some([gain, velocity_gain, reset, feed]) = axis.drive_errors {
            let drive = &axis.drive;
            let _ = writeln!(text, "\n[axis.{letter}.drive]");
            line(&mut text, "position_gain_per_s", drive.position_gain_per_s, Some(gain));
            line(&mut text, "velocity_gain_per_s", drive.velocity_gain_per_s, Some(velocity_gain));
            line(&mut text, "reset_time_s", drive.reset_time_s, Some(reset));
            line(&mut text, "velocity_feed_forward", drive.velocity_feed_forward, Some(feed));
            if drive.dead_time_s > 0.0 {
                line(&mut text, "dead_time_s", drive.dead_time_s, axis.reading_lag_s.standard_error);
            }
        }
        let _ = writeln!(text, "\n[axis.{letter}.friction]");
        let mut put = |key, figure: Figure, scale: f64| {
            line(&mut text, key, scale * figure.value, figure.standard_error.map(|error| scale * error));
        };
        put("coulomb_mm_per_s", axis.coulomb_per_s, 1.0);
        put("presliding_um", axis.presliding, 1e3);
        put("stribeck_share", axis.stribeck_share, 1.0);
        put("stribeck_velocity_mm_per_s", axis.stribeck_velocity_per_s, 1.0);
        put("viscous", axis.viscous, 1.0);
    }
    text
}

/// The text of a `machine.toml`, called `file` in the error, with [`sections`] in it; everything else stays as it is.
///
/// # Errors
/// An axis that the machine has not got, figures that its tables' reader refuses.
pub fn merged(machine_toml: &str, file: &Path, sections: &str) -> Result<String> {
    merge_sections(machine_toml, sections).map_err(|error| anyhow!("{}: {error}", file.display()))
}

/// A key with its value to six digits, and what is known about it.
fn line(text: &mut String, key: &str, value: f64, error: Option<f64>) {
    let shown = plain(value);
    let _ = match error {
        Some(error) => writeln!(text, "{key} = {shown}  # ± {}", significant(error, 2)),
        None => writeln!(text, "{key} = {shown}  # not told by the record"),
    };
}

/// A decimal number that TOML reads as a float, six significant digits.
fn plain(value: f64) -> String {
    if value == 0.0 {
        return "0.0".into();
    }
    let digits = (5 - value.abs().log10().floor() as i32).clamp(1, 12) as usize;
    let text = format!("{value:.digits$}");
    let short = text.trim_end_matches('0');
    if short.ends_with('.') { format!("{short}0") } else { short.into() }
}
