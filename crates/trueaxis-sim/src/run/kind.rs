//! The machines of a run, and the plugin that drives each.

use crate::error::{Result, SimError};
use std::borrow::Cow;
use trueaxis::ConfigError;
use trueaxis::check::{self, Spread};
use trueaxis::machine::{ErrorModel, MachineSettings};
use trueaxis_tables::Machine;

/// A machine of a run and how it is driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The actual machine, the plugin disabled.
    Uncompensated,
    /// The plugin enabled, its dynamic parts off: geometry alone.
    Compensated,
    /// A machine without geometric errors and lost motion: the error of the servo alone.
    ServoOnly,
    /// All parts of the plugin: the volumetric model if the chain permits it, friction, lag and acceleration feed-forward,
    /// contour feedback and cross-talk as far as the machine states them.
    Full,
    /// The plugin enabled, exactly as the machine's settings say: the behaviour of a controller with its tables.
    Configured,
}

/// Parts of the plugin that drive a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parts {
    Geometry,
    All,
    Configured,
}

impl Kind {
    /// The kinds simulated for every machine, in the order of a report.
    pub const BASIC: [Kind; 3] = [Kind::Uncompensated, Kind::Compensated, Kind::ServoOnly];
    /// [`Kind::BASIC`] and [`Kind::Full`], for a machine that has dynamic parts.
    pub const ALL: [Kind; 4] = [Kind::Uncompensated, Kind::Compensated, Kind::ServoOnly, Kind::Full];

    /// [`Kind::ALL`] for a machine with friction, dynamic correction, contour feedback or cross-talk, otherwise
    /// [`Kind::BASIC`].
    pub fn of(machine: &MachineSettings) -> &'static [Kind] {
        if is_dynamic(machine) { &Kind::ALL } else { &Kind::BASIC }
    }

    /// The kinds with these names, in the order of a report.
    ///
    /// # Errors
    /// An unknown name, or no name.
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

    /// Name in documents.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Uncompensated => "uncompensated",
            Kind::Compensated => "compensated",
            Kind::ServoOnly => "servo_only",
            Kind::Full => "full",
            Kind::Configured => "configured",
        }
    }

    /// Name for readers, the same in every output.
    pub fn words(self) -> &'static str {
        match self {
            Kind::Uncompensated => "uncorrected",
            Kind::Compensated => "corrected",
            Kind::ServoOnly => "servo alone",
            Kind::Full => "everything on",
            Kind::Configured => "as configured",
        }
    }

    /// Whether the plugin acts on the machine.
    pub fn enables_the_plugin(self) -> bool {
        matches!(self, Kind::Compensated | Kind::Full | Kind::Configured)
    }

    /// Whether the plugin uses a learned correction: with all its parts, or as configured.
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
    /// The machine whose tables the plugin is built from; the plant always has the machine unchanged.
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
            Parts::Configured => match feedback_refused(&machine.settings, period_s) {
                Some(error) => Err(error.into()),
                None => Ok(Cow::Borrowed(machine)),
            },
            _ => Ok(Cow::Borrowed(machine)),
        }
    }
}

/// Reason why [`Kind::Full`] omits the machine's contour feedback at a servo period: its gains leave too little margin there.
/// They are refused where a machine is compiled, but a run at a rate other than the machine's should still show the rest.
pub fn feedback_refused(machine: &MachineSettings, period_s: f64) -> Option<ConfigError> {
    check::feedback_within(machine, period_s, |_| Spread::LEAST).err()
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

/// The volumetric model requires more of a machine than the nine-term model does: if it is refused, the machine's own model is
/// kept.
fn volumetric(machine: &Machine) -> Result<Cow<'_, Machine>> {
    let mut wanted = machine.clone();
    wanted.settings.compensation.model = ErrorModel::Volumetric;
    if trueaxis_tables::compile(&wanted).is_ok() {
        return Ok(Cow::Owned(wanted));
    }
    trueaxis_tables::compile(machine)?;
    Ok(Cow::Borrowed(machine))
}
