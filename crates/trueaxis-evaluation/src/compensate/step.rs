//! The servo step's models: nine terms and twists.

use super::{Many, Model, NoCorrection, Place, PoseError, Settings};
use crate::model::{compensation, passes, thermal};
use anyhow::{Result, anyhow};
use trueaxis::compensation::{Batch, Compensation, Direction, Query, ThermalLine};
use trueaxis::machine::{AXES, AxisOrder};
use trueaxis_tables::Machine;

/// Builds the model of a machine on `N` slots of the step, in `memory`.
pub(super) fn model<'m, const N: usize>(
    machine: &'m Machine,
    settings: &Settings,
    memory: &'m mut Vec<f64>,
) -> Result<Box<dyn Model + 'm>> {
    let axes = AxisOrder::<N>::with_spare_slots(&machine.settings).map_err(|error| anyhow!("{error}"))?.axes();
    let passes = passes(machine, settings.passes)?;
    let thermal = thermal(machine, &axes, settings.kelvin);
    let compensation = compensation::<N>(machine, passes, memory)?;
    let many = compensation.batch().zip(thermal.first_chunk().copied());
    let many = many.map(|(batch, thermal)| OfSlides { batch, thermal });
    Ok(Box::new(Step { compensation, thermal, slots: axes.map(|axis| axis.index()), many }))
}

/// The nine terms of three slides.
struct OfSlides<'m> {
    batch: Batch<'m>,
    thermal: [ThermalLine<f64>; 3],
}

impl Many for OfSlides<'_> {
    fn errors(&self, positions: &[[f64; 3]], &[x, y, z, ..]: &[Direction; AXES], tips: &mut [[f64; 3]]) -> usize {
        self.batch.errors(positions, &[x, y, z], &self.thermal, tips)
    }

    fn corrections(
        &self,
        positions: &[[f64; 3]],
        &[x, y, z, ..]: &[Direction; AXES],
        corrections: &mut [[f64; 3]],
    ) -> usize {
        self.batch.corrections(positions, &[x, y, z], &self.thermal, corrections)
    }
}

struct Step<'m, const N: usize> {
    compensation: Compensation<'m, f64, f64, N>,
    thermal: [ThermalLine<f64>; N],
    /// Index of every axis of the step.
    slots: [usize; N],
    many: Option<OfSlides<'m>>,
}

impl<const N: usize> Model for Step<'_, N> {
    fn error(&self, at: &Place) -> PoseError {
        let coordinates = self.compensation.coordinates(&self.slots.map(|slot| at.command[slot]));
        let directions = self.slots.map(|slot| at.directions[slot]);
        let mut clamped = 0;
        let error = self.compensation.pose_error(&Query::at(&coordinates, &directions, &self.thermal), &mut clamped);
        PoseError { tip: error.tip.into(), orientation: error.orientation.into(), clamped: clamped != 0 }
    }

    fn correction(&self, at: &Place) -> Result<[f64; AXES], NoCorrection> {
        Ok(self.corrected(at).0)
    }

    fn correction_and_clamped(&self, at: &Place) -> Result<([f64; AXES], bool), NoCorrection> {
        let (correction, met) = self.corrected(at);
        // The passes also look up positions beside the command.
        Ok((correction, met && self.error(at).clamped))
    }

    fn batch(&self) -> Option<&dyn Many> {
        self.many.as_ref().map(|many| many as &dyn Many)
    }
}

impl<const N: usize> Step<'_, N> {
    /// The correction, and whether any of its passes met the end of a table; the first pass is at the command.
    fn corrected(&self, at: &Place) -> ([f64; AXES], bool) {
        let coordinates = self.compensation.coordinates(&self.slots.map(|slot| at.command[slot]));
        let directions = self.slots.map(|slot| at.directions[slot]);
        let mut clamped = 0;
        let found = self.compensation.correction(&Query::at(&coordinates, &directions, &self.thermal), &mut clamped);
        let mut correction = [0.0; AXES];
        for (slot, found) in self.slots.into_iter().zip(found) {
            correction[slot] = found;
        }
        (correction, clamped != 0)
    }
}
