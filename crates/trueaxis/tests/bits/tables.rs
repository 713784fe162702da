//! Random tables, and loops on them.

use trueaxis::contour::Method;
use trueaxis::machine::{Axis, MachineSettings, Row};
use trueaxis::{Config, ConfigError, Position, Real, ServoLoop};
use trueaxis_testing::machine::rows_both_ways;
use trueaxis_testing::noise::Noise;

/// Rows of the tables, axis by axis.
pub(crate) type Tables = Vec<(Axis, Vec<Row>)>;

/// Random values of all six errors of every axis in both directions, at the points that `points` returns for it.
pub(crate) fn tables(
    machine: &MachineSettings,
    noise: &mut Noise,
    mut points: impl FnMut(&mut Noise) -> Vec<f64>,
) -> Tables {
    let mut of = |axis: Axis| {
        let points = points(noise);
        let mut errors = [0.0; 6];
        let mut table = rows_both_ways(points, |_, reverse| {
            if !reverse {
                errors = std::array::from_fn(|k| if k < 3 { 2e-3 } else { 8e-6 } * noise.signed());
            }
            errors
        });
        // A table over a full turn ends as it begins.
        let last = table.len() - 1;
        (table[last].forward, table[last].reverse) = (table[0].forward, table[0].reverse);
        (axis, table)
    };
    machine.axes.iter().map(|axis| of(axis.axis)).collect()
}

/// A loop at 1 kHz, and the memory that it needs.
pub(crate) fn servo<'m, R: Real, P: Position, const N: usize>(
    machine: &'m MachineSettings,
    tables: &'m Tables,
) -> Result<(ServoLoop<'m, R, P, N>, usize), ConfigError> {
    let of = |axis: Axis| tables.iter().find(|(of, _)| *of == axis).map(|(_, rows)| &rows[..]);
    let (machine_id, tables_crc, period_ns) = (1, 1, 1_000_000);
    let config =
        Config { machine, grids: &[], machine_id, tables_crc, period_ns, inverse_passes: 8, method: Method::Guarded };
    let requirement = config.requirement(of);
    Ok((config.build(of, vec![R::ZERO; requirement].leak())?, requirement))
}
