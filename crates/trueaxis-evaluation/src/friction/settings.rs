//! The figures found, as sections of a `machine.toml` and as additions to a machine.

use super::document::degrees_of_freedom;
use crate::shown::half_width;
use std::fmt::Write;
use std::path::Path;
use trueaxis_metrology::friction::{Figure, Identified};
use trueaxis_report::number::significant;
use trueaxis_tables::Additions;
use trueaxis_tables::finding::{Finding, Fit, Known};
use trueaxis_tables::text::acts;

/// Key in a section of an axis, value, standard error.
type Entry = (&'static str, f64, Option<f64>);

/// Degrees of freedom of the standard errors of the resonance, if one is found.
fn resonance_freedom(axis: &Identified) -> Option<f64> {
    Some(axis.mechanics?.resonance.ok()?.degrees_of_freedom)
}

/// The figures of an axis as in its section `friction`.
fn friction(axis: &Identified) -> [Entry; 5] {
    let of =
        |key, figure: Figure, scale: f64| (key, scale * figure.value, figure.standard_error.map(|error| scale * error));
    [
        of("coulomb_mm_per_s", axis.coulomb_per_s, 1.0),
        of("presliding_um", axis.presliding, 1e3),
        of("stribeck_share", axis.stribeck_share, 1.0),
        of("stribeck_velocity_mm_per_s", axis.stribeck_velocity_per_s, 1.0),
        of("viscous", axis.viscous, 1.0),
    ]
}

/// The figures of an axis as in its section `drive`, if the record determined them.
fn drive(axis: &Identified) -> Option<[Entry; 5]> {
    let [gain, velocity_gain, reset, feed] = axis.drive_errors?.map(Some);
    let drive = &axis.drive;
    Some([
        ("position_gain_per_s", drive.position_gain_per_s, gain),
        ("velocity_gain_per_s", drive.velocity_gain_per_s, velocity_gain),
        ("reset_time_s", drive.reset_time_s, reset),
        ("velocity_feed_forward", drive.velocity_feed_forward, feed),
        ("dead_time_s", drive.dead_time_s, axis.reading_lag_s.standard_error),
    ])
}

/// Resonance and damping as in the section `drive`, if the record determined both.
fn mechanics(axis: &Identified) -> Vec<Entry> {
    let Some(own) = axis.mechanics else { return Vec::new() };
    match own.resonance {
        Ok(found) if found.is_damping_known() => Vec::from([
            ("resonance_hz", found.frequency_hz.value, found.frequency_hz.standard_error),
            ("resonance_damping", found.damping.value, found.damping.standard_error),
        ]),
        _ => Vec::new(),
    }
}

/// The sections `[axis.X.friction]` and, if found, `[axis.X.drive]` as they appear in `machine.toml`, each figure followed by
/// its expanded uncertainty, 95 %; the first line names `record`.
pub fn sections(record: &Path, found: &[Identified]) -> String {
    let mut text = format!(
        "# Friction found in {} by `trueaxis friction`; the expanded uncertainty, 95 %, after ± is not read.\n",
        record.file_name().unwrap_or_default().to_string_lossy().replace(acts, " ")
    );
    for axis in found {
        let (letter, freedom) = (axis.axis.letter(), degrees_of_freedom(axis));
        let of_resonance = resonance_freedom(axis).unwrap_or(freedom);
        let mut put = |section: &str, entries: &[Entry]| {
            let _ = writeln!(text, "\n[axis.{letter}.{section}]");
            for (key, value, error) in entries {
                let freedom = if key.starts_with("resonance") { of_resonance } else { freedom };
                line(&mut text, key, *value, error.map(|error| half_width(error, freedom)));
            }
        };
        if let Some(drive) = drive(axis) {
            let given = drive.into_iter().filter(|(key, value, _)| *key != "dead_time_s" || *value > 0.0);
            put("drive", &given.chain(mechanics(axis)).collect::<Vec<_>>());
        }
        put("friction", &friction(axis));
        if axis.drive_errors.is_none() {
            // Beside the machine's own figures of the drive: a second section of this name would be refused.
            for (key, value, error) in mechanics(axis) {
                let error = error.map(|error| format!("  # ± {}", significant(half_width(error, of_resonance), 2)));
                let error = error.unwrap_or_default();
                let _ = writeln!(text, "# axis.{letter}.drive.{key} = {}{error}", plain(value));
            }
        }
    }
    text
}

/// The figures found, as additions to a machine. The friction of an axis is valid only with the drive figures it was fitted
/// with: all are written or none, including those that the fit kept fixed.
pub fn additions(found: &[Identified]) -> Additions {
    let of_axis = |axis: &Identified| {
        let letter = axis.axis.letter();
        let degrees_of_freedom = degrees_of_freedom(axis);
        let drive = drive(axis).into_iter().flatten().map(|entry| ("drive", entry));
        let all = drive.chain(friction(axis).map(|entry| ("friction", entry)));
        let finding = move |(section, (key, value, uncertainty)): (&str, Entry)| Finding {
            key: format!("axis.{letter}.{section}.{key}"),
            found: Known { value, uncertainty, degrees_of_freedom: Some(degrees_of_freedom) },
            together: letter.to_string(),
            ..Finding::default()
        };
        let own = mechanics(axis).into_iter().map(move |entry| {
            let of = finding(("drive", entry));
            let freedom = resonance_freedom(axis).unwrap_or(degrees_of_freedom);
            Finding {
                found: Known { degrees_of_freedom: Some(freedom), ..of.found },
                together: format!("{letter}, resonance"),
                ..of
            }
        });
        all.map(finding).chain(own).collect::<Vec<_>>()
    };
    let fit = |axis: &Identified| {
        let before_mm = axis.glitch.before.rms;
        Fit {
            before_mm,
            left_mm: before_mm * (1.0 - axis.glitch.explained).max(0.0).sqrt(),
            noise_mm: None,
            is_angle: false,
        }
    };
    let worst = found.iter().map(fit).max_by(|a, b| a.left_mm.total_cmp(&b.left_mm));
    Additions { findings: found.iter().flat_map(of_axis).collect(), fit: worst, ..Additions::default() }
}

/// A key with its value to six digits and its expanded uncertainty, 95 %.
fn line(text: &mut String, key: &str, value: f64, half_width: Option<f64>) {
    let shown = plain(value);
    let _ = match half_width {
        Some(half_width) => writeln!(text, "{key} = {shown}  # ± {}", significant(half_width, 2)),
        None => writeln!(text, "{key} = {shown}  # not determined by the record"),
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
