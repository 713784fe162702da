//! The G-code of a grid: successive passes, back and forth.

use super::job::{Job, named};
use super::request::Passes;
use anyhow::Result;
use std::fmt::Write;
use trueaxis_metrology::helicoid::{Branch, Placement};
use trueaxis_tables::text::counted;

impl Job {
    /// The program in LinuxCNC's dialect: straight moves of all five axes in machine positions.
    ///
    /// Every grid point is the end of one G1. Before the first and after the last, the tool is retracted along its axis. A and
    /// C turn only with the pivot so high that the tool, at any angle, stays above the whole grid.
    ///
    /// # Errors
    /// u or θ beyond the flank, by the command-line option.
    pub fn program(&self) -> Result<String> {
        write(self).map_err(named)
    }
}

fn write(job: &Job) -> Result<String> {
    let passes = job.passes;
    let clearance_mm = job.clearance_mm;
    let (u, theta): (Vec<f64>, Vec<f64>) = (job.u.values().collect(), job.theta.values().collect());
    let (rows, columns) = if passes == Passes::Theta { (&u, &theta) } else { (&theta, &u) };
    let mut text = header(job)?;
    let mut before: Option<Pose> = None;
    for (index, row) in rows.iter().enumerate() {
        let name = if passes == Passes::Theta { "u" } else { "theta" };
        let mut pass = format!("(pass {} of {}, {name} {row} rad)\n", index + 1, rows.len());
        for step in 0..columns.len() {
            let column = columns[if index % 2 == 0 { step } else { columns.len() - 1 - step }];
            let [u, theta] = if passes == Passes::Theta { [*row, column] } else { [column, *row] };
            let pose = Pose::new(job, u, theta)?;
            let feed = if before.is_none() {
                text.push_str(&approach(job, &pose, clearance_mm)?);
                format!(" F{}", job.feed_mm_per_min)
            } else {
                String::new()
            };
            writeln!(pass, "G1 {}{feed}", words(&pose.axes))?;
            before = Some(pose);
        }
        text.push_str(&pass);
    }
    if let Some(last) = before {
        text.push_str("(back along the tool axis, and up)\n");
        writeln!(text, "G0 {}", words(&last.back(clearance_mm)))?;
        writeln!(text, "G0 Z{}", number(safe_height(job, clearance_mm)))?;
    }
    text.push_str("M2\n");
    Ok(text)
}

/// Axis positions and the direction in which the tool retracts from the surface, in machine coordinates.
#[derive(Clone, Copy)]
struct Pose {
    axes: Placement,
    spindle: [f64; 3],
}

impl Pose {
    fn new(job: &Job, u: f64, theta: f64) -> Result<Pose> {
        let axes = job.machine.place(&job.surface, u, theta, job.branch)?;
        let (sin, cos) = job.surface.tilt().sin_cos();
        let lean = if job.branch == Branch::First { -sin } else { sin };
        Ok(Pose { axes, spindle: [0.0, lean, cos] })
    }

    fn back(&self, distance: f64) -> Placement {
        let [x, y, z] = self.axes.linear_mm;
        let [i, j, k] = self.spindle;
        Placement { linear_mm: [x + distance * i, y + distance * j, z + distance * k], ..self.axes }
    }
}

/// Z at which the tool, at any A, is above every point of the grid by the clearance.
fn safe_height(job: &Job, clearance: f64) -> f64 {
    let p = job.surface.lead_parameter();
    let top = (p * job.theta.start).max(p * job.theta.stop) + job.settings.work_offset_mm[2];
    let [_, _, rest] = job.settings.form.spindle();
    let pivot_height = top + job.settings.pivot_mm + clearance;
    pivot_height - job.settings.pivot_mm * rest
}

fn approach(job: &Job, first: &Pose, clearance: f64) -> Result<String> {
    let back = first.back(clearance);
    let safe = number(safe_height(job, clearance));
    let [x, y, z] = back.linear_mm.map(number);
    let mut text = String::from("(up, turn, over the first point, down to the clearance along the tool axis)\n");
    writeln!(text, "G0 Z{safe}")?;
    writeln!(text, "G0 A{} C{}", number(back.a_deg), number(back.c_deg))?;
    writeln!(text, "G0 X{x} Y{y}")?;
    writeln!(text, "G0 Z{z}")?;
    Ok(text)
}

fn header(job: &Job) -> Result<String> {
    let mut text = String::from("(trueaxis helicoid: tool along the outward normal of an involute helicoid)\n");
    if let Some((gear, _)) = &job.gear {
        writeln!(
            text,
            "(gear: normal module {} mm, {} teeth, normal pressure angle {} deg, helix angle {} deg)",
            gear.module_mm, gear.teeth, gear.pressure_angle_deg, gear.helix_angle_deg
        )?;
    }
    writeln!(
        text,
        "(flank: base radius {} mm, lead parameter {} mm/rad, {})",
        job.surface.base_radius(),
        job.surface.lead_parameter(),
        job.flank_name()
    )?;
    writeln!(
        text,
        "(machine: table C about z, head A about x, {}, pivot length {} mm, branch {})",
        job.form_name(),
        job.settings.pivot_mm,
        job.branch_number()
    )?;
    let [x, y, z] = job.settings.work_offset_mm;
    writeln!(
        text,
        "(directions: A {}, C {}, work offset on the table X {x} Y {y} Z {z} mm)",
        job.settings.direction_a, job.settings.direction_c
    )?;
    for (name, range) in [("u", job.u), ("theta", job.theta)] {
        writeln!(text, "({name}: {} to {} rad, {})", range.start, range.stop, counted(range.count, "value"))?;
    }
    let along = if job.passes == Passes::Theta { "theta" } else { "u" };
    writeln!(text, "(passes along {along}, back and forth, mm and degrees, machine positions, no tool length offset)")?;
    text.push_str("G21 G90 G94\nG17 G40 G49 G80\n");
    Ok(text)
}

fn words(axes: &Placement) -> String {
    let [x, y, z] = axes.linear_mm.map(number);
    format!("X{x} Y{y} Z{z} A{} C{}", number(axes.a_deg), number(axes.c_deg))
}

/// Nine decimals without trailing zeros: a thousandth of a nanometre, below what any control resolves.
fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
