//! Settings of a machine and rows of its tables, from a structural code and the changes of a test.

use super::trueaxis::machine::{Axis, AxisSettings, Limits, MachineSettings, Row, Twist, links};
use super::trueaxis::roundness::Arm;
use std::vec::Vec;

/// The arm that follows the crankpin on the sample grinder.
pub const ARM: Arm = Arm { crank_mm: 45.0, wheel_mm: 300.0, pin_mm: 27.5 };

/// A machine with the stated defaults on every axis of its structural code, no tool, and no errors.
#[derive(Clone, Debug)]
pub struct Machine(MachineSettings);

impl Machine {
    /// Creates a machine from a structural code; panics if the code cannot be read.
    pub fn new(chain: &str) -> Self {
        let links = links(chain).expect("a readable structural code");
        let of = |axis: Axis| links.iter().find(|link| link.axis == axis);
        let axes = Axis::ALL.into_iter().filter_map(of);
        Machine(MachineSettings {
            name: "test".parse().expect("a short name"),
            chain: chain.parse().expect("a short structural code"),
            tool_mm: [0.0; 3],
            reference_temperature_c: 20.0,
            location: Default::default(),
            faults: Default::default(),
            contour: Default::default(),
            compensation: Default::default(),
            kinematics: Default::default(),
            axes: axes.map(|link| AxisSettings::with_defaults(link.axis, link.carries_workpiece)).collect(),
            roundness: None,
            crosstalk: Default::default(),
            periodic: Default::default(),
        })
    }

    /// X, Y and Z carry the tool: `w b X Y Z t`.
    pub fn three_axis() -> Self {
        Machine::new("w b X Y Z t")
    }

    /// Adds a tilting table to X, Y and Z: `w C' A' b X Y Z t`.
    pub fn five_axis() -> Self {
        Machine::new("w C' A' b X Y Z t")
    }

    /// Names the machine.
    pub fn name(self, name: &str) -> Self {
        self.with(|machine| machine.name = name.parse().expect("a short name"))
    }

    /// Changes any settings except the axes.
    pub fn with(mut self, change: impl FnOnce(&mut MachineSettings)) -> Self {
        change(&mut self.0);
        self
    }

    /// Changes every axis, in the order X Y Z A B C.
    pub fn each(mut self, change: impl FnMut(&mut AxisSettings)) -> Self {
        self.0.axes.iter_mut().for_each(change);
        self
    }

    /// Changes one axis; panics if the machine does not have it.
    pub fn axis(mut self, axis: Axis, change: impl FnOnce(&mut AxisSettings)) -> Self {
        change(self.0.axes.iter_mut().find(|settings| settings.axis == axis).expect("an axis of the machine"));
        self
    }

    /// Replaces the default axes by these settings.
    pub fn axes(self, axes: &[AxisSettings]) -> Self {
        self.with(|machine| machine.axes = axes.iter().copied().collect())
    }

    /// Sets the travel of every axis, mm (deg); its drive may move `beyond` past either end.
    pub fn travel(self, [low, high]: [f64; 2], beyond: f64) -> Self {
        self.each(|axis| {
            axis.travel = [low, high];
            axis.joint = [low - beyond, high + beyond];
        })
    }

    /// Sets the limits of the correction on every axis.
    pub fn limits(self, limits: Limits) -> Self {
        self.each(|axis| axis.limits = limits)
    }

    /// Sets the hysteresis of every axis, mm (deg).
    pub fn hysteresis(self, hysteresis: f64) -> Self {
        self.each(|axis| axis.hysteresis = hysteresis)
    }

    /// Sets the tool tip from the last frame on the tool's side, mm.
    pub fn tool(self, tool_mm: [f64; 3]) -> Self {
        self.with(|machine| machine.tool_mm = tool_mm)
    }

    /// Returns the settings.
    pub fn settings(self) -> MachineSettings {
        self.0
    }
}

/// A table whose errors, a function of the position, are equal in both directions of travel.
pub fn rows(positions: impl IntoIterator<Item = f64>, mut errors: impl FnMut(f64) -> Twist) -> Vec<Row> {
    let row = |position| {
        let errors = errors(position);
        Row { position, forward: errors, reverse: errors }
    };
    positions.into_iter().map(row).collect()
}

/// A table whose errors are a function of the position and of whether travel is negative.
pub fn rows_both_ways(
    positions: impl IntoIterator<Item = f64>,
    mut errors: impl FnMut(f64, bool) -> Twist,
) -> Vec<Row> {
    let row = |position| Row { position, forward: errors(position, false), reverse: errors(position, true) };
    positions.into_iter().map(row).collect()
}
