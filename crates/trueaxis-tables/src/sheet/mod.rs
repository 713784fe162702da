//! Reads CSV as spreadsheets and instruments write it: a header, then one row a line, read row by row.
//!
//! | recognised | how |
//! |---|---|
//! | comma, semicolon or tab between the fields | the one between the names of the header |
//! | decimal points or decimal commas | the first decimal number; the other kind is then refused |
//! | fields in quotes | `"…"`, closed on the same line |
//! | comments, blank lines, byte order mark | lines that begin with `#` are skipped |
//! | UTF-8, or UTF-16 as a spreadsheet's "Unicode text" | the byte order mark |
//!
//! Nothing is guessed. A decimal comma needs semicolons or tabs between the fields, or quotes. If the comma could equally be a
//! thousands separator (`1,234` in every number of a file without semicolons), the file is refused. Thousands separators are
//! never accepted.

mod dialect;
mod lines;
#[cfg(test)]
mod tests;

use crate::error::FileError;
use crate::origin::Origin;
use crate::text::{from_utf16, is_utf16};
use dialect::{AMBIGUOUS, Decimals, HEAD, Separator, Sign, bare, decimals, separator, sign};
use lines::{LONGEST_LINE, Lines, reader};
use std::borrow::Cow;
use std::io::{self, BufReader, Cursor, Read};
use std::path::Path;

/// A table being read.
pub struct Sheet<'r> {
    origin: Origin,
    reader: csv::Reader<Lines<'r>>,
    record: csv::StringRecord,
    header: Vec<String>,
    header_line: u32,
    line: u32,
    separator: Separator,
    decimals: Decimals,
}

impl std::fmt::Debug for Sheet<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Sheet").field("header", &self.header).field("line", &self.line).finish_non_exhaustive()
    }
}

impl<'r> Sheet<'r> {
    /// Reads the header; `file` is only named in errors.
    ///
    /// # Errors
    /// No header or one of numbers only, one with two kinds of separators, or ambiguous decimals.
    pub fn new(mut input: impl Read + 'r, file: &Path) -> Result<Sheet<'r>, FileError> {
        let origin = Origin::new(file);
        let mut head = Vec::new();
        let mut start = input.by_ref().take(HEAD);
        start.read_to_end(&mut head).map_err(|error| origin.unreadable(&error))?;
        if is_utf16(&head) {
            input.read_to_end(&mut head).map_err(|error| origin.unreadable(&error))?;
            head = from_utf16(&head, &origin)?.into_bytes();
        }
        let separator = separator(&head, &origin)?;
        let decimals = decimals(&head, separator, &origin)?;
        let input = Cursor::new(head).chain(BufReader::with_capacity(1 << 16, input));
        let mut sheet = Sheet {
            origin,
            reader: reader(Box::new(input), separator.byte()),
            record: csv::StringRecord::new(),
            header: Vec::new(),
            header_line: 0,
            line: 0,
            separator,
            decimals,
        };
        if !sheet.advance()? {
            return Err(sheet.origin.whole("no header", "a line with the names of the columns"));
        }
        sheet.header = sheet.record.iter().map(|name| bare(name).to_owned()).collect();
        sheet.header_line = sheet.line;
        // +1 and −1 name the runs of a matrix.
        let is_of_runs = sheet.header.iter().any(|name| name.starts_with('+'));
        if !is_of_runs
            && sheet.header.iter().all(|name| sheet.origin.number(sheet.line, "", &name.replace(',', ".")).is_ok())
        {
            let found = sheet.header.join(&sheet.separator().to_string());
            return Err(sheet.origin.at(
                sheet.line,
                "",
                found,
                "the names of the columns in the first line, above the numbers",
            ));
        }
        Ok(sheet)
    }

    /// Names of the columns, in the order of the file.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Line of the header, from 1.
    pub fn header_line(&self) -> u32 {
        self.header_line
    }

    /// Line of the row read last, from 1.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// Separators and decimals, if they are not commas and decimal points: to be reported once.
    pub fn dialect(&self) -> Option<&'static str> {
        Some(match (self.separator, self.decimals) {
            (Separator::Comma, Decimals::Comma) => "read as comma separated with decimal commas in quotes",
            (Separator::Comma, _) => return None,
            (Separator::Semicolon, Decimals::Comma) => "read as semicolon separated with decimal commas",
            (Separator::Semicolon, _) => "read as semicolon separated",
            (Separator::Tab, Decimals::Comma) => "read as tab separated with decimal commas",
            (Separator::Tab, _) => "read as tab separated",
        })
    }

    /// Character between the fields.
    pub(crate) fn separator(&self) -> char {
        char::from(self.separator.byte())
    }

    /// Whether any number read so far had a decimal comma.
    pub(crate) fn has_decimal_commas(&self) -> bool {
        self.decimals == Decimals::Comma
    }

    /// Advances to the next row; `false` at the end of the file.
    ///
    /// # Errors
    /// A row whose number of fields differs from the header's, an open quote, bytes that are not UTF-8.
    pub fn next_row(&mut self) -> Result<bool, FileError> {
        if !self.advance()? {
            return Ok(false);
        }
        if self.record.len() != self.header.len() {
            let hint = if self.separator == Separator::Comma && self.record.len() > self.header.len() {
                "; decimal commas need semicolons or tabs between the fields, or quotes"
            } else {
                ""
            };
            let needed = format!("{} as in the header{hint}", self.header.len());
            let found = if self.record.len() == 1 { "1 value".into() } else { format!("{} values", self.record.len()) };
            return Err(self.origin.at(self.line, "", found, needed));
        }
        Ok(true)
    }

    /// A field of the row, without surrounding blanks and quotes; empty beyond the last.
    pub fn field(&self, column: usize) -> &str {
        self.record.get(column).map_or("", bare)
    }

    /// A field with a decimal point, whichever the file uses.
    pub fn plain(&self, column: usize) -> Cow<'_, str> {
        let field = self.field(column);
        if self.decimals == Decimals::Comma { field.replace(',', ".").into() } else { field.into() }
    }

    /// A field as a finite number.
    ///
    /// # Errors
    /// A field that is not a number, not finite, or whose decimals differ in kind from those before.
    pub fn number(&mut self, column: usize) -> Result<f64, FileError> {
        let field = self.record.get(column).map_or("", bare);
        let name = self.header.get(column).map_or("", String::as_str);
        if !field.contains(',') {
            // The usual case, without a copy.
            if self.decimals == Decimals::Comma && sign(field) == Sign::Point {
                let needed = "a decimal comma, as in the numbers before";
                return Err(self.origin.at(self.line, name, format!("{field:?}"), needed));
            }
            let value = self.origin.number(self.line, name, field)?;
            if self.decimals == Decimals::Unknown && field.contains('.') {
                self.decimals = Decimals::Point;
            }
            return Ok(value);
        }
        if self.decimals == Decimals::Point {
            let needed = "a decimal point, as in the numbers before";
            return Err(self.origin.at(self.line, name, format!("{field:?}"), needed));
        }
        if self.decimals == Decimals::Unknown && self.separator != Separator::Semicolon && sign(field) == Sign::Either {
            return Err(self.origin.at(self.line, name, format!("{field:?}"), AMBIGUOUS));
        }
        if field.contains('.') {
            return Err(self.origin.at(self.line, name, format!("{field:?}"), "a number without thousands separators"));
        }
        let value = self
            .origin
            .number(self.line, name, &field.replacen(',', ".", 1))
            .map_err(|error| FileError { found: format!("{field:?}"), ..error })?;
        self.decimals = Decimals::Comma;
        Ok(value)
    }

    /// An error in the row read last (in the header before the first); an empty `column` means the line as a whole.
    pub fn error(&self, column: &str, found: impl std::fmt::Display, needed: impl Into<String>) -> FileError {
        self.origin.at(self.line, column, found, needed)
    }

    /// Reads and splits the next line that is neither blank nor a comment.
    fn advance(&mut self) -> Result<bool, FileError> {
        let read = self.reader.read_record(&mut self.record);
        let lines = self.reader.get_mut();
        let first = lines.handed.pop_front();
        if let Some(line) = first {
            self.line = line;
        }
        let needed = "a quote to be closed on its line";
        if !lines.handed.is_empty() {
            return Err(self.origin.at(self.line, "", "an open quote", needed));
        }
        match read {
            Ok(found) => Ok(found),
            Err(error) => Err(match error.into_kind() {
                csv::ErrorKind::Utf8 { .. } => {
                    self.origin.at(self.line, "", "bytes that are not UTF-8", "text in UTF-8")
                }
                csv::ErrorKind::Io(error) if error.kind() == io::ErrorKind::InvalidData => {
                    let needed = format!("at most {LONGEST_LINE} bytes in a line");
                    self.origin.at(lines.number, "", "a longer line", needed)
                }
                csv::ErrorKind::Io(error) => self.origin.unreadable(&error),
                other => self.origin.at(self.line, "", format!("{other:?}"), "a line of CSV"),
            }),
        }
    }
}
