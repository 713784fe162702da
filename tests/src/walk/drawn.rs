//! A machine as it was drawn.

use trueaxis::Axis;
use trueaxis::machine::{GridData, GridHeader, MachineSettings, Row};

/// Settings, a table for every axis that has one, in the order of the settings' axes, and grids.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// Everything but the tables.
    pub settings: MachineSettings,
    /// The tables.
    pub tables: Vec<Option<Vec<Row>>>,
    /// The grids, each with its stored bytes.
    pub grids: Vec<(GridHeader, Vec<u8>)>,
}

impl Drawn {
    /// Table of an axis.
    pub(super) fn rows(&self, axis: Axis) -> Option<&[Row]> {
        let place = self.settings.axes.iter().position(|settings| settings.axis == axis)?;
        self.tables[place].as_deref()
    }

    /// The grids as a compiled file lends them.
    pub(super) fn grids(&self) -> Vec<GridData<'_>> {
        let grids = self.grids.iter().map(|(header, bytes)| GridData::new(*header, bytes).expect("enough bytes").0);
        grids.collect()
    }
}
