//! Transformations between axis positions and the tool, against truth from outside.

use glam::{DAffine3, DVec3};
use trueaxis::machine::{AXES, Axis, AxisSettings, MachineSettings};

mod forward;
mod inverse;
mod published;

/// A machine of the given structural code with the stated defaults.
fn machine(chain: &str) -> MachineSettings {
    let links = trueaxis::machine::links(chain).unwrap();
    let mut axes = heapless::Vec::new();
    for axis in Axis::ALL {
        if let Some(link) = links.iter().find(|link| link.axis == axis) {
            axes.push(AxisSettings::with_defaults(axis, link.carries_workpiece)).unwrap();
        }
    }
    MachineSettings {
        name: heapless::String::try_from("test").unwrap(),
        chain: heapless::String::try_from(chain).unwrap(),
        tool_mm: [0.0; 3],
        reference_temperature_c: 20.0,
        location: Default::default(),
        faults: Default::default(),
        contour: Default::default(),
        compensation: Default::default(),
        kinematics: Default::default(),
        axes,
        roundness: None,
    }
}

fn of(machine: &mut MachineSettings, axis: Axis) -> &mut AxisSettings {
    machine.axes.iter_mut().find(|a| a.axis == axis).unwrap()
}

/// Splitmix64.
struct Random(u64);

impl Random {
    /// Uniform in −1 … 1.
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Offsets, senses of the rotary axes, tool and tool axis at random; linear travel ±1e6 mm.
    fn disturb(&mut self, machine: &mut MachineSettings) {
        for axis in &mut machine.axes {
            axis.offset_mm = [(); 3].map(|()| 80.0 * self.signed());
            if axis.axis.is_rotary() && self.signed() < 0.0 {
                axis.direction = -axis.direction;
            }
        }
        machine.tool_mm = [(); 3].map(|()| 150.0 * self.signed());
    }

    /// Positions of ±500 mm and ±`turn` degrees.
    fn pose(&mut self, turn: f64) -> [f64; AXES] {
        std::array::from_fn(|i| self.signed() * if i < 3 { 500.0 } else { turn })
    }
}

/// Product of homogeneous transforms along the code, independent of the code under test: from the bed outwards on
/// either side offset · motion, the tool point then taken back into the workpiece's frame.
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
