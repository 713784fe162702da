//! Siemens SINUMERIK leadscrew (measuring system) error compensation, `$AA_ENC_COMP`, and compensation of sag and angularity,
//! `$AN_CEC`, with their companions.
//!
//! ```text
//! $AA_ENC_COMP[e,N,AX]=value    compensation value of point N, mm (degrees)     e: measuring system, 0 or 1
//! $AA_ENC_COMP_STEP[e,AX]=…     distance of the points, mm (degrees)            AX: machine axis, e.g. X1
//! $AA_ENC_COMP_MIN[e,AX]=…      position of point 0
//! $AA_ENC_COMP_MAX[e,AX]=…      position of the last point, k = (MAX − MIN)/STEP
//! $AA_ENC_COMP_IS_MODULO[e,AX]= 0, or 1: repeated cyclically
//!
//! $AN_CEC[t,N]=value            compensation value of point N of table t, for the output axis; also _STEP[t], _MIN[t], _MAX[t]
//! $AN_CEC_INPUT_AXIS[t]=(Y1)    axis whose position is the table's argument
//! $AN_CEC_OUTPUT_AXIS[t]=(Z1)   axis that is corrected: Z over Y is EZY, in the table of Y
//! $AN_CEC_DIRECTION[t]=0        of travel of the input axis: 0 both, 1 positive alone, -1 negative alone
//! $AN_CEC_IS_MODULO[t]=0        as above;  $AN_CEC_MULT_BY_TABLE[t]=0: not multiplied by another table
//! ```
//!
//! Sign: a *positive* value makes the axis move in *negative* direction (SINUMERIK 808D Function Manual 01/2017, p. 106; the
//! rest: 840D sl Function Manual Extended Functions, K3 Compensations), so the value is the error itself: value = +E,
//! E = actual − commanded. Linear interpolation; the first and last value apply outside. The values do not depend on the
//! direction of travel: reversal error belongs in MD32450 `BACKLASH`.
//!
//! A file with the control's own names (AX1, AX2, …) does not state its axis: the caller gives the axis, and the file may have
//! only one such name.
//!
//! The control keeps the old value of every point that a file does not write, so a file with missing points is refused, as is
//! one with points outside the table. Also refused are a modulo table that is not a full circle of a rotary axis, an axis with
//! two measuring systems, a table multiplied by another (a surface), and two tables of the same axes and direction, which the
//! control adds.
//!
//! `$AN_CEC` treats sign and ends like `$AA_ENC_COMP`. Tables over the same axis become one, on the positions of all of them;
//! a direction of travel without a table has no error there. Read only: errors over another axis are not exported.

use super::{ExportOptions, Exported, Imported};
use super::{losses, positioning};
use crate::Machine;
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use crate::text::fixed;
use std::collections::BTreeMap;
use std::fmt::Write;
use trueaxis::machine::{Axis, Row};

/// Name of the file, as in its first line `%_N_AX_EEC_INI`.
pub const FILE_NAME: &str = "AX_EEC.INI";
/// Most points read; the control's memory option ends far below.
const MAX_INDEX: usize = 100_000;

/// Points of a table in a file, with their lines.
#[derive(Default)]
struct Points {
    points: BTreeMap<usize, (u32, f64)>,
    step: Option<(u32, f64)>,
    min: Option<(u32, f64)>,
    max: Option<(u32, f64)>,
    modulo: Option<(u32, f64)>,
}

/// `$AA_ENC_COMP` of one axis.
#[derive(Default)]
struct AxisBlock {
    /// Name of the axis in the file.
    identifier: Option<String>,
    encoder: Option<usize>,
    points: Points,
}

/// A table of `$AN_CEC`.
#[derive(Default)]
struct CrossBlock {
    input: Option<(u32, Axis)>,
    output: Option<(u32, Axis)>,
    direction: Option<(u32, f64)>,
    factor: Option<(u32, f64)>,
    points: Points,
}

/// The tables of a file.
#[derive(Default)]
struct Blocks {
    own: BTreeMap<Axis, AxisBlock>,
    cross: BTreeMap<usize, CrossBlock>,
}

/// Line number; position and error there, mm or rad.
type Line = (u32, (f64, f64));

/// An error as a function of an axis' position.
struct Curve {
    axis: Axis,
    /// Axis of the error component.
    moved: Axis,
    /// Directions of travel in which it acts, forward and reverse.
    acts: [bool; 2],
    lines: Vec<Line>,
}

pub(super) fn import(text: &str, origin: &Origin, only: Option<Axis>) -> Result<Imported, FileError> {
    let mut blocks = Blocks::default();
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
    let mut curves = Vec::new();
    for (axis, block) in &blocks.own {
        curves.push(own_curve(*axis, block, origin)?);
    }
    let mut notes = Vec::new();
    for (number, block) in &blocks.cross {
        let curve = cross_curve(*number, block, origin)?;
        if only.is_none_or(|only| only == curve.axis) {
            let [moved, along] = [curve.moved, curve.axis].map(Axis::letter);
            notes.push(format!("$AN_CEC table {number}, of {moved} over {along}, is E{moved}{along}"));
            curves.push(curve);
        }
    }
    let mut tables = Vec::new();
    for axis in Axis::ALL {
        let of_axis: Vec<&Curve> = curves.iter().filter(|curve| curve.axis == axis).collect();
        if !of_axis.is_empty() {
            tables.push((axis, axis_table(axis, &of_axis, origin)?));
        }
    }
    if tables.is_empty() {
        return Err(match only {
            Some(axis) => {
                origin.whole(format!("no $AA_ENC_COMP and no $AN_CEC of axis {}", axis.letter()), "its values")
            }
            None => origin.whole("no $AA_ENC_COMP and no $AN_CEC", "compensation values"),
        });
    }
    Ok(Imported { tables, notes, ..Imported::default() })
}

/// Strips the block number from `N10 $AA_…`.
fn without_block_number(code: &str) -> &str {
    match code.strip_prefix('N') {
        Some(rest) if rest.starts_with(|first: char| first.is_ascii_digit()) => {
            rest.trim_start_matches(|digit: char| digit.is_ascii_digit()).trim_start()
        }
        _ => code,
    }
}

/// An assignment `NAME[indices]=value`.
struct Assignment<'t> {
    line: u32,
    /// Name and indices, as written.
    left: &'t str,
    name: &'t str,
    indices: Vec<&'t str>,
    value: &'t str,
}

impl Assignment<'_> {
    fn index(&self, text: &str, limit: usize, origin: &Origin) -> Result<usize, FileError> {
        text.parse::<usize>().ok().filter(|index| *index <= limit).ok_or_else(|| {
            origin.at(self.line, self.name, format!("index {text:?}"), format!("a whole number from 0 to {limit}"))
        })
    }

    /// Refuses an assignment that the file has already made.
    fn once<T>(&self, before: Option<(u32, T)>, origin: &Origin) -> Result<(), FileError> {
        match before {
            Some((first, _)) => {
                let found = format!("{} again, already on line {first}", self.left);
                Err(origin.at(self.line, self.name, found, "it once"))
            }
            None => Ok(()),
        }
    }

    /// Stores a table entry; `part` is the suffix after the name of the table.
    fn put(&self, part: &str, points: &mut Points, point: usize, origin: &Origin) -> Result<(), FileError> {
        let entry = (self.line, origin.number(self.line, self.name, self.value)?);
        let before = match part {
            "_STEP" => points.step.replace(entry),
            "_MIN" => points.min.replace(entry),
            "_MAX" => points.max.replace(entry),
            "_IS_MODULO" => points.modulo.replace(entry),
            _ => points.points.insert(point, entry),
        };
        self.once(before, origin)
    }
}

fn assignment(
    code: &str,
    line: u32,
    origin: &Origin,
    only: Option<Axis>,
    blocks: &mut Blocks,
) -> Result<(), FileError> {
    const NEEDED: &str = "$AA_ENC_COMP[e,N,AX]=value, or its _STEP, _MIN, _MAX, _IS_MODULO; or $AN_CEC[t,N]=value, or its _STEP, \
                          _MIN, _MAX, _INPUT_AXIS, _OUTPUT_AXIS, _DIRECTION, _IS_MODULO, _MULT_BY_TABLE";
    let wrong = || origin.at(line, "", format!("{code:?}"), NEEDED);
    let (left, value) = code.split_once('=').ok_or_else(wrong)?;
    let (left, value) = (left.trim(), value.trim());
    let (name, indices) = left.strip_suffix(']').and_then(|left| left.split_once('[')).ok_or_else(wrong)?;
    let name = name.trim();
    let indices: Vec<&str> = indices.split(',').map(str::trim).collect();
    let of = Assignment { line, left, name, indices, value };
    if let Some(part) = name.strip_prefix("$AN_CEC") {
        return cross(&of, part, origin, &mut blocks.cross)?.ok_or_else(wrong);
    }
    let part = name.strip_prefix("$AA_ENC_COMP").ok_or_else(wrong)?;
    let (encoder, point, identifier) = match (part, of.indices.as_slice()) {
        ("", [encoder, point, identifier]) => {
            (of.index(encoder, 1, origin)?, of.index(point, MAX_INDEX, origin)?, *identifier)
        }
        ("_STEP" | "_MIN" | "_MAX" | "_IS_MODULO", [encoder, identifier]) => {
            (of.index(encoder, 1, origin)?, 0, *identifier)
        }
        _ => return Err(wrong()),
    };
    let axis = match (axis_of(identifier), only) {
        (Some(axis), Some(only)) if axis != only => return Ok(()),
        (Some(axis), _) => axis,
        // The control's own names do not state the axis.
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
    let block = blocks.own.entry(axis).or_default();
    let first = block.identifier.get_or_insert_with(|| identifier.to_owned());
    if first != identifier {
        let found = format!("axis {identifier:?} beside {first:?}");
        let needed = format!("one of them in the file, for axis {}", axis.letter());
        return Err(origin.at(line, name, found, needed));
    }
    if *block.encoder.get_or_insert(encoder) != encoder {
        return Err(origin.at(line, name, "a second measuring system of the axis", "one (0 or 1) in the file"));
    }
    of.put(part, &mut block.points, point, origin)
}

/// Stores an assignment to a table of `$AN_CEC`; `None` if it is not one.
fn cross(
    of: &Assignment<'_>,
    part: &str,
    origin: &Origin,
    blocks: &mut BTreeMap<usize, CrossBlock>,
) -> Result<Option<()>, FileError> {
    let (table, point) = match (part, of.indices.as_slice()) {
        ("", [table, point]) => (table, of.index(point, MAX_INDEX, origin)?),
        (
            "_STEP" | "_MIN" | "_MAX" | "_IS_MODULO" | "_INPUT_AXIS" | "_OUTPUT_AXIS" | "_DIRECTION" | "_MULT_BY_TABLE",
            [table],
        ) => (table, 0),
        _ => return Ok(None),
    };
    let block = blocks.entry(of.index(table, MAX_INDEX, origin)?).or_default();
    let axis = || {
        let identifier = of.value.trim_start_matches('(').trim_end_matches(')').trim().trim_matches('"');
        let needed = "X, Y, Z, A, B or C, with a number if need be: (Y1), also in place of (AX2), which does not say which axis it is";
        axis_of(identifier)
            .map(|axis| (of.line, axis))
            .ok_or_else(|| origin.at(of.line, of.name, format!("axis {identifier:?}"), needed))
    };
    let number = || Ok::<_, FileError>((of.line, origin.number(of.line, of.name, of.value)?));
    match part {
        "_INPUT_AXIS" => of.once(block.input.replace(axis()?), origin)?,
        "_OUTPUT_AXIS" => of.once(block.output.replace(axis()?), origin)?,
        "_DIRECTION" => of.once(block.direction.replace(number()?), origin)?,
        "_MULT_BY_TABLE" => of.once(block.factor.replace(number()?), origin)?,
        _ => of.put(part, &mut block.points, point, origin)?,
    }
    Ok(Some(()))
}

/// Whether the identifier is `AX1`, `AX2` and so on.
fn is_number(identifier: &str) -> bool {
    let number = identifier.strip_prefix("AX").unwrap_or_default();
    !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit())
}

/// The axis X of `X`, `X1`, `X12`.
fn axis_of(identifier: &str) -> Option<Axis> {
    let mut characters = identifier.chars();
    let axis = characters.next().and_then(Axis::from_letter)?;
    characters.all(|rest| rest.is_ascii_digit()).then_some(axis)
}

/// Factor from an axis' unit in the file to that of its error, mm or rad.
fn to_error(axis: Axis) -> f64 {
    if axis.is_rotary() { std::f64::consts::PI / 180.0 } else { 1.0 }
}

fn own_curve(axis: Axis, block: &AxisBlock, origin: &Origin) -> Result<Curve, FileError> {
    let of = format!("axis {}", axis.letter());
    let lines = block.points.lines(["$AA_ENC_COMP", &of], axis, to_error(axis), origin)?;
    Ok(Curve { axis, moved: axis, acts: [true; 2], lines })
}

fn cross_curve(number: usize, block: &CrossBlock, origin: &Origin) -> Result<Curve, FileError> {
    let missing = |name: &str| origin.whole(format!("no $AN_CEC_{name}[{number}]"), "it");
    let (_, axis) = block.input.ok_or_else(|| missing("INPUT_AXIS"))?;
    let (line, moved) = block.output.ok_or_else(|| missing("OUTPUT_AXIS"))?;
    if moved.is_rotary() && moved != axis {
        let found = format!("rotary axis {} over {}", moved.letter(), axis.letter());
        return Err(origin.at(line, "$AN_CEC_OUTPUT_AXIS", found, "X, Y or Z, or the input axis itself"));
    }
    if let Some((line, factor)) = block.factor
        && factor != 0.0
    {
        let found = format!("table {number} multiplied by another");
        let needed = "0: the product of two tables is a surface over both axes, as --from grid takes it";
        return Err(origin.at(line, "$AN_CEC_MULT_BY_TABLE", found, needed));
    }
    let acts = match block.direction {
        None | Some((_, 0.0)) => [true, true],
        Some((_, 1.0)) => [true, false],
        Some((_, -1.0)) => [false, true],
        Some((line, other)) => return Err(origin.at(line, "$AN_CEC_DIRECTION", other, "0, 1 or -1")),
    };
    let lines = block.points.lines(["$AN_CEC", &format!("table {number}")], axis, to_error(moved), origin)?;
    Ok(Curve { axis, moved, acts, lines })
}

impl Points {
    /// Points of a table over an axis with their lines, values times a factor; `name` and `of` appear in errors.
    fn lines(&self, [name, of]: [&str; 2], axis: Axis, factor: f64, origin: &Origin) -> Result<Vec<Line>, FileError> {
        let missing = |part: &str| origin.whole(format!("no {name}_{part} for {of}"), "it");
        let (step_line, step) = self.step.ok_or_else(|| missing("STEP"))?;
        let (_, min) = self.min.ok_or_else(|| missing("MIN"))?;
        let (max_line, max) = self.max.ok_or_else(|| missing("MAX"))?;
        if step <= 0.0 {
            return Err(origin.at(step_line, &format!("{name}_STEP"), step, "more than 0"));
        }
        let intervals = (max - min) / step;
        let last = intervals.round();
        if !(1.0..=MAX_INDEX as f64).contains(&last) || (intervals - last).abs() > 1e-6 {
            let found = format!("{intervals} steps between MIN and MAX");
            return Err(origin.at(max_line, &format!("{name}_MAX"), found, "a whole number of steps, at least 1"));
        }
        let modulo = format!("{name}_IS_MODULO");
        match self.modulo {
            None | Some((_, 0.0)) => {}
            Some((line, 1.0)) => {
                if !axis.is_rotary() || (max - min - 360.0).abs() > 1e-9 {
                    let found = format!("a cyclic table of axis {} over {}", axis.letter(), max - min);
                    return Err(origin.at(line, &modulo, found, "a rotary axis and 360 degrees"));
                }
            }
            Some((line, value)) => return Err(origin.at(line, &modulo, value, "0 or 1")),
        }
        let last = last as usize;
        if let Some((index, (line, _))) = self.points.iter().next_back().filter(|(index, _)| **index > last) {
            return Err(origin.at(*line, name, format!("point {index}"), format!("at most {last}, which is at MAX")));
        }
        let mut lines = Vec::with_capacity(last + 1);
        for index in 0..=last {
            let Some(&(line, value)) = self.points.get(&index) else {
                let found = format!("no point {index} of {of}: the control would keep the old value");
                return Err(origin.whole(found, format!("points 0 to {last}")));
            };
            let position = if index == last { max } else { min + index as f64 * step };
            lines.push((line, (position, value * factor)));
        }
        Ok(lines)
    }
}

/// The table of an axis from its curves, at the positions of all of them.
fn axis_table(axis: Axis, curves: &[&Curve], origin: &Origin) -> Result<crate::Table, FileError> {
    let mut places: Vec<(f64, u32)> = Vec::new();
    let mut given = [false; 6];
    for (index, curve) in curves.iter().enumerate() {
        let mut before = curves.iter().take(index).filter(|other| other.moved == curve.moved);
        if before.any(|other| other.acts.iter().zip(curve.acts).any(|(one, own)| *one && own)) {
            let line = curve.lines.first().map_or(0, |(line, _)| *line);
            let [moved, along] = [curve.moved, axis].map(Axis::letter);
            let found = format!("a second table of {moved} over {along}, which the control adds");
            return Err(origin.at(line, "", found, "one in each direction of travel"));
        }
        places.extend(curve.lines.iter().map(|(line, (position, _))| (*position, *line)));
        if let Some(flag) = given.get_mut(curve.moved.index()) {
            *flag = true;
        }
    }
    places.sort_by(|one, other| one.0.total_cmp(&other.0));
    places.dedup_by(|later, kept| later.0 - kept.0 < 1e-9);
    let points: Vec<Vec<(f64, f64)>> =
        curves.iter().map(|curve| curve.lines.iter().map(|(_, point)| *point).collect()).collect();
    let mut lines = Vec::with_capacity(places.len());
    for (position, line) in places {
        let [mut forward, mut reverse] = [[0.0; 6]; 2];
        for (curve, points) in curves.iter().zip(&points) {
            let value = linear(points, position);
            for (twist, _) in [&mut forward, &mut reverse].into_iter().zip(curve.acts).filter(|(_, acts)| *acts) {
                if let Some(error) = twist.get_mut(curve.moved.index()) {
                    *error = value;
                }
            }
        }
        lines.push((line, Row { position, forward, reverse }));
    }
    super::table(axis, given, lines, origin)
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
