//! A machine as it was drawn.

use trueaxis::Axis;
use trueaxis::machine::{MachineSettings, Row};

/// Settings, and a table for every axis that has one, in the order of the settings' axes.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// Everything but the tables.
    pub settings: MachineSettings,
    /// The tables.
    pub tables: Vec<Option<Vec<Row>>>,
}

impl Drawn {
    /// Table of an axis.
    pub(super) fn rows(&self, axis: Axis) -> Option<&[Row]> {
        let place = self.settings.axes.iter().position(|settings| settings.axis == axis)?;
        self.tables[place].as_deref()
    }
}
