//! The values of a circular test in readable form.

use super::BallbarDocument;
use trueaxis_report::number::significant;

/// Every value as text: name, value with unit (– if the record does not determine it), half-width of its 95 % interval.
pub fn values(document: &BallbarDocument) -> Vec<[String; 3]> {
    let d = document;
    let error = |key: &str, part: Option<&str>| {
        let of = d.expanded_uncertainties.get(key);
        part.map_or(of, |part| of.and_then(|of| of.get(part))).and_then(serde_json::Value::as_f64)
    };
    let mut values = Vec::new();
    let mut put = |name: String, unit: &str, value: Option<f64>, error: Option<f64>| {
        let value = value.map_or_else(|| "–".into(), |value| format!("{} {unit}", significant(value, 4)));
        values.push([name, value, error.map_or_else(String::new, |error| format!("± {}", significant(error, 2)))]);
    };
    let letters: Vec<char> = d.plane.chars().collect();
    let mismatch = letters.iter().map(char::to_string).collect::<Vec<_>>().join(" − ");
    put(format!("squareness {}", d.squareness), "µrad", Some(d.squareness_urad), error("squareness_urad", None));
    put(format!("scale mismatch {mismatch}"), "ppm", Some(d.scale_mismatch_ppm), error("scale_mismatch_ppm", None));
    put(format!("servo mismatch {mismatch}"), "µm", d.servo_mismatch_um, error("servo_mismatch_um", None));
    for (name, key, pair) in [
        ("backlash", "backlash_um", &d.backlash_um),
        ("reversal spikes", "reversal_um", &d.reversal_um),
        ("lateral play", "lateral_play_um", &d.lateral_play_um),
        ("straightness", "straightness_um", &d.straightness_um),
        ("cyclic error", "cyclic_um", &d.cyclic_um),
    ] {
        for letter in &letters {
            let key_of = letter.to_ascii_lowercase();
            let value = pair.get(&key_of).copied().flatten();
            put(format!("{name} {letter}"), "µm", value, error(key, Some(&key_of.to_string())));
        }
    }
    values
}
