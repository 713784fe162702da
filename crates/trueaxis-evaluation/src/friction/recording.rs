//! A record of circles, read from CSV.

use crate::record;
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis_metrology::friction::{FrictionRefusal, Record, Recorded};

/// Columns that a record may have: time, then command and reading of X, Y and Z.
const NAMES: [&str; 7] = ["t_s", "x_cmd_mm", "x_mm", "y_cmd_mm", "y_mm", "z_cmd_mm", "z_mm"];

/// The columns of a record: the time and those of `axes` are required, those of a third axis are optional.
pub fn columns(axes: [Axis; 2]) -> [Column; 7] {
    let needed = |name: &str| axes.iter().any(|axis| name.starts_with(axis.letter().to_ascii_lowercase()));
    NAMES.map(|name| Column { name, needed: name == "t_s" || needed(name) })
}

/// A record and its file.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The file as errors name it.
    pub file: PathBuf,
    /// The record read from it.
    pub record: Record,
}

impl Recording {
    /// Reads the rows of a file opened with [`columns`].
    ///
    /// # Errors
    /// A row that cannot be read, with its line; too few rows, uneven times, or an axis whose reading does not move while it
    /// is commanded to.
    ///
    /// Cost: 40 bytes of memory per row.
    pub fn read(mut rows: Rows<'_, 7>, axes: [Axis; 2]) -> Result<Recording> {
        let file = rows.file.clone();
        let (mut lines, mut times) = (Vec::new(), Vec::new());
        let mut recorded = axes.map(|axis| Recorded { axis, command: Vec::new(), reading: Vec::new() });
        while let Some(row) = rows.next()? {
            lines.push(row.line);
            times.push(row.values[0]);
            for own in &mut recorded {
                let place = 1 + 2 * own.axis.index();
                own.command.extend(row.values.get(place));
                own.reading.extend(row.values.get(place + 1));
            }
        }
        for own in &recorded {
            if let Some(stuck) = record::left_behind(&own.command, &own.reading) {
                return Err(stuck.error(&rows, &lines, NAMES[2 + 2 * own.axis.index()], 1.0));
            }
        }
        let record = Record::new(&times, recorded).map_err(|refused| match refused {
            FrictionRefusal::Uneven { index, found_s, period_s } => {
                let line = lines.get(index + 1).copied().unwrap_or(0);
                let found = format!("{found_s:.6} s after the line before");
                rows.error(line, "t_s", found, format!("{period_s:.6} s as everywhere else: no gap, an even rate"))
            }
            refused => anyhow!("{}: {refused}", file.display()),
        })?;
        Ok(Recording { file, record })
    }
}
