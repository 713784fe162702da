//! Geometric error compensation: the errors that the tables give at a position, and the correction for them.
//!
//! Two models, chosen by the machine's settings: [`NineTerms`], axis-wise and without levers, and [`Volumetric`], the
//! twist of every axis carried to the tool tip by its lever. Grids over several axes add to either.

#[cfg(feature = "bench")]
mod batch;
mod cells;
mod grid;
mod key;
mod nine;
mod periodic;
mod query;
mod reversal;
mod squareness;
mod table;
mod thermal;
pub mod trig;
pub(crate) mod volumetric;

#[cfg(feature = "bench")]
#[doc(hidden)]
pub use batch::Batch;
pub(crate) use cells::{Cells, InverseEnd, Source, Tables};
pub(crate) use grid::{CycleGrids, Grids, NearGrids};
pub use nine::NineTerms;
pub(crate) use periodic::Periods;
pub use query::Query;
pub use reversal::{Direction, Reversal};
pub(crate) use squareness::Squareness;
pub use table::{AxisTable, Contribution};
pub use thermal::ThermalLine;
pub use volumetric::Volumetric;

use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisOrder, ErrorModel, GridData, MachineSettings, Rows};
use crate::part::{self, Part};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Passes of the inverse are 1 to 8, but the compiler does not know that: masking the byte gives the loop a fixed bound.
pub(crate) const PASSES_MASK: u8 = 15;

/// Errors of all axes: the tip's dx, dy, dz in mm and the rotary axes' own errors in degrees, in the order of the axes.
pub type Errors<R, const N: usize> = [R; N];

/// Error of the tool's pose relative to the workpiece, actual − ideal, in bed axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct PoseError<R: Real> {
    /// Error of the tip, mm.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub tip: R::Vec3,
    /// Small rotation of the tool, rad: a tool axis t changes by `orientation × t`. Zero in the nine-term form.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub orientation: R::Vec3,
}

/// The tables of a machine under its error model: immutable, built once.
///
/// `N` axes: X, Y, Z first (an absent linear axis is a zero table), then the rotary axes of the chain.
#[derive(Clone, Copy, Debug)]
pub struct Compensation<'a, R, P, const N: usize> {
    model: Model<'a, R, P, N>,
    grids: Option<Grids<'a, R>>,
    passes: u8,
    periods: Periods<'a, R>,
}

#[derive(Clone, Copy, Debug)]
enum Model<'a, R, P, const N: usize> {
    Nine(NineTerms<'a, R, P, N>),
    Volumetric(Volumetric<'a, R, P, N>),
}

/// Memory that the tables of a machine need under either model, in scalars of the step.
///
/// Cost: reads every row once.
pub fn requirement<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
) -> usize {
    let of_periods = periodic::requirement(machine);
    if machine.compensation.is_volumetric() {
        of_periods + table::requirement_of_all::<6, T>(machine, rows)
    } else {
        of_periods + table::requirement_of_all::<4, T>(machine, rows)
    }
}

impl<'a, R: Real, P: Position, const N: usize> Compensation<'a, R, P, N> {
    /// Builds the tables of a machine in borrowed memory of [`requirement`] scalars. `passes` of the exact inverse: at
    /// least 1, at most 8. Grids are read where their bytes are stored.
    ///
    /// # Errors
    /// A table with fewer than two points or not ascending, memory too small, a structural code that cannot be read,
    /// more axes than `N`, `passes` out of range.
    pub fn build<'r, T: Rows + ?Sized + 'r>(
        machine: &MachineSettings,
        rows: impl Fn(Axis) -> Option<&'r T>,
        grids: &[GridData<'a>],
        passes: u8,
        memory: &'a mut [R],
    ) -> Result<Self, ConfigError> {
        Self::build_in(&AxisOrder::with_spare_slots(machine)?, machine, rows, grids, passes, memory)
    }

    /// [`Compensation::build`] with a known order of the axes.
    pub(crate) fn build_in<'r, T: Rows + ?Sized + 'r>(
        order: &AxisOrder<N>,
        machine: &MachineSettings,
        rows: impl Fn(Axis) -> Option<&'r T>,
        grids: &[GridData<'a>],
        passes: u8,
        memory: &'a mut [R],
    ) -> Result<Self, ConfigError> {
        if !(1..=8).contains(&passes) {
            return Err(ConfigError::new(Field::Inverse, f64::from(passes), "1 to 8 passes"));
        }
        if part::GRIDS.is_none() && !grids.is_empty() {
            return Err(ConfigError::left_out(Part::Grids, Field::GridTable));
        }
        table::enough(memory.len(), requirement(machine, &rows))?;
        let (periods, memory) = Periods::build::<P, N>(order, machine, memory)?;
        let model = match machine.compensation.model {
            ErrorModel::Nine => Model::Nine(NineTerms::build(order, machine, rows, memory)?),
            ErrorModel::Volumetric => Model::Volumetric(Volumetric::build(order, machine, rows, memory)?),
        };
        Ok(Compensation { model, grids: Grids::build(machine, grids), passes, periods })
    }

    /// Passes of the exact inverse.
    pub fn passes(&self) -> u8 {
        self.passes
    }

    /// The nine-term form, if that is the machine's model.
    pub fn nine_terms(&self) -> Option<&NineTerms<'a, R, P, N>> {
        match self.model() {
            Model::Nine(nine) => Some(nine),
            Model::Volumetric(_) => None,
        }
    }

    /// The volumetric form, if that is the machine's model.
    pub fn volumetric(&self) -> Option<&Volumetric<'a, R, P, N>> {
        match self.model() {
            Model::Nine(_) => None,
            Model::Volumetric(volumetric) => Some(volumetric),
        }
    }

    #[inline(always)]
    fn model(&self) -> &Model<'a, R, P, N> {
        if let Model::Volumetric(volumetric) = &self.model {
            volumetric.exists();
        }
        &self.model
    }

    /// The grids, if the machine has any.
    #[inline(always)]
    pub(crate) fn grids(&self) -> Option<&Grids<'a, R>> {
        self.grids.as_ref().inspect(|grids| grids.exist())
    }

    /// The periods, if the machine has any.
    #[inline(always)]
    pub(crate) fn periods(&self) -> Option<&Periods<'a, R>> {
        if self.periods.is_empty() { None } else { Some(&self.periods) }
    }

    /// Converts positions to table coordinates.
    #[inline(always)]
    pub fn coordinates(&self, positions: &[P; N]) -> [R; N] {
        match self.model() {
            Model::Nine(nine) => nine.coordinates(positions),
            Model::Volumetric(volumetric) => volumetric.coordinates(positions),
        }
    }

    /// Errors at a position: modelled deviation of the tip from the axis positions, and of the rotary axes.
    ///
    /// The rotary entries of the volumetric form are zero: the tip includes every error, and
    /// [`Compensation::pose_error`] returns the direction of the tool. Sets a bit in `clamped` for every axis whose
    /// edge value is used.
    #[inline(always)]
    pub fn errors(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> Errors<R, N> {
        let errors = self.errors_of_tables(query, clamped);
        if self.periods().is_some() { self.with_periods(query, errors) } else { errors }
    }

    /// [`Compensation::errors`] without periods.
    #[inline(always)]
    pub(crate) fn errors_of_tables(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> Errors<R, N> {
        let mut errors = match self.model() {
            Model::Nine(nine) => nine.errors(query, clamped),
            Model::Volumetric(volumetric) => {
                let mut errors = [R::ZERO; N];
                let pose = volumetric.pose_error(query, clamped);
                for (error, tip) in errors.iter_mut().zip(pose.tip.into()) {
                    *error = tip;
                }
                errors
            }
        };
        if let Some(grids) = self.grids() {
            let (tip, _) = self.of_grids(grids, query.command, clamped);
            for (error, tip) in errors.iter_mut().zip(tip.array()) {
                *error += tip;
            }
        }
        errors
    }

    /// Adds the errors of the periods.
    // Only with periods.
    #[inline(never)]
    fn with_periods(&self, query: &Query<'_, R, N>, mut errors: [R; N]) -> [R; N] {
        for (sum, [error, _]) in errors.iter_mut().zip(self.of_periods(query.command, query.directions)) {
            *sum += error;
        }
        errors
    }

    /// Errors of the periods and their slopes, from table coordinates.
    // Only with periods.
    #[inline(never)]
    fn of_periods(&self, at: &[R; N], directions: &[Direction; N]) -> [[R; 2]; N] {
        let origins = match self.model() {
            Model::Nine(nine) => &nine.origins,
            Model::Volumetric(volumetric) => volumetric.origins(),
        };
        let mut found = [[R::ZERO; 2]; N];
        let axes = at.iter().zip(origins).zip(directions).enumerate();
        for (found, (slot, ((at, origin), direction))) in found.iter_mut().zip(axes) {
            *found = self.periods.of_axis(slot, *at + *origin, *direction);
        }
        found
    }

    /// Errors of tip and direction that the grids add at a position in table coordinates.
    #[inline(never)]
    fn of_grids(&self, grids: &Grids<'_, R>, at: &[R; N], clamped: &mut u8) -> (V3<R>, V3<R>) {
        let sum = match self.model() {
            Model::Nine(nine) => grids.of_slides(&nine.slides(at)),
            Model::Volumetric(volumetric) => volumetric.of_grids(grids, at),
        };
        *clamped |= sum.edge;
        (sum.tip, sum.turn)
    }

    /// Error of the tool's pose at a position; arguments as for [`Compensation::errors`].
    #[inline]
    pub fn pose_error(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> PoseError<R> {
        let pose = self.pose_error_of_tables(query, clamped);
        if self.periods().is_none() {
            return pose;
        }
        let errors = self.with_periods(query, [R::ZERO; N]);
        let tip = errors.first_chunk().copied().unwrap_or_default();
        PoseError { tip: (V3::from_glam(pose.tip) + V3::from(tip)).glam(), ..pose }
    }

    /// [`Compensation::pose_error`] without periods.
    #[inline]
    pub(crate) fn pose_error_of_tables(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> PoseError<R> {
        let pose = match self.model() {
            Model::Nine(nine) => {
                let mut error_of_tip = [R::ZERO; 3];
                for (tip, error) in error_of_tip.iter_mut().zip(nine.errors(query, clamped)) {
                    *tip = error;
                }
                PoseError { tip: error_of_tip.into(), ..PoseError::default() }
            }
            Model::Volumetric(volumetric) => volumetric.pose_error(query, clamped),
        };
        let Some(grids) = self.grids() else { return pose };
        let (tip, turn) = self.of_grids(grids, query.command, clamped);
        PoseError {
            tip: (V3::from_glam(pose.tip) + tip).glam(),
            orientation: (V3::from_glam(pose.orientation) + turn).glam(),
        }
    }

    /// The wanted correction `r`, with which the pose at `q + r`, errors included, is the ideal pose at `q`.
    ///
    /// mm, rotary axes in degrees. Nine terms: `r ← −E(q + r)` from `r = 0`, [`NineTerms::correction`]; volumetric:
    /// [`Volumetric::correction`]; both include grids and periods. Errors looked up at the feedback need no inverse and are
    /// used as read.
    #[inline(always)]
    pub fn correction(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> [R; N] {
        match self.periods() {
            None => self.correction_of_tables(query, clamped),
            Some(_) => self.correction_with_periods(query, clamped),
        }
    }

    /// [`Compensation::correction`] without periods.
    #[inline(always)]
    pub(crate) fn correction_of_tables(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> [R; N] {
        let passes = self.passes;
        match (self.model(), self.grids()) {
            (Model::Nine(nine), None) => nine.correction(query, passes, clamped),
            (Model::Nine(_), Some(_)) => self.correction_with_grids(query, passes, clamped),
            (Model::Volumetric(volumetric), grids) => volumetric.correction_with(query, grids, passes, clamped),
        }
    }

    /// Correction of tables and periods: `r = r_t + s`, `r_t` the tables' at `q + s`, `s = −E(q + r_t + s)`.
    // Only with periods.
    #[inline(never)]
    fn correction_with_periods(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> [R; N] {
        let (mut moved, mut correction, mut own) = (*query.command, [R::ZERO; N], [R::ZERO; N]);
        // At most 3 rounds: each has a step of Newton's method for the periods.
        for _ in 0..3 {
            correction = self.correction_of_tables(&Query { command: &moved, ..*query }, clamped);
            let mut drive = moved;
            for (drive, r) in drive.iter_mut().zip(&correction) {
                *drive += *r;
            }
            let errors = self.of_periods(&drive, query.directions);
            for ((s, [error, slope]), (moved, q)) in own.iter_mut().zip(errors).zip(moved.iter_mut().zip(query.command))
            {
                *s = (slope * *s - error) / (R::ONE + slope);
                *moved = *q + *s;
            }
        }
        for (r, s) in correction.iter_mut().zip(own) {
            *r += s;
        }
        correction
    }

    /// [`NineTerms::correction`] with nine terms and grids.
    #[inline(never)]
    fn correction_with_grids(&self, query: &Query<'_, R, N>, passes: u8, clamped: &mut u8) -> [R; N] {
        let mut at = *query.command;
        let mut correction = [R::ZERO; N];
        // At most 8 rounds: more passes are refused when the tables are built.
        for _ in 0..passes & PASSES_MASK {
            let errors = self.errors_of_tables(&Query { command: &at, ..*query }, clamped);
            for (((r, at), q), error) in correction.iter_mut().zip(&mut at).zip(query.command).zip(errors) {
                *r = -error;
                *at = *q - error;
            }
        }
        correction
    }
}

#[cfg(test)]
mod tests;
