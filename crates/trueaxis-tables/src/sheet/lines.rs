//! Presents a file to the csv reader: one line, one record.

use std::collections::VecDeque;
use std::io::{self, BufRead, Read};

/// Longest line read, bytes: a file without line ends is not a table.
pub(super) const LONGEST_LINE: usize = 1 << 20;

pub(super) fn reader<'r>(input: Box<dyn BufRead + 'r>, delimiter: u8) -> csv::Reader<Lines<'r>> {
    csv::ReaderBuilder::new().delimiter(delimiter).has_headers(false).flexible(true).from_reader(Lines {
        input,
        line: Vec::new(),
        given: 0,
        number: 0,
        handed: VecDeque::new(),
    })
}

/// Passes a file to the csv reader line by line, without comments and blank lines, and records the numbers of those lines: one
/// line is one record.
pub(super) struct Lines<'r> {
    input: Box<dyn BufRead + 'r>,
    pub(super) line: Vec<u8>,
    given: usize,
    /// Line read last, from 1.
    pub(super) number: u32,
    /// Lines passed on whose record has not been read yet.
    pub(super) handed: VecDeque<u32>,
}

impl<'r> Lines<'r> {
    pub(super) fn over(bytes: &'r [u8]) -> Lines<'r> {
        Lines { input: Box::new(bytes), line: Vec::new(), given: 0, number: 0, handed: VecDeque::new() }
    }

    /// Reads up to the next line with content; `false` at the end.
    pub(super) fn fetch(&mut self) -> io::Result<bool> {
        loop {
            (self.given, self.number) = (0, self.number.saturating_add(1));
            self.line.clear();
            let most = LONGEST_LINE as u64 + 1;
            if (&mut self.input).take(most).read_until(b'\n', &mut self.line)? == 0 {
                return Ok(false);
            }
            if self.line.len() > LONGEST_LINE {
                return Err(io::ErrorKind::InvalidData.into());
            }
            if self.number == 1 && self.line.starts_with(b"\xef\xbb\xbf") {
                self.line.drain(..3);
            }
            while self.line.last().is_some_and(|byte| matches!(byte, b'\n' | b'\r')) {
                self.line.pop();
            }
            let content = self.line.trim_ascii_start();
            if !content.is_empty() && !content.starts_with(b"#") {
                self.line.push(b'\n');
                return Ok(true);
            }
        }
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        if self.given == self.line.len() {
            if !self.fetch()? {
                return Ok(0);
            }
            self.handed.push_back(self.number);
        }
        let left = self.line.get(self.given..).unwrap_or_default();
        let count = left.len().min(to.len());
        if let (Some(to), Some(from)) = (to.get_mut(..count), left.get(..count)) {
            to.copy_from_slice(from);
        }
        self.given += count;
        Ok(count)
    }
}
