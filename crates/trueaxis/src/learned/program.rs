//! The id of a program's path.

use crate::tcomp::{CRC, Table};

/// Distance between the path points that enter the id, mm of path length.
pub const POINTS_EVERY_MM: u32 = 1;

/// Computes the id of a program: CRC-32/ISO-HDLC over its path, as integers, little-endian, eight bytes each:
///
/// 1. the path length in µm;
/// 2. for the points at every whole mm of path length from 0, and for the end: X, Y, Z in µm and A, B, C in thousandths
///    of a degree, rounded to the nearest, in the coordinates in which the program is commanded; 0 for an axis that is not
///    commanded.
///
/// The division of the path into lines and arcs does not matter; its place on the machine does, since the errors depend
/// on it. Computed once when a program is loaded, not in a cycle.
///
/// ```
/// use trueaxis::learned::ProgramId;
///
/// // A line of 2 mm along X.
/// let mut line = ProgramId::new(2.0);
/// for x in [0.0, 1.0, 2.0] {
///     line.point([x, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// }
/// assert_eq!(line.finish(), 0xf613_9514);
/// ```
pub struct ProgramId(crc::Digest<'static, u32, Table>);

impl ProgramId {
    /// Starts the id of a path of this length, mm.
    pub fn new(length_mm: f64) -> Self {
        let mut digest = CRC.digest();
        digest.update(&thousandths(length_mm).to_le_bytes());
        ProgramId(digest)
    }

    /// Adds the next point: X, Y, Z in mm, A, B, C in degrees.
    pub fn point(&mut self, coordinates: [f64; 6]) {
        coordinates.map(thousandths).iter().for_each(|value| self.0.update(&value.to_le_bytes()));
    }

    /// Returns the id.
    pub fn finish(self) -> u32 {
        self.0.finalize()
    }
}

impl core::fmt::Debug for ProgramId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("ProgramId")
    }
}

fn thousandths(value: f64) -> i64 {
    libm::round(1e3 * value) as i64
}
