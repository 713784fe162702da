//! One run: every servo cycle goes through the step with its gauge, and the surface is ground.

use super::Grinding;
use super::cell::Cell;
use super::workpiece::{Harmonic, imprint};
use crate::servo::with_loop;
use anyhow::{Result, anyhow, bail};
use trueaxis::machine::{AXES, Limits};
use trueaxis::roundness::{Counts, Evaluation, Flags, Roundness, RoundnessSettings, RoundnessState};
use trueaxis::sample::Refusal;
use trueaxis::{Fault, GaugeRide, Input, ServoLoop, State};

/// Calls a function that is generic over the points of a revolution.
macro_rules! with_points {
    ($points:expr, $function:ident, ($($argument:expr),*)) => {
        match $points {
            64 => $function::<64>($($argument),*),
            128 => $function::<128>($($argument),*),
            256 => $function::<256>($($argument),*),
            512 => $function::<512>($($argument),*),
            1024 => $function::<1024>($($argument),*),
            2048 => $function::<2048>($($argument),*),
            4096 => $function::<4096>($($argument),*),
            other => bail!("[roundness] points: found {other}, needed a power of two from 64 to 4096"),
        }
    };
}

/// What an observer sees of a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'m> {
    /// Turns of the spindle since the first index pulse.
    pub turns: f64,
    /// What the drives are told, X, Y, Z, mm.
    pub drive_mm: [f64; 3],
    /// Correction in it, tables and infeed, mm.
    pub correction_mm: [f64; 3],
    /// Infeed correction that the gauge asks for, mm.
    pub infeed_mm: f64,
    /// What the gauge met.
    pub flags: Flags,
    /// A revolution has just been evaluated.
    pub finished: bool,
    /// How revolutions fared.
    pub counts: Counts,
    /// Infeed correction over the surface, µm.
    pub table_um: &'m [f64],
}

/// What one turn of the spindle left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Revolution {
    /// Harmonics of the true surface at its end, 0 to the last that is corrected.
    pub harmonics: Vec<Harmonic>,
    /// Root mean square of those in the corrected band, µm.
    pub imprint_um: f64,
    /// Peak to valley of the true surface, all harmonics and noise, µm.
    pub roundness_um: f64,
    /// The gauge's latest figures, once it has any: the same band, µm.
    pub gauge_imprint_um: Option<f64>,
    /// Peak to valley as the gauge evaluates it (after its filter), µm.
    pub gauge_roundness_um: Option<f64>,
}

/// Result of one run.
#[derive(Clone, Debug)]
pub struct Run {
    /// One entry a turn of the spindle.
    pub revolutions: Vec<Revolution>,
    /// Harmonics of the true surface, averaged over the last revolutions: what is not synchronous cancels.
    pub average: Vec<Harmonic>,
    /// Over how many.
    pub averaged: usize,
    /// Root mean square of the average in the corrected band, µm.
    pub imprint_um: f64,
    /// Mean peak to valley over the same revolutions, µm.
    pub roundness_um: f64,
    /// How revolutions fared.
    pub counts: Counts,
    /// The gauge's latest evaluation.
    pub evaluation: Option<Evaluation<f64>>,
    /// Motion of the centre as the gauge sees it in its latest revolution, R_X and R_Y over θ, µm.
    pub motion: [Vec<f64>; 2],
    /// Infeed correction over the surface at the end, µm.
    pub correction: Vec<f64>,
    /// True surface before and after, without mean and first harmonic, µm.
    pub surfaces: [Vec<f64>; 2],
    /// Cycles in which a correction passed its limit of magnitude, slope or acceleration.
    pub limits_exceeded: u64,
    /// Cycles in which the limiter held the infeed axis back.
    pub limited_cycles: u64,
    /// Whatever the gauge met.
    pub flags: Flags,
    /// Servo cycles.
    pub cycles: u64,
    /// Cycles that the work on a revolution takes at most.
    pub cycles_of_work: usize,
}

/// Cycles that the work on a revolution takes at most.
pub(super) fn cycles_of_work(gauge: &RoundnessSettings, period_ns: u32) -> Result<usize> {
    fn of<const POINTS: usize>(gauge: &RoundnessSettings, period_ns: u32) -> Result<usize> {
        Ok(build::<POINTS>(gauge, period_ns)?.cycles_of_work())
    }
    with_points!(gauge.points, of, (gauge, period_ns))
}

fn build<const POINTS: usize>(gauge: &RoundnessSettings, period_ns: u32) -> Result<Box<Roundness<f64, POINTS>>> {
    Ok(Box::new(Roundness::build(gauge, period_ns).map_err(|e| anyhow!("[roundness]: {e}"))?))
}

/// Grinds with the correction on or off; the gauge measures either way. `observe` is called in every cycle.
///
/// # Errors
/// The machine has no gauge with infeed correction, or something about it does not build.
pub fn run(grinding: &Grinding, corrected: bool, observe: &mut dyn FnMut(&Moment<'_>)) -> Result<Run> {
    let gauge = grinding.gauge()?;
    with_points!(gauge.points, run_with, (grinding, corrected, observe))
}

fn run_with<const POINTS: usize>(
    grinding: &Grinding,
    corrected: bool,
    observe: &mut dyn FnMut(&Moment<'_>),
) -> Result<Run> {
    let mut settings = *grinding.gauge()?;
    let place = settings.infeed.map_or(0, |infeed| infeed.axis.index());
    if !corrected {
        settings.infeed = None;
    }
    let gauge = build::<POINTS>(&settings, grinding.period_ns())?;
    with_loop::<3, _>(&grinding.machine, grinding.period_ns(), |servo| {
        let mut control = Control::<POINTS>::new(grinding, servo, &gauge)?;
        control.settle();
        let limit = control.most_cycles();
        while control.cell.turns() < f64::from(grinding.revolutions) && control.run.cycles < limit {
            control.cycle(observe, false)?;
        }
        if control.cell.turns() < f64::from(grinding.revolutions) {
            bail!("the spindle has not turned {} times within {limit} cycles", grinding.revolutions);
        }
        control.run.limited_cycles = control.limited[place];
        Ok(control.finish())
    })
}

/// Control and machine of one run.
struct Control<'c, 'a, const POINTS: usize> {
    grinding: &'c Grinding,
    servo: &'c ServoLoop<'a, f64, f64, 3>,
    state: State<f64, f64, 3>,
    gauge: &'c Roundness<f64, POINTS>,
    gauge_state: Box<RoundnessState<f64, POINTS>>,
    cell: Cell<'c>,
    limits: [Limits; 3],
    period_s: f64,
    correction: [f64; 3],
    slope: [f64; 3],
    limited: [u64; 3],
    band: [usize; 2],
    gauge_imprint: Option<f64>,
    run: Run,
}

impl<'c, 'a, const POINTS: usize> Control<'c, 'a, POINTS> {
    fn new(
        grinding: &'c Grinding,
        servo: &'c ServoLoop<'a, f64, f64, 3>,
        gauge: &'c Roundness<f64, POINTS>,
    ) -> Result<Self> {
        let cell = Cell::new(grinding)?;
        let free = Limits { magnitude: f64::MAX, slope_per_s: f64::MAX, acceleration_per_s2: f64::MAX };
        let mut limits = [free; 3];
        for axis in grinding.machine.settings.axes.iter().take(AXES) {
            if let Some(to) = limits.get_mut(axis.axis.index()) {
                *to = axis.limits;
            }
        }
        let band = grinding.gauge()?.infeed.map_or([2, 2], |infeed| [infeed.band.first, infeed.band.last]);
        let state =
            servo.start(grinding.period_ns()).map_err(|fault| anyhow!("the step refused to start: {fault:?}"))?;
        let before = cell.pin.about_the_circle();
        Ok(Control {
            grinding,
            servo,
            state,
            gauge,
            gauge_state: Box::new(gauge.start()),
            cell,
            limits,
            period_s: 1.0 / grinding.rate_hz,
            correction: [0.0; 3],
            slope: [0.0; 3],
            limited: [0; 3],
            band: band.map(usize::from),
            gauge_imprint: None,
            run: Run {
                revolutions: Vec::new(),
                average: Vec::new(),
                averaged: 0,
                imprint_um: 0.0,
                roundness_um: 0.0,
                counts: Counts::default(),
                evaluation: None,
                motion: [Vec::new(), Vec::new()],
                correction: Vec::new(),
                surfaces: [before, Vec::new()],
                limits_exceeded: 0,
                limited_cycles: 0,
                flags: Flags::default(),
                cycles: 0,
                cycles_of_work: gauge.cycles_of_work(),
            },
        })
    }

    /// Time for the tables' correction to be led in while the spindle stands and the wheel is off the part.
    fn settle(&mut self) {
        let slowest = self.limits.iter().filter(|l| l.magnitude < 1e3);
        let seconds = slowest.map(|l| l.magnitude / l.slope_per_s + l.slope_per_s / l.acceleration_per_s2);
        for _ in 0..(1.2 * seconds.fold(0.0, f64::max).min(2.0) * self.grinding.rate_hz) as u64 {
            if self.cycle(&mut |_| {}, true).is_err() {
                return;
            }
        }
    }

    /// Twice the time that the turns and the stops take: a run always ends.
    fn most_cycles(&self) -> u64 {
        let stops = self.grinding.events.iter().map(|event| match event {
            super::Event::Stop { for_s, .. } => *for_s,
            _ => 0.0,
        });
        let turning = 60.0 * (f64::from(self.grinding.revolutions) + 1.0) / self.grinding.speed_rpm;
        (2.0 * self.grinding.rate_hz * (turning + 1.0 + stops.sum::<f64>())) as u64
    }

    fn cycle(&mut self, observe: &mut dyn FnMut(&Moment<'_>), settling: bool) -> Result<()> {
        let (new_part, wheel) = if settling { (false, None) } else { self.cell.happen() };
        let readings = self.cell.read(new_part, wheel);
        if let Some(wheel_mm) = readings.wheel_mm {
            self.gauge.set_wheel(&mut self.gauge_state, wheel_mm).map_err(|e| anyhow!("wheel: {e}"))?;
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
        };
        let mut ride = GaugeRide::new(self.gauge, &mut self.gauge_state, &readings.probes);
        let output = self.servo.step(&mut self.state, &input, (), &mut ride);
        let cycle = ride.cycle();
        if output.record.fault != Fault::None {
            let at = self.cell.turns();
            bail!("the step reports {:?} after {at:.2} turns", output.record.fault);
        }
        self.hold_against_limits(output.record.correction, output.record.limited);
        if cycle.finished {
            let harmonics: Vec<Harmonic> = (0..=self.band[1]).map(|k| self.gauge_state.harmonic(k)).collect();
            self.gauge_imprint = Some(imprint(&harmonics, self.band[0]));
            self.run.motion = self.gauge_state.motion().map(|motion| motion.to_vec());
        }
        let turn = self.cell.turns().floor();
        self.cell.advance(output.drive[self.cell.place()], settling);
        if settling {
            return Ok(());
        }
        self.run.cycles += 1;
        self.run.flags = Flags(self.run.flags.0 | cycle.flags.0);
        observe(&Moment {
            turns: self.cell.turns(),
            drive_mm: output.drive,
            correction_mm: output.record.correction,
            infeed_mm: cycle.infeed,
            flags: cycle.flags,
            finished: cycle.finished,
            counts: self.gauge_state.counts(),
            table_um: self.gauge_state.correction(),
        });
        if self.cell.turns().floor() > turn && turn >= 0.0 {
            self.end_of_turn();
        }
        Ok(())
    }

    /// Magnitude, slope and acceleration of what the plugin adds to the command, whatever happens.
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
            gauge_roundness_um: self.gauge_state.latest().map(|latest| latest.peak_to_valley_um),
            harmonics,
        });
    }

    fn finish(mut self) -> Run {
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
        self.run.counts = self.gauge_state.counts();
        self.run.evaluation = self.gauge_state.latest();
        self.run.correction = self.gauge_state.correction().to_vec();
        self.run.surfaces[1] = self.cell.pin.about_the_circle();
        self.run
    }
}
