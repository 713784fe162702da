//! The simulated machine: servo drives, exact geometry, encoders, faults.

pub mod drive;
pub mod encoder;
pub mod fault;
pub mod geometry;

use drive::{Drive, DriveSettings, Play};
use encoder::{Encoder, EncoderSettings};
use fault::{Injection, Kind};
use geometry::{Geometry, place_of};
use trueaxis::Axis;
use trueaxis_tables::Machine;

/// What a servo cycle of the machine gives.
#[derive(Clone, Copy, Debug)]
pub struct Readings<const N: usize> {
    /// What the encoders say, mm (deg); NaN at a dropout.
    pub position: [f64; N],
    /// Time since the last cycle in periods, 1 unless a cycle is made late.
    pub elapsed_periods: f64,
}

#[derive(Clone, Debug)]
struct AxisPlant {
    axis: Axis,
    drive: Drive,
    encoder: Encoder,
    play: Play,
    backlash: f64,
    measured: f64,
    reading: f64,
}

/// A machine of `N` axes in motion: X, Y, Z, then the rotary ones.
///
/// The drives close their loops over the encoders; geometry and lost motion lie behind the encoders, where no servo
/// sees them. The same seed gives the same encoder noise whether the geometry is perfect or not.
#[derive(Clone, Debug)]
pub struct Plant<const N: usize> {
    axes: Vec<AxisPlant>,
    geometry: Option<Geometry>,
    faults: Vec<Injection>,
    period: f64,
    cycle: u64,
    tip: [f64; 3],
}

impl<const N: usize> Plant<N> {
    /// A machine at rest. With `perfect`, its geometry has no error and its drives no lost motion.
    pub fn new(machine: &Machine, perfect: bool, seed: u64, period_s: f64, faults: &[Injection]) -> Plant<N> {
        let rotary = machine.settings.axes.iter().map(|a| a.axis).filter(|a| a.is_rotary());
        let axes = [Axis::X, Axis::Y, Axis::Z].into_iter().chain(rotary).take(N).enumerate().map(|(place, axis)| {
            let found = machine.axes().find(|(settings, _)| settings.axis == axis);
            let backlash = found.filter(|_| !perfect).map_or(0.0, |(settings, _)| settings.backlash);
            // What is bidirectional in the table is lost motion too: the wider of the two is the play.
            let own = axis.index();
            let table = found.and_then(|(_, table)| table).filter(|_| !perfect);
            let spread = table.map_or(0.0, |t| {
                t.rows.iter().map(|row| (row.reverse[own] - row.forward[own]).abs()).fold(0.0, f64::max)
            });
            let spread = if axis.is_rotary() { spread.to_degrees() } else { spread };
            let kind = if axis.is_rotary() { EncoderSettings::ROTARY } else { EncoderSettings::LINEAR };
            AxisPlant {
                axis,
                drive: Drive::new(DriveSettings::typical(place), period_s),
                encoder: Encoder::new(kind, seed, place),
                play: Play::new(spread.max(backlash.abs())),
                backlash,
                measured: 0.0,
                reading: 0.0,
            }
        });
        Plant {
            axes: axes.collect(),
            geometry: (!perfect).then(|| Geometry::new(machine)),
            faults: faults.to_vec(),
            period: period_s,
            cycle: 0,
            tip: [0.0; 3],
        }
    }

    /// The machine moves for one period towards the drives' commands; gives what the encoders then read.
    pub fn cycle(&mut self, drive: &[f64; N]) -> Readings<N> {
        let first = self.cycle == 0;
        let mut readings = Readings { position: [0.0; N], elapsed_periods: 1.0 };
        let (mut at, mut reversed) = ([0.0; N], [0.0; N]);
        for (place, axis) in self.axes.iter_mut().enumerate() {
            let position = axis.drive.cycle(drive[place], axis.measured);
            let counts = axis.encoder.read(position);
            axis.measured = axis.encoder.position(counts);
            // A glitch or a stuck count is what the plugin's interface sees; the drive has its own.
            let mut reading = axis.measured;
            for fault in self.faults.iter().filter(|f| f.axis == axis.axis && f.acts(self.cycle, self.period)) {
                match fault.kind {
                    Kind::Dropout => reading = f64::NAN,
                    Kind::Glitch(size) => reading += size,
                    Kind::Stuck if !first => reading = axis.reading,
                    _ => {}
                }
            }
            axis.reading = reading;
            readings.position[place] = reading;
            at[place] = position;
            reversed[place] = axis.play.cycle(position);
        }
        for fault in self.faults.iter().filter(|f| f.acts(self.cycle, self.period)) {
            if let Kind::Late(periods) = fault.kind {
                readings.elapsed_periods = periods;
            }
        }
        self.tip = [at[0], at[1], at[2]];
        if let Some(geometry) = &self.geometry {
            let error = geometry.tip_error(&at, &reversed);
            for (k, tip) in self.tip.iter_mut().enumerate() {
                *tip += error[k] + self.axes[k].backlash * reversed[k];
            }
        }
        self.cycle += 1;
        readings
    }

    /// The command as the faulty host hands it over in the coming cycle.
    pub fn spoil(&self, command: &mut [f64; N]) {
        for fault in self.faults.iter().filter(|f| f.acts(self.cycle, self.period)) {
            if let Some(place) = self.axes.iter().position(|a| a.axis == fault.axis) {
                match fault.kind {
                    Kind::NanCommand => command[place] = f64::NAN,
                    Kind::JumpCommand(size) => command[place] += size,
                    _ => {}
                }
            }
        }
    }

    /// Where the tool tip truly is, relative to the workpiece, in machine coordinates, mm.
    pub fn true_tip(&self) -> [f64; 3] {
        self.tip
    }
}

/// How many axes a step for a machine has.
pub fn axis_count(machine: &Machine) -> usize {
    machine.settings.axes.iter().map(|a| place_of(machine, a.axis) + 1).max().unwrap_or(3).max(3)
}
