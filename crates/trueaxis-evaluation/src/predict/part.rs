//! `PART.toml`: where a part stands, its features by lines of the program, and its tolerances.

use super::advise::instrument::{Instrument, Touching, read_instrument, read_probe};
use super::fixture::{Setup, Tool, named};
use super::gear::{self, GearFlank};
pub use super::kinds::{Association, Characteristic, FeatureKind, Side};
use super::temperature::{Growth, GrowthModel, PartTemperature, read_temperature};
use crate::calibrate::ranges::number;
use anyhow::bail;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use trueaxis_sim::program::Program;
use trueaxis_tables::error::FileError;
use trueaxis_tables::{KeyValue, Machine, Section, read_toml};

/// A feature of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Name, as tolerances refer to it.
    pub name: String,
    /// Kind.
    pub kind: FeatureKind,
    /// First and last line of the program that cuts it.
    pub lines: [u32; 2],
    /// Index of the set-up in which it is cut; none for the first.
    pub setup: Option<usize>,
    /// Index of its tool.
    pub tool: Option<usize>,
    /// Where the tool or the material is.
    pub side: Option<Side>,
    /// The gear of a flank.
    pub gear: Option<GearFlank>,
    /// Line in the file.
    pub line: u32,
}

/// A tolerance of a feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerance {
    /// Index of the feature.
    pub feature: usize,
    /// What it limits.
    pub characteristic: Characteristic,
    /// How a form is associated; least squares for all others.
    pub association: Association,
    /// Least and greatest value, mm; a zone has no least.
    pub limits: [f64; 2],
    /// Indices of the datums in their order; of a distance: the feature it starts from.
    pub datums: Vec<usize>,
    /// Line in the file.
    pub line: u32,
}

/// A part as read.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Path of the file, for errors.
    pub file: PathBuf,
    /// Name of the part.
    pub name: String,
    /// The program, as the file states it.
    pub program: Option<String>,
    /// Program zero in machine coordinates X, Y, Z, mm.
    pub at_mm: [f64; 3],
    /// Further set-ups in the order of the file, which is that of cutting.
    pub setups: Vec<Setup>,
    /// Tools.
    pub tools: Vec<Tool>,
    /// Features in the order of the file.
    pub features: Vec<Feature>,
    /// Tolerances in the order of the file.
    pub tolerances: Vec<Tolerance>,
    /// What the owner can measure with.
    pub instruments: Vec<Instrument>,
    /// The probe.
    pub probe: Touching,
    /// Temperatures while it is cut.
    pub temperature: PartTemperature,
    /// Growth of the machine while it is cut, by a record or a thermal.toml; otherwise from `temperature.machine_c` and
    /// `[axis.X.thermal]` of the machine.
    pub growth: Option<Growth>,
}

/// Most features, and most tolerances.
const MOST: usize = 200;
/// Widest zone, and largest limit, mm.
const WIDEST: f64 = 10.0;

impl Part {
    /// Checks what [`advise`](super::advise()) needs before anything is computed.
    ///
    /// # Errors
    /// A part without instruments.
    pub fn require_instruments(&self) -> anyhow::Result<()> {
        if self.instruments.is_empty() {
            bail!(
                "{}: key instrument: found nothing, needed at least one section [[instrument]], such as kind = \"ball\"",
                self.file.display()
            );
        }
        Ok(())
    }

    /// Reads a part; `file` is used only in errors.
    ///
    /// # Errors
    /// Invalid TOML, unknown keys, values out of their range, tolerances that their feature cannot have, with the line.
    pub fn read(text: &str, file: &Path) -> Result<Part, FileError> {
        read_toml(text, file, |root| {
            let name = root.string("name")?.ok_or_else(|| root.missing("name", "the part's name"))?.value.to_owned();
            let program = root.string("program")?.map(|found| found.value.to_owned());
            let at = root.numbers::<3>("at_mm")?;
            let at = at.ok_or_else(|| root.missing("at_mm", "X, Y, Z of the machine at the program's zero, mm"))?;
            if at.value.iter().any(|q| q.abs() > 1e5) {
                return Err(root.wrong(&at, "at most 100000 mm"));
            }
            let setups = all(&root, "setup")?.into_iter().map(Setup::read).collect::<Result<Vec<_>, _>>()?;
            let tools = all(&root, "tool")?.into_iter().map(Tool::read).collect::<Result<Vec<_>, _>>()?;
            let twice = |names: Vec<&str>| (1..names.len()).find(|k| names[..*k].contains(&names[*k]));
            if let Some(double) = twice(setups.iter().map(|own| own.name.as_str()).collect()) {
                let double = &setups[double];
                return Err(root.at(double.line, "setup.name", &double.name, "a name that no other set-up has"));
            }
            if let Some(double) = twice(tools.iter().map(|own| own.name.as_str()).collect()) {
                let double = &tools[double];
                return Err(root.at(double.line, "tool.name", &double.name, "a name that no other tool has"));
            }
            let feature = |section| read_feature(section, &setups, &tools);
            let features = all(&root, "feature")?.into_iter().map(feature).collect::<Result<Vec<_>, _>>()?;
            if let Some(double) = twice(features.iter().map(|own| own.name.as_str()).collect()) {
                let double = &features[double];
                return Err(root.at(double.line, "feature.name", &double.name, "a name that no other feature has"));
            }
            let tolerances = all(&root, "tolerance")?;
            let tolerances =
                tolerances.into_iter().map(|one| read_tolerance(one, &features)).collect::<Result<_, _>>()?;
            let instruments = all(&root, "instrument")?.into_iter().map(read_instrument).collect::<Result<_, _>>()?;
            let probe = root.section("probe")?.map_or_else(|| Ok(Touching::default()), read_probe)?;
            let temperature = root.section("temperature")?;
            let temperature = temperature.map_or_else(|| Ok(PartTemperature::default()), read_temperature)?;
            root.finish(None)?;
            let (file, at_mm, growth) = (file.into(), at.value, None);
            Ok(Part {
                file,
                name,
                program,
                at_mm,
                setups,
                tools,
                features,
                tolerances,
                instruments,
                probe,
                temperature,
                growth,
            })
        })
    }

    /// The part cut on a machine of constant temperature, °C, in place of the temperature or record that it had.
    ///
    /// # Errors
    /// As [`Growth::constant`].
    pub fn at_temperature(self, model: GrowthModel, machine_c: f64) -> anyhow::Result<Part> {
        let growth = Some(Growth::constant(model, machine_c)?);
        let temperature = PartTemperature { machine_c: Some(machine_c), ..self.temperature };
        Ok(Part { temperature, growth, ..self })
    }

    /// Growth of the machine while the part is cut.
    pub(super) fn growth_on(&self, machine: &Machine) -> anyhow::Result<Option<Cow<'_, Growth>>> {
        Ok(match (&self.growth, self.temperature.machine_c) {
            (Some(growth), _) => Some(Cow::Borrowed(growth)),
            (None, Some(celsius)) => Some(Cow::Owned(Growth::constant(GrowthModel::of(machine, None)?, celsius)?)),
            (None, None) => None,
        })
    }

    /// The program that a part's file names: reads nothing from the first section on, which may be unfinished.
    ///
    /// # Errors
    /// Invalid TOML before the first section; a program that is not a text.
    pub fn first_program(text: &str, file: &Path) -> Result<Option<String>, FileError> {
        let head = text.split_inclusive('\n').take_while(|line| !line.trim_start().starts_with('['));
        read_toml(&head.collect::<String>(), file, |root| {
            Ok(root.string("program")?.map(|found| found.value.to_owned()))
        })
    }

    /// Reads the programs of the further set-ups.
    ///
    /// # Errors
    /// Those of `read`, which is given the name in the file.
    pub fn read_setups<E>(&mut self, read: impl Fn(&str) -> Result<Program, E>) -> Result<(), E> {
        self.setups.iter_mut().try_for_each(|setup| {
            setup.program = Some(read(&setup.file)?);
            Ok(())
        })
    }

    /// The program of a feature; `first`: that of the first set-up.
    pub(super) fn program_of<'p>(&'p self, setup: Option<usize>, first: &'p Program) -> &'p Program {
        setup.and_then(|setup| self.setups.get(setup)?.program.as_ref()).unwrap_or(first)
    }

    /// An error at a line of the file.
    pub(super) fn wrong(&self, line: u32, found: impl Into<String>, needed: impl Into<String>) -> FileError {
        let (found, needed) = (found.into(), needed.into());
        FileError { file: self.file.clone(), line: Some(line), column: None, found, needed }
    }
}

/// The sections of this name.
fn all<'a>(root: &Section<'a>, key: &str) -> Result<Vec<Section<'a>>, FileError> {
    let sections = root.sections(key)?;
    if let Some(beyond) = sections.get(MOST) {
        let found = sections.len().to_string();
        return Err(root.at(beyond.first_line(), key, &found, format!("at most {MOST} sections")));
    }
    Ok(sections)
}

fn read_feature(section: Section<'_>, setups: &[Setup], tools: &[Tool]) -> Result<Feature, FileError> {
    let line = section.first_line();
    let name = section.string("name")?.ok_or_else(|| section.missing_here("name", "its name"))?.value.to_owned();
    let kind = section.choice("kind", FeatureKind::NAMES)?;
    let words = FeatureKind::NAMES.map(|(name, _)| format!("{name:?}")).join(" or ");
    let kind = kind.ok_or_else(|| section.missing_here("kind", &words))?;
    let lines = section.numbers::<2>("lines")?;
    let lines = lines.ok_or_else(|| section.missing_here("lines", "its first and last line of the program"))?;
    let [from, to] = lines.value;
    if from.fract() != 0.0 || to.fract() != 0.0 || from < 1.0 || to < from || to > 1e9 {
        return Err(section.wrong(&lines, "first and last line of the program, counted from 1"));
    }
    let setup = named(&section, "setup", "set-up", setups.iter().map(|own| own.name.as_str()))?;
    let tool = named(&section, "tool", "tool", tools.iter().map(|own| own.name.as_str()))?;
    let tool = tool.or((tools.len() == 1).then_some(0));
    if tool.is_none() && tools.len() > 1 {
        let names: Vec<&str> = tools.iter().map(|own| own.name.as_str()).collect();
        return Err(section.missing_here("tool", &format!("the name of its tool: {}", names.join(", "))));
    }
    let side = Side::read(&section, kind)?;
    let gear = if kind == FeatureKind::Flank { Some(GearFlank::read(&section)?) } else { None };
    let words = match kind {
        FeatureKind::Circle => "\"inside\" or \"outside\": where the tool is, since its diameter is uncertain",
        FeatureKind::Line => {
            "\"left\" or \"right\": where the material is along the path, since the tool's diameter is uncertain"
        }
        FeatureKind::Profile => {
            "\"left\" or \"right\" along the path, \"below\" or \"above\" the tool: where the material is, since the \
             tool's diameter is uncertain"
        }
        _ => "",
    };
    if !words.is_empty() && side.is_none() && tool.is_some_and(|tool| tools[tool].radius > 0.0) {
        return Err(section.missing_here("side", words));
    }
    section.finish(None)?;
    Ok(Feature { name, kind, lines: [from as u32, to as u32], setup, tool, side, gear, line })
}

fn read_tolerance(section: Section<'_>, features: &[Feature]) -> Result<Tolerance, FileError> {
    let line = section.first_line();
    let named = |found: &KeyValue<&str>| {
        let index = features.iter().position(|own| own.name == found.value);
        let names = || features.iter().map(|own| own.name.as_str()).collect::<Vec<_>>().join(", ");
        index.ok_or_else(|| section.wrong(found, format!("the name of a feature: {}", names())))
    };
    let feature = section.string("feature")?.ok_or_else(|| section.missing_here("feature", "the name of a feature"))?;
    let feature = named(&feature)?;
    let kind = section.choice("kind", Characteristic::NAMES)?;
    let words = Characteristic::NAMES.map(|(name, _)| name).join(", ");
    let characteristic = kind.ok_or_else(|| section.missing_here("kind", &words))?;
    let own = features[feature].kind;
    if !characteristic.kinds().contains(&own) {
        let kinds: Vec<&str> = characteristic.kinds().iter().map(|kind| kind.name()).collect();
        let found = format!("{} of a {}", characteristic.name(), own.name());
        return Err(section.at(line, "kind", &found, kinds.join(" or ")));
    }
    let limits = match class(&section, characteristic, features[feature].gear.as_ref())? {
        Some(limits) => limits,
        None => read_limits(&section, characteristic)?,
    };
    let mut datums = Vec::new();
    let key = if characteristic == Characteristic::Distance { "from" } else { "datums" };
    if characteristic == Characteristic::Distance {
        let from = section.string("from")?.ok_or_else(|| section.missing_here("from", "the name of a feature"))?;
        datums.push(named(&from)?);
    } else if let Some(found) = section.strings("datums")? {
        for name in &found.value {
            datums.push(named(&KeyValue {
                value: *name,
                line: found.line,
                key: found.key.clone(),
                text: found.text.clone(),
            })?);
        }
    }
    let is_free = |kind: FeatureKind| matches!(kind, FeatureKind::Flank | FeatureKind::Profile);
    if let Some(free) = datums.iter().find(|datum| is_free(features[**datum].kind)) {
        let found = format!("{}, a {}", features[*free].name, features[*free].kind.name());
        return Err(section.at(line, key, &found, "a feature other than a flank or profile"));
    }
    let [least, most] = characteristic.datums();
    let twice = (0..datums.len()).any(|k| datums[k] == feature || datums[..k].contains(&datums[k]));
    if twice || !(least..=most).contains(&datums.len()) {
        let needed = match [least, most] {
            [0, 0] => String::from("no datum"),
            [1, 1] => String::from("one other feature"),
            _ => format!("{least} to {most} other features, none of them twice"),
        };
        let found: Vec<&str> = datums.iter().map(|datum| features[*datum].name.as_str()).collect();
        let found = if found.is_empty() { String::from("nothing") } else { found.join(", ") };
        return Err(section.at(line, key, &found, needed));
    }
    let association = section.choice("association", Association::NAMES)?.unwrap_or_default();
    if let Some(stated) = section.string("association")?.filter(|_| !characteristic.is_form()) {
        let found = format!("{} of a {}", stated.value, characteristic.name());
        return Err(section.at(stated.line, "association", &found, "that of a straightness, flatness or roundness"));
    }
    section.finish(None)?;
    Ok(Tolerance { feature, characteristic, association, limits, datums, line })
}

/// The tolerance of a gear's class, mm.
fn class(section: &Section<'_>, of: Characteristic, gear: Option<&GearFlank>) -> Result<Option<[f64; 2]>, FileError> {
    let (Characteristic::Flank(deviation), Some(gear)) = (of, gear) else { return Ok(None) };
    let Some(class) = gear::whole(section, "class", gear::CLASSES)? else { return Ok(None) };
    let most = gear.tolerance(deviation, class);
    Ok(Some([if of.has_limits() { -most } else { f64::NEG_INFINITY }, most]))
}

/// The tolerance itself, mm: the unit is part of the key.
fn read_limits(section: &Section<'_>, of: Characteristic) -> Result<[f64; 2], FileError> {
    let stem = if of.has_limits() { "limits" } else { "width" };
    let needed = if of.has_limits() {
        "limits_um or limits_mm: the least and the greatest deviation"
    } else {
        "width_um or width_mm: the width of the zone"
    };
    let mut found = Vec::new();
    for (unit, mm) in [("um", 1e-3), ("mm", 1.0)] {
        let key = format!("{stem}_{unit}");
        if of.has_limits() {
            let Some(limits) = section.numbers::<2>(&key)? else { continue };
            let [low, high] = limits.value.map(|limit| mm * limit);
            if low >= high || low.abs().max(high.abs()) > WIDEST {
                return Err(section.wrong(&limits, format!("a rising pair of at most {} {unit}", WIDEST / mm)));
            }
            found.push([low, high]);
        } else if let Some(width) = number(section, &key, [1e-5 / mm, WIDEST / mm], &format!(" {unit}"))? {
            found.push([f64::NEG_INFINITY, mm * width]);
        }
    }
    match found[..] {
        [limits] => Ok(limits),
        [] => {
            // Without its unit the key would be refused as unknown, without saying what is missing.
            let bare = if of.has_limits() {
                section.numbers::<2>(stem)?.map(|found| section.wrong(&found, format!("a unit, {needed}")))
            } else {
                section.number(stem)?.map(|found| section.wrong(&found, format!("a unit, {needed}")))
            };
            let class = if matches!(of, Characteristic::Flank(_)) { ", or class" } else { "" };
            Err(bare.unwrap_or_else(|| section.missing_here(&format!("{stem}_um"), &format!("{needed}{class}"))))
        }
        _ => Err(section.at(section.first_line(), stem, "two units", "one of them")),
    }
}
