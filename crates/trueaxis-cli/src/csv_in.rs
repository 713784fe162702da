//! CSV files, row by row, with a progress bar.

use crate::output::{progress, report_line};
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressBarIter};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
pub(crate) use trueaxis_evaluation::rows::{Column, Row};

/// The rows of a file.
pub(crate) type Rows<const C: usize> = trueaxis_evaluation::rows::Rows<'static, C>;

/// Opens a file and checks its header; `what` names the rows on the progress bar.
pub(crate) fn open<const C: usize>(file: &Path, columns: &[Column; C], what: &'static str) -> Result<Rows<C>> {
    let input = File::open(file).with_context(|| format!("cannot read {}", file.display()))?;
    let bar = progress(input.metadata().map_or(0, |data| data.len()), what);
    let aside = bar.clone();
    let watched = Watched { input: bar.wrap_read(input), bar };
    Rows::new(watched, file, columns, move |how| aside.suspend(|| report_line(format_args!("note: {how}"))))
}

/// Moves a bar as the file is read, and clears it at the end.
struct Watched {
    input: ProgressBarIter<File>,
    bar: ProgressBar,
}

impl Read for Watched {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(to)?;
        if count == 0 {
            self.bar.finish_and_clear();
        }
        Ok(count)
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
