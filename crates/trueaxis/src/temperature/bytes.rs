//! Reads numbers in sequence from the bytes of a file.

use super::ThermalError;

/// The bytes that have not been read yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    #[inline]
    fn next<const N: usize>(&mut self) -> Result<[u8; N], ThermalError> {
        let (first, rest) = self.0.split_first_chunk().ok_or(ThermalError::TooShort)?;
        self.0 = rest;
        Ok(*first)
    }

    pub(super) fn u8(&mut self) -> Result<u8, ThermalError> {
        self.next::<1>().map(|[byte]| byte)
    }

    pub(super) fn u16(&mut self) -> Result<u16, ThermalError> {
        self.next().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, ThermalError> {
        self.next().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Result<i32, ThermalError> {
        self.next().map(i32::from_le_bytes)
    }

    pub(super) fn i64(&mut self) -> Result<i64, ThermalError> {
        self.next().map(i64::from_le_bytes)
    }

    pub(super) fn magic(&mut self) -> Result<[u8; 8], ThermalError> {
        self.next()
    }

    /// Borrows the next `count` pieces of `N` bytes.
    pub(super) fn pieces<const N: usize>(&mut self, count: usize) -> Result<&'a [[u8; N]], ThermalError> {
        let (pieces, rest) = self.0.split_at_checked(count.saturating_mul(N)).ok_or(ThermalError::TooShort)?;
        self.0 = rest;
        Ok(pieces.as_chunks().0)
    }
}

/// Two signed numbers.
pub(super) fn pair(piece: &[u8; 8]) -> [i32; 2] {
    let [a, b, c, d, e, f, g, h] = *piece;
    [i32::from_le_bytes([a, b, c, d]), i32::from_le_bytes([e, f, g, h])]
}
