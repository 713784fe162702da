//! Curves of a run in memory of fixed size: complete cycles, namely those at which a value is largest or smallest.

use trueaxis::Axis;
use trueaxis::machine::AXES;
use trueaxis_report::Thinner;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{Kind, Moment, Sample, Sink};

/// Number of time intervals; from each, the rows contain the cycles of extreme values: a few thousand rows.
const BUCKETS: usize = 256;
/// Number of values with extremes: contour errors of five machines, fault, limited, correction, dynamic correction.
const EXTREMES: usize = 9;
/// Columns of a six-axis machine with every part, run in every kind.
const MOST_COLUMNS: usize = 96;

/// A number of a sample.
#[derive(Clone, Copy)]
enum Field {
    Error,
    Orientation,
    Estimated,
    Limited,
    Fault,
    Status,
    AtEdge,
    Correction(usize),
    Sent(usize),
    FeedForward(usize),
    Feedback(usize),
    Crosstalk(usize),
}

/// Selects the value of an axis.
type OfAxis = fn(usize) -> Field;

impl Field {
    fn of(self, sample: &Sample) -> f32 {
        let at = |values: &[f32; AXES], axis: usize| values.get(axis).copied().unwrap_or(0.0);
        match self {
            Field::Error => sample.error_um(),
            Field::Orientation => sample.orientation_urad,
            Field::Estimated => sample.estimated_um,
            Field::Limited => sample.limited.into(),
            Field::Fault => sample.fault.into(),
            Field::Status => sample.status.into(),
            Field::AtEdge => sample.at_edge.into(),
            Field::Correction(axis) => at(&sample.correction, axis),
            Field::Sent(axis) => at(&sample.dynamic.sent, axis),
            Field::FeedForward(axis) => at(&sample.dynamic.feed_forward, axis),
            Field::Feedback(axis) => at(&sample.dynamic.feedback, axis),
            Field::Crosstalk(axis) => at(&sample.dynamic.crosstalk, axis),
        }
    }
}

/// A column of the rows: its machine and value.
struct Column {
    name: String,
    machine: usize,
    field: Field,
}

/// A cycle.
#[derive(Clone, Copy, Debug)]
struct Row {
    time_s: f64,
    cycle: u64,
    line: u32,
    cutting: bool,
    length_mm: f64,
    nominal_mm: [f64; 3],
    rotary_deg: [f64; 3],
    values: [f32; MOST_COLUMNS],
}

/// Collects the rows.
pub(super) struct Traces {
    rotary: Vec<Axis>,
    columns: Vec<Column>,
    driven: Vec<bool>,
    rows: Thinner<Row, EXTREMES>,
}

impl Traces {
    pub(super) fn new(scenario: &Scenario, kinds: &[Kind]) -> Traces {
        let mut axes: Vec<Axis> = scenario.machine.settings.axes.iter().map(|own| own.axis).collect();
        axes.sort_unstable();
        let mut columns: Vec<Column> = Vec::new();
        let mut add = |machine: usize, what: String, field| {
            let name = format!("{}.{what}", kinds.get(machine).map_or("", |kind| kind.name()));
            columns.push(Column { name, machine, field });
        };
        for machine in 0..kinds.len() {
            add(machine, "error_um".into(), Field::Error);
            if scenario.five_axis {
                add(machine, "orientation_urad".into(), Field::Orientation);
            }
        }
        for (machine, kind) in kinds.iter().enumerate().filter(|(_, kind)| kind.enables_the_plugin()) {
            for (what, field) in [
                ("estimated_um", Field::Estimated),
                ("limited", Field::Limited),
                ("fault", Field::Fault),
                ("status", Field::Status),
                ("at_edge", Field::AtEdge),
            ] {
                add(machine, what.into(), field);
            }
            let whole: [(&str, OfAxis); 5] = [
                ("correction", Field::Correction),
                ("sent", Field::Sent),
                ("feed_forward", Field::FeedForward),
                ("feedback", Field::Feedback),
                ("crosstalk", Field::Crosstalk),
            ];
            // The run that simulates only the geometry has no dynamic parts.
            let count = if *kind == Kind::Compensated { 1 } else { whole.len() };
            for (what, field) in whole.into_iter().take(count) {
                axes.iter().for_each(|axis| add(machine, format!("{what}.{}", axis.letter()), field(axis.index())));
            }
        }
        columns.truncate(MOST_COLUMNS);
        Traces {
            rotary: axes.into_iter().filter(|axis| scenario.five_axis && axis.is_rotary()).collect(),
            columns,
            driven: kinds.iter().map(|kind| kind.enables_the_plugin()).collect(),
            rows: Thinner::new(BUCKETS),
        }
    }

    /// Names of the columns.
    pub(super) fn names(&self) -> Vec<String> {
        let own = ["time_s", "cycle", "line", "cutting", "length_mm", "x_mm", "y_mm", "z_mm"].map(String::from);
        let rotary = self.rotary.iter().map(|axis| format!("{}_deg", axis.letter().to_ascii_lowercase()));
        own.into_iter().chain(rotary).chain(self.columns.iter().map(|column| column.name.clone())).collect()
    }

    /// All selected rows, concatenated.
    pub(super) fn rows(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        for row in self.rows.items() {
            let cutting = f64::from(u8::from(row.cutting));
            numbers.extend([row.time_s, row.cycle as f64, row.line.into(), cutting, row.length_mm]);
            numbers.extend(row.nominal_mm);
            numbers.extend(self.rotary.iter().filter_map(|axis| row.rotary_deg.get(axis.index() - AXES / 2)));
            numbers.extend(row.values.iter().take(self.columns.len()).map(|value| f64::from(*value)));
        }
        numbers
    }
}

/// Value of a machine that has stopped.
const NOTHING: f32 = f32::NAN;

/// The component of the largest magnitude, with its sign.
fn largest(values: &[f32]) -> f64 {
    values.iter().copied().map(f64::from).fold(0.0, larger)
}

fn larger(one: f64, other: f64) -> f64 {
    if other.abs() > one.abs() { other } else { one }
}

impl Sink for Traces {
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]) {
        let mut values = [NOTHING; MOST_COLUMNS];
        for (value, column) in values.iter_mut().zip(&self.columns) {
            let sample = machines.get(column.machine).copied().flatten();
            *value = sample.map_or(NOTHING, |sample| column.field.of(sample));
        }
        let mut extremes = [0.0_f64; EXTREMES];
        for (extreme, sample) in extremes.iter_mut().take(EXTREMES - 4).zip(machines) {
            *extreme = sample.map_or(0.0, |sample| sample.error_um().into());
        }
        let driven = machines.iter().zip(&self.driven).filter_map(|(sample, driven)| sample.filter(|_| *driven));
        for sample in driven {
            let [.., fault, limited, correction, dynamic] = &mut extremes;
            *fault = fault.max(sample.fault.into());
            *limited = limited.max(f64::from(u8::from(sample.limited != 0)));
            *correction = larger(*correction, largest(&sample.correction));
            *dynamic = larger(*dynamic, largest(&sample.dynamic.sent));
        }
        let row = Row {
            time_s: moment.time_s,
            cycle: moment.cycle,
            line: moment.line,
            cutting: moment.cutting,
            length_mm: moment.length_mm,
            nominal_mm: moment.nominal_mm,
            rotary_deg: moment.rotary_deg,
            values,
        };
        self.rows.add(row, extremes);
    }
}
