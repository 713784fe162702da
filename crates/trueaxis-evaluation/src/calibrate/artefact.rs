//! Artefacts of known size, and where they are set up.

use super::block::Block;
use super::dial::{Dial, DialKind};
use super::grid::{self, Grid};
use super::place::Place;
use super::ranges::{needed, number, whole};
use trueaxis::machine::Axis;
use trueaxis_tables::error::FileError;
use trueaxis_tables::{KeyValue, Section};

const KINDS: &str = "\"ring\", \"ball\", \"ball plate\", \"step gauge\", \"square\", \"gauge block\" or \"block\"";

/// An artefact's shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A ring, touched inside.
    Ring {
        /// Diameter, mm.
        diameter_mm: f64,
        /// Number of points around it.
        points: usize,
        /// First and last angle, degrees; a whole circle has 360 between them.
        arc_deg: [f64; 2],
    },
    /// A ball on a stem.
    Ball {
        /// Diameter, mm.
        diameter_mm: f64,
        /// Whether it is touched at five points in every pose, instead of thirteen.
        few: bool,
    },
    /// Balls on a plate.
    Plate {
        /// Diameter of every ball, mm.
        diameter_mm: f64,
        /// Ball centres relative to the first, along the plate's first, second and upward directions, mm.
        balls_mm: Vec<[f64; 3]>,
        /// Whether a ball is touched in five points instead of all.
        few: bool,
    },
    /// Faces in a row, all facing back along it.
    Gauge {
        /// Distances of the faces from the first, mm.
        steps_mm: Vec<f64>,
    },
    /// Two arms at an angle, touched from outside.
    Square {
        /// Angle between the arms, degrees.
        angle_deg: f64,
        /// Lengths of the arms along and across, mm.
        arms_mm: [f64; 2],
        /// Number of points on each arm.
        points: usize,
    },
    /// A block with parallel faces.
    Block(Block),
    /// A plate of balls or holes of unknown places.
    Grid(Grid),
    /// A set-up with a dial indicator, which has no places.
    Dial(Dial),
}

/// An artefact of known size.
#[derive(Clone, Debug, PartialEq)]
pub struct Artefact {
    /// Name of the artefact.
    pub name: String,
    /// Shape of the artefact.
    pub kind: Kind,
    /// Standard uncertainty of the sizes, mm (for a square, of the angle, rad); `None` if they are unknown.
    pub uncertainty: Option<f64>,
    /// Plate, gauge and block: standard uncertainty of the overall length, 1; `None` if `uncertainty` includes it.
    pub length_uncertainty: Option<f64>,
    /// Largest accepted difference between a found and the stated size, mm.
    pub tolerance_mm: f64,
    /// Places where it is measured.
    pub places: Vec<Place>,
    /// Line in the task file.
    pub line: u32,
}

impl Artefact {
    pub(super) fn is_ball(&self) -> bool {
        matches!(self.kind, Kind::Ball { .. })
    }

    fn block(&self) -> Option<&Block> {
        match &self.kind {
            Kind::Block(block) => Some(block),
            _ => None,
        }
    }

    pub(crate) fn grid(&self) -> Option<&Grid> {
        match &self.kind {
            Kind::Grid(grid) => Some(grid),
            _ => None,
        }
    }

    pub(crate) fn dial(&self) -> Option<&Dial> {
        match &self.kind {
            Kind::Dial(dial) => Some(dial),
            _ => None,
        }
    }
}

/// Reads an artefact; `before`: those above it in the task; `is_open`: whether its places may be missing.
pub(super) fn read_artefact(section: Section<'_>, before: &[Artefact], is_open: bool) -> Result<Artefact, FileError> {
    let line = section.first_line();
    let name = section.string("name")?.ok_or_else(|| section.missing_here("name", "its name"))?.value.to_owned();
    let kind = section.string("kind")?.ok_or_else(|| section.missing_here("kind", KINDS))?;
    let blocks: Vec<_> = before.iter().map(|of| (of.name.as_str(), of.block())).collect();
    let diameter = || needed(&section, "diameter_mm", [0.5, 2000.0], " mm", "its diameter, mm");
    let shape = match kind.value {
        "ring" => {
            let points = whole(&section, "points", [5, 360])?.unwrap_or(24);
            let arc = section.numbers::<2>("arc_deg")?;
            let turn = |[from, to]: [f64; 2]| to - from >= 90.0 && to - from <= 360.0 && from.abs() <= 360.0;
            if let Some(arc) = arc.as_ref().filter(|arc| !turn(arc.value)) {
                return Err(section.wrong(arc, "first and last angle, 90 to 360 degrees apart"));
            }
            Kind::Ring { diameter_mm: diameter()?, points, arc_deg: arc.map_or([0.0, 360.0], |arc| arc.value) }
        }
        "ball" => Kind::Ball { diameter_mm: diameter()?, few: few_points(&section)? },
        "ball plate" => {
            let balls = section.lists::<3>("balls_mm")?;
            let balls = balls.ok_or_else(|| section.missing_here("balls_mm", "the centres of its balls, mm"))?;
            if !(3..=100).contains(&balls.value.len()) || balls.value.first() != Some(&[0.0; 3]) {
                return Err(section.wrong(&balls, "3 to 100 centres, the first of them [0, 0, 0]"));
            }
            Kind::Plate { diameter_mm: diameter()?, balls_mm: balls.value, few: few_points(&section)? }
        }
        "step gauge" => {
            let steps = section.list("steps_mm")?;
            let steps = steps.ok_or_else(|| section.missing_here("steps_mm", "the places of its faces, mm"))?;
            let rising = steps.value.windows(2).all(|pair| pair[1] > pair[0]);
            if !(2..=100).contains(&steps.value.len()) || !rising || steps.value.first() != Some(&0.0) {
                return Err(section.wrong(&steps, "2 to 100 distances that rise from 0"));
            }
            Kind::Gauge { steps_mm: steps.value }
        }
        "square" => {
            let arms = section.numbers::<2>("arms_mm")?;
            let arms = arms.ok_or_else(|| section.missing_here("arms_mm", "the lengths of its arms, mm"))?;
            if arms.value.iter().any(|arm| !(5.0..=5000.0).contains(arm)) {
                return Err(section.wrong(&arms, "5 to 5000 mm each"));
            }
            let angle_deg = number(&section, "angle_deg", [89.0, 91.0], " degrees")?.unwrap_or(90.0);
            Kind::Square { angle_deg, arms_mm: arms.value, points: whole(&section, "points", [2, 100])?.unwrap_or(6) }
        }
        "gauge block" | "block" => Kind::Block(Block::read(&section, kind.value, &blocks)?),
        _ => return Err(section.wrong(&kind, KINDS)),
    };
    let um = || number(&section, "uncertainty_um", [0.001, 1e4], " um");
    let uncertainty = match &shape {
        Kind::Square { .. } => number(&section, "uncertainty_urad", [0.001, 1e5], " urad")?.map(|urad| 1e-6 * urad),
        Kind::Block(block) if block.like.is_some() => None,
        Kind::Block(_) => um()?.map(|um| 1e-3 * um),
        _ => {
            let missing = || section.missing_here("uncertainty_um", "the standard uncertainty of its size, um");
            Some(1e-3 * um()?.ok_or_else(missing)?)
        }
    };
    let length_uncertainty = match shape {
        Kind::Plate { .. } | Kind::Gauge { .. } | Kind::Block(_) => {
            number(&section, "uncertainty_ppm", [0.001, 1000.0], " ppm")?
        }
        _ => None,
    };
    let length_uncertainty = length_uncertainty.map(|ppm| 1e-6 * ppm);
    let tolerance_mm = 1e-3 * number(&section, "tolerance_um", [1.0, 1e5], " um")?.unwrap_or(150.0);
    let places = section.sections("place")?;
    if places.is_empty() && !is_open {
        let needed = "at least one section [[artefact.place]], or `calibrate plan --minutes` to choose them";
        return Err(section.missing_here("place", needed));
    }
    let places = places.into_iter().map(|place| read_place(place, &shape)).collect::<Result<_, _>>()?;
    section.finish(None)?;
    Ok(Artefact { name, kind: shape, uncertainty, length_uncertainty, tolerance_mm, places, line })
}

/// Reads whether a ball is touched in five points instead of all.
fn few_points(section: &Section<'_>) -> Result<bool, FileError> {
    match section.number("points")? {
        Some(found) if found.value != 5.0 && found.value != 13.0 => {
            Err(section.wrong(&found, "5 touches of every ball, around it and on top, or all 13"))
        }
        found => Ok(found.is_some_and(|found| found.value == 5.0)),
    }
}

/// Reads a set-up with a dial indicator, an artefact without places.
pub(super) fn read_dial(section: Section<'_>) -> Result<Artefact, FileError> {
    let line = section.first_line();
    let name = section.string("name")?.ok_or_else(|| section.missing_here("name", "its name"))?.value.to_owned();
    let dial = Dial::read(&section)?;
    if !matches!(dial.kind, DialKind::Straightness { .. })
        && let Some(found) = section.number("tolerance_um")?
    {
        return Err(section.wrong(&found, "none: it is the largest form of a face, kind = \"straightness\""));
    }
    let kind = Kind::Dial(dial);
    let tolerance_mm = 1e-3 * number(&section, "tolerance_um", [1.0, 1e5], " um")?.unwrap_or(150.0);
    section.finish(None)?;
    Ok(Artefact { name, kind, uncertainty: None, length_uncertainty: None, tolerance_mm, places: Vec::new(), line })
}

/// Reads a plate of unknown places with its placements.
pub(super) fn read_plate(section: Section<'_>) -> Result<Artefact, FileError> {
    let line = section.first_line();
    let (name, tolerance_mm) = grid::named(&section)?;
    let (grid, places) = Grid::read(&section, tolerance_mm)?;
    let name = name.value.to_owned();
    section.finish(None)?;
    Ok(Artefact {
        name,
        kind: Kind::Grid(grid),
        uncertainty: None,
        length_uncertainty: None,
        tolerance_mm,
        places,
        line,
    })
}

fn read_place(section: Section<'_>, kind: &Kind) -> Result<Place, FileError> {
    let line = section.first_line();
    let at =
        section.numbers::<3>("at_mm")?.ok_or_else(|| section.missing_here("at_mm", "X, Y, Z of the machine there"))?;
    if at.value.iter().any(|q| q.abs() > 1e5) {
        return Err(section.wrong(&at, "at most 100000 mm"));
    }
    let linear = |key: &str, default: Axis| match section.axis(key)? {
        Some(found) if found.value.is_rotary() => Err(section.wrong(&found, "\"X\", \"Y\" or \"Z\"")),
        found => Ok(found.map_or(default, |found| found.value)),
    };
    let along = |found: Option<KeyValue<&str>>, needed: &str| {
        found.map_or_else(|| section.missing_here("along", needed), |found| section.wrong(&found, needed))
    };
    let mut place = Place {
        at_mm: at.value,
        normal: Axis::Z,
        along: Axis::X,
        across: Axis::Y,
        reversed: false,
        base: false,
        turn: 0,
        rotary_deg: vec![[0.0; 3]],
        stylus_mm: number(&section, "stylus_mm", [1.0, 2000.0], " mm")?,
        line,
    };
    if !matches!(kind, Kind::Ball { .. }) {
        place.normal = linear("normal", Axis::Z)?;
    }
    if matches!(kind, Kind::Square { .. } | Kind::Gauge { .. }) {
        let default = if place.normal == Axis::X { Axis::Y } else { Axis::X };
        place.along = linear("along", default)?;
        if place.along == place.normal {
            let found = section.string("along")?.or(section.string("normal")?);
            return Err(along(found, "another axis than the normal"));
        }
    }
    if let Kind::Block(block) = kind {
        place.along = linear("along", Axis::X)?;
        place.across = linear("across", if place.along == Axis::X { Axis::Y } else { Axis::X })?;
        if place.across == place.along {
            let found = section.string("across")?.or(section.string("along")?);
            return Err(along(found, "another axis across than along"));
        }
        place.reversed = section.boolean("reversed")?.unwrap_or(false);
        place.base = section.boolean("base")?.unwrap_or(false);
        if !block.touches_any(&place) {
            return Err(
                section.missing_here("base", "base = true: a length along the normal is measured from the base")
            );
        }
    }
    if matches!(kind, Kind::Square { .. }) {
        place.reversed = section.boolean("reversed")?.unwrap_or(false);
        if place.reversed && place.along == Axis::Z {
            let needed = "a first arm along \"X\" or \"Y\" where the square is turned over: about its upright arm";
            return Err(along(section.string("along")?, needed));
        }
    }
    if matches!(kind, Kind::Ball { .. })
        && let Some(angles) = section.lists::<3>("rotary_deg")?
    {
        let fine = |angles: &[f64; 3]| angles.iter().all(|angle| angle.abs() <= 3600.0);
        if !(1..=200).contains(&angles.value.len()) || !angles.value.iter().all(fine) {
            return Err(section.wrong(&angles, "1 to 200 poses of A, B, C, degrees"));
        }
        place.rotary_deg = angles.value;
    }
    section.finish(None)?;
    Ok(place)
}
