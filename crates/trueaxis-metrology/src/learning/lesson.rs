//! Learns the correction for the next part from the record of one part.

use super::{GAP_OF_CUTOFF, Law, MeasuredError, NotLearned, Resampled, encode, resample};
use std::vec::Vec;
use trueaxis::learned::{Learned, LearnedHeader};

/// Machine and program of a record and a correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identity {
    /// Id of the machine, [`trueaxis::tcomp::machine_id`].
    pub machine_id: u32,
    /// Id of the program's path, [`trueaxis::learned::ProgramId`].
    pub program_id: u32,
    /// Path length of the program, mm.
    pub length_mm: f64,
}

/// Result of learning from a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Lesson {
    /// Header of the correction's file.
    pub header: LearnedHeader,
    /// Spacing of the nodes, mm.
    pub spacing_mm: f64,
    /// Contour error of the part at the nodes, mm.
    pub errors_mm: Vec<[f64; 3]>,
    /// Correction that acted on the part, mm.
    pub before_mm: Option<Vec<[f64; 3]>>,
    /// Correction for the next part, mm.
    pub correction_mm: Vec<[f64; 3]>,
}

impl Lesson {
    /// Learns from the rows of a part made with the correction `before`; the caller must check that `before` belongs to
    /// `identity` ([`Learned::expect_program`]).
    ///
    /// # Errors
    /// As [`Law::check`] and [`resample`].
    pub fn learn(
        law: &Law,
        identity: &Identity,
        before: Option<&Learned<'_, f64>>,
        rows: &[MeasuredError],
    ) -> Result<Lesson, NotLearned> {
        law.check()?;
        let spacing_mm = law.spacing_mm(identity.length_mm);
        let gap_mm = GAP_OF_CUTOFF * law.cutoff_mm;
        let Resampled { errors_mm, .. } = resample(rows, identity.length_mm, spacing_mm, gap_mm)?;
        let at_nodes = |old: &Learned<'_, f64>| (0..errors_mm.len()).map(|k| old.at(k as f64 * spacing_mm)).collect();
        let before_mm: Option<Vec<[f64; 3]>> = before.map(at_nodes);
        let correction_mm = law.update(before_mm.as_deref(), &errors_mm, spacing_mm)?;
        let header = LearnedHeader {
            parts: before.map_or(0, |old| old.header().parts).saturating_add(1),
            machine_id: identity.machine_id,
            program_id: identity.program_id,
            length_nm: (1e6 * identity.length_mm).round() as u64,
            spacing_nm: (1e6 * spacing_mm).round() as u32,
            resolution_pm: 1,
        };
        Ok(Lesson { header, spacing_mm, errors_mm, before_mm, correction_mm })
    }

    /// Encodes the correction as a file.
    ///
    /// # Errors
    /// As [`encode`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, NotLearned> {
        encode(self.header, &self.correction_mm)
    }
}
