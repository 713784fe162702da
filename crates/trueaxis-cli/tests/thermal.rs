//! `trueaxis thermal` as called: a machine whose growth follows its one sensor, found and compiled, and every refusal.

use std::fmt::Write;
use trueaxis::temperature::{Readings, Thermal, ThermalState};
use trueaxis_testing::command::Folder;
use trueaxis_testing::covariance::{at, check};

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// Four cycles of 4 h, a row every 5 min at two positions of X. X grows by 12 µm/(m K) from 0 on, Z by 3 µm/K, both without
/// lag; the second sensor is unrelated to the growth.
fn record() -> String {
    let mut text = String::from("t_s,cycle,x_mm,ex_um,ez_um,T1_c,T2_c\n");
    for row in 0..192_u32 {
        let t = 300.0 * f64::from(row);
        let warm = 6.0 * (t / 7_000.0).sin() + 3.0 * (t / 2_300.0).cos();
        for x in [0.0, 250.0] {
            let (ex, ez) = (0.012 * warm * x, 3.0 * warm);
            let noise = 0.05 * (f64::from(row) * 12.9898 + x).sin();
            let other = 20.0 + 2.0 * (t / 1_234.0).sin();
            writeln!(text, "{t},{},{x},{},{},{:.3},{other:.3}", row / 48, ex + noise, ez - noise, 20.0 + warm).unwrap();
        }
    }
    text
}

const MACHINE: &str = "name = \"mill\"\nchain = \"w X' Y' b Z t\"\n\n[axis.X]\ntable = \"x.csv\"\n";
const TABLE: &str = "X_mm,EXX_um\n-300,0\n300,3\n";

#[test]
fn growth_is_found_compiled_and_read_by_the_task() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record());
    folder.write("machine.toml", MACHINE);
    folder.write("x.csv", TABLE);
    let found = folder.json(&[
        "thermal",
        "fit",
        "record.csv",
        "--machine",
        ".",
        "--json",
        "--report",
        "out",
        "-o",
        "thermal.toml",
    ]);
    assert_eq!(found["sensors"].as_array().unwrap().len(), 1, "{}", found["sensors"]);
    assert!(found["left_out"].as_array().unwrap().iter().any(|out| out["name"] == "T2"));
    let [drift, left] = [0, 1].map(|k| found["held_out_um"][k].as_f64().unwrap());
    assert!(drift > 15.0 && left < 0.3, "{left} of {drift} µm");
    let names = check(&found["covariance"], |name| {
        let (letter, (of, rest)) =
            name.split_once('.').map(|(letter, rest)| (letter, rest.split_once('.').unwrap())).unwrap();
        let (key, place) = rest.split_once('[').unwrap();
        let of_axis = found["axes"].as_array().unwrap().iter().find(|own| own["axis"] == letter).unwrap();
        let curve = of_axis["curves"].as_array().unwrap().iter().find(|own| own["of"] == of).unwrap();
        let error = format!("{}_error{}[{place}", key.trim_end_matches("_um"), if key == "slope" { "" } else { "_um" });
        [at(curve, rest), at(curve, &error)]
    });
    // X at two positions and Z; the ends of a straight curve are one unknown.
    assert!(names.contains(&"X.T1.slope[0]".into()) && names.contains(&"Z.T1.offset_um[1]".into()), "{names:?}");
    let page = folder.read("out/thermal.html");
    assert!(page.contains("Thermal growth") && page.contains("took no part in the fit"));
    let text = folder.read("thermal.toml");
    assert!(text.contains("[axis.X.sensor.T1]") && text.contains("slope_um_per_m"), "{text}");
    // The noise of 0.05 µm, against the noise of the row at which the cycle begins.
    let left =
        text.lines().find_map(|line| line.strip_prefix("uncertainty_um = ")?.split(' ').next()?.parse::<f64>().ok());
    assert!((0.02..0.15).contains(&left.unwrap()), "{text}");

    folder.good(&["thermal", "compile", "thermal.toml", "--machine", ".", "-o", "mill.ttherm"]);
    let bytes = std::fs::read(folder.join("mill.ttherm")).unwrap();
    let thermal = Thermal::parse(&bytes).unwrap();
    let readings = Readings { temperatures_c: &[Some(24.0)], spindle_rpm: None, tool_mm: 0.0 };
    let mut state = ThermalState::new();
    let growth = [0, 1, 2].map(|_| thermal.update(&mut state, 1.0, &readings))[2];
    let [[x, x_slope], [z, z_slope]] = [0, 2].map(|axis| growth.lines[axis].unwrap());
    assert!((x_slope - 4.0 * 12e-6).abs() < 4e-7 && x.abs() < 1e-4, "{x} {x_slope}");
    assert!((z - 4.0 * 3e-3).abs() < 1e-4 && z_slope.abs() < 4e-7, "{z} {z_slope}");
}

#[test]
fn each_cycle_is_held_out_in_turn() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record());
    let fit = ["thermal", "fit", "record.csv", "--hold-out", "0,1,2,3"];
    let found = folder.json(&[&fit[..], &["--json"]].concat());
    let cycles = found["cycles"].as_array().unwrap();
    assert!(cycles.len() == 8 && cycles.iter().all(|own| own["held_out"] == true), "{cycles:?}");
    assert!(cycles.iter().all(|own| own["left_um"].as_f64().unwrap() < 0.3), "{cycles:?}");
    // The noise of both axes is 0.05 µm at most; the second sensor never comes back to a state that it had in another cycle.
    let own = &found["repeatability"][1];
    assert!(own["axis"] == "Z" && own["left_um"].as_f64().unwrap() < 0.05, "{own}");
    let text = folder.good(&fit);
    assert!(text.contains("each predicted by the curves of the others"), "{text}");
    assert!(text.contains("What these sensors can predict"), "{text}");
}

#[test]
fn bad_records_are_refused_with_line_and_figure_and_nothing_is_written() {
    let folder = Folder::new(TRUEAXIS);
    let good = record();
    let line = |number: usize| good.lines().nth(number - 1).unwrap();
    // Changes T1 from line 200 on.
    let change = |from: usize, to: &dyn Fn(&str) -> String| {
        let lines = good.lines().enumerate();
        lines.fold(String::new(), |text, (k, line)| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if k + 1 >= from {
                cells[5] = to(&cells[5]);
            }
            text + &cells.join(",") + "\n"
        })
    };
    let held = line(200).split(',').nth(5).unwrap().to_owned();
    folder.write("stuck.csv", change(200, &|_| held.clone()));
    folder.write("jump.csv", change(200, &|cell| format!("{:.3}", cell.parse::<f64>().unwrap() + 40.0)));
    folder.write("gone.csv", change(200, &|_| String::new()));
    folder.write("absurd.csv", change(200, &|_| "850".into()));
    folder.write(
        "twice.csv",
        good.replace("T2_c", "T3_c").lines().enumerate().fold(String::new(), |text, (k, line)| {
            let cell = line.split(',').nth(5).unwrap().to_owned();
            text + line + "," + if k == 0 { "T2_c" } else { &cell } + "\n"
        }),
    );
    folder.write("short.csv", good.lines().take(97).fold(String::new(), |text, line| text + line + "\n"));
    folder.write("backward.csv", good.replacen("\n600,", "\n60,", 1));
    for (file, message) in [
        ("stuck.csv", "stuck.csv:200: column T1_c: found T1 at one reading for"),
        ("jump.csv", "jump.csv:200: column T1_c: found T1 "),
        (
            "jump.csv",
            "--rate-k-per-min admits a sensor that warms faster, --without T1 leaves out one that is not needed",
        ),
        ("gone.csv", "gone.csv:200: column T1_c: found nothing, needed a number"),
        ("absurd.csv", "absurd.csv:200: column T1_c: found 850, needed -60 to 300 degrees Celsius"),
        ("twice.csv", "found T1 and T2 running together (correlation 1.00000)"),
        ("short.csv", "short.csv: cycles: found 1, needed at least 3"),
        (
            "backward.csv",
            "backward.csv:6: column t_s: found a figure that is not finite or a time that does not ascend",
        ),
    ] {
        folder.bad(&["thermal", "fit", file, "-o", "thermal.toml"], &[message]);
        assert!(!folder.has("thermal.toml"));
    }
    folder.write("record.csv", &good);
    folder.bad(&["thermal", "fit", "record.csv", "--hold-out", "9"], &["found no cycle 9 to hold out"]);
    folder.bad(&["thermal", "fit", "record.csv", "--without", "T7"], &["--without: found T7, needed one of T1, T2"]);
}

#[test]
fn missing_rows_are_reported_with_their_line_and_duplicates_refused() {
    let folder = Folder::new(TRUEAXIS);
    let good = record();
    let without = |removed: &[usize]| {
        let kept = good.lines().enumerate().filter(|(k, _)| !removed.contains(&(k + 1)));
        kept.fold(String::new(), |text, (_, line)| text + line + "\n")
    };
    let fit = |file: &str| folder.json(&["thermal", "fit", file, "--json"])["missing"].clone();
    folder.write("good.csv", &good);
    assert_eq!(fit("good.csv"), serde_json::json!([]));
    // Both positions missing twice in cycle 1, and one position once in cycle 2; line 202 is row 100 at X 0.
    folder.write("gaps.csv", without(&[122, 123, 124, 125, 203]));
    let [first, second] = [(122, 1, 4, 900.0), (198, 2, 1, 600.0)].map(|(line, cycle, rows, found_s)| {
        serde_json::json!({ "line": line, "cycle": cycle, "rows": rows, "found_s": found_s, "interval_s": 300.0 })
    });
    assert_eq!(fit("gaps.csv"), serde_json::json!([first, second]));
    let table = folder.good(&["thermal", "fit", "gaps.csv", "--report", "out"]);
    let rows = table.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    assert!(rows.into_iter().any(|row| row == ["122", "1", "4", "900", "300"]), "{table}");
    assert!(folder.read("out/thermal.html").contains("Missing rows"));
    // The beginning of a cycle has no expected time, and an uneven record has no expected interval.
    folder.write("late.csv", without(&[98, 99]));
    assert_eq!(fit("late.csv"), serde_json::json!([]));
    let uneven: Vec<usize> = (2..386_usize).filter(|line| (line / 2).is_multiple_of(4)).collect();
    folder.write("uneven.csv", without(&uneven));
    assert_eq!(fit("uneven.csv"), serde_json::json!([]));
    let line = |number: usize| good.lines().nth(number - 1).unwrap();
    folder.write("doubled.csv", good.replacen(line(60), &format!("{0}\n{0}", line(60)), 1));
    folder.bad(&["thermal", "fit", "doubled.csv"], &["doubled.csv:61: column t_s: ", "(first in line 60)"]);
}

/// A hot end at 160 to 270 °C that warms by up to 1.5 K a minute: the task accepts its readings as plausible, at the stated
/// rate.
#[test]
fn a_hot_end_is_a_sensor() {
    let folder = Folder::new(TRUEAXIS);
    let hot = record().lines().enumerate().fold(String::new(), |text, (k, line)| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if k > 0 {
            cells[5] = format!("{:.2}", 215.0 + 6.0 * (cells[5].parse::<f64>().unwrap() - 20.0));
        }
        text + &cells.join(",") + "\n"
    });
    folder.write("hot.csv", hot);
    let fit = ["thermal", "fit", "hot.csv", "--without", "T2", "--json", "-o", "thermal.toml"];
    let found = folder.json(&[&fit[..], &["--rate-k-per-min", "8"]].concat());
    let [drift, left] = [0, 1].map(|k| found["held_out_um"][k].as_f64().unwrap());
    assert!(drift > 15.0 && left < 0.3, "{left} of {drift} µm");
    let text = folder.read("thermal.toml");
    let most = text.split_once("plausible_c = [-30, ").unwrap().1.split_once(']').unwrap().0.parse::<f64>().unwrap();
    assert!((268.0..=300.0).contains(&most) && text.contains("rate_k_per_min = 8\n"), "{text}");
    // Rows every 15 min, in which it changes by up to 12 K.
    let hot = folder.read("hot.csv");
    let coarse = hot.lines().enumerate().filter(|(k, _)| *k == 0 || (k - 1) / 2 % 3 == 0);
    folder.write("hot.csv", coarse.fold(String::new(), |text, (_, line)| text + line + "\n"));
    folder.bad(&[&fit[..], &["--rate-k-per-min", "0.1"]].concat(), &["column T1_c: found T1 ", "--rate-k-per-min"]);
    folder.bad(&[&fit[..], &["--rate-k-per-min", "0"]].concat(), &["--rate-k-per-min: found 0, needed 0.1 to 1000"]);
}

#[test]
fn bad_texts_are_refused_with_their_line() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("machine.toml", MACHINE);
    folder.write("x.csv", TABLE);
    let good = "reference_temperature_c = 20.0\n[[sensor]]\nname = \"T1\"\nlag_s = 60.0\nknots_c = [10.0, 30.0]\n\
                [axis.X]\ndatum_mm = 0.0\n[axis.X.sensor.T1]\noffset_um = [-1.0, 1.0]\n";
    folder.write("good.toml", good);
    folder.good(&["thermal", "compile", "good.toml", "--machine", ".", "-o", "good.ttherm"]);
    for (from, to, message) in [
        ("= 20.0", "= 21.0", "bad.toml:1: key reference_temperature_c: found 21, needed 20, as the machine's tables"),
        ("[10.0, 30.0]", "[30.0, 10.0]", "bad.toml:5: key sensor.knots_c: found [30.0, 10.0], needed 2 to 8 ascending"),
        ("[axis.X]", "[axis.U]", "found U, needed an axis of the chain w X' Y' b Z t"),
        ("datum_mm = 0.0", "datum_mm = 5.0", "bad.toml:7: key axis.X.datum_mm: found 5, needed 0, the datum of"),
        ("sensor.T1]", "sensor.T2]", "key axis.X.sensor.T2: found T2, needed the name of a [[sensor]]"),
        ("[-1.0, 1.0]", "[-1.0]", "key axis.X.sensor.T1: found 1 value, needed one for each of 2 knots"),
        ("lag_s", "leg_s", "leg_s"),
        ("60.0", "-60.0", "lag, ms: found -60000, beyond the range of the file's field"),
    ] {
        folder.write("bad.toml", good.replacen(from, to, 1));
        folder.bad(&["thermal", "compile", "bad.toml", "--machine", ".", "-o", "bad.ttherm"], &[message]);
        assert!(!folder.has("bad.ttherm"));
    }
}
