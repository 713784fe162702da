//! Flanks of helical gears: deviations of profile and helix along the normal, and their classes.
//!
//! ```text
//! F = r_b (cos φ + u sin φ, sin φ − u cos φ), p θ      u from the radius, φ from the angle of a programmed point about the gear's axis
//! δ = n · (p_cut − p_programmed)                       positive: material is left
//! f_H = slope of δ times the length, f_f = range of the rest, F = range of δ
//! ```
//!
//! The profile is evaluated in the middle of the face over the length of roll r_b u, the helix nearest to the reference
//! cylinder over the face width; both over all that the program cuts.
//!
//! Sources: ISO 21771:2007 (gear data); ISO 1328-1:2013, 5.3 (tolerances of the classes).

use super::circle::NEAR;
use crate::calibrate::ranges::number;
use glam::{DMat3, DVec3};
use trueaxis_metrology::helicoid::{Flank, Gear, GearData, Helicoid};
use trueaxis_tables::Section;
use trueaxis_tables::error::FileError;

/// Fewest points of a trace: of two, every line is straight.
const FEWEST: usize = 5;
/// Width of a line of the grid as a share of the whole: the rounding of a program.
const ON_LINE: f64 = 1e-3;
/// Height that is cut, as a share of the face width: ends may be relieved.
const FACE: [f64; 2] = [0.8, 1.05];
/// Classes of ISO 1328-1.
pub(super) const CLASSES: [f64; 2] = [1.0, 11.0];

/// The flank that a feature of the kind `flank` is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearFlank {
    /// The gear.
    pub gear: Gear,
    /// Side of its teeth.
    pub flank: Flank,
    /// Gear's axis in the coordinates of its set-up's program, mm.
    pub axis_mm: [f64; 2],
    /// Face width, mm.
    pub face_mm: f64,
}

/// A deviation of a flank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlankDeviation {
    /// F_α.
    ProfileTotal,
    /// f_fα.
    ProfileForm,
    /// f_Hα.
    ProfileSlope,
    /// F_β.
    HelixTotal,
    /// f_fβ.
    HelixForm,
    /// f_Hβ.
    HelixSlope,
}

/// A whole number within a range.
pub(super) fn whole(section: &Section<'_>, key: &str, within: [f64; 2]) -> Result<Option<f64>, FileError> {
    match section.number(key)? {
        Some(found) if found.value.fract() != 0.0 => Err(section.wrong(&found, "a whole number")),
        _ => number(section, key, within, ""),
    }
}

impl FlankDeviation {
    /// Whether its sign counts: a slope has two limits.
    pub(super) fn is_slope(self) -> bool {
        matches!(self, FlankDeviation::ProfileSlope | FlankDeviation::HelixSlope)
    }
}

impl GearFlank {
    pub(super) fn read(section: &Section<'_>) -> Result<GearFlank, FileError> {
        let needed = |key: &str, needed: &str, within: [f64; 2], unit: &str| {
            number(section, key, within, unit)?.ok_or_else(|| section.missing_here(key, needed))
        };
        let teeth = whole(section, "teeth", [5.0, 1000.0])?;
        let teeth = teeth.ok_or_else(|| section.missing_here("teeth", "the number of teeth"))?;
        let gear = Gear {
            module_mm: needed("module_mm", "the normal module, mm", [0.5, 70.0], " mm")?,
            teeth: teeth as u32,
            pressure_angle_deg: number(section, "pressure_angle_deg", [10.0, 30.0], " degrees")?.unwrap_or(20.0),
            helix_angle_deg: needed("helix_angle_deg", "the helix angle, degrees, not 0", [-45.0, 45.0], " degrees")?,
        };
        let side = section.choice("flank", [("right", Flank::Right), ("left", Flank::Left)])?;
        let flank = side.unwrap_or(Flank::Right);
        let axis_mm = section.numbers::<2>("axis_mm")?.map_or([0.0; 2], |found| found.value);
        let face_mm = needed("face_mm", "the face width, mm", [4.0, 1200.0], " mm")?;
        let checked = gear.helicoid(flank);
        if let Err(error) = checked {
            let found = error.found.to_string();
            return Err(section.at(section.first_line(), "flank", &found, error.needed));
        }
        Ok(GearFlank { gear, flank, axis_mm, face_mm })
    }

    /// Tolerance of a class, mm.
    pub(super) fn tolerance(&self, of: FlankDeviation, class: f64) -> f64 {
        let module = self.gear.module_mm;
        let diameter = self.gear.data().map_or(0.0, |data| 2.0 * data.reference_radius_mm);
        let face = self.face_mm;
        let step = 2f64.powf(0.5 * (class - 5.0));
        let profile = [0.4 * module + 0.001 * diameter + 4.0, 0.55 * module + 5.0];
        let helix =
            [0.05 * diameter.sqrt() + 0.35 * face.sqrt() + 4.0, 0.07 * diameter.sqrt() + 0.45 * face.sqrt() + 4.0];
        let um = match of {
            FlankDeviation::ProfileSlope => profile[0] * step,
            FlankDeviation::ProfileForm => profile[1] * step,
            FlankDeviation::ProfileTotal => profile[0].hypot(profile[1]) * step,
            FlankDeviation::HelixSlope => helix[0] * step,
            FlankDeviation::HelixForm => helix[1] * step,
            FlankDeviation::HelixTotal => helix[0].hypot(helix[1]) * step,
        };
        // Rounded as the standard does, to 1, 0.5 and 0.1 µm.
        let unit = if um > 10.0 {
            1.0
        } else if um >= 5.0 {
            2.0
        } else {
            10.0
        };
        1e-3 * (um * unit).round() / unit
    }
}

/// A point of a trace: its index among the points of the feature, and its coordinate, mm.
type Trace = Vec<(usize, f64)>;

/// The two traces that are evaluated on a flank.
#[derive(Clone, Debug)]
pub(super) struct Traces {
    profile: Trace,
    helix: Trace,
    programmed: Vec<DVec3>,
    /// Outward normals of all points.
    normals: Vec<DVec3>,
}

impl Traces {
    /// The traces through programmed points of the part; directions and zero of the program that cuts them.
    ///
    /// # Errors
    /// Points that are not on the flank, or not on a grid of passes along it.
    pub(super) fn of(
        of: &GearFlank,
        programmed: Vec<DVec3>,
        (to_part, zero): (DMat3, DVec3),
    ) -> Result<Traces, &'static str> {
        let data: GearData = of.gear.data().map_err(|_| "a gear")?;
        let surface = of.gear.helicoid(of.flank).map_err(|_| "a gear")?;
        let axis = DVec3::new(of.axis_mm[0], of.axis_mm[1], 0.0);
        // The gear stands where the set-up's program has it.
        let local = |point: &DVec3| to_part.transpose() * (*point - zero) - axis;
        let placed = programmed.iter().map(|point| Placed::of(local(point), &surface));
        let placed: Vec<Placed> = placed.collect::<Option<_>>().ok_or(BELOW)?;
        let first = placed.first().ok_or(BELOW)?;
        // Another tooth or another zero of z is the same flank, turned about its axis.
        let pitch = std::f64::consts::TAU * surface.lead_parameter().abs();
        let apart = |other: &Placed| (other.climb - first.climb + 0.5 * pitch).rem_euclid(pitch) - 0.5 * pitch;
        if placed.iter().any(|other| apart(other).abs() * surface.tilt().cos() > 2.0 * NEAR) {
            return Err("points on one flank of the gear");
        }
        let range = |value: fn(&Placed) -> f64| {
            let all = || placed.iter().map(value);
            [all().fold(f64::MAX, f64::min), all().fold(f64::MIN, f64::max)]
        };
        let [low, high] = range(|one| one.z);
        let middle = 0.5 * (low + high);
        if !(FACE[0]..=FACE[1]).contains(&((high - low) / of.face_mm)) {
            return Err("a program that cuts the face, face_mm: 80 to 105 % of it");
        }
        let reference = data.reference_roll_angle_rad * of.flank.sign();
        let [least, most] = range(|one| one.u);
        if !(least..=most).contains(&reference) {
            return Err("roll angles on both sides of the reference cylinder");
        }
        let profile = trace(&placed, |one| one.z, middle, |one| surface.base_radius() * one.u);
        let helix = trace(&placed, |one| one.u, reference, |one| one.z);
        if profile.len() < FEWEST || helix.len() < FEWEST {
            return Err("passes over a grid of at least five profiles and five heights");
        }
        let normal = |one: &Placed| to_part * DVec3::from(surface.normal(one.u, one.phi - one.u));
        let normals = placed.iter().map(normal).collect();
        Ok(Traces { profile, helix, programmed, normals })
    }

    /// A deviation of the points that are cut, mm.
    pub(super) fn value(&self, of: FlankDeviation, cut: &[DVec3]) -> f64 {
        use FlankDeviation::{HelixForm, HelixSlope, HelixTotal, ProfileForm, ProfileSlope, ProfileTotal};
        let trace = if matches!(of, ProfileTotal | ProfileForm | ProfileSlope) { &self.profile } else { &self.helix };
        let along = |index: usize| self.normals[index].dot(cut[index] - self.programmed[index]);
        let count = trace.len() as f64;
        let mean = |value: &dyn Fn(&(usize, f64)) -> f64| trace.iter().map(value).sum::<f64>() / count;
        let [s0, d0] = [mean(&|(_, s)| *s), mean(&|(index, _)| along(*index))];
        let product = mean(&|(index, s)| (s - s0) * (along(*index) - d0));
        let slope = product / mean(&|(_, s)| (s - s0) * (s - s0)).max(f64::MIN_POSITIVE);
        let range = |slope: f64| {
            let rest = || trace.iter().map(|(index, s)| along(*index) - slope * s);
            rest().fold(f64::MIN, f64::max) - rest().fold(f64::MAX, f64::min)
        };
        match of {
            ProfileTotal | HelixTotal => range(0.0),
            ProfileForm | HelixForm => range(slope),
            ProfileSlope | HelixSlope => {
                let ends = || trace.iter().map(|(_, s)| *s);
                slope * (ends().fold(f64::MIN, f64::max) - ends().fold(f64::MAX, f64::min))
            }
        }
    }
}

const BELOW: &str = "points outside the base cylinder of the gear";

/// A programmed point on the flank.
struct Placed {
    u: f64,
    phi: f64,
    z: f64,
    /// z − p θ, the same for all points of a flank up to a turn.
    climb: f64,
}

impl Placed {
    fn of(point: DVec3, surface: &Helicoid) -> Option<Placed> {
        let ratio = point.x.hypot(point.y) / surface.base_radius();
        let u = surface.flank().sign() * (ratio * ratio - 1.0).max(0.0).sqrt();
        // (cos φ + u sin φ, sin φ − u cos φ) is at the angle φ − atan u.
        let phi = point.y.atan2(point.x) + u.atan();
        let climb = point.z - surface.lead_parameter() * (phi - u);
        (ratio >= 1.0).then_some(Placed { u, phi, z: point.z, climb })
    }
}

/// The points of which `level` is nearest to a value, in order of a coordinate: those of one line of the grid.
fn trace(placed: &[Placed], level: fn(&Placed) -> f64, at: f64, along: impl Fn(&Placed) -> f64) -> Trace {
    let away = |one: &Placed| (level(one) - at).abs();
    let Some(nearest) = placed.iter().min_by(|a, b| away(a).total_cmp(&away(b))).map(level) else { return Vec::new() };
    let all = || placed.iter().map(level);
    let width = all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min);
    let on_line = |one: &Placed| (level(one) - nearest).abs() <= ON_LINE * width;
    let mut found: Trace =
        placed.iter().enumerate().filter(|(_, one)| on_line(one)).map(|(k, one)| (k, along(one))).collect();
    found.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    found
}
