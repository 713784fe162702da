//! A learned correction: three translations over the path length of one program, read in place from its file.
//!
//! Between two parts, the bench learns the remaining contour error of a program that repeats (`trueaxis learn`). The host
//! looks the correction up at the path length of its reference and passes it to the step as [`crate::Input::learned`];
//! the step only adds and limits it.
//!
//! All numbers are little-endian integers, so that nothing in the file can be NaN or infinite:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | magic `TRUELRND` |
//! | 2 | format version, 1 |
//! | 2 | number of parts learned from, 1 and up |
//! | 4 | machine id, as in the table file ([`crate::Tcomp::machine_id`]) |
//! | 4 | program id ([`ProgramId`]) |
//! | 8 | path length of the program, nm |
//! | 4 | spacing h of the nodes, nm: 1 to 10⁹ |
//! | 4 | resolution, pm: 1 to 10⁶ |
//! | 4 | number of nodes n: the path length over h, rounded up, plus one |
//! | 6 n | nodes: X, Y, Z as i16, in units of the resolution; node k is at path length k h |
//! | 4 | CRC-32/ISO-HDLC of everything before |
//!
//! Sixteen bits resolve 50 µm, the largest correction that the default limits pass, to 1.5 nm, finer than any encoder, in
//! half the memory of single precision. Translations are in machine directions, as added to the command, and linear
//! between nodes. The first and the last node are zero, and so is everything beyond: the correction does not jump at the
//! ends of a program.

#![deny(clippy::indexing_slicing)]

mod error;
mod layout;
mod program;

pub use error::LearnedError;
pub use program::ProgramId;

bench!(use layout::{
    COARSEST_RESOLUTION_PM, HEADER_BYTES, LENGTH_TOLERANCE_NM, LearnedHeader, MAGIC, NODE_BYTES, VERSION,
    WIDEST_SPACING_NM,
});
bench!(use program::POINTS_EVERY_MM);

use crate::real::Real;
use crate::tcomp::checksum;
use core::num::NonZeroU64;

/// A learned correction, checked; its nodes stay in the file's bytes.
///
/// `R` is the scalar of the step that uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learned<'a, R> {
    header: LearnedHeader,
    spacing: NonZeroU64,
    nodes: &'a [[u8; NODE_BYTES]],
    crc: u32,
    /// mm per unit of a node.
    resolution_mm: R,
    /// Nodes per nanometre.
    per_nm: R,
}

fn split<const N: usize>(bytes: &[u8]) -> Result<([u8; N], &[u8]), LearnedError> {
    bytes.split_first_chunk().map(|(first, rest)| (*first, rest)).ok_or(LearnedError::TooShort)
}

fn counts(node: &[u8; NODE_BYTES]) -> [i16; 3] {
    let [x, xx, y, yy, z, zz] = *node;
    [i16::from_le_bytes([x, xx]), i16::from_le_bytes([y, yy]), i16::from_le_bytes([z, zz])]
}

impl<'a, R: Real> Learned<'a, R> {
    /// Reads and checks a whole file: its form, its checksum, its values.
    ///
    /// Allocates nothing and never panics, whatever the bytes. Cost: linear in the file's length.
    ///
    /// # Errors
    /// The first defect found.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, LearnedError> {
        let (magic, rest) = split::<8>(bytes)?;
        if magic != MAGIC {
            return Err(LearnedError::Magic);
        }
        let (version, rest) = split::<2>(rest)?;
        if u16::from_le_bytes(version) != VERSION {
            return Err(LearnedError::Version);
        }
        let (header, count, rest) = header(rest)?;
        let length = usize::try_from(count).ok().and_then(|count| count.checked_mul(NODE_BYTES));
        let (nodes, sum) = length.and_then(|length| rest.split_at_checked(length)).ok_or(LearnedError::TooShort)?;
        let (sum, behind) = split::<4>(sum)?;
        if !behind.is_empty() {
            return Err(LearnedError::TooLong);
        }
        let crc = u32::from_le_bytes(sum);
        if bytes.get(..bytes.len().saturating_sub(4)).map(checksum) != Some(crc) {
            return Err(LearnedError::Checksum);
        }
        let spacing = NonZeroU64::new(header.spacing_nm.into()).ok_or(LearnedError::Spacing(0))?;
        check(&header, count)?;
        let nodes = nodes.as_chunks::<NODE_BYTES>().0;
        if [nodes.first(), nodes.last()].into_iter().flatten().any(|node| counts(node) != [0; 3]) {
            return Err(LearnedError::Ends);
        }
        Ok(Learned {
            header,
            spacing,
            nodes,
            crc,
            resolution_mm: R::of(1e-9 * f64::from(header.resolution_pm)),
            per_nm: R::of(1.0 / f64::from(header.spacing_nm)),
        })
    }

    /// Refuses the correction for any program except the one on which it was learned: `id` as of [`ProgramId`], path
    /// length in mm within 1 µm.
    ///
    /// # Errors
    /// [`LearnedError::WrongProgram`], [`LearnedError::WrongLength`], with both values.
    pub fn expect_program(&self, id: u32, length_mm: f64) -> Result<(), LearnedError> {
        if id != self.header.program_id {
            return Err(LearnedError::WrongProgram { found: self.header.program_id, needed: id });
        }
        let needed = nanometres(length_mm);
        if self.header.length_nm.abs_diff(needed) > LENGTH_TOLERANCE_NM {
            return Err(LearnedError::WrongLength { found_nm: self.header.length_nm, needed_nm: needed });
        }
        Ok(())
    }

    /// Refuses the correction on any machine except the one with this id.
    ///
    /// # Errors
    /// [`LearnedError::WrongMachine`], with both ids.
    pub fn expect_machine(&self, id: u32) -> Result<(), LearnedError> {
        let found = self.header.machine_id;
        if found == id { Ok(()) } else { Err(LearnedError::WrongMachine { found, needed: id }) }
    }

    /// Returns the correction in X, Y, Z at a path length in mm, mm; zero beyond the ends and for NaN.
    ///
    /// For hosts with double precision; [`Learned::at_nm`] computes only in integers and `R`.
    #[inline]
    pub fn at(&self, length_mm: f64) -> [R; 3] {
        self.at_nm(nanometres(length_mm))
    }

    /// Returns the correction in X, Y, Z at a path length in nm, mm; zero beyond the end.
    ///
    /// One integer division, two nodes, linear between them. Apart from rounding, never larger than the larger of the
    /// two; no panic.
    #[inline]
    pub fn at_nm(&self, length_nm: u64) -> [R; 3] {
        let (cell, rest) = (length_nm / self.spacing, length_nm % self.spacing);
        let cell = usize::try_from(cell).unwrap_or(usize::MAX);
        let next = cell.saturating_add(1);
        let (Some(here), Some(ahead)) = (self.nodes.get(cell), self.nodes.get(next)) else { return [R::ZERO; 3] };
        // Below the widest spacing, so the cast is lossless.
        let share = R::of_i32(rest as i32) * self.per_nm;
        let ([x, y, z], [xx, yy, zz]) = (counts(here), counts(ahead));
        [(x, xx), (y, yy), (z, zz)].map(|(here, ahead)| {
            let (here, ahead) = (R::of_i32(here.into()), R::of_i32(ahead.into()));
            self.resolution_mm * (here + share * (ahead - here))
        })
    }

    /// The nodes in order, mm.
    #[doc(hidden)]
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = [R; 3]> + '_ {
        self.nodes.iter().map(|node| counts(node).map(|count| self.resolution_mm * R::of_i32(count.into())))
    }

    /// Everything except the nodes.
    #[doc(hidden)]
    pub fn header(&self) -> &LearnedHeader {
        &self.header
    }

    /// Checksum at the end of the file.
    pub fn crc(&self) -> u32 {
        self.crc
    }
}

/// Converts mm to nm; zero for a negative value or NaN; saturates.
#[inline]
fn nanometres(length_mm: f64) -> u64 {
    (length_mm * 1e6 + 0.5) as u64
}

fn header(bytes: &[u8]) -> Result<(LearnedHeader, u32, &[u8]), LearnedError> {
    let (parts, rest) = split::<2>(bytes)?;
    let (machine_id, rest) = split::<4>(rest)?;
    let (program_id, rest) = split::<4>(rest)?;
    let (length_nm, rest) = split::<8>(rest)?;
    let (spacing_nm, rest) = split::<4>(rest)?;
    let (resolution_pm, rest) = split::<4>(rest)?;
    let (count, rest) = split::<4>(rest)?;
    let header = LearnedHeader {
        parts: u16::from_le_bytes(parts),
        machine_id: u32::from_le_bytes(machine_id),
        program_id: u32::from_le_bytes(program_id),
        length_nm: u64::from_le_bytes(length_nm),
        spacing_nm: u32::from_le_bytes(spacing_nm),
        resolution_pm: u32::from_le_bytes(resolution_pm),
    };
    Ok((header, u32::from_le_bytes(count), rest))
}

fn check(header: &LearnedHeader, count: u32) -> Result<(), LearnedError> {
    if !(1..=WIDEST_SPACING_NM).contains(&header.spacing_nm) {
        return Err(LearnedError::Spacing(header.spacing_nm));
    }
    if !(1..=COARSEST_RESOLUTION_PM).contains(&header.resolution_pm) {
        return Err(LearnedError::Resolution(header.resolution_pm));
    }
    if header.parts == 0 {
        return Err(LearnedError::Parts);
    }
    let needed = header.nodes().unwrap_or(0);
    // At least two nodes: a path has a length.
    if header.length_nm == 0 || u64::from(count) != needed {
        return Err(LearnedError::Nodes { found: count, needed });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
