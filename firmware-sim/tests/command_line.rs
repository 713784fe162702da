//! The simulator's command line: output, files and refusals.

use serde_json::Value;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");

fn json(arguments: &[&str]) -> Value {
    Folder::new(SIMULATOR).json(arguments)
}

/// `-o` names the output of every command; `--output` is its long form.
#[test]
fn every_output_has_both_its_names() {
    let folder = Folder::new(SIMULATOR);
    let with_output = ["compare", "friction", "learn", "record", "replay"];
    for command in with_output {
        let help = folder.good(&[command, "--help"]);
        assert!(help.lines().any(|line| line.trim_start().starts_with("-o, --output ")), "{help}");
    }
    let help = folder.good(&["--help"]);
    let all = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = all.filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')));
    let all: Vec<_> = names.filter_map(|line| line.split(' ').next()).filter(|name| *name != "help").collect();
    assert!(with_output.iter().all(|command| all.contains(command)), "{help}");
    for command in all.iter().filter(|command| !with_output.contains(command)) {
        let help = folder.good(&[command, "--help"]);
        assert!(!help.contains("  -o") && !help.contains("--output"), "{help}");
    }
    // A former name is still read.
    folder.bad(&["friction", "--record", "record.csv", "--radius-mm", "0"], &["--radius-mm: found 0"]);
}

fn size(run: &Value, which: &str, what: &str) -> f64 {
    run["contour_error_um"][which][what].as_f64().unwrap()
}

#[test]
fn the_default_scenario_falls_to_a_fifth_or_less_and_repeats_exactly() {
    let first = json(&["run", "--json"]);
    for what in ["max", "rms"] {
        let (before, after) = (size(&first, "uncompensated", what), size(&first, "compensated", what));
        assert!(after <= 0.2 * before, "{what}: {before} to {after}");
        assert!(size(&first, "full", what) <= 0.35 * size(&first, "servo_only", what));
    }
    assert_eq!(first["servo_rate_hz"], 10_000.0);
    assert_eq!(first["faults"], Value::Array(vec![]));
    for key in ["min", "p50", "p99", "p99_99", "max"] {
        assert!(first["latency_ns"][key].as_u64().unwrap() > 0);
    }
    assert!(first["budget_ns"].as_u64().is_some() && first["missed_deadlines"].as_u64().is_some());
    let slow = |seed: &str| json(&["run", "--json", "--rate-hz", "1000", "--seed", seed]);
    let [one, again, other] = ["1", "1", "7"].map(slow);
    assert_eq!(one["contour_error_um"], again["contour_error_um"]);
    assert_eq!(one["cycles"], again["cycles"]);
    assert_ne!(other["contour_error_um"], one["contour_error_um"]);
}

/// The report plots a circle as a ballbar does; a machine whose drives are not corrected has three runs.
#[test]
fn the_report_has_the_circle_and_reversals_where_there_are_some() {
    let directory = Folder::new(SIMULATOR);
    directory.write("own.ngc", "G21 G90 G17 F1500\nG1 X20\nG2 X20 Y0 I-20 J0\n");
    let sample = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables/mill-3axis");
    let machine = std::fs::read_to_string(sample.join("machine.toml")).unwrap();
    directory.write("plain/machine.toml", machine.split("# Drives, friction").next().unwrap());
    for table in ["x.csv", "y.csv", "z.csv"] {
        directory.write(format!("plain/{table}"), std::fs::read(sample.join(table)).unwrap());
    }
    let page = |machine: &str| {
        let arguments = ["run", "--program", "own.ngc", "--rate-hz", "2000", "--machine", machine, "--report", "out"];
        assert!(directory.run(&arguments).status.success());
        directory.read("out/index.html")
    };
    let whole = page("mill-3axis");
    for expected in [
        "Circle in polar coordinates",
        "circle of 20.0 mm in the plane XY",
        "everything on, zone",
        "<th>everything on</th>",
        "X turns",
        "Y turns",
    ] {
        assert!(whole.contains(expected), "`{expected}` is missing");
    }
    let plain = page("plain");
    assert!(!plain.contains("Dynamic correction at reversals") && !plain.contains("<th>everything on</th>"));
    let run = directory.json(&["run", "--json", "--program", "own.ngc", "--rate-hz", "2000", "--machine", "plain"]);
    assert!(run["contour_error_um"]["servo_only"].is_object() && run["contour_error_um"].get("full").is_none());
}

/// A bed rises by 0.2 mm with a limit of 0.1 mm: the run reports the missing part and its location; a sufficient limit gives
/// no note.
#[test]
fn clipped_corrections_are_reported() {
    let directory = Folder::new(SIMULATOR);
    directory.write("flat.ngc", "G21 G90 G94\nG0 X30 Y30 Z0.2\nG1 X200 F3000\nG1 Y150\nM2\n");
    directory.write("m/grid.csv", "X_mm,Y_mm,EZ_um\n0,0,0\n0,200,0\n200,0,-200\n200,200,-200\n");
    let notes = |limit: &str| {
        let toml = "name = \"m\"\nchain = \"w b X Y Z t\"\n[[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"grid.csv\"\n";
        directory.write("m/machine.toml", format!("{toml}[axis.Z.limits]\n{limit}\n"));
        let run =
            ["run", "--json", "--program", "flat.ngc", "--origin-mm", "0,0,0", "--rate-hz", "1000", "--machine", "m"];
        directory.json(&run)["notes"].as_array().unwrap().iter().map(|note| note.to_string()).collect::<Vec<_>>()
    };
    let printed = notes("magnitude_um = 100");
    let note =
        printed.iter().find(|note| note.contains("axis Z: the magnitude limit removes up to 100 µm of")).unwrap();
    for part in ["cycles, most at X200 ", "[axis.Z.limits] magnitude_um is 100, 200 would pass all of it"] {
        assert!(note.contains(part), "{note}");
    }
    assert!(notes("magnitude_um = 240").iter().all(|note| !note.contains("limit")));
    // At 50 mm/s the bed rises by 0.05 mm/s.
    let printed = notes("magnitude_um = 240\nslope_mm_per_s = 0.02");
    assert!(printed.iter().any(|note| note.contains("limits held the correction back in ")), "{printed:?}");
}

#[test]
fn other_programs_machines_and_rates_run() {
    for (program, machine, rate) in [
        ("butterfly", "mill-3axis", "2000"),
        ("pocket-3d", "mill-3axis", "4000"),
        ("circle-diamond-square", "mill-5axis", "2000"),
    ] {
        let run = json(&["run", "--json", "--program", program, "--machine", machine, "--rate-hz", rate]);
        for what in ["max", "rms"] {
            assert!(
                size(&run, "compensated", what) < 0.4 * size(&run, "uncompensated", what),
                "{program} on {machine}: {run}"
            );
        }
    }
}

/// A short user program, with every kind of injected fault.
#[test]
fn injected_faults_are_reported_where_they_happen_and_only_bad_commands_stop() {
    let directory = Folder::new(SIMULATOR);
    let program = directory.path().join("own.ngc");
    std::fs::write(&program, "G21 G90 G17 F1200\nG1 X20 Y5 Z-1\nG2 X20 Y25 J10\nG1 X0 Y0\nM2\n").unwrap();
    let program = program.to_str().unwrap();
    let run = json(&[
        "run",
        "--json",
        "--program",
        program,
        "--fault",
        "dropout:X@0.5s+3",
        "--fault",
        "glitch:Y@0.8s+1=5mm",
        "--fault",
        "late@1.1s+1=2.5",
        "--fault",
        "stuck:X@0.3s+400",
    ]);
    let faults: Vec<&str> = run["faults"].as_array().unwrap().iter().map(|f| f["fault"].as_str().unwrap()).collect();
    for expected in ["FeedbackNotFinite", "FeedbackJump", "LateCycle"] {
        assert!(faults.contains(&expected), "{faults:?}");
    }
    assert_eq!(run["stopped"], false);
    let dropout = run["faults"].as_array().unwrap().iter().find(|f| f["fault"] == "FeedbackNotFinite").unwrap();
    assert_eq!((dropout["axis"].as_str(), dropout["cycles"].as_u64()), (Some("X"), Some(3)));
    assert!((dropout["time_s"].as_f64().unwrap() - 0.5).abs() < 2e-4, "{dropout}");
    for (fault, name) in [("nan-command:X@0.6s+1", "CommandNotFinite"), ("jump-command:Y@0.6s+1=3mm", "CommandJump")] {
        let run = json(&["run", "--json", "--program", program, "--fault", fault]);
        assert_eq!(run["stopped"], true);
        assert_eq!(run["faults"][0]["fault"], name);
    }
}

/// In the trace of a run with faults, every line is within all limits of the correction.
#[test]
fn the_trace_keeps_the_limits_and_the_report_is_written() {
    let directory = Folder::new(SIMULATOR);
    let arguments =
        ["run", "--report", "out", "--trace-every", "1", "--program", "butterfly", "--fault", "dropout:Y@1s+10"];
    let output = directory.run(&[&arguments[..], &["--rate-hz", "2000"]].concat());
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("uncorrected") && text.contains("servo alone") && text.contains("FeedbackNotFinite"));
    let (_, errors) = text.split_once("True contour error of the tool tip while cutting\n").unwrap();
    assert_eq!(errors.lines().take_while(|line| !line.is_empty()).count(), 1 + 4, "{text}");
    let page = directory.read("out/index.html");
    assert!(page.contains("</html>") && page.contains("Dynamic correction at reversals"));
    let full = directory.read("out/trace-full.csv");
    let header: Vec<&str> = full.lines().next().unwrap().split(',').collect();
    assert_eq!(header[30..34], ["dynamic_x_um", "feed_forward_x_um", "contour_feedback_x_um", "crosstalk_x_um"]);
    assert!(full.lines().all(|line| line.split(',').count() == header.len() && header.len() == 42));
    let trace = directory.read("out/trace.csv");
    let mut lines = trace.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let columns: Vec<usize> = ["x", "y", "z"]
        .iter()
        .map(|a| header.iter().position(|h| *h == format!("correction_{a}_um")).unwrap())
        .collect();
    let drive: Vec<usize> =
        ["x", "y", "z"].iter().map(|a| header.iter().position(|h| *h == format!("drive_{a}_mm")).unwrap()).collect();
    assert_eq!(header.len(), 30, "a machine of three axes has no columns of others");
    let (mut last, mut velocity) = (None::<[f64; 3]>, [0.0; 3]);
    let mut count = 0;
    for line in lines {
        let values: Vec<&str> = line.split(',').collect();
        let c: [f64; 3] = std::array::from_fn(|k| values[columns[k]].parse().unwrap());
        assert!(drive.iter().all(|i| values[*i].parse::<f64>().unwrap().is_finite()));
        if let Some(last) = last {
            for k in 0..3 {
                let v = c[k] - last[k];
                // 100 µm, 5 mm/s = 2.5 µm and 5 m/s² = 1.25 µm per cycle; five decimals in the file.
                assert!(c[k].abs() <= 100.0 && v.abs() <= 2.5 + 2e-5, "line {count}: {v}");
                assert!(count < 3 || (v - velocity[k]).abs() <= 1.25 + 4e-5, "line {count}: {}", v - velocity[k]);
                velocity[k] = v;
            }
        }
        last = Some(c);
        count += 1;
    }
    assert!(count > 20_000);
}

#[test]
fn bad_input_ends_with_2_says_why_and_writes_nothing() {
    let directory = Folder::new(SIMULATOR);
    directory.write("bad.ngc", "G21 G90\nG1 X1 F100\nG33 Z1 K1\n");
    directory.write("far.ngc", "G21 G90 F100\nG1 X900\n");
    directory.write("endless.ngc", "G21 G90\nG1 X10 F0.001\n");
    directory.write("binary.ngc", [0xff, 0xfe, 0x00]);
    let cases: [(&[&str], &str); 13] = [
        (&["run", "--program", "bad.ngc"], "bad.ngc:3"),
        (&["run", "--program", "far.ngc"], "axis X goes to"),
        (&["run", "--program", "binary.ngc"], "binary.ngc:1: found UTF-16; needed: UTF-8 or Latin-1"),
        (&["run", "--trace-every", "0"], "--trace-every"),
        (&["run", "--program", "endless.ngc"], "endless.ngc:2: found a program of more than 166.7 hours"),
        (&["run", "--program", "missing.ngc"], "missing.ngc"),
        (&["run", "--machine", "nowhere"], "nowhere"),
        (&["run", "--rate-hz", "0"], "--rate-hz"),
        (&["run", "--rate-hz", "nan"], "--rate-hz"),
        (&["run", "--origin-mm", "1,2"], "--origin-mm"),
        (&["run", "--fault", "fire:X@1s"], "--fault"),
        (&["run", "--fault", "dropout:C@1s+1"], "axis C"),
        (&["keep", "--parts", "70"], "--parts: found 70, needed at most 60 of 480 s each"),
    ];
    for (arguments, expected) in cases {
        let with_report = [arguments, &["--report", "out"]].concat();
        directory.bad(&with_report, &[expected]);
    }
}

#[test]
fn the_step_alone_is_timed() {
    let bench = json(&["bench", "--cycles", "20000", "--json"]);
    assert_eq!(bench["cycles"], 20_000);
    assert!(bench["steps_per_s"].as_f64().unwrap() > 1e4);
    assert!(bench["latency_ns"]["p50"].as_u64().unwrap() > 0);
    Folder::new(SIMULATOR).bad(&["bench", "--cycles", "0"], &[]);
}

#[test]
fn grinding_prints_its_figures_and_writes_its_page() {
    let arguments = ["grind", "--revolutions", "16", "--speed-rpm", "200", "--seed", "3"];
    let run = json(&[&arguments[..], &["--json"]].concat());
    assert_eq!((run["revolutions"].as_u64(), run["points"].as_u64()), (Some(16), Some(1024)));
    assert!(run["cycles_of_work"].as_u64().unwrap() > 5000);
    assert_eq!(run["limits_exceeded"], 0);
    for which in ["uncorrected", "corrected"] {
        assert_eq!(run[which]["per_revolution"].as_array().unwrap().len(), 16);
        assert!(run[which]["imprint_um"].as_f64().unwrap() > 0.0 && run[which]["roundness_um"].as_f64().unwrap() > 0.0);
    }
    let ratio = run["corrected"]["imprint_um"].as_f64().unwrap() / run["uncorrected"]["imprint_um"].as_f64().unwrap();
    assert!((run["imprint_ratio"].as_f64().unwrap() - ratio).abs() < 1e-12);
    // The work takes more than the 3000 cycles of a revolution.
    let [evaluated, skipped] = ["evaluated", "skipped"].map(|what| run["corrected"][what].as_u64().unwrap());
    assert!(evaluated >= 6 && skipped >= 6 && evaluated + skipped <= 15, "{evaluated} {skipped}");
    for axis in ["x", "y"] {
        assert!(run["spindle"]["true"][axis]["synchronous_um"].as_f64().unwrap() > 1.0);
    }
    let directory = Folder::new(SIMULATOR);
    let text = directory.good(&[&arguments[..], &["--report", "out"]].concat());
    assert!(text.contains("uncorrected") && text.contains("grind.html"), "{text}");
    let page = directory.read("out/grind.html");
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..roxmltree::ParsingOptions::default() };
    let document = roxmltree::Document::parse_with_options(&page, options).unwrap();
    let figures = document.descendants().filter(|n| n.has_tag_name("figure")).count();
    assert_eq!(figures, 8);
    for text in document.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()) {
        assert!(!text.contains("NaN"), "{text}");
    }
}

#[test]
fn bad_arguments_of_grinding_are_refused_with_the_range_needed() {
    let directory = Folder::new(SIMULATOR);
    for (arguments, expected) in [
        (["--revolutions", "3"], "--revolutions: found 3, needed 8 to 10000"),
        (["--gain", "0.5"], "--gain: found 0.5, needed above 0 and at most 0.3090"),
        (["--gain", "nan"], "--gain: found NaN"),
        (["--speed-rpm", "5000"], "--speed-rpm: found 5000, needed 0.1 to"),
        (["--skip", "40"], "--skip: found 40, needed at most"),
        (["--feed-um", "-1"], "--feed-um: found -1, needed 0 to 5"),
        (["--machine", "mill-3axis"], "found no [roundness]"),
        (["--rate-hz", "5"], "--rate-hz: found 5, needed 100 to 100000"),
    ] {
        directory.bad(&[&["grind", "--report", "out"], &arguments[..]].concat(), &[expected]);
    }
}

#[test]
fn paced_runs_say_what_was_permitted() {
    let directory = Folder::new(SIMULATOR);
    let program = directory.path().join("short.ngc");
    std::fs::write(&program, "G21 G90 F1200\nG1 X5\n").unwrap();
    let run = json(&["run", "--json", "--paced", "--rate-hz", "1000", "--program", program.to_str().unwrap()]);
    // The run and its trace do not depend on the pace.
    assert_eq!(
        run["contour_error_um"],
        json(&["run", "--json", "--rate-hz", "1000", "--program", program.to_str().unwrap()])["contour_error_um"]
    );
    let arguments =
        ["run", "--paced", "--rate-hz", "1000", "--report", "out", "--trace-every", "1", "--program", "short.ngc"];
    directory.good(&arguments);
    let trace = directory.read("out/trace.csv");
    assert_eq!(trace.lines().count() as u64, 1 + run["cycles"].as_u64().unwrap());
    let notes: Vec<&str> = run["notes"].as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
    for means in ["SCHED_FIFO", "mlockall"] {
        assert!(notes.iter().any(|note| note.contains(means)), "{notes:?}");
    }
}

/// Report and trace contain every axis that the program turns: command, drive, feedback, correction.
#[test]
fn rotary_axes_are_in_the_report_and_in_the_trace() {
    let directory = Folder::new(SIMULATOR);
    let arguments = [
        "run",
        "--machine",
        "mill-5axis",
        "--program",
        "own.ngc",
        "--model",
        "volumetric",
        "--orientation",
        "--report",
        "out",
        "--trace-every",
        "1",
        "--rate-hz",
        "2000",
    ];
    directory.write("own.ngc", "G21 G90 G43.4 H1\nG1 X10 A-10 C20 F1200\nX0 A0 C0\nM2\n");
    directory.good(&arguments);
    let trace = directory.read("out/trace.csv");
    let mut lines = trace.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let page = directory.read("out/index.html");
    for axis in ["a", "c"] {
        let column = |name: String| {
            let place = header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("{name} in {header:?}"));
            rows.iter().map(|row| row[place]).collect::<Vec<f64>>()
        };
        let [programmed, command, drive, feedback] =
            ["", "command_", "drive_", "feedback_"].map(|what| column(format!("{what}{axis}_deg")));
        let correction = column(format!("correction_{axis}_urad"));
        let largest = correction.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(largest > 5.0 && largest < 2000.0, "{axis}: {largest} µrad");
        for k in 0..rows.len() {
            assert!((programmed[k] - command[k]).abs() < 6e-5, "{axis} {k}");
            // The drive receives the command with the correction, and the servo follows it.
            let sent = (command[k] + (1e-6 * correction[k]).to_degrees() - drive[k]).abs();
            assert!(sent < 1e-8, "{axis} {k}: {sent}");
            assert!((feedback[k] - command[k]).abs() < 0.5, "{axis} {k}");
        }
        let name = axis.to_uppercase();
        assert!(page.contains(&format!("{name} correction in µrad")) && page.contains(&format!("<tr><th>{name}</th>")));
    }
}

/// Standard output and error are closed before the start: the exit code is that of the same call with open pipes.
#[test]
fn a_closed_pipe_is_no_panic() {
    let directory = Folder::new(SIMULATOR);
    let closed = || {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        std::process::Stdio::from(writer)
    };
    let calls: [&[&str]; 4] =
        [&["bench", "--cycles", "1000"], &["bench", "--cycles", "0"], &["--help"], &["no-such-command"]];
    for arguments in calls {
        let listening = directory.run(arguments).status.code();
        let status = directory.command(arguments).stdout(closed()).stderr(closed()).status();
        assert_eq!(status.unwrap().code(), listening, "{arguments:?}");
    }
}
