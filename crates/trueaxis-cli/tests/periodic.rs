//! `trueaxis periodic` as called.

use std::f64::consts::TAU;
use std::fmt::Write;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// A machine whose X has a slow error and two periods, the longer one different in the two directions.
fn machine(folder: &Folder, name: &str, chain: &str, periods: &str) {
    folder.write(
        format!("{name}/machine.toml"),
        format!(
            "name = \"screws\"\nchain = \"{chain}\"\n\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [0.0, 400.0]\nbacklash_um = 3.0\n\
             {periods}\n[axis.Y]\ntravel_mm = [0.0, 300.0]\n\n[axis.Z]\ntravel_mm = [0.0, 200.0]\n"
        ),
    );
    folder.write(format!("{name}/x.csv"), "X_mm,EXX_um\n0,0\n80,4\n160,3\n240,9\n320,5\n400,6\n");
}

const PERIODS: &str = "\n[[axis.X.periodic]]\nperiod_mm = 5.0\nharmonics_um = [[1.9, -0.4], [0.3, 0.2]]\n\
                       reverse_um = [[1.4, -0.6], [0.3, 0.2]]\n\n[[axis.X.periodic]]\nperiod_mm = 1.25\n\
                       harmonics_um = [[0.2, 0.15]]\n";

fn near(found: &serde_json::Value, truth: [f64; 2], within: f64) {
    for (c, truth) in truth.into_iter().enumerate() {
        assert!((found[c].as_f64().unwrap() - truth).abs() < within, "{found} for {truth}");
    }
}

/// The plant's exact transforms make the record; tool and workpiece carried by the axis.
#[test]
fn a_rehearsal_finds_the_periods_of_the_true_machine() {
    let folder = Folder::new(TRUEAXIS);
    for (name, chain) in [("tool", "w Y' b X Z t"), ("table", "w X' Y' b Z t")] {
        machine(&folder, name, chain, PERIODS);
        folder.good(&[
            "periodic",
            "simulate",
            "--machine",
            name,
            "--axis",
            "X",
            "--drift-um-per-h",
            "3",
            "-o",
            "scan.csv",
        ]);
        let found = folder.json(&[
            "periodic",
            "scan.csv",
            "--axis",
            "X",
            "--period-mm",
            "5",
            "--period-mm",
            "1.25",
            "--json",
            "--report",
            "out",
        ]);
        let [long, short] = [0, 1].map(|k| &found["periods"][k]);
        near(&long["harmonics"][0], [1.9, -0.4], 0.03);
        near(&long["harmonics"][1], [0.3, 0.2], 0.03);
        near(&long["reverse"][0], [1.4, -0.6], 0.03);
        near(&short["harmonics"][0], [0.2, 0.15], 0.03);
        assert!(short["reverse"].is_null() && found["explained"].as_f64().unwrap() > 0.95, "{found}");
        assert!((found["left"].as_f64().unwrap() - 0.1).abs() < 0.01 && found["remains"].is_null(), "{found}");
        let page = std::fs::read_to_string(folder.join("out/periodic.html")).unwrap();
        assert!(page.contains("Period of 5 mm, negative travel") && !page.contains("nothing to draw"));
    }
}

/// Found on a machine that does not state them, written, and gone in the next scan, which the machine corrects.
#[test]
fn found_periods_are_written_and_correct_the_machine() {
    let folder = Folder::new(TRUEAXIS);
    machine(&folder, "true", "w Y' b X Z t", PERIODS);
    machine(&folder, "mill", "w Y' b X Z t", "");
    let scan = |seed: &str, more: &[&str]| {
        let all = ["periodic", "simulate", "--machine", "true", "--axis", "X", "--seed", seed, "-o", "scan.csv"];
        folder.good(&[&all, more].concat());
    };
    let evaluate = |more: &[&str]| {
        let all = ["periodic", "scan.csv", "--axis", "X", "--period-mm", "5", "--period-mm", "1.25", "--json"];
        folder.json(&[&all, more].concat())
    };
    scan("1", &[]);
    let done = evaluate(&["-o", "mill", "--dry-run"]);
    assert_eq!(done["written"][0]["why"], "nothing is stated");
    assert!(!std::fs::read_to_string(folder.join("mill/machine.toml")).unwrap().contains("periodic"));
    evaluate(&["-o", "mill"]);
    let text = std::fs::read_to_string(folder.join("mill/machine.toml")).unwrap();
    assert!(
        text.contains("[[axis.X.periodic]]") && text.contains("standard_uncertainty_um") && text.contains("records"),
        "{text}"
    );
    assert!(text.contains("backlash_um = 3.0"), "{text}");
    // The same record again changes nothing; another one becomes a mean with half the weight.
    let again = evaluate(&["-o", "mill"]);
    assert_eq!(again["written"][0]["why"], "agrees: this record is already included");
    scan("2", &[]);
    let mean = evaluate(&["-o", "mill"]);
    assert_eq!(mean["written"][0]["why"], "agrees: weighted mean of both");
    let [one, both] = [&again["written"][0]["old"], &mean["written"][0]["written"]];
    let ratio = both["uncertainty"].as_f64().unwrap() / one["uncertainty"].as_f64().unwrap();
    assert!((0.6..0.82).contains(&ratio), "{one} {both}");
    scan("3", &["--corrected-by", "mill"]);
    let left = evaluate(&[]);
    for period in left["periods"].as_array().unwrap() {
        assert!(period["peak_to_valley"][0].as_f64().unwrap() < 0.1, "{period}");
    }
}

/// A scan in positive travel says nothing of the other direction, whose stated harmonics stay.
#[test]
fn a_direction_that_was_not_travelled_keeps_its_harmonics() {
    let folder = Folder::new(TRUEAXIS);
    machine(&folder, "true", "w Y' b X Z t", PERIODS);
    machine(&folder, "mill", "w Y' b X Z t", &PERIODS.replace("1.9, -0.4", "0.5, 0.0"));
    folder.good(&["periodic", "simulate", "--machine", "true", "--axis", "X", "--one-way", "-o", "scan.csv"]);
    folder.good(&["periodic", "scan.csv", "--axis", "X", "--period-mm", "5", "--period-mm", "1.25", "-o", "mill"]);
    let text = folder.read("mill/machine.toml");
    assert!(text.contains("reverse_um = [[1.4, -0.6], [0.3, 0.2]]") && !text.contains("0.5, 0.0"), "{text}");
}

/// `--harmonics 1` says nothing of the second, which stays in both directions.
#[test]
fn a_harmonic_that_was_not_tried_keeps_its_value() {
    let folder = Folder::new(TRUEAXIS);
    machine(&folder, "true", "w Y' b X Z t", "\n[[axis.X.periodic]]\nperiod_mm = 5.0\nharmonics_um = [[1.9, -0.4]]\n");
    for (reverse, kept) in [("", ""), ("reverse_um = [[0.5, 0.0], [0.0, 0.75]]\n", "[0.0, 0.75]]")] {
        let stated = "\n[[axis.X.periodic]]\nperiod_mm = 5.0\nharmonics_um = [[0.5, 0.0], [0.25, 0.375]]\n";
        machine(&folder, "mill", "w Y' b X Z t", &format!("{stated}{reverse}"));
        folder.good(&["periodic", "simulate", "--machine", "true", "--axis", "X", "-o", "scan.csv"]);
        let scan = ["periodic", "scan.csv", "--axis", "X", "--period-mm", "5", "--harmonics", "1"];
        folder.good(&[&scan[..], &["-o", "mill"]].concat());
        let text = folder.read("mill/machine.toml");
        assert!(text.contains("[0.25, 0.375]]") && text.contains(kept) && !text.contains("[0.5, 0.0]"), "{text}");
        assert_eq!(text.contains("reverse_um"), !reverse.is_empty(), "{text}");
    }
}

/// A stated error of 3 µm that a scan does not find becomes zero, with its uncertainty; without a stated one nothing is added.
#[test]
fn a_stated_period_that_is_not_found_becomes_zero() {
    let folder = Folder::new(TRUEAXIS);
    machine(&folder, "true", "w Y' b X Z t", "");
    machine(&folder, "mill", "w Y' b X Z t", "\n[[axis.X.periodic]]\nperiod_mm = 5.0\nharmonics_um = [[3.0, 0.0]]\n");
    folder.good(&["periodic", "simulate", "--machine", "true", "--axis", "X", "-o", "scan.csv"]);
    let scan = ["periodic", "scan.csv", "--axis", "X", "--period-mm", "5", "--json", "-o"];
    let done = folder.json(&[&scan[..], &["mill"]].concat());
    let value = |which: &str| done["written"][0][which]["value"].as_f64();
    assert_eq!([value("old"), value("written")], [Some(3.0), Some(0.0)], "{done}");
    let text = folder.read("mill/machine.toml");
    assert!(text.contains("harmonics_um = [[0.0, 0.0]]") && text.contains("standard_uncertainty_um"), "{text}");
    machine(&folder, "bare", "w Y' b X Z t", "");
    for force in [&[][..], &["--force"]] {
        let done = folder.json(&[&scan[..], &["bare"], force].concat());
        assert!(done["written"][0]["written"].is_null(), "{done}");
        assert!(!folder.read("bare/machine.toml").contains("periodic"));
    }
}

/// What another section of the axis states would be corrected twice.
#[test]
fn a_stated_period_that_the_record_does_not_tell_from_a_found_one_is_refused() {
    let folder = Folder::new(TRUEAXIS);
    let stated = |period: &str, harmonics: &str| {
        format!("\n[[axis.X.periodic]]\nperiod_mm = {period}\nharmonics_um = {harmonics}\n")
    };
    let fourth = stated("5.0", "[[1.9, 0.0], [0.0, 0.0], [0.0, 0.0], [0.5, 0.0]]");
    machine(&folder, "true", "w Y' b X Z t", &fourth);
    folder.good(&["periodic", "simulate", "--machine", "true", "--axis", "X", "-o", "scan.csv"]);
    let scan =
        |more: &[&'static str]| [&["periodic", "scan.csv", "--axis", "X", "-o", "mill", "--period-mm"], more].concat();
    for (periods, with, refused) in [
        (stated("1.25", "[[0.25, 0.0]]"), &["5"][..], "needed both evaluated together: give --period-mm 1.25 too"),
        (stated("1.25", "[[0.25, 0.0]]"), &["5", "--period-mm", "1.25"][..], ""),
        (stated("1.25", "[[0.25, 0.0]]"), &["5", "--compensated"][..], ""),
        (stated("1.3", "[[0.25, 0.0]]"), &["5"][..], ""),
        (fourth, &["5", "--period-mm", "1.25"][..], "needed zero for it"),
        (
            stated("5.004", "[[0.25, 0.0]]"),
            &["5"][..],
            "found a period of 5 mm, needed 5.004 mm, which [[axis.X.periodic]]",
        ),
        (stated("5.0001", "[[0.25, 0.0]]"), &["5"][..], ""),
    ] {
        machine(&folder, "mill", "w Y' b X Z t", &periods);
        if refused.is_empty() {
            folder.good(&scan(with));
        } else {
            let error = folder.bad(&scan(with), &[]);
            assert!(error.contains(refused), "{error}");
        }
    }
    let text = folder.read("mill/machine.toml");
    assert_eq!(text.matches("period_mm").count(), 1, "{text}");
}

/// The machine's noise of lengths does not judge angles: a wave that is left, small beside what is explained, is no misfit.
#[test]
fn an_angle_is_not_compared_with_the_noise_of_a_length() {
    let folder = Folder::new(TRUEAXIS);
    let record = |left: f64| {
        scan(0.5, 721, "position_deg,error_urad", |q| {
            format!("{q},{:.4}", 8.0 * (TAU * q / 4.0).sin() + left * (TAU * q / 2.7).sin() + 0.05 * (77.0 * q).sin())
        })
    };
    let written = |left: f64| {
        folder.write("worm.csv", record(left));
        folder.write(
            "mill/machine.toml",
            "name = \"table\"\nchain = \"w C' X' Y' b Z t\"\n\n[axis.X]\ntravel_mm = [0.0, 400.0]\n\n[axis.Y]\n\
             travel_mm = [0.0, 300.0]\n\n[axis.Z]\ntravel_mm = [0.0, 200.0]\n\n[axis.C]\ntravel_deg = [0.0, 360.0]\n\n\
             [uncertainty]\neve_um = 0.1\n",
        );
        let scan = ["periodic", "worm.csv", "--axis", "C", "--period-deg", "4", "--json", "-o", "mill", "--dry-run"];
        folder.json(&scan)["written"][0].clone()
    };
    assert_eq!(written(2.0)["why"], "nothing is stated");
    let misfit = written(12.0);
    assert!(misfit["written"].is_null() && misfit["why"].as_str().unwrap().contains("µrad RMS remain"), "{misfit}");
}

/// A record that the squareness or another axis comes from says something new of this axis.
#[test]
fn a_record_counts_for_each_axis_by_itself() {
    let folder = Folder::new(TRUEAXIS);
    let record = scan(0.2, 1000, "position_mm,error_um", |q| {
        format!("{q:.1},{:.4}", (TAU * q / 5.0).cos() + 0.05 * (9.0 * q).sin())
    });
    folder.write("scan.csv", record);
    let period = |axis: char| {
        format!(
            "\n[[axis.{axis}.periodic]]\nperiod_mm = 5.0\nharmonics_um = [[1.0, 0.0]]\nstandard_uncertainty_um = 0.01\n"
        )
    };
    machine(&folder, "mill", "w Y' b X Z t", &(period('X') + &period('Y')));
    let why = |axis: &str| {
        let scan =
            ["periodic", "scan.csv", "--axis", axis, "--period-mm", "5", "--harmonics", "1", "--json", "-o", "mill"];
        folder.json(&scan)["written"][0]["why"].as_str().unwrap().to_owned()
    };
    assert_eq!(why("X"), "agrees: weighted mean of both");
    assert_eq!(why("Y"), "agrees: weighted mean of both");
    assert_eq!(why("X"), "agrees: this record is already included");
}

/// Options that only mean something for a machine to write are refused without one.
#[test]
fn options_of_writing_need_a_machine_to_write() {
    let folder = Folder::new(TRUEAXIS);
    machine(&folder, "mill", "w Y' b X Z t", "");
    folder.write(
        "scan.csv",
        scan(0.2, 300, "position_mm,error_um", |q| format!("{q:.1},{:.4}", 0.1 * (9.0 * q * q).sin())),
    );
    let all = ["periodic", "scan.csv", "--axis", "X", "--period-mm", "5"];
    for more in [&["--compensated"][..], &["--machine", "mill"]] {
        let error = folder.bad(&[&all[..], more].concat(), &[]);
        assert!(error.contains("--output") && error.contains("--dry-run"), "{error}");
    }
    folder.good(&[&all[..], &["--machine", "mill", "--compensated", "--dry-run"]].concat());
    let text = folder.good(&all);
    assert!(
        text.contains("no harmonic above") && text.contains("unless the machine states reverse_um for it"),
        "{text}"
    );
}

#[test]
fn what_is_written_needs_a_machine_and_a_coarse_table() {
    let folder = Folder::new(TRUEAXIS);
    machine(&folder, "mill", "w Y' b X Z t", "");
    machine(&folder, "true", "w Y' b X Z t", PERIODS);
    folder.good(&["periodic", "simulate", "--machine", "true", "--axis", "X", "--one-way", "-o", "scan.csv"]);
    let refused = |more: &[&str]| folder.bad(&[&["periodic", "scan.csv", "--axis", "X"], more].concat(), &[]);
    assert!(refused(&["--period-mm", "5", "--dry-run"]).contains("--dry-run: found no machine"));
    let rows: String = (0..=200).fold(String::from("X_mm,EXX_um\n"), |mut text, k| {
        let _ = writeln!(text, "{},{}", 2 * k, (0.7 * f64::from(k)).sin());
        text
    });
    folder.write("mill/x.csv", rows);
    let fine = refused(&["--period-mm", "5", "-o", "mill"]);
    assert!(fine.contains("found a table of axis X with points 2 mm apart, needed 2.5 mm at least"), "{fine}");
}

fn scan(step: f64, count: u32, head: &str, row: impl Fn(f64) -> String) -> String {
    (0..count).fold(format!("{head}\n"), |mut text, k| {
        let _ = writeln!(text, "{}", row(step * f64::from(k)));
        text
    })
}

#[test]
fn records_that_determine_nothing_are_refused_with_what_is_needed() {
    let folder = Folder::new(TRUEAXIS);
    let wave = |q: f64| (TAU * q / 5.0).cos() + 0.1 * (9.0 * q).sin();
    folder.write("fine.csv", scan(0.2, 300, "position_mm,error_um", |q| format!("{q:.1},{:.4}", wave(q))));
    folder.write("coarse.csv", scan(5.0, 30, "position_mm,error_um", |q| format!("{q},{:.4}", wave(q) + 0.01 * q)));
    let refused = |record: &str, more: &[&str]| folder.bad(&[&["periodic", record, "--axis", "X"], more].concat(), &[]);
    let coarse = refused("coarse.csv", &["--period-mm", "5"]);
    let aliased = "coarse.csv: found points every 5 mm, at which harmonic 1 of the period 5 mm looks like a constant, \
                   needed points every 1.25 mm at most";
    assert!(coarse.contains(aliased), "{coarse}");
    assert!(refused("fine.csv", &["--period-mm", "25"]).contains("needed 75 mm at least, three periods of 25 mm"));
    let close = refused("fine.csv", &["--period-mm", "5", "--period-mm", "5.1"]);
    assert!(close.contains("needed 255 mm at least to separate them"), "{close}");
    assert!(refused("fine.csv", &["--period-mm", "-5"]).contains("--period-mm: found -5, needed 0.001 to 100000 mm"));
    assert!(refused("fine.csv", &["--period-deg", "5"]).contains("--period-deg: found axis X, needed --period-mm"));
    assert!(
        refused("fine.csv", &["--period-mm", "5", "--harmonics", "9"]).contains("found 9 harmonics, needed 1 to 6")
    );
    let circle = ["--period-mm", "5", "--radius-mm", "100", "--centre-mm", "0,0,0"];
    assert!(refused("fine.csv", &circle).contains("needed the columns angle_deg, deviation_um, direction"));
    folder.write("zero.csv", "position_mm,error_um,direction\n0,1,fwd\n1,2,0\n");
    let zero = refused("zero.csv", &["--period-mm", "5"]);
    assert!(zero.contains("zero.csv:3: column direction: found 0, needed 1, + or fwd"), "{zero}");
    folder.write("other.csv", "position_mm,fwd_um\n0,1\n");
    let other = refused("other.csv", &["--period-mm", "5"]);
    assert!(other.contains("needed the columns position_mm, error_um, or position_mm, fwd_um, rev_um; for"), "{other}");
}

/// The order of the rows is the direction of travel where no column states it.
#[test]
fn a_falling_scan_is_negative_travel() {
    let folder = Folder::new(TRUEAXIS);
    let wave = |q: f64| (TAU * q / 5.0).cos() + 0.05 * (9.0 * q).sin();
    let falling = scan(0.2, 300, "position_mm,error_um", |q| format!("{:.1},{:.4}", 60.0 - q, wave(60.0 - q)));
    folder.write("falling.csv", &falling);
    folder.write("both.csv", scan(0.2, 300, falling.trim_end(), |q| format!("{q:.1},{:.4}", wave(q))));
    machine(&folder, "mill", "w Y' b X Z t", PERIODS.split("\n[[axis.X.periodic]]\nperiod_mm = 1.25").next().unwrap());
    let all = ["--axis", "X", "--period-mm", "5", "--force", "-o", "mill"];
    folder.good(&[&["periodic", "falling.csv"], &all[..]].concat());
    let text = folder.read("mill/machine.toml");
    assert!(text.contains("\nharmonics_um = [[1.9, -0.4], [0.3, 0.2]]") && !text.contains("1.4, -0.6"), "{text}");
    let both = folder.bad(&[&["periodic", "both.csv"], &all[..]].concat(), &[]);
    assert!(
        both.contains("both.csv:303: column position_mm: found 0.2") && both.contains("needed a column direction"),
        "{both}"
    );
}

/// A rotary axis, both directions in columns.
#[test]
fn a_worm_is_found_in_two_columns() {
    let folder = Folder::new(TRUEAXIS);
    let wave = |q: f64, sense: f64| 8.0 * (TAU * q / 4.0).sin() + sense + 0.05 * (77.0 * q + sense).sin();
    let text =
        scan(0.5, 721, "position_deg,fwd_urad,rev_urad", |q| format!("{q},{:.4},{:.4}", wave(q, 2.0), wave(q, -2.0)));
    folder.write("worm.csv", text);
    let found = folder.json(&["periodic", "worm.csv", "--axis", "C", "--period-deg", "4", "--json"]);
    near(&found["periods"][0]["harmonics"][0], [0.0, 8.0], 0.02);
    assert!(found["periods"][0]["reverse"].is_null() && found["unit"] == "deg" && found["error_unit"] == "urad");
    let text = folder.good(&["periodic", "worm.csv", "--axis", "C", "--period-deg", "4"]);
    assert!(text.contains("µrad peak to valley repeat within 4 deg"), "{text}");
}

/// A ballbar on the exact machine: the chirp gives the same harmonics as the scan.
#[test]
fn a_ballbar_finds_the_periods_of_both_axes() {
    let folder = Folder::new(TRUEAXIS);
    machine(&folder, "true", "w Y' b X Z t", PERIODS.split("\n[[axis.X.periodic]]\nperiod_mm = 1.25").next().unwrap());
    folder.good(&[
        "ballbar",
        "simulate",
        "--machine",
        "true",
        "--radius-mm",
        "120",
        "--readings",
        "3600",
        "--centre-mm",
        "200,150,100",
        "-o",
        "circle.csv",
    ]);
    let found = folder.json(&[
        "periodic",
        "circle.csv",
        "--axis",
        "X",
        "--period-mm",
        "5",
        "--harmonics",
        "2",
        "--radius-mm",
        "120",
        "--centre-mm",
        "200,150,100",
        "--json",
    ]);
    near(&found["periods"][0]["harmonics"][0], [1.9, -0.4], 0.06);
    near(&found["periods"][0]["reverse"][0], [1.4, -0.6], 0.06);
}
