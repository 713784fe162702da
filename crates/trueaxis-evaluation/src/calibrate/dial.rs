//! Readings of a dial indicator, typed in: each is a touch whose position is that of the machine plus the reading.
//!
//! ```text
//! straightness  n · p − o − θ m · p − s f_i            f_i: form of the face, out of the material; turned over, s changes
//! squareness    v · p − o₁ − θ u · p                   along the first arm u
//!               u · p − o₂ + θ v · p ± γ v · p         along the second arm v; − turned over. γ: angle − 90°
//! tram          z + R (α sin φ − β cos φ) − o − τ · p   p at the angle φ on the radius R, τ: slope of the table
//! test bar      x − β z + (e + ρ z) cos φ + s κ z − o   e, ρ: run-out of the bar, κ: its taper
//!               y + α z + …
//! ```
//!
//! are zero except for the scatter of the readings. α and β are the tilts of the spindle about X and Y. A reading increases as
//! its plunger is pushed in: on the side s = ±1 of a face the machine's axis is at q + s · reading with the dial in the
//! spindle, q − s · reading with the dial on the table.
//!
//! Source: ISO 230-1:2012, 8.2.2 (straightness), 10.3 (squareness), 10.1.4 (parallelism); Estler, NBSIR 84-2913 (reversal).

use super::place::unit;
use super::ranges::{needed, number, whole};
use trueaxis::machine::{AXES, Axis};
use trueaxis_metrology::calibration::{Part, Surface};
use trueaxis_tables::Section;
use trueaxis_tables::error::FileError;

const KINDS: &str = "\"straightness\", \"squareness\", \"tram\" or \"test bar\"";

/// A set-up with a dial indicator.
#[derive(Clone, Debug, PartialEq)]
pub struct Dial {
    /// Kind of the set-up.
    pub kind: DialKind,
    /// All readings, in order.
    pub readings: Vec<Reading>,
    /// Number of placements of the artefact.
    pub placements: usize,
}

/// Kind of a set-up. Axes are 0 to 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DialKind {
    /// Along a straight face.
    Straightness {
        /// Axis that moves.
        moves: usize,
        /// Axis across the face.
        reads: usize,
        /// Standard uncertainty of the face's form, mm; `None` if unknown.
        form: Option<f64>,
        /// Number of positions.
        points: usize,
    },
    /// Along both arms of a square, or along a table and a cylinder on it.
    Squareness {
        /// Axes along the first and the second arm.
        arms: [usize; 2],
        /// Standard uncertainty of its angle, rad; `None` if unknown.
        angle: Option<f64>,
    },
    /// In the spindle, around on the table.
    Tram {
        /// Radius of the circle, mm.
        radius_mm: f64,
        /// Standard uncertainty of the table's parallelism to X and Y, rad; `None` if the readings show it.
        table: Option<f64>,
    },
    /// On the table, along a bar in the spindle.
    Bar {
        /// Standard uncertainty of the bar's taper, rad.
        taper: f64,
    },
}

/// A reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Placement, from 0.
    pub placement: usize,
    /// Line of readings within it: first or second arm, plane of a bar.
    pub line: usize,
    /// Number within the line.
    pub index: usize,
    /// X, Y, Z of the machine, mm.
    pub at_mm: [f64; 3],
    /// Angle of the spindle, degrees from X towards Y.
    pub spindle_deg: f64,
    /// Axis along which the dial reads.
    pub reads: usize,
    /// Side of the face on which the dial is, ±1.
    pub side: f64,
}

/// Positions from 0 to a length.
fn steps(length: f64, points: usize) -> impl Iterator<Item = (usize, f64)> {
    (0..points).map(move |i| (i, length * i as f64 / (points - 1) as f64))
}

impl Dial {
    /// Movement of the machine's axes that has the effect of a reading, mm for a reading in mm.
    pub fn displacement(&self, reading: &Reading) -> [f64; 3] {
        // The bar moves with the machine, the dial does not.
        let held = if matches!(self.kind, DialKind::Bar { .. }) { -1.0 } else { 1.0 };
        unit(reading.reads).map(|part| held * reading.side * part)
    }

    /// Contact of the dial relative to the tool, mm.
    pub fn contact(&self, reading: &Reading) -> [f64; 3] {
        match self.kind {
            DialKind::Tram { radius_mm, .. } => {
                let (sin, cos) = reading.spindle_deg.to_radians().sin_cos();
                [radius_mm * cos, radius_mm * sin, 0.0]
            }
            _ => [0.0; 3],
        }
    }

    /// Whether the readings show a tilt of the spindle.
    pub fn shows_spindle(&self) -> bool {
        matches!(self.kind, DialKind::Tram { .. } | DialKind::Bar { .. })
    }

    pub(super) fn reads_curve(&self, moves: usize, component: usize) -> bool {
        matches!(self.kind, DialKind::Straightness { moves: m, reads, .. } if (m, reads) == (moves, component))
    }

    /// The operator's instruction for a line of readings.
    pub fn text(&self, name: &str, reading: &Reading) -> String {
        let letter = |axis: usize| ['X', 'Y', 'Z'][axis % 3];
        let sign = if reading.side > 0.0 { '+' } else { '-' };
        let side = format!("{sign}{} side", letter(reading.reads));
        let on = format!("dial on the {side}");
        match self.kind {
            DialKind::Straightness { moves, .. } => {
                let over = if reading.placement > 0 {
                    ", turned over about its length: each end stays where it is, the same face looks the other way"
                } else {
                    ""
                };
                format!("{name}: along {}, {on}{over}", letter(moves))
            }
            DialKind::Squareness { arms, .. } => {
                let arm = ["first", "second"][reading.line % 2];
                let over = if reading.placement > 0 { ", turned by half a turn about the second arm" } else { "" };
                format!("{name}: along {}, {arm} arm, {on}{over}", letter(arms[reading.line % 2]))
            }
            DialKind::Tram { radius_mm, .. } => {
                format!("{name}: dial in the spindle, on the table, on a radius of {radius_mm} mm")
            }
            DialKind::Bar { .. } => {
                format!("{name}: dial on the table, at its {side}, spindle at {} degrees", reading.spindle_deg)
            }
        }
    }
}

/// Name, initial value and standard uncertainty of an unknown.
pub(super) type Named = (String, f64, Option<f64>);

/// Points whose form is unknown: without its uncertainty all but the ends, from whose straight line it is measured.
fn free_forms(form: Option<f64>, points: usize) -> std::ops::Range<usize> {
    if form.is_some() { 0..points } else { 1..points - 1 }
}

impl Dial {
    /// Unknowns of the artefact itself: its form, its angle or its taper.
    pub(super) fn own_unknowns(&self, name: &str) -> Vec<Named> {
        match self.kind {
            DialKind::Straightness { form, points, .. } => {
                free_forms(form, points).map(|point| (format!("form {} of {name}", point + 1), 0.0, form)).collect()
            }
            DialKind::Squareness { angle, .. } => vec![(format!("angle of {name}"), 0.0, angle)],
            DialKind::Tram { .. } => Vec::new(),
            DialKind::Bar { taper } => vec![(format!("taper of {name}"), 0.0, Some(taper))],
        }
    }

    /// Unknowns of a placement.
    pub(super) fn place_unknowns(&self, placement: usize) -> Vec<Named> {
        let free = |what: &str, start: f64| (what.to_owned(), start, None);
        // The dial's zero is arbitrary; it is set to the machine's position.
        let start = |line: usize| {
            let first = self.readings.iter().find(|one| (one.placement, one.line) == (placement, line));
            first.map_or(0.0, |first| first.at_mm[first.reads])
        };
        match self.kind {
            DialKind::Straightness { .. } => vec![free("offset", start(0)), free("turn", 0.0)],
            DialKind::Squareness { .. } => {
                vec![free("first face", start(0)), free("second face", start(1)), free("turn", 0.0)]
            }
            DialKind::Tram { table, .. } => vec![
                free("offset", start(0)),
                ("slope of the table along X".into(), 0.0, table),
                ("slope of the table along Y".into(), 0.0, table),
            ],
            DialKind::Bar { .. } => vec![
                free("offset in X", start(0)),
                free("offset in Y", start(1)),
                free("eccentricity in X", 0.0),
                free("eccentricity in Y", 0.0),
                free("run-out in X", 0.0),
                free("run-out in Y", 0.0),
            ],
        }
    }

    /// Which of the unknowns of a placement are angles, rad.
    pub(super) fn place_angles(&self) -> std::ops::Range<usize> {
        match self.kind {
            DialKind::Straightness { .. } => 1..2,
            DialKind::Squareness { .. } => 2..3,
            DialKind::Tram { .. } => 1..3,
            DialKind::Bar { .. } => 4..6,
        }
    }

    /// The surface of a reading. `own`: first unknown of [`Dial::own_unknowns`]; `first`, of its placement; `spindle`, of the
    /// tilts.
    pub(super) fn surface(&self, reading: &Reading, own: usize, (first, spindle): (usize, usize)) -> Surface {
        let part = |unknown, factor, along| Part { unknown, factor, along };
        let side = reading.side;
        let (sin, cos) = reading.spindle_deg.to_radians().sin_cos();
        let z = Some(unit(2));
        let parts = match self.kind {
            DialKind::Straightness { moves, form, points, .. } => {
                let mut free = free_forms(form, points);
                let own = free.position(|point| point == reading.index).map(|index| part(own + index, side, None));
                let line = [part(first, 1.0, None), part(first + 1, 1.0, Some(unit(moves)))];
                line.into_iter().chain(own).collect()
            }
            DialKind::Squareness { arms: [u, _], .. } if reading.line == 0 => {
                vec![part(first, 1.0, None), part(first + 2, 1.0, Some(unit(u)))]
            }
            DialKind::Squareness { arms: [_, v], .. } => {
                let over = if reading.placement > 0 { -1.0 } else { 1.0 };
                let along = Some(unit(v));
                vec![part(first + 1, 1.0, None), part(first + 2, -1.0, along), part(own, -over, along)]
            }
            DialKind::Tram { radius_mm, .. } => vec![
                part(first, 1.0, None),
                part(first + 1, 1.0, Some(unit(0))),
                part(first + 2, 1.0, Some(unit(1))),
                part(spindle, -radius_mm * sin, None),
                part(spindle + 1, radius_mm * cos, None),
            ],
            DialKind::Bar { .. } => {
                let tilt = if reading.line == 0 { part(spindle + 1, 1.0, z) } else { part(spindle, -1.0, z) };
                vec![
                    part(first + reading.line, 1.0, None),
                    part(first + 2 + reading.line, -cos, None),
                    part(first + 4 + reading.line, -cos, z),
                    part(own, -side, z),
                    tilt,
                ]
            }
        };
        Surface::Face { normal: unit(reading.reads), outward: side, known_mm: 0.0, parts }
    }
}

impl Dial {
    /// Reads a set-up of a kind.
    pub(super) fn read(section: &Section<'_>) -> Result<Dial, FileError> {
        let kind = section.string("kind")?.ok_or_else(|| section.missing_here("kind", KINDS))?;
        let at = section.numbers::<3>("at_mm")?;
        let at = at.ok_or_else(|| section.missing_here("at_mm", "X, Y, Z of the machine at the first reading"))?.value;
        match kind.value {
            "straightness" => straightness(section, at),
            "squareness" => squareness(section, at),
            "tram" => tram(section, at),
            "test bar" => bar(section, at),
            _ => Err(section.wrong(&kind, KINDS)),
        }
    }
}

/// A linear axis, 0 to 2.
fn linear(section: &Section<'_>, key: &str, what: &str) -> Result<usize, FileError> {
    match section.axis(key)? {
        Some(found) if found.value.is_rotary() => Err(section.wrong(&found, "\"X\", \"Y\" or \"Z\"")),
        Some(found) => Ok(found.value.index() % 3),
        None => Err(section.missing_here(key, what)),
    }
}

fn placements(section: &Section<'_>, known: bool, key: &str) -> Result<usize, FileError> {
    let placements = whole(section, "placements", [1, 2])?.unwrap_or(if known { 1 } else { 2 });
    if placements == 1 && !known {
        let needed = format!("placements = 2: the artefact turned over, or its uncertainty ({key})");
        return Err(section.missing_here(key, &needed));
    }
    Ok(placements)
}

fn straightness(section: &Section<'_>, at: [f64; 3]) -> Result<Dial, FileError> {
    let moves = linear(section, "moves", "the axis that moves along the face")?;
    let reads = linear(section, "reads", "the axis along which the dial reads")?;
    let wrong = |needed: &str| {
        let found = section.string("reads");
        found.and_then(|found| {
            Err(found.map_or_else(|| section.missing_here("reads", needed), |at| section.wrong(&at, needed)))
        })
    };
    if reads == moves {
        return wrong("another axis than moves");
    }
    let length = needed(section, "length_mm", [10.0, 1e4], " mm", "the length of the readings, mm")?;
    let points = whole(section, "points", [3, 200])?.unwrap_or(11);
    let form = number(section, "uncertainty_um", [0.001, 1000.0], " um")?.map(|um| 1e-3 * um);
    let placements = placements(section, form.is_some(), "uncertainty_um")?;
    if placements == 2 && reads == 2 {
        return wrong(
            "\"X\" or \"Y\" where the face is turned over: upside down it cannot be read; or placements = 1 and uncertainty_um",
        );
    }
    let mut readings = Vec::new();
    for placement in 0..placements {
        let side = if placement == 0 { 1.0 } else { -1.0 };
        for (index, by) in steps(length, points) {
            let mut at_mm = at;
            at_mm[moves] += by;
            readings.push(Reading { placement, line: 0, index, at_mm, spindle_deg: 0.0, reads, side });
        }
    }
    Ok(Dial { kind: DialKind::Straightness { moves, reads, form, points }, readings, placements })
}

fn squareness(section: &Section<'_>, at: [f64; 3]) -> Result<Dial, FileError> {
    let arms = [
        linear(section, "along", "the axis along its first arm, or along the table under a cylinder")?,
        linear(section, "across", "the axis along its second arm")?,
    ];
    if arms[0] == arms[1] || arms[0] == 2 {
        let needed = "\"X\" or \"Y\", and another axis across: an upright arm is the second one";
        let found = section.string("along")?;
        return Err(found.map_or_else(|| section.missing_here("along", needed), |at| section.wrong(&at, needed)));
    }
    let lengths = section.numbers::<2>("arms_mm")?;
    let lengths = lengths.ok_or_else(|| section.missing_here("arms_mm", "the lengths of the readings, mm"))?;
    if lengths.value.iter().any(|arm| !(10.0..=5000.0).contains(arm)) {
        return Err(section.wrong(&lengths, "10 to 5000 mm each"));
    }
    let points = whole(section, "points", [2, 100])?.unwrap_or(6);
    let angle = number(section, "uncertainty_urad", [0.001, 1e5], " urad")?.map(|urad| 1e-6 * urad);
    let placements = placements(section, angle.is_some(), "uncertainty_urad")?;
    let mut readings = Vec::new();
    for placement in 0..placements {
        let over = if placement == 0 { 1.0 } else { -1.0 };
        for (line, (moves, reads)) in [(arms[0], arms[1]), (arms[1], arms[0])].into_iter().enumerate() {
            // The table under an upright square is read from above.
            let side = if line == 1 {
                -over
            } else if reads == 2 {
                1.0
            } else {
                -1.0
            };
            for (index, by) in steps(lengths.value[line], points) {
                let mut at_mm = at;
                at_mm[moves] += by;
                readings.push(Reading { placement, line, index, at_mm, spindle_deg: 0.0, reads, side });
            }
        }
    }
    Ok(Dial { kind: DialKind::Squareness { arms, angle }, readings, placements })
}

fn tram(section: &Section<'_>, at: [f64; 3]) -> Result<Dial, FileError> {
    let radius_mm = needed(section, "radius_mm", [5.0, 2000.0], " mm", "the radius of the circle, mm")?;
    let points = whole(section, "points", [4, 72])?.unwrap_or(8);
    let table = number(section, "uncertainty_urad", [0.001, 1e5], " urad")?.map(|urad| 1e-6 * urad);
    let sweep = section.numbers::<2>("sweep_mm")?;
    if let Some(sweep) = sweep.as_ref().filter(|sweep| sweep.value.iter().any(|mm| !(10.0..=5000.0).contains(mm))) {
        return Err(section.wrong(sweep, "10 to 5000 mm in X and in Y"));
    }
    if table.is_none() && sweep.is_none() {
        let needed = "the ways in X and Y over which the dial reads the table at 0 degrees, or uncertainty_urad of its \
                      parallelism to X and Y";
        return Err(section.missing_here("sweep_mm", needed));
    }
    let reading = |index: usize, at_mm: [f64; 3], spindle_deg: f64| Reading {
        placement: 0,
        line: 0,
        index,
        at_mm,
        spindle_deg,
        reads: 2,
        side: 1.0,
    };
    let mut readings: Vec<Reading> = (0..points).map(|i| reading(i, at, 360.0 * i as f64 / points as f64)).collect();
    for (axis, way) in sweep.iter().flat_map(|sweep| sweep.value.into_iter().enumerate()) {
        for share in [-0.5, 0.5] {
            let mut at_mm = at;
            at_mm[axis] += share * way;
            readings.push(reading(readings.len(), at_mm, 0.0));
        }
    }
    Ok(Dial { kind: DialKind::Tram { radius_mm, table }, readings, placements: 1 })
}

fn bar(section: &Section<'_>, at: [f64; 3]) -> Result<Dial, FileError> {
    let length = needed(section, "length_mm", [10.0, 5000.0], " mm", "the length of the readings along Z, mm")?;
    let points = whole(section, "points", [2, 100])?.unwrap_or(5);
    let what = "the standard uncertainty of the bar's taper (change of its radius), urad";
    let taper = 1e-6 * needed(section, "uncertainty_urad", [0.001, 1e5], " urad", what)?;
    let angles = section.list("angles_deg")?;
    if let Some(angles) = angles.as_ref().filter(|angles| angles.value != [0.0, 180.0]) {
        return Err(section.wrong(angles, "[0, 180]: in the mean of the two the bar's run-out cancels"));
    }
    let mut readings = Vec::new();
    for line in [0, 1] {
        for spindle_deg in [0.0, 180.0] {
            for (index, by) in steps(length, points) {
                let at_mm = [at[0], at[1], at[2] + by];
                readings.push(Reading { placement: 0, line, index, at_mm, spindle_deg, reads: line, side: 1.0 });
            }
        }
    }
    Ok(Dial { kind: DialKind::Bar { taper }, readings, placements: 1 })
}

/// X, Y, Z, A, B, C at a reading.
pub(super) fn pose(reading: &Reading) -> [f64; AXES] {
    let [x, y, z] = reading.at_mm;
    [x, y, z, 0.0, 0.0, 0.0]
}

/// Plane of a squareness: its normal.
pub(super) fn normal(arms: [usize; 2]) -> Axis {
    [Axis::X, Axis::Y, Axis::Z][(3 - arms[0] - arms[1]) % 3]
}
