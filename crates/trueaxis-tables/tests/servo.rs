//! Drive, friction, dynamic correction, contour feedback and cross-talk in `machine.toml`: read, written, refused.

use std::path::Path;
use trueaxis::machine::{
    Axis, CrosstalkSettings, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings, Limits,
};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::machine_files;
use trueaxis_tables::{Machine, compile};

/// Every key with a distinct value.
const MACHINE: &str = "\
name = \"servo\"
chain = \"w C' X' b Z t\"
[axis.X]
table = \"x.csv\"
travel_mm = [0, 20]
[axis.X.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
velocity_feed_forward = 0.93
current_loop_s = 0.0003
dead_time_s = 0.0005
lowest_resonance_hz = 10000
[axis.X.friction]
coulomb_mm_per_s = 0.5
presliding_um = 7.2
stribeck_share = 0.3
stribeck_velocity_mm_per_s = 2.5
viscous = 0.004
lead_s = 0.0002
[axis.X.dynamic]
magnitude_um = 40
slope_mm_per_s = 0.8
acceleration_mm_per_s2 = 150
lag = true
acceleration = true
take_up = true
[axis.C.drive]
position_gain_per_s = 60
velocity_gain_per_s = 400
reset_time_s = 0.01
[axis.C.friction]
coulomb_deg_per_s = 0.2
presliding_urad = 70
stribeck_velocity_deg_per_s = 3
[axis.C.dynamic]
magnitude_urad = 900
slope_deg_per_s = 2
acceleration_deg_per_s2 = 250
[axis.Z.drive]
position_gain_per_s = 100
velocity_gain_per_s = 700
reset_time_s = 0.007
lowest_resonance_hz = 10000
[contour.feedback]
proportional = 0.25
integral_per_s = 8
max_feed_mm_per_min = 9100
watch_um = 12
[[crosstalk]]
tip = \"X\"
from = \"Z\"
k_um_per_m_per_s2 = 1.2
[[crosstalk]]
tip = \"Z\"
from = \"C\"
over = \"X\"
table = [[0, 0.3], [10.5, 0.7]]
";

fn read(text: &str) -> Result<Machine, String> {
    let files = Memory::new([("machine.toml", text), ("x.csv", "X_mm,EXX_um\n0,1\n20,2\n")]);
    Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).map_err(|error| error.to_string())
}

#[test]
fn every_key_arrives_in_its_unit() {
    let machine = read(MACHINE).unwrap();
    let axis = |axis| machine.settings.axis(axis).unwrap().servo;
    let (x, c, z) = (axis(Axis::X), axis(Axis::C), axis(Axis::Z));
    assert_eq!(
        x.drive,
        Some(DriveFigures {
            position_gain_per_s: 110.0,
            velocity_gain_per_s: 800.0,
            reset_time_s: 0.006,
            velocity_feed_forward: 0.93,
            current_loop_s: 0.0003,
            dead_time_s: 0.0005,
            lowest_resonance_hz: 10_000.0,
            ..DriveFigures::with_defaults(0.0, 0.0, 0.0)
        })
    );
    assert_eq!(
        x.friction,
        Some(FrictionSettings {
            coulomb_per_s: 0.5,
            stribeck_share: 0.3,
            stribeck_velocity_per_s: 2.5,
            presliding: 0.0072,
            viscous: 0.004,
            lead_s: 0.0002,
            adapt: 0.0,
        })
    );
    let limits = Limits { magnitude: 0.04, slope_per_s: 0.8, acceleration_per_s2: 150.0 };
    assert_eq!(x.dynamic, Some(DynamicSettings { limits, lag: true, acceleration: true, take_up: true, lag_s: 0.0 }));
    // Missing keys have their defaults.
    let drive = z.drive.unwrap();
    assert_eq!((drive.velocity_feed_forward, drive.current_loop_s, drive.dead_time_s), (0.0, 0.00025, 0.0));
    assert_eq!((z.friction, z.dynamic), (None, None));
    let friction = c.friction.unwrap();
    assert_eq!((friction.coulomb_per_s, friction.presliding), (0.2, 70e-6_f64.to_degrees()));
    assert_eq!((friction.stribeck_velocity_per_s, friction.stribeck_share, friction.lead_s), (3.0, 0.0, 0.0));
    let limits = Limits { magnitude: 900e-6_f64.to_degrees(), slope_per_s: 2.0, acceleration_per_s2: 250.0 };
    assert_eq!(
        c.dynamic,
        Some(DynamicSettings { limits, lag: false, acceleration: false, take_up: false, lag_s: 0.0 })
    );
    let max_feed_per_s = 9100.0 / 60.0;
    assert_eq!(
        machine.settings.contour.feedback,
        Some(FeedbackSettings { proportional: 0.25, integral_per_s: 8.0, max_feed_per_s, watch_mm: 0.012 })
    );
    // 1 um per m/s2 is 1e-6 s2; 1 um per deg/s2 is 1e-3 mm per deg/s2.
    let constant = [[0.0, 1.2e-6]].into_iter().collect();
    let curve = [[0.0, 0.3e-3], [10.5, 0.7e-3]].into_iter().collect();
    assert_eq!(
        machine.settings.crosstalk.as_slice(),
        [
            CrosstalkSettings { tip: Axis::X, from: Axis::Z, over: Axis::Z, points: constant },
            CrosstalkSettings { tip: Axis::Z, from: Axis::C, over: Axis::X, points: curve },
        ]
    );
}

#[test]
fn defaults_are_those_stated() {
    let text = MACHINE.replace("lag = true\nacceleration = true\ntake_up = true\n", "");
    let (head, _) = text.split_once("magnitude_um").unwrap();
    let (_, tail) = text.split_once("[axis.C.drive]").unwrap();
    let (tail, crosstalk) = (tail.split_once("proportional").unwrap().0, "");
    let tail = tail.replace("magnitude_urad = 900\nslope_deg_per_s = 2\nacceleration_deg_per_s2 = 250\n", "");
    let machine = read(&format!("{head}[axis.C.drive]{tail}{crosstalk}")).unwrap();
    let of = |axis| machine.settings.axis(axis).unwrap().servo.dynamic.unwrap();
    let limits = |magnitude| Limits { magnitude, slope_per_s: 5.0, acceleration_per_s2: 5000.0 };
    let off = |magnitude| DynamicSettings {
        limits: limits(magnitude),
        lag: false,
        acceleration: false,
        take_up: false,
        lag_s: 0.0,
    };
    assert_eq!(of(Axis::X), off(0.05));
    assert_eq!(of(Axis::C), off(1000e-6_f64.to_degrees()));
    let feedback =
        FeedbackSettings { proportional: 0.3, integral_per_s: 10.0, max_feed_per_s: 10_000.0 / 60.0, watch_mm: 0.01 };
    assert_eq!(machine.settings.contour.feedback, Some(feedback));
}

/// Writes the machine and reads it back: bit for bit, except for angles that are written as µrad.
#[test]
fn a_written_machine_is_read_back() {
    let machine = read(MACHINE).unwrap();
    let files = machine_files(&machine, "");
    let files = Memory::new(files.iter().map(|(name, text)| (name, text.as_str())));
    let mut again = Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap();
    let servo = |machine: &Machine| machine.settings.axis(Axis::C).unwrap().servo;
    let angles = |machine: &Machine| {
        let servo = servo(machine);
        [servo.friction.unwrap().presliding, servo.dynamic.unwrap().limits.magnitude]
    };
    for (written, read) in angles(&machine).into_iter().zip(angles(&again)) {
        assert!((read / written - 1.0).abs() < 1e-15, "{read} {written}");
    }
    again.settings.axes.last_mut().unwrap().servo = servo(&machine);
    assert_eq!(again, machine);
}

/// Refusals by the reader.
#[test]
fn wrong_sections_are_refused_at_their_lines() {
    let line = |text: &str, found: &str| 1 + text.lines().position(|line| line == found).unwrap();
    for (old, new, at, expected) in [
        ("reset_time_s = 0.006\n", "", "", "key axis.X.drive.reset_time_s: found nothing, needed the reset time"),
        ("presliding_um = 7.2\n", "", "", "key axis.X.friction.presliding_um: found nothing, needed the travel"),
        ("lag = true", "lag = 1", "lag = 1", "key axis.X.dynamic.lag: found 1, needed true or false"),
        (
            "watch_um = 12",
            "watch_mm = 12",
            "watch_mm = 12",
            "key contour.feedback.watch_mm: found watch_mm, needed watch_um, or another of proportional, integral_per_s, \
             max_feed_mm_per_min, watch_um",
        ),
        (
            "presliding_urad = 70",
            "presliding_um = 70",
            "presliding_um = 70",
            "key axis.C.friction.presliding_um: found presliding_um, needed presliding_urad: the travel over which friction",
        ),
        ("[[crosstalk]]\ntip = \"X\"", "[crosstalk]\ntip = \"X\"", "", ""),
        (
            "k_um_per_m_per_s2 = 1.2",
            "",
            "tip = \"X\"",
            "key crosstalk.k_um_per_m_per_s2: found nothing, needed a number, or",
        ),
        ("from = \"Z\"", "from = \"U\"", "from = \"U\"", "key crosstalk.from: found \"U\", needed an axis, like"),
        (
            "over = \"X\"\n",
            "",
            "table = [[0, 0.3], [10.5, 0.7]]",
            "key crosstalk.table: found [[0, 0.3], [10.5, 0.7]], needed the axis on whose position it depends, over = …",
        ),
        (
            "[10.5, 0.7]",
            "[10.5]",
            "table = [[0, 0.3], [10.5]]",
            "key crosstalk.table: found [[0, 0.3], [10.5]], needed a list of pairs of numbers",
        ),
        ("[[0, 0.3], [10.5, 0.7]]", "[]", "table = []", "key crosstalk.table: found [], needed 1 to 8 pairs"),
        (
            "k_um_per_m_per_s2 = 1.2",
            "k_um_per_m_per_s2 = 1.2\nover = \"X\"",
            "k_um_per_m_per_s2 = 1.2",
            "key crosstalk.k_um_per_m_per_s2: found 1.2, needed either a constant, or over and table",
        ),
    ] {
        let text = MACHINE.replacen(old, new, 1);
        assert_ne!(text, MACHINE, "{old}");
        let error = read(&text).expect_err(old);
        let prefix =
            if at.is_empty() { String::from("machine.toml") } else { format!("machine.toml:{}: ", line(&text, at)) };
        assert!(error.starts_with(&prefix) && error.contains(expected), "{error}\n{prefix}{expected}");
    }
    let many = MACHINE.to_owned() + &"[[crosstalk]]\ntip = \"X\"\nfrom = \"Z\"\nk_um_per_m_per_s2 = 1\n".repeat(5);
    let error = read(&many).unwrap_err();
    let last = many.lines().count() - 2;
    assert_eq!(
        error,
        format!("machine.toml:{last}: key crosstalk: found another section [[crosstalk]], needed at most 6")
    );
}

/// Refusals by the controller's checks, at the line of the key.
#[test]
fn refusals_by_the_checks_name_their_line() {
    let drive = "position_gain_per_s = 110\nvelocity_gain_per_s = 800\nreset_time_s = 0.006\n\
                 velocity_feed_forward = 0.93\ncurrent_loop_s = 0.0003\ndead_time_s = 0.0005\nlowest_resonance_hz = 10000\n";
    let without = MACHINE.replace(&format!("[axis.X.drive]\n{drive}"), "");
    let no_friction = without.replace("[axis.X.friction]", "[axis.Z.friction]");
    let no_lag = no_friction.replace("lag = true", "lag = false");
    let no_acceleration = no_lag.replace("acceleration = true", "acceleration = false");
    let unknown = MACHINE.replace("[axis.Z.drive]", "[axis.Z.dr]");
    assert!(read(&unknown).unwrap_err().contains("key axis.Z.dr: found dr, needed one of"));
    for (text, at, expected) in [
        (
            &without,
            "[axis.X.friction]",
            "key axis.X.friction: found this section, needed the figures of the axis' drive as well: [axis.X.drive]",
        ),
        (
            &no_friction,
            "lag = true",
            "key axis.X.dynamic.lag: found true, needed the figures of the axis' drive as well: [axis.X.drive]",
        ),
        (
            &no_lag,
            "acceleration = true",
            "key axis.X.dynamic.acceleration: found true, needed the figures of the axis' drive as well: [axis.X.drive]",
        ),
        (
            &no_acceleration,
            "[contour.feedback]",
            "key contour.feedback: found this section, needed the figures of the axis' drive as well: [axis.X.drive]",
        ),
        (
            &MACHINE.replace("reset_time_s = 0.006", "reset_time_s = 0"),
            "reset_time_s = 0",
            "key axis.X.drive.reset_time_s: found 0, needed a time of 0.00001 to 1000 s",
        ),
        (
            &MACHINE.replace("reset_time_s = 0.006", "reset_time_s = 0.0002"),
            "position_gain_per_s = 110",
            "key axis.X.drive.position_gain_per_s: found 110, needed a gain at which the drive alone is stable with its \
             other figures",
        ),
        (
            &MACHINE.replace("magnitude_um = 40", "magnitude_um = 140"),
            "magnitude_um = 140",
            "key axis.X.dynamic.magnitude_um: found 140, needed a magnitude within that of the axis' correction: 100",
        ),
        (
            &MACHINE.replace("tip = \"Z\"", "tip = \"C\""),
            "tip = \"C\"",
            "key crosstalk.tip: found \"C\", needed a linear axis",
        ),
        (
            &MACHINE.replace("over = \"X\"", "over = \"A\""),
            "over = \"A\"",
            "key crosstalk.over: found \"A\", needed an axis of the machine",
        ),
        (
            &MACHINE.replace("[10.5, 0.7]", "[0, 0.7]"),
            "table = [[0, 0.3], [0, 0.7]]",
            "key crosstalk.table: found [[0, 0.3], [0, 0.7]], needed positions that increase by at least 0.001",
        ),
        (
            &MACHINE.replace("k_um_per_m_per_s2 = 1.2", "k_um_per_m_per_s2 = 1200"),
            "k_um_per_m_per_s2 = 1200",
            "key crosstalk.k_um_per_m_per_s2: found 1200, needed -1000 to 1000 um per m/s2",
        ),
    ] {
        let line = 1 + text.lines().position(|line| line == at).unwrap();
        assert_eq!(read(text).unwrap_err(), format!("machine.toml:{line}: {expected}"));
    }
}

/// Gains that leave too little margin are refused with the largest permitted ones; these, and all lower ones at the same
/// ratio, are accepted.
#[test]
fn gains_are_refused_with_the_largest_permitted_ones() {
    let built = |text: &str, rate_hz: f64| {
        let files = Memory::new([("machine.toml", text), ("x.csv", "X_mm,EXX_um\n0,1\n20,2\n")]);
        let machine = read(text).unwrap();
        let refused = |error| Machine::refusal(&files, Path::new("machine.toml"), &error).to_string();
        trueaxis_tables::build(&machine, rate_hz).map_err(refused)
    };
    for (p, i) in [(4.0, 120.0), (0.0, 400.0), (9.0, 3.0), (3.0, 1000.0)] {
        for rate_hz in [500.0, 1_000.0, 10_000.0] {
            let with = |share: f64| {
                let gains = format!("proportional = {:?}\nintegral_per_s = {:?}", p * share, i * share);
                MACHINE.replace("proportional = 0.25\nintegral_per_s = 8", &gains)
            };
            let (text, key) = (with(1.0), if p > 0.0 { "proportional" } else { "integral_per_s" });
            let error = built(&text, rate_hz).unwrap_err();
            let line = 1 + text.lines().position(|line| line.starts_with(key)).unwrap();
            assert!(error.starts_with(&format!("machine.toml:{line}: key contour.feedback.{key}: found ")), "{error}");
            assert!(error.contains("needed 60 degrees of phase margin and 12 dB of gain margin; "), "{error}");
            let (_, most) = error.split_once("may be at most ").unwrap();
            let (most, axis) = most.split_once(", because of axis ").unwrap();
            assert!(["X", "Z"].contains(&axis), "{error}");
            let most = most.parse::<f64>().unwrap() / if p > 0.0 { p } else { i };
            assert!(built(&with(most * 1.02), rate_hz).is_err(), "{error}");
            for share in [1.0, 0.99, 0.9, 0.75, 0.5] {
                assert_eq!(built(&with(most * share), rate_hz), Ok(()), "{share} of {error}");
            }
        }
    }
}

/// Three axes whose gains are 3 % apart, with the same standard uncertainty of K_v.
fn three_drives(uncertainty: &str) -> Machine {
    let axes = [("X", 100.0), ("Y", 103.0), ("Z", 97.0)].map(|(axis, gain)| {
        format!(
            "[axis.{axis}.drive]\nposition_gain_per_s = {gain}\nvelocity_gain_per_s = 800\nreset_time_s = 0.006\n\
             velocity_feed_forward = 0.9\n[axis.{axis}.drive.uncertainty]\n{uncertainty}\n[axis.{axis}.dynamic]\nlag = true\n"
        )
    });
    let text = format!("name = \"m\"\nchain = \"w X' Y' b Z t\"\n{}", axes.concat());
    let files = Memory::new([("machine.toml", text.as_str())]);
    Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap()
}

#[test]
fn drives_that_their_uncertainty_does_not_tell_apart_compensate_one_lag() {
    let lags = |machine: &Machine| -> Vec<f64> {
        machine.settings.axes.iter().map(|axis| axis.servo.dynamic.unwrap().lag_s).collect()
    };
    // u(L) = 3 % of L: chi-squared of 2; the quantile of two degrees of freedom is 5.99.
    let common = three_drives("position_gain_per_s = 3");
    let own = [100.0, 103.0, 97.0].map(|gain: f64| 0.1 / gain);
    let weights = [100.0, 103.0, 97.0].map(|gain: f64| (gain * gain).powi(2));
    let mean = own.iter().zip(weights).map(|(lag, weight)| lag * weight).sum::<f64>() / weights.iter().sum::<f64>();
    assert!(lags(&common).iter().all(|lag| (lag - mean).abs() < 1e-12), "{:?} {mean}", lags(&common));
    // 1 %: chi-squared of 18. Not stated: taken as exact.
    assert_eq!(lags(&three_drives("position_gain_per_s = 1")), [0.0; 3]);
    assert_eq!(lags(&three_drives("reset_time_s = 0.001")), [0.0; 3]);
    // The controller gets it, in version 7 of the format.
    let bytes = trueaxis_tables::compile(&common).unwrap();
    assert_eq!(bytes[8..10], [7, 0]);
    assert_eq!(trueaxis::tcomp::Tcomp::parse(&bytes).unwrap().settings(), &common.settings);
}

#[test]
fn the_check_tells_the_feed_at_which_lag_meets_its_limit() {
    let machine = three_drives("position_gain_per_s = 1");
    let needs = trueaxis_tables::dynamic_needs(&machine);
    // 50 µm over 1 ms.
    let feed = needs[0].lag_meets_limit_at_feed_per_min.unwrap();
    assert!((feed - 3000.0).abs() < 1e-6, "{feed}");
    let needed = needs[0].lag_needs_micro.unwrap();
    assert!((needed - needs[0].max_feed_per_min / 60.0).abs() < 1e-6, "{needs:?}");
    let warnings: Vec<String> = trueaxis_tables::check(&machine, 1e4).iter().map(ToString::to_string).collect();
    let expected = "axis X: lag meets the magnitude limit of the dynamic correction at 3000 mm/min and needs";
    assert!(warnings.iter().any(|warning| warning.starts_with(expected)), "{warnings:?}");
}

/// The machine with `adapt` of X.
fn adapting(value: &str) -> Result<Machine, String> {
    read(&MACHINE.replacen("[axis.X.friction]", &format!("[axis.X.friction]\nadapt = {value}"), 1))
}

#[test]
fn an_interval_of_friction_that_excludes_the_identified_figure_is_refused() {
    for (value, found) in [
        ("-0.1", "found -0.1, needed a share of 0 (off) to 0.9"),
        ("0.95", "found 0.95, needed a share of 0 (off) to 0.9"),
        ("1.5", "found 1.5, needed a share of 0 (off) to 0.9"),
        ("nan", "found nan, needed a finite number"),
    ] {
        let error = adapting(value).unwrap_err();
        for part in ["machine.toml", "adapt", found] {
            assert!(error.contains(part), "{value}: {error}");
        }
    }
    // Two ends of an interval are refused: the key is one number.
    let error = adapting("[0.6, 0.9]").unwrap_err();
    assert!(error.contains("adapt") && error.contains("number"), "{error}");
    let machine = adapting("0.5").unwrap();
    assert_eq!(machine.settings.axes[0].servo.friction.unwrap().adapt, 0.5);
    let compiled = compile(&machine).unwrap();
    assert_eq!(Tcomp::parse(&compiled).unwrap().settings(), &machine.settings);
    // Off: the same bytes as a machine without the key.
    assert_eq!(compile(&adapting("0").unwrap()).unwrap(), compile(&adapting("0.0").unwrap()).unwrap());
}
