//! The compiled file: its bytes are as documented, and anything else is refused.

use proptest::prelude::*;
use std::path::Path;
use trueaxis::check::{self, TableRule};
use trueaxis::error::{ConfigError, Field};
use trueaxis::machine::Rows;
use trueaxis::machine::{
    Axis, CompensationSettings, CrosstalkSettings, DriveFigures, DynamicSettings, ErrorModel, FeedbackSettings,
    FrictionSettings, KinematicsSettings, Limits, MachineSettings, PeriodicSettings,
};
use trueaxis::roundness::{Arm, ArmSettings, Band, GaugeSettings, InfeedSettings, ProbeAngles};
use trueaxis::tcomp::{Stored, Tcomp, TcompError, checksum, machine_id};
use trueaxis_tables::files::Memory;
use trueaxis_tables::{Machine, Term, Warning, check, compile, summary};
use trueaxis_testing::noise::Noise;

/// CRC-32 bit by bit, from the definition of the polynomial (reflected 0x04C11DB7).
fn crc32(bytes: &[u8]) -> u32 {
    let mut sum = !0_u32;
    for byte in bytes {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = (sum >> 1) ^ if sum & 1 == 1 { 0xEDB8_8320 } else { 0 };
        }
    }
    !sum
}

/// A file of version 4 around a payload.
fn file(id: u32, payload: &[u8]) -> Vec<u8> {
    file_of(4, id, payload)
}

fn file_of(version: u8, id: u32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = b"TRUEAXIS".to_vec();
    bytes.extend([version, 0]);
    bytes.extend(id.to_le_bytes());
    bytes.extend(u32::try_from(payload.len()).unwrap().to_le_bytes());
    bytes.extend(payload);
    let sum = crc32(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// A sample without stated encoders and resonances: version 4 of the format.
fn sample() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-5axis");
    let mut machine = Machine::read(&folder).unwrap();
    for axis in &mut machine.settings.axes {
        axis.encoder_resolution = None;
        axis.servo.drive.as_mut().unwrap().lowest_resonance_hz = 0.0;
    }
    let feedback = machine.settings.contour.feedback.as_mut().unwrap();
    (feedback.proportional, feedback.integral_per_s) = (0.03, 1.0);
    machine
}

/// The file of the small machine, assembled by hand from the documentation.
#[test]
fn the_bytes_are_those_documented() {
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
    let machine = crate::small_machine::machine();
    let mut payload = Vec::new();
    let text = |payload: &mut Vec<u8>, text: &str| {
        payload.push(text.len() as u8);
        payload.extend(text.as_bytes());
    };
    let numbers = |payload: &mut Vec<u8>, numbers: &[f64]| {
        numbers.iter().for_each(|number| payload.extend(number.to_le_bytes()));
    };
    text(&mut payload, "small");
    text(&mut payload, "w C' X' b Z t");
    numbers(&mut payload, &[0.0, 0.0, 0.0, 20.0]);
    numbers(&mut payload, &[0.0, 2e-5, -3.5e-5]);
    numbers(&mut payload, &[0.0; 12]);
    numbers(&mut payload, &[0.012, 0.0, 0.0, 0.0, -1.4e-5, 0.0]);
    numbers(&mut payload, &[0.05, 0.05, 2.0, 0.02, 0.02, 0.2, 0.2, 1.0]);
    // No contour feedback.
    payload.push(0);
    // Nine terms, no orientation.
    payload.extend([0, 0]);
    numbers(&mut payload, &[5.0]);
    numbers(&mut payload, &[0.0, 0.0, 1.0, 0.1]);
    payload.push(3);
    for (axis, direction, backlash, expansion) in [(0, 1_i8, 0.003, 11.5e-6), (2, 1, 0.002, 0.0), (5, -1, 0.0, 0.0)] {
        payload.extend([axis, 0, 0, 0, direction as u8]);
        numbers(&mut payload, &[-500.0, 500.0, -501.0, 501.0]);
        numbers(&mut payload, &[0.0; 6]);
        numbers(&mut payload, &[500.0, backlash, 0.001]);
        numbers(&mut payload, &[0.1, 1.0, 200.0, 0.0, expansion, 0.0]);
        // No drive, friction, dynamic correction.
        payload.extend([0, 0, 0]);
    }
    let gauge = payload.len();
    // No gauge, no cross-talk.
    payload.extend([0, 0]);
    payload.extend([1, 0b10_0011, 1, 3]);
    numbers(&mut payload, &[0.0, 0.010, 0.0, 0.0, 0.011, 0.0, 0.0]);
    numbers(&mut payload, &[50.0, -0.020, 0.0, 0.0, -0.019, 0.0, 0.0]);
    numbers(&mut payload, &[100.0, 0.0015, 0.004, -7e-6, 0.0025, 0.004, -7e-6]);
    payload.extend([0, 0, 0, 0]);
    payload.extend([1, 0b10_0001, 0, 3]);
    let mdeg = std::f64::consts::PI / 180_000.0;
    numbers(&mut payload, &[0.0, 0.0, 0.0, 180.0, 0.002, mdeg, 360.0, 0.0, 0.0]);
    let id = crc32(b"small\nw C' X' b Z t");
    assert_eq!(machine_id("small", "w C' X' b Z t"), id);
    assert_eq!(compile(&machine).unwrap(), file(id, &payload));

    // Settings of five axes, each with a distinct value: the bytes that change show their positions.
    let mut five = crate::small_machine::machine();
    five.settings.compensation =
        CompensationSettings { model: ErrorModel::Volumetric, orientation: true, fade_deg: 7.5 };
    five.settings.kinematics = KinematicsSettings { tool_axis: [0.0, 0.6, 0.8], singular_cone_deg: 0.25 };
    five.settings.axes[0].offset_mm = [1.0, 2.0, 3.0];
    five.settings.axes[0].measured_at_mm = [4.0, 5.0, 6.0];
    let mut changed = payload.clone();
    let compensation = "small".len() + "w C' X' b Z t".len() + 2 + 8 * (3 + 1 + 3 + 18 + 7 + 1) + 1;
    let mut bytes = vec![1, 1];
    numbers(&mut bytes, &[7.5, 0.0, 0.6, 0.8, 0.25]);
    bytes.extend([3, 0, 0, 0, 0, 1]);
    numbers(&mut bytes, &[-500.0, 500.0, -501.0, 501.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    changed.splice(compensation..compensation + bytes.len(), bytes);
    assert_eq!(compile(&five).unwrap(), file(id, &changed));

    // The same machine with a three-probe gauge.
    let mut with = crate::small_machine::machine();
    let mut settings = GaugeSettings::with_defaults(1024, ProbeAngles::Slots { p: 188, q: 667 }, 3_600_000);
    settings.arm = Some(ArmSettings {
        lengths: Arm { crank_mm: 45.0, wheel_mm: 300.0, pin_mm: 27.5 },
        counts: 4096,
        direction: -1,
        tolerance_deg: 0.5,
    });
    settings.filter = Some(50);
    settings.infeed = Some(InfeedSettings {
        drive_delay_s: 0.001,
        ..InfeedSettings::with_defaults(Axis::X, Band { first: 2, last: 50 })
    });
    with.settings.roundness = Some(settings);
    // Varints: seven bits per byte, lowest first.
    let mut gauge_bytes = vec![1, 0x80, 0x08, 0, 0xbc, 0x01, 0x9b, 0x05, 2, 100];
    numbers(&mut gauge_bytes, &[100.0]);
    for _ in 0..3 {
        numbers(&mut gauge_bytes, &[1.0, 0.0, -1000.0, 1000.0]);
    }
    gauge_bytes.extend([0x80, 0xdd, 0xdb, 0x01, 1, 1, 0x91, 0x1c]);
    gauge_bytes.push(1);
    numbers(&mut gauge_bytes, &[45.0, 300.0, 27.5]);
    gauge_bytes.extend([0x80, 0x20, 0xff]);
    numbers(&mut gauge_bytes, &[0.5]);
    gauge_bytes.extend([1, 50, 8, 1]);
    numbers(&mut gauge_bytes, &[1.0]);
    gauge_bytes.extend([1, 0, 1, 2, 50]);
    numbers(&mut gauge_bytes, &[0.25]);
    gauge_bytes.push(2);
    numbers(&mut gauge_bytes, &[180.0, 0.001, 20.0, 10.0]);
    let mut gauged = payload.clone();
    gauged.splice(gauge..=gauge, gauge_bytes);
    assert_eq!(compile(&with).unwrap(), file(id, &gauged));
}

/// Servo settings, each with a distinct value, are in the documented order.
#[test]
fn servo_settings_are_where_documented() {
    let plain = compile(&crate::small_machine::machine()).unwrap();
    let mut machine = crate::small_machine::machine();
    let limits = Limits { magnitude: 0.04, slope_per_s: 0.8, acceleration_per_s2: 150.0 };
    for axis in machine.settings.axes.iter_mut().filter(|axis| !axis.axis.is_rotary()) {
        axis.servo.drive = Some(DriveFigures {
            velocity_feed_forward: 0.9,
            dead_time_s: 5e-4,
            ..DriveFigures::with_defaults(110.0, 800.0, 0.006)
        });
    }
    let x = &mut machine.settings.axes[0].servo;
    x.friction = Some(FrictionSettings {
        coulomb_per_s: 0.5,
        stribeck_share: 0.3,
        stribeck_velocity_per_s: 1.5,
        presliding: 0.007,
        viscous: 0.004,
        lead_s: 2e-4,
        adapt: 0.0,
    });
    x.dynamic = Some(DynamicSettings { limits, lag: true, acceleration: false, take_up: true, lag_s: 0.0 });
    // With any resonance above 100 Hz no larger gain is safe.
    machine.settings.contour.feedback =
        Some(FeedbackSettings { proportional: 0.03, integral_per_s: 1.0, max_feed_per_s: 150.0, watch_mm: 0.02 });
    let points = [[0.0, 1e-6], [300.0, 2e-6]].into_iter().collect();
    let crosstalk = CrosstalkSettings { tip: Axis::X, from: Axis::Z, over: Axis::C, points };
    machine.settings.crosstalk.push(crosstalk).unwrap();
    let compiled = compile(&machine).unwrap();
    assert_eq!(*Tcomp::parse(&compiled).unwrap().settings(), machine.settings);

    let bytes = |flags: &[u8], numbers: &[f64], behind: &[u8]| -> Vec<u8> {
        flags
            .iter()
            .copied()
            .chain(numbers.iter().flat_map(|x| x.to_le_bytes()))
            .chain(behind.iter().copied())
            .collect()
    };
    let drive = bytes(&[1], &[110.0, 800.0, 0.006, 0.9, 2.5e-4, 5e-4], &[]);
    let friction = bytes(&[1], &[0.5, 0.3, 1.5, 0.007, 0.004, 2e-4], &[]);
    let dynamic = bytes(&[1], &[0.04, 0.8, 150.0], &[1, 0, 1]);
    let mut expected = plain[18..plain.len() - 4].to_vec();
    let head = "small".len() + "w C' X' b Z t".len() + 2;
    let feedback = head + 8 * (3 + 1 + 3 + 18 + 7 + 1);
    let axes = feedback + 1 + 2 + 8 * 5 + 1;
    let axis = 5 + 8 * (4 + 6 + 3 + 6) + 3;
    // From the end, so that the earlier positions stay valid.
    let crosstalk = axes + 3 * axis + 1;
    assert_eq!(expected[crosstalk], 0);
    expected.splice(crosstalk..=crosstalk, bytes(&[1, 0, 2, 5, 2], &[0.0, 1e-6, 300.0, 2e-6], &[]));
    expected.splice(axes + 2 * axis - 3..axes + 2 * axis - 2, drive.clone());
    expected.splice(axes + axis - 3..axes + axis, [drive, friction, dynamic].concat());
    expected.splice(feedback..=feedback, bytes(&[1], &[0.03, 1.0, 150.0, 0.02], &[]));
    assert_eq!(compiled, file(crc32(b"small\nw C' X' b Z t"), &expected));
}

#[test]
fn every_bit_counts() {
    let good = compile(&sample()).unwrap();
    assert!(Tcomp::parse(&good).is_ok());
    let mut bytes = good.clone();
    for place in 0..bytes.len() {
        for bit in 0..8 {
            bytes[place] ^= 1 << bit;
            let error = Tcomp::parse(&bytes).unwrap_err();
            if place < 8 {
                assert_eq!(error, TcompError::Magic);
            } else if place < 10 && !(place == 8 && bit < 2) {
                // 4 becomes 5 or 6, versions with grids or encoders: the checksum fails.
                assert_eq!(error, TcompError::Version);
            } else if !(14..18).contains(&place) {
                assert_eq!(error, TcompError::Checksum, "{place}");
            }
            bytes[place] ^= 1 << bit;
        }
    }
    assert_eq!(bytes, good);
}

#[test]
fn no_part_and_no_more_than_the_file() {
    let good = compile(&sample()).unwrap();
    for length in 0..good.len() {
        assert_eq!(Tcomp::parse(&good[..length]), Err(TcompError::TooShort), "{length}");
    }
    for more in [&b"\0"[..], b"\n", b"TRUEAXIS", &good] {
        assert_eq!(Tcomp::parse(&[&good[..], more].concat()), Err(TcompError::TooLong));
    }
}

#[test]
fn a_foreign_machine_is_refused() {
    let bytes = compile(&sample()).unwrap();
    let file = Tcomp::parse(&bytes).unwrap();
    assert_eq!(file.expect_machine(machine_id("mill-5axis", "w C' A' Y' b X Z t")), Ok(()));
    assert_eq!(file.expect_machine(machine_id("mill-3axis", "w X' Y' b Z t")), Err(TcompError::WrongMachine));
    assert_eq!(file.crc(), u32::from_le_bytes(*bytes.last_chunk().unwrap()));
    let mut other = bytes.clone();
    other[10] ^= 1;
    let sum = crc32(&other[..other.len() - 4]);
    let end = other.len() - 4;
    other[end..].copy_from_slice(&sum.to_le_bytes());
    assert_eq!(Tcomp::parse(&other), Err(TcompError::MachineId));
}

/// Content that no compiler writes, with a valid checksum.
#[test]
fn nonsense_with_a_good_sum_is_refused() {
    let machine = sample();
    let bytes = compile(&machine).unwrap();
    let payload = &bytes[18..bytes.len() - 4];
    let id = Tcomp::parse(&bytes).unwrap().machine_id();
    assert_eq!(file(id, payload), bytes);
    let wrapped = |payload: &[u8]| Tcomp::parse(&file(id, payload)).unwrap_err();
    assert_eq!(wrapped(&[]), TcompError::Settings);
    assert_eq!(wrapped(&[payload, b"\0"].concat()), TcompError::PayloadTooLong);
    assert_eq!(wrapped(&payload[..payload.len() - 1]), TcompError::TableTooLong);
    let settings = postcard::to_stdvec(&Stored(&machine.settings)).unwrap().len();
    assert_eq!(wrapped(&payload[..settings]), TcompError::TableHeader);
    let header = |change: &[u8]| wrapped(&[&payload[..settings], change, &payload[settings + change.len()..]].concat());
    // An invalid model and orientation: enum and bool beyond their variants.
    let feedback = if machine.settings.contour.feedback.is_some() { 1 + 8 * 4 } else { 1 };
    let location = 8 * (3 + 1 + 3 + 18 + 7 + 1) + feedback;
    let compensation = 2 + machine.settings.name.len() + machine.settings.chain.len() + location;
    for place in [compensation, compensation + 1] {
        let mut payload = payload.to_vec();
        payload[place] = 2;
        assert_eq!(wrapped(&payload), TcompError::Settings);
    }
    // No column, a seventh column, absent with lines, an invalid bool.
    for change in [[1, 0], [1, 0x40], [0, 1], [2, 1]] {
        assert_eq!(header(&change), TcompError::TableHeader);
    }
    assert_eq!(header(&[1, 63, 0, 0xff, 0xff, 0xff, 0xff, 0x0f]), TcompError::TableTooLong);
    // The first position of X becomes NaN, then higher than the second.
    for (position, needed) in [(f64::NAN, TableRule::Position), (1e3, TableRule::Increasing)] {
        let mut payload = payload.to_vec();
        let first = settings + 4;
        payload[first..first + 8].copy_from_slice(&position.to_le_bytes());
        let TcompError::Content(error) = wrapped(&payload) else { panic!() };
        assert_eq!((error.field, error.axis, error.needed), (Field::Table, Some(Axis::X), needed.needed()));
    }
}

fn gauge(points: u16) -> GaugeSettings {
    GaugeSettings::with_defaults(points, ProbeAngles::Slots { p: 11, q: 15 }, 1 << 20)
}

/// Bytes of a file whose settings are changed after compilation.
fn forged(change: impl Fn(&mut MachineSettings)) -> Result<(), TcompError> {
    let machine = sample();
    let bytes = compile(&machine).unwrap();
    let length = postcard::to_stdvec(&Stored(&machine.settings)).unwrap().len();
    let mut settings = machine.settings.clone();
    change(&mut settings);
    let mut payload = postcard::to_stdvec(&Stored(&settings)).unwrap();
    payload.extend(&bytes[18 + length..bytes.len() - 4]);
    Tcomp::parse(&file(machine_id(&settings.name, &settings.chain), &payload)).map(|_| ())
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    assert_eq!(forged(|_| ()), Ok(()));
    type Change = fn(&mut MachineSettings);
    let cases: [(Field, Change); 32] = [
        (Field::Points, |m| m.roundness = Some(gauge(1000))),
        (Field::Harmonics, |m| m.roundness = Some(GaugeSettings { band: Band { first: 0, last: 9 }, ..gauge(64) })),
        (Field::Stop, |m| m.roundness = Some(GaugeSettings { stop_s: f64::NAN, ..gauge(64) })),
        (Field::Name, |m| m.name.clear()),
        (Field::Chain, |m| m.chain = "w C' A' Y' b X Z".parse().unwrap()),
        (Field::Axes, |m| m.chain = "w C' A' Y' b X t".parse().unwrap()),
        (Field::Axes, |m| m.axes.swap(0, 1)),
        (Field::Axes, |m| m.axes[1].axis = Axis::X),
        (Field::Tool, |m| m.tool_mm[1] = f64::NAN),
        (Field::ReferenceTemperature, |m| m.reference_temperature_c = f64::INFINITY),
        (Field::LocationEc, |m| m.location.rotary[2][5] = f64::NAN),
        (Field::LocationA0Z, |m| m.location.a0z = f64::NAN),
        (Field::StuckDeg, |m| m.faults.stuck[1] = 0.0),
        (Field::MaxLag, |m| m.contour.max_lag_mm = f64::NAN),
        (Field::Fade, |m| m.compensation.fade_deg = -1e-9),
        (Field::Fade, |m| m.compensation.fade_deg = f64::NAN),
        (Field::ToolAxis, |m| m.kinematics.tool_axis = [0.0; 3]),
        (Field::ToolAxis, |m| m.kinematics.tool_axis[0] = f64::INFINITY),
        (Field::SingularCone, |m| m.kinematics.singular_cone_deg = 46.0),
        (Field::Offset, |m| m.axes[4].offset_mm[2] = f64::NAN),
        (Field::MeasuredAt, |m| m.axes[3].measured_at_mm[0] = f64::NEG_INFINITY),
        (Field::Fade, |m| m.compensation.fade_deg = 45.1),
        (Field::Travel, |m| m.axes[0].travel = [1.0, 1.0]),
        (Field::Joint, |m| m.axes[0].joint = [f64::NEG_INFINITY, 1e3]),
        (Field::Joint, |m| m.axes[0].joint = m.axes[0].travel),
        (Field::MaxFeed, |m| m.axes[2].max_feed_per_s = -1.0),
        (Field::Magnitude, |m| m.axes[2].limits.magnitude = 0.0),
        (Field::Direction, |m| m.axes[0].direction = -1),
        (Field::Direction, |m| m.axes[4].direction = 0),
        (Field::LocationC0Y, |m| m.location.c0y = 2.0),
        (Field::Inverse, |m| m.tool_mm = [1e6; 3]),
        (Field::ThermalOffset, |m| m.axes[0].thermal.offset_per_k = f64::NAN),
    ];
    for (field, change) in cases {
        match forged(change) {
            Err(TcompError::Content(error)) => assert_eq!(error.field, field, "{error}"),
            other => panic!("{field:?}: {other:?}"),
        }
    }
}

#[test]
fn the_compiler_refuses_what_the_file_cannot_hold() {
    let refused = |change: fn(&mut Machine)| {
        let mut machine = crate::small_machine::machine();
        change(&mut machine);
        compile(&machine).unwrap_err()
    };
    let table = |error: ConfigError| assert_eq!((error.field, error.axis), (Field::Table, Some(Axis::X)), "{error}");
    table(refused(|m| m.tables[0].as_mut().unwrap().given[1] = false));
    table(refused(|m| m.tables[0].as_mut().unwrap().bidirectional = false));
    table(refused(|m| m.tables[0].as_mut().unwrap().rows.truncate(1)));
    assert_eq!(refused(|m| m.tables.truncate(2)).field, Field::Axes);
    assert_eq!(refused(|m| m.settings.location.b0z = 1.5).field, Field::LocationB0Z);
    let steep = refused(|m| {
        let row = &mut m.tables[0].as_mut().unwrap().rows[1];
        (row.position, row.forward[1], row.reverse[1]) = (1.0, 0.9, 0.9);
    });
    assert_eq!(steep.field, Field::Inverse);
}

#[test]
fn codes_and_texts() {
    let content = TcompError::Content(ConfigError::new(Field::Chain, 3.0, "sense"));
    let all = [
        TcompError::TooShort,
        TcompError::TooLong,
        TcompError::Magic,
        TcompError::Version,
        TcompError::Checksum,
        TcompError::Settings,
        TcompError::TableHeader,
        TcompError::TableTooLong,
        TcompError::PayloadTooLong,
        TcompError::MachineId,
        content,
        TcompError::WrongMachine,
    ];
    let texts: std::collections::BTreeSet<String> = all.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 12);
    assert!(all.iter().map(TcompError::code).eq(1..=12));
}

/// Random errors in a machine with every kind of table pass through the file bit for bit.
#[test]
fn numbers_pass_bit_for_bit() {
    let mut noise = Noise::new(3);
    for _ in 0..200 {
        let mut machine = crate::small_machine::machine();
        machine.settings.axes[0].hysteresis = 0.1;
        for row in &mut machine.tables[0].as_mut().unwrap().rows {
            for component in [0, 1, 5] {
                row.forward[component] = noise.signed() * 1e-2;
                row.reverse[component] = noise.signed() * 1e-2;
            }
        }
        let bytes = compile(&machine).unwrap();
        let file = Tcomp::parse(&bytes).unwrap();
        let table = file.table(Axis::X).unwrap();
        for (index, row) in machine.tables[0].as_ref().unwrap().rows.iter().enumerate() {
            assert_eq!(table.row(index), Some(*row));
        }
        assert_eq!((table.row(3), Rows::len(table)), (None, 3));
        assert_eq!((file.table(Axis::Z), file.table(Axis::Y)), (None, None));
        let norm = check::jacobian_norm(file.settings(), |axis| file.table(axis), &check::GridBounds::NONE);
        assert_eq!(norm, check::jacobian_norm(&machine.settings, |axis| machine.rows(axis), &check::GridBounds::NONE));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn random_bytes_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        prop_assert!(Tcomp::parse(&bytes).is_err());
        // With a valid header and checksum, so that the decoder itself sees the bytes.
        prop_assert!(Tcomp::parse(&file(0, &bytes)).is_err());
    }

    #[test]
    fn damage_behind_a_good_sum_never_panics(place in 0usize..60_000, value in any::<u8>(), cut in 0usize..60_000) {
        let bytes = compile(&crate::small_machine::machine()).unwrap();
        let mut payload = bytes[18..bytes.len() - 4].to_vec();
        let id = machine_id("small", "w C' X' b Z t");
        let place = place % payload.len();
        let old = payload[place];
        payload[place] = value;
        if let Ok(read) = Tcomp::parse(&file(id, &payload)) {
            // A different machine, but a valid one.
            prop_assert!(check::machine(read.settings(), |axis| read.table(axis), read.grids()).is_ok());
        }
        payload[place] = old;
        let cut = cut % payload.len();
        prop_assert!(Tcomp::parse(&file(id, &payload[..cut])).is_err());
    }
}

#[test]
fn the_summary_contains_the_figures() {
    let bytes = compile(&crate::small_machine::machine()).unwrap();
    let summary = summary(&Tcomp::parse(&bytes).unwrap());
    let json = serde_json::to_value(&summary).unwrap();
    assert_eq!(json["name"], "small");
    assert_eq!(json["axes"][0]["table"]["errors"][0]["name"], "EXX");
    let near = |value: &serde_json::Value, truth: f64| {
        let value = value.as_f64().unwrap();
        assert!((value - truth).abs() < 1e-9 * truth.abs(), "{value} {truth}");
    };
    near(&json["axes"][0]["table"]["errors"][0]["max_abs"], 20.0);
    near(&json["axes"][0]["backlash_micro"], 3.0);
    near(&json["axes"][2]["table"]["errors"][1]["max_abs"], std::f64::consts::PI / 180.0 * 1e3);
    near(&json["axes"][2]["table"]["range"][1], 360.0);
    assert!(json["axes"][1]["table"].is_null());
    let text = summary.to_string();
    for part in ["w C' X' b Z t", "3 lines, 0 to 100 mm, linear, bidirectional", "EXX 20.00 µm", "ECX 7.00 µrad"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// Each of these settings alone makes a machine with stated errors; without any, the warning says that nothing is corrected.
#[test]
fn a_machine_needs_no_table() {
    let text = |more: &str| format!("name = \"m\"\nchain = \"w C' b X Y Z t\"\n{more}\n");
    let read = |more: &str| {
        Machine::read_from(
            &Memory::new([("machine.toml", text(more).as_str())]),
            Path::new("machine.toml"),
            &mut |_| {},
        )
    };
    let warns = |machine: &Machine| check(machine, 1000.0).contains(&Warning::NoErrorsStated);
    let states = [
        "[axis.Y]\nbacklash_um = 20.0",
        "[axis.C]\nbacklash_urad = 20.0",
        "[axis.X.thermal]\nexpansion_um_per_m_k = 11.5",
        "[axis.X.thermal]\noffset_um_per_k = 2.0",
        "[location]\nC0Y_urad = 100.0",
        "[location]\nEX0C_um = 10.0",
    ];
    for more in states {
        let machine = read(more).unwrap();
        assert!(!warns(&machine), "{more}");
        let bytes = compile(&machine).unwrap();
        assert_eq!(Machine::from_tcomp(&Tcomp::parse(&bytes).unwrap()), machine, "{more}");
    }
    let machine = read("").unwrap();
    assert!(warns(&machine));
    assert!(Tcomp::parse(&compile(&machine).unwrap()).is_ok());
}

/// A compiled file gives the same bits with a table of zeros over the travel and without it.
#[test]
fn lost_motion_of_an_axis_needs_no_table_of_zeros() {
    let text = |table: &str| {
        format!(
            "name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntravel_mm = [-300.0, 300.0]\n[axis.Y]\ntravel_mm = \
             [-200.0, 200.0]\nbacklash_um = 20.0\nhysteresis_um = 1.0\n{table}\n[axis.Z]\ntravel_mm = [-100.0, 100.0]\n"
        )
    };
    let (without, with) = (text(""), text("table = \"y.csv\""));
    let machines = [
        vec![("machine.toml", without.as_str())],
        vec![("y.csv", "Y_mm,EYY_um\n-200,0\n200,0\n"), ("machine.toml", with.as_str())],
    ]
    .map(|files| Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap());
    let found = machines.map(|machine| {
        let bytes = compile(&machine).unwrap();
        let tables = Tcomp::parse(&bytes).unwrap();
        let mut memory = vec![0.0; tables.requirement()];
        let servo = trueaxis::HostServo::<3>::load(&tables, 1_000_000, &mut memory).unwrap();
        let mut state = servo.start();
        let path = trueaxis::contour::Path::new(&[], 0, false);
        // To 10 mm and back to −20 mm at 16.7 mm/s, then at rest.
        let way = (0..600).chain((-1200..600).rev()).chain([-1200; 100]).map(|n| f64::from(n) / 60.0);
        way.map(|y| {
            let reference = trueaxis::contour::Reference { span: 0, t: 0.0 };
            let input = servo.input([0.0, y, 0.0], [0.0, y, 0.0]);
            servo.step(&mut state, &input, path.on(reference), ()).drive.map(f64::to_bits)
        })
        .collect::<Vec<_>>()
    });
    assert_eq!(found[0], found[1]);
    let [_, last, _] = found[0].last().unwrap().map(f64::from_bits);
    assert!((last - (-20.0 - 0.02)).abs() < 1e-9, "{last}");
}

/// The small machine's warnings, calculated by hand.
#[test]
fn warnings_carry_their_numbers() {
    let mut machine = crate::small_machine::machine();
    let found = check(&machine, 10_000.0);
    let steps = |axis| found.iter().find(|w| matches!(w, Warning::VelocitySteps { axis: a, .. } if *a == axis));
    // EXX: −0.6 µm/mm then +0.43 µm/mm, at 500 mm/s.
    let Some(Warning::VelocitySteps { component: 0, step, .. }) = steps(Axis::X) else { panic!("{found:?}") };
    assert!((step - 500.0 * (0.030 + 0.0215) / 50.0).abs() < 1e-12, "{step}");
    assert!(steps(Axis::Z).is_none() && steps(Axis::C).is_some());
    let covered = |w: &&Warning| matches!(w, Warning::TravelNotCovered { .. });
    assert_eq!(found.iter().filter(covered).count(), 1, "{found:?}");
    assert!(found.contains(&Warning::TravelNotCovered { axis: Axis::X, table: [0.0, 100.0], travel: [-500.0, 500.0] }));
    assert!(!found.iter().any(|w| matches!(w, Warning::SlopeAboveLimit { .. } | Warning::MagnitudeAboveLimit { .. })));

    // EXX 0.6 µm/mm and B0Z 20 µm/m at 500 mm/s, C 2 µm on 180 degrees at 500 deg/s: 0.3 + 0.01 + 0.0056 mm/s.
    machine.settings.axes[0].limits.slope_per_s = 0.3;
    machine.settings.axes[0].limits.magnitude = 0.02;
    machine.settings.axes[0].joint = [-510.0, 510.0];
    machine.settings.axes[1].travel = [-1e6, 1e6];
    machine.settings.axes[1].joint = [-1e6 - 1.0, 1e6 + 1.0];
    machine.settings.axes[1].limits.acceleration_per_s2 = 10.0;
    let found = check(&machine, 100_000.0);
    let Some(Warning::SlopeAboveLimit { rate, moving: Axis::X, part, .. }) =
        found.iter().find(|w| matches!(w, Warning::SlopeAboveLimit { axis: Axis::X, .. }))
    else {
        panic!("{found:?}")
    };
    assert!((part - 0.3).abs() < 1e-12 && (rate - 0.3 - 0.01 - 500.0 * 0.002 / 180.0).abs() < 1e-12, "{rate} {part}");
    assert!(found.contains(&Warning::TravelNotDeclared { axis: Axis::Z }));
    let resolution = f64::from(f32::EPSILON) * 0.1;
    let expected = Warning::AccelerationBelowResolution { axis: Axis::Z, per_cycle: 1e-9, resolution };
    assert!(found.iter().any(|w| w.to_string() == expected.to_string()), "{found:?}");
    // 20 µm of EXX relative to −20 µm, C 12 + 2 µm.
    let Some(Warning::MagnitudeAboveLimit { correction, limit, term: Term::Table(Axis::X), part, .. }) =
        found.iter().find(|w| matches!(w, Warning::MagnitudeAboveLimit { axis: Axis::X, .. }))
    else {
        panic!("{found:?}")
    };
    assert_eq!(*limit, 0.02);
    assert!((correction - 0.014 - 0.014).abs() < 1e-12, "{correction}");
    assert!((part - 0.02).abs() < 1e-3, "{part}");
    for warning in &found {
        let text = warning.to_string();
        assert!(
            (text.starts_with("axis ") || text.starts_with("angular errors "))
                && (text.contains("mm") || text.contains("µm") || text.contains("deg")),
            "{text}"
        );
    }
}

/// The refusal of another version names the supported one.
#[test]
fn another_version_is_refused_with_the_one_that_is_needed() {
    let text = TcompError::Version.to_string();
    assert!(text.contains(&format!("version {} is needed", trueaxis::tcomp::VERSION)), "{text}");
}

/// Behind the payload of version 4: no grid, no encoder, no addition, no notch, then the periods.
#[test]
fn periods_follow_everything_else() {
    let mut machine = crate::small_machine::machine();
    let plain = compile(&machine).unwrap();
    let payload = &plain[18..plain.len() - 4];
    let id = crc32(b"small\nw C' X' b Z t");
    let axes = machine.settings.axes.len();
    for (axis, period, forward, reverse) in [
        (Axis::X, 5.0, vec![[1e-3, -2e-3], [0.0, 5e-4]], vec![]),
        (Axis::C, 4.0, vec![[1e-4, 0.0]], vec![[1e-4, 1e-5]]),
    ] {
        let (harmonics, reverse) = (forward.into_iter().collect(), reverse.into_iter().collect());
        machine.settings.periodic.push(PeriodicSettings { axis, period, harmonics, reverse }).unwrap();
    }
    let mut expected = payload.to_vec();
    expected.push(0);
    expected.extend(vec![0; 8 * axes * (1 + 5 + 1)]);
    let head = expected.len();
    let numbers = |numbers: &[f64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>();
    for part in [&[2_u8, 0][..], &numbers(&[5.0]), &[2], &numbers(&[1e-3, -2e-3, 0.0, 5e-4]), &[0]] {
        expected.extend(part);
    }
    for part in [&[5_u8][..], &numbers(&[4.0]), &[1], &numbers(&[1e-4, 0.0]), &[1], &numbers(&[1e-4, 1e-5])] {
        expected.extend(part);
    }
    let compiled = compile(&machine).unwrap();
    assert_eq!(compiled, file_of(8, id, &expected));
    assert_eq!(Machine::from_tcomp(&Tcomp::parse(&compiled).unwrap()), machine);
    // Cut off, none at all, one more than there are, and bytes behind the last one.
    for length in head..expected.len() {
        let cut = file_of(8, id, &expected[..length]);
        assert_eq!(Tcomp::parse(&cut), Err(TcompError::Settings), "{length} of {}", expected.len());
    }
    for count in [0, 3, 255] {
        let mut other = expected.clone();
        other[head] = count;
        assert_eq!(Tcomp::parse(&file_of(8, id, &other)), Err(TcompError::Settings), "{count} periods");
    }
    assert_eq!(Tcomp::parse(&file_of(8, id, &[&expected[..], &[0]].concat())), Err(TcompError::PayloadTooLong));
    // Read again into the same place, a file without periods has none.
    let mut place = Tcomp::empty();
    assert_eq!((place.read(&compiled), place.read(&plain)), (Ok(()), Ok(())));
    assert!(place.settings().periodic.is_empty());
}
