//! Position, directions of travel and temperature of a query.

use crate::model;
use crate::numbers::{Numbers, numbers};
use anyhow::{Result, anyhow, bail};
use clap::Args;
use std::path::PathBuf;
use trueaxis::machine::{AXES, Axis};
use trueaxis_evaluation::correct;
use trueaxis_evaluation::model::range;
use trueaxis_tables::Machine;

#[derive(Args)]
pub(crate) struct CorrectArgs {
    /// machine.toml, its folder, or a compiled .tcomp.
    #[arg(value_name = "M")]
    pub(super) machine: PathBuf,
    /// Commanded position: X, Y, Z in mm, then the machine's rotary axes in the order A, B, C in degrees (zero if
    /// omitted) [default: the middle of the travel].
    #[arg(long, value_name = "X,Y,Z[,A,B,C]", value_parser = numbers, allow_hyphen_values = true)]
    pub(super) at: Option<Numbers>,
    /// Directions of travel, as in +x,-y [default: + on every axis].
    #[arg(long, value_name = "+X,-Y,…", allow_hyphen_values = true)]
    pub(super) direction: Option<String>,
    /// Temperature of the machine, °C, for its thermal growth [default: its reference temperature].
    #[arg(long, visible_alias = "temperature", value_name = "C", allow_hyphen_values = true)]
    pub(super) temperature_c: Option<f64>,
    /// Print one JSON document.
    #[arg(long)]
    pub(super) json: bool,
}

/// A validated query.
pub(super) struct Asked {
    pub(super) query: correct::Asked,
    /// Whether the position is the default one.
    pub(super) is_middle: bool,
}

impl Asked {
    pub(super) fn new(arguments: &CorrectArgs, machine: &Machine) -> Result<Asked> {
        let at = match &arguments.at {
            Some(given) => position(given, machine)?,
            None => middle(machine),
        };
        let reverse = arguments.direction.as_deref().map_or(Ok([false; AXES]), |text| directions(text, machine))?;
        let kelvin = model::rise(arguments.temperature_c, machine)?;
        Ok(Asked { query: correct::Asked { at, reverse, kelvin }, is_middle: arguments.at.is_none() })
    }
}

/// Positions in the order of the step, by [`Axis::index`].
pub(crate) fn position(found: &[f64], machine: &Machine) -> Result<[f64; AXES]> {
    correct::position(found, machine).map_err(|wrong| anyhow!("--at: {wrong}"))
}

/// The middle of the declared travel, or of the table, or zero.
fn middle(machine: &Machine) -> [f64; AXES] {
    let mut at = [0.0; AXES];
    for (own, table) in machine.axes() {
        let [low, high] = range(own, table);
        at[own.axis.index()] = 0.5 * (low + high);
    }
    at
}

fn directions(text: &str, machine: &Machine) -> Result<[bool; AXES]> {
    let axes: Vec<Axis> = machine.settings.step_axes().collect();
    let mut reverse = [None; AXES];
    for part in text.split(',').map(str::trim) {
        let of = |letters: &str| {
            let mut letters = letters.chars();
            let axis = letters.next().and_then(|letter| Axis::from_letter(letter.to_ascii_uppercase()));
            axis.filter(|axis| letters.next().is_none() && axes.contains(axis))
        };
        let signed =
            part.strip_prefix('+').map(|axis| (axis, false)).or(part.strip_prefix('-').map(|axis| (axis, true)));
        let found = signed.and_then(|(letter, is_reverse)| Some((of(letter)?, is_reverse))).ok_or_else(|| {
            let letters: Vec<String> = axes.iter().map(|axis| axis.letter().to_string()).collect();
            anyhow!("--direction: found \"{part}\", needed + or - and an axis of the machine ({})", letters.join(", "))
        });
        let (axis, is_reverse) = found?;
        if reverse[axis.index()].replace(is_reverse).is_some() {
            bail!("--direction: found axis {} twice, needed each axis once", axis.letter());
        }
    }
    Ok(reverse.map(Option::unwrap_or_default))
}
