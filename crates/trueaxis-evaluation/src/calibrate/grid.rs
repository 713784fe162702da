//! A plate of balls or holes of unknown places, for self-calibration.
//!
//! The places, the plate's length and the machine's terms are all unknown. The same plate is measured in several placements:
//!
//! ```text
//! in its first position, turned by 90°     squareness, the ratio of the scales, and all shapes of even degree
//! in its first position, moved by a pitch  the shapes of the axis that it is moved along
//! a known length                           the scale
//! ```
//!
//! The directions and the length of the plate are those of two of its balls, A and B: their deviations are zero by definition,
//! and those of the others count from them. Only centres enter, each the middle of two touches on opposite sides: neither a
//! roundness, nor a diameter, nor lost motion does.
//!
//! Source: Raugh, Precision Engineering 7 (1985) 3; Ye, Takac, Berglund, Owen and Pease, Precision Engineering 20 (1997) 16.

use super::place::{Place, across, printed};
use super::ranges::{needed, number, whole};
use trueaxis::machine::Axis;
use trueaxis_metrology::calibration::{Centre, Surface};
use trueaxis_tables::error::FileError;
use trueaxis_tables::{KeyValue, Section};

/// Least wall between two holes, mm.
const WALL_MM: f64 = 5.0;
/// Share of the pitch within which two coordinates are one.
const SAME: f64 = 1e-3;

/// Most centres in all placements: a solution for as many takes some seconds.
const MOST: usize = 1000;

/// A plate of balls or holes of unknown places.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Holes if true, otherwise balls.
    pub holes: bool,
    /// Diameter of every ball or hole, mm.
    pub diameter_mm: f64,
    /// Number of balls along the plate's first direction.
    pub columns: usize,
    /// Number of balls along its second direction.
    pub rows: usize,
    /// Distance of neighbours in both directions, mm.
    pub pitch_mm: f64,
    /// The two balls that define its direction and length.
    pub ends: [usize; 2],
    /// Known distance between these and its standard uncertainty, mm.
    pub length_mm: Option<[f64; 2]>,
}

impl Grid {
    /// Number of balls or holes.
    pub fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// Nominal position from the plate's middle, mm.
    pub fn offset(&self, ball: usize) -> [f64; 2] {
        let at = |index: usize, count: usize| (index as f64 - 0.5 * (count - 1) as f64) * self.pitch_mm;
        // Whole steps of what a program prints: rounding must not tell apart what the placements do not.
        [at(ball % self.columns, self.columns), at(ball / self.columns, self.rows)].map(printed)
    }

    /// Nominal distance of the two balls that define its length, mm.
    pub fn nominal_mm(&self) -> f64 {
        let [[a, b], [c, d]] = self.ends.map(|ball| self.offset(ball));
        (c - a).hypot(d - b)
    }

    /// `hole` or `ball`.
    pub(super) fn word(&self) -> &'static str {
        if self.holes { "hole" } else { "ball" }
    }

    /// Name of a ball by its column and row.
    pub(super) fn name(&self, ball: usize, plate: &str) -> String {
        format!("{} {}-{} of {plate}", self.word(), ball % self.columns + 1, ball / self.columns + 1)
    }

    /// Nominal centre of a ball at a placement: X, Y, Z of the machine.
    pub fn centre(&self, place: &Place, ball: usize) -> [f64; 3] {
        let ([u, v], [a, b]) = (directions(place), self.offset(ball));
        std::array::from_fn(|k| place.at_mm[k] + a * u[k] + b * v[k])
    }

    /// Relative elongation that the known length states, with its standard uncertainty.
    pub(super) fn elongation(&self) -> (f64, Option<f64>) {
        let nominal = self.nominal_mm();
        self.length_mm.map_or((0.0, None), |[mm, uncertainty]| (mm / nominal - 1.0, Some(uncertainty / nominal)))
    }

    /// The balls that have deviations, in the order of these.
    pub(super) fn deviating(&self) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.count()).filter(|ball| !self.ends.contains(ball))
    }

    /// The surface of a touch. `own`: first of the deviations; `origin`: first unknown of the placement.
    pub(super) fn surface(
        &self,
        place: &Place,
        ball: usize,
        along: [f64; 3],
        [own, origin, length]: [usize; 3],
    ) -> Surface {
        let own = self.deviating().position(|of| of == ball).map(|at| own + 2 * at);
        let (plane, offset) = (directions(place), self.offset(ball));
        Surface::Centre(Centre { plane, origin, offset, own, length, along, weight: 1.0 })
    }

    /// Start values of a placement's unknowns with the tip at the plate's middle.
    pub(super) fn origin(place: &Place, tip: [f64; 3]) -> [f64; 2] {
        directions(place).map(|direction| (0..3).map(|k| direction[k] * tip[k]).sum())
    }

    /// Instruction for a placement: how the plate lies, and where the ends of its first row are.
    pub(super) fn set_up_text(&self, name: &str, place: &Place) -> String {
        let turned = match place.turn {
            0 => String::new(),
            turn => format!(", turned counter-clockwise by {} degrees", 90 * u16::from(turn)),
        };
        let stylus = stylus(place).map_or(String::new(), |needs| format!(", {needs}"));
        let (word, last) = (self.word(), self.columns - 1);
        let at = |ball: usize| {
            let [x, y, z] = self.centre(place, ball).map(printed);
            format!("{word} {}-1 at X{x} Y{y} Z{z}", ball + 1)
        };
        let facing = place.normal.letter();
        format!("plate {name}{turned}, its marked face towards {facing}{stylus}, its marked {}, {}", at(0), at(last))
    }

    /// Coordinates of the balls along an axis of the machine in all placements, rising; empty across the plate.
    pub(super) fn lines(&self, places: &[Place], axis: usize) -> Vec<f64> {
        let along = places.iter().filter(|place| in_plane(place).any(|own| own == axis));
        let mut all: Vec<f64> =
            along.flat_map(|place| (0..self.count()).map(|ball| self.centre(place, ball)[axis])).collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|one, other| (*one - *other).abs() < SAME * self.pitch_mm);
        all
    }
}

/// The stylus that an upright plate needs: the probe comes from its side.
pub(super) fn stylus(place: &Place) -> Option<String> {
    let along = place.normal.index() % 3 != 2;
    along.then(|| format!("needs a stylus that points along {}, towards the plate", place.normal.letter()))
}

/// Axes of the machine in the plane of a placement.
fn in_plane(place: &Place) -> impl Iterator<Item = usize> + use<> {
    let normal = place.normal.index() % 3;
    (0..3).filter(move |axis| *axis != normal)
}

/// Directions of a plate's columns and rows at a placement.
pub(super) fn directions(place: &Place) -> [[f64; 3]; 2] {
    let [u, v] = across(place.normal);
    let minus = |of: [f64; 3]| of.map(|part| if part == 0.0 { 0.0 } else { -part });
    match place.turn % 4 {
        0 => [u, v],
        1 => [v, minus(u)],
        2 => [minus(u), minus(v)],
        _ => [minus(v), u],
    }
}

impl Grid {
    /// Reads a plate and its placements.
    pub(super) fn read(section: &Section<'_>, tolerance_mm: f64) -> Result<(Grid, Vec<Place>), FileError> {
        let kind = section.choice("kind", [("balls", false), ("holes", true)])?;
        let holes = kind.ok_or_else(|| section.missing_here("kind", "\"balls\" or \"holes\""))?;
        let many = |key: &str, what: &str| whole(section, key, [2, 20])?.ok_or_else(|| section.missing_here(key, what));
        let diameter_mm =
            needed(section, "diameter_mm", [1.0, 200.0], " mm", "the diameter of every ball or hole, mm")?;
        let columns = many("columns", "the number of balls along its first direction")?;
        let rows = many("rows", "the number of balls along its second direction")?;
        let wall = if holes { WALL_MM } else { 0.0 };
        let least = diameter_mm + wall;
        let pitch_mm = needed(section, "pitch_mm", [least, 1000.0], " mm", "the distance of neighbours, mm")?;
        // Its half, too, is whole steps of what a program prints: all lines are equally far apart.
        let pitch_mm = 2.0 * printed(0.5 * pitch_mm);
        let mut grid = Grid { holes, diameter_mm, columns, rows, pitch_mm, ends: [0, columns - 1], length_mm: None };
        if let Some(length) = section.section("length")? {
            grid.read_length(length, tolerance_mm)?;
        }
        let at = section.numbers::<3>("at_mm")?;
        let height = if holes {
            "in the holes at the depth at which they are touched"
        } else {
            "at the height of the balls' centres"
        };
        let middle = || format!("X, Y, Z of the machine with the tip at the plate's middle, {height}");
        let at = at.ok_or_else(|| section.missing_here("at_mm", &middle()))?;
        let placements = section.sections("placement")?;
        if placements.is_empty() {
            return Err(section.missing_here("placement", "sections [[plate.placement]]"));
        }
        let (line, centres) = (section.first_line(), grid.count() * placements.len());
        if centres > MOST {
            let found =
                format!("{columns} x {rows} {}s in {} placements: {centres} centres", grid.word(), placements.len());
            return Err(section.at(line, "placement", &found, format!("at most {MOST} centres in all placements")));
        }
        let mut places: Vec<Place> = Vec::new();
        for placement in placements {
            let place = grid.read_placement(placement, (at.value, line), &places)?;
            places.push(place);
        }
        Ok((grid, places))
    }

    /// Reads the known length: as far off its pitch as both of its ends may be.
    fn read_length(&mut self, section: Section<'_>, tolerance_mm: f64) -> Result<(), FileError> {
        let end = |key: &str| {
            let found =
                section.numbers::<2>(key)?.ok_or_else(|| section.missing_here(key, "column and row, from 1"))?;
            let [column, row] = found.value;
            let fine = |at: f64, count: usize| at.fract() == 0.0 && (1.0..=count as f64).contains(&at);
            if fine(column, self.columns) && fine(row, self.rows) {
                Ok((column as usize - 1 + (row as usize - 1) * self.columns, found))
            } else {
                Err(section.wrong(&found, format!("column 1 to {} and row 1 to {}", self.columns, self.rows)))
            }
        };
        let ((from, _), (to, found)) = (end("from")?, end("to")?);
        if from == to {
            return Err(section.wrong(&found, "another one than from"));
        }
        self.ends = [from, to];
        let found = section.number("mm")?;
        let found = found.ok_or_else(|| section.missing_here("mm", "the distance of the two centres, mm"))?;
        let (mm, nominal, most) = (found.value, self.nominal_mm(), 2.0 * tolerance_mm);
        if (mm - nominal).abs() > most || mm.is_nan() || mm <= 0.0 {
            let needed = format!("{nominal:.3} mm, by its pitch, within {:.0} um (twice tolerance_um)", 1e3 * most);
            return Err(section.wrong(&found, needed));
        }
        let what = "the standard uncertainty of that distance, um";
        let uncertainty = 1e-3 * needed(&section, "uncertainty_um", [0.001, 1e4], " um", what)?;
        self.length_mm = Some([mm, uncertainty]);
        section.finish(None)
    }

    /// Reads a placement: balls lie on the lines of those in the placements before it.
    fn read_placement(
        &self,
        section: Section<'_>,
        (middle, plate_line): ([f64; 3], u32),
        before: &[Place],
    ) -> Result<Place, FileError> {
        let line = if section.first_line() == 0 { plate_line } else { section.first_line() };
        let turn = number(&section, "turn_deg", [0.0, 270.0], " degrees")?.unwrap_or(0.0);
        if turn % 90.0 != 0.0 {
            let found = section.number("turn_deg")?;
            let needed = "0, 90, 180 or 270: the balls lie on the lines of the others";
            return Err(found.map_or_else(|| section.missing_here("turn_deg", needed), |at| section.wrong(&at, needed)));
        }
        let normal = match section.axis("normal")? {
            Some(found) if found.value.is_rotary() => return Err(section.wrong(&found, "\"X\", \"Y\" or \"Z\"")),
            found => found.map_or(Axis::Z, |found| found.value),
        };
        let at = section.numbers::<3>("at_mm")?;
        let moved = section.numbers::<2>("moved")?;
        let by = moved.as_ref().map_or([0.0; 2], |moved| moved.value);
        let mut place = Place {
            stylus_mm: None,
            at_mm: at.as_ref().map_or(middle, |at| at.value),
            normal,
            along: Axis::X,
            across: Axis::Y,
            reversed: false,
            base: false,
            rotary_deg: vec![[0.0; 3]],
            turn: (turn / 90.0) as u8,
            line,
        };
        let [u, v] = directions(&Place { turn: 0, ..place.clone() });
        (0..3).for_each(|k| place.at_mm[k] = printed(place.at_mm[k] + self.pitch_mm * (by[0] * u[k] + by[1] * v[k])));
        if place.at_mm.iter().any(|q| q.is_nan() || q.abs() > 1e5) {
            return Err(section.at(line, "at_mm", "a plate beyond 100000 mm", "within the machine's travel"));
        }
        if let Some((axis, off)) = self.off_lines(&place, before) {
            let letter = ['X', 'Y', 'Z'][axis];
            let needed = format!(
                "its {}s on the lines of the placements before: {off} pitches less or more along {letter} (moved, at_mm)",
                self.word()
            );
            let found = format!("a plate turned by {turn} degrees and moved by {by:?} pitches, off those lines");
            return Err(section.at(line, if moved.is_some() { "moved" } else { "turn_deg" }, &found, needed));
        }
        section.finish(None)?;
        self.snap(&mut place, before);
        Ok(place)
    }

    /// Puts a placement that is a few micrometres off the lines of those before it onto them: an unmoved plate would otherwise
    /// look moved.
    fn snap(&self, place: &mut Place, before: &[Place]) {
        for axis in in_plane(place) {
            let Some(line) = self.lines(before, axis).first().copied() else { continue };
            let first = self.centre(place, 0)[axis];
            let steps = ((first - line) / self.pitch_mm).round();
            place.at_mm[axis] = printed(place.at_mm[axis] + line + steps * self.pitch_mm - first);
        }
    }

    /// Whether two placements in the same plane lie apart in it.
    pub(super) fn apart(&self, one: &Place, other: &Place) -> bool {
        in_plane(one).map(|axis| one.at_mm[axis] - other.at_mm[axis]).any(|by| by.abs() > SAME * self.pitch_mm)
    }

    /// Axis and pitches by which a placement is off the lines of those before it.
    fn off_lines(&self, place: &Place, before: &[Place]) -> Option<(usize, f64)> {
        in_plane(place).find_map(|axis| {
            let line = *self.lines(before, axis).first()?;
            let by = (self.centre(place, 0)[axis] - line) / self.pitch_mm;
            let off = (by - by.round()).abs();
            (off > SAME).then(|| (axis, (off * 1e3).round() / 1e3))
        })
    }
}

/// Reads the name of a plate and its tolerance.
pub(super) fn named<'a>(section: &Section<'a>) -> Result<(KeyValue<&'a str>, f64), FileError> {
    let name = section.string("name")?.ok_or_else(|| section.missing_here("name", "its name"))?;
    Ok((name, 1e-3 * number(section, "tolerance_um", [1.0, 1e5], " um")?.unwrap_or(300.0)))
}
