//! The layout of the settings in the file, by literal bytes.

use super::{Layout, Stored, TableHeader, read_settings};
use crate::machine::{
    Axis, AxisServo, AxisSettings, CompensationSettings, ContourSettings, CrosstalkSettings, DriveFigures,
    DynamicSettings, ErrorModel, FaultSettings, FeedbackSettings, FrictionSettings, GridAxis, GridHeader,
    Interpolation, KinematicsSettings, Limits, LocationErrors, Lookup, MachineSettings, PeriodicSettings,
    ThermalGrowth,
};
use crate::roundness::{
    Arm, ArmSettings, Band, GaugeSettings, InfeedSettings, ProbeAngles, ProbeSettings, SpindleEncoder,
};
use std::vec::Vec;

/// Every part present. The doubles are 1, 2, 3 … in the order of the file, so that each says where it belongs.
fn everything() -> MachineSettings {
    let axis = AxisSettings {
        axis: Axis::X,
        interpolation: Interpolation::Cubic,
        lookup: Lookup::Command,
        cross_lookup: Lookup::Feedback,
        direction: -1,
        travel: [43.0, 44.0],
        joint: [45.0, 46.0],
        offset_mm: [47.0, 48.0, 49.0],
        measured_at_mm: [50.0, 51.0, 52.0],
        max_feed_per_s: 53.0,
        backlash: 54.0,
        hysteresis: 55.0,
        encoder_resolution: None,
        limits: Limits { magnitude: 56.0, slope_per_s: 57.0, acceleration_per_s2: 58.0 },
        thermal: ThermalGrowth { offset_per_k: 59.0, expansion_per_k: 60.0, datum: 61.0 },
        servo: AxisServo {
            drive: Some(DriveFigures {
                position_gain_per_s: 62.0,
                velocity_gain_per_s: 63.0,
                reset_time_s: 64.0,
                velocity_feed_forward: 65.0,
                current_loop_s: 66.0,
                dead_time_s: 67.0,
                resonance_hz: 0.0,
                resonance_damping: 0.0,
                lowest_resonance_hz: 0.0,
                gain_without_notch: 0.0,
            }),
            friction: Some(FrictionSettings {
                coulomb_per_s: 68.0,
                stribeck_share: 69.0,
                stribeck_velocity_per_s: 70.0,
                presliding: 71.0,
                viscous: 72.0,
                lead_s: 73.0,
                adapt: 0.0,
            }),
            dynamic: Some(DynamicSettings {
                limits: Limits { magnitude: 74.0, slope_per_s: 75.0, acceleration_per_s2: 76.0 },
                lag: false,
                lag_s: 0.0,
                acceleration: true,
                take_up: false,
            }),
        },
    };
    let gauge = GaugeSettings {
        points: 4096,
        angles: ProbeAngles::Degrees { phi2: 77.0, phi3: 78.0 },
        band: Band { first: 2, last: 300 },
        noise_gain_limit: 79.0,
        probes: [80.0, 84.0, 88.0].map(|first| ProbeSettings {
            gain_um: first,
            zero: first + 1.0,
            range: [first + 2.0, first + 3.0],
        }),
        spindle: SpindleEncoder { counts: 1 << 20, direction: -1, index: true, index_tolerance: 5 },
        arm: Some(ArmSettings {
            lengths: Arm { crank_mm: 92.0, wheel_mm: 93.0, pin_mm: 94.0 },
            counts: 7,
            direction: 1,
            tolerance_deg: 95.0,
        }),
        filter: Some(50),
        revolutions: 9,
        slices_per_cycle: 3,
        stop_s: 96.0,
        infeed: Some(InfeedSettings {
            axis: Axis::Z,
            direction: -1,
            band: Band { first: 4, last: 6 },
            gain: 97.0,
            delay_revolutions: 8,
            contact_deg: 98.0,
            drive_delay_s: 99.0,
            limit_um: 100.0,
            noise_gain_limit: 101.0,
        }),
    };
    MachineSettings {
        name: "mill".parse().unwrap(),
        chain: "w b X t".parse().unwrap(),
        tool_mm: [1.0, 2.0, 3.0],
        reference_temperature_c: 4.0,
        location: LocationErrors {
            a0z: 5.0,
            b0z: 6.0,
            c0y: 7.0,
            rotary: [8, 14, 20].map(|first| core::array::from_fn(|place| f64::from(first) + place as f64)),
        },
        faults: FaultSettings {
            resume: [26.0, 27.0],
            command_jump_factor: 28.0,
            feedback_jump: [29.0, 30.0],
            stuck: [31.0, 32.0],
        },
        contour: ContourSettings {
            max_lag_mm: 33.0,
            feedback: Some(FeedbackSettings {
                proportional: 34.0,
                integral_per_s: 35.0,
                max_feed_per_s: 36.0,
                watch_mm: 37.0,
            }),
        },
        compensation: CompensationSettings { model: ErrorModel::Volumetric, orientation: true, fade_deg: 38.0 },
        kinematics: KinematicsSettings { tool_axis: [39.0, 40.0, 41.0], singular_cone_deg: 42.0 },
        axes: [axis].into_iter().collect(),
        roundness: Some(gauge),
        crosstalk: [CrosstalkSettings {
            tip: Axis::Y,
            from: Axis::C,
            over: Axis::B,
            points: [[102.0, 103.0], [104.0, 105.0]].into_iter().collect(),
        }]
        .into_iter()
        .collect(),
        periodic: heapless::Vec::new(),
    }
}

/// No optional part, no axis; the angles in slots.
fn least() -> MachineSettings {
    let mut settings = everything();
    settings.contour.feedback = None;
    settings.compensation.model = ErrorModel::Nine;
    settings.axes.clear();
    settings.crosstalk.clear();
    let gauge = settings.roundness.as_mut().unwrap();
    gauge.angles = ProbeAngles::Slots { p: 11, q: 300 };
    (gauge.arm, gauge.filter, gauge.infeed) = (None, None, None);
    settings
}

/// From version 4 on.
const LEAST: &str = "
    name         04 6d 69 6c 6c
    chain        07 77 20 62 20 58 20 74
    tool         1.0 2.0 3.0
    temperature  4.0
    location     5.0 6.0 7.0
    of_A         8.0 9.0 10.0 11.0 12.0 13.0
    of_B         14.0 15.0 16.0 17.0 18.0 19.0
    of_C         20.0 21.0 22.0 23.0 24.0 25.0
    faults       26.0 27.0  28.0  29.0 30.0  31.0 32.0
    contour      33.0
    feedback     00
    compensation 00 01 38.0
    kinematics   39.0 40.0 41.0  42.0
    axes         00
    gauge        01  80 20
    angles       00 0b ac 02
    band         02 ac 02  79.0
    probes       80.0 81.0 82.0 83.0  84.0 85.0 86.0 87.0  88.0 89.0 90.0 91.0
    spindle      80 80 40 ff 01 05
    arm          00
    filter       00
    work         09 03 96.0
    infeed       00
    crosstalk    00";

/// From version 4 on.
const EVERYTHING: &str = "
    name         04 6d 69 6c 6c
    chain        07 77 20 62 20 58 20 74
    tool         1.0 2.0 3.0
    temperature  4.0
    location     5.0 6.0 7.0
    of_A         8.0 9.0 10.0 11.0 12.0 13.0
    of_B         14.0 15.0 16.0 17.0 18.0 19.0
    of_C         20.0 21.0 22.0 23.0 24.0 25.0
    faults       26.0 27.0  28.0  29.0 30.0  31.0 32.0
    contour      33.0
    feedback     01 34.0 35.0 36.0 37.0
    compensation 01 01 38.0
    kinematics   39.0 40.0 41.0  42.0
    axes         01
    X            00 01 00 01 ff
    travel       43.0 44.0
    joint        45.0 46.0
    offset       47.0 48.0 49.0
    measured_at  50.0 51.0 52.0
    reversal     53.0 54.0 55.0
    limits       56.0 57.0 58.0
    thermal      59.0 60.0 61.0
    drive        01 62.0 63.0 64.0 65.0 66.0 67.0
    friction     01 68.0 69.0 70.0 71.0 72.0 73.0
    dynamic      01 74.0 75.0 76.0  00 01 00
    gauge        01  80 20
    angles       01 77.0 78.0
    band         02 ac 02  79.0
    probes       80.0 81.0 82.0 83.0  84.0 85.0 86.0 87.0  88.0 89.0 90.0 91.0
    spindle      80 80 40 ff 01 05
    arm          01 92.0 93.0 94.0  07 01 95.0
    filter       01 32
    work         09 03 96.0
    infeed       01 02 ff 04 06 97.0 08 98.0 99.0 100.0 101.0
    crosstalk    01 01 05 04
    points       02 102.0 103.0 104.0 105.0";

/// From version 5 on.
const GRID: &str = "
    along_X      ac 02 1.0 2.0 01
    along_Y      ac 02 3.0 4.0 01
    along_Z      ac 02 5.0 6.0 00
    given        25
    scales       7.0 8.0 9.0 10.0 11.0 12.0
    fade         01 13.0 14.0
    measured_at  15.0 16.0 17.0";

/// In version 8.
const PERIOD: &str = "
    axis         05
    length       1.0
    harmonics    02 2.0 3.0 4.0 5.0
    reverse      01 6.0 7.0";

/// The lines of a layout: its name, then bytes in hexadecimal and raw doubles.
fn lines(layout: &str) -> impl Iterator<Item = (&str, Vec<u8>)> {
    layout.lines().filter_map(|line| {
        let mut words = line.split_whitespace();
        let name = words.next()?;
        let bytes = words.flat_map(|word| match word.contains('.') {
            true => word.parse::<f64>().unwrap().to_le_bytes().to_vec(),
            false => [u8::from_str_radix(word, 16).unwrap()].to_vec(),
        });
        Some((name, bytes.collect()))
    })
}

/// Writes a value and reads it back: both as the layout says.
fn assert_layout<T: Layout + PartialEq + core::fmt::Debug>(value: &T, layout: &str) {
    let mut buffer = [0; 2048];
    let written = postcard::to_slice(&Stored(value), &mut buffer).unwrap();
    let mut rest = &written[..];
    for (line, bytes) in lines(layout) {
        let (found, behind) = rest.split_at(bytes.len().min(rest.len()));
        assert_eq!(found, bytes, "{line}");
        rest = behind;
    }
    assert!(rest.is_empty(), "bytes follow the last line: {rest:?}");
    assert_eq!(&postcard::from_bytes::<Stored<T>>(written).unwrap().0, value);
}

/// The order of the fields in the public types has no influence: the bytes are those of all files ever written.
#[test]
fn the_layout_of_the_settings_is_fixed() {
    for (settings, layout) in [(everything(), EVERYTHING), (least(), LEAST)] {
        assert_layout(&settings, layout);
        // As the controller reads them: field by field.
        let bytes: Vec<u8> = lines(layout).flat_map(|(_, bytes)| bytes).collect();
        let (mut read, mut rest) = (MachineSettings::EMPTY, &bytes[..]);
        assert_eq!(read_settings(&mut rest, &mut read), Some(()));
        assert_eq!((read, rest), (settings, &[][..]));
    }
}

#[test]
fn the_layout_of_the_headers_is_fixed() {
    let along = |first: f64| GridAxis { nodes: 300, ends: [first, first + 1.0], free: true };
    let header = GridHeader {
        axes: [along(1.0), along(3.0), GridAxis { free: false, ..along(5.0) }],
        given: 0b10_0101,
        scales: [7.0, 8.0, 9.0, 10.0, 11.0, 12.0],
        fade: Some([13.0, 14.0]),
        measured_at_mm: [15.0, 16.0, 17.0],
    };
    assert_layout(&header, GRID);
    let period = PeriodicSettings {
        axis: Axis::C,
        period: 1.0,
        harmonics: [[2.0, 3.0], [4.0, 5.0]].into_iter().collect(),
        reverse: [[6.0, 7.0]].into_iter().collect(),
    };
    assert_layout(&period, PERIOD);
    let header = TableHeader { present: true, given: 0b10_0101, bidirectional: false, rows: 300 };
    assert_eq!(postcard::to_slice(&header, &mut [0; 8]).unwrap(), [0x01, 0x25, 0x00, 0xac, 0x02]);
}
