//! The result as a document and as a table.

use super::grid::Range;
use super::job::{Job, five};
use anyhow::Result;
use serde::Serialize;
use std::fmt::Write;
use trueaxis_metrology::helicoid::{Flank, GearData};

/// One row of the result.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// Roll angle u, rad.
    pub u_rad: f64,
    /// Angle θ, rad.
    pub theta_rad: f64,
    /// X, mm.
    pub x_mm: f64,
    /// Y, mm.
    pub y_mm: f64,
    /// Z, mm.
    pub z_mm: f64,
    /// A, degrees.
    pub a_deg: f64,
    /// C, degrees; continuous over full turns.
    pub c_deg: f64,
}

impl Job {
    /// Points of the grid, with u varying slowest. C is proportional to φ = u + θ and never jumps along a grid line.
    ///
    /// # Errors
    /// u or θ beyond the flank, by the command-line option.
    pub fn points(&self) -> Result<Vec<Point>> {
        let mut points: Vec<Point> = Vec::with_capacity(self.u.count * self.theta.count);
        for u_rad in self.u.values() {
            for theta_rad in self.theta.values() {
                let [x_mm, y_mm, z_mm, a_deg, c_deg] = five(&self.place(u_rad, theta_rad, self.branch)?);
                points.push(Point { u_rad, theta_rad, x_mm, y_mm, z_mm, a_deg, c_deg });
            }
        }
        Ok(points)
    }
}

/// The result as one document.
#[derive(Clone, Debug, Serialize)]
pub struct HelicoidDocument {
    /// The request.
    pub inputs: Inputs,
    /// The flank.
    pub surface: Surface,
    /// Null if the request states the base cylinder.
    pub gear: Option<DerivedGear>,
    /// Points of the grid, with u varying slowest.
    pub points: Vec<Point>,
}

/// The request, defaults included; omitted values are null.
#[derive(Clone, Debug, Serialize)]
pub struct Inputs {
    pub(super) form: &'static str,
    pub(super) flank: &'static str,
    pub(super) branch: u8,
    pub(super) pivot_mm: f64,
    pub(super) edge_finder_mm: Option<f64>,
    pub(super) edge_finder_radius_mm: Option<f64>,
    pub(super) direction_a: i8,
    pub(super) direction_c: i8,
    pub(super) work_offset_mm: [f64; 3],
    pub(super) u_rad: Range,
    pub(super) theta_rad: Range,
    pub(super) module_mm: Option<f64>,
    pub(super) teeth: Option<u32>,
    pub(super) pressure_angle_deg: Option<f64>,
    pub(super) helix_angle_deg: Option<f64>,
}

/// The flank by its base cylinder and lead.
#[derive(Clone, Debug, Serialize)]
pub struct Surface {
    pub(super) base_radius_mm: f64,
    pub(super) lead_parameter_mm_per_rad: f64,
    pub(super) lead_mm: f64,
    /// Angle γ between the normal and the gear's axis.
    pub(super) tilt_deg: f64,
}

/// Values derived from a gear's data.
#[derive(Clone, Debug, Serialize)]
pub struct DerivedGear {
    pub(super) transverse_module_mm: f64,
    pub(super) transverse_pressure_angle_deg: f64,
    pub(super) reference_radius_mm: f64,
    pub(super) base_radius_mm: f64,
    pub(super) lead_parameter_mm_per_rad: f64,
    pub(super) lead_mm: f64,
    pub(super) base_helix_angle_deg: f64,
    pub(super) reference_roll_angle_rad: f64,
}

impl From<&GearData> for DerivedGear {
    fn from(data: &GearData) -> Self {
        DerivedGear {
            transverse_module_mm: data.transverse_module_mm,
            transverse_pressure_angle_deg: data.transverse_pressure_angle_deg,
            reference_radius_mm: data.reference_radius_mm,
            base_radius_mm: data.base_radius_mm,
            lead_parameter_mm_per_rad: data.lead_parameter_mm_per_rad,
            lead_mm: data.lead_mm,
            base_helix_angle_deg: data.base_helix_angle_deg,
            reference_roll_angle_rad: data.reference_roll_angle_rad,
        }
    }
}

impl HelicoidDocument {
    /// The document of a request and the points computed for it; without points for a window that requests them one by one.
    pub fn new(job: &Job, points: Vec<Point>) -> HelicoidDocument {
        let gear = job.gear.as_ref();
        let inputs = Inputs {
            form: job.form_name(),
            flank: if job.surface.flank() == Flank::Right { "right" } else { "left" },
            branch: job.branch_number(),
            pivot_mm: job.settings.pivot_mm,
            edge_finder_mm: job.edge_finder_mm.map(|[travel, _]| travel),
            edge_finder_radius_mm: job.edge_finder_mm.map(|[_, radius]| radius),
            direction_a: job.settings.direction_a,
            direction_c: job.settings.direction_c,
            work_offset_mm: job.settings.work_offset_mm,
            u_rad: job.u,
            theta_rad: job.theta,
            module_mm: gear.map(|(gear, _)| gear.module_mm),
            teeth: gear.map(|(gear, _)| gear.teeth),
            pressure_angle_deg: gear.map(|(gear, _)| gear.pressure_angle_deg),
            helix_angle_deg: gear.map(|(gear, _)| gear.helix_angle_deg),
        };
        let surface = Surface {
            base_radius_mm: job.surface.base_radius(),
            lead_parameter_mm_per_rad: job.surface.lead_parameter(),
            lead_mm: std::f64::consts::TAU * job.surface.lead_parameter(),
            tilt_deg: job.surface.tilt().to_degrees(),
        };
        HelicoidDocument { inputs, surface, gear: gear.map(|(_, data)| data.into()), points }
    }
}

/// The table of the points, as the command line prints it.
pub fn csv(points: &[Point]) -> String {
    let mut text = String::from("u_rad,theta_rad,x_mm,y_mm,z_mm,a_deg,c_deg\n");
    for Point { u_rad, theta_rad, x_mm, y_mm, z_mm, a_deg, c_deg } in points {
        // Writing into a string never fails.
        let _ = writeln!(text, "{u_rad},{theta_rad},{x_mm},{y_mm},{z_mm},{a_deg},{c_deg}");
    }
    text
}
