//! The program `trueaxis`.

mod ballbar;
mod calibrate;
mod circle;
mod collapse;
mod command_line;
mod compensate_models;
mod correct;
#[cfg(target_os = "linux")]
mod crash;
mod data_as_given;
#[cfg(unix)]
mod desk;
#[cfg(unix)]
mod documentation;
mod evaluate;
mod explain;
mod files;
mod friction;
mod helicoid;
mod identify;
mod keep;
mod kinematics;
mod learn;
mod one_at_a_time;
mod periodic;
mod plate;
mod predict;
mod predict_servo;
mod ranges;
mod roundness;
mod shop_artefacts;
mod simulate;
mod telemetry;
mod thermal;
mod uncertainty;
