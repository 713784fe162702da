//! Ball test of a five-axis head: measure, identify, compile, measure again.
//!
//! With RTCP on, the control keeps the centre of a ball still while C turns a full circle with A at rest, then A a quarter
//! turn with C at rest, in three set-ups each. The simulated gauge reads the deviation that the machine's exact geometry
//! produces. The identified six errors of either axis become tables, which are compiled as for a controller, and the cycle is
//! repeated with the plugin's volumetric correction:
//!
//! ```text
//! true tables ─► exact geometry ─► gauge + noise ─► identification ─► tables ─► .tcomp ─► correction ─┐
//!                     ▲                                                                               │
//!                     └───────────────────────────── corrected command ◄──────────────────────────────┘
//! ```
//!
//! Linear axes are assumed perfect: the results show the errors of the rotary axes, and the residuals.
//!
//! Source: CN105479268A (cycle and set-ups).

mod corrected;
mod cycle;
mod outcome;

pub use cycle::{SET_UPS_A, SET_UPS_C};
pub use outcome::{AxisOutcome, Outcome, Stop, TipError};

use crate::error::{Result, SimError};
use trueaxis::Axis;
use trueaxis_tables::Machine;

/// A test to be simulated.
#[derive(Clone, Debug)]
pub struct BallCycle {
    /// A machine whose head carries A in C; its tables are the true errors.
    pub machine: Machine,
    /// Standard deviation of the gauge in each direction, µm.
    pub gauge_noise_um: f64,
    /// Seed of the gauge's noise.
    pub seed: u64,
}

impl BallCycle {
    /// Runs the whole loop.
    ///
    /// # Errors
    /// A machine without a head of C and A, or any error of identification or compilation.
    pub fn run(&self) -> Result<Outcome> {
        outcome::run(self)
    }
}

/// The machine with perfect linear axes: tables, squareness, backlash and growth of rotary axes only.
fn rotary_only(machine: &Machine) -> Result<Machine> {
    let code: String = machine.settings.chain.chars().filter(|c| !c.is_whitespace()).collect();
    if !code.ends_with("CAt") || code.contains("C'") || code.contains("A'") || code.contains('B') {
        return Err(SimError::unsuited(
            format!("machine {}", machine.settings.name),
            format!("the chain \"{}\"", machine.settings.chain),
            "one that ends in \"C A t\" and has no other rotary axis",
        ));
    }
    let mut machine = machine.clone();
    machine.settings.periodic.retain(|period| period.axis.is_rotary());
    let location = &mut machine.settings.location;
    (location.a0z, location.b0z, location.c0y) = (0.0, 0.0, 0.0);
    for (settings, table) in machine.settings.axes.iter_mut().zip(&mut machine.tables) {
        settings.backlash = 0.0;
        settings.thermal = Default::default();
        if !settings.axis.is_rotary() {
            *table = None;
        }
    }
    Ok(machine)
}

/// Index of an axis among the machine's axes.
fn place(machine: &Machine, axis: Axis) -> Option<usize> {
    machine.settings.axes.iter().position(|settings| settings.axis == axis)
}
