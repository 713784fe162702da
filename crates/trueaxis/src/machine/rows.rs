//! Lines of an error table, independent of their storage.

use super::{Axis, AxisSettings, Interpolation, MachineSettings, Row};

/// The lines of a table by index: implemented for slices and for the lines of a compiled file.
pub trait Rows {
    /// Number of lines.
    fn len(&self) -> usize;
    /// Line `index`, in ascending order of position.
    fn row(&self, index: usize) -> Option<Row>;
    /// Whether the table has no lines.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Rows for [Row] {
    fn len(&self) -> usize {
        <[Row]>::len(self)
    }
    fn row(&self, index: usize) -> Option<Row> {
        self.get(index).copied()
    }
}

/// Lines in which the step looks an axis up: those of its table, or zeros for an axis with lost motion but no table.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lines<'r, T: ?Sized> {
    /// A table.
    Table(&'r T),
    /// Two lines of zeros at these positions, mm (deg).
    Zeros([f64; 2]),
}

/// Ends of the zeros of a linear axis without a declared travel, mm: in single precision its coordinates keep 0.1 µm.
const UNDECLARED: [f64; 2] = [-1000.0, 1000.0];
/// Extent of the zeros beyond a declared travel, mm (deg): farther than a correction moves a lookup, so that no axis is
/// reported at the edge of a table that it does not have.
const BEYOND_TRAVEL: f64 = 10.0;

impl<'r, T: Rows + ?Sized + 'r> Lines<'r, T> {
    /// The lines of an axis, and its settings adapted to them; `None` for an axis with neither a table nor lost motion.
    ///
    /// Zeros extend [`BEYOND_TRAVEL`] past the declared travel, or over one turn if a rotary axis can then rotate fully.
    /// They are interpolated like the machine's first table, so that they use the same loop as the others.
    pub(crate) fn of(
        machine: &MachineSettings,
        rows: impl Fn(Axis) -> Option<&'r T>,
        settings: &AxisSettings,
    ) -> Option<(Self, AxisSettings)> {
        if let Some(table) = rows(settings.axis) {
            return Some((Lines::Table(table), *settings));
        }
        if settings.backlash == 0.0 {
            return None;
        }
        let [low, high] = [settings.travel[0] - BEYOND_TRAVEL, settings.travel[1] + BEYOND_TRAVEL];
        let ends = if settings.axis.is_rotary() && high - low >= 360.0 {
            [0.0, 360.0]
        } else if !settings.axis.is_rotary()
            && settings.travel == AxisSettings::with_defaults(settings.axis, false).travel
        {
            UNDECLARED
        } else {
            [low, high]
        };
        let first = machine.axes.iter().find(|other| rows(other.axis).is_some());
        let interpolation = first.map_or(Interpolation::Linear, |other| other.interpolation);
        Some((Lines::Zeros(ends), AxisSettings { interpolation, ..*settings }))
    }
}

impl<T: Rows + ?Sized> Rows for Lines<'_, T> {
    fn len(&self) -> usize {
        match self {
            Lines::Table(table) => table.len(),
            Lines::Zeros(ends) => ends.len(),
        }
    }
    fn row(&self, index: usize) -> Option<Row> {
        match self {
            Lines::Table(table) => table.row(index),
            Lines::Zeros(ends) => {
                ends.get(index).map(|position| Row { position: *position, forward: [0.0; 6], reverse: [0.0; 6] })
            }
        }
    }
}
