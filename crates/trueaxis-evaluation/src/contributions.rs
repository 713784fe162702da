//! Shares of an error: of an axis, of one term of its table, of a location error.
//!
//! The share of a source is the part that would vanish if the machine were perfect there and nowhere else:
//!
//! ```text
//! share(s) = e(machine) − e(machine without s)
//! ```
//!
//! The caller chooses e: the error of the tip under a model, the error by exact transforms, or the residual after a correction
//! whose tables lack the source as well. In a first-order model the shares add up to e; in the exact geometry they add up to e
//! except for products of errors.

use anyhow::Result;
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// Where an error comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Table, periods, lost motion and thermal growth of an axis.
    Axis(Axis),
    /// A column of an axis' table, both directions of travel: 0 to 5 are the errors along X, Y, Z and about X, Y, Z.
    Term(Axis, usize),
    /// Errors of an axis that repeat within a period.
    Periods(Axis),
    /// Lost motion of an axis.
    Backlash(Axis),
    /// Thermal growth of an axis.
    Thermal(Axis),
    /// Squareness: 0, 1, 2 are A0Z, B0Z, C0Y.
    Squareness(usize),
    /// A location error of a rotary axis; components as in [`Source::Term`].
    Location(Axis, usize),
}

impl Source {
    /// All axes, in the order of the machine's list.
    pub fn axes(machine: &Machine) -> impl Iterator<Item = Source> + '_ {
        machine.settings.axes.iter().map(|own| Source::Axis(own.axis))
    }

    /// The terms of an axis: six of its table, periods, lost motion, thermal growth.
    pub fn terms(axis: Axis) -> impl Iterator<Item = Source> {
        (0..AXES).map(move |component| Source::Term(axis, component)).chain([
            Source::Periods(axis),
            Source::Backlash(axis),
            Source::Thermal(axis),
        ])
    }

    /// The location errors of a machine: squareness, then those of its rotary axes.
    pub fn locations(machine: &Machine) -> impl Iterator<Item = Source> + '_ {
        let rotary = machine.settings.axes.iter().map(|own| own.axis).filter(|axis| axis.is_rotary());
        let located = rotary.flat_map(|axis| (0..AXES).map(move |component| Source::Location(axis, component)));
        (0..3).map(Source::Squareness).chain(located)
    }

    /// ISO 230-1 name: `X`, `EYX`, `C0Y`, `EX0C`; for the others `periods X`, `backlash X`, `thermal growth X`.
    pub fn name(self) -> String {
        let along = |component: usize| Axis::ALL.get(component).map_or('?', |axis| axis.letter());
        match self {
            Source::Axis(axis) => axis.letter().to_string(),
            Source::Term(axis, component) => format!("E{}{}", along(component), axis.letter()),
            Source::Periods(axis) => format!("periods {}", axis.letter()),
            Source::Backlash(axis) => format!("backlash {}", axis.letter()),
            Source::Thermal(axis) => format!("thermal growth {}", axis.letter()),
            Source::Squareness(which) => ["A0Z", "B0Z", "C0Y"].get(which).copied().unwrap_or("?").to_owned(),
            Source::Location(axis, component) => format!("E{}0{}", along(component), axis.letter()),
        }
    }

    /// The machine without this source; `None` if the machine is already perfect there.
    pub fn removed_from(self, machine: &Machine) -> Option<Machine> {
        let mut without = machine.clone();
        let settings = &mut without.settings;
        let slot = |axis: Axis| machine.settings.axes.iter().position(|own| own.axis == axis);
        match self {
            Source::Axis(axis) => {
                let slot = slot(axis)?;
                let (own, table) = (settings.axes.get_mut(slot)?, without.tables.get_mut(slot)?);
                (own.backlash, own.thermal, *table) = (0.0, Default::default(), None);
                settings.periodic.retain(|period| period.axis != axis);
            }
            Source::Term(axis, component) => {
                for row in &mut without.tables.get_mut(slot(axis)?)?.as_mut()?.rows {
                    *row.forward.get_mut(component)? = 0.0;
                    *row.reverse.get_mut(component)? = 0.0;
                }
            }
            Source::Periods(axis) => settings.periodic.retain(|period| period.axis != axis),
            Source::Backlash(axis) => settings.axes.get_mut(slot(axis)?)?.backlash = 0.0,
            Source::Thermal(axis) => settings.axes.get_mut(slot(axis)?)?.thermal = Default::default(),
            Source::Squareness(which) => {
                let location = &mut settings.location;
                **[&mut location.a0z, &mut location.b0z, &mut location.c0y].get_mut(which)? = 0.0;
            }
            Source::Location(axis, component) => {
                let rotary = axis.index().checked_sub(Axis::A.index())?;
                *settings.location.rotary.get_mut(rotary)?.get_mut(component)? = 0.0;
            }
        }
        (without != *machine).then_some(without)
    }
}

/// A source with its share, mm.
pub type Share = (Source, [f64; 3]);

/// Shares of the `sources` that the machine has in its error `whole`, and the rest, which no single source explains; mm.
///
/// `error` computes the error of a machine the way `whole` was computed for this one. Cost: one call per source.
///
/// # Errors
/// As `error`.
pub fn shares(
    machine: &Machine,
    sources: impl Iterator<Item = Source>,
    whole: [f64; 3],
    mut error: impl FnMut(&Machine) -> Result<[f64; 3]>,
) -> Result<(Vec<Share>, [f64; 3])> {
    let mut found = Vec::new();
    let mut rest = whole;
    for source in sources {
        let Some(without) = source.removed_from(machine) else { continue };
        let others = error(&without)?;
        let share: [f64; 3] = std::array::from_fn(|i| whole[i] - others[i]);
        rest = std::array::from_fn(|i| rest[i] - share[i]);
        found.push((source, share));
    }
    Ok((found, rest))
}
