//! Separators and decimals, detected from the head of a file.

use super::lines::{Lines, reader};
use crate::error::FileError;
use crate::origin::Origin;

/// Bytes of a file that are examined for decimal commas or points.
pub(super) const HEAD: u64 = 1 << 16;

pub(super) const AMBIGUOUS: &str =
    "decimals that cannot be taken for thousands: decimal points, or semicolons between the fields";

/// Character between the fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    Comma,
    Semicolon,
    Tab,
}

impl Separator {
    const ALL: [Separator; 3] = [Separator::Comma, Separator::Semicolon, Separator::Tab];

    pub(super) fn byte(self) -> u8 {
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

/// Decimal sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decimals {
    /// No number so far had decimals.
    Unknown,
    Point,
    Comma,
}

/// Evidence of a single field about the decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    None,
    Point,
    Comma,
    /// A comma followed by three digits: decimals or thousands.
    Either,
}

pub(super) fn sign(field: &str) -> Sign {
    let unsigned = field.trim_start_matches(['+', '-']);
    if !unsigned.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b',' | b'e' | b'E' | b'+' | b'-')) {
        return Sign::None;
    }
    match (unsigned.split_once(','), unsigned.contains('.')) {
        (None, false) => Sign::None,
        (None, true) => Sign::Point,
        // `1.234,5` is not a number either way, and is refused as one.
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

/// A field without surrounding blanks and quotes.
pub(super) fn bare(field: &str) -> &str {
    let field = field.trim();
    // The csv reader leaves quotes that follow a blank.
    field.strip_prefix('"').and_then(|field| field.strip_suffix('"')).map_or(field, str::trim)
}

/// The separator between the names of the header.
pub(super) fn separator(head: &[u8], origin: &Origin) -> Result<Separator, FileError> {
    let mut lines = Lines::over(head);
    if !lines.fetch().map_err(|error| origin.unreadable(&error))? {
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
            Err(origin.at(lines.number, "", found, "one of commas, semicolons and tabs"))
        }
    }
}

/// The decimals of the first unambiguous number.
pub(super) fn decimals(head: &[u8], separator: Separator, origin: &Origin) -> Result<Decimals, FileError> {
    // The last line may be incomplete.
    let whole = if (head.len() as u64) < HEAD {
        head.len()
    } else {
        head.iter().rposition(|b| *b == b'\n').map_or(0, |p| p + 1)
    };
    let head = head.get(..whole).unwrap_or_default();
    let mut reader = reader(Box::new(head), separator.byte());
    let mut record = csv::ByteRecord::new();
    let (mut doubtful, mut header) = (None, true);
    // Faults of a line are reported when it is read.
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
        Some((line, field)) => Err(origin.at(line, "", format!("{field:?}"), AMBIGUOUS)),
    }
}
