//! Reads, checks, converts and compiles compensation tables.

mod additions;
mod change;
pub mod collapse;
mod compile;
mod correlated;
mod document;
mod dynamic_needs;
mod edit;
pub mod error;
pub mod exact;
pub mod files;
pub mod finding;
pub mod formats;
mod grid;
pub mod limits;
mod lost_motion;
mod margins;
mod origin;
pub mod output;
mod periods;
mod printable;
mod rates;
mod read;
pub mod sheet;
mod summary;
pub mod text;
pub mod uncertainty;
mod warning;

pub use additions::Additions;
pub use change::{Change, Setting, change, changes};
pub use compile::{build, compile};
pub use document::Edited;
pub use dynamic_needs::{DynamicNeed, dynamic_needs};
pub use grid::{Grid, GridSource, TooFine};
pub use lost_motion::{LostMotion, lost_motion};
pub use margins::{FeedbackMargins, Notched, feedback_margins, feedback_margins_within, feedback_within};
pub use output::write_atomically;
pub use periods::FoundPeriod;
pub use rates::{DriveRate, rates};
pub use read::keys::{Keys, Written};
pub use read::section::{KeyValue, Section, read_toml};
pub use read::table_text::{ColumnText, TableText, table_texts};
pub use summary::{
    AxisSummary, CrosstalkSummary, DriveSummary, DynamicSummary, ErrorSummary, FeedbackSummary, FrictionSummary,
    GridAxisSummary, GridErrorSummary, GridSummary, PeriodSummary, RoundnessSummary, ServoSummary, Summary,
    TableSummary, summary,
};
pub use warning::{Term, Warning, check};

use trueaxis::machine::{AxisSettings, GridData, LocationErrors, MachineSettings, Row};
use trueaxis::tcomp::Tcomp;

/// An axis' error table in source form: mm and radians, positions in mm or degrees, strictly increasing.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Which of the six errors the file states (the others are zero).
    pub given: [bool; 6],
    /// Whether forward and reverse differ in any column.
    pub bidirectional: bool,
    /// The lines, at least two.
    pub rows: Vec<Row>,
}

/// A machine as read from `machine.toml` and its axis tables, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Everything but the tables.
    pub settings: MachineSettings,
    /// One entry per axis of `settings.axes`, in the same order; an axis without a table has `None`.
    pub tables: Vec<Option<Table>>,
    /// Errors over several axes, which add to those of the tables.
    pub grids: Vec<Grid>,
}

impl Machine {
    /// The machine of a compiled file: settings, every line of every table and every node of every grid, bit for bit; not the
    /// notches, which follow from the settings.
    pub fn from_tcomp(file: &Tcomp<'_>) -> Machine {
        let tables = file.axes().map(|(_, table)| {
            table.map(|table| Table {
                given: table.given(),
                bidirectional: table.bidirectional(),
                rows: table.rows().collect(),
            })
        });
        let grids = file.grids().iter().map(Grid::from_data).collect();
        let mut settings = file.settings().clone();
        // Decided again from the other figures when the machine is compiled.
        settings
            .axes
            .iter_mut()
            .flat_map(|axis| &mut axis.servo.drive)
            .for_each(|drive| drive.gain_without_notch = 0.0);
        Machine { settings, tables: tables.collect(), grids }
    }

    /// The machine with every entry of its tables and grids times `share`, as if they were only partly trusted. Squareness,
    /// backlash and everything else stay.
    pub fn with_tables_scaled(mut self, share: f64) -> Machine {
        for row in self.tables.iter_mut().flatten().flat_map(|table| &mut table.rows) {
            row.forward.iter_mut().chain(&mut row.reverse).for_each(|error| *error *= share);
        }
        self.grids.iter_mut().for_each(|grid| *grid = grid.scaled(share));
        self
    }

    /// Whether tables, grids or settings (location errors, lost motion, thermal growth) state any error.
    pub fn states_errors(&self) -> bool {
        let axis = |own: &AxisSettings| {
            own.backlash != 0.0 || own.thermal.offset_per_k != 0.0 || own.thermal.expansion_per_k != 0.0
        };
        self.tables.iter().any(Option::is_some)
            || !self.grids.is_empty()
            || !self.settings.periodic.is_empty()
            || self.settings.location != LocationErrors::default()
            || self.settings.axes.iter().any(axis)
    }

    /// The grids as the controller reads them.
    pub fn grids(&self) -> Vec<GridData<'_>> {
        self.grids.iter().map(Grid::data).collect()
    }

    /// The axes with their tables.
    pub fn axes(&self) -> impl Iterator<Item = (&AxisSettings, Option<&Table>)> {
        self.settings.axes.iter().zip(self.tables.iter().map(Option::as_ref))
    }
}
