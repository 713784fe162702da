//! The decoders of bytes from outside, each under a separate name: for any bytes, of any length.
//!
//! Telemetry frames are not among them: the decoders of COBS and postcard do not link, as the compiler cannot prove their
//! bounds.

use crate::Proved;
use trueaxis::Row;
use trueaxis::learned::{Learned, LearnedError};
use trueaxis::tcomp::TableData;

type R = crate::symbols::R;

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_table_row(table: &TableData<'_>, index: usize) -> Option<Row> {
    table.row(index)
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_learned_parse(bytes: &'static [u8]) -> Result<Learned<'static, R>, LearnedError> {
    Learned::parse(bytes)
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_learned_at(learned: &Learned<'_, R>, length_nm: u64) -> [R; 3] {
    learned.at_nm(length_nm)
}

/// All of them.
pub static TABLE: &[Proved] = &[
    Proved(proved_table_row as *const ()),
    Proved(proved_learned_parse as *const ()),
    Proved(proved_learned_at as *const ()),
];
