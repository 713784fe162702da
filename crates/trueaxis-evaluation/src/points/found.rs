//! From points to errors, and from errors to a machine.

use super::Points;
use crate::response::{Unit, response, tip_errors, without_errors};
use anyhow::{Result, anyhow, bail};
use trueaxis::Axis;
use trueaxis::machine::{AXES, ErrorModel, Row};
use trueaxis_metrology::volumetric::{Basis, COMPONENTS, LEAST_LEVER_MM, Observation, VolumetricFit, fit};
use trueaxis_tables::limits::raise;
use trueaxis_tables::{Machine, Table};

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Number of nodes of an axis whose points are not on levels.
const NODES: usize = 11;
/// Maximum number of levels that become nodes.
const MOST_LEVELS: usize = 41;
/// Interval of the held-out points: one in this many.
const HELD_OUT: usize = 10;
/// Minimum number of points for holding any out.
const LEAST_WITH_HELD_OUT: usize = 60;

/// How to fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Nodes of X, Y, Z, evenly spaced over the points; `None`: the levels of the points, or else 11.
    pub nodes: Option<[usize; 3]>,
    /// Errors to leave at zero, such as `EBX`.
    pub without: Vec<String>,
}

/// Numbers of nodes of X, Y, Z.
///
/// # Errors
/// Anything but three numbers of 2 to 101; the error states the numbers found and those needed.
pub fn nodes(counts: &[usize]) -> Result<[usize; 3], String> {
    match *counts {
        [x, y, z] if [x, y, z].iter().all(|count| (2..=101).contains(count)) => Ok([x, y, z]),
        _ => Err(format!("found {counts:?}, needed three numbers of 2 to 101")),
    }
}

/// Result of [`identify`].
#[derive(Clone, Debug)]
pub struct PointsFit {
    /// The errors.
    pub errors: VolumetricFit,
    /// Nodes, reference and the errors that the points determine.
    pub basis: Basis,
    /// Residual of every point with the errors in the machine, by its own model, mm; without the instrument's placement and
    /// the reflectors' offsets.
    pub left_mm: Vec<[f64; 3]>,
    /// Residuals of the held-out points, with their indices, in a fit without them; empty with few points.
    pub held_out_mm: Vec<(usize, [f64; 3])>,
    /// Deviation of every point without the placement, mm.
    pub deviations_mm: Vec<[f64; 3]>,
    /// Angular errors that the points do not determine, left at zero.
    pub unseen: Vec<String>,
    /// The machine with the errors, model volumetric.
    pub machine: Machine,
    /// Correction limits that the machine needs, a sentence each.
    pub limits: Vec<String>,
}

/// The 21 errors of the linear axes of `machine`, ignoring its own tables and squarenesses; rotary axes at zero.
///
/// Cost: two fits, see [`fit`].
///
/// # Errors
/// A machine that lacks a linear axis, errors in `without` that it does not have, points that do not determine the rest.
pub fn identify(points: &Points, machine: &Machine, options: &Options) -> Result<PointsFit> {
    for axis in LINEAR {
        if machine.settings.axis(axis).is_none() {
            bail!("{}: found no axis {}, needed X, Y and Z", machine.settings.name, axis.letter());
        }
    }
    let mut bare = without_errors(machine);
    bare.settings.compensation.orientation = false;
    let mut points = points.clone();
    take_out_periods(&mut points, machine);
    let points = &points;
    let observations = observations(points, &bare)?;
    let (basis, unseen) = basis(points, &bare, options)?;
    let errors = fit(&observations, &basis).map_err(|refused| anyhow!("{refused}"))?;
    let out = |index: usize| points.points.len() >= LEAST_WITH_HELD_OUT && index % HELD_OUT == HELD_OUT - 1;
    let mut held_out_mm = Vec::new();
    if points.points.len() >= LEAST_WITH_HELD_OUT {
        let kept: Vec<Observation> =
            observations.iter().enumerate().filter(|(i, _)| !out(*i)).map(|(_, of)| of.clone()).collect();
        // Without the held-out points a node may lack points; the result then has no held-out residuals.
        if let Ok(part) = fit(&kept, &basis) {
            let left = left(points, &filled(&bare, &basis, &part), &part)?;
            held_out_mm = left.into_iter().enumerate().filter(|(i, _)| out(*i)).collect();
        }
    }
    let left_mm = left(points, &filled(&bare, &basis, &errors), &errors)?;
    let deviations_mm = points.points.iter().map(|point| placed(point, &errors)).collect();
    let mut written = filled(machine, &basis, &errors);
    let limits = raise(&mut written);
    Ok(PointsFit { errors, basis, left_mm, held_out_mm, deviations_mm, unseen, machine: written, limits })
}

pub(super) fn place(of: [f64; 3]) -> [f64; AXES] {
    let mut place = [0.0; AXES];
    place[..3].copy_from_slice(&of);
    place
}

/// The bare machine with a reflector as its tool.
pub(super) fn with_tool(bare: &Machine, tool_mm: Option<[f64; 3]>) -> Machine {
    let mut machine = bare.clone();
    machine.settings.tool_mm = tool_mm.unwrap_or(machine.settings.tool_mm);
    machine
}

/// Takes the periods of the linear axes, which stay as the machine states them, out of the deviations in positive travel: points
/// far apart would show them as a slow error.
fn take_out_periods(points: &mut Points, machine: &Machine) {
    for point in &mut points.points {
        for (axis, of) in LINEAR.into_iter().enumerate() {
            let position = point.command_mm[axis];
            let within = machine.settings.periods_of(of).map(|period| period.error_and_slope(position, false)[0]);
            point.deviation_mm[axis] -= within.sum::<f64>();
        }
    }
}

fn observations(points: &Points, bare: &Machine) -> Result<Vec<Observation>> {
    let mut observations: Vec<Observation> = points
        .points
        .iter()
        .map(|point| Observation {
            position_mm: point.command_mm,
            deviation_mm: point.deviation_mm,
            sigma_mm: point.sigma_mm,
            tool: point.tool,
            responses: [[[0.0; 3]; 6]; 3],
            squareness: [[0.0; 3]; 3],
        })
        .collect();
    for (tool, &offset) in points.tools_mm.iter().enumerate() {
        let machine = with_tool(bare, offset);
        let own: Vec<usize> = (0..observations.len()).filter(|&i| observations[i].tool == tool).collect();
        let places: Vec<_> = own.iter().map(|&i| place(observations[i].position_mm)).collect();
        for (axis, of) in LINEAR.into_iter().enumerate() {
            for component in 0..6 {
                let found = response(&machine, Unit::Linear(of, component), &places)?;
                for (&i, value) in own.iter().zip(found) {
                    observations[i].responses[axis][component] = value;
                }
            }
        }
        for (k, unit) in [Unit::A0z, Unit::B0z, Unit::C0y].into_iter().enumerate() {
            for (&i, value) in own.iter().zip(response(&machine, unit, &places)?) {
                observations[i].squareness[k] = value;
            }
        }
    }
    Ok(observations)
}

pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

fn basis(points: &Points, bare: &Machine, options: &Options) -> Result<(Basis, Vec<String>)> {
    let along = |axis: usize| points.points.iter().map(move |point| point.command_mm[axis]);
    let ends: [[f64; 2]; 3] = [0, 1, 2].map(|axis| range(along(axis)));
    for (axis, [low, high]) in ends.into_iter().enumerate() {
        if high - low < 1e-3 {
            bail!(
                "column {}: found all points at {low}, needed points along every axis; points in a plane: trueaxis evaluate points",
                super::COLUMNS[axis].name
            );
        }
    }
    let nodes_mm = [0, 1, 2].map(|axis| {
        let [low, high] = ends[axis];
        let mut levels: Vec<f64> = along(axis).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|next, kept| *next - *kept < 1e-6 * (high - low));
        match options.nodes {
            None if (2..=MOST_LEVELS).contains(&levels.len()) => levels,
            of => {
                let count = of.map_or(NODES, |counts| counts[axis]).max(2);
                (0..count).map(|k| low + (high - low) * k as f64 / (count - 1) as f64).collect()
            }
        }
    });
    let mut without = options.without.clone();
    let (mut seen, mut unseen) = ([[true; 6]; 3], Vec::new());
    for (axis, of) in LINEAR.into_iter().enumerate() {
        for component in 3..6 {
            let name = format!("E{}{}", COMPONENTS[component], of.letter());
            let asked = without.iter().position(|asked| asked.eq_ignore_ascii_case(&name)).map(|at| without.remove(at));
            if asked.is_some() {
                seen[axis][component] = false;
            } else if spread(points, bare, of, component, ends)? < LEAST_LEVER_MM {
                seen[axis][component] = false;
                unseen.push(name);
            }
        }
    }
    if let Some(unknown) = without.first() {
        bail!("--without: found {unknown}, needed angular errors of linear axes as EBX");
    }
    let reference_mm = ends.map(|[low, high]| 0.0_f64.clamp(low, high));
    let length_mm = ends.iter().map(|[low, high]| 0.25 * (high - low).powi(2)).sum::<f64>().sqrt();
    Ok((Basis { nodes_mm, reference_mm, seen, tools: points.tools_mm.len(), length_mm }, unseen))
}

/// Variation of the lever of a rotation over the ends of the other axes and the reflectors, its own axis fixed, mm.
fn spread(points: &Points, bare: &Machine, axis: Axis, component: usize, ends: [[f64; 2]; 3]) -> Result<f64> {
    let own = axis.index();
    let corners: Vec<[f64; AXES]> = (0..8)
        .map(|corner| {
            let at =
                [0, 1, 2].map(|k| if k == own { 0.5 * (ends[k][0] + ends[k][1]) } else { ends[k][corner >> k & 1] });
            place(at)
        })
        .collect();
    let mut levers = Vec::new();
    for &tool in &points.tools_mm {
        levers.extend(response(&with_tool(bare, tool), Unit::Linear(axis, component), &corners)?);
    }
    let widths = (0..3).map(|c| {
        let [low, high] = range(levers.iter().map(|lever| lever[c]));
        high - low
    });
    Ok(widths.fold(0.0, f64::max))
}

/// The deviation of a point without the instrument's placement and its reflector's offset, mm.
fn placed(point: &super::Point, errors: &VolumetricFit) -> [f64; 3] {
    let [tx, ty, tz, a, b, c] = errors.placement;
    let [x, y, z] = point.command_mm;
    let turned = [b * z - c * y, c * x - a * z, a * y - b * x];
    let offset = point.tool.checked_sub(1).and_then(|tool| errors.offsets_mm.get(tool)).copied().unwrap_or_default();
    let shift = [tx, ty, tz];
    std::array::from_fn(|k| point.deviation_mm[k] - shift[k] - turned[k] - offset[k])
}

/// Residuals of the points with the errors in the machine, by its own model.
fn left(points: &Points, machine: &Machine, errors: &VolumetricFit) -> Result<Vec<[f64; 3]>> {
    let mut left = vec![[0.0; 3]; points.points.len()];
    for (tool, &offset) in points.tools_mm.iter().enumerate() {
        let own: Vec<usize> = (0..left.len()).filter(|&i| points.points[i].tool == tool).collect();
        let places: Vec<_> = own.iter().map(|&i| place(points.points[i].command_mm)).collect();
        let (modelled, _) = tip_errors(&with_tool(machine, offset), &places)?;
        for (&i, model) in own.iter().zip(modelled) {
            let is = placed(&points.points[i], errors);
            left[i] = std::array::from_fn(|c| is[c] - model[c]);
        }
    }
    Ok(left)
}

/// Inverse of the steps in which tables are stored, 1e-7 µm and µrad: short decimals.
const STEPS: f64 = 1e7;

/// A value in whole steps. Scaled to micro and then / 1e3 or 1e6, as a file is read, so that it reads back as the same double;
/// + 0 turns −0 into 0.
pub(super) fn rounded(value: f64, scale: f64) -> f64 {
    (value * scale * STEPS).round() / STEPS / scale + 0.0
}

/// A machine with the errors as its tables of X, Y, Z and its squareness.
fn filled(machine: &Machine, basis: &Basis, errors: &VolumetricFit) -> Machine {
    let mut machine = machine.clone();
    machine.settings.compensation.model = ErrorModel::Volumetric;
    // The points show the whole error: a grid on top would count it twice.
    machine.grids.clear();
    let [a0z, b0z, c0y] = errors.squareness.map(|rad| rounded(rad, 1e6));
    let location = &mut machine.settings.location;
    (location.a0z, location.b0z, location.c0y) = (a0z, b0z, c0y);
    for (axis, of) in LINEAR.into_iter().enumerate() {
        let Some(slot) = machine.settings.axes.iter().position(|own| own.axis == of) else { continue };
        let rows = basis.nodes_mm[axis].iter().enumerate().map(|(node, &position)| {
            let twist = std::array::from_fn(|component| {
                let scale = if component < 3 { 1e3 } else { 1e6 };
                rounded(errors.errors[axis][component][node], scale)
            });
            Row { position, forward: twist, reverse: twist }
        });
        let given = std::array::from_fn(|component| component < 3 || basis.seen[axis][component]);
        machine.tables[slot] = Some(Table { given, bidirectional: false, rows: rows.collect() });
    }
    machine
}
