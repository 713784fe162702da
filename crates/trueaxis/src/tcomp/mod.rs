//! The compiled table file, as loaded by the controller: read in place, without allocation.
//!
//! All numbers little-endian:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | magic `TRUEAXIS` |
//! | 2 | format version, 8; 7 for a machine without periods, 6 without later figures of a servo, 5 without stated encoders, 4 without grids |
//! | 4 | machine id: CRC-32 of name, line feed, chain |
//! | 4 | length n of the payload |
//! | n | payload |
//! | 4 | CRC-32 of everything before |
//!
//! CRC-32 is CRC-32/ISO-HDLC (Ethernet, zlib). The payload is [`MachineSettings`] in postcard, in the
//! layout of `stored.rs`, then for every axis, in their order, [`TableHeader`] in postcard and its lines as raw doubles:
//! position (mm, degrees), the given forward errors (mm, rad) in the order EX EY EZ EA EB EC, and the reverse ones if
//! the table is bidirectional. From version 5 on, the number of grids follows as one byte, then for each grid
//! [`GridHeader`] in postcard, the positions of free nodes as raw doubles and the nodes as 16-bit numbers
//! ([`GridData`]), which are read in place. From version 6 on, a raw double for every axis follows: the step of its
//! encoder (mm, degrees), 0 if not stated. From version 7 on, five raw doubles for every axis follow ([`additions`]), 0 if
//! not stated, and one more for every axis ([`notch`]), in version 7 only if a drive has a notch. In version 8 the number of
//! periods follows as one byte, then each ([`PeriodicSettings`](crate::machine::PeriodicSettings)) in postcard.

mod stored;

pub use stored::Stored;

use crate::check;
use crate::error::{ConfigError, Field};
use crate::machine::Rows;
use crate::machine::{
    AXES, Axis, AxisSettings, GRIDS, GridData, GridHeader, MachineSettings, PERIODIC_CAPACITY, PeriodicSettings, Row,
    Twist,
};
use crate::part::{self, Part};
use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;
use serde::{Deserialize, Serialize};
use stored::{Layout, read_settings};

/// First eight bytes of the file.
pub const MAGIC: [u8; 8] = *b"TRUEAXIS";
/// Format version for a machine with errors that repeat within a period.
pub const VERSION: u16 = 8;
/// Format version for a machine without periods, but with [`additions`]: unchanged, so that older controllers load it.
pub const VERSION_WITHOUT_PERIODS: u16 = 7;
/// Format version for a machine without additions, but with a stated encoder step: unchanged, so that older controllers
/// load it.
pub const VERSION_WITHOUT_ADDITIONS: u16 = 6;
/// Format version for a machine without stated steps, but with grids: unchanged, so that older controllers load it.
pub const VERSION_WITHOUT_ENCODERS: u16 = 5;
/// Format version for a machine with neither.
pub const VERSION_WITHOUT_GRIDS: u16 = 4;
/// Bytes before the payload.
pub const HEADER_BYTES: usize = 18;

/// CRC with a table of 1 KiB, or bit by bit.
#[cfg(feature = "fast")]
pub(crate) type Table = crc::Table<1>;
#[cfg(not(feature = "fast"))]
pub(crate) type Table = crc::NoTable;

pub(crate) static CRC: Crc<u32, Table> = Crc::<u32, Table>::new(&CRC_32_ISO_HDLC);

/// Computes CRC-32/ISO-HDLC, the checksum at the end of the file.
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Computes the id of a machine: CRC-32/ISO-HDLC of its name, a line feed and its structural code.
pub fn machine_id(name: &str, chain: &str) -> u32 {
    let mut digest = CRC.digest();
    digest.update(name.as_bytes());
    digest.update(b"\n");
    digest.update(chain.as_bytes());
    digest.finalize()
}

/// Header of a table, before its lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableHeader {
    /// Whether the axis has a table; otherwise all fields below are zero.
    pub present: bool,
    /// Which errors the table gives: bit 0 EX … bit 5 EC.
    pub given: u8,
    /// Whether the table has forward and reverse columns.
    pub bidirectional: bool,
    /// Number of lines.
    pub rows: u32,
}

impl TableHeader {
    /// Bytes of one line.
    pub const fn row_bytes(&self) -> usize {
        let columns = self.given.count_ones() as usize;
        8 * (1 + columns * (1 + self.bidirectional as usize))
    }

    fn is_sound(&self) -> bool {
        if self.present { self.given != 0 && self.given < 64 } else { *self == TableHeader::default() }
    }
}

/// Why a file was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum TcompError {
    /// Shorter than its header says.
    TooShort = 1,
    /// Longer than its header says.
    TooLong = 2,
    /// Another kind of file.
    Magic = 3,
    /// Another version of the format.
    Version = 4,
    /// Damaged: the sum over the file is wrong.
    Checksum = 5,
    /// The settings cannot be decoded.
    Settings = 6,
    /// The header of a table cannot be decoded.
    TableHeader = 7,
    /// A table is longer than the payload.
    TableTooLong = 8,
    /// Bytes after the last item of the payload.
    PayloadTooLong = 9,
    /// The id does not match the name and the chain.
    MachineId = 10,
    /// The decoded content is not a valid machine.
    Content(ConfigError) = 11,
    /// The file belongs to another machine.
    WrongMachine = 12,
    /// The header of a grid cannot be decoded, or the number of grids is too large, or zero in version 5.
    GridHeader = 13,
    /// A grid is longer than the payload.
    GridTooLong = 14,
}

impl TcompError {
    /// The numeric code.
    pub const fn code(&self) -> u8 {
        match self {
            TcompError::TooShort => 1,
            TcompError::TooLong => 2,
            TcompError::Magic => 3,
            TcompError::Version => 4,
            TcompError::Checksum => 5,
            TcompError::Settings => 6,
            TcompError::TableHeader => 7,
            TcompError::TableTooLong => 8,
            TcompError::PayloadTooLong => 9,
            TcompError::MachineId => 10,
            TcompError::Content(_) => 11,
            TcompError::WrongMachine => 12,
            TcompError::GridHeader => 13,
            TcompError::GridTooLong => 14,
        }
    }
}

impl fmt::Display for TcompError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            TcompError::TooShort => "the file is shorter than its header says",
            TcompError::TooLong => "the file is longer than its header says",
            TcompError::Magic => "not a compiled table file (it does not start with TRUEAXIS)",
            TcompError::Version => "another version of the format (version 8 is needed, or 4 to 7)",
            TcompError::Checksum => "the file is damaged (its CRC-32 is wrong)",
            TcompError::Settings => "the machine settings cannot be decoded",
            TcompError::TableHeader => "the header of a table cannot be decoded",
            TcompError::TableTooLong => "a table is longer than the payload",
            TcompError::PayloadTooLong => "bytes follow the last item of the payload",
            TcompError::MachineId => "the machine id does not belong to the machine's name and chain",
            TcompError::Content(error) => return error.fmt(f),
            TcompError::WrongMachine => "the file was made for another machine",
            TcompError::GridHeader => "the header of a grid cannot be decoded",
            TcompError::GridTooLong => "a grid is longer than the payload",
        };
        f.write_str(text)
    }
}

impl core::error::Error for TcompError {}

/// A table inside the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableData<'a> {
    header: TableHeader,
    bytes: &'a [u8],
}

impl TableData<'_> {
    /// Which of the six errors the file gives (the others are zero).
    pub fn given(&self) -> [bool; 6] {
        core::array::from_fn(|component| self.header.given >> component & 1 == 1)
    }

    /// Whether forward and reverse differ; otherwise both are equal.
    pub fn bidirectional(&self) -> bool {
        self.header.bidirectional
    }

    /// Number of lines.
    pub fn len(&self) -> usize {
        self.header.rows as usize
    }

    /// Whether the table has no lines (never in an accepted file).
    pub fn is_empty(&self) -> bool {
        self.header.rows == 0
    }

    /// Line `index`.
    pub fn row(&self, index: usize) -> Option<Row> {
        let width = self.header.row_bytes();
        let start = index.checked_mul(width)?;
        let line = self.bytes.get(start..start.checked_add(width)?)?;
        let mut numbers = line.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
        let position = numbers.next()?;
        let mut twist = || {
            let mut errors = [0.0; 6];
            for (error, given) in errors.iter_mut().zip(self.given()) {
                if given {
                    *error = numbers.next()?;
                }
            }
            Some(errors)
        };
        let forward: Twist = twist()?;
        let reverse = if self.header.bidirectional { twist()? } else { forward };
        Some(Row { position, forward, reverse })
    }

    /// All lines in order.
    pub fn rows(&self) -> impl Iterator<Item = Row> + '_ {
        (0..self.len()).filter_map(|index| self.row(index))
    }
}

impl Rows for TableData<'_> {
    fn len(&self) -> usize {
        TableData::len(self)
    }
    fn row(&self, index: usize) -> Option<Row> {
        TableData::row(self, index)
    }
}

/// A compiled table file, checked; its tables and grids stay in the file's bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Tcomp<'a> {
    settings: MachineSettings,
    tables: Vec<Option<TableData<'a>>, AXES>,
    grids: Vec<GridData<'a>, GRIDS>,
    machine_id: u32,
    crc: u32,
    inverse_passes: u8,
}

/// Source of bytes for postcard, whose own source is inlined at every field and takes kilobytes.
struct Bytes<'a>(&'a [u8]);

impl<'a> postcard::de_flavors::Flavor<'a> for Bytes<'a> {
    type Remainder = &'a [u8];
    type Source = &'a [u8];

    #[inline(never)]
    fn pop(&mut self) -> postcard::Result<u8> {
        let (first, rest) = self.0.split_first().ok_or(postcard::Error::DeserializeUnexpectedEnd)?;
        self.0 = rest;
        Ok(*first)
    }

    #[inline(never)]
    fn try_take_n(&mut self, count: usize) -> postcard::Result<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(postcard::Error::DeserializeUnexpectedEnd)?;
        self.0 = rest;
        Ok(taken)
    }

    fn finalize(self) -> postcard::Result<&'a [u8]> {
        Ok(self.0)
    }
}

/// Decodes a value in postcard; returns it with the bytes after it.
#[inline(never)]
fn decoded<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<(T, &'a [u8])> {
    let mut source = postcard::Deserializer::from_flavor(Bytes(bytes));
    let value = T::deserialize(&mut source).ok()?;
    Some((value, source.finalize().ok()?))
}

/// Decodes the next value in postcard into its place.
fn read<'a, T: Deserialize<'a>>(rest: &mut &'a [u8], to: &mut T) -> Option<()> {
    (*to, *rest) = decoded(rest)?;
    Some(())
}

/// Decodes the next value in its layout into its place.
fn read_stored<T: Layout>(rest: &mut &[u8], to: &mut T) -> Option<()> {
    let (Stored(value), behind) = decoded(rest)?;
    (*to, *rest) = (value, behind);
    Some(())
}

/// Decodes a list element by element into its place.
fn read_list<T: Layout, const N: usize>(rest: &mut &[u8], to: &mut Vec<T, N>) -> Option<()> {
    to.clear();
    let mut count = 0_u32;
    read(rest, &mut count)?;
    for _ in 0..count {
        let (Stored(element), behind) = decoded(rest)?;
        to.push(element).ok()?;
        *rest = behind;
    }
    Some(())
}

fn split<const N: usize>(bytes: &[u8]) -> Result<([u8; N], &[u8]), TcompError> {
    bytes.split_first_chunk().map(|(first, rest)| (*first, rest)).ok_or(TcompError::TooShort)
}

impl<'a> Tcomp<'a> {
    /// A machine without name and axes, to [`read`](Tcomp::read) a file into.
    pub const fn empty() -> Self {
        Tcomp {
            settings: MachineSettings::EMPTY,
            tables: Vec::new(),
            grids: Vec::new(),
            machine_id: 0,
            crc: 0,
            inverse_passes: 0,
        }
    }

    /// Reads and checks a whole file: its form, its checksum, and everything that makes it a valid machine.
    ///
    /// Allocates nothing and never panics, whatever the bytes. Cost: linear in the file's length.
    ///
    /// # Errors
    /// The first defect found.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, TcompError> {
        let mut file = Tcomp::empty();
        file.read(bytes)?;
        Ok(file)
    }

    /// Like [`parse`](Tcomp::parse), into a place that the caller provides, which takes a third as much stack. After an
    /// error it holds no axis, so that no loop can be built of it.
    ///
    /// # Errors
    /// The first defect found.
    pub fn read(&mut self, bytes: &'a [u8]) -> Result<(), TcompError> {
        self.tables.clear();
        self.grids.clear();
        let read = self.read_checked(bytes);
        if read.is_err() {
            self.settings.axes.clear();
        }
        read
    }

    fn read_checked(&mut self, bytes: &'a [u8]) -> Result<(), TcompError> {
        let (magic, rest) = split::<8>(bytes)?;
        if magic != MAGIC {
            return Err(TcompError::Magic);
        }
        let (version, rest) = split::<2>(rest)?;
        let version = u16::from_le_bytes(version);
        if !(VERSION_WITHOUT_GRIDS..=VERSION).contains(&version) {
            return Err(TcompError::Version);
        }
        let (id, rest) = split::<4>(rest)?;
        let (length, rest) = split::<4>(rest)?;
        let length = u32::from_le_bytes(length) as usize;
        let (payload, sum) = rest.split_at_checked(length).ok_or(TcompError::TooShort)?;
        let (sum, behind) = split::<4>(sum)?;
        if !behind.is_empty() {
            return Err(TcompError::TooLong);
        }
        self.crc = u32::from_le_bytes(sum);
        if bytes.get(..bytes.len().saturating_sub(4)).map(checksum) != Some(self.crc) {
            return Err(TcompError::Checksum);
        }
        self.read_payload(payload, version)?;
        self.machine_id = machine_id(&self.settings.name, &self.settings.chain);
        if u32::from_le_bytes(id) != self.machine_id {
            return Err(TcompError::MachineId);
        }
        let passes = check::machine(&self.settings, self.rows(), &self.grids);
        self.inverse_passes = passes.map_err(TcompError::Content)?;
        Ok(())
    }

    #[inline(never)]
    fn read_payload(&mut self, payload: &'a [u8], version: u16) -> Result<(), TcompError> {
        let Tcomp { settings, tables, grids, .. } = self;
        let mut rest = payload;
        read_settings(&mut rest, settings).ok_or(TcompError::Settings)?;
        for _ in &settings.axes {
            let (table, behind) = table(rest)?;
            rest = behind;
            // At most one table for each of at most as many axes.
            let _ = tables.push(table);
        }
        if version != VERSION_WITHOUT_GRIDS {
            read_grids(&mut rest, version, grids)?;
        }
        if version >= VERSION_WITHOUT_ADDITIONS {
            rest = encoders(settings, rest)?;
        }
        if version >= VERSION_WITHOUT_PERIODS {
            rest = read_additions(settings, rest)?;
            rest = read_notches(settings, rest, version)?;
        }
        settings.periodic.clear();
        if version == VERSION {
            read_periods(&mut rest, &mut settings.periodic)?;
        }
        if rest.is_empty() { Ok(()) } else { Err(TcompError::PayloadTooLong) }
    }

    /// Refuses the file on any machine except the one with this id.
    ///
    /// # Errors
    /// [`TcompError::WrongMachine`].
    pub fn expect_machine(&self, id: u32) -> Result<(), TcompError> {
        if id == self.machine_id { Ok(()) } else { Err(TcompError::WrongMachine) }
    }

    /// The settings: everything except the tables.
    #[doc(hidden)]
    pub fn settings(&self) -> &MachineSettings {
        &self.settings
    }

    /// Id of the machine: CRC-32/ISO-HDLC of its name, a line feed and its structural code.
    pub fn machine_id(&self) -> u32 {
        self.machine_id
    }

    /// Checksum at the end of the file: the version of the tables in every telemetry record.
    pub fn crc(&self) -> u32 {
        self.crc
    }

    /// Lookups that the exact inverse of these tables needs.
    #[doc(hidden)]
    pub fn inverse_passes(&self) -> u8 {
        self.inverse_passes
    }

    /// Memory that a servo loop needs for these tables, in scalars of the step ([`crate::ServoLoop::load`]).
    pub fn requirement(&self) -> usize {
        crate::compensation::requirement(&self.settings, self.rows())
    }

    /// The axes with their tables.
    #[doc(hidden)]
    pub fn axes(&self) -> impl Iterator<Item = (&AxisSettings, Option<TableData<'a>>)> {
        self.settings.axes.iter().zip(self.tables.iter().copied())
    }

    /// The grids.
    #[doc(hidden)]
    pub fn grids(&self) -> &[GridData<'a>] {
        &self.grids
    }

    /// The tables by axis, as [`Config::build`](crate::Config::build) takes them. All callers share one type, so that the
    /// checks are compiled once.
    #[doc(hidden)]
    pub fn rows<'t>(&'t self) -> impl Fn(Axis) -> Option<&'t TableData<'a>> + Copy {
        move |axis| self.table(axis)
    }

    /// The table of an axis.
    #[doc(hidden)]
    pub fn table(&self, axis: Axis) -> Option<&TableData<'a>> {
        let place = self.settings.axes.iter().position(|settings| settings.axis == axis)?;
        self.tables.get(place)?.as_ref()
    }
}

fn table(bytes: &[u8]) -> Result<(Option<TableData<'_>>, &[u8]), TcompError> {
    let (header, rest) = decoded::<TableHeader>(bytes).ok_or(TcompError::TableHeader)?;
    if !header.is_sound() {
        return Err(TcompError::TableHeader);
    }
    if !header.present {
        return Ok((None, rest));
    }
    let length = (header.rows as usize).checked_mul(header.row_bytes()).ok_or(TcompError::TableTooLong)?;
    let (bytes, rest) = rest.split_at_checked(length).ok_or(TcompError::TableTooLong)?;
    Ok((Some(TableData { header, bytes }), rest))
}

/// Reads the steps of the encoders, after the grids; 0 means not stated.
fn encoders<'a>(settings: &mut MachineSettings, mut rest: &'a [u8]) -> Result<&'a [u8], TcompError> {
    for axis in &mut settings.axes {
        let (step, behind) = rest.split_first_chunk().ok_or(TcompError::Settings)?;
        let step = f64::from_le_bytes(*step);
        axis.encoder_resolution = (step != 0.0).then_some(step);
        rest = behind;
    }
    Ok(rest)
}

/// Figures of an axis' servo that version 7 added: the lag that is compensated (s), then resonance (Hz), its damping (share
/// of critical) and lowest resonance (Hz), then the share by which friction adapts; 0: not stated.
pub fn additions(settings: &AxisSettings) -> [f64; 5] {
    let lag_s = settings.servo.dynamic.map_or(0.0, |dynamic| dynamic.lag_s);
    let drive = settings.servo.drive.as_ref();
    let [hz, damping, lowest] =
        drive.map_or([0.0; 3], |drive| [drive.resonance_hz, drive.resonance_damping, drive.lowest_resonance_hz]);
    let adapt = settings.servo.friction.map_or(0.0, |friction| friction.adapt);
    [lag_s, hz, damping, lowest, adapt]
}

/// Sets the [`additions`] of an axis; `None` if it has no place for one that is stated.
fn set_additions(settings: &mut AxisSettings, [lag_s, hz, damping, lowest, adapt]: [f64; 5]) -> Option<()> {
    match &mut settings.servo.friction {
        Some(friction) => friction.adapt = adapt,
        None if adapt != 0.0 => return None,
        None => {}
    }
    match &mut settings.servo.dynamic {
        Some(dynamic) => dynamic.lag_s = lag_s,
        None if lag_s != 0.0 => return None,
        None => {}
    }
    match &mut settings.servo.drive {
        Some(drive) => {
            (drive.resonance_hz, drive.resonance_damping, drive.lowest_resonance_hz) = (hz, damping, lowest);
            Some(())
        }
        None => (hz == 0.0 && damping == 0.0 && lowest == 0.0).then_some(()),
    }
}

/// Reads the additions, after the steps of the encoders.
fn read_additions<'a>(settings: &mut MachineSettings, mut rest: &'a [u8]) -> Result<&'a [u8], TcompError> {
    for axis in &mut settings.axes {
        let mut figures = [0.0; 5];
        for figure in &mut figures {
            let (bytes, behind) = rest.split_first_chunk().ok_or(TcompError::Settings)?;
            *figure = f64::from_le_bytes(*bytes);
            rest = behind;
        }
        set_additions(axis, figures).ok_or(TcompError::Settings)?;
    }
    Ok(rest)
}

/// Factor on the gains of the contour feedback that an axis' resonance permits without a notch, which its drive has; 0: none.
pub fn notch(settings: &AxisSettings) -> f64 {
    settings.servo.drive.map_or(0.0, |drive| drive.gain_without_notch)
}

/// Reads the [`notch`] of every axis after the additions, if the file has them.
fn read_notches<'a>(settings: &mut MachineSettings, rest: &'a [u8], version: u16) -> Result<&'a [u8], TcompError> {
    let length = 8 * settings.axes.len();
    if version == VERSION_WITHOUT_PERIODS && rest.len() != length {
        return Ok(rest);
    }
    let (notches, rest) = rest.split_at_checked(length).ok_or(TcompError::Settings)?;
    for (axis, bytes) in settings.axes.iter_mut().zip(notches.as_chunks::<8>().0) {
        let gain = f64::from_le_bytes(*bytes);
        match &mut axis.servo.drive {
            Some(drive) => drive.gain_without_notch = gain,
            None if gain != 0.0 => return Err(TcompError::Settings),
            None => {}
        }
    }
    Ok(rest)
}

/// Reads the periods at the end: their number, at least one, then each.
fn read_periods(rest: &mut &[u8], periods: &mut Vec<PeriodicSettings, PERIODIC_CAPACITY>) -> Result<(), TcompError> {
    let ([count], mut behind) = rest.split_first_chunk().ok_or(TcompError::Settings)?;
    if *count == 0 {
        return Err(TcompError::Settings);
    }
    for _ in 0..*count {
        let (Stored(period), after) = decoded::<Stored<PeriodicSettings>>(behind).ok_or(TcompError::Settings)?;
        periods.push(period).map_err(|_| TcompError::Settings)?;
        behind = after;
    }
    *rest = behind;
    Ok(())
}

/// Reads the grids after the tables: their number, then each; in version 5 at least one.
fn read_grids<'a>(rest: &mut &'a [u8], version: u16, grids: &mut Vec<GridData<'a>, GRIDS>) -> Result<(), TcompError> {
    let ([count], mut behind) = rest.split_first_chunk().ok_or(TcompError::GridHeader)?;
    if *count == 0 && version == VERSION_WITHOUT_ENCODERS {
        return Err(TcompError::GridHeader);
    }
    if *count > 0 && part::GRIDS.is_none() {
        return Err(TcompError::Content(ConfigError::left_out(Part::Grids, Field::GridTable)));
    }
    for _ in 0..*count {
        let (Stored(header), bytes) = decoded::<Stored<GridHeader>>(behind).ok_or(TcompError::GridHeader)?;
        let (grid, after) = GridData::new(header, bytes).ok_or(TcompError::GridTooLong)?;
        grids.push(grid).map_err(|_| TcompError::GridHeader)?;
        behind = after;
    }
    *rest = behind;
    Ok(())
}

#[cfg(test)]
mod tests;
