//! The worst point of a field, and which table and term cause it.

use super::sample::{Pose, Sampler, size};
use crate::contributions::{Source, shares};
use anyhow::Result;
use serde::Serialize;
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// The point with the largest error of the tip. Errors µm, actual − ideal, machine directions.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Worst {
    /// Commanded X, Y, Z, mm.
    pub at_mm: [f64; 3],
    /// Error of the tip.
    pub error_um: [f64; 3],
    /// Size of the error.
    pub size_um: f64,
    /// Rotation of the tool, µrad.
    pub orientation_urad: [f64; 3],
    /// Correction sent, mm and degrees, in the order X, Y, Z, A, B, C; zero before the correction.
    pub correction: [f64; AXES],
    /// Every table with its terms, and the location errors; largest contribution first.
    pub tables: Vec<Table>,
    /// All terms, largest contribution first.
    pub terms: Vec<Cause>,
    /// The rest that no single term explains: products of errors.
    pub rest_um: [f64; 3],
}

/// Share of a table with its axis' lost motion and growth, or of the location errors.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Table {
    /// Axis by its letter, or `location errors`.
    pub source: String,
    /// Sum of the source's terms, µm.
    pub error_um: [f64; 3],
    /// Component along the whole error, µm: those of all tables and the rest add up to its size.
    pub along_um: f64,
}

/// Share of a term: the error that would vanish if the machine were perfect there, in its geometry and in its tables.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Cause {
    /// Table that contains the term, as [`Table::source`].
    pub table: String,
    /// ISO 230-1 name, such as `EYX`, `C0Y`, `backlash X`.
    pub term: String,
    /// Share, µm.
    pub error_um: [f64; 3],
    /// Component along the whole error, µm.
    pub along_um: f64,
}

/// Component of a share along the whole.
fn along(share: [f64; 3], whole: [f64; 3]) -> f64 {
    let length = size(whole);
    if length == 0.0 { 0.0 } else { (0..3).map(|i| share[i] * whole[i]).sum::<f64>() / length }
}

/// Error of the tip that a machine has at a place, mm.
type ErrorOf<'a> = dyn Fn(&Machine, &[f64; AXES]) -> Result<[f64; 3]> + 'a;

/// The worst point of the uncorrected errors.
pub(super) fn before(sampler: &Sampler<'_>, poses: &[Pose]) -> Result<Worst> {
    let error = |machine: &Machine, at: &[f64; AXES]| Ok(Sampler::of(sampler.asked, machine)?.before(at).0.tip);
    found(sampler, &sampler.asked.machine, poses, [0.0; AXES], &error)
}

/// The worst point after the compensation of `machine`. Removing a term never needs more `passes` of the inverse.
pub(super) fn after(sampler: &Sampler<'_>, machine: &Machine, passes: u8, poses: &[Pose]) -> Result<Worst> {
    let left = |machine: &Machine, at: &[f64; AXES]| {
        Sampler::of(sampler.asked, machine)?.compensated(machine, passes, |sampler, model| {
            sampler.after(model, at, &sampler.geometry.commanded(&sampler.slots(at)))
        })
    };
    let correction = left(machine, &sampler.asked.at(index(poses)))?.correction;
    found(sampler, machine, poses, correction, &|machine, at| Ok(left(machine, at)?.pose.tip))
}

/// Index of the worst point; the first if several are equal.
fn index(poses: &[Pose]) -> usize {
    let sizes = poses.iter().map(|pose| size(pose.tip)).enumerate();
    sizes.fold((0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best }).0
}

fn found(
    sampler: &Sampler<'_>,
    machine: &Machine,
    poses: &[Pose],
    correction: [f64; AXES],
    error: &ErrorOf<'_>,
) -> Result<Worst> {
    let worst = index(poses);
    let (at, pose) = (sampler.asked.at(worst), poses[worst]);
    let mut rest = pose.tip;
    let (mut tables, mut terms) = (Vec::new(), Vec::new());
    let mut add = |source: String, sources: &mut dyn Iterator<Item = Source>| -> Result<()> {
        let (found, unexplained) = shares(machine, sources, pose.tip, |without| error(without, &at))?;
        if found.is_empty() {
            return Ok(());
        }
        let sum: [f64; 3] = std::array::from_fn(|i| pose.tip[i] - unexplained[i]);
        rest = std::array::from_fn(|i| rest[i] - sum[i]);
        for (term, share) in found {
            let along_um = along(share, pose.tip) * 1e3;
            terms.push(Cause { table: source.clone(), term: term.name(), error_um: um(share), along_um });
        }
        tables.push(Table { source, error_um: um(sum), along_um: along(sum, pose.tip) * 1e3 });
        Ok(())
    };
    for axis in machine.settings.axes.iter().map(|own| own.axis) {
        add(axis.letter().to_string(), &mut Source::terms(axis))?;
    }
    add(String::from("location errors"), &mut Source::locations(machine))?;
    rank(&mut tables, &mut terms);
    Ok(Worst {
        at_mm: [Axis::X, Axis::Y, Axis::Z].map(|axis| at[axis.index()]),
        error_um: um(pose.tip),
        size_um: size(pose.tip) * 1e3,
        orientation_urad: pose.orientation.map(|rad| rad * 1e6),
        correction,
        tables,
        terms,
        rest_um: um(rest),
    })
}

fn um(mm: [f64; 3]) -> [f64; 3] {
    mm.map(|mm| mm * 1e3)
}

/// Sorts the largest share of the error first.
fn rank(tables: &mut Vec<Table>, terms: &mut Vec<Cause>) {
    trueaxis_metrology::order::sort_by_number(tables, |one| -one.along_um);
    trueaxis_metrology::order::sort_by_number(terms, |one| -one.along_um);
}
