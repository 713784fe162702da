//! Error tables of three linear axes, 128 points each, travel −300 … 335 mm.

use crate::Random;
use trueaxis::compensation::{NineTerms, Volumetric};
use trueaxis::machine::{AxisOrder, AxisSettings, ErrorModel, GridData, MachineSettings};
use trueaxis::{Axis, Row};
use trueaxis_tables::GridSource;
use trueaxis_testing::machine::Machine;

/// Points of each table.
pub const POINTS: u32 = 128;
/// First point of each table, mm.
pub const FIRST_MM: f64 = -300.0;
/// Mean distance between two points, mm.
pub const CELL_MM: f64 = 5.0;

/// Spacing of the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// Equal distances.
    Equidistant,
    /// Distances vary by ±40 %.
    Free,
}

/// Rows of one table: errors of some 10 µm, changing by less than 1 µm from point to point.
pub fn rows(grid: Grid, seed: u64) -> Vec<Row> {
    let mut random = Random(seed);
    let mut error = [0.0; 6];
    (0..POINTS)
        .map(|i| {
            let stray = if grid == Grid::Free && i > 0 { 0.2 * random.signed() } else { 0.0 };
            for e in error.iter_mut().take(3) {
                *e += 1e-3 * random.signed();
            }
            Row { position: FIRST_MM + CELL_MM * (f64::from(i) + stray), forward: error, reverse: error }
        })
        .collect()
}

/// A machine with three linear axes on the tool side.
pub fn machine() -> MachineSettings {
    Machine::three_axis().travel([-290.0, 325.0], 0.1).settings()
}

/// Memory for 3 tables, leaked because it is needed until the process ends.
pub fn memory() -> &'static mut [f64] {
    // Value and slope of four numbers, and the grid with its guide.
    vec![0.0; (2 * 4 + 3) * 3 * POINTS as usize].leak()
}

/// The nine terms of [`machine`].
pub fn nine_terms(grid: Grid) -> NineTerms<'static, f64, f64, 3> {
    let tables = [1, 2, 3].map(|seed| rows(grid, seed));
    NineTerms::build(
        &AxisOrder::of(&machine()).expect("valid axes"),
        &machine(),
        |axis: Axis| tables.get(axis.index()).map(Vec::as_slice),
        memory(),
    )
    .expect("valid tables")
}

/// Twists of an axis, 128 points: translations of some 10 µm, rotations of some 10 µrad; a rotary table spans a full circle.
fn twists(axis: Axis) -> Vec<Row> {
    let mut random = Random(10 + axis.index() as u64);
    let mut error = [0.0; 6];
    let cell = if axis.is_rotary() { 360.0 / f64::from(POINTS - 1) } else { CELL_MM };
    let first = if axis.is_rotary() { 0.0 } else { FIRST_MM };
    let mut rows: Vec<Row> = (0..POINTS)
        .map(|i| {
            for (k, e) in error.iter_mut().enumerate() {
                *e += if k < 3 { 1e-3 } else { 1e-6 } * random.signed();
            }
            Row { position: first + cell * f64::from(i), forward: error, reverse: error }
        })
        .collect();
    if let (true, Some(start)) = (axis.is_rotary(), rows.first().copied())
        && let Some(last) = rows.last_mut()
    {
        (last.forward, last.reverse) = (start.forward, start.reverse);
    }
    rows
}

/// The volumetric model of a machine with `N` axes: X Y Z on the tool side, and with five axes a table C on a trunnion A.
pub fn volumetric<const N: usize>() -> Volumetric<'static, f64, f64, N> {
    let mut machine = machine();
    machine.compensation.model = ErrorModel::Volumetric;
    machine.tool_mm = [0.0, 0.0, -120.0];
    if N == 5 {
        machine.chain = "w C' A' b X Y Z t".try_into().expect("a short chain");
        for axis in [Axis::A, Axis::C] {
            machine.axes.push(AxisSettings::with_defaults(axis, true)).expect("five axes fit");
        }
    }
    let tables: Vec<(Axis, Vec<Row>)> = machine.axes.iter().map(|a| (a.axis, twists(a.axis))).collect();
    let rows = |axis: Axis| tables.iter().find(|(a, _)| *a == axis).map(|(_, rows)| &rows[..]);
    let memory = vec![0.0; Volumetric::<f64, f64, N>::requirement(&machine, rows)].leak();
    Volumetric::build(&AxisOrder::of(&machine).expect("valid axes"), &machine, rows, memory).expect("valid tables")
}

/// A grid of translations over X and Y, or over all three axes, leaked: nodes 12.3 mm apart in X and Y, 61.5 mm in Z.
pub fn grid(with_z: bool) -> &'static [GridData<'static>] {
    let mut random = Random(23);
    let along = |count: u32, pitch: f64| (0..count).map(|i| -290.0 + pitch * f64::from(i)).collect::<Vec<f64>>();
    let nodes = [along(51, 12.3), along(51, 12.3), if with_z { along(11, 61.5) } else { Vec::new() }];
    let count = nodes.iter().map(|nodes| nodes.len().max(1)).product();
    let values = (0..count).map(|_| [0; 6].map(|_| 2e-3 * random.signed()));
    let given = [true, true, true, false, false, false];
    let source = GridSource { nodes, given, values: values.collect(), ..GridSource::default() };
    let grid = Box::leak(Box::new(trueaxis_tables::Grid::new(source).expect("errors that 16 bits hold")));
    vec![grid.data()].leak()
}

/// A position within the tables, mm.
pub fn position(random: &mut Random) -> [f64; 3] {
    [0; 3].map(|_| FIRST_MM + CELL_MM * f64::from(POINTS - 1) * (0.01 + 0.98 * random.unit()))
}
