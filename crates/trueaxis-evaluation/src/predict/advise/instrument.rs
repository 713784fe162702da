//! `[[instrument]]` and `[probe]` of a part's file: what the owner can measure with, and what it costs.

use crate::calibrate::ranges::number;
use trueaxis::machine::Axis;
use trueaxis_tables::error::FileError;
use trueaxis_tables::{KeyValue, Section};

/// Kind of an instrument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstrumentKind {
    /// Touched with a probe.
    Ball,
    /// Touched with a probe, inside.
    Ring,
    /// Touched with a probe, lying along X or Y.
    GaugeBlock,
    /// Touched with a probe.
    Square,
    /// Circles in both directions.
    Ballbar,
    /// Positions along an axis in both directions.
    Laser,
    /// A task of `calibrate`.
    Task,
}

const WORDS: &str = "\"ball\", \"ring\", \"gauge block\", \"square\", \"ballbar\", \"laser\" or \"task\"";

/// What an instrument has where its section does not say otherwise.
struct Defaults {
    kind: InstrumentKind,
    name: &'static str,
    /// Of one measurement; where a probe is used, of its set-up.
    minutes: f64,
    /// Key of the standard uncertainty, its value, and what it is multiplied by for mm, rad or 1.
    uncertainty: Option<(&'static str, f64, f64)>,
    /// Key and value of its size.
    size: Option<(&'static str, f64)>,
    /// Of a reading, µm; `None`: that of the probe.
    repeatability_um: Option<f64>,
}

const ALL: [Defaults; 7] = {
    use InstrumentKind::{Ball, Ballbar, GaugeBlock, Laser, Ring, Square, Task};
    [
        Defaults {
            kind: Ball,
            name: "ball",
            minutes: 5.0,
            uncertainty: Some(("uncertainty_um", 0.2, 1e-3)),
            size: Some(("diameter_mm", 25.0)),
            repeatability_um: None,
        },
        Defaults {
            kind: Ring,
            name: "ring",
            minutes: 8.0,
            uncertainty: Some(("uncertainty_um", 0.5, 1e-3)),
            size: Some(("diameter_mm", 100.0)),
            repeatability_um: None,
        },
        Defaults {
            kind: GaugeBlock,
            name: "gauge block",
            minutes: 6.0,
            uncertainty: Some(("uncertainty_um", 0.2, 1e-3)),
            size: Some(("length_mm", 100.0)),
            repeatability_um: None,
        },
        Defaults {
            kind: Square,
            name: "square",
            minutes: 10.0,
            uncertainty: Some(("uncertainty_urad", 5.0, 1e-6)),
            size: Some(("arm_mm", 100.0)),
            repeatability_um: None,
        },
        Defaults {
            kind: Ballbar,
            name: "ballbar",
            minutes: 15.0,
            uncertainty: None,
            size: Some(("radius_mm", 100.0)),
            repeatability_um: Some(0.3),
        },
        Defaults {
            kind: Laser,
            name: "laser",
            minutes: 60.0,
            uncertainty: Some(("uncertainty_um_per_m", 0.7, 1e-6)),
            size: None,
            repeatability_um: Some(0.2),
        },
        Defaults { kind: Task, name: "task", minutes: 10.0, uncertainty: None, size: None, repeatability_um: None },
    ]
};

/// An instrument.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    /// Kind.
    pub kind: InstrumentKind,
    /// Name, that of the kind or of a task's file unless stated.
    pub name: String,
    /// Duration of one measurement; of a task or artefact: of one set-up, without the probing.
    pub minutes: f64,
    /// Standard uncertainty of its size: mm, of a square rad, of a laser by length.
    pub uncertainty: f64,
    /// Diameter, length, arm or radius, mm.
    pub size_mm: f64,
    /// Standard deviation of a reading, mm; of an artefact that of the probe.
    pub repeatability_mm: Option<f64>,
    /// Where it is in the machine, X, Y, Z, mm; `None`: about the part's middle.
    pub at_mm: Option<[f64; 3]>,
    /// Axes: along which a block or laser lies, or across which a ring, square or circle lies.
    pub axes: Vec<Axis>,
    /// File of a task, beside the part's.
    pub file: Option<String>,
    /// Line in the file.
    pub line: u32,
}

/// The probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Touching {
    /// Dialect of the control, as in a task.
    pub dialect: String,
    /// Radius of the tip, mm.
    pub tip_radius_mm: f64,
    /// Standard uncertainty of the effective radius, mm: a ball determines it better.
    pub tip_uncertainty_mm: f64,
    /// Standard deviation of a touch, mm.
    pub repeatability_mm: f64,
}

impl Default for Touching {
    fn default() -> Self {
        let dialect = String::from("linuxcnc");
        Touching { dialect, tip_radius_mm: 3.0, tip_uncertainty_mm: 0.02, repeatability_mm: 0.5e-3 }
    }
}

impl InstrumentKind {
    fn defaults(self) -> &'static Defaults {
        ALL.iter().find(|own| own.kind == self).unwrap_or(&ALL[0])
    }

    /// Axes along or across which it is used unless stated.
    fn usual(self) -> Vec<Axis> {
        match self {
            InstrumentKind::Ring => vec![Axis::Z],
            InstrumentKind::GaugeBlock => vec![Axis::X, Axis::Y],
            InstrumentKind::Square | InstrumentKind::Ballbar => vec![Axis::Z, Axis::X, Axis::Y],
            InstrumentKind::Laser => vec![Axis::X, Axis::Y, Axis::Z],
            InstrumentKind::Ball | InstrumentKind::Task => Vec::new(),
        }
    }
}

/// Reads `[probe]`.
pub(in super::super) fn read_probe(section: Section<'_>) -> Result<Touching, FileError> {
    let mut probe = Touching::default();
    let words = ["linuxcnc", "grblhal", "klipper"].map(|word| (word, word));
    if let Some(dialect) = section.choice("dialect", words)? {
        dialect.clone_into(&mut probe.dialect);
    }
    if let Some(mm) = number(&section, "tip_radius_mm", [0.05, 25.0], " mm")? {
        probe.tip_radius_mm = mm;
    }
    if let Some(um) = number(&section, "tip_uncertainty_um", [0.001, 1000.0], " um")? {
        probe.tip_uncertainty_mm = 1e-3 * um;
    }
    if let Some(um) = number(&section, "repeatability_um", [0.01, 1000.0], " um")? {
        probe.repeatability_mm = 1e-3 * um;
    }
    section.finish(None)?;
    Ok(probe)
}

/// Reads `[[instrument]]`.
pub(in super::super) fn read_instrument(section: Section<'_>) -> Result<Instrument, FileError> {
    let line = section.first_line();
    let kind = section.choice("kind", ALL.each_ref().map(|own| (own.name, own.kind)))?;
    let kind = kind.ok_or_else(|| section.missing_here("kind", WORDS))?;
    let own = kind.defaults();
    let name = section.string("name")?.map(|found| found.value.to_owned());
    let minutes = number(&section, "minutes", [0.1, 10_000.0], " minutes")?.unwrap_or(own.minutes);
    let uncertainty = match own.uncertainty {
        Some((key, value, factor)) => factor * number(&section, key, [0.001, 1e4], "")?.unwrap_or(value),
        None => 0.0,
    };
    let size_mm = match own.size {
        Some((key, value)) => number(&section, key, [5.0, 2000.0], " mm")?.unwrap_or(value),
        None => 0.0,
    };
    let mut repeatability_mm = None;
    if let Some(um) = own.repeatability_um {
        repeatability_mm = Some(1e-3 * number(&section, "repeatability_um", [0.01, 1000.0], " um")?.unwrap_or(um));
    }
    let mut at_mm = None;
    let mut file = None;
    if kind == InstrumentKind::Task {
        let found = section.string("file")?.ok_or_else(|| section.missing_here("file", "a task of calibrate"))?;
        file = Some(found.value.to_owned());
    } else if let Some(found) = section.numbers::<3>("at_mm")? {
        if found.value.iter().any(|q| q.abs() > 1e5) {
            return Err(section.wrong(&found, "at most 100000 mm"));
        }
        at_mm = Some(found.value);
    }
    let axes = read_axes(&section, kind)?;
    section.finish(None)?;
    let name = name.or_else(|| file.clone()).unwrap_or_else(|| own.name.into());
    Ok(Instrument { kind, name, minutes, uncertainty, size_mm, repeatability_mm, at_mm, axes, file, line })
}

/// `along` of blocks and lasers; `planes` of rings, squares and circles, as the axes across them.
fn read_axes(section: &Section<'_>, kind: InstrumentKind) -> Result<Vec<Axis>, FileError> {
    let is_along = matches!(kind, InstrumentKind::GaugeBlock | InstrumentKind::Laser);
    let words: &[(&str, Axis)] = match kind {
        InstrumentKind::GaugeBlock => &[("X", Axis::X), ("Y", Axis::Y)],
        InstrumentKind::Laser => &[("X", Axis::X), ("Y", Axis::Y), ("Z", Axis::Z)],
        InstrumentKind::Ring => &[("XY", Axis::Z)],
        InstrumentKind::Square | InstrumentKind::Ballbar => &[("XY", Axis::Z), ("YZ", Axis::X), ("ZX", Axis::Y)],
        InstrumentKind::Ball | InstrumentKind::Task => return Ok(Vec::new()),
    };
    let Some(found) = section.strings(if is_along { "along" } else { "planes" })? else { return Ok(kind.usual()) };
    let mut axes = Vec::new();
    for name in &found.value {
        let one = words.iter().find(|(word, axis)| word == name && !axes.contains(axis));
        let names: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        let needed = format!("each once of {}", names.join(", "));
        axes.push(one.ok_or_else(|| section.wrong(&as_text(&found, name), needed))?.1);
    }
    if axes.is_empty() {
        return Err(section.wrong(&found, "at least one"));
    }
    Ok(axes)
}

fn as_text<'a>(found: &KeyValue<Vec<&'a str>>, value: &'a str) -> KeyValue<&'a str> {
    KeyValue { value, line: found.line, key: found.key.clone(), text: found.text.clone() }
}
