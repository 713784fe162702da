//! `trueaxis ballbar` as called; the circle is run by positions, not radii.

use std::fmt::Write;
use trueaxis::telemetry::{AxisFrame, ContourFrame, FRAME_BYTES, FRAME_VERSION, Frame, Status};
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// 100 mm: C0Y 50 µrad, lost motion of 5 µm in X, the pivot 20 µm off.
fn record(directions: &[f64]) -> String {
    record_of(directions, 5.0)
}

fn record_of(directions: &[f64], lost_um: f64) -> String {
    let mut text = String::from("angle_deg,deviation_um,direction\n");
    for d in directions {
        for k in 0..360 {
            let (sin, cos) = (f64::from(k) + 0.5).to_radians().sin_cos();
            let (x, y) = (100.0 * cos, 100.0 * sin);
            let x = x - 50e-6 * y + 0.5e-3 * lost_um * (d * sin).signum() + 0.02;
            writeln!(text, "{},{},{d}", f64::from(k) + 0.5, 1e3 * (x.hypot(y) - 100.0)).unwrap();
        }
    }
    text
}

#[test]
fn causes_are_found() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record(&[1.0, -1.0]));
    let found = folder.json(&["ballbar", "record.csv", "--radius-mm", "100", "--json", "--report", "out"]);
    let near = |found: &serde_json::Value, truth: f64, tolerance: f64| {
        assert!((found.as_f64().unwrap() - truth).abs() < tolerance, "{found} for {truth}");
    };
    near(&found["squareness_urad"], 50.0, 0.05);
    near(&found["backlash_um"]["x"], 5.0, 0.01);
    near(&found["backlash_um"]["y"], 0.0, 0.01);
    near(&found["centre_um"][0], 20.0, 0.01);
    near(&found["h_um"], 5.0, 0.02);
    assert!(found["standard_errors"]["squareness_urad"].as_f64().unwrap() < 0.1);
    assert_eq!(found["shares"][0]["cause"], "squareness");
    let page = std::fs::read_to_string(folder.join("out/ballbar.html")).unwrap();
    assert!(page.contains("Circular test") && page.contains("squareness C0Y"));
}

/// Command and position on a circle of 40 mm about (7, −3), four per degree: the second axis lags by 5 µm, has 3 µm of lost
/// motion and moves the first by 30 µrad.
fn places() -> Vec<[[f64; 2]; 2]> {
    places_of(30e-6)
}

fn places_of(squareness: f64) -> Vec<[[f64; 2]; 2]> {
    let turns = |d: f64| (0..=1440).map(move |k| (d, d * f64::from(k) * 0.25));
    let all = turns(1.0).chain(turns(-1.0));
    all.map(|(d, angle)| {
        let (sin, cos) = (angle + 0.1).to_radians().sin_cos();
        let (x, y) = (40.0 * cos, 40.0 * sin);
        let moved = [x - squareness * y, y - 0.005 * d * cos - 0.0015 * (d * cos).signum()];
        [[7.0 + x, -3.0 + y], [7.0 + moved[0], -3.0 + moved[1]]]
    })
    .collect()
}

/// One circle as CSV, halsampler lines and telemetry gives one document; another plane renames the squareness.
#[test]
fn positions_come_in_three_forms() {
    let folder = Folder::new(TRUEAXIS);
    let (mut csv, mut zx) =
        (String::from("t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n"), String::from("z_cmd_mm,z_mm,x_cmd_mm,x_mm\n"));
    let (mut sampled, mut frames) = (String::new(), Vec::new());
    for (k, [command, place]) in places().into_iter().enumerate() {
        let row = format!("{},{},{},{}", command[0], place[0], command[1], place[1]);
        writeln!(csv, "{},{row}", 1e-3 * k as f64).unwrap();
        writeln!(zx, "{row}").unwrap();
        writeln!(sampled, "{} {}", k + 70, row.replace(',', " ")).unwrap();
        let axis = |i: usize| AxisFrame { command: command[i], feedback: place[i], correction: 0.0, dynamic: None };
        let still = AxisFrame { command: 5.0, feedback: 5.0, correction: 0.0, dynamic: None };
        let frame = Frame {
            version: FRAME_VERSION,
            sequence: k as u32,
            machine_id: 1,
            tables_crc: 7,
            fault: trueaxis::Fault::None,
            fault_axis: 0,
            status: Status(0),
            limited: 0,
            at_edge: 0,
            axes: [axis(0), axis(1), still].into_iter().collect(),
            tip: ContourFrame::default(),
            encoder: ContourFrame::default(),
            orientation: 0.0,
            orientation_flags: 0,
        };
        let mut buffer = [0; FRAME_BYTES];
        frames.extend_from_slice(frame.encode(&mut buffer).unwrap());
    }
    folder.write("grid.csv", csv);
    folder.write("samples.txt", sampled.clone());
    folder.write(
        "bare.txt",
        sampled.lines().fold(String::new(), |text, line| text + line.split_once(' ').unwrap().1 + "\n"),
    );
    folder.write("frames.bin", frames);
    folder.write("zx.csv", zx);
    let of = |file: &str| folder.json(&["ballbar", file, "--radius-mm", "40", "--json"]);
    let found = of("grid.csv");
    let near = |found: &serde_json::Value, truth: f64, tolerance: f64| {
        assert!((found.as_f64().unwrap() - truth).abs() < tolerance, "{found} for {truth}");
    };
    near(&found["squareness_urad"], 30.0, 0.1);
    near(&found["servo_mismatch_um"], -5.0, 0.02);
    near(&found["backlash_um"]["y"], 3.0, 0.05);
    near(&found["backlash_um"]["x"], 0.0, 0.05);
    assert!(found["warnings"][0].as_str().unwrap().starts_with("computed from positions"));
    for file in ["samples.txt", "bare.txt", "frames.bin"] {
        assert_eq!(of(file), found, "{file}");
    }
    let other = folder.json(&["ballbar", "zx.csv", "--radius-mm", "40", "--axes", "Z,X", "--json"]);
    assert_eq!((&other["plane"], &other["squareness"]), (&"ZX".into(), &"B0Z".into()));
    near(&other["squareness_urad"], -30.0, 0.1);
    assert_eq!(other["backlash_um"]["x"], found["backlash_um"]["y"]);
    // Errors in these files are reported.
    folder.write("gap.txt", sampled.replacen("\n75 ", "\n#", 1).replace('#', "76 "));
    folder.write("lost.txt", sampled.replacen("\n80 ", "\noverrun\n80 ", 1));
    folder.write("zeros.bin", [0; 40]);
    for (file, message) in [
        ("gap.txt", "gap.txt:6: found sample 76 after 74, needed every cycle, none lost"),
        ("lost.txt", "lost.txt:11: found \"overrun\", needed command and position of the first axis"),
        ("zeros.bin", "zeros.bin: found no whole record of a cycle, needed text or telemetry"),
        ("zx.csv", "zx.csv: found columns z_cmd_mm, z_mm, x_cmd_mm, x_mm, needed the columns angle_deg, deviation_um"),
    ] {
        folder.bad(&["ballbar", file, "--radius-mm", "40"], &[message]);
    }
    let wrong = "found commands that turn with a radius of 40.0000 mm, needed circles of 45 mm about one centre";
    folder.bad(&["ballbar", "samples.txt", "--radius-mm", "45"], &[wrong]);
}

/// Squareness and backlash are written into the machine, replacing or adding to the stated values; the rest is unchanged.
#[test]
fn identified_settings_are_written_into_the_machine() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record(&[1.0, -1.0]));
    let toml = "# ours\nname = \"m\"\nchain = \"w Y' X' b Z t\"\n[location]\nC0Y_urad = 20\n[axis.X]\ntable = \"x.csv\"\n\
                backlash_um = 1 # by hand\n[axis.Y]\n[axis.Z]\n";
    std::fs::create_dir(folder.join("m")).unwrap();
    folder.write("m/machine.toml", toml);
    folder.write("m/x.csv", "X_mm,EXX_um\n-100,0\n100,3\n");
    let ballbar = ["ballbar", "record.csv", "--radius-mm", "100", "--machine", "m", "-o"];
    let call = |more: &[&'static str]| [&ballbar[..], more].concat();
    let found = |file: &str, key: &str| -> f64 {
        let text = folder.read(file);
        let line = text.lines().find(|line| line.starts_with(key)).unwrap_or_else(|| panic!("{key} in {text}"));
        line.split(['=', '#']).nth(1).unwrap().trim().parse().unwrap()
    };
    folder.good(&call(&["new"]));
    assert!((found("new/machine.toml", "C0Y_urad") - 50.0).abs() < 0.1);
    assert!((found("new/machine.toml", "backlash_um") - 5.0).abs() < 0.02);
    assert!(folder.read("new/machine.toml").starts_with("# ours") && folder.read("new/x.csv").contains("100,3"));
    assert_eq!(folder.read("m/machine.toml"), toml, "the machine itself stays");
    folder.good(&call(&["more", "--compensated"]));
    assert!((found("more/machine.toml", "C0Y_urad") - 70.0).abs() < 0.1);
    assert!((found("more/machine.toml", "backlash_um") - 6.0).abs() < 0.02);
    folder.good(&["tables", "check", "new"]);
    // The same record does not count twice on top of the tables; another one does.
    let own = ["ballbar", "record.csv", "--radius-mm", "100", "--machine", "new", "-o", "new", "--compensated"];
    let before = folder.read("new/machine.toml");
    assert!(folder.both(&own)[1].contains("this record is already included"));
    assert_eq!(folder.read("new/machine.toml"), before);
    folder.write("record.csv", format!("# again\n{}", record(&[1.0, -1.0])));
    folder.good(&own);
    assert!((found("new/machine.toml", "backlash_um") - 10.0).abs() < 0.04, "its own folder");
    folder.bad(&call(&["more"]), &["found a machine in more, needed the folder of --machine or one without a machine"]);
    folder.bad(&["ballbar", "record.csv", "--radius-mm", "100", "-o", "x"], &["--machine"]);
}

/// Only errors that the circle shows are reported as written; a lost motion within its scatter is not.
#[test]
fn only_changed_terms_are_reported() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record(&[1.0, -1.0]));
    let toml = "name = \"m\"\nchain = \"w b X Y Z t\"\n[location]\nA0Z_urad = 32.123456789\nB0Z_urad = 38.987654321\nC0Y_urad = 20\n";
    folder.write("m/machine.toml", toml);
    let [_, stderr] = folder.both(&["ballbar", "record.csv", "--radius-mm", "100", "--machine", "m", "-o", "new"]);
    assert!(stderr.contains("location.C0Y_urad") && !stderr.contains("A0Z") && !stderr.contains("B0Z"), "{stderr}");
    let text = folder.read("new/machine.toml");
    assert!(text.contains("A0Z_urad = 32.123456789\nB0Z_urad = 38.987654321\nC0Y_urad = 50"), "{text}");
    assert!(text.contains("[axis.X]\nbacklash_um = 5") && !text.contains("[axis.Y]"), "{text}");
    assert!(stderr.lines().any(|line| line.starts_with("axis.Y.backlash_um") && line.contains("of zero")), "{stderr}");
    let call = ["ballbar", "record.csv", "--radius-mm", "100", "--machine", "m", "-o", "forced", "--force"];
    let [_, stderr] = folder.both(&call);
    assert!(stderr.contains("forced, the rule writes nothing: within 2 standard uncertainties of zero"), "{stderr}");
    let text = folder.read("forced/machine.toml");
    assert!(text.contains("[axis.Y]\nbacklash_um = ") && text.contains("B0Z_urad = 38.987654321\n"), "{text}");
    folder.bad(&["ballbar", "record.csv", "--radius-mm", "100", "--force"], &["--machine"]);
}

/// The circles show 5 µm of lost motion, of which the axis' table has 4 already.
#[test]
fn lost_motion_of_a_table_is_not_written_again() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record(&[1.0, -1.0]));
    folder.write("m/machine.toml", "name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntable = \"x.csv\"\n");
    folder.write("m/x.csv", "X_mm,EXX_fwd_um,EXX_rev_um\n-150,1,5\n0,0,4\n150,2,6\n");
    let call = |more: &[&'static str]| {
        let mut call = vec!["ballbar", "record.csv", "--radius-mm", "100", "--machine", "m", "-o", "new"];
        call.extend(more);
        folder.both(&call)
    };
    let [_, stderr] = call(&[]);
    let text = folder.read("new/machine.toml");
    let line = text.lines().find(|line| line.starts_with("backlash_um")).unwrap_or_else(|| panic!("{text}{stderr}"));
    let written: f64 = line.split(['=', '#']).nth(1).unwrap().trim().parse().unwrap();
    assert!((written - 1.0).abs() < 0.02, "{text}");
}

/// Axis encoders do not see squareness: finding none does not remove the stated value.
#[test]
fn positions_take_no_squareness_away() {
    let folder = Folder::new(TRUEAXIS);
    let rows = places_of(0.0).into_iter().enumerate().map(|(k, [command, place])| {
        // Noise of half a nanometre, the encoder's resolution.
        let noise = 5e-7 * f64::from([1, -1, 0, -1, 1, 0, 0][k % 7]);
        format!("{},{},{},{}\n", command[0], place[0] + noise, command[1], place[1] - noise)
    });
    folder.write("grid.csv", String::from("x_cmd_mm,x_mm,y_cmd_mm,y_mm\n") + &rows.collect::<String>());
    let toml =
        "name = \"m\"\nchain = \"w b X Y Z t\"\n[location]\nC0Y_urad = 38.0\n[uncertainty.location]\nC0Y_urad = 2.0\n";
    folder.write("m/machine.toml", toml);
    let [_, stderr] = folder.both(&["ballbar", "grid.csv", "--radius-mm", "40", "--machine", "m", "-o", "new"]);
    let text = folder.read("new/machine.toml");
    assert!(text.contains("[location]\nC0Y_urad = 38.0\n") && text.contains("backlash_um = 3"), "{text} {stderr}");
}

/// A control that compensates 8 µm too much: the cause is named and the squareness is written.
#[test]
fn lost_motion_below_zero_refuses_nothing_else() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record_of(&[1.0, -1.0], -8.0));
    folder.write("m/machine.toml", "name = \"m\"\nchain = \"w b X Y Z t\"\n");
    let ballbar = ["ballbar", "record.csv", "--radius-mm", "100", "--machine", "m", "-o", "new"];
    let [found, stderr] = folder.both(&ballbar);
    let cause = "-8.0 µm: lost motion below zero is over-compensation: the control takes up too much";
    assert!(
        found.replace('\u{2212}', "-").contains(&format!("note: backlash X is {}", cause.replace("8.0", "8.00"))),
        "{found}"
    );
    assert!(
        stderr.lines().any(|line| line.starts_with("axis.X.backlash_um") && line.contains("lost motion below zero")),
        "{stderr}"
    );
    let text = folder.read("new/machine.toml");
    assert!(text.contains("C0Y_urad = 50") && !text.contains("backlash"), "{text}");
}

#[test]
fn a_direction_is_read_as_people_write_it() {
    let folder = Folder::new(TRUEAXIS);
    let text = record(&[1.0, -1.0]);
    folder.write("numbers.csv", text.clone());
    let found = folder.json(&["ballbar", "numbers.csv", "--radius-mm", "100", "--json"]);
    for (counterclockwise, clockwise) in
        [("+", "-"), ("+1", "\u{2212}1"), ("ccw", "cw"), ("CCW", "\u{2212}"), ("1.0", "-1")]
    {
        let written: String = text
            .lines()
            .map(|line| match line.strip_suffix(",-1") {
                Some(begin) => format!("{begin},{clockwise}\n"),
                None => {
                    line.strip_suffix(",1").map_or(format!("{line}\n"), |begin| format!("{begin},{counterclockwise}\n"))
                }
            })
            .collect();
        assert!(written.contains(&format!(",{clockwise}\n")), "{written}");
        folder.write("words.csv", written);
        let other = folder.json(&["ballbar", "words.csv", "--radius-mm", "100", "--json"]);
        assert_eq!(other, found, "{counterclockwise} {clockwise}");
    }
    folder.write("left.csv", text.replacen(",-1\n", ",left\n", 1));
    folder.bad(&["ballbar", "left.csv", "--radius-mm", "100"], &["left.csv:362: column direction: found \"left\""]);
}

/// Deviations in mm under a header of µm: no machine is that round.
#[test]
fn an_implausibly_round_circle_is_reported() {
    let folder = Folder::new(TRUEAXIS);
    let warns = |scale: f64| {
        let text = record(&[1.0, -1.0]).lines().enumerate().fold(String::new(), |text, (k, line)| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if k > 0 {
                cells[1] = format!("{:e}", scale * cells[1].parse::<f64>().unwrap());
            }
            text + &cells.join(",") + "\n"
        });
        folder.write("scaled.csv", text);
        let found = folder.json(&["ballbar", "scaled.csv", "--radius-mm", "100", "--json"]);
        found["warnings"].as_array().unwrap().iter().any(|warning| warning.as_str().unwrap().contains("may be in mm"))
    };
    assert!(warns(1e-3) && !warns(1.0) && !warns(0.1));
}

#[test]
fn errors_name_their_line() {
    let folder = Folder::new(TRUEAXIS);
    let good = record(&[1.0]);
    folder.write("still.csv", good.replacen("2.5,", "2.5,0,0\n3.5,", 1).replace("0,0\n3.5,", "0,0\n#"));
    folder.write("part.csv", good.lines().take(200).fold(String::new(), |text, line| text + line + "\n"));
    let in_radians = |line: &str| {
        let (angle, rest) = line.split_once(',').unwrap();
        angle.parse::<f64>().map_or(format!("{line}\n"), |angle| format!("{:.4},{rest}\n", angle.to_radians()))
    };
    folder.write("radians.csv", good.lines().map(in_radians).collect::<String>());
    for (file, message) in [
        ("radians.csv", "radians.csv:361: column angle_deg: found 6.2745, needed angles in degrees"),
        (
            "still.csv",
            "still.csv:4: column direction: found 0, needed 1, + or ccw for counterclockwise, -1, - or cw for clockwise",
        ),
        ("part.csv", "part.csv: found no counterclockwise reading over 162.0° from 198.5° on"),
    ] {
        let refused = folder.run(&["ballbar", file, "--radius-mm", "100"]);
        let error = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && error.contains(message), "{error}");
    }
}
