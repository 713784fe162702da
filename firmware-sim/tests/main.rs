//! The program `firmware-sim`.

mod artefacts;
mod calibration;
mod command_line;
#[cfg(target_os = "linux")]
mod crash;
#[cfg(unix)]
mod documentation;
mod events;
mod files;
mod five_axis;
mod friction;
mod grinding;
mod growth;
mod keeping;
mod learning;
mod linuxcnc;
mod memory;
mod posts;
mod replay;
mod report;
mod rtcp;
mod settings;
mod shop_artefacts;
mod soak;
#[cfg(target_os = "linux")]
mod stall;
