//! Machines drawn from a class.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use trueaxis::machine::{
    Axis, AxisSettings, CompensationSettings, ContourSettings, ErrorModel, FaultSettings, KinematicsSettings,
    LocationErrors, MachineSettings, Row,
};
use trueaxis_tables::{Machine, Table};

/// Size of the errors of a random machine: standard deviations, except for the backlash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Class {
    /// Squareness, rad.
    pub squareness: f64,
    /// Scale.
    pub scale: f64,
    /// Largest backlash, mm; drawn uniformly from 0.
    pub backlash_mm: f64,
    /// Bow of positioning and of straightness: height of a parabola over the travel, mm.
    pub bow_mm: f64,
    /// Cubic part of both, at the ends of the travel, mm.
    pub cubic_mm: f64,
    /// Wave of 1.5 to 4 periods over the travel in each, mm.
    pub wave_mm: f64,
    /// Angular errors over the travel: height of the bow, rad.
    pub angle: f64,
    /// Location errors of the centre lines of rotary axes, mm, and their tilts, rad.
    pub centre: [f64; 2],
}

impl Class {
    /// A small mill in use, without angular errors: location, scale, backlash, straightness.
    pub const MILL: Class = Class {
        squareness: 40e-6,
        scale: 40e-6,
        backlash_mm: 0.008,
        bow_mm: 0.003,
        cubic_mm: 0.0012,
        wave_mm: 0.0005,
        angle: 0.0,
        centre: [0.02, 60e-6],
    };
}

/// Travels of X, Y, Z, mm.
pub(super) const TRAVELS: [[f64; 2]; 3] = [[0.0, 500.0], [0.0, 400.0], [-300.0, 0.0]];
/// Lines of a true table.
const LINES: usize = 100;
const CHAINS: [&str; 4] = ["w X' Y' b Z t", "w Y' b X Z t", "w b X Y Z t", "w X' b Y Z t"];

struct Dice(ChaCha8Rng);

impl Dice {
    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A three-axis machine of 500 × 400 × 300 mm with random structure and errors.
pub fn random_machine(seed: u64, class: &Class) -> Machine {
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(seed));
    let chain = CHAINS[(dice.0.next_u64() % CHAINS.len() as u64) as usize];
    machine(&mut dice, "random mill", chain, class)
}

/// [`random_machine`] with trunnion A and table C on the workpiece side; the rotary axes have location errors.
pub fn random_five_axis(seed: u64, class: &Class) -> Machine {
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(seed));
    let mut machine = machine(&mut dice, "random five axes", "w C' A' Y' b X Z t", class);
    let [shift, tilt] = class.centre;
    let location = &mut machine.settings.location;
    for (axis, free) in [(0, [1, 2, 4, 5]), (2, [0, 1, 3, 4])] {
        for component in free {
            location.rotary[axis][component] = dice.normal() * if component < 3 { shift } else { tilt };
        }
    }
    machine
}

fn machine(dice: &mut Dice, name: &str, chain: &str, class: &Class) -> Machine {
    let mut settings = MachineSettings {
        roundness: None,
        crosstalk: Default::default(),
        periodic: Default::default(),
        name: name.parse().unwrap_or_default(),
        chain: chain.parse().unwrap_or_default(),
        tool_mm: [0.0; 3],
        reference_temperature_c: 20.0,
        location: LocationErrors {
            a0z: class.squareness * dice.normal(),
            b0z: class.squareness * dice.normal(),
            c0y: class.squareness * dice.normal(),
            ..LocationErrors::default()
        },
        faults: FaultSettings::default(),
        contour: ContourSettings::default(),
        compensation: CompensationSettings { model: ErrorModel::Volumetric, ..CompensationSettings::default() },
        kinematics: KinematicsSettings::default(),
        axes: Default::default(),
    };
    let mut tables = Vec::new();
    let present = |axis: Axis| chain.contains(axis.letter());
    for axis in Axis::ALL.into_iter().filter(|axis| present(*axis)) {
        let carries = chain.contains(&format!("{}'", axis.letter()));
        let mut own = AxisSettings::with_defaults(axis, carries);
        own.limits.magnitude = 1.0;
        if axis.is_rotary() {
            own.travel = [-120.0, 360.0];
            if axis == Axis::A {
                // The trunnion's axis is in the middle of the table, 60 mm above it.
                own.offset_mm = [250.0, 200.0, -250.0];
            }
            own.joint = [own.travel[0] - 1.0, own.travel[1] + 1.0];
            tables.push(None);
        } else {
            own.travel = TRAVELS[axis.index()];
            own.backlash = class.backlash_mm * dice.unit();
            own.joint = [own.travel[0] - 1.0, own.travel[1] + 1.0];
            tables.push(Some(table(dice, axis, class)));
        }
        let _ = settings.axes.push(own);
    }
    Machine { settings, tables, grids: Vec::new() }
}

fn table(dice: &mut Dice, axis: Axis, class: &Class) -> Table {
    let [low, high] = TRAVELS[axis.index()];
    let shapes: [[f64; 5]; 6] = std::array::from_fn(|component| {
        // Angular errors have the shape of the mill's straightness.
        let [bow, cubic, wave] = match component {
            0..3 => [class.bow_mm, class.cubic_mm, class.wave_mm],
            _ => [1.0, 0.4, 1.0 / 6.0].map(|share| share * class.angle),
        };
        [
            bow * dice.normal(),
            cubic * dice.normal(),
            wave * dice.normal(),
            1.5 + 2.5 * dice.unit(),
            core::f64::consts::TAU * dice.unit(),
        ]
    });
    let scale = class.scale * dice.normal();
    let at = |position: f64| {
        let share = (position - low) / (high - low);
        let t = 2.0 * share - 1.0;
        let mut errors = shapes.map(|[bow, cubic, wave, periods, phase]| {
            bow * (1.0 - t * t)
                + cubic * t * (t * t - 1.0) * 2.6
                + wave * libm::sin(core::f64::consts::TAU * periods * share + phase)
        });
        errors[axis.index()] += scale * position;
        errors
    };
    // The errors vanish at the machine's zero, from which rotary axes are located.
    let zero = at(0.0);
    let rows = (0..=LINES)
        .map(|i| {
            let position = low + f64::from(i as u32) / LINES as f64 * (high - low);
            let errors = at(position);
            let errors = std::array::from_fn(|k| errors[k] - zero[k]);
            Row { position, forward: errors, reverse: errors }
        })
        .collect();
    Table {
        given: [true, true, true, class.angle != 0.0, class.angle != 0.0, class.angle != 0.0],
        bidirectional: false,
        rows,
    }
}
