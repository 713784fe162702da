//! A task: machine, probe, artefacts, and the terms to determine.

use super::artefact::{Artefact, Kind, read_artefact, read_dial, read_plate};
use super::dial::DialKind;
use super::ranges::{needed, number, whole};
use super::wishes::{Wishes, read_wishes};
use std::path::{Path, PathBuf};
use trueaxis_tables::error::FileError;
use trueaxis_tables::{Section, read_toml};

/// Standard uncertainty of a tip that no touch determines, mm.
const TIP_MM: f64 = 0.01;
/// Standard deviation of a coefficient of an angular error, rad, unless the task states it.
const ANGLE_RANGE: f64 = 20e-6;
/// Degree of curves that have every shape that a plate shows.
const ALL: usize = u8::MAX as usize;

/// Dialect of a control: how it probes and logs.
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
    /// Name of the dialect in a task file.
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
    /// Standard uncertainty of the effective radius, mm; `None` if the artefacts are to determine it.
    pub tip_uncertainty_mm: Option<f64>,
    /// How far the tip deflects before the trip, mm: the effective radius is smaller by this.
    pub pre_travel_mm: f64,
    /// Standard deviation of a touch, mm.
    pub repeatability_mm: f64,
    /// Distance before the surface at which a probing move starts, mm.
    pub approach_mm: f64,
    /// Distance beyond the surface at which it ends, mm.
    pub overtravel_mm: f64,
    /// Travel over which an axis takes up its lost motion before a touch, mm.
    pub take_up_mm: f64,
    /// Z position at which the probe travels between places, mm.
    pub safe_z_mm: Option<f64>,
    /// Feed of a probing move, mm/min.
    pub probe_feed_mm_per_min: f64,
    /// Feed of the other moves near an artefact, mm/min.
    pub feed_mm_per_min: f64,
    /// Number of touches at every point.
    pub repeats: usize,
}

/// The artefact that is touched repeatedly to track drift.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Index of a ball.
    pub artefact: usize,
    /// Number of touches between visits to it, in addition to those before and after every set-up.
    pub every: usize,
}

/// Terms to determine, as far as the artefacts allow.
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
    /// Degree of the polynomial for an axis' positioning error; 1 is the scale.
    pub positioning: usize,
    /// Degree of the polynomials for straightness; 1 means none.
    pub straightness: usize,
    /// Degree of the polynomials for roll, pitch and yaw of the linear axes; 0 means none.
    pub angle: usize,
    /// Standard deviation of each coefficient of these polynomials before anything is measured, rad.
    pub angle_range: f64,
    /// The same of the polynomials of positioning and straightness from the second degree on, mm; `None`: they are free.
    pub curve_range: Option<f64>,
}

impl Default for Wanted {
    fn default() -> Wanted {
        Wanted {
            squareness: true,
            scale: true,
            backlash: true,
            rotary: true,
            positioning: 1,
            straightness: 1,
            angle: 0,
            angle_range: ANGLE_RANGE,
            curve_range: None,
        }
    }
}

/// A task as read.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Path of the task file, for errors.
    pub file: PathBuf,
    /// Folder of the machine, as the task states it.
    pub machine: String,
    /// The control.
    pub dialect: Dialect,
    /// Whether the machine's tables compensated it during probing.
    pub compensated: bool,
    /// The probe.
    pub probe: Probe,
    /// The artefacts.
    pub artefacts: Vec<Artefact>,
    /// The artefact that tracks drift.
    pub reference: Option<Reference>,
    /// Terms to determine.
    pub wanted: Wanted,
    /// What placements may be chosen from.
    pub wishes: Wishes,
}

/// The words for one observation and for several.
pub(super) fn words(is_read: bool) -> [&'static str; 2] {
    if is_read { ["reading", "readings"] } else { ["touch", "touches"] }
}

impl Task {
    /// Whether the task has readings of dials instead of touches.
    pub fn is_read(&self) -> bool {
        self.artefacts.iter().any(|artefact| artefact.dial().is_some())
    }

    /// The plate of unknown places.
    pub(crate) fn plate(&self) -> Option<&Artefact> {
        self.artefacts.iter().find(|artefact| artefact.grid().is_some())
    }

    /// The word for an observation.
    pub fn word(&self) -> &'static str {
        words(self.is_read())[0]
    }

    /// The word for several of them.
    pub fn words(&self) -> &'static str {
        words(self.is_read())[1]
    }

    /// Reads a task file; `file` is used only in errors.
    ///
    /// # Errors
    /// Invalid TOML, unknown keys or values out of their range, with the line.
    pub fn read(text: &str, file: &Path) -> Result<Task, FileError> {
        Task::read_whole(text, file, false)
    }

    /// Reads a task whose artefacts may lack their places, to be chosen.
    ///
    /// # Errors
    /// As [`Task::read`].
    pub fn read_open(text: &str, file: &Path) -> Result<Task, FileError> {
        Task::read_whole(text, file, true)
    }

    fn read_whole(text: &str, file: &Path, is_open: bool) -> Result<Task, FileError> {
        read_toml(text.strip_prefix('\u{feff}').unwrap_or(text), file, |root| {
            let dials = root.sections("dial")?;
            let plates = root.sections("plate")?;
            let mut task = match (dials.is_empty(), plates.is_empty()) {
                (true, true) => Task::probing(&root, file, [false, is_open])?,
                (true, false) => Task::of_plate(&root, plates, file)?,
                (false, true) => Task::of_dials(&root, dials, file)?,
                (false, false) => {
                    let line = plates.first().map_or(0, Section::first_line);
                    return Err(root.at(
                        line,
                        "plate",
                        "a plate beside a dial",
                        "touches and readings of a dial in two tasks",
                    ));
                }
            };
            task.compensated = root.boolean("compensated")?.unwrap_or(false);
            if let Some(section) = root.section("reference")? {
                task.reference = Some(read_reference(section, &task.artefacts)?);
            }
            if let Some(section) = root.section("plan")? {
                task.wishes = read_wishes(section)?;
            }
            if let Some(section) = root.section("solve")? {
                task.wanted = read_wanted(section, &task)?;
            }
            few_points(&root, &task)?;
            styli_hold(&root, &task)?;
            root.finish(None)?;
            Ok(task)
        })
    }

    fn of_dials(root: &Section<'_>, dials: Vec<Section<'_>>, file: &Path) -> Result<Task, FileError> {
        let machine = root.string("machine")?.ok_or_else(|| root.missing("machine", "the machine's folder"))?;
        if let Some(touched) = root.sections("artefact")?.first() {
            let needed = "touches and readings of a dial in two tasks";
            return Err(root.at(touched.first_line(), "artefact", "an artefact beside a dial", needed));
        }
        let what = "the standard deviation of a reading, um";
        let section = root.section("indicator")?.ok_or_else(|| root.missing("indicator.repeatability_um", what))?;
        let repeatability_mm = 1e-3 * needed(&section, "repeatability_um", [0.01, 1000.0], " um", what)?;
        section.finish(None)?;
        let artefacts = dials.into_iter().map(read_dial).collect::<Result<Vec<_>, _>>()?;
        Ok(Task {
            file: file.into(),
            machine: machine.value.to_owned(),
            dialect: Dialect::LinuxCnc,
            compensated: false,
            probe: Probe {
                // The dial's zero is unknown; nothing else is between machine and face.
                tip_radius_mm: 0.0,
                tip_uncertainty_mm: Some(1e-9),
                pre_travel_mm: 0.0,
                repeatability_mm,
                approach_mm: 1.0,
                overtravel_mm: 1.0,
                take_up_mm: 1.0,
                safe_z_mm: None,
                probe_feed_mm_per_min: 60.0,
                feed_mm_per_min: 1000.0,
                repeats: 1,
            },
            artefacts,
            reference: None,
            wishes: Wishes::default(),
            wanted: Wanted { straightness: 3, scale: false, backlash: false, rotary: false, ..Wanted::default() },
        })
    }

    /// Reads machine, control, probe and artefacts from a file; the caller reads the remaining keys.
    ///
    /// # Errors
    /// As [`Task::read`].
    pub(crate) fn of_probing(root: &Section<'_>, file: &Path) -> Result<Task, FileError> {
        Task::probing(root, file, [false; 2])
    }

    /// Reads a task with a plate of unknown places, beside which there are only balls, for the drift.
    fn of_plate(root: &Section<'_>, plates: Vec<Section<'_>>, file: &Path) -> Result<Task, FileError> {
        let mut task = Task::probing(root, file, [true, false])?;
        if let Some(other) = task.artefacts.iter().find(|of| !matches!(of.kind, Kind::Ball { .. })) {
            let needed = "only balls beside a plate of unknown places; certified artefacts in another task";
            return Err(root.at(other.line, "artefact.kind", &other.name, needed));
        }
        if let Some(second) = plates.get(1) {
            let needed = "one plate, its placements in [[plate.placement]]; another plate in another task";
            return Err(root.at(second.first_line(), "plate", "a second plate", needed));
        }
        // A ball shows lost motion, the middles of a plate do not.
        let backlash = !task.artefacts.is_empty();
        if !backlash {
            // Nor do they depend on the tip.
            task.probe.tip_uncertainty_mm.get_or_insert(TIP_MM);
        }
        task.artefacts.extend(plates.into_iter().map(read_plate).collect::<Result<Vec<_>, _>>()?);
        task.wanted = Wanted { backlash, rotary: false, positioning: ALL, straightness: ALL, ..task.wanted };
        Ok(task)
    }

    /// `beside`: whether there may be no artefact; `is_open`: whether an artefact may have no place.
    fn probing(root: &Section<'_>, file: &Path, [beside, is_open]: [bool; 2]) -> Result<Task, FileError> {
        let machine = root.string("machine")?.ok_or_else(|| root.missing("machine", "the machine's folder"))?;
        let words = [("linuxcnc", Dialect::LinuxCnc), ("grblhal", Dialect::GrblHal), ("klipper", Dialect::Klipper)];
        let dialect = root.choice("dialect", words)?;
        let dialect = dialect.ok_or_else(|| root.missing("dialect", "\"linuxcnc\", \"grblhal\" or \"klipper\""))?;
        let probe = root.section("probe")?.ok_or_else(|| root.missing("probe", "a section [probe]"))?;
        let probe = read_probe(probe)?;
        let artefacts = root.sections("artefact")?;
        if artefacts.is_empty() && !beside {
            return Err(root.missing("artefact", "at least one section [[artefact]]"));
        }
        let artefacts = artefacts.into_iter().try_fold(Vec::new(), |mut before, section| {
            before.push(read_artefact(section, &before, is_open)?);
            Ok(before)
        })?;
        Ok(Task {
            file: file.into(),
            machine: machine.value.to_owned(),
            dialect,
            compensated: false,
            probe,
            artefacts,
            reference: None,
            wishes: Wishes::default(),
            wanted: Wanted::default(),
        })
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
        repeats: whole(&section, "repeats", [1, 20])?.unwrap_or(2),
    };
    section.finish(None)?;
    Ok(probe)
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
    let found = found.ok_or_else(|| section.wrong(&name, "the name of a ball at one place, with A, B, C = 0 first"))?;
    let every = whole(&section, "every", [5, 100_000])?.unwrap_or(60);
    section.finish(None)?;
    Ok(Reference { artefact: found, every })
}

/// Refuses a straight face with too few readings for the polynomial to be found along it.
fn few_points(root: &Section<'_>, task: &Task) -> Result<(), FileError> {
    for of in &task.artefacts {
        if let Some(DialKind::Straightness { points, .. }) = of.dial().map(|dial| dial.kind)
            && points <= task.wanted.straightness
        {
            let degree = task.wanted.straightness;
            let needed = format!("at least {}, one more than straightness_degree ({degree})", degree + 1);
            return Err(root.at(of.line, "dial.points", &points.to_string(), needed));
        }
    }
    Ok(())
}

/// Refuses styli of stated lengths on a corrected machine: the control's tables know one tool.
fn styli_hold(root: &Section<'_>, task: &Task) -> Result<(), FileError> {
    let mut places = task.artefacts.iter().flat_map(|artefact| &artefact.places);
    match places.find(|place| place.stylus_mm.is_some()) {
        Some(place) if task.compensated => {
            let needed = "compensated = false with stylus_mm: the correction would need the length of each stylus";
            Err(root.at(place.line, "artefact.place.stylus_mm", "a stylus on a compensated machine", needed))
        }
        _ => Ok(()),
    }
}

fn read_wanted(section: Section<'_>, task: &Task) -> Result<Wanted, FileError> {
    let default = task.wanted;
    if task.plate().is_some() && !default.backlash && section.boolean("backlash")? == Some(true) {
        let needed = "false, or a ball beside the plate: lost motion cancels in the middle of two opposite touches";
        return Err(section.at(section.first_line(), "backlash", "true", needed));
    }
    for key in ["scale", "backlash", "rotary"] {
        if task.is_read() && section.boolean(key)? == Some(true) {
            return Err(section.at(section.first_line(), key, "true", "false: no reading of a dial shows it"));
        }
    }
    let angle = whole(&section, "angular_degree", [0, 8])?;
    if let Some(found) = section.number("angular_degree")?.filter(|degree| degree.value > 0.0)
        && (task.is_read() || task.plate().is_some())
    {
        return Err(section.wrong(&found, "0: roll, pitch and yaw are determined by touches on certified artefacts"));
    }
    let range = number(&section, "angular_range_urad", [0.01, 1e4], " urad")?.map(|urad| 1e-6 * urad);
    let curve_range = section.number("curve_range_um")?;
    if let Some(found) = curve_range.filter(|_| task.plate().is_some()) {
        return Err(section.wrong(
            &found,
            "no curve_range_um with a plate of unknown places: its placements must separate the curves",
        ));
    }
    let wanted = Wanted {
        angle: angle.unwrap_or(default.angle),
        angle_range: range.unwrap_or(default.angle_range),
        curve_range: number(&section, "curve_range_um", [0.01, 1e4], " um")?.map(|um| 1e-3 * um),
        squareness: section.boolean("squareness")?.unwrap_or(default.squareness),
        scale: section.boolean("scale")?.unwrap_or(default.scale),
        backlash: section.boolean("backlash")?.unwrap_or(default.backlash),
        rotary: section.boolean("rotary")?.unwrap_or(default.rotary),
        positioning: whole(&section, "positioning_degree", [1, 8])?.unwrap_or(default.positioning),
        straightness: whole(&section, "straightness_degree", [1, 8])?.unwrap_or(default.straightness),
    };
    section.finish(None)?;
    Ok(wanted)
}
