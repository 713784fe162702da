//! Positions of the axes in the test cycle, and readings of the gauge.

use super::{BallCycle, place};
use crate::error::{Result, SimError};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis::Axis;
use trueaxis::machine::AXES;
use trueaxis_metrology::identification::{AngleReadings, Ball, BallTest};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Set-ups for C, (L, H) in mm.
pub const SET_UPS_C: [(f64, f64); 3] = [(250.0, 60.0), (250.0, 160.0), (350.0, 60.0)];
/// Set-ups for A, (L, H) in mm.
pub const SET_UPS_A: [(f64, f64); 3] = [(250.0, 60.0), (250.0, 160.0), (350.0, 160.0)];

/// A cycle of one axis: set-ups, and the angles at which it stops.
pub(super) struct AxisCycle {
    pub(super) axis: Axis,
    pub(super) balls: [Ball; 3],
    pub(super) stops_deg: Vec<f64>,
    /// Every degree of that range, for judging the result.
    pub(super) judged_deg: Vec<f64>,
}

impl AxisCycle {
    /// C: a full circle in 36 stops. A: a quarter turn in 19.
    pub(super) fn of(axis: Axis) -> AxisCycle {
        let (points, stops, step, last) =
            if axis == Axis::C { (SET_UPS_C, 36, 10.0, 359) } else { (SET_UPS_A, 19, 5.0, 90) };
        AxisCycle {
            axis,
            balls: points.map(|(vertical_mm, horizontal_mm)| Ball { vertical_mm, horizontal_mm }),
            stops_deg: (0..stops).map(|i| f64::from(i) * step).collect(),
            judged_deg: (0..=last).map(f64::from).collect(),
        }
    }

    /// Positions of all axes with the tested axis at `angle_deg`: the ball of every set-up stays where the first one was at 0.
    pub(super) fn position(&self, machine: &Machine, ball: Ball, angle_deg: f64) -> Result<[f64; AXES]> {
        let turn = place(machine, self.axis).ok_or_else(|| no_axis(machine, self.axis))?;
        let mut position = [0.0; AXES];
        position[turn] = angle_deg;
        let [first, ..] = self.balls;
        let (from, to) = (hanging(first), self.turned(machine, turn, hanging(ball), angle_deg));
        for (i, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            if let Some(slot) = place(machine, axis) {
                position[slot] = from[i] - to[i];
            }
        }
        Ok(position)
    }

    fn turned(&self, machine: &Machine, slot: usize, [x, y, z]: [f64; 3], angle_deg: f64) -> [f64; 3] {
        let direction = machine.settings.axes.get(slot).map_or(1.0, |settings| f64::from(settings.direction));
        let (sin, cos) = libm::sincos((direction * angle_deg).to_radians());
        match self.axis {
            Axis::C => [x * cos - y * sin, x * sin + y * cos, z],
            _ => [x, y * cos - z * sin, y * sin + z * cos],
        }
    }

    /// Readings of the gauge in every set-up at every stop.
    pub(super) fn measure(&self, test: &BallCycle, machine: &Machine, stream: u64) -> Result<BallTest> {
        let mut noise = ChaCha8Rng::seed_from_u64(test.seed);
        noise.set_stream(stream);
        let geometries: Vec<Geometry> =
            self.balls.iter().map(|&ball| Ok(Geometry::new(&with_ball(machine, ball), 0.0)?)).collect::<Result<_>>()?;
        let slot = place(machine, self.axis).and_then(|slot| machine.settings.axes.get(slot));
        let direction = slot.map_or(1.0, |settings| f64::from(settings.direction));
        let mut angles = Vec::with_capacity(self.stops_deg.len());
        for &angle_deg in &self.stops_deg {
            let mut deviations_mm = Vec::with_capacity(self.balls.len());
            for (geometry, &ball) in geometries.iter().zip(&self.balls) {
                let tip = geometry.tip_error(&self.position(machine, ball, angle_deg)?, &[0.0; AXES]);
                deviations_mm.push(tip.map(|value| {
                    let scatter: f64 = StandardNormal.sample(&mut noise);
                    value + 1e-3 * test.gauge_noise_um * scatter
                }));
            }
            angles.push(AngleReadings { angle_rad: (direction * angle_deg).to_radians(), deviations_mm });
        }
        Ok(BallTest { axis: self.axis, balls: self.balls.to_vec(), angles })
    }
}

fn no_axis(machine: &Machine, axis: Axis) -> SimError {
    let name = &machine.settings.name;
    SimError::unsuited(format!("machine {name}"), format!("no axis {}", axis.letter()), "A and C")
}

/// Centre of a ball from the intersection of A and C, both at 0.
fn hanging(ball: Ball) -> [f64; 3] {
    [0.0, ball.horizontal_mm, -ball.vertical_mm]
}

/// The machine with the ball as its tool.
pub(super) fn with_ball(machine: &Machine, ball: Ball) -> Machine {
    let mut machine = machine.clone();
    machine.settings.tool_mm = hanging(ball);
    machine
}
