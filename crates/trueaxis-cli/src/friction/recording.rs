//! A record of circles, read from CSV.

use crate::csv_in::{Column, Rows};
use anyhow::{Result, anyhow};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis_metrology::friction::{Record, Recorded, Refused};

/// The record and where it comes from.
pub(super) struct Recording {
    pub(super) file: PathBuf,
    pub(super) record: Record,
}

impl Recording {
    pub(super) fn read(file: &Path, axes: [Axis; 2]) -> Result<Recording> {
        let names = axes.map(names);
        let needed = |name| Column { name, needed: true };
        let [[command, reading], [other_command, other_reading]] = names;
        let columns = ["t_s", command, reading, other_command, other_reading].map(needed);
        let mut rows = Rows::open(file, &columns, "samples")?;
        let (mut lines, mut times) = (Vec::new(), Vec::new());
        let mut recorded = axes.map(|axis| Recorded { axis, command: Vec::new(), reading: Vec::new() });
        while let Some(row) = rows.next()? {
            let [time, values @ ..] = row.values;
            lines.push(row.line);
            times.push(time);
            for (own, pair) in recorded.iter_mut().zip(values.chunks(2)) {
                own.command.extend(pair.first());
                own.reading.extend(pair.last());
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

/// Columns of an axis: command, reading.
fn names(axis: Axis) -> [&'static str; 2] {
    match axis {
        Axis::X => ["x_cmd_mm", "x_mm"],
        Axis::Y => ["y_cmd_mm", "y_mm"],
        _ => ["z_cmd_mm", "z_mm"],
    }
}
