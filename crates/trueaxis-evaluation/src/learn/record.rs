//! RECORD.csv: the contour error of one part over path length.

use crate::record::{self, Channel};
use crate::rows::{Column, Row, Rows};
use anyhow::{Context, Result, anyhow};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use trueaxis_metrology::learning::{Identity, MeasuredError, NotLearned};

/// Columns of a record.
pub const COLUMNS: [Column; 5] = [
    Column { name: "s_mm", needed: true },
    Column { name: "ex_um", needed: true },
    Column { name: "ey_um", needed: true },
    Column { name: "ez_um", needed: true },
    Column { name: "measured", needed: false },
];

/// Bytes before the header that are searched for comments.
const COMMENTS: u64 = 1 << 16;
const KEYS: [&str; 3] = ["program_id", "machine_id", "length_mm"];

/// The record of a part as read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    file: PathBuf,
    /// Machine, program and its path length.
    pub identity: Identity,
    /// The rows, mm.
    pub rows: Vec<MeasuredError>,
    lines: Vec<u32>,
}

/// A comment `# key = value`.
struct Said {
    line: u32,
    value: String,
}

impl Record {
    /// Reads a file: its comments from `comments`, its rows from the sheet that `open` opens. The resampling checks whatever
    /// depends on path and cut-off.
    ///
    /// # Errors
    /// A comment that is missing, repeated or out of range; a row that cannot be read; a component that stops changing
    /// half-way.
    pub fn read<'r>(comments: impl Read, file: &Path, open: impl FnOnce() -> Result<Rows<'r, 5>>) -> Result<Record> {
        let said = self::comments(comments, file)?;
        let [program_id, machine_id] = [&said[0], &said[1]];
        let program_id = id(file, KEYS[0], program_id)?;
        let machine_id = id(file, KEYS[1], machine_id)?;
        let length_mm = length(file, &said[2])?;
        let mut sheet = open()?;
        let has_flag = sheet.present[4];
        let (mut rows, mut lines) = (Vec::new(), Vec::new());
        while let Some(Row { line, values }) = sheet.next()? {
            let [length_mm, x, y, z, measured] = values;
            if has_flag && measured != 0.0 && measured != 1.0 {
                return Err(sheet.error(line, COLUMNS[4].name, measured, "0 or 1"));
            }
            let error_mm = (!has_flag || measured == 1.0).then(|| [x, y, z].map(|value| 1e-3 * value));
            rows.push(MeasuredError { length_mm, error_mm });
            lines.push(line);
        }
        let measured = || rows.iter().zip(&lines).filter_map(|(row, line)| Some((row.error_mm?, *line)));
        let values = [0, 1, 2].map(|c| measured().map(|(error, _)| error[c]).collect::<Vec<f64>>());
        let channels = [0, 1, 2].map(|c| Channel { name: COLUMNS[1 + c].name, values: &values[c], scale: 1e3 });
        record::alive(&sheet, &measured().map(|(_, line)| line).collect::<Vec<u32>>(), &channels)?;
        let identity = Identity { machine_id, program_id, length_mm };
        Ok(Record { file: file.into(), identity, rows, lines })
    }

    /// Adds file and line to a refusal from the mathematics.
    pub fn refused(&self, refused: &NotLearned) -> anyhow::Error {
        let line = refused.row().and_then(|row| self.lines.get(row));
        let column = if matches!(refused, NotLearned::TooLarge { .. }) { "ex_um, ey_um, ez_um" } else { "s_mm" };
        match line {
            Some(line) => anyhow!("{}:{line}: column {column}: {refused}", self.file.display()),
            None => anyhow!("{}: {refused}", self.file.display()),
        }
    }
}

/// The values of [`KEYS`], in that order.
fn comments(input: impl Read, file: &Path) -> Result<[Said; 3]> {
    let mut said: [Option<Said>; 3] = [None, None, None];
    for (number, line) in (1..).zip(BufReader::new(input.take(COMMENTS)).split(b'\n')) {
        let line = line.with_context(|| format!("cannot read {}", file.display()))?;
        let line = String::from_utf8_lossy(&line);
        let line = line.trim_start_matches('\u{feff}').trim();
        if line.is_empty() {
            continue;
        }
        let Some(comment) = line.strip_prefix('#') else { break };
        let Some((key, value)) = comment.split_once('=') else { continue };
        let Some(slot) = KEYS.iter().position(|known| *known == key.trim()) else { continue };
        if let Some(before) = &said[slot] {
            return Err(anyhow!(
                "{}:{number}: found {} again, needed it once (line {})",
                file.display(),
                KEYS[slot],
                before.line
            ));
        }
        said[slot] = Some(Said { line: number, value: value.trim().to_owned() });
    }
    let missing =
        |key: &str| anyhow!("{}: found no {key}, needed a comment `# {key} = …` before the header", file.display());
    let [program, machine, length] = said;
    Ok([
        program.ok_or_else(|| missing(KEYS[0]))?,
        machine.ok_or_else(|| missing(KEYS[1]))?,
        length.ok_or_else(|| missing(KEYS[2]))?,
    ])
}

fn id(file: &Path, key: &str, said: &Said) -> Result<u32> {
    let digits = said.value.strip_prefix("0x").unwrap_or(&said.value);
    let hexadecimal = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let id = hexadecimal.then(|| u32::from_str_radix(digits, 16).ok()).flatten();
    id.ok_or_else(|| {
        anyhow!(
            "{}:{}: {key}: found {:?}, needed up to eight hexadecimal digits",
            file.display(),
            said.line,
            said.value
        )
    })
}

fn length(file: &Path, said: &Said) -> Result<f64> {
    let length = said.value.parse::<f64>().ok().filter(|length| (1e-3..=1e9).contains(length));
    length.ok_or_else(|| {
        let Said { line, value } = said;
        anyhow!("{}:{line}: length_mm: found {value:?}, needed a path length of 0.001 to 1e9 mm", file.display())
    })
}
