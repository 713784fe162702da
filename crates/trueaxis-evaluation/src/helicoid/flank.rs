//! The tip's error along a line on the flank, before and after a machine's own compensation.

use super::apart::{angle, apart};
use super::job::{Job, by_option, five};
use super::machine::{Fit, fit, six};
use super::request::Passes;
use crate::compensate::{Place, Settings, with_model};
use crate::positions::in_order;
use anyhow::{Result, anyhow};
use serde::Serialize;
use trueaxis::compensation::Direction;
use trueaxis::glam::DVec3;
use trueaxis::kinematics::{Choice, Kinematics, Tool};
use trueaxis::machine::AXES;
use trueaxis_metrology::helicoid::Branch;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Errors of the tool in the gear's frame, actual − ideal, one per point.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Errors {
    /// Distance of the tip from its ideal position, µm.
    pub tip_um: Vec<f64>,
    /// Component along the outward normal, µm: positive leaves material on the flank.
    pub normal_um: Vec<f64>,
    /// Angle between the tool and the normal, µrad.
    pub direction_urad: Vec<f64>,
    /// Largest of each.
    pub largest: [f64; 3],
}

/// The tip's error along a line on the flank.
#[derive(Clone, Debug, Serialize)]
pub struct Flanked {
    /// Whether the displacements are positions of this machine's axes; if not, the machine's inverse transformation gives the
    /// positions for the same tool poses.
    pub fit: Fit,
    /// u or θ, rad.
    pub parameter_rad: Vec<f64>,
    /// Without compensation.
    pub before: Errors,
    /// With the correction of the servo step at standstill, from the machine's own tables and model.
    pub after: Errors,
    /// Letters of the axes that leave their declared travel along the line.
    pub out_of_travel: Vec<char>,
}

/// The tip's error along a line on the flank, with one parameter `along` its range and the other `held`.
///
/// The exact geometry ([`Geometry`]) gives the actual pose at the commands, and at the commands plus the correction that the
/// servo step settles to at standstill. Directions of travel are those of the axes along the line; a stationary axis keeps its
/// direction, positive at first. All at the reference temperature.
///
/// # Errors
/// u or θ beyond the flank; a machine without a transformation or that cannot reach the poses; one that the step refuses.
pub fn flank(job: &Job, machine: &Machine, along: Passes, held: f64, count: usize) -> Result<Flanked> {
    let places = job.line(along, held, count)?;
    let fit = fit(job, &machine.settings);
    let positions = if fit.fits { own(job, &places)? } else { inverse(job, machine, &places)? };
    let travels = travels(&positions);
    let corrections = corrections(machine, &positions, &travels)?;
    let geometry = Geometry::new(machine, 0.0).map_err(|error| anyhow!("{error}"))?;
    let mut flanked = Flanked {
        fit,
        parameter_rad: places.iter().map(|[u, theta]| if along == Passes::Theta { *theta } else { *u }).collect(),
        before: Errors::default(),
        after: Errors::default(),
        out_of_travel: Vec::new(),
    };
    for own in &machine.settings.axes {
        let of = || positions.iter().map(|position| position[own.axis.index()]);
        if of().any(|found| found < own.travel[0] || found > own.travel[1]) {
            flanked.out_of_travel.push(own.axis.letter());
        }
    }
    for (i, [u, theta]) in places.into_iter().enumerate() {
        let normal = job.surface.normal(u, theta);
        let slots = |values: &[f64; AXES]| in_order(machine.settings.axes.iter().map(|own| own.axis), values);
        let reverse = slots(&travels[i].map(|travel| if travel { 1.0 } else { 0.0 }));
        let ideal = geometry.ideal_pose(&slots(&positions[i]));
        let sent: [f64; AXES] = std::array::from_fn(|k| positions[i][k] + corrections[i][k]);
        for (errors, at) in [(&mut flanked.before, &positions[i]), (&mut flanked.after, &sent)] {
            let actual = geometry.actual_pose(&slots(at), &reverse);
            let along_normal: f64 = (0..3).map(|k| (actual.tip_mm[k] - ideal.tip_mm[k]) * normal[k]).sum();
            errors.push([
                1e3 * apart(actual.tip_mm, ideal.tip_mm),
                1e3 * along_normal,
                1e6 * angle(apart(actual.direction, ideal.direction)),
            ]);
        }
    }
    Ok(flanked)
}

impl Errors {
    fn push(&mut self, values: [f64; 3]) {
        for ((list, largest), value) in [&mut self.tip_um, &mut self.normal_um, &mut self.direction_urad]
            .into_iter()
            .zip(&mut self.largest)
            .zip(values)
        {
            list.push(value);
            *largest = largest.max(value.abs());
        }
    }
}

/// The displacements, as positions of X Y Z A B C.
fn own(job: &Job, places: &[[f64; 2]]) -> Result<Vec<[f64; AXES]>> {
    places.iter().map(|[u, theta]| Ok(six(&five(&job.place(*u, *theta, job.branch)?)))).collect()
}

/// Positions of another machine for the same poses, on its branch with the same number.
fn inverse(job: &Job, machine: &Machine, places: &[[f64; 2]]) -> Result<Vec<[f64; AXES]>> {
    let name = machine.settings.name.as_str();
    let kinematics = Kinematics::<f64>::new(&machine.settings).map_err(|error| anyhow!("{name}: {error}"))?;
    let choice = if job.branch == Branch::First { Choice::First } else { Choice::Second };
    let mut near = [0.0; AXES];
    let mut positions = Vec::with_capacity(places.len());
    for &[u, theta] in places {
        job.surface.contains(u, theta).map_err(by_option)?;
        let (point, offset) = (job.surface.point(u, theta), job.settings.work_offset_mm);
        let tip = DVec3::from_array(std::array::from_fn(|i| point[i] + offset[i]));
        let tool = Tool { tip, axis: DVec3::from_array(job.surface.normal(u, theta)) };
        let found = kinematics.solutions(&tool, &near).and_then(|both| both.choose(choice));
        near = found.map_err(|error| anyhow!("{name} at u = {u} rad, theta = {theta} rad: {error}"))?.axes;
        positions.push(near);
    }
    Ok(positions)
}

/// Whether each axis arrives in negative travel, in the order X Y Z A B C.
fn travels(positions: &[[f64; AXES]]) -> Vec<[bool; AXES]> {
    let mut now = [false; AXES];
    // The first point is reached in the same directions as the second.
    let from = |i: usize| if i == 0 { [0, 1] } else { [i - 1, i] };
    (0..positions.len())
        .map(|i| {
            let [before, at] = from(i).map(|i| positions.get(i));
            if let (Some(before), Some(at)) = (before, at) {
                for (now, (before, at)) in now.iter_mut().zip(before.iter().zip(at)) {
                    if (at - before).abs() > RESTING {
                        *now = at < before;
                    }
                }
            }
            now
        })
        .collect()
}

/// An axis that moves by less, mm or degrees, is stationary: rounding.
const RESTING: f64 = 1e-9;

/// Corrections that the step settles to, in the order X Y Z A B C.
fn corrections(machine: &Machine, positions: &[[f64; AXES]], travels: &[[bool; AXES]]) -> Result<Vec<[f64; AXES]>> {
    with_model(machine, &Settings::default(), |model| {
        let places = positions.iter().zip(travels);
        let corrected = places.map(|(position, travel)| {
            Ok(model.correction(&Place { command: *position, directions: travel.map(Direction::of) })?)
        });
        corrected.collect()
    })
}
