//! Grinding a crankpin, with three probes on it and their infeed correction in the servo step.
//!
//! ```text
//! spindle: α, motion of the pin's centre ─┬─► contact ─► workpiece (a surface on a fine grid) ─► harmonics, roundness
//! linkage: β, θ = α + β                  ─┘      ▲            │
//! X drive: delay, lag ───────────────────────────┘            ▼
//!      ▲                                        probes at θ, θ + φ2, θ + φ2 + φ3; encoders
//!      └──────────── step with gauge ◄──────────────────────┘
//! ```
//!
//! The contact with the wheel is at the angle s = θ + ψ of the surface. There the wheel's edge is at
//!
//! ```text
//! level = level0 − x cos β − [R_Y cos(ψ + β) + R_X sin(ψ + β)]      µm; x: travel of the axis toward the workpiece
//! ```
//!
//! and material above it is removed: motion of the centre or of an axis towards the wheel leaves a low spot (r < 0). The
//! probes read `r + R_Y cos(φ + β) + R_X sin(φ + β)` of the same surface and the same motion. r > 0 is high.
//!
//! The programmed feed is a function of the spindle's turns that falls from roughing to a slow plunge, so that every point is
//! touched in every revolution. The chase motion that keeps the wheel at the circling pin is assumed perfect: the axis carries
//! only feed and correction.
//!
//! The simulation shares no code with the gauge, so that the simulated surface shows the true effect of the correction.

mod cell;
mod comparison;
mod control;
mod document;
mod event;
mod gauging;
mod infeed_drive;
mod outcome;
mod readings;
mod request;
mod result;
mod simulate;
mod spindle;
mod workpiece;

pub use comparison::{Comparison, simulate};
pub use document::{GrindingDocument, Motion, RevolutionFigures, RunFigures, SpindleFigures};
pub use event::Event;
pub use infeed_drive::InfeedDrive;
pub use outcome::Outcome;
pub use readings::readings;
pub use request::Request;
pub use result::{Moment, Revolution, Run};
pub use simulate::{Simulation, run};
pub use spindle::{CentreMotion, Linkage, Noise, Term, Turning, counts, sum};
pub use workpiece::{CELLS, Harmonic, Workpiece, imprint};

use crate::error::{Result, SimError};
use trueaxis::roundness::{GaugeSettings, ProbeAngles};
use trueaxis_tables::Machine;

/// A pin to be ground: machine, speed, process and events.
#[derive(Clone, Debug)]
pub struct Grinding {
    /// A machine of linear axes with a gauge and its infeed correction.
    pub machine: Machine,
    /// Servo rate.
    pub rate_hz: f64,
    /// Spindle speed.
    pub speed_rpm: f64,
    /// Turns of the spindle.
    pub revolutions: u32,
    /// Seed of the surface and of every noise.
    pub seed: u64,
    /// The process.
    pub process: Process,
    /// Events during the run.
    pub events: Vec<Event>,
}

/// The grinding process and its surroundings, unknown to the plugin.
#[derive(Clone, Debug, PartialEq)]
pub struct Process {
    /// Motion of the pin's centre.
    pub motion: CentreMotion,
    /// Stock removed in roughing, µm of radius; the feed falls by 63 % in an eighth of the revolutions.
    pub roughing_um: f64,
    /// Feed that remains, µm of radius per revolution.
    pub feed_um: f64,
    /// Standard deviation of a probe's noise, µm.
    pub probe_noise_um: f64,
    /// Pure delay of the infeed drive, s.
    pub delay_s: f64,
    /// First-order lag of the infeed drive, s.
    pub lag_s: f64,
}

impl Default for Process {
    fn default() -> Self {
        Process {
            motion: CentreMotion::default(),
            roughing_um: 30.0,
            feed_um: 0.1,
            probe_noise_um: 0.01,
            delay_s: 0.002,
            lag_s: 0.0005,
        }
    }
}

impl Grinding {
    /// Servo period, ns.
    pub fn period_ns(&self) -> u32 {
        (1e9 / self.rate_hz).round() as u32
    }

    /// The gauge of the machine.
    ///
    /// # Errors
    /// The machine has no gauge, or one without infeed correction, or it has rotary axes.
    pub fn gauge(&self) -> Result<&GaugeSettings> {
        let machine = format!("machine {}", self.machine.settings.name);
        let Some(gauge) = &self.machine.settings.roundness else {
            return Err(SimError::unsuited(machine, "no [roundness]", "a gauge of three probes"));
        };
        if gauge.infeed.is_none() {
            return Err(SimError::unsuited(machine, "no [roundness.infeed]", "the axis that corrects"));
        }
        if let Some(axis) = self.machine.settings.axes.iter().find(|a| a.axis.is_rotary()) {
            let found = format!("the rotary axis {}", axis.axis.letter());
            return Err(SimError::unsuited(machine, found, "linear axes only"));
        }
        Ok(gauge)
    }

    /// Total feed after some turns from the beginning of a part, µm of radius.
    pub fn fed_um(&self, turns: f64) -> f64 {
        let turns = turns.max(0.0);
        let constant = f64::from(self.revolutions.max(1)) / 8.0;
        self.process.roughing_um * -libm::expm1(-turns / constant) + self.process.feed_um * turns
    }
}

/// Angles of the probes, rad: 0, φ2, φ2 + φ3.
pub fn probe_angles(gauge: &GaugeSettings) -> [f64; 3] {
    let (phi2, phi3) = match gauge.angles {
        ProbeAngles::Slots { p, q } => {
            let slot = std::f64::consts::TAU / f64::from(gauge.points);
            (f64::from(p) * slot, f64::from(q) * slot)
        }
        ProbeAngles::Degrees { phi2, phi3 } => (phi2.to_radians(), phi3.to_radians()),
    };
    [0.0, phi2, phi2 + phi3]
}

/// Highest speed at which the gauge can resample, rpm: θ passes at most two points per cycle, and the arm makes θ up to R/(R_S
/// + R_W) faster than α; a tenth is reserved for the ripple of the speed.
pub fn fastest_rpm(gauge: &GaugeSettings, rate_hz: f64) -> f64 {
    let ratio = gauge.arm.map_or(0.0, |arm| arm.lengths.ratio().unwrap_or(0.0));
    60.0 * rate_hz * 2.0 / (1.1 * (1.0 + ratio) * f64::from(gauge.points))
}

/// Speed at which the gauge has to skip at least `skip` whole revolutions between two evaluated ones, rpm.
///
/// # Errors
/// The settings do not build, or the speed would exceed [`fastest_rpm`].
pub fn speed_that_skips(gauge: &GaugeSettings, rate_hz: f64, skip: u32) -> Result<f64> {
    let most = simulate::cycles_of_work(gauge, (1e9 / rate_hz).round() as u32)?;
    // Two units per point are spent only when a window of spindle motion is full, one only when the wheel has changed.
    let seldom = usize::from(gauge.points) * if gauge.arm.is_some() { 3 } else { 2 };
    let seldom = seldom / usize::from(gauge.slices_per_cycle.max(1));
    let work = most.saturating_sub(seldom).max(1) as f64;
    let cycles = work / (f64::from(skip) + 0.5);
    let speed_rpm = 60.0 * rate_hz / cycles;
    let fastest = fastest_rpm(gauge, rate_hz);
    if speed_rpm > fastest {
        let most = (work * fastest / (60.0 * rate_hz) - 0.5).floor().max(0.0);
        let needed = format!(
            "at most {most}: revolutions of {cycles:.1} cycles, of which its {work} cycles of work would span so many, are \
             too short for {} points",
            gauge.points
        );
        return Err(SimError::unsuited("--skip", skip.to_string(), needed));
    }
    Ok(speed_rpm)
}
