//! The control loop: every servo cycle goes through the step with its gauge, and the surface is ground.

use super::Grinding;
use super::cell::Cell;
use super::event::Event;
use super::gauging::Gauging;
use super::result::{Moment, Revolution, Run};
use super::workpiece::{Harmonic, imprint};
use crate::error::{Result, SimError};
use crate::servo::{Owned, step, three};
use std::sync::Arc;
use trueaxis::machine::{AXES, Limits};
use trueaxis::roundness::GaugeFlags;
use trueaxis::sample::Refusal;
use trueaxis::{Fault, Input, Output, State};

/// Control and machine of one run.
pub(super) struct Control {
    grinding: Arc<Grinding>,
    servo: three::Cell,
    state: State<f64, f64, 3>,
    gauge: Box<dyn Gauging + Send>,
    cell: Cell,
    settled: bool,
    limits: [Limits; 3],
    period_s: f64,
    correction: [f64; 3],
    slope: [f64; 3],
    limited: [u64; 3],
    band: [usize; 2],
    gauge_imprint: Option<f64>,
    run: Run,
}

impl Control {
    pub(super) fn new(grinding: Arc<Grinding>, gauge: Box<dyn Gauging + Send>) -> Result<Self> {
        let servo = three::Cell::build(&grinding.machine, grinding.period_ns())?;
        let cell = Cell::new(Arc::clone(&grinding))?;
        let free = Limits { magnitude: f64::MAX, slope_per_s: f64::MAX, acceleration_per_s2: f64::MAX };
        let mut limits = [free; 3];
        for axis in grinding.machine.settings.axes.iter().take(AXES) {
            if let Some(to) = limits.get_mut(axis.axis.index()) {
                *to = axis.limits;
            }
        }
        let band = grinding.gauge()?.infeed.map_or([2, 2], |infeed| [infeed.band.first, infeed.band.last]);
        let state = servo.servo().start();
        let run = Run::begun(cell.pin.about_the_circle(), gauge.cycles_of_work());
        Ok(Control {
            servo,
            state,
            gauge,
            cell,
            settled: false,
            limits,
            period_s: 1.0 / grinding.rate_hz,
            correction: [0.0; 3],
            slope: [0.0; 3],
            limited: [0; 3],
            band: band.map(usize::from),
            gauge_imprint: None,
            run,
            grinding,
        })
    }

    /// Gives the tables' correction time to ramp in while the spindle is at rest and the wheel is off the part.
    fn settle(&mut self) {
        let slowest = self.limits.iter().filter(|l| l.magnitude < 1e3);
        let seconds = slowest.map(|l| l.magnitude / l.slope_per_s + l.slope_per_s / l.acceleration_per_s2);
        for _ in 0..(1.2 * seconds.fold(0.0, f64::max).min(2.0) * self.grinding.rate_hz) as u64 {
            if self.cycle(&mut |_| {}, true).is_err() {
                return;
            }
        }
    }

    /// Twice the duration of the turns and the stops, so that a run always ends.
    fn most_cycles(&self) -> u64 {
        let stops = self.grinding.events.iter().map(|event| match event {
            Event::Stop { for_s, .. } => *for_s,
            _ => 0.0,
        });
        let turning = 60.0 * (f64::from(self.grinding.revolutions) + 1.0) / self.grinding.speed_rpm;
        (2.0 * self.grinding.rate_hz * (turning + 1.0 + stops.sum::<f64>())) as u64
    }

    fn cycle(&mut self, observe: &mut dyn FnMut(&Moment<'_>), settling: bool) -> Result<()> {
        let (new_part, wheel) = if settling { (false, None) } else { self.cell.happen() };
        let readings = self.cell.read(new_part, wheel);
        if let Some(wheel_mm) = readings.wheel_mm {
            self.gauge.set_wheel(wheel_mm).map_err(SimError::Gauge)?;
        }
        let input = Input {
            command: readings.command,
            feedback: readings.feedback,
            encoder_alarm: 0,
            elapsed_ns: self.grinding.period_ns(),
            homed: true,
            enable: true,
            reset: false,
            refusal: Refusal::NONE,
            ..Input::at_rest(self.grinding.period_ns())
        };
        let mut output = Output::none();
        let cycle = self.gauge.run_with(&readings.probes, &mut |gauge| {
            output = step(self.servo.servo(), &mut self.state, &input, &mut (), gauge);
        });
        if output.record.fault != Fault::None {
            return Err(SimError::Fault { fault: output.record.fault, turns: self.cell.turns() });
        }
        self.hold_against_limits(output.record.correction, output.record.limited);
        if cycle.finished {
            let harmonics: Vec<Harmonic> = (0..=self.band[1]).map(|k| self.gauge.harmonic(k)).collect();
            self.gauge_imprint = Some(imprint(&harmonics, self.band[0]));
            self.run.motion = self.gauge.motion().map(<[f64]>::to_vec);
        }
        let turn = self.cell.turns().floor();
        self.cell.advance(output.drive[self.cell.place()], settling);
        if settling {
            return Ok(());
        }
        self.run.cycles += 1;
        self.run.flags = GaugeFlags(self.run.flags.0 | cycle.flags.0);
        observe(&Moment {
            turns: self.cell.turns(),
            drive_mm: output.drive,
            correction_mm: output.record.correction,
            infeed_mm: cycle.infeed,
            flags: cycle.flags,
            finished: cycle.finished,
            counts: self.gauge.counts(),
            table_um: self.gauge.correction(),
        });
        if self.cell.turns().floor() > turn && turn >= 0.0 {
            self.end_of_turn();
        }
        Ok(())
    }

    /// Compares the plugin's correction with its limits of magnitude, slope and acceleration, in every cycle.
    fn hold_against_limits(&mut self, correction: [f64; 3], limited: u8) {
        let mut exceeded = false;
        for (k, limits) in self.limits.iter().enumerate() {
            let slope = correction[k] - self.correction[k];
            let acceleration = slope - self.slope[k];
            let within = |value: f64, limit: f64| value.abs() <= limit * (1.0 + 1e-6) + 1e-15;
            exceeded |= !within(correction[k], limits.magnitude)
                || !within(slope, limits.slope_per_s * self.period_s)
                || !within(acceleration, limits.acceleration_per_s2 * self.period_s * self.period_s);
            (self.correction[k], self.slope[k]) = (correction[k], slope);
            self.limited[k] += u64::from(limited >> k & 1);
        }
        self.run.limits_exceeded += u64::from(exceeded);
    }

    fn end_of_turn(&mut self) {
        let harmonics = self.cell.pin.harmonics(self.band[1]);
        self.run.revolutions.push(Revolution {
            imprint_um: imprint(&harmonics, self.band[0]),
            roundness_um: self.cell.pin.roundness(),
            gauge_imprint_um: self.gauge_imprint,
            gauge_roundness_um: self.gauge.latest().map(|latest| latest.peak_to_valley_um),
            harmonics,
        });
    }

    pub(super) fn advance(&mut self, cycles: u64, observe: &mut dyn FnMut(&Moment<'_>)) -> Result<bool> {
        if !self.settled {
            self.settled = true;
            self.settle();
        }
        let (revolutions, limit) = (self.grinding.revolutions, self.most_cycles());
        for _ in 0..cycles {
            if self.cell.turns() >= f64::from(revolutions) {
                return Ok(false);
            }
            if self.run.cycles >= limit {
                return Err(SimError::Spindle { revolutions, cycles: limit });
            }
            self.cycle(observe, false)?;
        }
        Ok(self.cell.turns() < f64::from(revolutions))
    }

    pub(super) fn turns(&self) -> f64 {
        self.cell.turns()
    }

    pub(super) fn revolutions(&self) -> &[Revolution] {
        &self.run.revolutions
    }

    pub(super) fn finish(mut self) -> Run {
        self.run.limited_cycles = self.limited[self.cell.place()];
        let revolutions = &self.run.revolutions;
        let averaged = (revolutions.len() / 4).clamp(1, 10).min(revolutions.len());
        let last = &revolutions[revolutions.len() - averaged..];
        let mut average = vec![[0.0; 2]; self.band[1] + 1];
        for revolution in last {
            for (to, from) in average.iter_mut().zip(&revolution.harmonics) {
                to[0] += from[0] / averaged as f64;
                to[1] += from[1] / averaged as f64;
            }
        }
        self.run.imprint_um = imprint(&average, self.band[0]);
        self.run.roundness_um = last.iter().map(|r| r.roundness_um).sum::<f64>() / averaged.max(1) as f64;
        (self.run.average, self.run.averaged) = (average, averaged);
        self.run.counts = self.gauge.counts();
        self.run.evaluation = self.gauge.latest();
        self.run.correction = self.gauge.correction().to_vec();
        self.run.surfaces[1] = self.cell.pin.about_the_circle();
        self.run
    }
}
