//! A task: machine, probe, artefacts, and where they are set up.

use std::path::{Path, PathBuf};
use trueaxis::machine::Axis;
use trueaxis_tables::error::FileError;
use trueaxis_tables::{Found, Section, read_toml};

/// What a control executes and logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// G38.2, log by `(LOG,…)`.
    LinuxCnc,
    /// G38.2, `[PRB:…]` on the console.
    GrblHal,
    /// The macro `TRUEAXIS_PROBE` of integrations/klipper.
    Klipper,
}

impl Dialect {
    /// Its name in a task file.
    pub fn name(self) -> &'static str {
        match self {
            Dialect::LinuxCnc => "linuxcnc",
            Dialect::GrblHal => "grblhal",
            Dialect::Klipper => "klipper",
        }
    }
}

/// The probe and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Radius of the tip, mm.
    pub tip_radius_mm: f64,
    /// Standard uncertainty of the effective radius, mm; none where the artefacts are to tell it.
    pub tip_uncertainty_mm: Option<f64>,
    /// How far the tip is deflected before the trip, mm: the effective radius is that much smaller.
    pub pre_travel_mm: f64,
    /// Standard deviation of a touch, mm.
    pub repeatability_mm: f64,
    /// Way before the surface at which a probing move starts, mm.
    pub approach_mm: f64,
    /// Way beyond the surface at which it ends, mm.
    pub overtravel_mm: f64,
    /// Way on which an axis takes up its lost motion before a touch, mm.
    pub take_up_mm: f64,
    /// Position of Z at which the probe travels from place to place, mm.
    pub safe_z_mm: Option<f64>,
    /// Feed of a probing move, mm/min.
    pub probe_feed_mm_per_min: f64,
    /// Feed of the other moves near an artefact, mm/min.
    pub feed_mm_per_min: f64,
    /// Touches of every point.
    pub repeats: usize,
}

/// An artefact's shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A ring, touched inside.
    Ring {
        /// Diameter, mm.
        diameter_mm: f64,
        /// Points around it.
        points: usize,
        /// First and last angle, degrees; a whole circle has 360 between them.
        arc_deg: [f64; 2],
    },
    /// A ball on a stem.
    Ball {
        /// Diameter, mm.
        diameter_mm: f64,
    },
    /// Balls on a plate.
    Plate {
        /// Diameter of every ball, mm.
        diameter_mm: f64,
        /// Their centres from the first one, along the plate's first, second and upward direction, mm.
        balls_mm: Vec<[f64; 3]>,
    },
    /// Faces in a row, all of which look back along it.
    Gauge {
        /// Their distances from the first, mm.
        steps_mm: Vec<f64>,
    },
    /// Two arms at an angle, touched outside.
    Square {
        /// The angle, degrees.
        angle_deg: f64,
        /// Lengths of the arms along and across, mm.
        arms_mm: [f64; 2],
        /// Points on either arm.
        points: usize,
    },
}

/// Where an artefact is set up.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// X, Y, Z of the machine with the tip's centre at the artefact's: centre of a ring or ball, first ball of a plate, first
    /// face of a gauge, corner of a square; mm.
    pub at_mm: [f64; 3],
    /// Ring, plate, square: direction across it, in which the probe leaves it.
    pub normal: Axis,
    /// Gauge and square: the direction of the row, of the first arm.
    pub along: Axis,
    /// The square is turned over about its second arm.
    pub reversed: bool,
    /// A, B, C at which a ball is measured, degrees.
    pub rotary_deg: Vec<[f64; 3]>,
    /// Line in the task file.
    pub line: u32,
}

/// A thing of known size.
#[derive(Clone, Debug, PartialEq)]
pub struct Artefact {
    /// Its name.
    pub name: String,
    /// Its shape.
    pub kind: Kind,
    /// Standard uncertainty of its sizes, mm (of a square's angle rad); none: not known.
    pub uncertainty: Option<f64>,
    /// How far a size may be found from the stated one, mm.
    pub tolerance_mm: f64,
    /// Where it is measured.
    pub places: Vec<Place>,
    /// Line in the task file.
    pub line: u32,
}

/// The artefact that is touched again and again to follow the drift.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Index of a ball.
    pub artefact: usize,
    /// Touches after which it is visited again, beside before and after every set-up.
    pub every: usize,
}

/// What is to be found, as far as the artefacts span it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Squareness.
    pub squareness: bool,
    /// Scales.
    pub scale: bool,
    /// Backlash.
    pub backlash: bool,
    /// Centre lines and tilts of rotary axes that turn in the task.
    pub rotary: bool,
    /// Degree of the polynomial of an axis' own error; 1 is the scale.
    pub positioning: usize,
    /// Degree of the polynomials of straightness; 1 is none.
    pub straightness: usize,
}

impl Default for Wanted {
    fn default() -> Wanted {
        Wanted { squareness: true, scale: true, backlash: true, rotary: true, positioning: 1, straightness: 1 }
    }
}

/// A task as read.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The file as errors name it.
    pub file: PathBuf,
    /// Folder of the machine, as the task has it.
    pub machine: String,
    /// The control.
    pub dialect: Dialect,
    /// Whether the machine was compensated by its tables while it was probed.
    pub compensated: bool,
    /// The probe.
    pub probe: Probe,
    /// The artefacts.
    pub artefacts: Vec<Artefact>,
    /// The one that shows the drift.
    pub reference: Option<Reference>,
    /// What is to be found.
    pub wanted: Wanted,
}

impl Task {
    /// Reads a task file; `file` is only named in errors.
    ///
    /// # Errors
    /// Text that is no TOML, keys that there are not, values out of their range; with the line.
    pub fn read(text: &str, file: &Path) -> Result<Task, FileError> {
        read_toml(text.strip_prefix('\u{feff}').unwrap_or(text), file, |root| {
            let mut task = Task::of_probing(&root, file)?;
            task.compensated = root.boolean("compensated")?.unwrap_or(false);
            if let Some(section) = root.section("reference")? {
                task.reference = Some(read_reference(section, &task.artefacts)?);
            }
            if let Some(section) = root.section("solve")? {
                task.wanted = read_wanted(section)?;
            }
            root.finish(None)?;
            Ok(task)
        })
    }

    /// Machine, control, probe and artefacts of a file, what else there is in it left to the caller.
    ///
    /// # Errors
    /// As [`Task::read`].
    pub(crate) fn of_probing(root: &Section<'_>, file: &Path) -> Result<Task, FileError> {
        let machine = root.string("machine")?.ok_or_else(|| root.missing("machine", "the machine's folder"))?;
        let words = [("linuxcnc", Dialect::LinuxCnc), ("grblhal", Dialect::GrblHal), ("klipper", Dialect::Klipper)];
        let dialect = root.choice("dialect", words)?;
        let dialect = dialect.ok_or_else(|| root.missing("dialect", "\"linuxcnc\", \"grblhal\" or \"klipper\""))?;
        let probe = root.section("probe")?.ok_or_else(|| root.missing("probe", "a section [probe]"))?;
        let probe = read_probe(probe)?;
        let artefacts = root.sections("artefact")?;
        if artefacts.is_empty() {
            return Err(root.missing("artefact", "at least one section [[artefact]]"));
        }
        let artefacts = artefacts.into_iter().map(read_artefact).collect::<Result<Vec<_>, _>>()?;
        Ok(Task {
            file: file.into(),
            machine: machine.value.to_owned(),
            dialect,
            compensated: false,
            probe,
            artefacts,
            reference: None,
            wanted: Wanted::default(),
        })
    }
}

fn within(
    section: &Section<'_>,
    found: Option<Found<f64>>,
    [low, high]: [f64; 2],
    unit: &str,
) -> Result<Option<f64>, FileError> {
    match found {
        Some(found) if !(low..=high).contains(&found.value) => {
            Err(section.wrong(&found, format!("{low} to {high}{unit}")))
        }
        found => Ok(found.map(|found| found.value)),
    }
}

fn number(section: &Section<'_>, key: &str, range: [f64; 2], unit: &str) -> Result<Option<f64>, FileError> {
    within(section, section.number(key)?, range, unit)
}

fn needed(section: &Section<'_>, key: &str, range: [f64; 2], unit: &str, what: &str) -> Result<f64, FileError> {
    number(section, key, range, unit)?.ok_or_else(|| section.missing_here(key, what))
}

fn whole(section: &Section<'_>, key: &str, [low, high]: [usize; 2], default: usize) -> Result<usize, FileError> {
    match section.number(key)? {
        None => Ok(default),
        Some(found) if found.value.fract() == 0.0 && (low as f64..=high as f64).contains(&found.value) => {
            Ok(found.value as usize)
        }
        Some(found) => Err(section.wrong(&found, format!("a whole number from {low} to {high}"))),
    }
}

fn read_probe(section: Section<'_>) -> Result<Probe, FileError> {
    let mm = |key: &str, range: [f64; 2], default: f64| {
        Ok::<_, FileError>(number(&section, key, range, " mm")?.unwrap_or(default))
    };
    let feed = |key: &str, default: f64| {
        Ok::<_, FileError>(number(&section, key, [1.0, 20_000.0], " mm/min")?.unwrap_or(default))
    };
    let probe = Probe {
        tip_radius_mm: needed(&section, "tip_radius_mm", [0.05, 25.0], " mm", "the radius of the tip, mm")?,
        tip_uncertainty_mm: number(&section, "tip_uncertainty_um", [0.001, 1000.0], " um")?.map(|um| 1e-3 * um),
        pre_travel_mm: 1e-3 * number(&section, "pre_travel_um", [0.0, 1000.0], " um")?.unwrap_or(0.0),
        repeatability_mm: 1e-3 * number(&section, "repeatability_um", [0.01, 1000.0], " um")?.unwrap_or(1.0),
        approach_mm: mm("approach_mm", [0.2, 50.0], 3.0)?,
        overtravel_mm: mm("overtravel_mm", [0.2, 50.0], 3.0)?,
        take_up_mm: mm("take_up_mm", [0.05, 20.0], 1.0)?,
        safe_z_mm: number(&section, "safe_z_mm", [-1e5, 1e5], " mm")?,
        probe_feed_mm_per_min: feed("probe_feed_mm_per_min", 60.0)?,
        feed_mm_per_min: feed("feed_mm_per_min", 1000.0)?,
        repeats: whole(&section, "repeats", [1, 20], 2)?,
    };
    section.finish(None)?;
    Ok(probe)
}

fn read_artefact(section: Section<'_>) -> Result<Artefact, FileError> {
    let line = section.first_line();
    let name = section.string("name")?.ok_or_else(|| section.missing_here("name", "its name"))?.value.to_owned();
    let kind = section.string("kind")?.ok_or_else(|| section.missing_here("kind", KINDS))?;
    let diameter = || needed(&section, "diameter_mm", [0.5, 2000.0], " mm", "its diameter, mm");
    let shape = match kind.value {
        "ring" => {
            let points = whole(&section, "points", [5, 360], 24)?;
            let arc = section.numbers::<2>("arc_deg")?;
            let turn = |[from, to]: [f64; 2]| to - from >= 90.0 && to - from <= 360.0 && from.abs() <= 360.0;
            if let Some(arc) = arc.as_ref().filter(|arc| !turn(arc.value)) {
                return Err(section.wrong(arc, "first and last angle, 90 to 360 degrees apart"));
            }
            Kind::Ring { diameter_mm: diameter()?, points, arc_deg: arc.map_or([0.0, 360.0], |arc| arc.value) }
        }
        "ball" => Kind::Ball { diameter_mm: diameter()? },
        "ball plate" => {
            let balls = section.lists::<3>("balls_mm")?;
            let balls = balls.ok_or_else(|| section.missing_here("balls_mm", "the centres of its balls, mm"))?;
            if !(3..=100).contains(&balls.value.len()) || balls.value.first() != Some(&[0.0; 3]) {
                return Err(section.wrong(&balls, "3 to 100 centres, the first of them [0, 0, 0]"));
            }
            Kind::Plate { diameter_mm: diameter()?, balls_mm: balls.value }
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
            Kind::Square { angle_deg, arms_mm: arms.value, points: whole(&section, "points", [2, 100], 6)? }
        }
        _ => return Err(section.wrong(&kind, KINDS)),
    };
    let uncertainty = if matches!(shape, Kind::Square { .. }) {
        number(&section, "uncertainty_urad", [0.001, 1e5], " urad")?.map(|urad| 1e-6 * urad)
    } else {
        let what = "the standard uncertainty of its size, um";
        Some(1e-3 * needed(&section, "uncertainty_um", [0.001, 1e4], " um", what)?)
    };
    let tolerance_mm = 1e-3 * number(&section, "tolerance_um", [1.0, 1e5], " um")?.unwrap_or(150.0);
    let places = section.sections("place")?;
    if places.is_empty() {
        return Err(section.missing_here("place", "at least one section [[artefact.place]]"));
    }
    let places = places.into_iter().map(|place| read_place(place, &shape)).collect::<Result<_, _>>()?;
    section.finish(None)?;
    Ok(Artefact { name, kind: shape, uncertainty, tolerance_mm, places, line })
}

const KINDS: &str = "\"ring\", \"ball\", \"ball plate\", \"step gauge\" or \"square\"";

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
    let flat = matches!(kind, Kind::Ring { .. } | Kind::Plate { .. } | Kind::Square { .. } | Kind::Gauge { .. });
    let mut place =
        Place { at_mm: at.value, normal: Axis::Z, along: Axis::X, reversed: false, rotary_deg: vec![[0.0; 3]], line };
    if flat {
        place.normal = linear("normal", Axis::Z)?;
    }
    if matches!(kind, Kind::Square { .. } | Kind::Gauge { .. }) {
        let default = if place.normal == Axis::X { Axis::Y } else { Axis::X };
        place.along = linear("along", default)?;
        if place.along == place.normal {
            let found = section.string("along")?.or(section.string("normal")?);
            return Err(found.map_or_else(
                || section.missing_here("along", "another axis than the normal"),
                |found| section.wrong(&found, "another axis than the normal"),
            ));
        }
    }
    if matches!(kind, Kind::Square { .. }) {
        place.reversed = section.boolean("reversed")?.unwrap_or(false);
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

fn read_reference(section: Section<'_>, artefacts: &[Artefact]) -> Result<Reference, FileError> {
    let name = section.string("artefact")?.ok_or_else(|| section.missing("artefact", "the name of a ball"))?;
    let found = artefacts.iter().position(|artefact| artefact.name == name.value);
    let is_still = |artefact: &Artefact| {
        matches!(artefact.kind, Kind::Ball { .. })
            && artefact.places.len() == 1
            && artefact.places[0].rotary_deg[0] == [0.0; 3]
    };
    let found = found.filter(|index| is_still(&artefacts[*index]));
    let found =
        found.ok_or_else(|| section.wrong(&name, "the name of a ball that stays at one place, A, B, C at 0 first"))?;
    let every = whole(&section, "every", [5, 100_000], 60)?;
    section.finish(None)?;
    Ok(Reference { artefact: found, every })
}

fn read_wanted(section: Section<'_>) -> Result<Wanted, FileError> {
    let default = Wanted::default();
    let wanted = Wanted {
        squareness: section.boolean("squareness")?.unwrap_or(default.squareness),
        scale: section.boolean("scale")?.unwrap_or(default.scale),
        backlash: section.boolean("backlash")?.unwrap_or(default.backlash),
        rotary: section.boolean("rotary")?.unwrap_or(default.rotary),
        positioning: whole(&section, "positioning_degree", [1, 8], default.positioning)?,
        straightness: whole(&section, "straightness_degree", [1, 8], default.straightness)?,
    };
    section.finish(None)?;
    Ok(wanted)
}
