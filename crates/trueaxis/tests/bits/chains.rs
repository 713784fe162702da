//! Five-axis machines in several orders, with both error models, and without a state.

use super::tables::{servo, tables};
use super::{Sum, check};
use trueaxis::compensation::{Direction, ThermalLine};
use trueaxis::machine::{ErrorModel, Interpolation, Lookup};
use trueaxis::{Conditions, Nanometres, Position, Real};
use trueaxis_testing::machine::Machine;
use trueaxis_testing::noise::Noise;

const CHAINS: [&str; 6] = [
    "w C' A' b X Y Z t",
    "w b X Y Z C A t",
    "w C' X' b Y Z B t",
    "w B' A' b X Y Z t",
    "w X' Y' b Z C B t",
    "w C' Z' b X Y A t",
];

fn sum_of<R: Real, P: Position, const N: usize>(chain: &str, model: ErrorModel, cubic: bool, seed: u64) -> u64 {
    let mut noise = Noise::new(seed);
    let machine = Machine::new(chain).tool([2.0, -3.0, -140.0]).each(|axis| {
        axis.interpolation = if cubic { Interpolation::Cubic } else { Interpolation::Linear };
        axis.offset_mm = noise.vector(50.0);
        axis.backlash = 5e-4;
        axis.hysteresis = 0.05;
        if noise.unit() < 0.5 && model == ErrorModel::Volumetric {
            axis.measured_at_mm = noise.vector(60.0);
        }
    });
    let mut machine = machine.settings();
    machine.compensation.model = model;
    machine.compensation.orientation = model == ErrorModel::Volumetric && N > 3;
    if seed.is_multiple_of(2) {
        machine.axes.iter_mut().for_each(|axis| axis.lookup = Lookup::Feedback);
    }
    (machine.location.c0y, machine.location.b0z, machine.location.a0z) = (1e-5, -2e-5, 1.5e-5);
    let rows = tables(&machine, &mut noise, |noise| {
        let free = noise.unit() < 0.4;
        let jitter = |i: i32, noise: &mut Noise| if free && i > 0 && i < 18 { 6.0 * noise.signed() } else { 0.0 };
        (0..19).map(|i| -180.0 + 20.0 * f64::from(i) + jitter(i, noise)).collect()
    });
    let (servo, requirement) =
        servo::<R, P, N>(&machine, &rows).unwrap_or_else(|error| panic!("{chain} {model:?}: {error}"));
    let (mut state, mut sum) = (servo.start(), Sum::new());
    sum.add(&requirement);
    let place = |noise: &mut Noise, size: f64| -> [f64; N] {
        std::array::from_fn(|k| size * if k < 3 { 190.0 } else { 150.0 } * noise.signed())
    };
    let (mut at, mut way) = (place(&mut noise, 0.8), [0.0; N]);
    for i in 0..420 {
        if i % 35 == 0 {
            way = std::array::from_fn(|k| if k < 3 { 0.12 } else { 0.02 } * noise.signed());
        }
        if i == 150 {
            let line = ThermalLine::new(3e-3, 2e-6).expect("a growth");
            (0..N).for_each(|slot| state.set_thermal(slot, line).expect("a slot of the step"));
        }
        at = std::array::from_fn(|k| at[k] + way[k]);
        let feedback = std::array::from_fn(|k| P::of(at[k] - way[k] + 1e-3 * noise.signed()));
        let input = servo.input(at.map(P::of), feedback);
        sum.add(&servo.step(&mut state, &input, (), ()));
    }
    for i in 0..60 {
        // Beyond the tables as well.
        let position = place(&mut noise, 1.0).map(P::of);
        let conditions = Conditions {
            directions: std::array::from_fn(|_| Direction::of(noise.unit() < 0.5)),
            thermal: std::array::from_fn(|k| {
                ThermalLine::new(1e-3 * f64::from(i) * k as f64, 1e-6 * f64::from(i)).expect("a growth")
            }),
        };
        sum.add(&(servo.error_at(&position, &conditions), servo.pose_error_at(&position, &conditions)));
        sum.add(&servo.correction_at(&position, &conditions));
    }
    sum.0
}

#[test]
fn chains_of_five_axes() {
    let sums: Vec<u64> = CHAINS
        .iter()
        .zip(0..)
        .flat_map(|(chain, seed)| {
            let cubic = seed % 3 == 1;
            [
                sum_of::<f64, f64, 5>(chain, ErrorModel::Volumetric, cubic, seed),
                sum_of::<f32, Nanometres, 5>(chain, ErrorModel::Volumetric, !cubic, seed),
            ]
        })
        .collect();
    check(
        &sums,
        &[
            0x3be0_cc18_4c57_f40f,
            0x5492_8976_ba45_75dc,
            0x3158_a356_8f41_aeb3,
            0x17f8_47d6_3b7c_6f5c,
            0x48df_121f_00f2_8297,
            0x02b0_4ac7_4ed5_aea5,
            0xeec1_b7f7_524d_dac6,
            0x4cd9_69ab_58ab_5188,
            0xa937_7143_ffd0_bf3d,
            0x178a_7d42_aab7_fe84,
            0xadc3_d9d0_93c7_758a,
            0x63a1_82e2_297e_ccc3,
        ],
    );
}

#[test]
fn nine_terms_of_five_axes() {
    let sums: Vec<u64> = [CHAINS[0], CHAINS[1]]
        .iter()
        .zip(10..)
        .flat_map(|(chain, seed)| {
            [
                sum_of::<f64, f64, 5>(chain, ErrorModel::Nine, seed % 2 == 0, seed),
                sum_of::<f32, Nanometres, 5>(chain, ErrorModel::Nine, seed % 2 == 1, seed),
            ]
        })
        .collect();
    check(&sums, &[0xa3a9_afa7_999d_d495, 0xd4af_2550_a00b_188e, 0x163e_352d_12ae_8052, 0x07f7_06a4_a9cb_fd2d]);
}

#[test]
fn three_axes_on_either_side() {
    let sums: Vec<u64> = ["w b X Y Z t", "w X' Y' b Z t", "w Y' b X Z t", "w Z' X' Y' b t"]
        .iter()
        .zip(20..)
        .flat_map(|(chain, seed)| {
            [
                sum_of::<f64, f64, 3>(chain, ErrorModel::Volumetric, seed % 2 == 0, seed),
                sum_of::<f32, Nanometres, 3>(chain, ErrorModel::Nine, seed % 2 == 1, seed),
            ]
        })
        .collect();
    check(
        &sums,
        &[
            0xaac5_943f_cc10_1d98,
            0xeee2_1eec_e8b2_9159,
            0x61eb_b49f_11a3_3d7f,
            0x962a_951b_a5bf_4d76,
            0x55ab_9a02_2a25_634b,
            0xcb81_d252_0215_f6c0,
            0x6e48_bd09_e157_e878,
            0x1044_7552_85d2_7847,
        ],
    );
}
