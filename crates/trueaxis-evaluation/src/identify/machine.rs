//! The errors found, as additions to a machine.

use super::{Identification, micro, names, table};
use anyhow::{Result, anyhow};
use trueaxis::machine::{Row, Twist};
use trueaxis_metrology::identification::{Identified, Offsets, identify as solve, lever};
use trueaxis_tables::finding::{Finding, Fit, Known};
use trueaxis_tables::{Additions, Machine};

impl Identification {
    /// The six errors as findings for a machine that was not corrected during the test: their excess over its table and its
    /// location errors of the axis. The fit determines them together: only levers distinguish a shift from a rotation, so an
    /// error in one causes an error in the other.
    ///
    /// # Errors
    /// Angles from which no table can be built.
    ///
    /// Cost: a second fit.
    pub fn additions(&self, machine: &Machine) -> Result<Additions> {
        let axis = self.errors.axis;
        let mut left = self.readings.clone();
        for (&angle, deviations) in left.angles_deg.iter().zip(&mut left.deviations_mm) {
            let [x, y, z, a, b, c] = machine.stated_errors(axis, angle);
            for (deviation, &ball) in deviations.iter_mut().zip(&left.balls) {
                let [u, v, w] = lever(axis, (self.direction * angle).to_radians(), ball).unwrap_or_default();
                let stated = [x + b * w - c * v, y + c * u - a * w, z + a * v - b * u];
                *deviation = std::array::from_fn(|k| deviation[k] - stated[k]);
            }
        }
        let on_top = solve(&left.test(axis, self.direction), self.offsets)
            .map_err(|refused| anyhow!("excess over the machine's table: {refused}"))?;
        let (table, _) = table::table(&left.angles_deg, &on_top)?;
        let rows = aligned_to(&table.rows, machine.rows(axis));
        let (values, errors) = (rms(&on_top, |of| of.0), rms(&on_top, |of| of.1));
        let findings = names(axis).into_iter().enumerate().map(|(k, name)| Finding {
            key: format!("axis.{}.{name}", axis.letter()),
            found: Known::new(values[k], errors[k], on_top.degrees_of_freedom),
            curve: rows.iter().map(|row| (row.position, only(row.forward, k))).collect(),
            on_top: true,
            together: axis.letter().to_string(),
            ..Finding::default()
        });
        let squares = self.errors.angles.iter().map(|angle| angle.residual_mm.powi(2));
        let left_mm = (squares.sum::<f64>() / self.errors.angles.len().max(1) as f64).sqrt();
        let fit = Fit { before_mm: self.read_mm(), left_mm, noise_mm: None, is_angle: false };
        Ok(Additions { findings: findings.collect(), fit: Some(fit), ..Additions::default() })
    }

    /// Root mean square of the readings; with free offsets, about their means.
    fn read_mm(&self) -> f64 {
        let (mut squares, mut count) = (0.0, 0.0);
        for set_up in 0..self.readings.balls.len() {
            for k in 0..3 {
                let read: Vec<f64> =
                    self.readings.deviations_mm.iter().filter_map(|of| Some(of.get(set_up)?[k])).collect();
                let mean =
                    if self.offsets == Offsets::Free { read.iter().sum::<f64>() / read.len() as f64 } else { 0.0 };
                squares += read.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
                count += read.len() as f64;
            }
        }
        (squares / f64::max(count, 1.0)).sqrt()
    }
}

/// Root mean squares over the angles, of the errors or of their standard errors, µm and µrad.
fn rms(found: &Identified, of: impl Fn((Twist, Twist)) -> Twist) -> [f64; 6] {
    let all: Vec<[f64; 6]> =
        found.angles.iter().map(|angle| micro(&of((angle.errors, angle.standard_errors)))).collect();
    std::array::from_fn(|k| (all.iter().map(|values| values[k].powi(2)).sum::<f64>() / all.len() as f64).sqrt())
}

fn only(errors: Twist, k: usize) -> Twist {
    std::array::from_fn(|own| if own == k { errors[own] } else { 0.0 })
}

/// Moves the lines of a full turn to the turn that begins with the machine's own table. Returns other lines, and those for a
/// machine without a table, unchanged.
fn aligned_to(found: &[Row], own: Option<&[Row]>) -> Vec<Row> {
    let (Some(start), [first, .., last]) = (own.and_then(|rows| rows.first()), found) else { return found.to_vec() };
    if (last.position - first.position - 360.0).abs() > super::SAME_ANGLE_DEG {
        return found.to_vec();
    }
    let begin = start.position;
    // The line that closes the turn repeats the first.
    let open = found.len() - 1;
    let mut turned: Vec<Row> = found[..open]
        .iter()
        .map(|row| Row { position: begin + (row.position - begin).rem_euclid(360.0), ..*row })
        .collect();
    turned.sort_by(|a, b| a.position.total_cmp(&b.position));
    let (Some(&low), Some(&high)) = (turned.first(), turned.last()) else { return found.to_vec() };
    // Interpolates the values at both ends of the turn between the last line before its start and the first line in it.
    let (to_low, to_high) = (low.position - begin, begin + 360.0 - high.position);
    let share = if to_low + to_high > 0.0 { to_low / (to_low + to_high) } else { 0.0 };
    let forward = std::array::from_fn(|k| low.forward[k] + share * (high.forward[k] - low.forward[k]));
    let edge = |position| Row { position, forward, reverse: forward };
    turned.retain(|row| row.position - begin > super::SAME_ANGLE_DEG);
    turned.insert(0, edge(begin));
    turned.push(edge(begin + 360.0));
    turned
}
