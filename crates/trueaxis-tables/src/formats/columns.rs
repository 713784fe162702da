//! Positions or deviations of one axis, measured once in each direction, in columns of any name.
//!
//! ```text
//! Position (mm),Forward,Reverse          Commanded,Reading
//! 0,0.4,1.9                              0,0.0021
//! 100,2.1,3.6                            100,100.0034
//! ```
//!
//! Such headers are read as they stand: `Position`, `Commanded`, `Target` or `Nominal`, or the letter of the axis; then
//! `Forward` and `Reverse`, or one of `Forward`, `Reading`, `Measured`, `Actual` for one direction of approach. [`Mapping`]
//! names the columns of any other header.
//!
//! A column states its unit in its name: `Fwd (um)`, `Fwd [um]`, `fwd_um`; in mm, um, inch, deg, arcsec or urad. [`Mapping::unit`]
//! is the unit of the readings that state none; positions that state none are then in mm, with inches in inches. Positions of a
//! rotary axis that state none are in degrees.
//!
//! The numbers tell whether the readings are actual positions (E = reading − position) or deviations (E = reading): read as the
//! other kind, the errors are as large as the positions. Readings without a unit beside positions in mm are in mm if they are
//! positions. Deviations are in µm if in mm they exceeded the [range](trueaxis::range::TRANSLATION) of an error, and in mm if
//! in µm none reached [`LEAST`]. Everything else is refused.

use super::{Imported, axis_of, finished, only, single};
use crate::Table;
use crate::error::FileError;
use crate::origin::Origin;
use crate::sheet::Sheet;
use crate::text::one_of;
use std::path::Path;
use trueaxis::error::Figure;
use trueaxis::machine::Axis;
use trueaxis::range;

/// Deviations in µm of which none reaches this are not the errors of an axis.
pub const LEAST: f64 = 0.02;
/// One kind of reading must make the errors smaller than the other by this factor.
const CLEARLY: f64 = 10.0;

/// Unit of lengths in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// mm.
    Millimetre,
    /// µm.
    Micrometre,
    /// 25.4 mm.
    Inch,
}

impl Unit {
    /// The unit with this name: `mm`, `um` or `inch`.
    pub fn from_name(name: &str) -> Option<Unit> {
        match name {
            "mm" => Some(Unit::Millimetre),
            "um" => Some(Unit::Micrometre),
            "inch" => Some(Unit::Inch),
            _ => None,
        }
    }
}

/// Columns of a file whose header does not name them as this module does.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mapping {
    /// Name of the column with the commanded positions.
    pub position: Option<String>,
    /// Name of the column with the readings of the approach in positive direction, or of the only one.
    pub forward: Option<String>,
    /// Name of the column with the readings of the approach in negative direction.
    pub reverse: Option<String>,
    /// Unit of readings whose column does not state it.
    pub unit: Option<Unit>,
}

impl Mapping {
    /// The mapping `position=Pos,forward=Fwd,reverse=Rev`, of which `reverse` may be missing.
    ///
    /// # Errors
    /// A part that is not KEY=NAME with one of these keys, or stands twice, and a key that is missing: found, needed.
    pub fn parse(text: &str) -> Result<Mapping, String> {
        const NEEDED: &str = "needed position=NAME,forward=NAME, and reverse=NAME if there is one";
        let mut mapping = Mapping::default();
        for part in text.split(',') {
            let given = part.split_once('=').map(|(key, name)| (key.trim(), name.trim()));
            let (place, name) = match given {
                Some((_, "")) | None => return Err(format!("found {part:?}, {NEEDED}")),
                Some(("position", name)) => (&mut mapping.position, name),
                Some(("forward", name)) => (&mut mapping.forward, name),
                Some(("reverse", name)) => (&mut mapping.reverse, name),
                Some((key, _)) => return Err(format!("found {key:?}, {NEEDED}")),
            };
            if place.replace(name.to_owned()).is_some() {
                return Err(format!("found {part:?} after another, {NEEDED}"));
            }
        }
        if mapping.position.is_none() || mapping.forward.is_none() {
            return Err(format!("found {text:?}, {NEEDED}"));
        }
        Ok(mapping)
    }
}

/// A unit with its factor to mm or degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Measure {
    name: &'static str,
    is_angle: bool,
    factor: f64,
}

const MILLIMETRE: Measure = Measure { name: "mm", is_angle: false, factor: 1.0 };
const MICROMETRE: Measure = Measure { name: "um", is_angle: false, factor: 1e-3 };
const INCH: Measure = Measure { name: "inch", is_angle: false, factor: 25.4 };
const DEGREE: Measure = Measure { name: "deg", is_angle: true, factor: 1.0 };
const ARC_SECOND: Measure = Measure { name: "arcsec", is_angle: true, factor: 1.0 / 3600.0 };
const MICRORADIAN: Measure = Measure { name: "urad", is_angle: true, factor: 180.0 / std::f64::consts::PI / 1e6 };

impl From<Unit> for Measure {
    fn from(unit: Unit) -> Measure {
        match unit {
            Unit::Millimetre => MILLIMETRE,
            Unit::Micrometre => MICROMETRE,
            Unit::Inch => INCH,
        }
    }
}

/// The unit with one of its usual names.
fn measure(name: &str) -> Option<Measure> {
    Some(match name.to_lowercase().as_str() {
        "mm" => MILLIMETRE,
        "um" | "µm" | "μm" => MICROMETRE,
        "in" | "inch" | "inches" => INCH,
        "deg" | "°" | "degree" | "degrees" => DEGREE,
        "arcsec" => ARC_SECOND,
        "urad" | "µrad" | "μrad" => MICRORADIAN,
        _ => return None,
    })
}

/// A column with its name, without and with its unit.
struct Column<'s> {
    index: usize,
    name: &'s str,
    stem: &'s str,
    unit: Option<Measure>,
}

/// The columns of a header.
fn columns<'s>(sheet: &'s Sheet<'_>) -> Result<Vec<Column<'s>>, FileError> {
    let mut columns = Vec::new();
    for (index, name) in sheet.header().iter().enumerate() {
        let in_brackets = [('(', ')'), ('[', ']')]
            .into_iter()
            .find_map(|(open, close)| name.strip_suffix(close).and_then(|inner| inner.rsplit_once(open)));
        let (stem, unit) = match (in_brackets, name.rsplit_once('_')) {
            (Some((stem, unit)), _) => (stem, Some((unit, measure(unit.trim())))),
            (None, Some((stem, unit))) if measure(unit).is_some() => (stem, Some((unit, measure(unit)))),
            _ => (name.as_str(), None),
        };
        columns.push((Column { index, name, stem: stem.trim(), unit: unit.and_then(|(_, unit)| unit) }, unit));
    }
    // A bracket that holds no unit belongs to the name.
    Ok(columns
        .into_iter()
        .map(|(column, unit)| match unit {
            Some((_, None)) => Column { stem: column.name, ..column },
            _ => column,
        })
        .collect())
}

const POSITION: [&str; 4] = ["position", "commanded", "target", "nominal"];
const FORWARD: [&str; 4] = ["forward", "reading", "measured", "actual"];
const REVERSE: [&str; 1] = ["reverse"];
const NEEDED: &str = "Position, Commanded, Target, Nominal or the axis; Forward and Reverse, or Reading, Measured or Actual, each \
                      once; or --columns position=NAME,forward=NAME,reverse=NAME";

/// Columns that are read.
struct Chosen<'s> {
    position: Column<'s>,
    forward: Column<'s>,
    reverse: Option<Column<'s>>,
    /// Names of the columns that are not read.
    others: Vec<&'s str>,
}

/// The columns of a header that names them as this module does.
fn known<'s>(sheet: &'s Sheet<'_>) -> Result<Chosen<'s>, FileError> {
    let (mut position, mut forward, mut reverse) = (None, None, None);
    for column in columns(sheet)? {
        let stem = column.stem.to_lowercase();
        let is = |names: &[&str]| names.contains(&stem.as_str());
        let place = if axis_of(column.stem).is_some() || is(&POSITION) {
            &mut position
        } else if is(&FORWARD) {
            &mut forward
        } else if is(&REVERSE) {
            &mut reverse
        } else {
            return Err(sheet.error(column.name, format!("column {:?}", column.name), NEEDED));
        };
        let name = column.name;
        if let Some(before) = place.replace(column) {
            return Err(sheet.error(name, format!("{name:?} beside {:?}", before.name), NEEDED));
        }
    }
    match (position, forward) {
        (Some(position), Some(forward)) => Ok(Chosen { position, forward, reverse, others: Vec::new() }),
        _ => Err(sheet.error("", sheet.header().join(","), NEEDED)),
    }
}

/// The columns of a mapping.
fn mapped<'s>(sheet: &'s Sheet<'_>, mapping: &Mapping) -> Result<Chosen<'s>, FileError> {
    let mut all = columns(sheet)?;
    let mut take = |key: &str, name: &str| {
        let is = |column: &Column<'_>| [column.name, column.stem].iter().any(|own| own.eq_ignore_ascii_case(name));
        let exact = all.iter().position(|column| column.name == name);
        let mut like = all.iter().enumerate().filter(|(_, column)| is(column)).map(|(index, _)| index);
        let found = match (exact, like.next(), like.next()) {
            (Some(index), ..) | (None, Some(index), None) => index,
            (None, Some(_), Some(_)) => {
                let needed = format!("one column with the name, of {}", sheet.header().join(", "));
                return Err(sheet.error("", format!("two columns for --columns {key}={name}"), needed));
            }
            (None, None, _) => {
                let needed = one_of(name, sheet.header().iter().map(String::as_str), ", ");
                return Err(sheet.error("", format!("no column for --columns {key}={name}"), needed));
            }
        };
        Ok(all.remove(found))
    };
    let position = take("position", mapping.position.as_deref().unwrap_or_default())?;
    let forward = take("forward", mapping.forward.as_deref().unwrap_or_default())?;
    let reverse = mapping.reverse.as_deref().map(|name| take("reverse", name)).transpose()?;
    Ok(Chosen { position, forward, reverse, others: all.iter().map(|column| column.name).collect() })
}

/// Line, position, forward and reverse reading, in the units of the file.
type Line = (u32, [f64; 3]);

/// Kind and unit of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Readings {
    are_positions: bool,
    unit: Measure,
}

/// Largest reading and largest distance between reading and position, in mm or degrees.
fn largest(lines: &[Line], position: Measure, readings: [Measure; 2]) -> [f64; 2] {
    lines.iter().fold([0.0; 2], |[own, apart], (_, [at, forward, reverse])| {
        let pairs = [(forward, readings[0]), (reverse, readings[1])];
        pairs.iter().fold([own, apart], |[own, apart]: [f64; 2], (value, unit)| {
            let value = *value * unit.factor;
            [own.max(value.abs()), apart.max((value - at * position.factor).abs())]
        })
    })
}

/// Whether the readings are positions; `None` where the numbers do not show it.
fn are_positions([own, apart]: [f64; 2]) -> Option<bool> {
    match (apart * CLEARLY <= own, own * CLEARLY <= apart) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

/// Kind and unit of readings without a unit.
fn readings(lines: &[Line], position: Measure, origin: &Origin) -> Result<Readings, FileError> {
    let alike = largest(lines, position, [position; 2]);
    let [own, _] = largest(lines, MILLIMETRE, [MILLIMETRE; 2]);
    if are_positions(alike) == Some(true) {
        return Ok(Readings { are_positions: true, unit: position });
    }
    if position == MILLIMETRE {
        // Deviations in µm may be as large as positions in mm.
        if own > range::TRANSLATION.most && are_positions(largest(lines, position, [MICROMETRE; 2])) == Some(false) {
            return Ok(Readings { are_positions: false, unit: MICROMETRE });
        }
        if own < LEAST && are_positions(alike) == Some(false) {
            return Ok(Readings { are_positions: false, unit: MILLIMETRE });
        }
    }
    let found = format!("readings up to {} without a unit", Figure(own));
    let needed = if position.is_angle {
        "their unit in the name of the column, (deg), (arcsec) or (urad)"
    } else {
        "--unit mm, um or inch, or the unit in the name of the column, as in Forward (um)"
    };
    Err(origin.whole(found, needed))
}

/// Reads a file; `file` is only named in errors, `axis` is needed if the position column does not name it.
///
/// # Errors
/// A missing or unknown column, readings that could be positions or deviations or whose unit is not clear, a position given
/// twice, an invalid value: file, line, column, found, needed.
pub fn import(text: &str, file: &Path, axis: Option<Axis>, mapping: &Mapping) -> Result<Imported, FileError> {
    let origin = &Origin::new(file);
    let mut sheet = Sheet::new(text.as_bytes(), file)?;
    let is_mapped = mapping.position.is_some();
    let chosen = if is_mapped { mapped(&sheet, mapping)? } else { known(&sheet)? };
    let axis = match (axis_of(chosen.position.stem), axis) {
        (Some(named), Some(wanted)) if named != wanted => {
            let found = format!("positions of {}", named.letter());
            return Err(sheet.error(chosen.position.name, found, format!("axis {}", wanted.letter())));
        }
        (Some(axis), _) | (None, Some(axis)) => axis,
        (None, None) => return Err(sheet.error(chosen.position.name, "no axis", "the axis (--axis X)")),
    };
    let own = [Some(&chosen.forward), chosen.reverse.as_ref()];
    let stated = own.map(|column| column.and_then(|column| column.unit));
    let all_state = own.iter().flatten().all(|column| column.unit.is_some());
    if mapping.unit.is_some() && all_state {
        return Err(sheet.error(chosen.forward.name, "--unit beside the unit of the column", "one of them"));
    }
    for column in own.into_iter().flatten().chain([&chosen.position]) {
        if column.unit.is_some_and(|unit| unit.is_angle != axis.is_rotary()) {
            let found = format!("{:?} for axis {}", column.name, axis.letter());
            return Err(sheet.error(column.name, found, "lengths for X, Y, Z; angles for A, B, C"));
        }
    }
    if axis.is_rotary() && mapping.unit.is_some() {
        return Err(sheet.error(
            chosen.forward.name,
            "--unit with a rotary axis",
            "(deg), (arcsec) or (urad) in the name",
        ));
    }
    let by_option = mapping.unit.map(Measure::from);
    let position = match (chosen.position.unit, by_option) {
        (Some(stated), _) => stated,
        (None, _) if axis.is_rotary() => DEGREE,
        (None, Some(INCH)) => INCH,
        (None, Some(_)) => MILLIMETRE,
        (None, None) => {
            let needed = "--unit mm, um or inch, or the unit in the names, as in Position (mm)";
            return Err(sheet.error(chosen.position.name, "positions without a unit", needed));
        }
    };
    let units = stated.map(|stated| stated.or(by_option));
    let [at, forward, reverse] = [Some(&chosen.position), Some(&chosen.forward), chosen.reverse.as_ref()]
        .map(|column| column.map(|column| column.index));
    let names = [chosen.position.name, chosen.forward.name, chosen.reverse.as_ref().map_or("", |column| column.name)];
    let [position_name, forward_name, reverse_name] = names.map(str::to_owned);
    let others = chosen.others.join(", ");
    let mut lines: Vec<Line> = Vec::new();
    while sheet.next_row()? {
        let at = sheet.number(at.unwrap_or_default())?;
        let forward = sheet.number(forward.unwrap_or_default())?;
        let reverse = reverse.map(|column| sheet.number(column)).transpose()?.unwrap_or(forward);
        lines.push((sheet.line(), [at, forward, reverse]));
    }
    let (units, are_positions) = match units {
        [None, None] => {
            let found = readings(&lines, position, origin)?;
            ([found.unit; 2], found.are_positions)
        }
        [None, Some(_)] | [Some(_), None] if !reverse_name.is_empty() => {
            let needed = "the unit in the names of both columns, or of none";
            return Err(origin.whole(format!("a unit in one of {forward_name:?} and {reverse_name:?}"), needed));
        }
        [forward, reverse] => {
            let forward = forward.or(reverse).unwrap_or(MILLIMETRE);
            let units = [forward, reverse.unwrap_or(forward)];
            let largest = largest(&lines, position, units);
            let kind = are_positions(largest).ok_or_else(|| {
                let found = format!(
                    "errors up to {} read as deviations and {} read as positions",
                    Figure(largest[0]),
                    Figure(largest[1])
                );
                origin.whole(found, "readings that are clearly one of them: positions beyond the errors")
            })?;
            (units, kind)
        }
    };
    let mut notes: Vec<String> = sheet.dialect().map(str::to_owned).into_iter().collect();
    if !others.is_empty() {
        notes.push(format!("not read: {others}"));
    }
    let both = if reverse_name.is_empty() { forward_name } else { format!("{forward_name} and {reverse_name}") };
    let sign = if are_positions { "positions, E = reading − position" } else { "deviations, +E" };
    let unit = if units[0] == units[1] {
        units[0].name.to_owned()
    } else {
        format!("{} and {}", units[0].name, units[1].name)
    };
    notes.push(format!("{position_name} in {}; {both} in {unit} are {sign}", position.name));
    let mut table = table(axis, lines, position, units, are_positions, &mut notes, origin)?;
    if reverse_name.is_empty() {
        notes.push(super::iso230_2::one_way(axis));
    } else {
        table.bidirectional = true;
    }
    Ok(finished(Imported { tables: vec![(axis, table)], notes, ..Imported::default() }, true))
}

/// The table of an axis from the lines of a file.
fn table(
    axis: Axis,
    mut lines: Vec<Line>,
    position: Measure,
    units: [Measure; 2],
    are_positions: bool,
    notes: &mut Vec<String>,
    origin: &Origin,
) -> Result<Table, FileError> {
    if lines.windows(2).any(|pair| matches!(pair, [(_, [before, ..]), (_, [at, ..])] if at < before)) {
        lines.sort_by(|(_, [one, ..]), (_, [other, ..])| one.total_cmp(other));
        notes.push(String::from("the positions do not increase: the lines are used in their order"));
    }
    for pair in lines.windows(2) {
        if let [(first, [before, ..]), (line, [at, ..])] = pair
            && at == before
        {
            let found = format!("{} again, already on line {first}", Figure(*at));
            let needed = "each position once; several runs are read by --from iso230-2, with their direction";
            return Err(origin.at(*line, "position", found, needed));
        }
    }
    let to_table = if axis.is_rotary() { std::f64::consts::PI / 180.0 } else { 1.0 };
    let rows = lines.into_iter().map(|(line, [at, forward, reverse])| {
        let at = at * position.factor;
        let error = |value: f64, unit: Measure| {
            let value = value * unit.factor;
            to_table * if are_positions { super::decimal::difference(value, at) } else { value }
        };
        (line, single(at, axis.index(), error(forward, units[0]), error(reverse, units[1])))
    });
    super::table(axis, only(axis.index()), rows.collect(), origin)
}
