//! Machines of a leg: drawn at random within the permitted range of a configuration, at its extremes, or a sample.

use super::combination::{Combination, Measured};
use super::dice::Dice;
use super::drawn::Drawn;
use super::{sample, servo};
use trueaxis::Axis;
use trueaxis::machine::{
    AxisSettings, ErrorModel, FaultSettings, GridAxis, GridHeader, Interpolation, Limits, Lookup, MachineSettings, Row,
};
use trueaxis_testing::machine::{Machine, rows_both_ways};

const CHAINS: [&[&str]; 4] = [
    &["w b X Y Z t", "w X' b Y Z t", "w Y' X' b Z t", "w Z' b X Y t"],
    &["w C' b X Y Z t", "w X' b Y Z A t", "w b X Y Z B t", "w B' X' b Y Z t"],
    &["w C' A' b X Y Z t", "w C' A' X' b Y Z t", "w X' b Y Z C A t", "w X' Y' b Z C A t", "w C' X' b Y Z B t"],
    &["w C' A' b X Y Z B t", "w C' b X Y Z B A t", "w C' B' X' b Y Z A t"],
];

/// Servo periods, ns.
const PERIODS: [u32; 6] = [50_000, 100_000, 250_000, 500_000, 1_000_000, 2_000_000];

/// Draws the period that the machines of a leg share.
pub(super) fn period(dice: &mut Dice) -> u32 {
    dice.one_of(&PERIODS)
}

/// Draws a machine, which is simpler the larger `plain`, the number of refused draws. One that is exchanged for another has
/// the same axes and usually the same travel.
pub(super) fn draw(
    dice: &mut Dice,
    of: &Combination,
    period_ns: u32,
    plain: u32,
    like: Option<&MachineSettings>,
) -> Drawn {
    if like.is_none()
        && plain < 3
        && dice.one_in(5)
        && let Some(sample) = sample::with(dice, of)
    {
        return sample;
    }
    let chain = like.map_or_else(|| dice.one_of(CHAINS[of.axes - 3]), |like| &like.chain);
    let mut settings = Machine::new(chain).settings();
    settings.name = "walk".parse().expect("a short name");
    settings.compensation.model = of.model;
    settings.compensation.orientation =
        of.model == ErrorModel::Volumetric && of.axes == 5 && plain < 8 && dice.one_in(2);
    let tool = of.axes > 3 || of.measured == Measured::ToolPath;
    settings.tool_mm = [30.0, 30.0, if tool { 150.0 } else { 30.0 }].map(|size| size * dice.signed());
    let squareness = 60e-6;
    let location = &mut settings.location;
    [location.a0z, location.b0z, location.c0y] = [(); 3].map(|()| squareness * dice.signed());
    for twist in &mut location.rotary {
        *twist = std::array::from_fn(|k| if k < 3 { 0.01 } else { 30e-6 } * dice.signed());
    }
    settings.faults = faults(dice);
    settings.contour.max_lag_mm = dice.factor(0.2, 5.0);
    let period_s = f64::from(period_ns) * 1e-9;
    for axis in &mut settings.axes {
        *axis = self::axis(dice, axis.axis, *axis, period_s, plain);
        if let Some(like) = like.and_then(|like| like.axis(axis.axis)).filter(|_| !dice.one_in(8)) {
            let room = if dice.one_in(3) { 0.0 } else { axis.limits.magnitude };
            (axis.travel, axis.max_feed_per_s) = (like.travel, like.max_feed_per_s);
            axis.joint = [axis.travel[0] - room, axis.travel[1] + room];
        }
    }
    if plain < 12 && dice.one_in(2) {
        servo::configure(dice, &mut settings);
    }
    let tables = settings.axes.iter().map(|axis| table(dice, axis, plain)).collect();
    let grids = if plain < 14 && dice.one_in(2) { grids(dice, &settings, plain) } else { Vec::new() };
    Drawn { settings, tables, grids }
}

/// One to three grids over two or three axes, within the travel or beyond it, with free or equal spacing; some fade.
fn grids(dice: &mut Dice, machine: &MachineSettings, plain: u32) -> Vec<(GridHeader, Vec<u8>)> {
    const OVER: [[bool; 3]; 4] = [[true, true, false], [true, true, true], [false, true, true], [true, false, true]];
    let size = 0.02 * f64::from(plain / 2 + 1).recip();
    let grid = |dice: &mut Dice| {
        let over = dice.one_of(&OVER);
        let turns = machine.compensation.model == ErrorModel::Volumetric && dice.one_in(3);
        let fades = over == OVER[0] && !turns && dice.one_in(2);
        let mut header = GridHeader { given: if turns { 0b111111 } else { 0b111 }, ..GridHeader::default() };
        header.scales = std::array::from_fn(|k| match k {
            0..3 => size / 32767.0,
            _ if turns => 1e-3 * size / 32767.0,
            _ => 0.0,
        });
        let mut positions = Vec::new();
        for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            let travel = machine.axis(axis).map_or([-100.0, 100.0], |axis| axis.travel);
            if !over[k] {
                header.measured_at_mm[k] = 20.0 * dice.signed();
                continue;
            }
            let ends = travel.map(|end| end * dice.range(0.6, 1.2));
            let (nodes, free) = (2 + dice.below(6), dice.one_in(2));
            header.axes[k] = GridAxis { nodes: nodes as u16, ends, free };
            let pitch = (ends[1] - ends[0]) / (nodes - 1) as f64;
            positions.extend((0..nodes).filter(|_| free).map(|node| match node {
                0 => ends[0],
                _ if node + 1 == nodes => ends[1],
                _ => ends[0] + pitch * (node as f64 + 0.4 * dice.signed()),
            }));
        }
        header.fade = fades.then(|| {
            let [low, high] = machine.axis(Axis::Z).map_or([-100.0, 100.0], |axis| axis.travel);
            [low + 0.4 * (high - low), low + 0.9 * (high - low)]
        });
        let nodes = (0..header.count().unwrap_or(0) * header.columns()).map(|_| (32767.0 * dice.signed()) as i16);
        let nodes: Vec<u8> = nodes.flat_map(i16::to_le_bytes).collect();
        let bytes = positions.into_iter().flat_map(f64::to_le_bytes).chain(nodes).collect();
        (header, bytes)
    };
    let count = 1 + dice.below(3);
    (0..count).map(|_| grid(dice)).collect()
}

fn faults(dice: &mut Dice) -> FaultSettings {
    FaultSettings {
        resume: [dice.factor(0.005, 0.3), dice.factor(0.005, 0.3)],
        command_jump_factor: dice.range(1.0, 3.0),
        feedback_jump: [dice.factor(0.005, 0.1), dice.factor(0.005, 0.1)],
        stuck: [dice.factor(0.02, 0.5), dice.factor(0.02, 0.5)],
    }
}

/// Limits of a correction: typical of machines, or as extreme as the scalars permit.
fn limits(dice: &mut Dice, rotary: bool, period_s: f64) -> Limits {
    let extreme = dice.one_in(12);
    let magnitude = if extreme { dice.factor(2e-6, 5.0) } else { dice.factor(0.002, 0.3) };
    let slope_per_s = if extreme { dice.factor(1e-3, 1e3) } else { dice.factor(0.5, 50.0) };
    // Above the resolution of single precision.
    let least = 4e-7 * magnitude / (period_s * period_s);
    let acceleration_per_s2 =
        if extreme { dice.factor(least.clamp(1e-3, 9e5), 1e6) } else { dice.factor(20.0, 20_000.0).max(least) };
    let magnitude = if rotary { magnitude.min(1.0) } else { magnitude };
    Limits { magnitude, slope_per_s, acceleration_per_s2: acceleration_per_s2.min(1e6) }
}

fn axis(dice: &mut Dice, axis: Axis, known: AxisSettings, period_s: f64, plain: u32) -> AxisSettings {
    let rotary = axis.is_rotary();
    let most = match rotary {
        true => dice.one_of(&[60.0, 180.0, 2000.0]),
        false => dice.factor(30.0, 900.0),
    };
    let travel = [-most * dice.range(0.3, 1.0), most * dice.range(0.3, 1.0)];
    let limits = limits(dice, rotary, period_s);
    // Tight: an outward correction at the end of the travel has no room.
    let room = if dice.one_in(3) { 0.0 } else { limits.magnitude };
    let hysteresis = dice.factor(0.1e-3, 3e-3) * f64::from(1 + plain);
    let lookup = |dice: &mut Dice| if plain < 10 && dice.one_in(6) { Lookup::Feedback } else { Lookup::Command };
    AxisSettings {
        interpolation: if dice.one_in(2) { Interpolation::Cubic } else { Interpolation::Linear },
        lookup: lookup(dice),
        cross_lookup: lookup(dice),
        travel,
        joint: [travel[0] - room, travel[1] + room],
        offset_mm: [100.0 * dice.signed(), 100.0 * dice.signed(), 100.0 * dice.signed()],
        measured_at_mm: if dice.one_in(3) { [20.0 * dice.signed(), 10.0, -10.0] } else { [0.0; 3] },
        max_feed_per_s: dice.factor(20.0, 800.0),
        backlash: if plain < 6 && dice.one_in(3) { dice.range(0.0, 0.01) } else { 0.0 },
        hysteresis: hysteresis.min(0.09),
        limits,
        ..known
    }
}

/// A sum of two waves over the travel or a part of it, periodic for a full turn.
fn table(dice: &mut Dice, axis: &AxisSettings, plain: u32) -> Option<Vec<Row>> {
    if dice.one_in(6) {
        return None;
    }
    let [low, high] = axis.travel;
    let turn = axis.axis.is_rotary() && high - low > 360.0;
    let (start, end) = if turn { (0.0, 360.0) } else { (low * dice.range(0.6, 1.2), high * dice.range(0.6, 1.2)) };
    let count = 3 + dice.below(40);
    let free = dice.one_in(2);
    let wave = std::f64::consts::TAU / (end - start);
    // With large errors and short travel the inverse does not contract; no table is refused at zero.
    let size = 0.04 * f64::from(plain / 2 + 1).recip();
    let shapes: [[f64; 4]; 6] = std::array::from_fn(|k| {
        let size = if k < 3 { size } else { 1.5e-3 * size };
        [dice.signed() * size, dice.signed() * size * 0.4, dice.unit() * 6.3, dice.unit() * 6.3]
    });
    let lost: [f64; 6] = match plain < 6 && dice.one_in(4) {
        true => std::array::from_fn(|k| if k < 3 { 1e-3 * dice.unit() } else { 2e-6 * dice.unit() }),
        false => [0.0; 6],
    };
    let pitch = (end - start) / (count - 1) as f64;
    let shifts: Vec<f64> =
        (0..count).map(|k| if free && k > 0 && k + 1 < count { 0.4 * pitch * dice.signed() } else { 0.0 }).collect();
    let positions = (0..count).map(|k| if k + 1 == count { end } else { start + pitch * k as f64 + shifts[k] });
    Some(rows_both_ways(positions, |q, reverse| {
        // Both ends of a turn have the same value.
        let q = if turn && q == end { start } else { q };
        std::array::from_fn(|k| {
            let [a, b, first, second] = shapes[k];
            let lost = if reverse { lost[k] } else { 0.0 };
            a * (wave * (q - start) + first).sin() + b * (3.0 * wave * (q - start) + second).sin() + lost
        })
    }))
}
