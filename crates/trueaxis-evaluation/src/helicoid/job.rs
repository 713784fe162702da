//! A checked request; errors name the command-line options.

use super::grid::{MOST, Range, is_coarse};
use super::request::{Passes, Request};
use anyhow::{Error, Result, anyhow, bail};
use trueaxis_metrology::error::{InputError, Quantity};
use trueaxis_metrology::helicoid::{
    Branch, Flank, Form, Gear, GearData, HeadTable, Helicoid, MachineSettings, Placement, pivot_length,
};

/// A checked request.
#[derive(Clone, Debug)]
pub struct Job {
    /// The gear and the data derived from it, if the request states a gear.
    pub gear: Option<(Gear, GearData)>,
    /// The flank.
    pub surface: Helicoid,
    /// Machine settings as requested.
    pub settings: MachineSettings,
    /// The machine, checked.
    pub machine: HeadTable,
    /// Travel and ball radius of the edge finder that gave the pivot length, mm.
    pub edge_finder_mm: Option<[f64; 2]>,
    /// Which of the two solutions for the axes.
    pub branch: Branch,
    /// Roll angles u, rad.
    pub u: Range,
    /// Angles θ, rad.
    pub theta: Range,
    /// Feed of the program, mm/min.
    pub feed_mm_per_min: f64,
    /// Clearance of the program, mm.
    pub clearance_mm: f64,
    /// Parameter along which the program's passes run.
    pub passes: Passes,
}

/// Restates an input error with the name of its option.
pub(super) fn named(error: Error) -> Error {
    match error.downcast_ref::<InputError>() {
        Some(error) => by_option(*error),
        None => error,
    }
}

pub(super) fn by_option(error: InputError) -> Error {
    let option = match error.quantity {
        Quantity::GearModule => "--module-mm",
        Quantity::Teeth => "--teeth",
        Quantity::PressureAngle => "--pressure-angle-deg",
        Quantity::HelixAngle => "--helix-angle-deg",
        Quantity::BaseRadius => "--base-radius-mm",
        Quantity::LeadParameter => "--lead-parameter-mm-per-rad",
        Quantity::RollAngle => "--u-rad",
        Quantity::LeadAngle => "--theta-rad",
        Quantity::Pivot => "--pivot-mm",
        Quantity::EdgeFinder => "--edge-finder-mm",
        Quantity::EdgeFinderRadius => "--edge-finder-radius-mm",
        Quantity::WorkOffset => "--work-offset-mm",
        Quantity::Flank => {
            return anyhow!("--flank: found a lead parameter p of {} mm/rad, needed {}", error.found, error.needed);
        }
        _ => return error.into(),
    };
    anyhow!("{option}: found {}, needed {}", error.found, error.needed)
}

impl Job {
    /// Checks a request. Computes only the surface and the gear's data.
    ///
    /// # Errors
    /// A surface given twice or incompletely, a gear, flank, pivot length, offset, feed or clearance out of its range, more
    /// than [`MOST`] points; found and needed, by the command-line option. Computing the points detects u and θ beyond the
    /// flank.
    pub fn new(request: &Request) -> Result<Job> {
        let (gear, surface) = surface(request)?;
        let (pivot_mm, edge_finder_mm) = pivot(request)?;
        let settings = MachineSettings {
            form: request.form,
            pivot_mm,
            direction_a: request.direction_a,
            direction_c: request.direction_c,
            work_offset_mm: request.work_offset_mm,
        };
        let machine = HeadTable::new(&settings).map_err(by_option)?;
        let gear = gear.map(|gear| gear.data().map(|data| (gear, data))).transpose().map_err(by_option)?;
        let (feed, clearance) = (request.feed_mm_per_min, request.clearance_mm);
        if !(feed > 0.0 && feed <= 1e6) {
            bail!("--feed-mm-per-min: found {feed}, needed a feed above 0, at most 1e6 mm/min");
        }
        if !(0.0..=1e6).contains(&clearance) {
            bail!("--clearance-mm: found {clearance}, needed a distance from 0 to 1e6 mm");
        }
        let count = request.u_rad.count.saturating_mul(request.theta_rad.count);
        if count > MOST {
            bail!("--u-rad, --theta-rad: found {count} points, needed at most {MOST}");
        }
        Ok(Job {
            gear,
            surface,
            settings,
            machine,
            edge_finder_mm,
            branch: request.branch,
            u: request.u_rad,
            theta: request.theta_rad,
            feed_mm_per_min: feed,
            clearance_mm: clearance,
            passes: request.passes,
        })
    }

    /// Axis positions at a place of the flank.
    ///
    /// # Errors
    /// u or θ beyond the flank, by the command-line option.
    pub fn place(&self, u: f64, theta: f64, branch: Branch) -> Result<Placement> {
        self.machine.place(&self.surface, u, theta, branch).map_err(by_option)
    }

    /// `vertical` or `horizontal`.
    pub fn form_name(&self) -> &'static str {
        if self.settings.form == Form::Vertical { "vertical" } else { "horizontal" }
    }

    /// `right flank` or `left flank`.
    pub fn flank_name(&self) -> &'static str {
        if self.surface.flank() == Flank::Right { "right flank" } else { "left flank" }
    }

    /// 1 or 2.
    pub fn branch_number(&self) -> u8 {
        number(self.branch)
    }

    /// Notes for a reader of the result: the source of the pivot length, and a grid too coarse for straight moves.
    pub fn notes(&self) -> Vec<String> {
        let pivot = self.edge_finder_mm.map(|[travel, radius]| {
            format!("pivot length {} mm = travel {travel} mm + ball radius {radius} mm", self.settings.pivot_mm)
        });
        let ranges = [("--u-rad", self.u), ("--theta-rad", self.theta)];
        let coarse = ranges.into_iter().filter(|(_, range)| is_coarse(*range));
        let coarse = coarse.map(|(name, _)| {
            format!("{name}: C turns by more than half a turn between points, and a straight move leaves the surface")
        });
        pivot.into_iter().chain(coarse).collect()
    }
}

/// X, Y, Z, A, C; adding 0 turns a −0 into 0.
pub(super) fn five(axes: &Placement) -> [f64; 5] {
    let [x, y, z] = axes.linear_mm;
    [x, y, z, axes.a_deg, axes.c_deg].map(|value| value + 0.0)
}

/// 1 or 2.
pub(super) fn number(branch: Branch) -> u8 {
    if branch == Branch::First { 1 } else { 2 }
}

fn surface(request: &Request) -> Result<(Option<Gear>, Helicoid)> {
    let of_base = [
        ("--base-radius-mm", request.base_radius_mm.is_some()),
        ("--lead-parameter-mm-per-rad", request.lead_parameter_mm_per_rad.is_some()),
    ];
    let of_gear = [
        ("--module-mm", request.module_mm.is_some()),
        ("--teeth", request.teeth.is_some()),
        ("--pressure-angle-deg", request.pressure_angle_deg.is_some()),
        ("--helix-angle-deg", request.helix_angle_deg.is_some()),
    ];
    let given = |of: &[(&'static str, bool)]| of.iter().find(|(_, given)| *given).map(|(name, _)| *name);
    if let (Some(base), Some(gear)) = (given(&of_base), given(&of_gear)) {
        bail!("found both {base} and {gear}, needed either base radius and lead parameter or a gear");
    }
    let missing = |of: &[(&'static str, bool)]| {
        of.iter().filter(|(_, given)| !given).map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
    };
    if let Some(given) = given(&of_base) {
        let (Some(base_radius), Some(lead_parameter)) = (request.base_radius_mm, request.lead_parameter_mm_per_rad)
        else {
            bail!("found {given} alone, needed {} with it", missing(&of_base));
        };
        return Ok((None, Helicoid::new(base_radius, lead_parameter, request.flank).map_err(by_option)?));
    }
    let (Some(module_mm), Some(teeth), Some(pressure_angle_deg), Some(helix_angle_deg)) =
        (request.module_mm, request.teeth, request.pressure_angle_deg, request.helix_angle_deg)
    else {
        let found = given(&of_gear).map_or("no surface".to_owned(), |name| format!("a gear's {name}"));
        let base = if given(&of_gear).is_none() {
            ", or --base-radius-mm and --lead-parameter-mm-per-rad"
        } else {
            " as well"
        };
        bail!("found {found}, needed {}{base}", missing(&of_gear));
    };
    let gear = Gear { module_mm, teeth, pressure_angle_deg, helix_angle_deg };
    Ok((Some(gear), gear.helicoid(request.flank).map_err(by_option)?))
}

fn pivot(request: &Request) -> Result<(f64, Option<[f64; 2]>)> {
    match (request.pivot_mm, request.edge_finder_mm, request.edge_finder_radius_mm) {
        (Some(pivot), None, None) => Ok((pivot, None)),
        (None, Some(travel), Some(radius)) => {
            Ok((pivot_length(travel, radius).map_err(by_option)?, Some([travel, radius])))
        }
        (Some(_), _, _) => bail!(
            "found both --pivot-mm and an edge finder, needed either --pivot-mm or --edge-finder-mm with \
             --edge-finder-radius-mm"
        ),
        (None, None, None) => {
            bail!("found no pivot length, needed --pivot-mm, or --edge-finder-mm and --edge-finder-radius-mm")
        }
        (None, Some(_), None) => bail!("found --edge-finder-mm alone, needed --edge-finder-radius-mm with it"),
        (None, None, Some(_)) => bail!("found --edge-finder-radius-mm alone, needed --edge-finder-mm with it"),
    }
}
