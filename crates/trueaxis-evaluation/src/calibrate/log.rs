//! Logs of probing programs.
//!
//! | log | a touch |
//! |---|---|
//! | LinuxCNC, `(LOG,…)` | `touch 17 x y z a b c 1` |
//! | grblHAL, console | `[MSG:touch 17]`, then `[PRB:x,y,z:1]` or with more axes |
//! | Klipper, console or klippy.log | `trueaxis touch 17 X:… Y:… Z:… tripped:1` |
//! | CSV | `id,x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg],tripped` |
//!
//! Other console lines are ignored; an unreadable touch line is refused. Positions are machine positions, mm and degrees.

use super::task::Dialect;
use crate::rows::{Column, Rows};
use anyhow::Result;
use std::collections::BTreeMap;
use std::path::Path;
use trueaxis::machine::AXES;
use trueaxis_tables::error::FileError;
use trueaxis_tables::text::counted;

/// A touch as logged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logged {
    /// Line of the log.
    pub line: u32,
    /// X, Y, Z, A, B, C at the trip, mm and degrees.
    pub position: [f64; AXES],
    /// Which of A, B, C the log states.
    pub rotary: [bool; 3],
}

/// Touches of a log by number, from 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// The touches.
    pub touches: BTreeMap<usize, Logged>,
    /// Program identity that the log states, with its line.
    pub identity: Option<(u32, u32)>,
}

/// Largest position in a log, mm or degrees.
const LARGEST: f64 = 1e6;

const COLUMNS: [Column; 8] = [
    Column { name: "id", needed: true },
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
    Column { name: "a_deg", needed: false },
    Column { name: "b_deg", needed: false },
    Column { name: "c_deg", needed: false },
    Column { name: "tripped", needed: true },
];

/// Reads a control's log or a CSV; `file` is used only in errors. Unusual separators are reported to the callback.
///
/// # Errors
/// With the line: a log of another control, an unreadable touch, a duplicate touch, a probe that did not trip.
pub fn read_log(text: &str, file: &Path, dialect: Dialect, note: impl FnMut(String)) -> Result<Log> {
    let mut reader = Reader { file, log: Log::default(), open: None };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let first = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    if first.is_some_and(|line| line.split([',', ';', '\t']).any(|cell| cell.trim_matches(['"', ' ']) == "id")) {
        reader.csv(text, note)?;
        return Ok(reader.log);
    }
    for (line, text) in (1..).zip(text.lines()) {
        let other = dialect_of(text).filter(|found| *found != dialect);
        if let Some(other) = other {
            let found = format!("a line of {}: {text:?}", other.name());
            let needed = format!("a log of {}, as the task says", dialect.name());
            return Err(reader.error(line, "", found, needed));
        }
        reader.identity(line, text)?;
        match dialect {
            Dialect::LinuxCnc => reader.linuxcnc(line, text)?,
            Dialect::GrblHal => reader.grblhal(line, text)?,
            Dialect::Klipper => reader.klipper(line, text)?,
        }
    }
    if let Some((id, line)) = reader.open {
        return Err(reader.error(line, "", format!("touch {id} without a trip"), "[PRB:…] after it"));
    }
    Ok(reader.log)
}

/// The number of the plan that a line states.
pub(super) fn identity_of(line: &str) -> Option<u32> {
    let (_, rest) = line.split_once("trueaxis calibrate ")?;
    u32::from_str_radix(rest.split_whitespace().next()?, 16).ok()
}

/// The only control that writes such a line.
fn dialect_of(line: &str) -> Option<Dialect> {
    if line.contains("[PRB:") || line.contains("[MSG:touch ") {
        Some(Dialect::GrblHal)
    } else if line.contains("trueaxis touch ") {
        Some(Dialect::Klipper)
    } else if line.starts_with("touch ") {
        Some(Dialect::LinuxCnc)
    } else {
        None
    }
}

struct Reader<'f> {
    file: &'f Path,
    log: Log,
    /// A touch announced but not yet logged, with its line.
    open: Option<(usize, u32)>,
}

impl Reader<'_> {
    fn error(&self, line: u32, column: &str, found: impl ToString, needed: impl ToString) -> anyhow::Error {
        FileError {
            file: self.file.into(),
            line: Some(line),
            column: (!column.is_empty()).then(|| column.to_owned()),
            found: found.to_string(),
            needed: needed.to_string(),
        }
        .into()
    }

    fn identity(&mut self, line: u32, text: &str) -> Result<()> {
        let Some(identity) = identity_of(text) else { return Ok(()) };
        match self.log.identity {
            Some((before, at)) if before != identity || !self.log.touches.is_empty() => {
                let found = format!("a second program, {identity:08x}; the first is {before:08x} of line {at}");
                Err(self.error(line, "", found, "the log of one run"))
            }
            _ => {
                self.log.identity = Some((identity, line));
                Ok(())
            }
        }
    }

    fn put(&mut self, line: u32, id: usize, position: [f64; AXES], rotary: [bool; 3], tripped: f64) -> Result<()> {
        if tripped != 1.0 {
            return Err(self.error(
                line,
                "",
                format!("touch {id} that did not trip"),
                "a probe that trips on every touch",
            ));
        }
        if let Some(far) = position.iter().find(|value| value.is_nan() || value.abs() > LARGEST) {
            return Err(self.error(line, "", format!("a position of {far}"), "at most 1e6"));
        }
        match self.log.touches.insert(id, Logged { line, position, rotary }) {
            Some(first) => {
                let found = format!("touch {id} for the second time, the first in line {}", first.line);
                Err(self.error(line, "", found, "every touch once"))
            }
            None => Ok(()),
        }
    }

    fn number(&self, line: u32, what: &str, word: &str) -> Result<f64> {
        match word.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.error(line, what, format!("{word:?}"), "a number")),
        }
    }

    fn id(&self, line: u32, word: &str) -> Result<usize> {
        match word.parse::<usize>() {
            Ok(id) if id > 0 => Ok(id),
            _ => Err(self.error(line, "touch", format!("{word:?}"), "the number of a touch")),
        }
    }

    fn linuxcnc(&mut self, line: u32, text: &str) -> Result<()> {
        let Some(rest) = text.strip_prefix("touch ") else { return Ok(()) };
        let words: Vec<&str> = rest.split_whitespace().collect();
        let [id, values @ .., tripped] = words.as_slice() else {
            return Err(self.error(line, "", format!("{text:?}"), "touch, its number, X Y Z A B C and 1"));
        };
        if values.len() != AXES {
            return Err(self.error(line, "", counted(values.len(), "position"), "X Y Z A B C"));
        }
        let mut position = [0.0; AXES];
        for (to, word) in position.iter_mut().zip(values) {
            *to = self.number(line, "position", word)?;
        }
        let tripped = self.number(line, "tripped", tripped)?;
        self.put(line, self.id(line, id)?, position, [true; 3], tripped)
    }

    fn grblhal(&mut self, line: u32, text: &str) -> Result<()> {
        if let Some((_, rest)) = text.split_once("[MSG:touch ") {
            if let Some((id, at)) = self.open {
                return Err(self.error(
                    line,
                    "",
                    format!("a touch after touch {id} of line {at} without a trip"),
                    "[PRB:…] first",
                ));
            }
            let word = rest.split(']').next().unwrap_or_default().trim();
            self.open = Some((self.id(line, word)?, line));
        } else if let Some((_, rest)) = text.split_once("[PRB:") {
            let Some((id, _)) = self.open.take() else {
                return Err(self.error(line, "", "a trip that no touch announces", "[MSG:touch …] before it"));
            };
            let inside = rest.split(']').next().unwrap_or_default();
            let Some((values, tripped)) = inside.rsplit_once(':') else {
                return Err(self.error(line, "", format!("{text:?}"), "[PRB:x,y,z:1]"));
            };
            let words: Vec<&str> = values.split(',').collect();
            if !(3..=AXES).contains(&words.len()) {
                return Err(self.error(line, "", counted(words.len(), "position"), "3 to 6"));
            }
            let mut position = [0.0; AXES];
            for (to, word) in position.iter_mut().zip(&words) {
                *to = self.number(line, "PRB", word)?;
            }
            let tripped = self.number(line, "PRB", tripped)?;
            let rotary = std::array::from_fn(|k| words.len() > 3 + k);
            self.put(line, id, position, rotary, tripped)?;
        }
        Ok(())
    }

    fn klipper(&mut self, line: u32, text: &str) -> Result<()> {
        let Some((_, rest)) = text.split_once("trueaxis touch ") else { return Ok(()) };
        let mut words = rest.split_whitespace();
        let id = self.id(line, words.next().unwrap_or_default())?;
        let mut found = [None; 4];
        for word in words {
            let (name, value) = word.split_once(':').unwrap_or((word, ""));
            let Some(slot) = ["X", "Y", "Z", "tripped"].iter().position(|known| *known == name) else {
                return Err(self.error(line, "", format!("{word:?}"), "X:… Y:… Z:… tripped:1"));
            };
            found[slot] = Some(self.number(line, name, value)?);
        }
        let [Some(x), Some(y), Some(z), Some(tripped)] = found else {
            return Err(self.error(line, "", format!("{text:?}"), "X:… Y:… Z:… tripped:1"));
        };
        self.put(line, id, [x, y, z, 0.0, 0.0, 0.0], [false; 3], tripped)
    }

    fn csv(&mut self, text: &str, note: impl FnMut(String)) -> Result<()> {
        for (line, text) in (1..).zip(text.lines()).take_while(|(_, text)| text.trim_start().starts_with('#')) {
            self.identity(line, text)?;
        }
        let mut rows = Rows::new(text.as_bytes(), self.file, &COLUMNS, note)?;
        let rotary = std::array::from_fn(|k| rows.present[4 + k]);
        while let Some(row) = rows.next()? {
            let [id, x, y, z, a, b, c, tripped] = row.values;
            if id.fract() != 0.0 || !(1.0..=1e9).contains(&id) {
                return Err(rows.error(row.line, "id", id, "the number of a touch, from 1"));
            }
            self.put(row.line, id as usize, [x, y, z, a, b, c], rotary, tripped)?;
        }
        Ok(())
    }
}
