//! The simulated machine: drives, encoders, lost motion and the true geometry behind them.
//!
//! ```text
//! drive command -> drive -> axis position -> encoder -> (fault) -> reading
//!                                |
//!                           lost motion -> geometry -> true tool tip
//! ```
//!
//! A drive with two masses has two positions: the encoder reads motor or load, the tip follows the load.
//!
//! The encoders see neither lost motion nor geometry, so that readings are bit-identical for a perfect and an imperfect
//! machine.

mod agreed;
pub mod delay;
pub mod drive;
pub mod encoder;
pub mod fault;
mod lost_motion;
pub mod variation;

use drive::{Disagreement, Drive, DriveSettings};
use encoder::{Encoder, EncoderSettings};
use fault::{Fault, FaultKind, FaultScript};

pub use agreed::{agreed, stated};
use lost_motion::LostMotion;

use thiserror::Error;
use trueaxis::machine::{AXES, Axis, AxisSettings};
use trueaxis_tables::exact::{Geometry, GeometryError, ToolPose};
use trueaxis_tables::{Machine, Table};

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

/// Play of an axis without backlash whose own positioning error does not depend on the direction of travel, mm (deg).
const SMALLEST_PLAY: f64 = 1e-3;

/// Reason why a plant cannot be built.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlantError {
    /// The machine's structure is not usable.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The servo period is not usable.
    #[error("servo period: found {found_s} s, needed 1e-6 to 0.1 s")]
    Period {
        /// The period given, s.
        found_s: f64,
    },
    /// Figures of a drive do not agree with each other or with the servo period.
    #[error("drive of axis {axis}: {}: found {}, needed {}", .of.key, .of.found, .of.needed)]
    Drive {
        /// The axis' letter.
        axis: char,
        /// The figure.
        of: Disagreement,
    },
    /// A fault names an axis that the machine does not have.
    #[error("fault script: found axis {axis}, needed one of the machine's axes")]
    FaultAxis {
        /// The axis' letter.
        axis: char,
    },
}

/// Properties of the plant that are not in the machine file.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantSettings {
    /// Drives, in the order X Y Z A B C.
    pub drives: [DriveSettings; AXES],
    /// Encoders, in the order X Y Z A B C.
    pub encoders: [EncoderSettings; AXES],
    /// Lost motion that is not in the machine's tables, in the order X Y Z A B C, mm (deg).
    pub lost_motion_mm: [f64; AXES],
    /// Temperature above the machine's reference temperature, K.
    pub temperature_rise_k: f64,
    /// Scripted faults.
    pub faults: FaultScript,
}

impl Default for PlantSettings {
    fn default() -> PlantSettings {
        PlantSettings {
            drives: Axis::ALL.map(DriveSettings::of),
            encoders: Axis::ALL.map(EncoderSettings::of),
            lost_motion_mm: [0.0; AXES],
            temperature_rise_k: 0.0,
            faults: FaultScript::default(),
        }
    }
}

/// Readings of the control at the end of a cycle; one entry per axis in the order of the machine's axes, the rest zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Encoder counts (0 where the reading is missing).
    pub counts: [i64; AXES],
    /// Counts times resolution, mm or degrees (NaN where the reading is missing).
    pub position: [f64; AXES],
    /// Whether there was a reading.
    pub valid: [bool; AXES],
    /// Time since the previous cycle in periods: 1 unless the cycle is late.
    pub elapsed_periods: f64,
}

/// One axis: drive, lost motion and encoder.
#[derive(Clone, Debug)]
struct Station {
    axis: Axis,
    drive: Drive,
    play: LostMotion,
    /// Lost motion that is not in the tables, mm (deg).
    unknown_play: f64,
    encoder: Encoder,
    /// Last reading of the drive, and last reading that the control received.
    counts: i64,
    sent: i64,
    /// Reading from which a wrong scale counts: the last one without it.
    scaled_from: i64,
}

/// A machine with its servo drives, cycle by cycle; deterministic for a given seed.
#[derive(Clone, Debug)]
pub struct Plant {
    stations: Vec<Station>,
    geometry: Geometry,
    perfect_geometry: bool,
    faults: FaultScript,
    faults_held: bool,
    period_s: f64,
    cycle: u64,
}

impl Plant {
    /// A machine at rest with all axes at zero, last moved in positive direction.
    ///
    /// `perfect_geometry`: neither geometric errors nor lost motion, everything else unchanged. `seed`: seed of the encoders'
    /// noise. `period_s`: servo period, 1 µs to 0.1 s.
    pub fn new(
        machine: &Machine,
        settings: PlantSettings,
        perfect_geometry: bool,
        seed: u64,
        period_s: f64,
    ) -> Result<Plant, PlantError> {
        if !(1e-6..=0.1).contains(&period_s) {
            return Err(PlantError::Period { found_s: period_s });
        }
        for (own, _) in machine.axes() {
            let disagree = |of| PlantError::Drive { axis: own.axis.letter(), of };
            settings.drives[own.axis.index()].agree(period_s).map_err(disagree)?;
        }
        let geometry = Geometry::new(machine, settings.temperature_rise_k)?;
        let stations: Vec<Station> = machine
            .axes()
            .map(|(own, table)| {
                let i = own.axis.index();
                Station {
                    axis: own.axis,
                    drive: Drive::new(settings.drives[i], period_s),
                    play: LostMotion::new(play_width(own, table) + settings.lost_motion_mm[i]),
                    unknown_play: if perfect_geometry { 0.0 } else { settings.lost_motion_mm[i] },
                    encoder: Encoder::new(settings.encoders[i], own.axis, seed),
                    counts: 0,
                    sent: 0,
                    scaled_from: 0,
                }
            })
            .collect();
        let mut plant = Plant {
            stations,
            geometry,
            perfect_geometry,
            faults: FaultScript::default(),
            faults_held: false,
            period_s,
            cycle: 0,
        };
        settings.faults.items.into_iter().try_for_each(|fault| plant.inject(fault))?;
        Ok(plant)
    }

    /// Adds a fault to the script; if its start has passed, it acts as if it had begun then.
    ///
    /// # Errors
    /// The fault names an axis that the machine does not have.
    pub fn inject(&mut self, fault: Fault) -> Result<(), PlantError> {
        if let Some(axis) = fault.kind.axis().filter(|axis| self.stations.iter().all(|station| station.axis != *axis)) {
            return Err(PlantError::FaultAxis { axis: axis.letter() });
        }
        self.faults.items.push(fault);
        Ok(())
    }

    /// Sets all axes at rest at `position` (mm, deg), last moved in positive direction; noise and fault script continue.
    pub fn rest_at(&mut self, position: &[f64; AXES]) {
        for (station, &q) in self.stations.iter_mut().zip(position) {
            station.drive.rest_at(q);
            station.play.follow(f64::MAX);
            station.counts = (q / station.encoder.resolution()).round() as i64;
            station.sent = station.counts;
            station.scaled_from = station.counts;
        }
    }

    /// Suppresses all faults until [`Plant::start_faults`].
    pub fn hold_faults(&mut self) {
        self.faults_held = true;
    }

    /// Restarts the cycle counter, and with it the fault script, at zero.
    pub fn start_faults(&mut self) {
        self.faults_held = false;
        self.cycle = 0;
    }

    /// Cycle of the fault script; far beyond its end while the script is paused.
    fn script_cycle(&self) -> u64 {
        if self.faults_held { u64::MAX } else { self.cycle }
    }

    /// Applies the faults scripted for the coming cycle to the position that the host commands.
    pub fn disturb_command(&self, command: &mut [f64; AXES]) {
        let cycle = self.script_cycle();
        for kind in self.faults.acting(cycle, self.period_s) {
            for (station, value) in self.stations.iter().zip(command.iter_mut()) {
                match kind {
                    FaultKind::NanCommand(axis) if axis == station.axis => *value = f64::NAN,
                    FaultKind::JumpCommand(axis, by) if axis == station.axis => *value += by,
                    _ => {}
                }
            }
        }
    }

    /// Simulates one servo cycle: the drives get `drive_command` (mm, deg), the encoders are read at its end.
    pub fn cycle(&mut self, drive_command: &[f64; AXES]) -> Readings {
        let cycle = self.script_cycle();
        let elapsed_periods = self
            .faults
            .acting(cycle, self.period_s)
            .filter_map(|kind| if let FaultKind::Late(periods) = kind { Some(periods) } else { None })
            .fold(1.0, f64::max);
        let mut readings = Readings { counts: [0; AXES], position: [0.0; AXES], valid: [true; AXES], elapsed_periods };
        for (i, (station, &command)) in self.stations.iter_mut().zip(drive_command).enumerate() {
            let resolution = station.encoder.resolution();
            let before = station.drive.load_position();
            station.drive.cycle(command, station.counts as f64 * resolution, elapsed_periods);
            station.play.follow(station.drive.load_position() - before);
            station.counts = station.encoder.read(station.drive.position());

            let mut sent = station.counts;
            let mut scaled = false;
            for kind in self.faults.acting(cycle, self.period_s) {
                match kind {
                    FaultKind::Stuck(axis) if axis == station.axis => sent = station.sent,
                    FaultKind::Scale(axis, multiple) if axis == station.axis => {
                        scaled = true;
                        let way = (sent - station.scaled_from) as f64;
                        sent = station.scaled_from.saturating_add((multiple * way).round() as i64);
                    }
                    FaultKind::Glitch(axis, by) if axis == station.axis => {
                        sent = sent.saturating_add((by / resolution).round() as i64);
                    }
                    FaultKind::Dropout(axis) if axis == station.axis => readings.valid[i] = false,
                    _ => {}
                }
            }
            if !scaled {
                station.scaled_from = station.counts;
            }
            if readings.valid[i] {
                readings.counts[i] = sent;
                readings.position[i] = sent as f64 * resolution;
                station.sent = sent;
            } else {
                readings.position[i] = f64::NAN;
            }
        }
        self.cycle += 1;
        readings
    }

    /// True position of the tool tip relative to the workpiece, in machine coordinates, mm: the positions of X, Y and Z plus
    /// the tip error d of [`Geometry::tip_error`] (0 for an axis that the machine does not have; the tool's length is not
    /// included).
    pub fn true_tip(&self) -> [f64; 3] {
        let position = self.carriage_positions();
        let mut tip = if self.perfect_geometry { [0.0; 3] } else { self.tip_error_at(&position) };
        for (station, q) in self.stations.iter().zip(position) {
            if let Some(component) = tip.get_mut(station.axis.index()) {
                *component += q;
            }
        }
        tip
    }

    /// Tool tip and tool direction in the workpiece's frame, tool length and rotary axes included.
    pub fn true_pose(&self) -> ToolPose {
        let position = self.carriage_positions();
        if self.perfect_geometry {
            self.geometry.ideal_pose(&position)
        } else {
            self.geometry.actual_pose(&position, &self.reversal())
        }
    }

    /// True positions of the axes on the encoders' side, mm or degrees, free of encoder errors.
    pub fn axis_positions(&self) -> [f64; AXES] {
        let mut position = [0.0; AXES];
        for (q, station) in position.iter_mut().zip(&self.stations) {
            *q = station.drive.position();
        }
        position
    }

    /// The loads' positions behind the lost motion that is not in the tables; the tables' own is part of the geometry.
    fn carriage_positions(&self) -> [f64; AXES] {
        let mut position = [0.0; AXES];
        for (q, station) in position.iter_mut().zip(&self.stations) {
            *q = station.drive.load_position() + station.unknown_play * station.play.reverse();
        }
        position
    }

    /// Travel per count of each axis, mm or degrees.
    pub fn resolutions(&self) -> [f64; AXES] {
        let mut resolution = [0.0; AXES];
        for (value, station) in resolution.iter_mut().zip(&self.stations) {
            *value = station.encoder.resolution();
        }
        resolution
    }

    /// Number of cycles simulated.
    pub fn cycles(&self) -> u64 {
        self.cycle
    }

    fn tip_error_at(&self, position: &[f64; AXES]) -> [f64; 3] {
        self.geometry.tip_error(position, &self.reversal())
    }

    /// Traversed share of each axis' lost motion.
    pub(crate) fn reversal(&self) -> [f64; AXES] {
        let mut reverse = [0.0; AXES];
        for (value, station) in reverse.iter_mut().zip(&self.stations) {
            *value = station.play.reverse();
        }
        reverse
    }
}

/// Lost motion of an axis: its backlash plus the largest difference of its positioning error between the table's directions.
fn play_width(settings: &AxisSettings, table: Option<&Table>) -> f64 {
    let own = settings.axis.index();
    let rows = table.map_or(&[][..], |table| &table.rows);
    let spread = rows.iter().map(|row| (row.reverse[own] - row.forward[own]).abs()).fold(0.0, f64::max);
    let spread = if settings.axis.is_rotary() { spread.to_degrees() } else { spread };
    let width = settings.backlash.abs() + spread;
    if width > 0.0 { width } else { SMALLEST_PLAY }
}
