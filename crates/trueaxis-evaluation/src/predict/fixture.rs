//! How a part is held, and what cuts it: further set-ups, and tools whose length and diameter are not exactly known.
//!
//! ```text
//! p = z + Rᵀ p_s                     a point of a set-up's program on the part; R: the turn of the part, about X, then Y, then Z
//! d = Rᵀ (t + ω × p_s)               what an error of the set-up adds
//! d = n Δr,  d = −a Δl               of a tool's radius along n, the normal into the material, of its length along a, from
//!                                    the tip to the spindle
//! d = (a + n) Δr                     of the radius of a ball, whose length ends at its tip
//! ```

use super::cut::{Cut, Point};
use super::fit::Nominal;
use super::kinds::{FeatureKind, Side};
use super::temperature::Start;
use crate::calibrate::ranges::number;
use crate::uncertainty::terms::{Effect, Term};
use anyhow::Result;
use glam::{DMat3, DVec3};
use trueaxis_sim::program::Program;
use trueaxis_tables::error::FileError;
use trueaxis_tables::{KeyValue, Section};

/// Largest distance of a program's zero, mm.
const FARTHEST: f64 = 1e5;
/// Latest start of a set-up: after a month.
const LATEST_S: f64 = 2.7e6;
/// Largest standard uncertainties: what no tool or set-up has, µm and µrad.
const LARGEST: f64 = 1e4;

/// A further set-up of a part; the first one is that of the part itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Name, as features refer to it.
    pub name: String,
    /// Its program, as the file states it.
    pub file: String,
    /// Program zero in machine coordinates X, Y, Z, mm.
    pub at_mm: [f64; 3],
    /// Program zero on the part, in the coordinates of the first set-up's program, mm.
    pub zero_mm: [f64; 3],
    /// Turn of the part from the first set-up, about X, then Y, then Z, degrees.
    pub turned_deg: [f64; 3],
    /// Standard uncertainties of the part's place along X, Y, Z, mm, and of its orientation about them, rad.
    pub uncertainty: [f64; 6],
    /// When it starts in a record of temperatures; when the one before has ended unless stated.
    pub start: Option<Start>,
    /// Line of that key.
    pub start_line: u32,
    /// The program, once it has been read.
    pub program: Option<Program>,
    /// Line in the part's file.
    pub line: u32,
}

impl Setup {
    pub(super) fn read(section: Section<'_>) -> Result<Setup, FileError> {
        let line = section.first_line();
        let text = |key: &str, needed: &str| {
            Ok::<_, FileError>(section.string(key)?.ok_or_else(|| section.missing_here(key, needed))?.value.to_owned())
        };
        let place = |key: &str, most: f64, unit: &str| {
            let Some(found) = section.numbers::<3>(key)? else { return Ok(None) };
            let within = found.value.iter().all(|q| q.abs() <= most);
            if within { Ok(Some(found.value)) } else { Err(section.wrong(&found, format!("at most {most} {unit}"))) }
        };
        let name = text("name", "its name")?;
        let file = text("program", "its G-code file")?;
        let missing = |needed: &str| section.missing_here("at_mm", needed);
        let at_mm = place("at_mm", FARTHEST, "mm")?
            .ok_or_else(|| missing("X, Y, Z of the machine at the zero of this set-up's program, mm"))?;
        let zero_mm = place("zero_mm", FARTHEST, "mm")?.unwrap_or_default();
        let turned_deg = place("turned_deg", 360.0, "degrees")?.unwrap_or_default();
        let mut uncertainty = [0.0; 6];
        for (first, key, unit, mm) in [(0, "uncertainty_um", "um", 1e-3), (3, "uncertainty_urad", "urad", 1e-6)] {
            let Some(found) = section.numbers::<3>(key)? else { continue };
            if found.value.iter().any(|u| !(0.0..=LARGEST).contains(u)) {
                return Err(section.wrong(&found, format!("three standard uncertainties, 0 to {LARGEST} {unit}")));
            }
            uncertainty[first..first + 3].copy_from_slice(&found.value.map(|u| mm * u));
        }
        let (start, start_line) = read_start(&section)?.unzip();
        section.finish(None)?;
        Ok(Setup {
            name,
            file,
            at_mm,
            zero_mm,
            turned_deg,
            uncertainty,
            start,
            start_line: start_line.unwrap_or(line),
            program: None,
            line,
        })
    }

    /// Directions of the set-up's program on the part.
    pub(super) fn to_part(&self) -> DMat3 {
        let [a, b, c] = self.turned_deg.map(f64::to_radians);
        (DMat3::from_rotation_z(c) * DMat3::from_rotation_y(b) * DMat3::from_rotation_x(a)).transpose()
    }
}

/// When a set-up starts in a record of temperatures, by one of two keys, and the line of that.
fn read_start(section: &Section<'_>) -> Result<Option<(Start, u32)>, FileError> {
    number(section, "start_s", [0.0, LATEST_S], " s after the first row of the record")?;
    let after = section.number("start_s")?;
    let Some(at) = section.string("start_at")? else {
        return Ok(after.map(|after| (Start::After(after.value), after.line)));
    };
    if after.is_some() {
        return Err(section.wrong(&at, "start_s or start_at, one of them"));
    }
    let seconds = Start::clock(at.value).ok_or_else(|| section.wrong(&at, "hours and minutes, 00:00 to 23:59"))?;
    Ok(Some((Start::At(seconds), at.line)))
}

/// A tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Name, as features refer to it.
    pub name: String,
    /// Standard uncertainty of its length, mm.
    pub length: f64,
    /// Standard uncertainty of its radius, mm.
    pub radius: f64,
    /// Line in the part's file.
    pub line: u32,
}

impl Tool {
    pub(super) fn read(section: Section<'_>) -> Result<Tool, FileError> {
        let line = section.first_line();
        let name = section.string("name")?.ok_or_else(|| section.missing_here("name", "its name"))?.value.to_owned();
        let um = |key: &str| number(&section, key, [0.0, LARGEST], " um");
        let length = 1e-3 * um("length_uncertainty_um")?.unwrap_or_default();
        let radius = 0.5e-3 * um("diameter_uncertainty_um")?.unwrap_or_default();
        section.finish(None)?;
        Ok(Tool { name, length, radius, line })
    }
}

impl Side {
    pub(super) fn read(section: &Section<'_>, kind: FeatureKind) -> Result<Option<Side>, FileError> {
        match kind {
            FeatureKind::Circle => section.choice("side", [("inside", Side::Inside), ("outside", Side::Outside)]),
            FeatureKind::Line => section.choice("side", [("left", Side::Left), ("right", Side::Right)]),
            FeatureKind::Profile => {
                let all =
                    [("left", Side::Left), ("right", Side::Right), ("below", Side::Below), ("above", Side::Above)];
                section.choice("side", all)
            }
            _ => Ok(None),
        }
    }
}

/// What an uncertain quantity of set-ups, tools and drives moves, of unit variance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Moves {
    /// A set-up, along (0 to 2, mm) or about (3 to 5, rad) an axis.
    Setup {
        setup: usize,
        component: usize,
        by: f64,
    },
    Length {
        tool: usize,
        by: f64,
    },
    Radius {
        tool: usize,
        by: f64,
    },
    /// A figure of a drive, whose effect on the axes the points have.
    Drive,
}

/// The quantities of set-ups and tools, each with its term.
pub(super) fn moves(setups: &[Setup], tools: &[Tool]) -> (Vec<Moves>, Vec<Term>) {
    let (mut moves, mut terms) = (Vec::new(), Vec::new());
    let mut put = |name: String, one: Moves, by: f64| {
        if by > 0.0 {
            let effect = Effect::Part;
            moves.push(one);
            terms.push(Term { name, effect, degrees_of_freedom: f64::INFINITY });
        }
    };
    for (setup, of) in setups.iter().enumerate() {
        for (component, by) in of.uncertainty.into_iter().enumerate() {
            let how = if component < 3 { "along" } else { "about" };
            let name = format!("set-up {} {how} {}", of.name, ["X", "Y", "Z"][component % 3]);
            put(name, Moves::Setup { setup, component, by }, by);
        }
    }
    for (tool, of) in tools.iter().enumerate() {
        put(format!("length of {}", of.name), Moves::Length { tool, by: of.length }, of.length);
        put(format!("diameter of {}", of.name), Moves::Radius { tool, by: of.radius }, of.radius);
    }
    (moves, terms)
}

/// What the quantities move of the points of one feature.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    /// Of a point at the zero of the set-up's program, on the part.
    shift: DVec3,
    turn: DVec3,
    about: DVec3,
    length: f64,
    radius: f64,
}

impl Moved {
    /// `values`: of every quantity, in units of its standard uncertainty.
    pub(super) fn of(moves: &[Moves], values: &[f64], setups: &[Setup], cut: &Cut) -> Moved {
        let mut moved = Moved { shift: DVec3::ZERO, turn: DVec3::ZERO, about: DVec3::ZERO, length: 0.0, radius: 0.0 };
        if let Some(setup) = cut.setup.and_then(|setup| setups.get(setup)) {
            moved.about = DVec3::from(setup.zero_mm);
        }
        for (one, z) in moves.iter().zip(values) {
            match *one {
                Moves::Setup { setup, component, by } if cut.setup == Some(setup) => {
                    let along = cut.to_part * DVec3::AXES[component % 3] * (by * z);
                    *(if component < 3 { &mut moved.shift } else { &mut moved.turn }) += along;
                }
                Moves::Length { tool, by } if cut.tool == Some(tool) => moved.length += by * z,
                Moves::Radius { tool, by } if cut.tool == Some(tool) => moved.radius += by * z,
                _ => {}
            }
        }
        moved
    }

    /// What is added to a point of the feature.
    pub(super) fn of_point(&self, point: &Point, cut: &Cut, nominal: &Nominal) -> DVec3 {
        let lever = point.nominal - self.about;
        let mut moved = self.shift + self.turn.cross(lever) - self.length * point.pointing;
        if self.radius != 0.0 {
            moved += self.radius * into_material(point, cut, nominal);
        }
        moved
    }
}

/// Direction in which a larger tool moves the surface; zero where its end cuts.
fn into_material(point: &Point, cut: &Cut, nominal: &Nominal) -> DVec3 {
    if cut.kind == FeatureKind::Profile {
        return point.larger;
    }
    let ends = [cut.points.first(), cut.points.last()].map(|end| end.map_or(DVec3::ZERO, |end| end.nominal));
    let left = || nominal.normal.cross(ends[1] - ends[0]).normalize_or_zero();
    let outwards = || (point.nominal - nominal.centre).reject_from_normalized(nominal.normal).normalize_or_zero();
    match cut.side {
        Some(Side::Inside) => outwards(),
        Some(Side::Outside) => -outwards(),
        Some(Side::Left) => left(),
        Some(Side::Right) => -left(),
        Some(Side::Below | Side::Above) | None => DVec3::ZERO,
    }
}

/// The index of a name.
pub(super) fn named<'a>(
    section: &Section<'_>,
    key: &str,
    what: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<Option<usize>, FileError> {
    let Some(found): Option<KeyValue<&str>> = section.string(key)? else { return Ok(None) };
    let index = names.clone().position(|name| name == found.value);
    let all = || names.collect::<Vec<_>>().join(", ");
    index.map(Some).ok_or_else(|| section.wrong(&found, format!("the name of a {what}: {}", all())))
}
