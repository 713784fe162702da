//! The text of a task.

use super::instrument::Touching;

/// The task of several artefacts: `machine` is its folder from where the task will be.
pub(super) fn task_text(machine: &str, probe: &Touching, scatter_mm: f64, artefacts: &[String]) -> String {
    let machine = toml::Value::from(machine);
    let (dialect, tip) = (&probe.dialect, probe.tip_radius_mm);
    // An axis that repeats badly scatters every touch.
    let um = (1e6 * probe.repeatability_mm.hypot(scatter_mm)).round() / 1e3;
    let known = 1e3 * probe.tip_uncertainty_mm;
    format!(
        "machine = {machine}\ndialect = \"{dialect}\"\ncompensated = true\n\n[probe]\ntip_radius_mm = {tip}\n\
         tip_uncertainty_um = {known}\nrepeatability_um = {um}\n{}",
        artefacts.concat()
    )
}
