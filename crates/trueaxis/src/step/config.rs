//! Settings of a servo loop, and one call for the usual ones.

#![deny(clippy::indexing_slicing)]

use super::ServoLoop;
use crate::axis::{AXES, Axis};
use crate::check::GridBounds;
use crate::compensation::{self, Compensation, Grids, Tables};
use crate::contour::{ContourSearch, Method};
use crate::dynamic::DynamicStage;
use crate::error::{ConfigError, Field};
use crate::machine::{AxisOrder, AxisSettings, GridData, MachineSettings, Rows};
use crate::output::OutputStage;
use crate::position::Position;
use crate::real::Real;
use crate::sample::Sampler;
use crate::tcomp::Tcomp;

/// A drive within this share of its band has not reversed, however the comparison rounds in the step's scalar.
const WITHIN: f64 = 1.0 - 1e-6;

/// Settings of a servo loop, for a host that needs others than [`ServoLoop::load`] chooses.
#[derive(Clone, Copy, Debug)]
pub struct Config<'m, 'g> {
    /// The machine's settings.
    pub machine: &'m MachineSettings,
    /// Its grids, at most [`GRIDS`](crate::machine::GRIDS); the loop reads their nodes in place for as long as it is
    /// used.
    pub grids: &'m [GridData<'g>],
    /// Identity of the machine ([`crate::tcomp::Tcomp::machine_id`]); goes into every record.
    pub machine_id: u32,
    /// CRC-32 of the table file; goes into every record.
    pub tables_crc: u32,
    /// Servo period.
    pub period_ns: u32,
    /// Passes of the exact inverse, 1 to 8; [`crate::check::machine_passes`] returns the number that a machine needs.
    pub inverse_passes: u8,
    /// Method of the foot-point search.
    pub method: Method,
}

impl<'m, 'g> Config<'m, 'g> {
    /// The configuration described by a compiled table file, with guarded search and the number of passes that the tables
    /// need.
    pub fn of(file: &'m Tcomp<'g>, period_ns: u32) -> Self {
        Config {
            machine: file.settings(),
            grids: file.grids(),
            machine_id: file.machine_id(),
            tables_crc: file.crc(),
            period_ns,
            inverse_passes: file.inverse_passes(),
            method: Method::Guarded,
        }
    }

    /// Checks all settings once and precomputes the per-cycle data in `memory` of at least [`Config::requirement`]
    /// scalars.
    ///
    /// # Errors
    /// The first wrong setting, with the value found and the one needed; [`Field::Memory`] if the memory is too small.
    pub fn build<'a, 'r, R: Real, P: Position, const N: usize, T: Rows + ?Sized + 'r>(
        &self,
        rows: impl Fn(Axis) -> Option<&'r T>,
        memory: &'a mut [R],
    ) -> Result<ServoLoop<'a, R, P, N>, ConfigError>
    where
        'g: 'a,
    {
        self.build_in(AxisOrder::of, rows, memory)
    }

    /// [`Config::build`] of a step that may have more slots than the machine has axes
    /// ([`AxisOrder::with_spare_slots`]): for a host that compiles one step for all machines. Positions in spare slots are
    /// passed on as they are.
    ///
    /// # Errors
    /// As [`Config::build`].
    pub fn build_with_spare_slots<'a, 'r, R: Real, P: Position, const N: usize, T: Rows + ?Sized + 'r>(
        &self,
        rows: impl Fn(Axis) -> Option<&'r T>,
        memory: &'a mut [R],
    ) -> Result<ServoLoop<'a, R, P, N>, ConfigError>
    where
        'g: 'a,
    {
        self.build_in(AxisOrder::with_spare_slots, rows, memory)
    }

    fn build_in<'a, 'r, R: Real, P: Position, const N: usize, T: Rows + ?Sized + 'r>(
        &self,
        order: fn(&MachineSettings) -> Result<AxisOrder<N>, ConfigError>,
        rows: impl Fn(Axis) -> Option<&'r T>,
        memory: &'a mut [R],
    ) -> Result<ServoLoop<'a, R, P, N>, ConfigError>
    where
        'g: 'a,
    {
        if !(3..=AXES).contains(&N) {
            return Err(ConfigError::new(Field::Axes, N as f64, "3 to 6 axes"));
        }
        if !(1_000..=100_000_000).contains(&self.period_ns) {
            return Err(ConfigError::new(Field::Period, f64::from(self.period_ns) * 1e-9, "1e-6 s to 0.1 s"));
        }
        // Behind `dyn`, whatever the closure's type, so that a firmware contains one copy of the checks.
        let rows: &dyn Fn(Axis) -> Option<&'r T> = &rows;
        crate::check::settings(self.machine)?;
        crate::check::grids(self.machine, self.grids)?;
        let order = order(self.machine)?;
        let bands = order.settings(self.machine).map(|settings| settings.map_or(0.0, |s| s.hysteresis));
        let compensation = Compensation::build_in(&order, self.machine, rows, self.grids, self.inverse_passes, memory)?;
        let bounds = GridBounds::of(self.grids);
        crate::check::reversal(self.machine, rows, &bounds)?;
        let period_s = f64::from(self.period_ns) * 1e-9;
        crate::check::feedback(self.machine, period_s)?;
        let in_a_cycle = |per_s: fn(&AxisSettings) -> f64| {
            let squares = self.machine.axes.iter().map(|axis| per_s(axis) * period_s * per_s(axis) * period_s);
            libm::sqrt(squares.sum())
        };
        let motion = self.machine.faults.command_jump_factor * in_a_cycle(|axis| axis.max_feed_per_s);
        let norms = crate::check::jacobian_norms(self.machine, rows, &bounds);
        let changes = [motion, in_a_cycle(|axis| axis.limits.slope_per_s)];
        let grids = compensation.grids().map(Grids::key);
        let tables = Tables::new(compensation.nine_terms(), grids, norms, changes, self.inverse_passes);
        Ok(ServoLoop {
            order,
            sampler: Sampler::new(&order, self.machine, self.period_ns),
            compensation,
            tables,
            bands: bands.map(R::of),
            within: bands.map(|band| P::reach(band * WITHIN)),
            search: ContourSearch::new(self.machine.contour.max_lag_mm, self.method)?,
            output: OutputStage::new(&order, self.machine, period_s)?,
            dynamic: DynamicStage::new(&order, self.machine, period_s)?,
            machine_id: self.machine_id,
            tables_crc: self.tables_crc,
            period_ns: self.period_ns,
        })
    }

    /// Memory that [`Config::build`] needs, in scalars of the step.
    pub fn requirement<'r, T: Rows + ?Sized + 'r>(&self, rows: impl Fn(Axis) -> Option<&'r T>) -> usize {
        compensation::requirement(self.machine, rows)
    }
}

impl<'a, R: Real, P: Position, const N: usize> ServoLoop<'a, R, P, N> {
    /// Builds the servo loop of a compiled table file at a servo period, in borrowed `memory`.
    ///
    /// The nodes of the machine's grids stay in the file's bytes; each cycle reads them there.
    ///
    /// `memory` needs at least [`Tcomp::requirement`] scalars; `trueaxis tables show` prints the number. The contour search
    /// is guarded, and the inverse takes as many passes as the tables need.
    ///
    /// # Errors
    /// The first wrong setting, with the value found and the one needed; [`Field::Memory`] if the memory is too small.
    pub fn load(tables: &Tcomp<'a>, period_ns: u32, memory: &'a mut [R]) -> Result<Self, ConfigError> {
        Config::of(tables, period_ns).build(tables.rows(), memory)
    }
}
