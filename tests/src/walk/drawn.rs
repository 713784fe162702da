//! A randomly drawn machine.

use trueaxis::Axis;
use trueaxis::machine::{GridData, GridHeader, MachineSettings, Row};

/// Settings, a table for every axis that has one, in the order of the settings' axes, and grids.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// All settings except the tables.
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

    /// The grids as borrowed from a compiled file.
    pub(super) fn grids(&self) -> Vec<GridData<'_>> {
        let grids = self.grids.iter().map(|(header, bytes)| GridData::new(*header, bytes).expect("enough bytes").0);
        grids.collect()
    }
}
