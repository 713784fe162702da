//! The untrusted inputs, one file each.

pub mod ballbar;
pub mod c_calls;
pub mod circle;
pub mod convert;
pub mod desk;
pub mod friction;
pub mod gcode;
pub mod identify;
pub mod import;
pub mod instruments;
pub mod keep;
pub mod learn;
pub mod machine;
pub mod path;
pub mod positions;
pub mod probe_log;
pub mod probes;
pub mod recording;
pub mod scenario;
pub mod tcomp;
pub mod telemetry;
pub mod thermal;
pub mod tlearn;
pub mod ttherm;
pub mod warming;

use crate::Target;

/// Passes the list of all targets to a macro, in the order of the report, as `name: constant`, for code needed once per
/// target.
#[macro_export]
macro_rules! for_each_target {
    ($make:ident) => {
        $make! {
            tcomp: $crate::targets::tcomp::TARGET,
            machine: $crate::targets::machine::TARGET,
            import_linuxcnc_0: $crate::targets::import::LINUXCNC_0,
            import_linuxcnc_1: $crate::targets::import::LINUXCNC_1,
            import_siemens: $crate::targets::import::SIEMENS,
            import_isg: $crate::targets::import::ISG,
            import_iso230_2: $crate::targets::import::ISO230_2,
            import_columns: $crate::targets::import::COLUMNS,
            import_rtl: $crate::targets::import::RTL,
            import_heightmap: $crate::targets::import::HEIGHTMAP,
            import_marlin: $crate::targets::import::MARLIN,
            import_bed_mesh: $crate::targets::import::BED_MESH,
            import_grid: $crate::targets::import::GRID,
            gcode: $crate::targets::gcode::TARGET,
            path: $crate::targets::path::TARGET,
            convert: $crate::targets::convert::TARGET,
            ballbar: $crate::targets::ballbar::TARGET,
            c_calls: $crate::targets::c_calls::TARGET,
            circle: $crate::targets::circle::TARGET,
            desk: $crate::targets::desk::TARGET,
            friction: $crate::targets::friction::TARGET,
            identify: $crate::targets::identify::TARGET,
            instruments: $crate::targets::instruments::TARGET,
            keep: $crate::targets::keep::TARGET,
            learn: $crate::targets::learn::TARGET,
            positions: $crate::targets::positions::TARGET,
            probe_log: $crate::targets::probe_log::TARGET,
            probes: $crate::targets::probes::TARGET,
            recording: $crate::targets::recording::TARGET,
            scenario: $crate::targets::scenario::TARGET,
            telemetry: $crate::targets::telemetry::TARGET,
            thermal: $crate::targets::thermal::TARGET,
            tlearn: $crate::targets::tlearn::TARGET,
            ttherm: $crate::targets::ttherm::TARGET,
            warming: $crate::targets::warming::TARGET,
        }
    };
}

macro_rules! list {
    ($($name:ident: $target:path,)*) => {
        /// All targets.
        pub const TARGETS: &[&Target] = &[$(&$target),*];
    };
}

for_each_target!(list);

/// The target with this name.
pub fn named(name: &str) -> Option<&'static Target> {
    TARGETS.iter().copied().find(|target| target.name == name)
}
