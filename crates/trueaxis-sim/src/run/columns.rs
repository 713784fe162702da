//! Columns of a trace: the values recorded per cycle.

use super::kind::Kind;
use super::sample::{Moment, Sample};
use trueaxis::machine::{Axis, MachineSettings};

type Value = fn(&Moment, &Sample, usize) -> f64;

/// A column of a trace.
#[derive(Clone, Debug)]
pub struct Column {
    /// Name and unit.
    pub name: String,
    /// Decimals in a file; 0 for whole numbers.
    pub decimals: usize,
    axis: usize,
    value: Value,
}

impl Column {
    /// The value in a cycle of one machine.
    pub fn value(&self, moment: &Moment, sample: &Sample) -> f64 {
        (self.value)(moment, sample, self.axis)
    }
}

/// The columns for a machine of that kind: time and line; command, drive, reading and correction of X, Y, Z; errors and state;
/// programmed rotary axes; for a machine with rotary axes, theirs after those, degrees and µrad; for [`Kind::Full`] the
/// dynamic correction of every axis with its parts, µm and µrad, and after them the factors on the friction of the axes where it
/// adapts.
pub fn columns(kind: Kind, machine: &MachineSettings) -> Vec<Column> {
    let mut axes: Vec<Axis> = machine.axes.iter().map(|own| own.axis).collect();
    axes.sort_unstable();
    let mut columns = Vec::new();
    let mut add = |name: &str, decimals, axis, value: Value| {
        columns.push(Column { name: name.to_owned(), decimals, axis, value });
    };
    let linear = ['x', 'y', 'z'];
    add("time_s", 7, 0, |m, _, _| m.time_s);
    add("line", 0, 0, |m, _, _| m.line.into());
    let positions: [(&str, Value); 3] = [("command", COMMAND), ("drive", DRIVE), ("feedback", FEEDBACK)];
    for (what, value) in positions {
        linear.iter().enumerate().for_each(|(i, a)| add(&format!("{what}_{a}_mm"), 7, i, value));
    }
    linear.iter().enumerate().for_each(|(i, a)| add(&format!("correction_{a}_um"), 5, i, CORRECTION));
    add("true_error_um", 5, 0, |_, s, _| s.error_um().into());
    for (i, a) in linear.iter().enumerate() {
        add(&format!("true_error_{a}_um"), 5, i, |_, s, i| s.deviation_um[i].into());
    }
    add("estimated_error_um", 5, 0, |_, s, _| s.estimated_um.into());
    add("encoder_error_um", 5, 0, |_, s, _| s.encoder_um);
    add("lag_um", 5, 0, |_, s, _| s.lag_um);
    add("fault", 0, 0, |_, s, _| s.fault.into());
    add("status", 0, 0, |_, s, _| s.status.into());
    add("limited", 0, 0, |_, s, _| s.limited.into());
    add("at_edge", 0, 0, |_, s, _| s.at_edge.into());
    for (i, a) in ['a', 'b', 'c'].iter().enumerate() {
        add(&format!("{a}_deg"), 4, i, |m, _, i| m.rotary_deg[i]);
    }
    add("true_orientation_urad", 4, 0, |_, s, _| s.orientation_urad.into());
    add("estimated_orientation_urad", 4, 0, |_, s, _| s.estimated_orientation_urad.into());
    for axis in axes.iter().filter(|axis| axis.is_rotary()) {
        let (i, a) = (axis.index(), axis.letter().to_ascii_lowercase());
        for (what, value) in positions {
            add(&format!("{what}_{a}_deg"), 9, i, value);
        }
        add(&format!("correction_{a}_urad"), 5, i, CORRECTION);
    }
    let dynamic: [(&str, Value); 4] = [
        ("dynamic", |_, s, i| s.dynamic.sent[i].into()),
        ("feed_forward", |_, s, i| s.dynamic.feed_forward[i].into()),
        ("contour_feedback", |_, s, i| s.dynamic.feedback[i].into()),
        ("crosstalk", |_, s, i| s.dynamic.crosstalk[i].into()),
    ];
    for axis in axes.iter().filter(|_| kind == Kind::Full) {
        let (a, unit) = (axis.letter().to_ascii_lowercase(), if axis.is_rotary() { "urad" } else { "um" });
        for (part, value) in dynamic {
            add(&format!("{part}_{a}_{unit}"), 5, axis.index(), value);
        }
    }
    let factors: [(&str, Value); 2] = [
        ("friction_factor", |_, s, i| s.friction[i][0].into()),
        ("presliding_factor", |_, s, i| s.friction[i][1].into()),
    ];
    let adapts =
        |axis: &Axis| machine.axis(*axis).and_then(|own| own.servo.friction).is_some_and(|own| own.adapt > 0.0);
    for axis in axes.iter().filter(|axis| kind == Kind::Full && adapts(axis)) {
        for (factor, value) in factors {
            add(&format!("{factor}_{}", axis.letter().to_ascii_lowercase()), 5, axis.index(), value);
        }
    }
    columns
}

const COMMAND: Value = |_, s, i| s.command[i];
const DRIVE: Value = |_, s, i| s.drive[i];
const FEEDBACK: Value = |_, s, i| s.feedback[i];
const CORRECTION: Value = |_, s, i| s.correction[i].into();
