//! Key in `machine.toml` of a setting that the controller's checks refuse.

use super::section::line;
use toml::de::DeTable;
use trueaxis::error::{ConfigError, Field};

/// Where a setting is stated, or could be.
pub(super) struct Key {
    /// Line of the key, or of the innermost section that is there; 0 where there is none.
    pub(super) line: u32,
    /// Full name.
    pub(super) name: String,
    /// Value as written; `None` where the file leaves the key out.
    pub(super) text: Option<String>,
}

/// The key of an error's setting in the text of the file; `None` for an error of no single setting.
pub(super) fn locate(text: &str, error: &ConfigError) -> Option<Key> {
    let (sections, names) = path(error)?;
    let full = |name: &str| if sections.is_empty() { name.to_owned() } else { format!("{sections}.{name}") };
    let document = DeTable::parse(text).ok()?;
    let (mut table, mut at) = (Some(document.get_ref()), 0);
    for section in sections.split('.').filter(|section| !section.is_empty()) {
        let entry = table.and_then(|table| table.get_key_value(section));
        table = entry.and_then(|(_, inside)| inside.get_ref().as_table());
        at = entry.map_or(at, |(name, _)| line(text, name.span().start));
    }
    let given = names.iter().find_map(|name| Some((name, table?.get(name.as_str())?)));
    Some(match given {
        Some((name, value)) => {
            let span = value.span();
            Key { line: line(text, span.start), name: full(name), text: text.get(span).map(str::to_owned) }
        }
        None => Key { line: at, name: full(names.first()?), text: None },
    })
}

/// Sections and names of the keys that may state the setting of an error, the usual one first.
fn path(error: &ConfigError) -> Option<(String, Vec<String>)> {
    let (field, key, index) = (error.field, error.key, error.index.unwrap_or(0) as usize);
    let is_rotary = error.axis.is_some_and(|axis| axis.is_rotary());
    let letter = error.axis.map_or(' ', |axis| axis.letter());
    let (unit, micro) = if is_rotary { ("deg", "urad") } else { ("mm", "um") };
    let root = |name: &str| Some((String::new(), vec![name.to_owned()]));
    let within = |section: &str, name: String| Some((section.to_owned(), vec![name]));
    let of_axis = |name: String| Some((format!("axis.{letter}"), vec![name]));
    let of_part = |part: &str, name: String| Some((format!("axis.{letter}.{part}"), vec![name]));
    match field {
        Field::Name => root("name"),
        Field::Chain | Field::Axes => root("chain"),
        Field::Tool => root("tool_mm"),
        Field::ReferenceTemperature => root("reference_temperature_c"),
        Field::Location => within("location", location(error, index)),
        Field::Travel => of_axis(format!("travel_{unit}")),
        Field::Joint => of_axis(format!("joint_{unit}")),
        Field::MeasuredAt => of_axis("measured_at_mm".into()),
        Field::MaxFeed => of_axis(format!("max_feed_{unit}_per_min")),
        Field::Direction => of_axis("direction".into()),
        Field::Backlash => of_axis(format!("backlash_{micro}")),
        Field::Hysteresis => of_axis(format!("hysteresis_{micro}")),
        Field::Encoder => of_axis(format!("encoder_resolution_{micro}")),
        Field::Offset => of_axis("offset_mm".into()),
        Field::Table => of_axis("table".into()),
        Field::Magnitude => of_part("limits", format!("magnitude_{micro}")),
        Field::Slope => of_part("limits", format!("slope_{unit}_per_s")),
        Field::Acceleration => of_part("limits", format!("acceleration_{unit}_per_s2")),
        Field::Thermal => {
            let expansion = if is_rotary { "expansion_urad_per_rad_k" } else { "expansion_um_per_m_k" };
            of_part(
                "thermal",
                match key {
                    "offset" => format!("offset_{micro}_per_k"),
                    "datum" => format!("datum_{unit}"),
                    _ => expansion.to_owned(),
                },
            )
        }
        Field::Faults if key == "command_jump_factor" => within("faults", key.into()),
        Field::Faults => within("faults", format!("{key}_{}", if index == 0 { "mm" } else { "deg" })),
        Field::Contour => within("contour", "max_lag_mm".into()),
        Field::Compensation => within("compensation", "fade_deg".into()),
        Field::Kinematics if key == "tool_axis" => within("kinematics", key.into()),
        Field::Kinematics => within("kinematics", "singular_cone_deg".into()),
        _ => of_gauge(field, key),
    }
}

/// `A0Z`, `B0Z` and `C0Y`, or a location error of a rotary axis.
fn location(error: &ConfigError, index: usize) -> String {
    match error.axis {
        None => ["A0Z_urad", "B0Z_urad", "C0Y_urad"].get(index).copied().unwrap_or_default().into(),
        Some(axis) => {
            let direction = ["X", "Y", "Z", "A", "B", "C"].get(index).copied().unwrap_or_default();
            format!("E{direction}0{}_{}", axis.letter(), if index < 3 { "um" } else { "urad" })
        }
    }
}

/// A key of `[roundness]` or a section in it.
fn of_gauge(field: Field, key: &str) -> Option<(String, Vec<String>)> {
    let (section, name) = match (field, key) {
        (Field::Points, _) => ("", "points"),
        (Field::Harmonics, _) => ("", "harmonics"),
        (Field::ProbeAngles, "") => {
            let names = ["probe_slots", "probe_angles_deg"].map(str::to_owned);
            return Some(("roundness".into(), names.into()));
        }
        (Field::Filter, _) => ("", "filter_upr"),
        (Field::Probe, "probe_gain") => ("", "probe_gain_um"),
        (Field::Spindle, "stop") => ("", "stop_s"),
        (Field::Spindle, "direction") => ("", "spindle_direction"),
        (Field::Spindle, "counts_per_revolution") => ("", "spindle_counts_per_revolution"),
        (Field::ProbeAngles | Field::Probe | Field::Spindle | Field::Revolutions, key) => ("", key),
        (Field::Arm, "crank") => (".arm", "crank_mm"),
        (Field::Arm, "wheel") => (".arm", "wheel_mm"),
        (Field::Arm, "pin") => (".arm", "pin_mm"),
        (Field::Arm, "tolerance") => (".arm", "tolerance_deg"),
        (Field::Arm, key) => (".arm", key),
        (Field::Infeed, "contact") => (".infeed", "contact_deg"),
        (Field::Infeed, "drive_delay") => (".infeed", "drive_delay_s"),
        (Field::Infeed, "limit") => (".infeed", "limit_um"),
        (Field::Infeed, key) => (".infeed", key),
        _ => return None,
    };
    Some((format!("roundness{section}"), vec![name.to_owned()]))
}
