//! Exact transforms.

use super::{Model, NoCorrection, Place, PoseError, Settings};
use crate::positions::in_order;
use anyhow::{Result, anyhow};
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{CorrectionSettings, Geometry};

/// An axis of the machine.
struct Own {
    axis: Axis,
    /// Ends of the axis' table, unless it wraps.
    ends: Option<[f64; 2]>,
}

pub(super) struct Exact {
    geometry: Geometry,
    settings: CorrectionSettings,
    /// Axes in the machine's order.
    axes: Vec<Own>,
}

impl Exact {
    pub(super) fn new(machine: &Machine, settings: &Settings) -> Result<Exact> {
        let geometry =
            Geometry::new(machine, settings.kelvin).map_err(|error| anyhow!("{}: {error}", machine.settings.name))?;
        let compensation = &machine.settings.compensation;
        let axes = machine.axes().map(|(own, table)| {
            let rows = table.map(|table| table.rows.as_slice());
            let rows = rows.filter(|rows| !trueaxis::machine::wraps(own.axis, *rows));
            let ends = rows.and_then(|rows| Some([rows.first()?.position, rows.last()?.position]));
            Own { axis: own.axis, ends }
        });
        Ok(Exact {
            geometry,
            settings: CorrectionSettings {
                passes: settings.passes,
                fade_deg: compensation.orientation.then_some(compensation.fade_deg),
            },
            axes: axes.collect(),
        })
    }

    /// Positions, and 1 for negative travel, 0 for positive.
    fn ordered(&self, at: &Place) -> [[f64; AXES]; 2] {
        let reverse = |direction| if direction == Direction::POSITIVE { 0.0 } else { 1.0 };
        [at.command, at.directions.map(reverse)].map(|all| in_order(self.axes.iter().map(|own| own.axis), &all))
    }
}

impl Model for Exact {
    fn error(&self, at: &Place) -> PoseError {
        let [position, reverse] = self.ordered(at);
        let error = self.geometry.pose_error(&position, &reverse);
        let beyond = |(own, q): (&Own, f64)| own.ends.is_some_and(|[low, high]| q < low || q > high);
        let clamped = self.axes.iter().zip(position).any(beyond);
        PoseError { tip: error.tip_mm, orientation: error.orientation, clamped }
    }

    fn correction(&self, at: &Place) -> Result<[f64; AXES], NoCorrection> {
        let [position, reverse] = self.ordered(at);
        let found = self.geometry.correction(&position, &reverse, self.settings).ok_or(NoCorrection)?;
        let mut correction = [0.0; AXES];
        for (own, found) in self.axes.iter().zip(found) {
            correction[own.axis.index()] = found;
        }
        Ok(correction)
    }
}
