//! Lines of an error table, wherever they are stored.

use super::{Axis, AxisSettings, Interpolation, MachineSettings, Row};

/// A table's lines by number: implemented for slices and for the lines of a compiled file.
pub trait Rows {
    /// Number of lines.
    fn len(&self) -> usize;
    /// Line `index`, in ascending order of position.
    fn row(&self, index: usize) -> Option<Row>;
    /// No lines at all.
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

/// Lines that the step looks an axis up in: those of its table or, of an axis without one that loses motion, zeros.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lines<'r, T: ?Sized> {
    /// A table.
    Table(&'r T),
    /// Two lines of zeros at these positions, mm (deg).
    Zeros([f64; 2]),
}

/// Ends of the zeros of a linear axis that declares no travel, mm: in single precision its coordinates keep 0.1 µm.
const UNDECLARED: [f64; 2] = [-1000.0, 1000.0];
/// How far zeros reach beyond a declared travel, mm (deg): farther than a correction leads a look-up, so that no axis is
/// reported at the edge of a table that it does not have.
const BEYOND_TRAVEL: f64 = 10.0;

impl<'r, T: Rows + ?Sized + 'r> Lines<'r, T> {
    /// The lines of an axis, and its settings as they hold for them; `None` where the direction of travel says nothing and there
    /// is no table.
    ///
    /// Zeros reach [`BEYOND_TRAVEL`] past the declared travel; where a rotary axis then turns right round, they go round once.
    /// They are interpolated as the machine's first table, so that they take the loop of the others.
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
