//! The plugin's data about a machine: servo loops, thermal growth, kinematics. All of it is exchanged at once.

use super::kind::{Kind, Parts};
use crate::error::{Result, SimError};
use crate::scenario::Scenario;
use crate::servo::Owned;
use trueaxis::compensation::ThermalLine;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::AxisOrder;
use trueaxis_tables::Machine;

/// Servo loops of a machine, one for each set of parts that drives a machine of the run, and the data that belongs to them.
pub(super) struct Plugin<S, const N: usize> {
    loops: Vec<(Parts, S)>,
    about: About<N>,
}

/// Data besides the servo loops.
pub(super) struct About<const N: usize> {
    /// Growth of each axis at the temperature of the scenario.
    pub(super) thermal: [ThermalLine<f64>; N],
    /// For programs with rotary axes.
    pub(super) kinematics: Option<Kinematics<f64>>,
}

impl<S: Owned<N>, const N: usize> Plugin<S, N> {
    /// Builds the plugin of the scenario's own machine.
    pub(super) fn of(scenario: &Scenario, kinds: &[Kind]) -> Result<Self> {
        Plugin::build(scenario, &scenario.machine, kinds)
    }

    /// Builds the plugin of other tables, for the machines of the run whose plugin is enabled.
    ///
    /// # Errors
    /// The tables are of another machine, or do not build for this period.
    pub(super) fn exchanged(scenario: &Scenario, name: &str, machine: &Machine, kinds: &[Kind]) -> Result<Self> {
        is_same(scenario, name, machine)?;
        let driven: Vec<Kind> = kinds.iter().copied().filter(|kind| kind.enables_the_plugin()).collect();
        Plugin::build(scenario, machine, &driven)
            .map_err(|error| SimError::Exchange { name: name.into(), error: Box::new(error) })
    }

    fn build(scenario: &Scenario, machine: &Machine, kinds: &[Kind]) -> Result<Self> {
        let mut loops: Vec<(Parts, S)> = Vec::new();
        for parts in kinds.iter().map(|kind| kind.parts()) {
            if loops.iter().all(|(built, _)| *built != parts) {
                let machine = parts.of(machine, scenario.period_s())?;
                loops.push((parts, S::build(&machine, scenario.period_ns())?));
            }
        }
        let warmer = scenario.machine.settings.reference_temperature_c - machine.settings.reference_temperature_c;
        let kelvin = scenario.kelvin + warmer;
        let mut thermal = [ThermalLine::default(); N];
        for (line, axis) in thermal.iter_mut().zip(AxisOrder::<N>::with_spare_slots(&machine.settings)?.axes()) {
            if let Some(settings) = machine.settings.axis(axis) {
                *line = ThermalLine::for_axis(&settings.thermal, kelvin).ok_or_else(|| {
                    let what = format!("thermal growth of axis {}", axis.letter());
                    SimError::unsuited(what, format!("{kelvin} K"), "a growth that the step can represent")
                })?;
            }
        }
        Ok(Plugin { loops, about: About { thermal, kinematics: scenario.kinematics_of(machine)? } })
    }

    /// The loop that drives a machine; `None` if the plugin was not built for it.
    pub(super) fn servo(&self, kind: Kind) -> Option<&S> {
        self.loops.iter().find(|(parts, _)| *parts == kind.parts()).map(|(_, servo)| servo)
    }

    pub(super) fn about(&self) -> &About<N> {
        &self.about
    }
}

/// Refuses tables that are not of the scenario's machine.
fn is_same(scenario: &Scenario, name: &str, machine: &Machine) -> Result<()> {
    for ((of, found), (_, needed)) in identity(machine).into_iter().zip(identity(&scenario.machine)) {
        if found != needed {
            let what = format!("exchange:{name}");
            return Err(SimError::unsuited(what, format!("{of} {found}"), format!("{needed}, those of the machine")));
        }
    }
    Ok(())
}

/// Properties that all tables of one machine share: state and path of a run depend on them.
fn identity(machine: &Machine) -> [(&'static str, String); 3] {
    let settings = &machine.settings;
    let mut axes: Vec<_> = settings.step_axes().collect();
    axes.sort_unstable();
    [
        ("axes", axes.into_iter().map(|axis| axis.letter()).collect()),
        ("structural code", settings.chain.as_str().to_owned()),
        ("name", settings.name.as_str().to_owned()),
    ]
}
