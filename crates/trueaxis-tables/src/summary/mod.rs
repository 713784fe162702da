//! Summary of a compiled file, for people and for programs.

mod grid;
mod periodic;
mod roundness;
mod servo;

pub use grid::{GridAxisSummary, GridErrorSummary, GridSummary};
pub use periodic::PeriodSummary;
pub use roundness::RoundnessSummary;
pub use servo::{CrosstalkSummary, DriveSummary, DynamicSummary, FeedbackSummary, FrictionSummary, ServoSummary};

use crate::text::micro;
use crate::text::short;
use serde::Serialize;
use std::fmt;
use trueaxis::machine::carries_workpiece;
use trueaxis::machine::{Axis, AxisSettings, ErrorModel, Interpolation, Lookup, MachineSettings};
use trueaxis::tcomp::{TableData, Tcomp};

/// Contents of a compiled file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the machine.
    pub name: String,
    /// Structural code.
    pub chain: String,
    /// Id of the machine, as in telemetry.
    pub machine_id: u32,
    /// Checksum over the file, as in telemetry.
    pub crc: u32,
    /// Tool vector, mm.
    pub tool_mm: [f64; 3],
    /// Tool axis with all axes at zero.
    pub tool_axis: [f64; 3],
    /// Error model of the step: `nine` or `volumetric`.
    pub model: &'static str,
    /// Whether the direction of the tool is corrected through the rotary axes.
    pub orientation: bool,
    /// Reference temperature of the tables, °C.
    pub reference_temperature_c: f64,
    /// Squareness A0Z, B0Z, C0Y, µrad.
    pub squareness_urad: [f64; 3],
    /// Look-up passes of the exact inverse.
    pub inverse_passes: u8,
    /// Memory that a servo loop needs for the tables, in scalars.
    pub memory_scalars: usize,
    /// The axes.
    pub axes: Vec<AxisSummary>,
    /// The grids.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub grids: Vec<GridSummary>,
    /// Contour feedback.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feedback: Option<FeedbackSummary>,
    /// Acceleration cross-talk.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub crosstalk: Vec<CrosstalkSummary>,
    /// Three-probe gauge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roundness: Option<RoundnessSummary>,
}

/// An axis of a compiled file. Positions and limits in the axis' unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisSummary {
    /// X, Y, Z, A, B or C.
    pub axis: char,
    /// Unit of positions and of everything below that states no unit: mm or deg.
    pub unit: &'static str,
    /// Whether the axis is on the workpiece side of the chain.
    pub carries_workpiece: bool,
    /// Sense of a rotary axis.
    pub direction: i8,
    /// Declared travel; `None`: not declared.
    pub travel: Option<[f64; 2]>,
    /// Range of the joint; `None`: travel not declared.
    pub joint: Option<[f64; 2]>,
    /// Top feed per second.
    pub max_feed_per_s: f64,
    /// Backlash, µm or µrad.
    pub backlash_micro: f64,
    /// Largest |correction|, µm or µrad.
    pub magnitude_micro: f64,
    /// Largest rate of the correction per second.
    pub slope_per_s: f64,
    /// Largest acceleration of the correction per second².
    pub acceleration_per_s2: f64,
    /// Drive, friction and dynamic correction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<ServoSummary>,
    /// Errors that repeat within a period.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub periodic: Vec<PeriodSummary>,
    /// The table.
    pub table: Option<TableSummary>,
}

/// A table of a compiled file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TableSummary {
    /// Number of lines.
    pub rows: usize,
    /// First and last position.
    pub range: [f64; 2],
    /// `linear` or `cubic`.
    pub interpolation: &'static str,
    /// Position at which the own error is looked up: `command` or `feedback`.
    pub lookup: &'static str,
    /// Position at which the other errors are looked up.
    pub cross_lookup: &'static str,
    /// Whether it has forward and reverse columns.
    pub bidirectional: bool,
    /// The given errors.
    pub errors: Vec<ErrorSummary>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// EXX and so on.
    pub name: String,
    /// um or urad.
    pub unit: &'static str,
    /// Largest |value| over both directions, in `unit`.
    pub max_abs: f64,
}

/// Sums up a compiled file.
pub fn summary(file: &Tcomp<'_>) -> Summary {
    let settings = file.settings();
    let location = &settings.location;
    Summary {
        name: settings.name.to_string(),
        chain: settings.chain.to_string(),
        machine_id: file.machine_id(),
        crc: file.crc(),
        tool_mm: settings.tool_mm,
        tool_axis: settings.kinematics.tool_axis,
        model: match settings.compensation.model {
            ErrorModel::Nine => "nine",
            ErrorModel::Volumetric => "volumetric",
        },
        orientation: settings.compensation.orientation,
        reference_temperature_c: settings.reference_temperature_c,
        squareness_urad: [location.a0z, location.b0z, location.c0y].map(|angle| angle * 1e6),
        inverse_passes: file.inverse_passes(),
        memory_scalars: file.requirement(),
        axes: file.axes().map(|(axis, table)| axis_summary(settings, axis, table)).collect(),
        grids: file.grids().iter().map(grid::grid).collect(),
        feedback: settings.contour.feedback.as_ref().map(servo::feedback),
        crosstalk: settings.crosstalk.iter().map(servo::crosstalk).collect(),
        roundness: settings.roundness.as_ref().and_then(roundness::roundness),
    }
}

fn axis_summary(machine: &MachineSettings, settings: &AxisSettings, table: Option<TableData<'_>>) -> AxisSummary {
    let axis = settings.axis;
    let declared = settings.travel != AxisSettings::with_defaults(axis, false).travel;
    AxisSummary {
        axis: axis.letter(),
        unit: if axis.is_rotary() { "deg" } else { "mm" },
        carries_workpiece: carries_workpiece(&machine.chain, axis),
        direction: settings.direction,
        travel: declared.then_some(settings.travel),
        joint: declared.then_some(settings.joint),
        max_feed_per_s: settings.max_feed_per_s,
        backlash_micro: micro(axis, settings.backlash),
        magnitude_micro: micro(axis, settings.limits.magnitude),
        slope_per_s: settings.limits.slope_per_s,
        acceleration_per_s2: settings.limits.acceleration_per_s2,
        servo: servo::servo(axis, &settings.servo),
        periodic: machine.periods_of(axis).map(periodic::period).collect(),
        table: table.map(|table| table_summary(settings, &table)),
    }
}

fn lookup(lookup: Lookup) -> &'static str {
    match lookup {
        Lookup::Command => "command",
        Lookup::Feedback => "feedback",
    }
}

fn table_summary(settings: &AxisSettings, table: &TableData<'_>) -> TableSummary {
    let mut most = [0.0_f64; 6];
    let mut range = [f64::NAN; 2];
    for (index, row) in table.rows().enumerate() {
        range = if index == 0 { [row.position; 2] } else { [range[0], row.position] };
        for ((most, forward), reverse) in most.iter_mut().zip(row.forward).zip(row.reverse) {
            *most = most.max(forward.abs()).max(reverse.abs());
        }
    }
    let columns = Axis::ALL.into_iter().zip(most).zip(table.given()).filter(|(_, given)| *given);
    TableSummary {
        rows: table.len(),
        range,
        interpolation: match settings.interpolation {
            Interpolation::Linear => "linear",
            Interpolation::Cubic => "cubic",
        },
        lookup: lookup(settings.lookup),
        cross_lookup: lookup(settings.cross_lookup),
        bidirectional: table.bidirectional(),
        errors: columns
            .map(|((direction, most), _)| ErrorSummary {
                name: format!("E{}{}", direction.letter(), settings.axis.letter()),
                unit: if direction.is_rotary() { "urad" } else { "um" },
                max_abs: most * if direction.is_rotary() { 1e6 } else { 1e3 },
            })
            .collect(),
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}   {}", self.name, self.chain)?;
        writeln!(f, "machine id {:08x}, crc {:08x}", self.machine_id, self.crc)?;
        let [x, y, z] = self.tool_mm.map(short);
        writeln!(f, "tool {x} {y} {z} mm, reference {} °C", short(self.reference_temperature_c))?;
        let through = if self.orientation { ", direction of the tool corrected" } else { "" };
        writeln!(f, "error model {}{through}", self.model)?;
        let [a0z, b0z, c0y] = self.squareness_urad;
        writeln!(f, "squareness A0Z {a0z:.1}, B0Z {b0z:.1}, C0Y {c0y:.1} µrad")?;
        writeln!(f, "exact inverse: {} look-ups", self.inverse_passes)?;
        let [double, single] = [8, 4].map(|bytes| (self.memory_scalars * bytes) as f64 / 1024.0);
        write!(f, "memory {} scalars: {double:.1} KiB in f64, {single:.1} KiB in f32", self.memory_scalars)?;
        self.axes.iter().try_for_each(|axis| axis.fmt(f))?;
        self.grids.iter().try_for_each(|grid| grid.fmt(f))?;
        self.feedback.iter().try_for_each(|feedback| feedback.fmt(f))?;
        self.crosstalk.iter().try_for_each(|crosstalk| crosstalk.fmt(f))?;
        self.roundness.iter().try_for_each(|roundness| roundness.fmt(f))
    }
}

impl fmt::Display for AxisSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, micro) = (self.unit, if self.unit == "deg" { "µrad" } else { "µm" });
        let side = if self.carries_workpiece { "workpiece" } else { "tool" };
        write!(f, "\n\n{} ({side} side)", self.axis)?;
        match self.travel {
            Some([low, high]) => write!(f, "   travel {} to {} {unit}", short(low), short(high))?,
            None => write!(f, "   travel not declared")?,
        }
        write!(f, ", up to {} {unit}/s, backlash {:.2} {micro}", short(self.max_feed_per_s), self.backlash_micro)?;
        write!(
            f,
            "\n  limits     {:.1} {micro}, {} {unit}/s, {} {unit}/s²",
            self.magnitude_micro,
            short(self.slope_per_s),
            short(self.acceleration_per_s2)
        )?;
        if let Some(servo) = &self.servo {
            servo.lines(f, unit, micro)?;
        }
        self.periodic.iter().try_for_each(|period| period.line(f, unit, micro))?;
        let Some(table) = &self.table else { return write!(f, "\n  no table") };
        let [low, high] = table.range.map(short);
        let directions = if table.bidirectional { ", bidirectional" } else { "" };
        write!(f, "\n  table      {} lines, {low} to {high} {unit}, {}{directions}", table.rows, table.interpolation)?;
        write!(f, "\n  look-up    own {}, cross {}", table.lookup, table.cross_lookup)?;
        write!(f, "\n  max |E|   ")?;
        for error in &table.errors {
            let micro = if error.unit == "um" { "µm" } else { "µrad" };
            write!(f, " {} {:.2} {micro}", error.name, error.max_abs)?;
        }
        Ok(())
    }
}
