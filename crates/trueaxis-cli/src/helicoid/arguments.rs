//! Arguments of `trueaxis helicoid`.

use crate::numbers::{number, sense, triple};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis_evaluation::helicoid::{Passes, Range, Request};
use trueaxis_metrology::helicoid::{Branch, Flank, Form};

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis helicoid --module-mm 3 --teeth 24 --pressure-angle-deg 20 \\
      --helix-angle-deg 15 --u-rad 0.2:0.6:2 --theta-rad 0:0.1:2 \\
      --form vertical --pivot-mm 150";

pub(crate) const HELP: &str = "\
The surface, with φ = u + θ (z: the gear's axis; p is positive for a right-hand helix):
  F = [r_b (cos φ + u sin φ), r_b (sin φ − u cos φ), p θ]
  n = [p sin φ, −p cos φ, r_b]/√(p² + r_b²)
From a gear:
  r = m_n z/(2 cos β), tan α_t = tan α_n/cos β, r_b = r cos α_t, p = r/tan β
The right flank has u ≥ 0 and is the right side of a tooth seen from +z with its tip up; the left flank has u ≤ 0. \
The tool comes from +z: it reaches the right flank of a right-hand helix (p > 0) and the left flank of a left-hand \
one (p < 0). The others face away from it and are refused.

The machine: table C turns the workpiece about z, head A the tool about x. With γ = atan2(p, r_b):
  branch 1: C = −φ,       A = γ (vertical) or 90° + γ (horizontal)
  branch 2: C = 180° − φ, A = −γ (vertical) or 90° − γ (horizontal)
  [X, Y, Z] = R_z(C) (F + w) + L (R_x(A) t0 − t0)
  t0 = +z (vertical) or +y (horizontal)

OUT.csv has the columns u_rad,theta_rad,x_mm,y_mm,z_mm,a_deg,c_deg; u is the slow parameter, and C continues over \
full turns. In the program a feed of G94 counts along X Y Z; if only A and C turn, it is in degrees per minute.";

#[derive(Args)]
pub(crate) struct HelicoidArgs {
    /// Radius r_b of the base cylinder; with --lead-parameter-mm-per-rad, in place of a gear.
    #[arg(long, value_name = "RB", value_parser = number, allow_hyphen_values = true, help_heading = "Flank")]
    base_radius_mm: Option<f64>,
    /// Lead parameter p, lead/2π; positive for a right-hand helix.
    #[arg(long, value_name = "P", value_parser = number, allow_hyphen_values = true, help_heading = "Flank")]
    lead_parameter_mm_per_rad: Option<f64>,
    /// Normal module m_n of a gear.
    #[arg(long, value_name = "MN", value_parser = number, allow_hyphen_values = true, help_heading = "Flank")]
    module_mm: Option<f64>,
    /// Number of teeth.
    #[arg(long, value_name = "Z", value_parser = teeth, allow_hyphen_values = true, help_heading = "Flank")]
    teeth: Option<u32>,
    /// Normal pressure angle α_n.
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true, help_heading = "Flank")]
    pressure_angle_deg: Option<f64>,
    /// Helix angle β at the reference cylinder, positive for a right-hand helix; not 0.
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true, help_heading = "Flank")]
    helix_angle_deg: Option<f64>,
    /// Roll angles u of the involute; 0 is on the base cylinder.
    #[arg(
        long,
        value_name = "START:STOP:COUNT",
        value_parser = Range::parse,
        allow_hyphen_values = true,
        help_heading = "Flank"
    )]
    u_rad: Range,
    /// Angles θ along the helix.
    #[arg(
        long,
        value_name = "START:STOP:COUNT",
        value_parser = Range::parse,
        allow_hyphen_values = true,
        help_heading = "Flank"
    )]
    theta_rad: Range,
    /// Head at A = 0: spindle along +y or along +z.
    #[arg(long, value_enum, default_value_t = FormName::Horizontal, help_heading = "Machine")]
    form: FormName,
    /// Pivot length L, tool tip to A axis.
    #[arg(long, value_name = "L", value_parser = number, allow_hyphen_values = true, help_heading = "Machine")]
    pivot_mm: Option<f64>,
    /// Travel a of an edge finder, in place of --pivot-mm: L = a + r.
    #[arg(long, value_name = "A", value_parser = number, allow_hyphen_values = true, help_heading = "Machine")]
    edge_finder_mm: Option<f64>,
    /// Radius r of the edge finder's ball.
    #[arg(long, value_name = "R", value_parser = number, allow_hyphen_values = true, help_heading = "Machine")]
    edge_finder_radius_mm: Option<f64>,
    /// Which of the two solutions for the axes.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2), help_heading = "Machine")]
    branch: u8,
    /// Side of the tooth, seen from +z with its tip up.
    #[arg(long, value_enum, default_value_t = FlankName::Right, help_heading = "Flank")]
    flank: FlankName,
    /// Position of the gear's origin on the table.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = triple,
        default_value = "0,0,0",
        allow_hyphen_values = true,
        help_heading = "Machine"
    )]
    work_offset_mm: [f64; 3],
    /// Sense of the A axis; 1: right-handed turn of the tool about +x.
    #[arg(
        long,
        value_name = "1|-1",
        value_parser = sense,
        default_value = "1",
        allow_hyphen_values = true,
        help_heading = "Machine"
    )]
    direction_a: i8,
    /// Sense of the C axis; 1: right-handed turn of the workpiece about +z.
    #[arg(
        long,
        value_name = "1|-1",
        value_parser = sense,
        default_value = "1",
        allow_hyphen_values = true,
        help_heading = "Machine"
    )]
    direction_c: i8,
    /// Write a program in LinuxCNC's dialect.
    #[arg(long, value_name = "FILE", help_heading = "Program")]
    pub(super) gcode: Option<PathBuf>,
    /// Feed of the program.
    #[arg(
        long,
        value_name = "F",
        value_parser = number,
        default_value_t = Request::FEED_MM_PER_MIN,
        allow_hyphen_values = true,
        help_heading = "Program"
    )]
    feed_mm_per_min: f64,
    /// Distance of the tool from the flank, and above it, before and after the program's passes.
    #[arg(
        long,
        value_name = "D",
        value_parser = number,
        default_value_t = Request::CLEARANCE_MM,
        allow_hyphen_values = true,
        help_heading = "Program"
    )]
    clearance_mm: f64,
    /// Parameter along which the program's passes run.
    #[arg(long, value_enum, default_value_t = PassesName::Theta, help_heading = "Program")]
    passes: PassesName,
    /// Result [default: standard output].
    #[arg(short, long, value_name = "OUT.csv")]
    pub(super) output: Option<PathBuf>,
    /// Print one JSON document: inputs, gear data, points.
    #[arg(long)]
    pub(super) json: bool,
    /// Write a page with figures: a file that ends in .html, or a folder for helicoid.html.
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
enum PassesName {
    /// Along the helix.
    Theta,
    /// Along the involute.
    U,
}

fn teeth(text: &str) -> Result<u32, String> {
    text.trim().parse().map_err(|_| format!("found {text}, needed {}", Request::TEETH))
}

impl HelicoidArgs {
    /// The request as given, not yet checked.
    pub(super) fn request(&self) -> Request {
        Request {
            base_radius_mm: self.base_radius_mm,
            lead_parameter_mm_per_rad: self.lead_parameter_mm_per_rad,
            module_mm: self.module_mm,
            teeth: self.teeth,
            pressure_angle_deg: self.pressure_angle_deg,
            helix_angle_deg: self.helix_angle_deg,
            u_rad: self.u_rad,
            theta_rad: self.theta_rad,
            form: match self.form {
                FormName::Vertical => Form::Vertical,
                FormName::Horizontal => Form::Horizontal,
            },
            pivot_mm: self.pivot_mm,
            edge_finder_mm: self.edge_finder_mm,
            edge_finder_radius_mm: self.edge_finder_radius_mm,
            branch: if self.branch == 1 { Branch::First } else { Branch::Second },
            flank: match self.flank {
                FlankName::Right => Flank::Right,
                FlankName::Left => Flank::Left,
            },
            work_offset_mm: self.work_offset_mm,
            direction_a: self.direction_a,
            direction_c: self.direction_c,
            feed_mm_per_min: self.feed_mm_per_min,
            clearance_mm: self.clearance_mm,
            passes: match self.passes {
                PassesName::Theta => Passes::Theta,
                PassesName::U => Passes::U,
            },
        }
    }
}
