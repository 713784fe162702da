//! Identifies the columns of a measurement by their names.

use crate::error::FileError;
use crate::sheet::Sheet;
use trueaxis::machine::Axis;
use trueaxis_metrology::accuracy::Direction;

const LIST: &str = "the columns X_mm (or C_deg, position_mm, position_deg), run, direction, deviation_um (deviation_urad); other names, with one \
     reading in each direction: --from columns";
const MATRIX: &str =
    "X_mm (or C_deg, position_mm, position_deg) and a column per run: +1, -1, +2, … or fwd_1_um, rev_1_um, …";

/// Columns of a file, by their index.
pub(super) struct Columns {
    pub(super) axis: Axis,
    /// Column of the target position.
    pub(super) position: usize,
    pub(super) layout: Layout,
}

/// Arrangement of the approaches.
pub(super) enum Layout {
    /// One line per approach.
    List { run: usize, direction: usize, deviation: usize },
    /// One line per target position, one column per run and direction.
    Matrix(Vec<Run>),
}

/// A column of a matrix.
pub(super) struct Run {
    pub(super) column: usize,
    pub(super) run: u32,
    pub(super) direction: Direction,
}

/// The columns that the header names, for the requested axis.
pub(super) fn read(sheet: &Sheet<'_>, wanted: Option<Axis>) -> Result<Columns, FileError> {
    let names = sheet.header();
    let is_matrix = names.iter().any(|name| run_column(name).is_some());
    let needed = if is_matrix { MATRIX } else { LIST };
    let (mut position, mut run, mut direction, mut deviation) = (None, None, None, None);
    let (mut runs, mut units): (Vec<Run>, Vec<(&str, bool)>) = (Vec::new(), Vec::new());
    for (column, name) in names.iter().enumerate() {
        let name = name.as_str();
        let before = match (name, run_column(name), position_column(name)) {
            (_, _, Some(target)) => position.replace((column, name, target)).is_some(),
            (_, Some((run, direction, unit)), _) => {
                if runs.iter().any(|other| (other.run, other.direction) == (run, direction)) {
                    let found = format!("run {run} in this direction again");
                    return Err(sheet.error(name, found, "each run and direction once"));
                }
                runs.push(Run { column, run, direction });
                units.extend(unit.map(|is_urad| (name, is_urad)));
                false
            }
            ("run", ..) if !is_matrix => run.replace(column).is_some(),
            ("direction", ..) if !is_matrix => direction.replace(column).is_some(),
            ("deviation_um" | "deviation_urad", ..) if !is_matrix => {
                units.push((name, name == "deviation_urad"));
                deviation.replace(column).is_some()
            }
            _ => return Err(sheet.error(name, format!("column {name:?}"), needed)),
        };
        if before {
            return Err(sheet.error(name, "a second such column", needed));
        }
    }
    let layout = match (run, direction, deviation) {
        _ if is_matrix => Some(Layout::Matrix(runs)),
        (Some(run), Some(direction), Some(deviation)) => Some(Layout::List { run, direction, deviation }),
        _ => None,
    };
    let (Some((position, name, (named, is_deg))), Some(layout)) = (position, layout) else {
        return Err(sheet.error("", "a header without all of them", needed));
    };
    let axis = measured_axis(sheet, name, named, wanted)?;
    for (name, is_angle) in std::iter::once((name, is_deg)).chain(units) {
        if is_angle != axis.is_rotary() {
            let found = format!("{name} for axis {}", axis.letter());
            return Err(sheet.error(name, found, "mm and um for X, Y, Z; deg and urad for A, B, C"));
        }
    }
    Ok(Columns { axis, position, layout })
}

/// The axis that the file names, or the requested one.
fn measured_axis(sheet: &Sheet<'_>, name: &str, named: Option<Axis>, wanted: Option<Axis>) -> Result<Axis, FileError> {
    match (named, wanted) {
        (Some(named), Some(wanted)) if named != wanted => {
            let found = format!("a measurement of {}", named.letter());
            Err(sheet.error(name, found, format!("axis {}", wanted.letter())))
        }
        (Some(axis), _) | (None, Some(axis)) => Ok(axis),
        (None, None) => Err(sheet.error(name, "no axis", "the axis, or a column such as X_mm")),
    }
}

/// Run, direction and whether µrad (if the name says so) of `+1`, `-1`, `+2` …; `fwd_1_um`, `rev_1_um` … (`_urad` for a rotary
/// axis).
fn run_column(name: &str) -> Option<(u32, Direction, Option<bool>)> {
    let (direction, rest) = [
        ("+", Direction::Up),
        ("-", Direction::Down),
        ("\u{2191}", Direction::Up),
        ("\u{2193}", Direction::Down),
        ("\u{2212}", Direction::Down),
        ("fwd_", Direction::Up),
        ("rev_", Direction::Down),
    ]
    .into_iter()
    .find_map(|(start, direction)| Some((direction, name.strip_prefix(start)?)))?;
    let (number, urad) = match rest.split_once('_') {
        None => (rest, None),
        Some((number, "um")) => (number, Some(false)),
        Some((number, "urad")) => (number, Some(true)),
        Some(_) => return None,
    };
    // Spelled-out names state their unit, as all other columns do.
    if urad.is_none() && name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        return None;
    }
    let run = number.bytes().all(|digit| digit.is_ascii_digit()).then(|| number.parse().ok()).flatten()?;
    (run > 0).then_some((run, direction, urad))
}

/// Axis (if named) and whether degrees, from `X_mm`, `C_deg`, `position_mm`, `position_deg`.
fn position_column(name: &str) -> Option<(Option<Axis>, bool)> {
    let (axis, is_deg) = match name.split_once('_')? {
        (axis, "mm") => (axis, false),
        (axis, "deg") => (axis, true),
        _ => return None,
    };
    if axis == "position" {
        return Some((None, is_deg));
    }
    let mut letters = axis.chars();
    let named = letters.next().and_then(Axis::from_letter)?;
    letters.next().is_none().then_some((Some(named), is_deg))
}
