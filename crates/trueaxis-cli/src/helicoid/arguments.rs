//! Arguments of `trueaxis helicoid`, and those that do not go together.

use super::grid::Range;
use super::job::Job;
use crate::numbers::{number, sense, triple};
use anyhow::{Error, Result, anyhow, bail};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis_metrology::error::{InputError, Quantity};
use trueaxis_metrology::helicoid::{Branch, Flank, Form, Gear, HeadTable, Helicoid, MachineSettings, pivot_length};

pub(crate) const HELP: &str = "\
The surface, with φ = u + θ (gear's axis z, p positive for a right-hand helix):
  F = [r_b (cos φ + u sin φ), r_b (sin φ − u cos φ), p θ],  n = [p sin φ, −p cos φ, r_b]/√(p² + r_b²)
From a gear: r = m_n z/(2 cos β), tan α_t = tan α_n/cos β, r_b = r cos α_t, p = r/tan β.
Right flank: u >= 0, the right side of a tooth seen from +z with its tip up; left flank: u <= 0.
The tool comes from +z: it reaches the right flank of a right-hand helix (p > 0) and the left flank of a
left-hand one (p < 0); the others face away from it and are refused.

The machine: table C turns the workpiece about z, head A the tool about x. γ = atan2(p, r_b):
  branch 1: C = −φ,       A = γ (vertical) or 90° + γ (horizontal)
  branch 2: C = 180° − φ, A = −γ (vertical) or 90° − γ (horizontal)
  [X, Y, Z] = R_z(C) (F + w) + L (R_x(A) t0 − t0),  t0 = +z (vertical) or +y (horizontal)

OUT.csv: u_rad,theta_rad,x_mm,y_mm,z_mm,a_deg,c_deg; u is the slow parameter; C counts on over full turns. A feed
of G94 counts along X Y Z; where only A and C turn it is degrees a minute.

Example: trueaxis helicoid --module-mm 3 --teeth 24 --pressure-angle-deg 20 --helix-angle-deg 15 \\
           --u-rad 0.1:0.6:6 --theta-rad 0:0.2:9 --form vertical --pivot-mm 150 --gcode flank.ngc -o flank.csv";

#[derive(Args)]
pub(crate) struct Arguments {
    /// Radius r_b of the base cylinder; with --lead-parameter-mm-per-rad, in place of a gear.
    #[arg(long, value_name = "RB", value_parser = number, allow_hyphen_values = true)]
    base_radius_mm: Option<f64>,
    /// Lead parameter p, lead/2π; positive for a right-hand helix.
    #[arg(long, value_name = "P", value_parser = number, allow_hyphen_values = true)]
    lead_parameter_mm_per_rad: Option<f64>,
    /// Normal module m_n of a gear.
    #[arg(long, value_name = "MN", value_parser = number, allow_hyphen_values = true)]
    module_mm: Option<f64>,
    /// Number of teeth.
    #[arg(long, value_name = "Z", value_parser = teeth, allow_hyphen_values = true)]
    teeth: Option<u32>,
    /// Normal pressure angle α_n.
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true)]
    pressure_angle_deg: Option<f64>,
    /// Helix angle β at the reference cylinder, positive for a right-hand helix; not 0.
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true)]
    helix_angle_deg: Option<f64>,
    /// Roll angles u of the involute; 0 is on the base cylinder.
    #[arg(long, value_name = "START:STOP:COUNT", value_parser = Range::parse, allow_hyphen_values = true)]
    u_rad: Range,
    /// Angles θ along the helix.
    #[arg(long, value_name = "START:STOP:COUNT", value_parser = Range::parse, allow_hyphen_values = true)]
    theta_rad: Range,
    /// Head at A = 0: spindle along +y or along +z.
    #[arg(long, value_enum, default_value_t = FormName::Horizontal)]
    form: FormName,
    /// Pivot length L, tool tip to A axis.
    #[arg(long, value_name = "L", value_parser = number, allow_hyphen_values = true)]
    pivot_mm: Option<f64>,
    /// Travel a of an edge finder, in place of --pivot-mm: L = a + r.
    #[arg(long, value_name = "A", value_parser = number, allow_hyphen_values = true)]
    edge_finder_mm: Option<f64>,
    /// Radius r of the edge finder's ball.
    #[arg(long, value_name = "R", value_parser = number, allow_hyphen_values = true)]
    edge_finder_radius_mm: Option<f64>,
    /// Which of the two stands of the axes.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    branch: u8,
    /// Side of the tooth, seen from +z with its tip up.
    #[arg(long, value_enum, default_value_t = FlankName::Right)]
    flank: FlankName,
    /// Position of the gear's origin on the table.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, default_value = "0,0,0", allow_hyphen_values = true)]
    work_offset_mm: [f64; 3],
    /// Sense of the A axis; 1: right-handed turn of the tool about +x.
    #[arg(long, value_name = "1|-1", value_parser = sense, default_value = "1", allow_hyphen_values = true)]
    direction_a: i8,
    /// Sense of the C axis; 1: right-handed turn of the workpiece about +z.
    #[arg(long, value_name = "1|-1", value_parser = sense, default_value = "1", allow_hyphen_values = true)]
    direction_c: i8,
    /// Write a program in LinuxCNC's dialect.
    #[arg(long, value_name = "FILE")]
    pub(super) gcode: Option<PathBuf>,
    /// Feed of the program.
    #[arg(long, value_name = "F", value_parser = number, default_value = "500", allow_hyphen_values = true)]
    feed_mm_per_min: f64,
    /// Distance of the tool from the flank, and above it, before and after the program's passes.
    #[arg(long, value_name = "D", value_parser = number, default_value = "50", allow_hyphen_values = true)]
    clearance_mm: f64,
    /// Parameter along which the program's passes run.
    #[arg(long, value_enum, default_value_t = Passes::Theta)]
    pub(super) passes: Passes,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    pub(super) output: Option<PathBuf>,
    /// Print one JSON document: inputs, gear data, points.
    #[arg(long)]
    pub(super) json: bool,
    /// Write an interactive page: a file that ends in .html, or a folder for helicoid.html.
    #[arg(long, value_name = "FILE|DIR")]
    pub(super) report: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormName {
    Vertical,
    Horizontal,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FlankName {
    Right,
    Left,
}

/// Parameter along which the passes run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Passes {
    /// Along the helix.
    Theta,
    /// Along the involute.
    U,
}

fn teeth(text: &str) -> Result<u32, String> {
    text.trim().parse().map_err(|_| format!("found {text}, needed a whole number of teeth, 1 to 10000"))
}

/// The same error with the name of the option.
pub(super) fn named(error: Error) -> Error {
    match error.downcast_ref::<InputError>() {
        Some(error) => by_option(*error),
        None => error,
    }
}

fn by_option(error: InputError) -> Error {
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

impl Arguments {
    pub(super) fn job(&self) -> Result<Job> {
        let flank = if self.flank == FlankName::Right { Flank::Right } else { Flank::Left };
        let (gear, surface) = self.surface(flank)?;
        let (pivot_mm, edge_finder_mm) = self.pivot()?;
        let settings = MachineSettings {
            form: if self.form == FormName::Vertical { Form::Vertical } else { Form::Horizontal },
            pivot_mm,
            direction_a: self.direction_a,
            direction_c: self.direction_c,
            work_offset_mm: self.work_offset_mm,
        };
        let machine = HeadTable::new(&settings).map_err(by_option)?;
        let branch = if self.branch == 1 { Branch::First } else { Branch::Second };
        let gear = gear.map(|gear| gear.data().map(|data| (gear, data))).transpose().map_err(by_option)?;
        Ok(Job { gear, surface, settings, machine, edge_finder_mm, branch, u: self.u_rad, theta: self.theta_rad })
    }

    fn surface(&self, flank: Flank) -> Result<(Option<Gear>, Helicoid)> {
        let of_base = [
            ("--base-radius-mm", self.base_radius_mm.is_some()),
            ("--lead-parameter-mm-per-rad", self.lead_parameter_mm_per_rad.is_some()),
        ];
        let of_gear = [
            ("--module-mm", self.module_mm.is_some()),
            ("--teeth", self.teeth.is_some()),
            ("--pressure-angle-deg", self.pressure_angle_deg.is_some()),
            ("--helix-angle-deg", self.helix_angle_deg.is_some()),
        ];
        let given = |of: &[(&'static str, bool)]| of.iter().find(|(_, given)| *given).map(|(name, _)| *name);
        if let (Some(base), Some(gear)) = (given(&of_base), given(&of_gear)) {
            bail!("found both {base} and {gear}, needed either base radius and lead parameter or a gear");
        }
        let missing = |of: &[(&'static str, bool)]| {
            of.iter().filter(|(_, given)| !given).map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
        };
        if let Some(given) = given(&of_base) {
            let (Some(base_radius), Some(lead_parameter)) = (self.base_radius_mm, self.lead_parameter_mm_per_rad)
            else {
                bail!("found {given} alone, needed {} with it", missing(&of_base));
            };
            return Ok((None, Helicoid::new(base_radius, lead_parameter, flank).map_err(by_option)?));
        }
        let (Some(module_mm), Some(teeth), Some(pressure_angle_deg), Some(helix_angle_deg)) =
            (self.module_mm, self.teeth, self.pressure_angle_deg, self.helix_angle_deg)
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
        Ok((Some(gear), gear.helicoid(flank).map_err(by_option)?))
    }

    fn pivot(&self) -> Result<(f64, Option<[f64; 2]>)> {
        match (self.pivot_mm, self.edge_finder_mm, self.edge_finder_radius_mm) {
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

    pub(super) fn feed(&self) -> Result<f64> {
        if !(self.feed_mm_per_min > 0.0 && self.feed_mm_per_min <= 1e6) {
            bail!("--feed-mm-per-min: found {}, needed a feed above 0, at most 1e6 mm/min", self.feed_mm_per_min);
        }
        Ok(self.feed_mm_per_min)
    }

    pub(super) fn clearance(&self) -> Result<f64> {
        if !(0.0..=1e6).contains(&self.clearance_mm) {
            bail!("--clearance-mm: found {}, needed a distance from 0 to 1e6 mm", self.clearance_mm);
        }
        Ok(self.clearance_mm)
    }
}
