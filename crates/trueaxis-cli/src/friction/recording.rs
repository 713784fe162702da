//! A record of circles, read from CSV.

use crate::csv_in::{self, Column};
use anyhow::{Result, anyhow};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis_metrology::friction::{Record, Recorded, Refused};

/// Columns that a record may have: time, then command and reading of X, Y and Z.
const NAMES: [&str; 7] = ["t_s", "x_cmd_mm", "x_mm", "y_cmd_mm", "y_mm", "z_cmd_mm", "z_mm"];

/// The record and where it comes from.
pub(super) struct Recording {
    pub(super) file: PathBuf,
    pub(super) record: Record,
}

impl Recording {
    pub(super) fn read(file: &Path, axes: [Axis; 2]) -> Result<Recording> {
        let needed = |name: &str| axes.iter().any(|axis| name.starts_with(axis.letter().to_ascii_lowercase()));
        let columns = NAMES.map(|name| Column { name, needed: name == "t_s" || needed(name) });
        let mut rows = csv_in::open(file, &columns, "samples")?;
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
        let record = Record::new(&times, recorded).map_err(|refused| match refused {
            Refused::Uneven { index, found_s, period_s } => {
                let line = lines.get(index + 1).copied().unwrap_or(0);
                let found = format!("{found_s:.6} s after the line before");
                rows.error(line, "t_s", found, format!("{period_s:.6} s as everywhere else: no gap, an even rate"))
            }
            refused => anyhow!("{}: {refused}", file.display()),
        })?;
        Ok(Recording { file: file.into(), record })
    }
}
