//! `keep.toml`: machine, probe, balls, the terms that may change, and their bounds.

use crate::calibrate::ranges::{number, whole};
use crate::calibrate::{Kind, Reference, Task, Term, Wanted};
use std::path::Path;
use trueaxis::machine::Axis;
use trueaxis_tables::error::FileError;
use trueaxis_tables::{Machine, Section, read_toml};

/// Bounds that can be stated, µm, µrad or ppm: anything larger calls for a calibration.
const BOUNDS: std::ops::RangeInclusive<f64> = 0.001..=1000.0;
/// Touches between two visits to the first ball: enough that it is visited only at the ends.
const AT_THE_ENDS: usize = 100_000;

/// Which file holds a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// `machine.toml` and the tables that it names.
    Machine,
    /// `thermal.toml`.
    Thermal,
}

/// How far a term may be changed, in mm, rad or 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest single update.
    pub update: f64,
    /// Largest sum of updates since the beginning.
    pub total: f64,
    /// A term has moved if it differs from zero by more than this many standard errors.
    pub significance: f64,
}

/// A term that may be changed.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptTerm {
    /// Name in the task.
    pub name: String,
    /// The term.
    pub term: Term,
    /// File that holds the term.
    pub home: Home,
    /// Bounds of the term.
    pub bounds: Bounds,
    /// Line of the section.
    pub line: u32,
}

/// A task as read.
#[derive(Clone, Debug, PartialEq)]
pub struct KeepTask {
    /// Machine, control, probe and balls; compensated during probing.
    pub probing: Task,
    /// Number of parts between two probings.
    pub every_parts: u32,
    /// Terms that may change.
    pub terms: Vec<KeptTerm>,
    /// Controller file in the machine's folder, recompiled with every change.
    pub tcomp: Option<String>,
    /// Thermal model in the machine's folder, if terms of growth change it.
    pub thermal: Option<String>,
    /// Controller file of the thermal model, recompiled with every change.
    pub ttherm: Option<String>,
}

impl KeepTask {
    /// Reads a task file; `file` is used only in errors.
    ///
    /// # Errors
    /// Invalid TOML, unknown keys, artefacts other than balls, a term without bounds or with bounds that do not bound; with
    /// the line.
    pub fn read(text: &str, file: &Path) -> Result<KeepTask, FileError> {
        read_toml(text.strip_prefix('\u{feff}').unwrap_or(text), file, |root| {
            let mut probing = Task::of_probing(&root, file)?;
            for artefact in &probing.artefacts {
                let stays = matches!(artefact.kind, Kind::Ball { .. }) && artefact.places.len() == 1;
                if !stays {
                    let found = format!("{}, which is not a ball at a fixed place", artefact.name);
                    return Err(root.at(artefact.line, "artefact", &found, "balls, each at one place"));
                }
            }
            let first = &probing.artefacts[0].places[0];
            if first.rotary_deg.first() != Some(&[0.0; 3]) {
                let found = "a first ball that is not measured at A, B, C = 0 first";
                return Err(root.at(first.line, "artefact.place.rotary_deg", found, "[0, 0, 0] first"));
            }
            probing.compensated = true;
            probing.reference = Some(Reference { artefact: 0, every: AT_THE_ENDS });
            let every = whole(&root, "every_parts", [1, 1_000_000])?;
            let every =
                every.ok_or_else(|| root.missing("every_parts", "the number of parts between two re-probings"))?;
            let [tcomp, thermal, ttherm] = [("tcomp", ".tcomp"), ("thermal", ".toml"), ("ttherm", ".ttherm")]
                .map(|(key, ending)| file_name(&root, key, ending));
            let (tcomp, thermal, ttherm) = (tcomp?, thermal?, ttherm?);
            if thermal.is_none() && ttherm.is_some() {
                return Err(root.missing("thermal", "the thermal.toml that ttherm is compiled from"));
            }
            let mut terms: Vec<KeptTerm> = Vec::new();
            for section in root.sections("term")? {
                read_terms(section, &mut terms, thermal.is_some())?;
            }
            if terms.is_empty() {
                return Err(root.missing("term", "at least one section [[term]] with names and bounds"));
            }
            let backlash = terms.iter().any(|kept| matches!(kept.term, Term::Backlash(_)));
            probing.wanted = Wanted { backlash, ..Wanted::default() };
            root.finish(None)?;
            Ok(KeepTask { probing, every_parts: every as u32, terms, tcomp, thermal, ttherm })
        })
    }

    /// Refuses terms of axes that the machine lacks.
    ///
    /// # Errors
    /// The first such term, with the line of its section.
    pub fn fits(&self, machine: &Machine) -> Result<(), FileError> {
        let has = |axis: Axis| machine.settings.axis(axis).is_some();
        for kept in &self.terms {
            let missing = match kept.term {
                Term::Squareness(which) => match which {
                    0 => [Axis::X, Axis::Y],
                    1 => [Axis::X, Axis::Z],
                    _ => [Axis::Y, Axis::Z],
                }
                .into_iter()
                .find(|axis| !has(*axis)),
                Term::Curve { axis, .. } | Term::Backlash(axis) | Term::Location(axis, _) => {
                    Some(axis).filter(|axis| !has(*axis))
                }
            };
            if let Some(axis) = missing {
                return Err(FileError {
                    file: self.probing.file.clone(),
                    line: Some(kept.line),
                    column: Some("key term.names".into()),
                    found: format!("{:?}", kept.name),
                    needed: format!("terms of the chain {}, which has no {}", machine.settings.chain, axis.letter()),
                });
            }
        }
        Ok(())
    }

    /// Whether a ball is rotated, so that it determines location errors without its position being known.
    pub fn turns(&self) -> bool {
        self.probing.artefacts.iter().any(|ball| ball.places.iter().any(|place| place.rotary_deg.len() > 1))
    }
}

/// Reads the name of a file in the machine's folder.
fn file_name(root: &Section<'_>, key: &str, ending: &str) -> Result<Option<String>, FileError> {
    let Some(found) = root.string(key)? else { return Ok(None) };
    let plain = Path::new(found.value).components().count() == 1 && found.value.ends_with(ending);
    let own = plain && found.value.len() > ending.len() && found.value != "machine.toml";
    let needed = || format!("the name of a {ending} file in the machine's folder");
    if own { Ok(Some(found.value.to_owned())) } else { Err(root.wrong(&found, needed())) }
}

/// Names of terms in a task.
const NAMES: &str =
    "names like \"EX0C\", \"C0Y\", \"offset X\", \"scale X\", \"backlash X\", \"growth X\" or \"expansion X\"";

fn read_terms(section: Section<'_>, terms: &mut Vec<KeptTerm>, thermal: bool) -> Result<(), FileError> {
    let line = section.first_line();
    let names = section.strings("names")?.ok_or_else(|| section.missing_here("names", NAMES))?;
    let mut named = Vec::new();
    for name in &names.value {
        let (term, home) = parse(name).ok_or_else(|| section.wrong(&names, NAMES))?;
        if home == Home::Thermal && !thermal {
            let found = format!("{name:?} without a thermal model");
            return Err(section.at(
                names.line,
                "names",
                &found,
                "thermal = \"thermal.toml\", or \"offset\" and \"scale\"",
            ));
        }
        if terms.iter().map(|kept| kept.term).chain(named.iter().map(|(_, term, _)| *term)).any(|own| own == term) {
            return Err(section.at(names.line, "names", &format!("{name:?} a second time"), "every term once"));
        }
        named.push((*name, term, home));
    }
    let Some((_, first, _)) = named.first() else { return Err(section.wrong(&names, NAMES)) };
    let (shown, factor) = first.unit();
    if named.iter().any(|(_, term, _)| term.unit().0 != shown) {
        return Err(section.wrong(&names, "terms of one unit, as their bounds have one"));
    }
    let unit = match shown {
        "µm" => "um",
        "µrad" => "urad",
        other => other,
    };
    let bound = |what: &str, of: &str| {
        let key = format!("{what}_{unit}");
        let found = section.number(&key)?;
        let found = found.ok_or_else(|| section.missing_here(&key, &format!("{of}, {shown}")))?;
        if BOUNDS.contains(&found.value) {
            Ok(found)
        } else {
            Err(section.wrong(&found, format!("0.001 to 1000 {shown}: a larger change needs a calibration")))
        }
    };
    let update = bound("largest_update", "the largest single update")?;
    let total = bound("largest_total", "the largest sum of updates since the beginning")?;
    if total.value < update.value {
        return Err(section.wrong(&total, format!("at least {}, the largest single update", update.value)));
    }
    let significance = number(&section, "significance", [1.0, 20.0], " standard errors")?.unwrap_or(3.0);
    let bounds = Bounds { update: update.value / factor, total: total.value / factor, significance };
    terms.extend(named.into_iter().map(|(name, term, home)| KeptTerm { name: name.into(), term, home, bounds, line }));
    section.finish(None)
}

fn parse(name: &str) -> Option<(Term, Home)> {
    let machine = |term| Some((term, Home::Machine));
    if let Some(which) = ["C0Y", "B0Z", "A0Z"].iter().position(|known| *known == name) {
        return machine(Term::Squareness(which as u8));
    }
    let letter = |text: &str| {
        let mut letters = text.chars();
        letters.next().filter(|_| letters.next().is_none()).and_then(Axis::from_letter)
    };
    if let Some((what, axis)) = name.split_once(' ') {
        let axis = letter(axis).filter(|axis| !axis.is_rotary())?;
        let curve = |degree| Term::Curve { axis, component: axis.index() as u8, degree };
        return match what {
            "offset" => machine(curve(0)),
            "scale" => machine(curve(1)),
            "backlash" => machine(Term::Backlash(axis)),
            "growth" => Some((curve(0), Home::Thermal)),
            "expansion" => Some((curve(1), Home::Thermal)),
            _ => None,
        };
    }
    let (direction, axis) = name.strip_prefix('E')?.split_once('0')?;
    let (direction, axis) = (letter(direction)?, letter(axis).filter(|axis| axis.is_rotary())?);
    machine(Term::Location(axis, direction.index() as u8))
}
