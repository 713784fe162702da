//! A request, as command-line options and as a JSON object with the options' names.

use super::grid::Range;
use serde::de::{Error, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};
use trueaxis_metrology::helicoid::{Branch, Flank, Form};

/// A request as given; nothing is checked before [`super::Job::new`].
///
/// In a JSON object, keys are the command-line options with underscores, and ranges are texts `START:STOP:COUNT`. Omitted keys
/// have the command line's defaults; unknown keys are refused.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Radius r_b of the base cylinder, mm; with the lead parameter, in place of a gear.
    #[serde(default)]
    pub base_radius_mm: Option<f64>,
    /// Lead parameter p, mm/rad; positive for a right-hand helix.
    #[serde(default)]
    pub lead_parameter_mm_per_rad: Option<f64>,
    /// Normal module m_n of a gear, mm.
    #[serde(default)]
    pub module_mm: Option<f64>,
    /// Number of teeth.
    #[serde(default, deserialize_with = "teeth")]
    pub teeth: Option<u32>,
    /// Normal pressure angle α_n, degrees.
    #[serde(default)]
    pub pressure_angle_deg: Option<f64>,
    /// Helix angle β at the reference cylinder, degrees; positive for a right-hand helix.
    #[serde(default)]
    pub helix_angle_deg: Option<f64>,
    /// Roll angles u of the involute.
    #[serde(deserialize_with = "u_rad")]
    pub u_rad: Range,
    /// Angles θ along the helix.
    #[serde(deserialize_with = "theta_rad")]
    pub theta_rad: Range,
    /// Form of the head at A = 0.
    #[serde(default, with = "FormName")]
    pub form: Form,
    /// Pivot length L, mm, tool tip to A axis.
    #[serde(default)]
    pub pivot_mm: Option<f64>,
    /// Travel a of an edge finder, mm, in place of the pivot length: L = a + r.
    #[serde(default)]
    pub edge_finder_mm: Option<f64>,
    /// Radius r of the edge finder's ball, mm.
    #[serde(default)]
    pub edge_finder_radius_mm: Option<f64>,
    /// Which of the two solutions for the axes, 1 or 2.
    #[serde(default, deserialize_with = "branch")]
    pub branch: Branch,
    /// Side of the tooth, seen from +z with its tip up.
    #[serde(default = "right", with = "FlankName")]
    pub flank: Flank,
    /// Position of the gear's origin on the table, mm.
    #[serde(default)]
    pub work_offset_mm: [f64; 3],
    /// Sense of the A axis; 1: right-handed turn of the tool about +x.
    #[serde(default = "positive")]
    pub direction_a: i8,
    /// Sense of the C axis; 1: right-handed turn of the workpiece about +z.
    #[serde(default = "positive")]
    pub direction_c: i8,
    /// Feed of the program, mm/min.
    #[serde(default = "feed")]
    pub feed_mm_per_min: f64,
    /// Distance of the tool from the flank, and above it, before and after the program's passes, mm.
    #[serde(default = "clearance")]
    pub clearance_mm: f64,
    /// Parameter along which the program's passes run.
    #[serde(default)]
    pub passes: Passes,
}

/// Parameter along which the passes run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Passes {
    /// Along the helix.
    #[default]
    Theta,
    /// Along the involute.
    U,
}

fn right() -> Flank {
    Flank::Right
}

fn positive() -> i8 {
    1
}

fn feed() -> f64 {
    Request::FEED_MM_PER_MIN
}

fn clearance() -> f64 {
    Request::CLEARANCE_MM
}

impl Request {
    /// Default feed of a program.
    pub const FEED_MM_PER_MIN: f64 = 500.0;
    /// Default clearance of a program.
    pub const CLEARANCE_MM: f64 = 50.0;
    /// Requirement for a number of teeth.
    pub const TEETH: &str = "a whole number of teeth, 1 to 10000";
}

#[derive(Deserialize)]
#[serde(remote = "Form", rename_all = "lowercase")]
enum FormName {
    Vertical,
    Horizontal,
}

#[derive(Deserialize)]
#[serde(remote = "Flank", rename_all = "lowercase")]
enum FlankName {
    Right,
    Left,
}

fn u_rad<'de, D: Deserializer<'de>>(from: D) -> Result<Range, D::Error> {
    range(from, "--u-rad")
}

fn theta_rad<'de, D: Deserializer<'de>>(from: D) -> Result<Range, D::Error> {
    range(from, "--theta-rad")
}

fn range<'de, D: Deserializer<'de>>(from: D, option: &str) -> Result<Range, D::Error> {
    Range::parse(&String::deserialize(from)?).map_err(|error| D::Error::custom(format_args!("{option}: {error}")))
}

fn branch<'de, D: Deserializer<'de>>(from: D) -> Result<Branch, D::Error> {
    match u8::deserialize(from)? {
        1 => Ok(Branch::First),
        2 => Ok(Branch::Second),
        other => Err(D::Error::invalid_value(Unexpected::Unsigned(other.into()), &"branch 1 or 2")),
    }
}

fn teeth<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u32>, D::Error> {
    let Some(found) = Option::<f64>::deserialize(from)? else { return Ok(None) };
    // Larger counts than any gear has pass to the check, which names the option.
    if found.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&found) {
        return Ok(Some(found as u32));
    }
    Err(D::Error::custom(format_args!("--teeth: found {found}, needed {}", Request::TEETH)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST: &str =
        r#""base_radius_mm":36,"lead_parameter_mm_per_rad":130,"u_rad":"0.2:0.6:3","theta_rad":"-0.1:0.1:5""#;

    fn read(more: &str) -> Result<Request, serde_json::Error> {
        serde_json::from_str(&format!("{{{LEAST}{more}}}"))
    }

    #[test]
    fn omitted_fields_have_the_command_lines_defaults() {
        let request = read("").unwrap();
        assert_eq!((request.form, request.flank, request.branch), (Form::Horizontal, Flank::Right, Branch::First));
        assert_eq!((request.direction_a, request.direction_c, request.work_offset_mm), (1, 1, [0.0; 3]));
        assert_eq!((request.feed_mm_per_min, request.clearance_mm, request.passes), (500.0, 50.0, Passes::Theta));
        assert_eq!((request.u_rad.count, request.theta_rad.start, request.teeth), (3, -0.1, None));
    }

    #[test]
    fn objects_that_cannot_be_are_refused_with_what_is_needed() {
        for (more, said) in [
            (r#","teeth":24.5"#, "--teeth: found 24.5, needed a whole number of teeth"),
            (r#","teeth":-1"#, "--teeth: found -1, needed"),
            (r#","branch":3"#, "branch 1 or 2"),
            (r#","form":"slanted""#, "`vertical` or `horizontal`"),
            (r#","pivot":150"#, "unknown field `pivot`"),
            (r#","work_offset_mm":[1,2]"#, "array of length 3"),
        ] {
            let error = read(more).unwrap_err().to_string();
            assert!(error.contains(said), "{more}: {error}");
        }
        let error = serde_json::from_str::<Request>(r#"{"u_rad":"0:1:0","theta_rad":"0:1:2"}"#).unwrap_err();
        assert!(error.to_string().contains("--u-rad: found COUNT 0, needed 1 to 1000000"), "{error}");
    }
}
