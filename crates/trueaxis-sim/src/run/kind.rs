//! The machines of a run, and the plugin that each is driven by.

use crate::error::{Result, SimError};
use std::borrow::Cow;
use trueaxis::ConfigError;
use trueaxis::check;
use trueaxis::machine::{ErrorModel, MachineSettings};
use trueaxis_tables::Machine;

/// A machine of a run and how it is driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The machine as it is, the plugin disabled.
    Uncompensated,
    /// The plugin enabled, its dynamic parts off: geometry alone.
    Compensated,
    /// A machine with perfect geometry and no lost motion: the error of the servo alone.
    ServoOnly,
    /// Everything that the plugin has: the volumetric model where the chain permits it, friction, lag and acceleration
    /// feed-forward, contour feedback and cross-talk as far as the machine states them.
    Full,
    /// The plugin enabled, exactly as the machine's settings say: what a controller with its tables does.
    Configured,
}

/// Which parts of the plugin a machine is driven with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parts {
    Geometry,
    All,
    Configured,
}

impl Kind {
    /// Those that every machine is simulated as, in the order of a report.
    pub const BASIC: [Kind; 3] = [Kind::Uncompensated, Kind::Compensated, Kind::ServoOnly];
    /// The same and [`Kind::Full`], for a machine that has dynamic parts.
    pub const ALL: [Kind; 4] = [Kind::Uncompensated, Kind::Compensated, Kind::ServoOnly, Kind::Full];

    /// [`Kind::ALL`] for a machine with friction, dynamic correction, contour feedback or cross-talk, else
    /// [`Kind::BASIC`].
    pub fn of(machine: &MachineSettings) -> &'static [Kind] {
        if is_dynamic(machine) { &Kind::ALL } else { &Kind::BASIC }
    }

    /// The machines of these names, in the order of a report.
    ///
    /// # Errors
    /// A name that is none, or no name.
    pub fn named(names: &[impl AsRef<str>]) -> Result<Vec<Kind>> {
        let all = || Kind::ALL.into_iter().chain([Kind::Configured]);
        let known = |name: &str| all().any(|kind| kind.name() == name);
        if let Some(unknown) = names.iter().map(AsRef::as_ref).find(|name| !known(name)) {
            let needed = format!("some of {}", all().map(Kind::name).collect::<Vec<_>>().join(", "));
            return Err(SimError::unsuited("kinds", format!("\"{unknown}\""), needed));
        }
        let kinds: Vec<Kind> = all().filter(|kind| names.iter().any(|name| kind.name() == name.as_ref())).collect();
        if kinds.is_empty() {
            return Err(SimError::unsuited("kinds", "none", "at least one"));
        }
        Ok(kinds)
    }

    /// As documents call it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Uncompensated => "uncompensated",
            Kind::Compensated => "compensated",
            Kind::ServoOnly => "servo_only",
            Kind::Full => "full",
            Kind::Configured => "configured",
        }
    }

    /// Whether the plugin acts on the machine.
    pub fn enables_the_plugin(self) -> bool {
        matches!(self, Kind::Compensated | Kind::Full | Kind::Configured)
    }

    /// A learned correction belongs to all that the plugin has.
    pub(super) fn takes_what_was_learned(self) -> bool {
        matches!(self, Kind::Full | Kind::Configured)
    }

    pub(super) fn parts(self) -> Parts {
        match self {
            Kind::Full => Parts::All,
            Kind::Configured => Parts::Configured,
            Kind::Uncompensated | Kind::Compensated | Kind::ServoOnly => Parts::Geometry,
        }
    }
}

impl Parts {
    /// The machine whose tables the plugin is built from; that of the plant is the machine as it stands.
    ///
    /// # Errors
    /// Tables that do not compile with the machine's own model.
    pub(super) fn of(self, machine: &Machine, period_s: f64) -> Result<Cow<'_, Machine>> {
        match self {
            Parts::Geometry if is_dynamic(&machine.settings) => Ok(Cow::Owned(without_dynamics(machine))),
            Parts::All => {
                let mut all = match machine.settings.compensation.model {
                    ErrorModel::Nine => volumetric(machine)?,
                    _ => Cow::Borrowed(machine),
                };
                if feedback_refused(&machine.settings, period_s).is_some() {
                    all.to_mut().settings.contour.feedback = None;
                }
                Ok(all)
            }
            _ => Ok(Cow::Borrowed(machine)),
        }
    }
}

/// Why [`Kind::Full`] does without the machine's contour feedback at a servo period: its gains leave too little margin
/// there. A controller refuses them; a run at another rate than the machine's is to show the rest all the same.
pub fn feedback_refused(machine: &MachineSettings, period_s: f64) -> Option<ConfigError> {
    check::feedback(machine, period_s).err()
}

/// Whether anything acts on the servo itself; figures of a drive alone do not.
fn is_dynamic(machine: &MachineSettings) -> bool {
    let acts = machine.axes.iter().any(|axis| axis.servo.friction.is_some() || axis.servo.dynamic.is_some());
    acts || machine.contour.feedback.is_some() || !machine.crosstalk.is_empty()
}

fn without_dynamics(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    for axis in &mut machine.settings.axes {
        (axis.servo.friction, axis.servo.dynamic) = (None, None);
    }
    machine.settings.contour.feedback = None;
    machine.settings.crosstalk.clear();
    machine
}

/// The volumetric model asks more of a machine than nine terms do: where it is refused, its own model stays.
fn volumetric(machine: &Machine) -> Result<Cow<'_, Machine>> {
    let mut wanted = machine.clone();
    wanted.settings.compensation.model = ErrorModel::Volumetric;
    if trueaxis_tables::compile(&wanted).is_ok() {
        return Ok(Cow::Owned(wanted));
    }
    trueaxis_tables::compile(machine)?;
    Ok(Cow::Borrowed(machine))
}
