//! Friction from circles: records circles on the simulated machine, identifies friction, configures the plugin with it, and
//! records again.
//!
//! ```text
//! Circles ─► Recorder ─► Pass ─► sent() ─► identify ─► configured() ─► Recorder ─► Pass ─► Outcome
//! ```
//!
//! The figures are identified by [`trueaxis_metrology::friction::identify`], which has no knowledge of the plant.

mod circles;
mod outcome;

pub use circles::{Circles, Pass, Plane, Recorder, joined};
pub use outcome::{AxisOutcome, Figures, Outcome, Pair, Spikes};

use crate::error::SimError;
use trueaxis::machine::DynamicSettings;
use trueaxis_metrology::friction::{FrictionRefusal, Identified};
use trueaxis_tables::Machine;

/// The machine with the identified friction and drives, and nothing else that acts on the servo.
pub fn configured(mut machine: Machine, found: &[Identified; 2]) -> Machine {
    for own in &mut machine.settings.axes {
        let identified = found.iter().find(|found| found.axis == own.axis);
        own.servo.friction = identified.map(|found| found.friction);
        if let Some(found) = identified {
            own.servo.drive = Some(found.drive);
        }
        let limits = own.servo.dynamic.unwrap_or(DynamicSettings::with_defaults(own.axis)).limits;
        own.servo.dynamic =
            identified.map(|_| DynamicSettings { limits, lag: false, acceleration: false, take_up: false, lag_s: 0.0 });
    }
    machine.settings.contour.feedback = None;
    machine.settings.crosstalk.clear();
    machine
}

impl SimError {
    /// The error for a refused record `of` something.
    fn friction(of: &'static str) -> impl Fn(FrictionRefusal) -> SimError {
        move |error| SimError::Friction { of, error }
    }
}
