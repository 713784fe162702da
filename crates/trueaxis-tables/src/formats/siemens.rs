//! Siemens SINUMERIK leadscrew (measuring system) error compensation: `$AA_ENC_COMP` and its companions.
//!
//! ```text
//! $AA_ENC_COMP[e,N,AX]=value    compensation value of point N, mm (degrees)     e: measuring system, 0 or 1
//! $AA_ENC_COMP_STEP[e,AX]=…     distance of the points, mm (degrees)            AX: machine axis, e.g. X1
//! $AA_ENC_COMP_MIN[e,AX]=…      position of point 0
//! $AA_ENC_COMP_MAX[e,AX]=…      position of the last point, k = (MAX − MIN)/STEP
//! $AA_ENC_COMP_IS_MODULO[e,AX]= 0, or 1: repeated cyclically
//! ```
//!
//! Sign: a *positive* value makes the axis move in *negative* direction (SINUMERIK 808D Function Manual 01/2017, p. 106;
//! the rest: 840D sl Function Manual Extended Functions, K3 Compensations), so the value is the error itself: value = +E,
//! E = actual − commanded. Linear interpolation; the first and last value hold outside. There is no direction: reversal error
//! belongs in MD32450 `BACKLASH`.
//!
//! A file in the control's own names (AX1, AX2, …) does not say which axis it is for: the axis is given, and the file may have
//! one such name only.
//!
//! The control keeps the old value of every point that a file does not write; such a file, or one with points outside the
//! table, is refused. So is a modulo table that is not a full circle of a rotary axis, and an axis with two measuring systems.

use super::{ExportOptions, Exported, Imported};
use super::{losses, positioning};
use crate::Machine;
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use crate::text::fixed;
use std::collections::BTreeMap;
use std::fmt::Write;
use trueaxis::machine::{Axis, LocationErrors};

/// Name of the file, after its first line `%_N_AX_EEC_INI`.
pub const FILE_NAME: &str = "AX_EEC.INI";
/// Most points read: the memory option of the control ends far below.
const MAX_INDEX: usize = 100_000;

/// Values of one axis in a file, with their lines.
#[derive(Default)]
struct AxisBlock {
    /// Name of the axis in the file.
    identifier: Option<String>,
    encoder: Option<usize>,
    points: BTreeMap<usize, (u32, f64)>,
    step: Option<(u32, f64)>,
    min: Option<(u32, f64)>,
    max: Option<(u32, f64)>,
    modulo: Option<(u32, f64)>,
}

pub(super) fn import(text: &str, origin: &Origin, only: Option<Axis>) -> Result<Imported, FileError> {
    let mut blocks: BTreeMap<Axis, AxisBlock> = BTreeMap::new();
    for (line, content) in numbered(text) {
        let code = content.find(';').map_or(content, |start| content.split_at(start).0).trim();
        let code = without_block_number(code);
        if code.is_empty()
            || code.starts_with('%')
            || code.starts_with("CHANDATA(")
            || ["M17", "M2", "M02", "M30", "RET"].contains(&code)
        {
            continue;
        }
        assignment(code, line, origin, only, &mut blocks)?;
    }
    if blocks.is_empty() {
        return Err(match only {
            Some(axis) => origin.whole(format!("no $AA_ENC_COMP of axis {}", axis.letter()), "its values"),
            None => origin.whole("no $AA_ENC_COMP", "compensation values"),
        });
    }
    let mut tables = Vec::new();
    for (axis, block) in blocks {
        tables.push((axis, block_table(axis, &block, origin)?));
    }
    Ok(Imported {
        tables,
        grids: Vec::new(),
        location: LocationErrors::default(),
        settings: None,
        notes: Vec::new(),
        replaces_grids: false,
    })
}

/// `N10 $AA_…` without its block number.
fn without_block_number(code: &str) -> &str {
    match code.strip_prefix('N') {
        Some(rest) if rest.starts_with(|first: char| first.is_ascii_digit()) => {
            rest.trim_start_matches(|digit: char| digit.is_ascii_digit()).trim_start()
        }
        _ => code,
    }
}

fn assignment(
    code: &str,
    line: u32,
    origin: &Origin,
    only: Option<Axis>,
    blocks: &mut BTreeMap<Axis, AxisBlock>,
) -> Result<(), FileError> {
    const NEEDED: &str = "$AA_ENC_COMP[e,N,AX]=value, or its _STEP, _MIN, _MAX, _IS_MODULO";
    let wrong = || origin.at(line, "", format!("{code:?}"), NEEDED);
    let (left, value) = code.split_once('=').ok_or_else(wrong)?;
    let (name, indices) = left.trim().strip_suffix(']').and_then(|left| left.split_once('[')).ok_or_else(wrong)?;
    let name = name.trim();
    let indices: Vec<&str> = indices.split(',').map(str::trim).collect();
    let value = origin.number(line, name, value.trim())?;
    let index = |text: &str, limit: usize| {
        text.parse::<usize>().ok().filter(|index| *index <= limit).ok_or_else(|| {
            origin.at(line, name, format!("index {text:?}"), format!("a whole number from 0 to {limit}"))
        })
    };
    let (encoder, point, identifier) = match (name, indices.as_slice()) {
        ("$AA_ENC_COMP", [encoder, point, identifier]) => {
            (index(encoder, 1)?, Some(index(point, MAX_INDEX)?), *identifier)
        }
        (
            "$AA_ENC_COMP_STEP" | "$AA_ENC_COMP_MIN" | "$AA_ENC_COMP_MAX" | "$AA_ENC_COMP_IS_MODULO",
            [encoder, identifier],
        ) => (index(encoder, 1)?, None, *identifier),
        _ => return Err(wrong()),
    };
    let axis = match (axis_of(identifier), only) {
        (Some(axis), Some(only)) if axis != only => return Ok(()),
        (Some(axis), _) => axis,
        // The control's own names do not say which axis it is.
        (None, Some(only)) if is_number(identifier) => only,
        (None, None) if is_number(identifier) => {
            let needed = "the axis that it is (--axis X)";
            return Err(origin.at(line, name, format!("axis {identifier:?}, which names none"), needed));
        }
        (None, _) => {
            let needed = "X, Y, Z, A, B or C, with a number if need be (X1), or AX1 and so on";
            return Err(origin.at(line, name, format!("axis {identifier:?}"), needed));
        }
    };
    let block = blocks.entry(axis).or_default();
    let first = block.identifier.get_or_insert_with(|| identifier.to_owned());
    if first != identifier {
        let found = format!("axis {identifier:?} beside {first:?}");
        let needed = format!("one of them in the file, for axis {}", axis.letter());
        return Err(origin.at(line, name, found, needed));
    }
    if *block.encoder.get_or_insert(encoder) != encoder {
        return Err(origin.at(line, name, "a second measuring system of the axis", "one (0 or 1) in the file"));
    }
    let entry = (line, value);
    let before = match name {
        "$AA_ENC_COMP_STEP" => block.step.replace(entry),
        "$AA_ENC_COMP_MIN" => block.min.replace(entry),
        "$AA_ENC_COMP_MAX" => block.max.replace(entry),
        "$AA_ENC_COMP_IS_MODULO" => block.modulo.replace(entry),
        _ => block.points.insert(point.unwrap_or_default(), entry),
    };
    match before {
        Some((first, _)) => {
            Err(origin.at(line, name, format!("{} again, already on line {first}", left.trim()), "it once"))
        }
        None => Ok(()),
    }
}

/// Whether it is `AX1`, `AX2` and so on.
fn is_number(identifier: &str) -> bool {
    let number = identifier.strip_prefix("AX").unwrap_or_default();
    !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit())
}

/// X of `X`, `X1`, `X12`.
fn axis_of(identifier: &str) -> Option<Axis> {
    let mut characters = identifier.chars();
    let axis = characters.next().and_then(Axis::from_letter)?;
    characters.all(|rest| rest.is_ascii_digit()).then_some(axis)
}

fn block_table(axis: Axis, block: &AxisBlock, origin: &Origin) -> Result<crate::Table, FileError> {
    let letter = axis.letter();
    let missing = |name: &str| origin.whole(format!("no $AA_ENC_COMP_{name} for axis {letter}"), "it");
    let (step_line, step) = block.step.ok_or_else(|| missing("STEP"))?;
    let (_, min) = block.min.ok_or_else(|| missing("MIN"))?;
    let (max_line, max) = block.max.ok_or_else(|| missing("MAX"))?;
    if step <= 0.0 {
        return Err(origin.at(step_line, "$AA_ENC_COMP_STEP", step, "more than 0"));
    }
    let intervals = (max - min) / step;
    let last = intervals.round();
    if !(1.0..=MAX_INDEX as f64).contains(&last) || (intervals - last).abs() > 1e-6 {
        let found = format!("{intervals} steps between MIN and MAX");
        return Err(origin.at(max_line, "$AA_ENC_COMP_MAX", found, "a whole number of steps, at least 1"));
    }
    match block.modulo {
        None | Some((_, 0.0)) => {}
        Some((line, 1.0)) => {
            if !axis.is_rotary() || (max - min - 360.0).abs() > 1e-9 {
                let found = format!("a cyclic table of axis {letter} over {}", max - min);
                return Err(origin.at(line, "$AA_ENC_COMP_IS_MODULO", found, "a rotary axis and 360 degrees"));
            }
        }
        Some((line, value)) => return Err(origin.at(line, "$AA_ENC_COMP_IS_MODULO", value, "0 or 1")),
    }
    let last = last as usize;
    if let Some((index, (line, _))) = block.points.iter().next_back().filter(|(index, _)| **index > last) {
        return Err(origin.at(
            *line,
            "$AA_ENC_COMP",
            format!("point {index}"),
            format!("at most {last}, which is at MAX"),
        ));
    }
    let to_table = if axis.is_rotary() { std::f64::consts::PI / 180.0 } else { 1.0 };
    let mut lines = Vec::with_capacity(last + 1);
    for index in 0..=last {
        let Some(&(line, value)) = block.points.get(&index) else {
            let found = format!("no point {index} of axis {letter}: the control would keep the old value");
            return Err(origin.whole(found, format!("points 0 to {last}")));
        };
        let position = if index == last { max } else { min + index as f64 * step };
        lines.push((line, super::single(position, axis.index(), value * to_table, value * to_table)));
    }
    super::table(axis, super::only(axis.index()), lines, origin)
}

pub(super) fn export(
    machine: &Machine,
    options: &ExportOptions,
    origin: &Origin,
    exported: &mut Exported,
) -> Result<(), FileError> {
    let mut text = String::from("%_N_AX_EEC_INI\nCHANDATA(1)\n");
    for (settings, table) in positioning::chosen(machine, options.axis) {
        let letter = settings.axis.letter();
        losses::cross_terms(settings, table, &mut exported.dropped);
        let points = positioning::points(machine, settings, table);
        let points = positioning::mean_of_directions(settings, &points, &mut exported.dropped);
        let (points, step) = equidistant(letter, &points, options, origin, exported)?;
        let decimals = if settings.axis.is_rotary() { 7 } else { 6 };
        for (index, (_, error)) in points.iter().enumerate() {
            let _ = writeln!(text, "$AA_ENC_COMP[0,{index},{letter}1]={}", fixed(*error, decimals));
        }
        let (low, high) = (points.first().map_or(0.0, |point| point.0), points.last().map_or(0.0, |point| point.0));
        let wraps = settings.axis.is_rotary() && (high - low - 360.0).abs() < 1e-9;
        let _ = writeln!(text, "$AA_ENC_COMP_STEP[0,{letter}1]={step:?}");
        let _ = writeln!(text, "$AA_ENC_COMP_MIN[0,{letter}1]={low:?}");
        let _ = writeln!(text, "$AA_ENC_COMP_MAX[0,{letter}1]={high:?}");
        let _ = writeln!(text, "$AA_ENC_COMP_IS_MODULO[0,{letter}1]={}", u8::from(wraps));
        exported.notes.push(format!(
            "axis {letter}1: MD38000 MM_ENC_COMP_MAX_POINTS at least {}; MD32700 ENC_COMP_ENABLE 0 while loading, then 1",
            points.len()
        ));
    }
    text.push_str("M17\n");
    exported.files.push((String::from(FILE_NAME), text));
    losses::settings_losses(machine, options.axis, &mut exported.dropped);
    losses::machine_losses(machine, options.axis, &mut exported.dropped);
    Ok(())
}

/// The points on an equidistant grid, and its step.
fn equidistant(
    letter: char,
    points: &[(f64, f64)],
    options: &ExportOptions,
    origin: &Origin,
    exported: &mut Exported,
) -> Result<(Vec<(f64, f64)>, f64), FileError> {
    let (Some(&(low, _)), Some(&(high, _))) = (points.first(), points.last()) else {
        return Err(origin.whole(format!("an empty table of axis {letter}"), "at least two points"));
    };
    let Some(step) = options.step else {
        let step = (high - low) / (points.len() - 1) as f64;
        let uneven =
            points.iter().enumerate().find(|(index, point)| (point.0 - (low + *index as f64 * step)).abs() > 1e-6);
        return match uneven {
            None => Ok((points.to_vec(), step)),
            Some((_, point)) => Err(origin.whole(
                format!("a free grid: point {} of axis {letter}", point.0),
                "an equidistant table, or a step to resample it with",
            )),
        };
    };
    let intervals = (high - low) / step;
    if !(step > 0.0
        && intervals.round() >= 1.0
        && intervals <= MAX_INDEX as f64
        && (intervals - intervals.round()).abs() < 1e-6)
    {
        return Err(origin.whole(
            format!("a step of {step} for axis {letter}"),
            format!("one that divides its table, {low} to {high}, into whole steps"),
        ));
    }
    let count = intervals.round() as usize;
    let resampled: Vec<(f64, f64)> = (0..=count)
        .map(|index| if index == count { high } else { low + index as f64 * step })
        .map(|position| (position, linear(points, position)))
        .collect();
    let change = points.iter().map(|point| (linear(&resampled, point.0) - point.1).abs()).fold(0.0, f64::max);
    if change > 1e-6 {
        exported
            .dropped
            .push(format!("detail of axis {letter} between the steps (up to {:.4} um or mdeg)", change * 1e3));
    }
    Ok((resampled, step))
}

/// Linear interpolation, clamped at the ends.
fn linear(points: &[(f64, f64)], position: f64) -> f64 {
    let above = points.partition_point(|point| point.0 < position);
    match (above.checked_sub(1).and_then(|below| points.get(below)), points.get(above)) {
        (Some(low), Some(high)) => low.1 + (high.1 - low.1) * (position - low.0) / (high.0 - low.0),
        (_, Some(only)) | (Some(only), _) => only.1,
        (None, None) => 0.0,
    }
}
