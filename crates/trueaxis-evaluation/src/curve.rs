//! The columns of a table between its points, as the step looks them up.

use anyhow::{Context, Result, anyhow};
use trueaxis::Axis;
use trueaxis::compensation::{AxisTable, Direction, ThermalLine};
use trueaxis_tables::Machine;

/// One error of an axis over its table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorCurve {
    /// Positions, mm or degrees, including those of the table.
    pub positions: Vec<f64>,
    /// Error in positive travel, µm or µrad.
    pub forward: Vec<f64>,
    /// Error in negative travel, µm or µrad, including backlash if it is the axis' own error.
    pub reverse: Vec<f64>,
    /// Growth of the own error at the temperature, µm or µrad; zero for other errors.
    pub growth: Vec<f64>,
}

/// Error `component` (0 to 5: EX to EC) of an axis as the volumetric form looks it up, without levers, at about `points`
/// positions and at every line of the table. `temperature_c` is the temperature of the axis, °C.
///
/// # Errors
/// An axis without a table; a growth of more than 10 mm or 1e-3.
pub fn curve(machine: &Machine, axis: Axis, component: usize, temperature_c: f64, points: usize) -> Result<ErrorCurve> {
    let settings = machine.settings.axis(axis).context("the axis is not in the machine")?;
    let rows = machine.rows(axis).with_context(|| format!("found no table of axis {}, needed one", axis.letter()))?;
    let mut memory = vec![0.0; AxisTable::<f64, f64, 6>::requirement(settings, rows)];
    let mut lent = memory.as_mut_slice();
    let table = AxisTable::<f64, f64, 6>::build_twists(settings, rows, [0.0; 3], [0.0; 6], &mut lent)
        .map_err(|error| anyhow!("{error}"))?;
    let kelvin = temperature_c - machine.settings.reference_temperature_c;
    let line = ThermalLine::<f64>::for_axis(&settings.thermal, kelvin)
        .with_context(|| format!("found {kelvin} K above the reference, needed a growth of at most 10 mm and 1e-3"))?;
    let own = component == axis.index();
    // The growth of a rotary axis is in degrees.
    let angle = if axis.is_rotary() { 1f64.to_radians() } else { 1.0 };
    let micro = if component < 3 { 1e3 } else { 1e6 };
    let at = |position: f64, direction| {
        let (twist, _) = table.at(table.coordinate(position), direction);
        twist.get(component).copied().unwrap_or_default() * micro
    };
    let mut curve =
        ErrorCurve { positions: positions(rows.iter().map(|row| row.position), points), ..Default::default() };
    for &position in &curve.positions {
        curve.forward.push(at(position, Direction::POSITIVE));
        curve.reverse.push(at(position, Direction::NEGATIVE));
        let growth = line.at(position - settings.thermal.datum) * angle * micro;
        curve.growth.push(if own { growth } else { 0.0 });
    }
    Ok(curve)
}

/// Every line, and evenly between two lines enough positions to make about `points` in all.
fn positions(lines: impl Iterator<Item = f64>, points: usize) -> Vec<f64> {
    let lines: Vec<f64> = lines.collect();
    let between = (points / lines.len().max(1)).clamp(1, 100);
    let mut positions = Vec::with_capacity(lines.len() * between);
    for pair in lines.windows(2) {
        let [low, high] = pair else { continue };
        positions.extend((0..between).map(|part| low + (high - low) * part as f64 / between as f64));
    }
    positions.extend(lines.last());
    positions
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use trueaxis_tables::files::Memory;

    #[test]
    fn the_curve_goes_through_the_points_and_shows_lost_motion_and_growth() {
        let text = "name = \"m\"\nchain = \"w X' b t\"\n[axis.X]\ntable = \"x.csv\"\ninterpolation = \"cubic\"\n\
            backlash_um = 2.0\n[axis.X.thermal]\nexpansion_um_per_m_k = 10.0\noffset_um_per_k = 0.5\n";
        let table = "X_mm,EXX_um,EBX_urad\n0,1,4\n10,2.5,0\n20,-3,8\n";
        let files = Memory::new([("machine.toml", text), ("x.csv", table)]);
        let machine = Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap();
        let near = |found: f64, needed: f64| assert!((found - needed).abs() < 1e-9, "{found} {needed}");
        let own = curve(&machine, Axis::X, 0, 22.0, 6).unwrap();
        assert_eq!(own.positions, [0.0, 5.0, 10.0, 15.0, 20.0]);
        for (index, value) in [(0, 1.0), (1, 2.3125), (2, 2.5), (4, -3.0)] {
            near(own.forward[index], value);
            near(own.reverse[index], value + 2.0);
        }
        // 2 K: 1 µm of offset, 20 µm/m.
        near(own.growth[4], 1.4);
        let cross = curve(&machine, Axis::X, 4, 22.0, 3).unwrap();
        assert_eq!(cross.positions, [0.0, 10.0, 20.0]);
        near(cross.forward[2], 8.0);
        assert_eq!((cross.reverse == cross.forward, cross.growth[2]), (true, 0.0));
        assert!(curve(&machine, Axis::Y, 0, 20.0, 9).is_err());
        assert!(curve(&machine, Axis::X, 0, 1e6, 9).unwrap_err().to_string().contains("K above the reference"));
    }
}
