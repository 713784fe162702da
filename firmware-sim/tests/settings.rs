//! Settings from the command line: files, flags, refusals.

use firmware_sim::samples::sample_machine;
use serde_json::Value;
use trueaxis_sim::plant::drive::Variant;
use trueaxis_sim::plant::encoder::EncoderSettings;
use trueaxis_tables::Machine;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");

#[test]
fn a_printed_scenario_is_read_back() {
    let folder = Folder::new(SIMULATOR);
    let all =
        ["--feed-percent", "80", "--noise-um", "0.02", "--set", "drive.reset_time_s=0.01", "--fault", "late@3s+1=2.5"];
    let text = folder.good(&[&["scenario"], &all[..]].concat());
    folder.write("mine.toml", &text);
    assert_eq!(folder.good(&["scenario", "--scenario", "mine.toml"]), text);
    for line in ["feed_percent = 80.0", "noise_rms_mm = 0.00002", "reset_time_s = 0.01", "faults = [\"late@3s+1=2.5\"]"]
    {
        assert!(text.contains(line), "{line} in\n{text}");
    }
    // Flags override the file, --set overrides flags.
    let more = [
        "scenario",
        "--scenario",
        "mine.toml",
        "--feed-percent",
        "70",
        "--jerk",
        "2e4",
        "--set",
        "motion.jerk_mm_per_s3=3e4",
    ];
    let text = folder.good(&more);
    assert!(text.contains("feed_percent = 70.0") && text.contains("jerk_mm_per_s3 = 30000.0"), "{text}");
}

#[test]
fn a_run_with_the_file_is_the_run_with_the_flags() {
    let folder = Folder::new(SIMULATOR);
    folder.write("mine.toml", "rate_hz = 500\n[drive]\nposition_gain_per_s = 60\n");
    let run = |arguments: &[&str]| -> Value {
        folder.json(&[&["run", "--program", "short-tour", "--json"], arguments].concat())
    };
    let of_file = run(&["--scenario", "mine.toml"]);
    let of_flags = run(&["--rate-hz", "500", "--position-gain", "60"]);
    let plain = run(&["--rate-hz", "500"]);
    assert_eq!(of_file["settings"]["drive"]["position_gain_per_s"], 60.0);
    for key in ["settings", "contour_error_um", "cycles", "servo_rate_hz"] {
        assert_eq!(of_file[key], of_flags[key], "{key}");
    }
    let rms = |of: &Value| of["contour_error_um"]["servo_only"]["rms"].as_f64().unwrap();
    assert!(rms(&of_file) > 1.2 * rms(&plain), "{} {}", rms(&of_file), rms(&plain));
    let summary = folder.good(&["run", "--program", "short-tour", "--scenario", "mine.toml"]);
    assert!(summary.contains("note: setting drive.position_gain_per_s = 60.0 (default 110.0)"), "{summary}");
}

#[test]
fn refusals_say_where_and_what_is_needed() {
    let folder = Folder::new(SIMULATOR);
    folder.write("bad.toml", "seed = 1\n[drive]\ngain = 3\n");
    for (arguments, expected) in [
        (
            &["--scenario", "bad.toml"][..],
            "bad.toml:3: drive.gain: found no such setting, needed one of coulomb_mm_per_s2",
        ),
        (&["--scenario", "none.toml"], "cannot read none.toml"),
        (&["--noise-um", "-1"], "--noise-um: encoder.linear.noise_rms_mm: found -0.001, needed 0 to 1 mm"),
        (&["--feed-percent", "nan"], "--feed-percent: found NaN, needed 1 to 1000 %"),
        (&["--set", "drive.gain=3"], "--set drive.gain=3: drive.gain: found no such setting"),
        (&["--set", "seed"], "--set: found seed, needed KEY=VALUE"),
        (&["--origin-mm", "1,2"], "--origin-mm: found"),
        (&["--drive", "usaul"], "--drive: found \"usaul\", needed usual, or another of stiff, usual, soft, worn"),
        (&["--drive", "worn@Q"], "--drive: found \"worn@Q\", needed worn@AXIS of X, Y, Z, A, B, C"),
        (&["--drive", "stiff", "--rate-hz", "400"], "drive.resonance_hz: found 250, needed 0 (rigid) or 1 to 200 Hz"),
        (&["--set", "drive.gear_play_mm=0.01"], "drive.gear_play_mm: found 0.01, needed 0 with the rigid drive"),
    ] {
        for command in ["scenario", "run"] {
            folder.bad(&[&[command], arguments].concat(), &[expected]);
        }
    }
    // The scenario file is an input, which an output never replaces.
    folder.write("out/trace.csv", "seed = 1\n");
    folder.bad(&["run", "--scenario", "out/trace.csv", "--report", "out"], &[]);
}

/// The stated resolution is six standard deviations of the noise, which is more than a count.
#[test]
fn the_sample_machines_state_their_encoders() {
    for name in ["mill-3axis", "mill-5axis", "head-5axis", "mill-turn", "grinder"] {
        for own in &Machine::read(&sample_machine(name)).unwrap().settings.axes {
            let encoder = EncoderSettings::of(own.axis);
            let stated = own.encoder_resolution.unwrap();
            assert!(stated > encoder.resolution_mm, "{name} {:?}", own.axis);
            assert!((stated / (6.0 * encoder.noise_rms_mm) - 1.0).abs() < 0.01, "{name} {:?}: {stated}", own.axis);
        }
    }
}

#[test]
fn a_drive_is_chosen_for_all_axes_or_one_and_other_flags_change_it() {
    let folder = Folder::new(SIMULATOR);
    let text = folder.good(&["scenario", "--position-gain", "55", "--drive", "usual", "--drive", "worn@y"]);
    for line in ["position_gain_per_s = 55.0", "resonance_hz = 120.0", "scale_at = \"load\"", "drive = \"worn\""] {
        assert!(text.contains(line), "{line} in\n{text}");
    }
    folder.write("mine.toml", &text);
    assert_eq!(folder.good(&["scenario", "--scenario", "mine.toml"]), text);
    let refused = ["run", "--program", "short-tour", "--drive", "worn@C"];
    folder.bad(&refused, &["settings: found a drive of axis C, needed one of X, Y, Z"]);
}

/// `run --help` states the figures of every variant.
#[test]
fn the_help_has_the_figures_of_the_variants() {
    let help = Folder::new(SIMULATOR).good(&["run", "--help"]);
    for variant in Variant::ALL {
        let row = help.lines().find(|line| {
            let mut words = line.split_whitespace();
            words.next() == Some(variant.name()) && words.next().is_some_and(|word| word.parse::<f64>().is_ok())
        });
        let row = row.unwrap_or_else(|| panic!("{}", variant.name()));
        let numbers: Vec<f64> = row.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let s = variant.settings();
        let antiresonance = s.antiresonance_hz().round();
        let gains = [s.position_gain_per_s, s.velocity_gain_per_s, s.velocity_feed_forward];
        let mechanics =
            [s.resonance_hz, antiresonance, 100.0 * s.resonance_damping, s.load_share, 1e3 * s.gear_play_mm];
        assert_eq!(numbers[..8], [mechanics.as_slice(), gains.as_slice()].concat()[..8], "{row}");
    }
}
