//! Settings as TOML: round trip, refusals with their lines, ranges.

use trueaxis_sim::Settings;
use trueaxis_sim::plant::drive::{DriveSettings, Variant};

#[test]
fn written_settings_are_read_back() {
    let mut settings = Settings::default();
    assert_eq!(Settings::parse(&settings.to_toml(), "a.toml"), Ok(settings.clone()));
    assert_eq!(Settings::parse("", "a.toml"), Ok(settings.clone()));
    assert!(settings.changes().is_empty());
    for (key, value) in [
        ("rate_hz", "4000"),
        ("seed", "9223372036854775807"),
        ("temperature_c", "23.5"),
        ("origin_mm", "[1, -2.5, 3.0]"),
        ("faults", "[\"glitch:Y@0.5s+1=5mm\", \"late@3s+1=2.5\"]"),
        ("events", "[\"off:correction@0.5s\", \"exchange:../warm@1.25s\", \"on:lag@3s\"]"),
        ("motion.feed_percent", "80"),
        ("drive.dead_time_s", "1e-3"),
        ("encoder.rotary.noise_rms_mm", "0.0"),
        ("axis.C.lost_motion_mm", "0.1"),
    ] {
        settings.set(key, value).unwrap();
    }
    assert_eq!(settings.changes().len(), 10, "{:?}", settings.changes());
    assert!(settings.changes().contains(&("drive.dead_time_s".into(), "0.001".into(), "0.0".into())));
    assert_eq!(Settings::parse(&settings.to_toml(), "a.toml"), Ok(settings));
}

#[test]
fn a_text_changes_only_what_it_states() {
    let text = "rate_hz = 4000\n[drive]\nposition_gain_per_s = 90\n[encoder.rotary]\nnoise_rms_mm = 1e-4\n";
    let mut expected = Settings { rate_hz: 4000.0, ..Settings::default() };
    expected.drive.position_gain_per_s = 90.0;
    expected.encoder.rotary.noise_rms_mm = 1e-4;
    assert_eq!(Settings::parse(text, "a.toml"), Ok(expected));
}

#[test]
fn refusals_name_file_line_key_and_what_is_needed() {
    for (text, expected) in [
        ("seed = 1\ngain = 3\n", "a.toml:2: gain: found no such setting, needed one of axis, drive, encoder, events"),
        ("[drive]\n\ngain = 3\n", "a.toml:3: drive.gain: found no such setting, needed one of coulomb_mm_per_s2"),
        ("[axis.U]\ngain_factor = 1\n", "a.toml:1: axis.U: found no such setting, needed one of A, B, C, X, Y, Z"),
        ("rate_hz = \"fast\"", "a.toml:1: rate_hz: found \"fast\", needed a number"),
        ("seed = 1.5", "a.toml:1: seed: found 1.5, needed a whole number"),
        ("seed = -1", "a.toml:1: seed: found -1, needed a whole number from 0"),
        ("drive = 3", "a.toml:1: drive: found 3, needed a table of"),
        ("rate_hz = 50", "a.toml:1: rate_hz: found 50, needed 100 to 100000 Hz"),
        ("[motion]\nfeed_percent = 0\n", "a.toml:2: motion.feed_percent: found 0, needed 1 to 1000 %"),
        (
            "[encoder.linear]\nresolution_mm = nan\n",
            "a.toml:2: encoder.linear.resolution_mm: found NaN, needed 1e-9 to 1 mm",
        ),
        ("drive.dead_time_s = -1e-3", "a.toml:1: drive.dead_time_s: found -0.001, needed 0 to 0.1 s"),
        ("faults = [\"vanish:X@1s+1\"]", "a.toml:1: faults: found"),
        (
            "seed = 1\nevents = [\"\"\"ex\nch@1s\"\"\"]",
            "a.toml:2: events: found [\"\"\"\\nex\\nch@1s\"\"\"], needed event",
        ),
        (
            "faults = [\"late@3s+1=2.5\"]\n\nevents = [\"off:brakes@1s\"]",
            "a.toml:3: events: found [\"off:brakes@1s\"], needed event \"off:brakes@1s\": found \"brakes\"",
        ),
        ("events = [1]", "a.toml:1: events: found [1], needed"),
        ("origin_mm = [1, 2]", "a.toml:1: origin_mm: found"),
        ("temperature_c = 900", "a.toml:1: temperature_c: found 900, needed -50 to 200 °C"),
        ("[drive\n", "a.toml:1: found"),
        (
            "[drive]\nvariant = \"sotf\"\n",
            "a.toml:2: drive.variant: found \"sotf\", needed soft, or another of stiff, usual, soft, worn",
        ),
        ("drive.variant = 3", "a.toml:1: drive.variant: found 3, needed one of stiff, usual, soft, worn"),
        (
            "[axis.Y]\ndrive = \"old\"",
            "a.toml:2: axis.Y.drive: found \"old\", needed one of common, stiff, usual, soft",
        ),
        ("axis.Y.drive = 1", "a.toml:1: axis.Y.drive: found 1, needed one of common, stiff, usual, soft, worn"),
        (
            "drive.resonanc_hz = 9",
            "a.toml:1: drive.resonanc_hz: found no such setting, needed resonance_hz, or another of",
        ),
        (
            "drive.scale_at = \"laod\"",
            "a.toml:1: drive.scale_at: found \"laod\", needed load, or another of motor, load",
        ),
        ("drive.resonance_hz = -1", "a.toml:1: drive.resonance_hz: found -1, needed 0 to 2000 Hz"),
        ("drive.load_share = 1", "a.toml:1: drive.load_share: found 1, needed 0.05 to 0.95"),
        ("drive.resonance_damping = 1", "a.toml:1: drive.resonance_damping: found 1, needed 0 to 0.9 of critical"),
        ("drive.gear_play_mm = nan", "a.toml:1: drive.gear_play_mm: found NaN, needed 0 to 1 mm"),
        ("drive.torque_ripple_mm_per_s2 = -2", "a.toml:1: drive.torque_ripple_mm_per_s2: found -2, needed 0 to"),
        ("drive.ripple_period_mm = 0", "a.toml:1: drive.ripple_period_mm: found 0, needed 0.001 to 1000 mm"),
    ] {
        let error = Settings::parse(text, "a.toml").unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}\nneeded {expected}");
    }
    let mut settings = Settings::default();
    assert_eq!(settings.set("jerk", "1").unwrap_err().file, None);
    assert!(settings.set("motion.jerk_mm_per_s3", "").is_err());
    assert_eq!(settings, Settings::default());
}

#[test]
fn drives_that_do_not_agree_with_themselves_or_the_servo_rate_are_refused() {
    for (text, expected) in [
        (
            "[drive]\nresonance_hz = 90\nresonance_damping = 0\n",
            "a.toml:3: drive.resonance_damping: found 0, needed 0.002 to 0.9 of critical with a resonance_hz of 90",
        ),
        (
            "rate_hz = 200\ndrive.resonance_hz = 120",
            "a.toml:2: drive.resonance_hz: found 120, needed 0 (rigid) or 1 to 100 Hz, half the servo rate at most",
        ),
        ("drive.resonance_hz = 0.5", "a.toml:1: drive.resonance_hz: found 0.5, needed 0 (rigid) or 1 to 2000 Hz"),
        (
            "drive.gear_play_mm = 0.005",
            "a.toml:1: drive.gear_play_mm: found 0.005, needed 0 with the rigid drive of resonance_hz = 0, or a resonance_hz",
        ),
        (
            "drive.scale_at = \"load\"",
            "a.toml:1: drive.scale_at: found \"load\", needed \"motor\" with the rigid drive of resonance_hz = 0",
        ),
        (
            "drive.torque_ripple_mm_per_s2 = 500\ndrive.force_limit_mm_per_s2 = 400",
            "a.toml:1: drive.torque_ripple_mm_per_s2: found 500, needed less than force_limit_mm_per_s2, 400",
        ),
        (
            "rate_hz = 400\n[axis.Z]\ndrive = \"stiff\"",
            "a.toml:3: axis.Z.drive: found \"stiff\" with its resonance_hz of 250, needed 0 (rigid) or 1 to 200 Hz",
        ),
    ] {
        let error = Settings::parse(text, "a.toml").unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}\nneeded {expected}");
    }
    // One by one, in any order; the whole is checked.
    let mut settings = Settings::default();
    settings.set("drive.gear_play_mm", "0.005").unwrap();
    assert!(settings.check().is_err());
    settings.set("drive.resonance_hz", "90").unwrap();
    assert_eq!(settings.check(), Ok(()));
}

#[test]
fn a_variant_stands_for_its_figures_and_is_read_back() {
    for variant in Variant::ALL {
        let text = format!("[drive]\ncoulomb_mm_per_s2 = 300\nvariant = \"{}\"\n", variant.name());
        let settings = Settings::parse(&text, "a.toml").unwrap();
        assert_eq!(settings.drive, DriveSettings { coulomb_mm_per_s2: 300.0, ..variant.settings() });
        assert_eq!(Settings::parse(&settings.to_toml(), "a.toml"), Ok(settings));
    }
    let settings =
        Settings::parse("[axis.Y]\ndrive = \"worn\"\ngain_factor = 2\nfriction_factor = 1\n", "a.toml").unwrap();
    assert_eq!(Settings::parse(&settings.to_toml(), "a.toml"), Ok(settings.clone()));
    let worn = Variant::Worn.settings();
    let drives = settings.plant(0.0).drives;
    assert_eq!(drives[0], DriveSettings::default());
    assert_eq!(drives[1].position_gain_per_s, 2.0 * worn.position_gain_per_s);
    assert_eq!(drives[1].gear_play_mm, worn.gear_play_mm);
}
