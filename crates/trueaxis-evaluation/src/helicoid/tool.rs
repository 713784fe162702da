//! The tool at one place of the flank.

use super::apart::{angle, apart};
use super::job::{Job, five, number};
use super::machine::{six, twin};
use super::travel::{Beyond, Limits};
use anyhow::Result;
use serde::Serialize;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::CompensationSettings;
use trueaxis_metrology::helicoid::{Branch, Form};

/// The tool at (u, θ), on both branches.
#[derive(Clone, Debug, Serialize)]
pub struct Tool {
    /// u, rad.
    pub u_rad: f64,
    /// θ, rad.
    pub theta_rad: f64,
    /// Surface point at which the tip is, in the gear's frame, mm.
    pub point_mm: [f64; 3],
    /// Outward normal along which the tool lies, in the gear's frame.
    pub normal: [f64; 3],
    /// Distance of the point from the gear's axis, mm.
    pub radius_mm: f64,
    /// Branch 1 and branch 2.
    #[serde(rename = "stands")]
    pub poses: [BranchPose; 2],
    /// Distance from the singular pose; equal on both branches and over the whole flank.
    pub singular: Singular,
}

/// Axis positions on one branch.
#[derive(Clone, Debug, Serialize)]
pub struct BranchPose {
    /// 1 or 2.
    pub branch: u8,
    /// X, mm.
    pub x_mm: f64,
    /// Y, mm.
    pub y_mm: f64,
    /// Z, mm.
    pub z_mm: f64,
    /// A, degrees.
    pub a_deg: f64,
    /// C, degrees.
    pub c_deg: f64,
    /// Direction of the A axis in the gear's frame.
    pub a_axis: [f64; 3],
    /// Distance of the tip from the surface point, µm, by the forward transformation of the step's kinematics for a machine of
    /// this chain: independent of the displacement formula.
    pub off_surface_um: f64,
    /// Angle between tool and normal, µrad, found in the same way.
    pub off_normal_urad: f64,
    /// Axes beyond their travel.
    pub beyond: Vec<Beyond>,
}

/// Distance of the tool from the table's axis, on which C is arbitrary.
#[derive(Clone, Debug, Serialize)]
pub struct Singular {
    /// Angle between tool and C axis, degrees.
    pub margin_deg: f64,
    /// A of the singular pose, degrees, at which both branches meet.
    pub a_deg: f64,
    /// Largest change of C per 1 µrad of change in the tool's direction, µrad: 1/sin(margin).
    pub gain: f64,
    /// Margin, degrees, within which the correction of the tool's direction fades, unless a machine sets another.
    pub fade_deg: f64,
    /// Whether the margin is below `fade_deg`.
    pub near: bool,
}

impl Job {
    /// The tool at (u, θ) on both branches.
    ///
    /// # Errors
    /// u or θ beyond the flank; limits with the high end first.
    pub fn tool(&self, u: f64, theta: f64, limits: &Limits) -> Result<Tool> {
        limits.check()?;
        let kinematics = twin(&self.settings)?;
        let first = self.pose(u, theta, Branch::First, limits, &kinematics)?;
        let second = self.pose(u, theta, Branch::Second, limits, &kinematics)?;
        let point_mm = self.surface.point(u, theta);
        let margin_deg = kinematics.singularity_margin_deg(&six(&five(&self.place(u, theta, Branch::First)?)));
        let fade_deg = CompensationSettings::default().fade_deg;
        let quarter = if self.settings.form == Form::Vertical { 0.0 } else { 90.0 };
        Ok(Tool {
            u_rad: u,
            theta_rad: theta,
            point_mm,
            normal: self.surface.normal(u, theta),
            radius_mm: point_mm[0].hypot(point_mm[1]),
            poses: [first, second],
            singular: Singular {
                margin_deg,
                a_deg: f64::from(self.settings.direction_a) * quarter + 0.0,
                gain: 1.0 / margin_deg.to_radians().sin(),
                fade_deg,
                near: margin_deg < fade_deg,
            },
        })
    }

    fn pose(
        &self,
        u: f64,
        theta: f64,
        branch: Branch,
        limits: &Limits,
        machine: &Kinematics<f64>,
    ) -> Result<BranchPose> {
        let positions = five(&self.place(u, theta, branch)?);
        let tool = machine.forward(&six(&positions));
        let (point, normal, offset) =
            (self.surface.point(u, theta), self.surface.normal(u, theta), self.settings.work_offset_mm);
        let tip: [f64; 3] = std::array::from_fn(|i| tool.tip[i] - offset[i]);
        let off_normal = apart(tool.axis.to_array(), normal);
        let [x_mm, y_mm, z_mm, a_deg, c_deg] = positions;
        Ok(BranchPose {
            branch: number(branch),
            x_mm,
            y_mm,
            z_mm,
            a_deg,
            c_deg,
            a_axis: machine.to_workpiece(&six(&positions), trueaxis::glam::DVec3::X).to_array(),
            off_surface_um: 1e3 * apart(tip, point),
            off_normal_urad: 1e6 * angle(off_normal),
            beyond: limits.beyond(&positions),
        })
    }
}
