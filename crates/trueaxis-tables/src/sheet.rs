//! CSV as spreadsheets and instruments write it: a header, then one row a line, read row by row.
//!
//! | recognised | how |
//! |---|---|
//! | comma, semicolon or tab between the fields | the one that stands between the names of the header |
//! | decimal points or decimal commas | the first decimal number; the other kind is then refused |
//! | fields in quotes | `"…"`, closed on the same line |
//! | comments, blank lines, byte order mark | lines that begin with `#` are skipped |
//!
//! Nothing is guessed. A decimal comma needs semicolons or tabs between the fields, or quotes. Where it could as well part
//! thousands (`1,234` in every number of a file without semicolons), the file is refused. Thousands are never parted.

use crate::error::FileError;
use crate::source::Source;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::Path;

/// Longest line read, bytes: a file without line ends is no table.
const LONGEST_LINE: usize = 1 << 20;
/// As much of a file is looked at to tell decimal commas from points, bytes.
const HEAD: u64 = 1 << 16;

/// What stands between the fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    Comma,
    Semicolon,
    Tab,
}

impl Separator {
    const ALL: [Separator; 3] = [Separator::Comma, Separator::Semicolon, Separator::Tab];

    fn byte(self) -> u8 {
        match self {
            Separator::Comma => b',',
            Separator::Semicolon => b';',
            Separator::Tab => b'\t',
        }
    }

    fn name(self) -> &'static str {
        match self {
            Separator::Comma => "commas",
            Separator::Semicolon => "semicolons",
            Separator::Tab => "tabs",
        }
    }
}

/// What parts the decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Decimals {
    /// No number has had any yet.
    Unknown,
    Point,
    Comma,
}

/// What a single field says of the decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    None,
    Point,
    Comma,
    /// A comma with three digits on its right: decimals or thousands.
    Either,
}

fn sign(field: &str) -> Sign {
    let unsigned = field.trim_start_matches(['+', '-']);
    if !unsigned.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b',' | b'e' | b'E' | b'+' | b'-')) {
        return Sign::None;
    }
    match (unsigned.split_once(','), unsigned.contains('.')) {
        (None, false) => Sign::None,
        (None, true) => Sign::Point,
        // `1.234,5` is no number either way: it is refused as a number.
        (Some(_), true) => Sign::Comma,
        (Some((whole, decimals)), false) => {
            let thousands = decimals.len() == 3
                && (1..=3).contains(&whole.len())
                && !whole.starts_with('0')
                && !decimals.contains(',');
            if thousands { Sign::Either } else { Sign::Comma }
        }
    }
}

/// A field without the blanks and quotes around it.
fn bare(field: &str) -> &str {
    let field = field.trim();
    // Quotes behind a blank are not the csv reader's.
    field.strip_prefix('"').and_then(|field| field.strip_suffix('"')).map_or(field, str::trim)
}

/// A table in the course of being read.
pub struct Sheet<'r> {
    source: Source,
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

impl Sheet<'static> {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// As [`Sheet::new`], and a file that cannot be opened.
    pub fn open(file: &Path) -> Result<Sheet<'static>, FileError> {
        let input = File::open(file).map_err(|error| Source::new(file).whole(error.to_string(), "a readable file"))?;
        Sheet::new(input, file)
    }
}

impl<'r> Sheet<'r> {
    /// Reads the header; `file` is only named in errors.
    ///
    /// # Errors
    /// No header, one with two kinds of separators, or decimals that can be read in two ways.
    pub fn new(mut input: impl Read + 'r, file: &Path) -> Result<Sheet<'r>, FileError> {
        let source = Source::new(file);
        let mut head = Vec::new();
        let mut start = input.by_ref().take(HEAD);
        start.read_to_end(&mut head).map_err(|error| source.whole(error.to_string(), "a readable file"))?;
        if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
            return Err(source.whole("text in UTF-16", "text in UTF-8"));
        }
        let separator = separator(&head, &source)?;
        let decimals = decimals(&head, separator, &source)?;
        let input = Cursor::new(head).chain(BufReader::with_capacity(1 << 16, input));
        let mut sheet = Sheet {
            source,
            reader: reader(Box::new(input), separator),
            record: csv::StringRecord::new(),
            header: Vec::new(),
            header_line: 0,
            line: 0,
            separator,
            decimals,
        };
        if !sheet.advance()? {
            return Err(sheet.source.whole("no header", "a line with the names of the columns"));
        }
        sheet.header = sheet.record.iter().map(|name| bare(name).to_owned()).collect();
        sheet.header_line = sheet.line;
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

    /// How the file is read where that is not commas and decimal points: to be told once.
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

    /// Goes on to the next row; false at the end of the file.
    ///
    /// # Errors
    /// A row with another number of fields than the header, an open quote, bytes that are not UTF-8.
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
            return Err(self.source.at(self.line, "", found, needed));
        }
        Ok(true)
    }

    /// A field of the row, without blanks and quotes around it; empty beyond the last.
    pub fn field(&self, place: usize) -> &str {
        self.record.get(place).map_or("", bare)
    }

    /// A field with a decimal point, whatever the file has.
    pub fn plain(&self, place: usize) -> Cow<'_, str> {
        let field = self.field(place);
        if self.decimals == Decimals::Comma { field.replace(',', ".").into() } else { field.into() }
    }

    /// A field as a finite number.
    ///
    /// # Errors
    /// No number, one that is not finite, or one with decimals of the other kind than those before.
    pub fn number(&mut self, place: usize) -> Result<f64, FileError> {
        let field = self.record.get(place).map_or("", bare);
        let name = self.header.get(place).map_or("", String::as_str);
        if !field.contains(',') {
            // The usual case, without a copy.
            if self.decimals == Decimals::Comma && sign(field) == Sign::Point {
                let needed = "a decimal comma, as in the numbers before";
                return Err(self.source.at(self.line, name, format!("{field:?}"), needed));
            }
            let value = self.source.number(self.line, name, field)?;
            if self.decimals == Decimals::Unknown && field.contains('.') {
                self.decimals = Decimals::Point;
            }
            return Ok(value);
        }
        if self.decimals == Decimals::Point {
            let needed = "a decimal point, as in the numbers before";
            return Err(self.source.at(self.line, name, format!("{field:?}"), needed));
        }
        if self.decimals == Decimals::Unknown && self.separator != Separator::Semicolon && sign(field) == Sign::Either {
            return Err(self.source.at(self.line, name, format!("{field:?}"), AMBIGUOUS));
        }
        if field.contains('.') {
            return Err(self.source.at(self.line, name, format!("{field:?}"), "a number without parted thousands"));
        }
        let value = self
            .source
            .number(self.line, name, &field.replacen(',', ".", 1))
            .map_err(|error| FileError { found: format!("{field:?}"), ..error })?;
        self.decimals = Decimals::Comma;
        Ok(value)
    }

    /// An error in the row read last (in the header before the first); an empty `column` means the line as a whole.
    pub fn error(&self, column: &str, found: impl std::fmt::Display, needed: impl Into<String>) -> FileError {
        self.source.at(self.line, column, found, needed)
    }

    /// The next line that is neither blank nor a comment, taken apart.
    fn advance(&mut self) -> Result<bool, FileError> {
        let read = self.reader.read_record(&mut self.record);
        let lines = self.reader.get_mut();
        let first = lines.handed.pop_front();
        if let Some(line) = first {
            self.line = line;
        }
        let needed = "a quote to be closed on its line";
        if !lines.handed.is_empty() {
            return Err(self.source.at(self.line, "", "an open quote", needed));
        }
        match read {
            Ok(found) => Ok(found),
            Err(error) => Err(match error.into_kind() {
                csv::ErrorKind::Utf8 { .. } => {
                    self.source.at(self.line, "", "bytes that are not UTF-8", "text in UTF-8")
                }
                csv::ErrorKind::Io(error) if error.kind() == io::ErrorKind::InvalidData => {
                    let needed = format!("at most {LONGEST_LINE} bytes in a line");
                    self.source.at(lines.number, "", "a longer line", needed)
                }
                csv::ErrorKind::Io(error) => self.source.whole(error.to_string(), "a readable file"),
                other => self.source.at(self.line, "", format!("{other:?}"), "a line of CSV"),
            }),
        }
    }
}

const AMBIGUOUS: &str = "decimals that cannot be taken for thousands: decimal points, or semicolons between the fields";

fn reader<'r>(input: Box<dyn BufRead + 'r>, separator: Separator) -> csv::Reader<Lines<'r>> {
    csv::ReaderBuilder::new().delimiter(separator.byte()).has_headers(false).flexible(true).from_reader(Lines {
        input,
        line: Vec::new(),
        given: 0,
        number: 0,
        handed: VecDeque::new(),
    })
}

/// The separator between the names of the header.
fn separator(head: &[u8], source: &Source) -> Result<Separator, FileError> {
    let mut lines = Lines::over(head);
    if !lines.fetch().map_err(|error| source.whole(error.to_string(), "a readable file"))? {
        return Ok(Separator::Comma);
    }
    let mut quoted = false;
    let mut outside = lines.line.iter().filter(|byte| {
        quoted ^= **byte == b'"';
        !quoted
    });
    let mut found = [false; 3];
    outside.by_ref().for_each(|byte| {
        for (found, separator) in found.iter_mut().zip(Separator::ALL) {
            *found |= *byte == separator.byte();
        }
    });
    let found: Vec<Separator> =
        Separator::ALL.into_iter().zip(found).filter(|(_, found)| *found).map(|(s, _)| s).collect();
    match found.as_slice() {
        [] => Ok(Separator::Comma),
        [only] => Ok(*only),
        several => {
            let names: Vec<&str> = several.iter().map(|separator| separator.name()).collect();
            let found = format!("{} between the names", names.join(" and "));
            Err(source.at(lines.number, "", found, "one of commas, semicolons and tabs"))
        }
    }
}

/// What the first decimal number that leaves no doubt says.
fn decimals(head: &[u8], separator: Separator, source: &Source) -> Result<Decimals, FileError> {
    // The last line may be cut off.
    let whole = if (head.len() as u64) < HEAD {
        head.len()
    } else {
        head.iter().rposition(|b| *b == b'\n').map_or(0, |p| p + 1)
    };
    let head = head.get(..whole).unwrap_or_default();
    let mut reader = reader(Box::new(head), separator);
    let mut record = csv::ByteRecord::new();
    let (mut doubtful, mut header) = (None, true);
    // Whatever is wrong with a line is told when it is read.
    while let Ok(true) = reader.read_byte_record(&mut record) {
        let line = reader.get_mut().handed.pop_front().unwrap_or(0);
        if std::mem::take(&mut header) {
            continue;
        }
        for field in record.iter().filter_map(|field| std::str::from_utf8(field).ok()).map(bare) {
            match sign(field) {
                Sign::None => {}
                Sign::Point => return Ok(Decimals::Point),
                Sign::Comma => return Ok(Decimals::Comma),
                Sign::Either if separator == Separator::Semicolon => return Ok(Decimals::Comma),
                Sign::Either => doubtful = doubtful.or_else(|| Some((line, field.to_owned()))),
            }
        }
    }
    match doubtful {
        None => Ok(Decimals::Unknown),
        Some((line, field)) => Err(source.at(line, "", format!("{field:?}"), AMBIGUOUS)),
    }
}

/// Hands a file to the csv reader line by line, without comments and blank lines, and keeps the numbers of those lines: one
/// line is one record.
struct Lines<'r> {
    input: Box<dyn BufRead + 'r>,
    line: Vec<u8>,
    given: usize,
    /// Line read last, from 1.
    number: u32,
    /// Lines handed out of which no record was made yet.
    handed: VecDeque<u32>,
}

impl<'r> Lines<'r> {
    fn over(bytes: &'r [u8]) -> Lines<'r> {
        Lines { input: Box::new(bytes), line: Vec::new(), given: 0, number: 0, handed: VecDeque::new() }
    }

    /// Reads on to a line with content; false at the end.
    fn fetch(&mut self) -> io::Result<bool> {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// How the text is read, and its rows with their lines.
    type Found = (Option<&'static str>, Vec<(u32, Vec<f64>)>);

    fn read(text: &[u8]) -> Result<Found, FileError> {
        let mut sheet = Sheet::new(text, Path::new("t.csv"))?;
        let mut rows = Vec::new();
        while sheet.next_row()? {
            let numbers = (0..sheet.header().len()).map(|place| sheet.number(place)).collect::<Result<_, _>>()?;
            rows.push((sheet.line(), numbers));
        }
        Ok((sheet.dialect(), rows))
    }

    fn refused(text: &str) -> String {
        read(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn files_as_spreadsheets_write_them() {
        let truth = vec![(2, vec![1.5, -2.25]), (3, vec![3.0, 4e-3])];
        let plain: [(&str, Option<&str>); 8] = [
            ("x,y\n1.5,-2.25\n3,4e-3\n", None),
            ("\u{feff}x,y\r\n1.5,-2.25\r\n3,4e-3", None),
            ("x;y\n1,5;-2,25\n3;4e-3\n", Some("read as semicolon separated with decimal commas")),
            ("x;y\n1.5;-2.25\n3;4e-3\n", Some("read as semicolon separated")),
            ("x\ty\n1.5\t-2.25\n3\t4e-3\n", Some("read as tab separated")),
            ("x\ty\n1,5\t-2,25\n3\t4e-3\n", Some("read as tab separated with decimal commas")),
            (
                "\"x\",\"y\"\n\"1,5\",\"-2,25\"\n\"3\",4e-3\n",
                Some("read as comma separated with decimal commas in quotes"),
            ),
            ("x, y\n1.5, \"-2.25\"\n 3 ,4e-3\n", None),
        ];
        for (text, told) in plain {
            assert_eq!(read(text.as_bytes()).unwrap(), (told, truth.clone()), "{text:?}");
        }
        // Comments may be in any encoding; lines are counted with them.
        let (_, rows) = read(b"# \xb5m\n\n  # more, \"\nx,y\n# here\n1,2\n\n3,4\n").unwrap();
        assert_eq!(rows, [(6, vec![1.0, 2.0]), (8, vec![3.0, 4.0])]);
        // Three decimals everywhere are decimals where semicolons part the fields, or once another number shows it.
        assert_eq!(read(b"x;y\n1,234;5\n").unwrap().1, [(2, vec![1.234, 5.0])]);
        assert_eq!(read(b"x\ty\n1,234\t5\n0,500\t2\n").unwrap().1, [(2, vec![1.234, 5.0]), (3, vec![0.5, 2.0])]);
    }

    #[test]
    fn nothing_is_guessed() {
        for (text, parts) in [
            ("x,y\n1,5,2,5\n", ["t.csv:2", "4 values", "semicolons"]),
            ("x,y;z\n1,2;3\n", ["t.csv:1", "commas and semicolons", "one of"]),
            ("x\ty\n1,234\t5,678\n", ["t.csv:2", "1,234", "thousands"]),
            ("x,y\n\"1,234\",5\n", ["t.csv:2", "1,234", "thousands"]),
            ("x;y\n1,5;2.5\n", ["t.csv:2", "2.5", "decimal comma"]),
            ("x;y\n1.5;2\n1;2,5\n", ["t.csv:3", "2,5", "decimal point"]),
            ("x;y\n1.234,5;2\n", ["t.csv:2", "1.234,5", "thousands"]),
            ("x;y\n1,234,567;2\n", ["t.csv:2", "1,234,567", "a number"]),
            ("x,y\n\"1,2\n3,4\n", ["t.csv:2", "open quote", "closed"]),
            ("x,y\n1\n", ["t.csv:2", "1 value", "2 as in the header"]),
            ("x,y\n1,\n", ["t.csv:2: column y", "nothing", "a number"]),
            ("# no more\n", ["t.csv", "no header", "names"]),
        ] {
            let error = refused(text);
            for part in parts {
                assert!(error.contains(part), "{text:?}: {error}");
            }
        }
        let latin = read(b"x,y\n1,2\n\xb5,2\n").unwrap_err();
        assert_eq!((latin.line, latin.found.as_str()), (Some(3), "bytes that are not UTF-8"));
        assert!(read(b"\xff\xfex\0").unwrap_err().found.contains("UTF-16"));
        let mut long = b"x,y\n1,2\n".to_vec();
        long.resize(LONGEST_LINE + 100, b'7');
        assert_eq!(read(&long).unwrap_err().line, Some(3));
    }
}
