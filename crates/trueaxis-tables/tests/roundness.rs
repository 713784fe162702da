//! `[roundness]` of a machine: every key, and every refusal.

use std::fs;
use trueaxis::machine::Axis;
use trueaxis::roundness::{
    Arm, ArmSettings, Band, GaugeSettings, InfeedSettings, ProbeAngles, ProbeSettings, SpindleEncoder,
};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::{Machine, compile, summary};

const MACHINE: &str = "name = \"g\"\nchain = \"w b X Z t\"\n[axis.X]\ntable = \"x.csv\"\n";
const LEAST: &str = "[roundness]\npoints = 1024\nprobe_slots = [188, 667]\nspindle_counts_per_revolution = 3600000\n";

fn read(roundness: &str) -> Result<Machine, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("machine.toml"), format!("{MACHINE}{roundness}")).unwrap();
    fs::write(folder.path().join("x.csv"), "X_mm,EXX_um\n0,1\n10,2\n").unwrap();
    Machine::read(folder.path())
        .map_err(|error| error.to_string().strip_prefix(&error.file.display().to_string()).unwrap().to_owned())
}

#[test]
fn defaults_are_those_stated() {
    let slots = ProbeAngles::Slots { p: 188, q: 667 };
    let least = GaugeSettings::with_defaults(1024, slots, 3_600_000);
    assert_eq!(read(LEAST).unwrap().settings.roundness, Some(least));
    assert_eq!(least.band, Band { first: 2, last: 100 });
    assert_eq!(read("").unwrap().settings.roundness, None);
}

#[test]
fn every_key_arrives_and_survives_compilation() {
    let machine = read(
        "[roundness]\npoints = 512\nprobe_angles_deg = [66.1, 234.5]\nspindle_counts_per_revolution = 8192\n\
         harmonics = [2, 60]\nnoise_gain_limit = 20\nspindle_direction = -1\nspindle_index = false\n\
         spindle_index_tolerance_counts = 4\nstop_s = 0.25\nrevolutions = 5\nunits_per_cycle = 3\nfilter_upr = 50\n\
         probe_gain_um = [1, -2, 3]\nprobe_zero = [0.1, 0.2, 0.3]\nprobe_low = [-1, -2, -3]\nprobe_high = [1, 2, 3]\n\
         [roundness.arm]\ncrank_mm = 45\nwheel_mm = 300\npin_mm = 27.5\ncounts_per_revolution = 40000\n\
         direction = -1\ntolerance_deg = 0.3\n\
         [roundness.infeed]\naxis = \"X\"\ndirection = -1\ngain = 0.2\ndelay_revolutions = 3\ncontact_deg = 175.5\n\
         drive_delay_s = 0.002\nlimit_um = 15\nharmonics = [2, 40]\n",
    )
    .unwrap();
    let probe = |gain_um: f64, zero: f64, reach: f64| ProbeSettings { gain_um, zero, range: [-reach, reach] };
    let expected = GaugeSettings {
        points: 512,
        angles: ProbeAngles::Degrees { phi2: 66.1, phi3: 234.5 },
        band: Band { first: 2, last: 60 },
        noise_gain_limit: 20.0,
        probes: [probe(1.0, 0.1, 1.0), probe(-2.0, 0.2, 2.0), probe(3.0, 0.3, 3.0)],
        spindle: SpindleEncoder { counts: 8192, direction: -1, index: false, index_tolerance: 4 },
        arm: Some(ArmSettings {
            lengths: Arm { crank_mm: 45.0, wheel_mm: 300.0, pin_mm: 27.5 },
            counts: 40_000,
            direction: -1,
            tolerance_deg: 0.3,
        }),
        filter: Some(50),
        revolutions: 5,
        slices_per_cycle: 3,
        stop_s: 0.25,
        infeed: Some(InfeedSettings {
            axis: Axis::X,
            direction: -1,
            band: Band { first: 2, last: 40 },
            gain: 0.2,
            delay_revolutions: 3,
            contact_deg: 175.5,
            drive_delay_s: 0.002,
            limit_um: 15.0,
            noise_gain_limit: 10.0,
        }),
    };
    assert_eq!(machine.settings.roundness, Some(expected));
    let bytes = compile(&machine).unwrap();
    let file = Tcomp::parse(&bytes).unwrap();
    assert_eq!(file.settings().roundness, Some(expected));
    let text = summary(&file).to_string();
    assert!(text.contains("512 points") && text.contains("infeed on X"), "{text}");
}

#[test]
fn errors_name_their_line() {
    let with = |more: &str| format!("{LEAST}{more}");
    let replaced = |from: &str, to: &str| LEAST.replace(from, to);
    let arm = "[roundness.arm]\ncrank_mm = 45\nwheel_mm = 300\npin_mm = 27.5\ncounts_per_revolution = 40000\n";
    let infeed = "[roundness.infeed]\naxis = \"X\"\n";
    for (text, wanted) in [
        (replaced("points = 1024\n", ""), "key roundness.points: found nothing"),
        (replaced("1024", "1000"), ":6: key roundness.points: found 1000, needed a power of two from 64 to 4096"),
        (replaced("1024", "32"), ":6: key roundness.points: found 32"),
        (replaced("1024", "64.5"), ":6: key roundness.points: found 64.5"),
        (replaced("188", "0"), ":7: key roundness.probe_slots: found [0, 667], needed p and q from 1 to N"),
        (replaced("667", "1024"), ":7: key roundness.probe_slots"),
        (replaced("188", "188.5"), ":7: key roundness.probe_slots: found [188.5, 667], needed two whole numbers"),
        (
            replaced("[188, 667]", "[256, 384]"),
            "do not see 7, 9, 15, 17, 23, 25, 31, 33, 39, 41, 47, 49, 55, 57, 63, 65, 71, 73, 79, 81, 87, 89, 95, 97",
        ),
        (replaced("[188, 667]", "[512, 3]"), ":7: key roundness.probe_slots"),
        (with("probe_angles_deg = [1, 2]\n"), ":9: key roundness.probe_angles_deg: found [1, 2], needed either"),
        (replaced("probe_slots = [188, 667]\n", ""), "roundness.probe_slots: found nothing"),
        (
            replaced("3600000", "1000"),
            ":8: key roundness.spindle_counts_per_revolution: found 1000, needed at least as many",
        ),
        (replaced("3600000", "1e12"), ":8: key roundness.spindle_counts_per_revolution"),
        (with("harmonics = [1, 50]\n"), ":9: key roundness.harmonics: found [1, 50], needed 2 or more"),
        (with("harmonics = [2, 512]\n"), ":9: key roundness.harmonics"),
        (with("harmonics = [50, 2]\n"), ":9: key roundness.harmonics"),
        (with("noise_gain_limit = 0\n"), ":9: key roundness.noise_gain_limit"),
        (
            with("filter_upr = 51\n"),
            ":9: key roundness.filter_upr: found 51, needed a cut-off of 15, 50, 150 or 500 UPR",
        ),
        (with("spindle_direction = 2\n"), ":9: key roundness.spindle_direction: found 2, needed 1 or -1"),
        (with("spindle_index = 1\n"), ":9: key roundness.spindle_index: found 1, needed true or false"),
        (with("spindle_index_tolerance_counts = 900000\n"), ":9: key roundness.spindle_index_tolerance_counts"),
        (with("revolutions = 0\n"), ":9: key roundness.revolutions"),
        (with("units_per_cycle = 17\n"), ":9: key roundness.units_per_cycle"),
        // The same value in another key of the field, where it is valid.
        (with("revolutions = 17\nunits_per_cycle = 17\n"), ":10: key roundness.units_per_cycle: found 17, needed"),
        (with("stop_s = 0\n"), ":9: key roundness.stop_s"),
        (with("probe_gain_um = [1, 0, 1]\n"), ":9: key roundness.probe_gain_um"),
        // A missing key: the line of its section.
        (with("probe_low = [0, 0, 2000]\n"), ":5: key roundness.probe_high: found "),
        (with("probe_low = [0, 0, 2000]\n"), ", the default, needed a range from low to high"),
        (with("probes = 3\n"), ":9: key roundness.probes: found probes, needed one of"),
        (
            with(&arm.replace("45", "327.5")),
            ":10: key roundness.arm.crank_mm: found 327.5, needed a crank throw R below",
        ),
        (with(&arm.replace("300", "-1")), ":11: key roundness.arm.wheel_mm"),
        (with(&arm.replace("pin_mm = 27.5\n", "")), "roundness.arm.pin_mm: found nothing"),
        (with(&format!("{infeed}gain = 0.4\n")), ":11: key roundness.infeed.gain: found 0.4, needed a gain above 0"),
        (with(&infeed.replace('X', "Y")), ":10: key roundness.infeed.axis: found \"Y\", needed an axis of the machine"),
        (with(&infeed.replace('X', "U")), ":10: key roundness.infeed.axis: found \"U\", needed an axis"),
        (
            with(&format!("{infeed}limit_um = 150\n")),
            ":11: key roundness.infeed.limit_um: found 150, needed a limit within",
        ),
        (
            with(&format!("{infeed}harmonics = [1, 50]\n")),
            ":11: key roundness.infeed.harmonics: found [1, 50], needed 2 or more",
        ),
        (
            with(&format!("{infeed}harmonics = [2, 101]\n")),
            ":11: key roundness.infeed.harmonics: found [2, 101], needed harmonics within those",
        ),
        (with(&format!("{infeed}drive_delay_s = 0.2\n")), ":11: key roundness.infeed.drive_delay_s"),
        (with("filter_upr = 0\n"), ":9: key roundness.filter_upr: found 0"),
        (with("filter_upr = 65535\n"), ":9: key roundness.filter_upr: found 65535"),
        (
            with(&arm.replace("45", "326")),
            ":10: key roundness.arm.crank_mm: found 326, needed a crank throw R of at most 0.99",
        ),
        (
            with(&format!("{infeed}harmonics = [2, 129]\n")),
            ":11: key roundness.infeed.harmonics: found [2, 129], needed harmonics up to N/8",
        ),
    ] {
        let error = read(&text).unwrap_err();
        assert!(error.contains(wanted), "{text}\nfound  {error}\nneeded {wanted}");
    }
}
