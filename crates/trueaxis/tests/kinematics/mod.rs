//! Transformations between axis positions and the tool, compared with independent references.

use glam::{DAffine3, DVec3};
use trueaxis::machine::{AXES, Axis, AxisSettings, MachineSettings};
use trueaxis_testing::machine::Machine;
use trueaxis_testing::noise::Noise;

mod edges;
mod forward;
mod inverse;
mod published;
mod singular;

/// A machine of the given structural code with the stated defaults.
fn machine(chain: &str) -> MachineSettings {
    Machine::new(chain).settings()
}

fn of(machine: &mut MachineSettings, axis: Axis) -> &mut AxisSettings {
    machine.axes.iter_mut().find(|a| a.axis == axis).unwrap()
}

/// Sets random offsets, senses of the rotary axes, tool and tool axis; linear travel ±1e6 mm.
fn disturb(noise: &mut Noise, machine: &mut MachineSettings) {
    for axis in &mut machine.axes {
        axis.offset_mm = noise.vector(80.0);
        if axis.axis.is_rotary() && noise.signed() < 0.0 {
            axis.direction = -axis.direction;
        }
    }
    machine.tool_mm = noise.vector(150.0);
}

/// A random pose within ±500 mm and ±`turn` degrees.
fn random_pose(noise: &mut Noise, turn: f64) -> [f64; AXES] {
    std::array::from_fn(|i| noise.signed() * if i < 3 { 500.0 } else { turn })
}

/// Product of homogeneous transforms along the code, independent of the code under test: from the bed outwards offset ·
/// motion on either side, then the tool point transformed back into the workpiece's frame.
fn by_transforms(machine: &MachineSettings, q: &[f64; AXES], tool: [f64; 3]) -> (DVec3, DVec3) {
    let code: Vec<char> = machine.chain.chars().filter(|c| c.is_ascii_uppercase()).collect();
    let count = machine.chain.split('b').next().unwrap().chars().filter(|c| c.is_ascii_uppercase()).count();
    let carriage = |letter: char, sign: f64| {
        let axis = Axis::from_letter(letter).unwrap();
        let settings = machine.axis(axis).unwrap();
        let q = q[axis.index()];
        let along = [DVec3::X, DVec3::Y, DVec3::Z][axis.index() % 3];
        let motion = if axis.is_rotary() {
            DAffine3::from_axis_angle(along, (f64::from(settings.direction) * q).to_radians())
        } else {
            DAffine3::from_translation(along * (sign * q))
        };
        DAffine3::from_translation(DVec3::from_array(settings.offset_mm)) * motion
    };
    let workpiece = code[..count].iter().rev().fold(DAffine3::IDENTITY, |sum, &c| sum * carriage(c, -1.0));
    let head = code[count..].iter().fold(DAffine3::IDENTITY, |sum, &c| sum * carriage(c, 1.0));
    let relative = workpiece.inverse() * head;
    let axis = DVec3::from_array(machine.kinematics.tool_axis).normalize();
    (relative.transform_point3(DVec3::from_array(tool)), relative.matrix3 * axis)
}

fn apart(a: DVec3, b: DVec3) -> f64 {
    (a - b).length()
}
