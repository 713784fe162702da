//! The inputs of `trueaxis helicoid`, checked, and its result.

use super::grid::Range;
use anyhow::Result;
use serde::Serialize;
use trueaxis_metrology::helicoid::{Branch, Flank, Form, Gear, GearData, HeadTable, Helicoid, MachineSettings};

/// The checked request.
pub(crate) struct Job {
    /// The gear and what follows from it, where the surface was given so.
    pub(crate) gear: Option<(Gear, GearData)>,
    pub(crate) surface: Helicoid,
    pub(crate) settings: MachineSettings,
    pub(crate) machine: HeadTable,
    /// Reading and ball radius of the edge finder that gave the pivot length.
    pub(crate) edge_finder_mm: Option<[f64; 2]>,
    pub(crate) branch: Branch,
    pub(crate) u: Range,
    pub(crate) theta: Range,
}

impl Job {
    pub(crate) fn form_name(&self) -> &'static str {
        if self.settings.form == Form::Vertical { "vertical" } else { "horizontal" }
    }

    pub(crate) fn flank_name(&self) -> &'static str {
        if self.surface.flank() == Flank::Right { "right flank" } else { "left flank" }
    }

    pub(crate) fn branch_number(&self) -> u8 {
        if self.branch == Branch::First { 1 } else { 2 }
    }

    /// The grid, u the slow parameter. C is proportional to φ = u + θ and never jumps along a line of it.
    pub(super) fn points(&self) -> Result<Vec<Point>> {
        let mut points: Vec<Point> = Vec::with_capacity(self.u.count * self.theta.count);
        for u_rad in self.u.values() {
            for theta_rad in self.theta.values() {
                let axes = self.machine.place(&self.surface, u_rad, theta_rad, self.branch)?;
                // Adding 0 turns a −0 into 0.
                let [x_mm, y_mm, z_mm] = axes.linear_mm.map(|value| value + 0.0);
                points.push(Point {
                    u_rad,
                    theta_rad,
                    x_mm,
                    y_mm,
                    z_mm,
                    a_deg: axes.a_deg + 0.0,
                    c_deg: axes.c_deg + 0.0,
                });
            }
        }
        Ok(points)
    }
}

/// One row of the result.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Point {
    pub(crate) u_rad: f64,
    pub(crate) theta_rad: f64,
    pub(crate) x_mm: f64,
    pub(crate) y_mm: f64,
    pub(crate) z_mm: f64,
    pub(crate) a_deg: f64,
    pub(crate) c_deg: f64,
}

/// The result as one document; the page carries the same.
#[derive(Serialize)]
pub(crate) struct Document {
    pub(crate) inputs: Inputs,
    pub(crate) surface: Surface,
    /// Null where the base cylinder was given.
    pub(crate) gear: Option<DerivedGear>,
    pub(crate) points: Vec<Point>,
}

#[derive(Serialize)]
pub(crate) struct Inputs {
    form: &'static str,
    flank: &'static str,
    branch: u8,
    pivot_mm: f64,
    edge_finder_mm: Option<f64>,
    edge_finder_radius_mm: Option<f64>,
    direction_a: i8,
    direction_c: i8,
    work_offset_mm: [f64; 3],
    u_rad: Range,
    theta_rad: Range,
    module_mm: Option<f64>,
    teeth: Option<u32>,
    pressure_angle_deg: Option<f64>,
    helix_angle_deg: Option<f64>,
}

#[derive(Serialize)]
pub(crate) struct Surface {
    base_radius_mm: f64,
    lead_parameter_mm_per_rad: f64,
    lead_mm: f64,
    /// Angle γ between the normal and the gear's axis.
    tilt_deg: f64,
}

#[derive(Serialize)]
pub(crate) struct DerivedGear {
    transverse_module_mm: f64,
    transverse_pressure_angle_deg: f64,
    reference_radius_mm: f64,
    base_radius_mm: f64,
    lead_parameter_mm_per_rad: f64,
    lead_mm: f64,
    base_helix_angle_deg: f64,
    reference_roll_angle_rad: f64,
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

impl Document {
    pub(super) fn new(job: &Job, points: Vec<Point>) -> Document {
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
        Document { inputs, surface, gear: gear.map(|(_, data)| data.into()), points }
    }
}
