//! `trueaxis explain`: the codes that a controller reports, in words.

use crate::output::print;
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use std::fmt::Write;
use trueaxis::error::{Fault, Field, Figure};
use trueaxis::machine::Axis;
use trueaxis::tcomp::TcompError;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis explain fault 3";

pub(crate) const HELP: &str = "\
A library built without the part `text` reports errors by numbers only: `result`, `code` and `field` of \
trueaxis_error_t. Ask for them one after the other:

  trueaxis explain result 6
  trueaxis explain tables 11
  trueaxis explain setting '#22' --axis X --found 0.0003

Without a code, all codes of the kind are listed; without a kind, all kinds. For the whole message, with the value \
that is needed, run `trueaxis tables check` on the machine from which the file was compiled.";

#[derive(Args)]
pub(crate) struct ExplainArgs {
    /// Kind of the code.
    kind: Option<Kind>,
    /// The code; a setting's may begin with #, as the library writes it.
    #[arg(value_parser = code)]
    code: Option<u8>,
    /// Axis of the setting: `axis` of `trueaxis_error_t`.
    #[arg(long, requires = "code")]
    axis: Option<char>,
    /// Value of the setting: `found` of `trueaxis_error_t`, in mm, degrees or seconds.
    #[arg(long, requires = "code", allow_negative_numbers = true)]
    found: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Result of a function of the C library.
    Result,
    /// Fault of a servo cycle, as in records and telemetry.
    Fault,
    /// Why a compiled table file (.tcomp) is refused.
    Tables,
    /// A setting of the machine, `field` of an error.
    Setting,
    /// A part that a build leaves out.
    Part,
    /// Why a learned correction (.tlearn) is refused.
    Learned,
    /// Why a file of thermal growth (.ttherm) is refused.
    Growth,
}

fn code(text: &str) -> Result<u8, String> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    digits.parse().map_err(|_| format!("found {text}, needed a number from 0 to 255"))
}

/// Codes of the C library with their names in the header.
const RESULTS: &[(u8, &str, &str)] = &[
    (0, "OK", "the function succeeded"),
    (1, "NULL", "a required pointer is NULL"),
    (2, "SIZE", "a size is not the one that the library needs (member size, size argument, TRUEAXIS_SINGLE)"),
    (3, "ALIGNMENT", "a pointer is not aligned as its type needs (memory: 8 bytes)"),
    (4, "UNBUILT", "an object was never built or started, or is of another kind"),
    (5, "ABI", "header and library differ in version or precision"),
    (6, "TABLES", "the table file is refused: explain tables CODE"),
    (7, "MACHINE", "the file belongs to another machine"),
    (8, "CONFIG", "a setting is refused: explain setting FIELD"),
    (9, "MEMORY", "the lent memory is too small"),
    (10, "PERIOD", "the period differs from that of the loop by more than 0.1 %"),
    (11, "AXES", "loop and state differ in the number of axes, or the number is not 3 to 6"),
    (12, "STATE", "the state was started by a loop of the other kind (bypass or not)"),
    (13, "ARGUMENT", "an argument is out of range; the function's description lists the conditions"),
    (14, "BUFFER", "the buffer is too small"),
    (15, "PATH", "the segment of the path is not valid"),
    (16, "GAUGE", "the machine has no gauge, or one with another number of points"),
    (17, "NOT_YET", "no value is available yet"),
    (18, "NO_OUTPUT", "no drive positions yet: no valid command has come, and not every axis has been read"),
    (19, "POSE", "the kinematics cannot reach the pose"),
    (20, "LEARNED", "the learned correction is refused: explain learned CODE"),
    (21, "THERMAL", "the file of thermal growth is refused: explain growth CODE"),
    (22, "LEFT_OUT", "a part is needed that this build of the library leaves out: explain part CODE"),
];

/// Features of the C library, the first six those of the core.
const PARTS: &[&str] = &["grids", "volumetric", "rotary", "dynamic", "gauge", "curves", "toolpath", "growth"];

/// Why any compiled file is refused; then come the reasons of its kind.
fn of_file(kind: &str, reasons: &[&str]) -> Vec<(u8, String)> {
    let common = [
        "shorter than its header says",
        "longer than its header says",
        &format!("not {kind}"),
        "another version of the format",
        "damaged: wrong CRC-32",
    ];
    numbered(common.iter().chain(reasons))
}

fn numbered<'t>(texts: impl IntoIterator<Item = &'t &'t str>) -> Vec<(u8, String)> {
    (1..).zip(texts.into_iter().map(|text| (*text).to_owned())).collect()
}

const LEARNED: &[&str] = &[
    "spacing of the nodes out of range",
    "resolution of the nodes out of range",
    "learned from zero parts",
    "number of nodes does not match path length and spacing",
    "first or last node is not zero",
    "learned on another program",
    "the program has another length",
    "learned on another machine",
];

const GROWTH: &[&str] = &[
    "number of sensors out of range",
    "number of axes out of range",
    "number of knots out of range",
    "knots do not ascend",
    "a time is out of range",
    "plausible readings are out of range",
    "an axis is not one of the machine's, or is there twice",
    "growth at the reference temperature is not zero",
    "a slope is larger than the step accepts",
    "made for another machine",
];

const TABLES: &[TcompError] = &[
    TcompError::TooShort,
    TcompError::TooLong,
    TcompError::Magic,
    TcompError::Version,
    TcompError::Checksum,
    TcompError::Settings,
    TcompError::TableHeader,
    TcompError::TableTooLong,
    TcompError::PayloadTooLong,
    TcompError::MachineId,
    TcompError::WrongMachine,
    TcompError::GridHeader,
    TcompError::GridTooLong,
];
/// Code of [`TcompError::Content`], which has no text without a setting.
const CONTENT: u8 = 11;

impl Kind {
    fn title(self) -> &'static str {
        match self {
            Kind::Result => "results of functions (trueaxis_result_t)",
            Kind::Fault => "faults of a servo cycle",
            Kind::Tables => "refused table files (result 6)",
            Kind::Setting => "settings of the machine",
            Kind::Part => "parts of a build (result 22)",
            Kind::Learned => "refused learned corrections (result 20)",
            Kind::Growth => "refused files of thermal growth (result 21)",
        }
    }

    /// Every code with its meaning, ascending.
    fn codes(self) -> Vec<(u8, String)> {
        match self {
            Kind::Result => {
                let name = |number, name: &str| format!("TRUEAXIS_{}{name}", if number == 0 { "" } else { "ERROR_" });
                RESULTS.iter().map(|(number, own, text)| (*number, format!("{}: {text}", name(*number, own)))).collect()
            }
            Kind::Fault => {
                let faults = (0..=u8::MAX).filter_map(|code| Some((code, Fault::try_from(code).ok()?)));
                faults.map(|(code, fault)| (code, format!("{fault}; {}", consequence(fault)))).collect()
            }
            Kind::Tables => {
                let mut codes: Vec<_> = TABLES.iter().map(|error| (error.code(), error.to_string())).collect();
                codes.push((CONTENT, "a setting or a table is out of range: explain setting FIELD".to_owned()));
                codes.sort();
                codes
            }
            Kind::Setting => Field::ALL.iter().map(|field| (field.code(), setting(*field, None))).collect(),
            Kind::Part => numbered(PARTS),
            Kind::Learned => of_file("a learned correction", LEARNED),
            Kind::Growth => of_file("a file of thermal growth", GROWTH),
        }
    }
}

fn consequence(fault: Fault) -> &'static str {
    if fault.freezes() {
        "the correction freezes, the command passes"
    } else if fault.stops() {
        "the output holds, a stop is requested"
    } else if fault.refuses() {
        "the command passes uncorrected"
    } else if fault != Fault::None {
        "the correction continues with the identified friction, until a reset"
    } else {
        "the cycle is corrected"
    }
}

/// The key in `machine.toml`, with `*` for an axis that is not given; the name of a setting that is not in the file.
fn setting(field: Field, axis: Option<Axis>) -> String {
    if field == Field::Inverse {
        return "Inverse: the errors of all tables together, too steep for the exact inverse".to_owned();
    }
    let axes = axis.map_or([Axis::X, Axis::C], |axis| [axis; 2]);
    let [linear, rotary] = axes.map(|axis| field.key(Some(axis)).map(|key| key.to_string()));
    // Only rotary axes have location errors.
    let Some(key) = rotary.filter(|key| key.contains("0C_")).or(linear) else {
        return format!("{field:?}, which the host sets");
    };
    match axis {
        Some(_) => key,
        None => key.replace("axis.X", "axis.*").replace("axis.C", "axis.*").replace("0C_", "0*_"),
    }
}

pub(crate) fn run(arguments: &ExplainArgs) -> Result<()> {
    let Some(kind) = arguments.kind else {
        let mut text = String::new();
        for kind in Kind::value_variants() {
            let gap = if text.is_empty() { "" } else { "\n" };
            text.push_str(gap);
            list(&mut text, *kind)?;
        }
        return print(&text);
    };
    let Some(code) = arguments.code else {
        let mut text = String::new();
        list(&mut text, kind)?;
        return print(&text);
    };
    if kind != Kind::Setting && (arguments.axis.is_some() || arguments.found.is_some()) {
        bail!("--axis, --found: found a code that is not a setting's, needed `explain setting CODE`");
    }
    let codes = kind.codes();
    let Some((_, meaning)) = codes.iter().find(|(known, _)| *known == code) else {
        let [first, last] = [codes.first(), codes.last()].map(|code| code.map_or(0, |(code, _)| *code));
        bail!("code: found {code}, needed a code from {first} to {last} of the list: {}", kind.title());
    };
    match Field::ALL.get(usize::from(code)).filter(|_| kind == Kind::Setting) {
        Some(field) => print(&format!("{}\n", found(*field, arguments)?)),
        None => print(&format!("{meaning}\n")),
    }
}

fn list(text: &mut String, kind: Kind) -> Result<()> {
    writeln!(text, "{}", kind.title())?;
    kind.codes().iter().try_for_each(|(code, meaning)| writeln!(text, "{code:5}  {meaning}"))?;
    Ok(())
}

/// A setting, with its value in the unit of its key.
fn found(field: Field, arguments: &ExplainArgs) -> Result<String> {
    let axis = match arguments.axis {
        None => None,
        Some(letter) => match Axis::from_letter(letter) {
            Some(axis) => Some(axis),
            None => bail!("--axis: found {letter}, needed X, Y, Z, A, B or C"),
        },
    };
    let mut text = setting(field, axis);
    if arguments.found.is_some() && text.contains('*') {
        bail!("--found: found no axis, needed --axis too: the unit depends on it");
    }
    if let Some(value) = arguments.found {
        let value = field.key(axis).map_or(value, |key| key.in_its_unit(value));
        write!(text, ": found {}", Figure(value))?;
    }
    Ok(text)
}
