//! The step's outputs to the last bit: the same inputs give the same outputs, on every host and from one version to the
//! next. A change of a number needs new digests here; the bare-metal image is compared with the same ones by
//! `firmware-sim/cortex-m`.

use trueaxis::contour::Method;
use trueaxis::machine::{ErrorModel, Interpolation, LocationErrors, MachineSettings, Row};
use trueaxis::{Axis, Config, Real, ServoLoop};
use trueaxis_recording::adversary::{AXES, Adversary, COURSES, Course, Digest, ServoParts, vary};
use trueaxis_recording::outputs::Wire;
use trueaxis_testing::machine::{Machine, rows_both_ways};
use trueaxis_testing::noise::Noise;

const PERIOD_NS: u32 = 1_000_000;
/// Sixteen scenes.
const CYCLES: u32 = 4000;

/// The values that go into one digest.
#[derive(Clone, Copy, Debug)]
struct Case {
    model: ErrorModel,
    interpolation: Interpolation,
    /// Points of the tables are unevenly spaced.
    free: bool,
    parts: Option<ServoParts>,
    method: Method,
}

impl Case {
    fn machine(self) -> MachineSettings {
        let machine = Machine::three_axis().travel([-300.0, 300.0], 5.0).tool([3.0, -2.0, -120.0]);
        let machine = machine.each(|axis| {
            axis.interpolation = self.interpolation;
            axis.backlash = 2e-3;
            axis.hysteresis = 5e-3;
        });
        let mut machine = machine.settings();
        machine.compensation.model = self.model;
        machine.location = LocationErrors { a0z: 30e-6, b0z: -20e-6, c0y: 50e-6, ..Default::default() };
        if let Some(parts) = self.parts {
            parts.configure(&mut machine);
        }
        machine
    }

    /// Tables that end within the travel, those of the second set larger.
    fn rows(self, second: bool) -> [Vec<Row>; 3] {
        let mut noise = Noise::new(7);
        let size = if second { 1.3 } else { 1.0 };
        [0, 1, 2].map(|_| {
            let points: Vec<f64> = (0..30)
                .map(|i| -261.0 + 18.0 * f64::from(i) + if self.free { 5.0 * noise.signed() } else { 0.0 })
                .collect();
            let mut error = [0.0; 6];
            rows_both_ways(points, |_, reverse| {
                if !reverse {
                    for (k, error) in error.iter_mut().enumerate() {
                        *error += size * noise.signed() * if k < 3 { 1e-3 } else { 4e-6 };
                    }
                }
                error.map(|error| if reverse { error * 1.1 } else { error })
            })
        })
    }

    fn servo<R: Wire>(self, second: bool) -> ServoLoop<'static, R, R::Place, AXES> {
        let (machine, rows) = (self.machine(), self.rows(second));
        let (machine_id, tables_crc) = (1, u32::from(second));
        let (inverse_passes, method) = (8, self.method);
        let config = Config {
            machine: &machine,
            grids: &[],
            machine_id,
            tables_crc,
            period_ns: PERIOD_NS,
            inverse_passes,
            method,
        };
        let of = |axis: Axis| rows.get(axis.index()).map(|rows| &rows[..]);
        let memory = vec![<R as Real>::ZERO; config.requirement(of)].leak();
        config.build(of, memory).expect("a valid configuration")
    }

    fn digest<R: Wire>(self) -> u32 {
        let servos = [self.servo::<R>(false), self.servo::<R>(true)];
        let courses: Vec<Course<R, R::Place>> = (0..COURSES).map(Course::new).collect();
        let mut adversary = Adversary::new(&courses, PERIOD_NS);
        let (mut digest, mut state) = (Digest::default(), servos[0].start());
        for number in 0..CYCLES {
            let mut moment = adversary.cycle(number);
            if moment.cold {
                state = servos[0].start();
            }
            if let Some((slot, line)) = moment.thermal {
                state.set_thermal(slot, line).expect("a slot of the step");
            }
            if self.parts.is_some() {
                vary(&mut moment.input, number);
            }
            let on = courses[moment.course].path().on(moment.reference);
            digest.add(&servos[usize::from(moment.exchanged)].step(&mut state, &moment.input, on, ()));
        }
        digest.value()
    }

    /// In doubles, in singles on nanometres.
    fn digests(self) -> [u32; 2] {
        [self.digest::<f64>(), self.digest::<f32>()]
    }
}

const NINE: Case = Case {
    model: ErrorModel::Nine,
    interpolation: Interpolation::Linear,
    free: false,
    parts: None,
    method: Method::Guarded,
};

#[track_caller]
fn check(cases: &[(Case, [u32; 2])]) {
    let found: Vec<[u32; 2]> = cases.iter().map(|(case, _)| case.digests()).collect();
    let wanted: Vec<[u32; 2]> = cases.iter().map(|(_, digests)| *digests).collect();
    assert_eq!(found, wanted, "{found:#010x?}");
}

#[test]
fn nine_terms() {
    check(&[
        (NINE, [0x697c_deed, 0x8bd8_f144]),
        (Case { free: true, ..NINE }, [0x920a_c374, 0xaa21_a73a]),
        (Case { interpolation: Interpolation::Cubic, ..NINE }, [0x466a_b51d, 0x2346_f88d]),
        (Case { interpolation: Interpolation::Cubic, free: true, ..NINE }, [0xc0b0_10c4, 0x2ea8_44f4]),
    ]);
}

#[test]
fn volumetric() {
    let model = ErrorModel::Volumetric;
    check(&[
        (Case { model, ..NINE }, [0x7c5e_4daa, 0x0263_f3ba]),
        (Case { model, free: true, ..NINE }, [0x87ec_7cc9, 0xc0d2_a144]),
        (Case { model, interpolation: Interpolation::Cubic, ..NINE }, [0xe295_e958, 0x3a3c_c1dc]),
    ]);
}

#[test]
fn dynamic_correction() {
    check(&[
        (Case { parts: Some(ServoParts::Friction), ..NINE }, [0x810c_a048, 0x2132_9139]),
        (Case { parts: Some(ServoParts::All), ..NINE }, [0x1fd1_b5e9, 0xb468_65db]),
        (Case { parts: Some(ServoParts::Feedback), model: ErrorModel::Volumetric, ..NINE }, [0x3b5b_8486, 0x5def_7595]),
    ]);
}

#[test]
fn the_search_by_bisection() {
    check(&[(Case { method: Method::Bisection, ..NINE }, [0xcf40_713c, 0x582c_cbba])]);
}
