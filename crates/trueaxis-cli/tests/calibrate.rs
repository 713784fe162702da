//! `trueaxis calibrate` as called. The tests simulate control, probe and machine in a few lines: every probing move of the
//! program runs against artefacts on a machine with known scales, squareness and backlash.

use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const MACHINE: &str = "# of my own hand\nname = \"mill\"\nchain = \"w X' Y' b Z t\"\n\n[axis.X] # long\ntravel_mm = [0.0, 500.0]\n\
                       [axis.Y]\ntravel_mm = [0.0, 400.0]\n[axis.Z]\ntravel_mm = [-300.0, 0.0]\n";

const HEAD: &str = "machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 3.0\n";
const BALL: &str = "[[artefact]]\nname = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25.0\nuncertainty_um = 0.2\n\
                    [[artefact.place]]\nat_mm = [40.0, 40.0, -250.0]\n";
const RING: &str =
    "[[artefact]]\nname = \"ring\"\nkind = \"ring\"\ndiameter_mm = 150.0\nuncertainty_um = 0.2\npoints = 16\n";
const FLAT: &str = "[[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\n";
const UPRIGHT: &str = "[[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\nnormal = \"Y\"\n\
                       [[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\nnormal = \"X\"\n";
const REFERENCE: &str = "[reference]\nartefact = \"ball\"\nevery = 40\n";

fn whole_task() -> String {
    format!("{HEAD}{REFERENCE}{BALL}{RING}{FLAT}{UPRIGHT}")
}

/// Scales 40, −30 and 20 ppm; C0Y 50, B0Z −20, A0Z 30 µrad; backlash of X 6 µm, of Y 3 µm; the tip 8 µm smaller.
struct Bench {
    reverse: [bool; 3],
    lost_x_um: f64,
    drift_um: f64,
    ring_mm: f64,
}

impl Bench {
    fn actual(&self, [x, y, z]: [f64; 3], count: f64) -> [f64; 3] {
        let lost = |axis: usize, um: f64| if self.reverse[axis] { 1e-3 * um } else { 0.0 };
        [
            x + 40e-6 * x - 50e-6 * y - 20e-6 * z + lost(0, self.lost_x_um) + 1e-3 * self.drift_um * count,
            y - 30e-6 * y - 30e-6 * z + lost(1, 3.0),
            z + 20e-6 * z,
        ]
    }

    /// Distance from the tip to the nearest artefact: the ball, or the ring of a set-up.
    fn gap(&self, set_up: usize, tip: [f64; 3]) -> f64 {
        let radius = 3.0 - 0.008;
        let away = |centre: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| tip[k] - centre[k]) };
        let [x, y, z] = away([40.1, 39.8, -250.2]);
        let ball = (x * x + y * y + z * z).sqrt() - 12.5 - radius;
        let [x, y, z] = away([250.2, 200.1, -149.9]);
        let (u, v, along) = match set_up {
            1 => (x, y, z),
            2 => (z, x, y),
            3 => (y, z, x),
            _ => return ball,
        };
        let ring = if along.abs() < 12.0 { 0.5 * self.ring_mm - radius - u.hypot(v) } else { 5.0 };
        ball.min(ring)
    }

    /// Runs a program and returns its log.
    fn run(mut self, program: &str) -> String {
        trueaxis_testing::control::run(program, |touch| {
            self.reverse = touch.reverse;
            self.gap(touch.set_up.unwrap(), self.actual(touch.at, touch.count))
        })
    }
}

fn bench() -> Bench {
    Bench { reverse: [false; 3], lost_x_um: 6.0, drift_um: 0.002, ring_mm: 150.0 }
}

/// A folder with machine, task and program.
fn planned(task: &str) -> (Folder, String) {
    let folder = Folder::new(TRUEAXIS);
    folder.write("mill/machine.toml", MACHINE);
    folder.write("task.toml", task);
    let program = folder.good(&["calibrate", "plan", "task.toml"]);
    (folder, program)
}

const SOLVE: [&str; 5] = ["calibrate", "solve", "task.toml", "probe.log", "-o"];

fn solve<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    SOLVE.iter().copied().chain([output]).chain(more.iter().copied()).collect()
}

#[test]
fn a_ring_and_a_ball_determine_the_machine() {
    let (folder, program) = planned(&whole_task());
    folder.write("probe.log", bench().run(&program));
    let found = folder.json(&solve("mill", &["--json", "--report", "out"]));
    let near = |found: &serde_json::Value, truth: f64, tolerance: f64| {
        assert!((found.as_f64().unwrap() - truth).abs() < tolerance, "{found} for {truth}");
    };
    for (key, truth) in [("C0Y_urad", 50.0), ("B0Z_urad", -20.0), ("A0Z_urad", 30.0)] {
        near(&found["location"][key], truth, 0.1);
    }
    for (axis, scale, backlash) in [("X", 40.0, 6.0), ("Y", -30.0, 3.0), ("Z", 20.0, 0.0)] {
        near(&found["axes"][axis]["scale_ppm"], scale, 0.1);
        near(&found["axes"][axis]["backlash_um"], backlash, 0.02);
    }
    near(&found["tip_radius_mm"], 2.992, 1e-5);
    assert!(found["sigma_um"].as_f64().unwrap() < 0.05, "{found}");
    assert!(found["standard_errors"]["location"]["C0Y_urad"].as_f64().unwrap() > 0.0);
    let text = folder.read("mill/machine.toml");
    for part in
        ["# of my own hand", "[axis.X] # long", "table = \"x.csv\"", "[uncertainty.location]", "[axis.Z.uncertainty]"]
    {
        assert!(text.contains(part), "{text}");
    }
    let page = folder.read("out/calibrate.html");
    assert!(page.contains("Residuals") && page.contains("squareness C0Y"));
    assert!(page.trim_end().ends_with("</html>"), "a whole page");
    // At 0, 500 mm: 40 ppm are 20 µm.
    let (_, rows) = trueaxis_testing::command::csv(&folder.read("mill/x.csv"));
    assert!((rows.last().unwrap()[1] - 20.0).abs() < 0.05 && rows.first().unwrap()[1].abs() < 0.01, "{rows:?}");
    // Errors that the tables already contain are not found a second time.
    let again = folder.json(&solve("mill", &["--json"]));
    near(&again["location"]["C0Y_urad"], 0.0, 0.05);
    near(&again["axes"]["X"]["scale_ppm"], 0.0, 0.05);
    // A lost motion within its scatter is written only if forced.
    let of = |found: &serde_json::Value| {
        found["written"].as_array().unwrap().iter().find(|of| of["key"] == "axis.Z.backlash_um").unwrap().clone()
    };
    let forced = folder.json(&solve("mill", &["--json", "--force", "--dry-run"]));
    assert!(of(&forced)["why"].as_str().unwrap().starts_with("forced, the rule writes "), "{}", of(&forced));
    assert!(of(&forced)["written"].is_object());
}

/// Places chosen for a time go into a task that `plan` takes as it is and gives the same program for; what cannot be is refused
/// and changes nothing.
#[test]
fn places_are_chosen_for_a_time() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("mill/machine.toml", MACHINE);
    let free = "[plan] # from what there is\nfree_mm = [[120.0, 420.0], [100.0, 350.0], [-260.0, -200.0]]\nnormals = [\"Z\"]\n";
    folder.write("hour.toml", format!("{HEAD}{free}{REFERENCE}{BALL}{RING}"));
    let choose = |minutes: &'static str, placed: &'static str| {
        ["calibrate", "plan", "hour.toml", "--minutes", minutes, "--placed", placed, "-o", "hour.ngc"]
    };
    folder.bad(&choose("2", "placed.toml"), &["--minutes: found 2 minutes, needed at least "]);
    folder.bad(&choose("40", "mill/placed.toml"), &["--placed: found mill/placed.toml", "a file beside hour.toml"]);
    let said = folder.reported(&choose("40", "placed.toml"));
    assert!(said.contains("written placed.toml: ") && said.contains("error of the tip expected"), "{said}");
    let placed = folder.read("placed.toml");
    assert!(
        placed.contains("[plan] # from what there is") && placed.matches("[[artefact.place]]").count() > 1,
        "{placed}"
    );
    assert_eq!(folder.good(&["calibrate", "plan", "placed.toml"]), folder.read("hour.ngc"));
}

/// A control that compensates 6 µm too much in X.
#[test]
fn lost_motion_below_zero_refuses_nothing_else() {
    let (folder, program) = planned(&whole_task());
    folder.write("probe.log", Bench { lost_x_um: -6.0, ..bench() }.run(&program));
    let [found, stderr] = folder.both(&solve("mill", &[]));
    assert!(found.contains("note: backlash of X is −6.00 µm: lost motion below zero"), "{found}");
    assert!(
        stderr.lines().any(|line| line.starts_with("axis.X.backlash_um") && line.contains("lost motion below zero")),
        "{stderr}"
    );
    let text = folder.read("mill/machine.toml");
    let (x, y) = text.split_once("[axis.Y]").unwrap();
    assert!(!x.contains("backlash_um") && y.contains("backlash_um = 3") && text.contains("C0Y_urad = 50"), "{text}");
}

#[test]
fn every_dialect_and_a_csv_say_the_same() {
    let (folder, program) = planned(&whole_task());
    let log = bench().run(&program);
    folder.write("probe.log", &log);
    let first = folder.json(&solve("one", &["--json"]));
    let touches: Vec<Vec<&str>> =
        log.lines().filter_map(|line| Some(line.strip_prefix("touch ")?.split(' ').collect())).collect();
    let head = log.lines().next().unwrap();
    let of = |name: &str, text: String| {
        folder.write("task.toml", whole_task().replace("linuxcnc", name));
        folder.write("probe.log", text);
        folder.json(&solve(&format!("out-{name}-{}", name.len()), &["--json"]))
    };
    let grblhal = touches.iter().fold(format!("ok\n[MSG:{head}]\n"), |text, touch| {
        format!(
            "{text}[MSG:touch {}]\n<Idle|MPos:0,0,0>\n[PRB:{},{},{}:1]\nok\n",
            touch[0], touch[1], touch[2], touch[3]
        )
    });
    let klipper = touches.iter().fold(format!("// echo: {head}\n"), |text, touch| {
        format!("{text}Recv: // trueaxis touch {} X:{} Y:{} Z:{} tripped:1\n", touch[0], touch[1], touch[2], touch[3])
    });
    let csv = touches.iter().fold(String::from("id,x_mm,y_mm,z_mm,tripped\n"), |text, touch| {
        format!("{text}{},{},{},{},1\n", touch[0], touch[1], touch[2], touch[3])
    });
    for other in [of("grblhal", grblhal), of("klipper", klipper), of("linuxcnc", csv)] {
        assert_eq!(other["terms"], first["terms"]);
    }
    let plan = |name: &str| {
        folder.write("task.toml", whole_task().replace("linuxcnc", name));
        folder.good(&["calibrate", "plan", "task.toml"])
    };
    assert!(plan("grblhal").contains("(MSG,touch 1)\nG38.2 X"));
    assert!(plan("klipper").contains("TRUEAXIS_PROBE ID=1 X="));
}

#[test]
fn bad_logs_are_refused_with_their_line() {
    let (folder, program) = planned(&whole_task());
    let log = bench().run(&program);
    let lines: Vec<&str> = log.lines().collect();
    let index = lines.iter().position(|line| line.starts_with("touch 30 ")).unwrap();
    let refused = |text: String, parts: &[&str]| {
        folder.write("probe.log", text);
        folder.bad(&solve("mill", &["--report", "out"]), parts)
    };
    let without = [&lines[..index], &lines[index + 1..]].concat().join("\n");
    refused(without, &["probe.log:30:", "no touch 30", "needed all"]);
    let doubled = [&lines[..=index], &lines[index..]].concat().join("\n");
    refused(doubled, &["probe.log:32:", "touch 30 for the second time", "line 31"]);
    let changed = |line: String| {
        let mut lines: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
        lines[index] = line;
        lines.join("\n")
    };
    let words: Vec<f64> = lines[index].split(' ').skip(2).map(|word| word.parse().unwrap()).collect();
    let moved = |by: f64| changed(format!("touch 30 {} {} {} 0 0 0 1", words[0] + by, words[1] + 2.0, words[2] + by));
    refused(moved(4.0), &["probe.log:31:", "touch 30", "beside its probing move", "rapid"]);
    refused(changed(lines[index].replace(" 1.000000", " 0.000000")), &["probe.log:31:", "did not trip"]);
    refused(changed("touch 30 a b c 0 0 0 1".into()), &["probe.log:31:", "\"a\"", "a number"]);
    refused(lines.join("\n").replace("touch 30 ", "touch 9999 "), &["probe.log:31:", "touch 9999", "touches 1 to"]);
    let identity = log.split_whitespace().nth(2).unwrap().to_owned();
    refused(log.replace(&identity, "0000abcd"), &["probe.log:1:", "program 0000abcd", &identity]);
    refused(format!("[PRB:1.0,2.0,3.0:1]\n{log}"), &["probe.log:1:", "grblhal", "linuxcnc"]);
    refused(String::new(), &["probe.log", "no touch 1"]);
    // A control that reports inches.
    let inches = lines.iter().map(|line| match line.strip_prefix("touch ") {
        Some(rest) => {
            let words: Vec<f64> = rest.split(' ').map(|word| word.parse().unwrap()).collect();
            format!("touch {} {:.6} {:.6} {:.6} 0 0 0 1\n", words[0], words[1] / 25.4, words[2] / 25.4, words[3] / 25.4)
        }
        None => format!("{line}\n"),
    });
    refused(inches.collect(), &["probe.log:2:", "touch 1", "only if its numbers are inches", "a log in mm", "$13=0"]);
    // A ring of another size, but within the probing moves: 150.4 mm, plus 16 µm by the tip and 4.5 µm by backlash, minus
    // 0.75 µm by the scales.
    let other = Bench { ring_mm: 150.4, ..bench() };
    refused(other.run(&program), &["probe.log:", "ring at place 1 measured 150.419", "150 mm within 150 µm"]);
    // 0.6 µm per touch amount to 24 µm between two probings of the reference.
    let warm = Bench { drift_um: 0.6, ..bench() };
    refused(warm.run(&program), &["probe.log:", "a drift of", "µm", "less than the measured errors"]);
    assert!(!folder.has("out") && folder.read("mill/machine.toml") == MACHINE);
}

#[test]
fn terms_that_a_set_up_cannot_separate_are_named() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("mill/machine.toml", MACHINE);
    let refused = |task: String, parts: &[&str]| {
        folder.write("task.toml", task);
        folder.bad(&["calibrate", "plan", "task.toml", "-o", "probe.ngc"], parts)
    };
    let text = refused(format!("{HEAD}{RING}{FLAT}"), &["task.toml", "scale of X", "scale of Y", "radius of the tip"]);
    assert!(!text.contains("squareness"), "{text}");
    let square = "[[artefact]]\nname = \"square\"\nkind = \"square\"\narms_mm = [200.0, 150.0]\n\
                  [[artefact.place]]\nat_mm = [100.0, 100.0, -150.0]\n";
    let tip = "tip_uncertainty_um = 5.0\n";
    refused(format!("{HEAD}{tip}{square}"), &["task.toml", "squareness C0Y", "angle of square"]);
    let over = format!("{square}[[artefact.place]]\nat_mm = [350.0, 100.0, -150.0]\nreversed = true\n");
    let expected = |task: String| -> f64 {
        folder.write("task.toml", task);
        let [_, stderr] = folder.both(&["calibrate", "plan", "task.toml", "-o", "probe.ngc"]);
        let line = stderr.lines().find(|line| line.contains("squareness C0Y")).unwrap_or_else(|| panic!("{stderr}"));
        line.split_whitespace().nth(2).unwrap().parse().unwrap()
    };
    // 12 touches of 1 µm at six points over 0.9 of an arm give its direction to 1 µm / (0.31 · length · √12): 4.7 and 6.2 µrad
    // for 200 and 150 mm. Their angle has 7.8 µrad, the mean of both orientations 5.5. A ball sees C0Y only by r u_x u_y: 58
    // touches with r = 15.5 mm, evenly spread, give it to 1 µm / (r √(58/15)) = 33 µrad. The text shows twice that (95 %).
    let turned = expected(format!("{HEAD}{tip}{over}"));
    assert!((10.0..12.0).contains(&turned), "{turned}");
    let by_ball = expected(format!("{HEAD}{BALL}{square}"));
    assert!((50.0..80.0).contains(&by_ball), "{by_ball}");
    assert!(expected(format!("{HEAD}{BALL}{over}")) <= turned);
    refused(format!("{HEAD}colour = 3\n{BALL}"), &["task.toml:5: key probe.colour", "tip_radius_mm"]);
    refused(
        format!("{HEAD}{RING}{FLAT}").replace("250.0, 200.0", "450.0, 200.0"),
        &["task.toml:12:", "within its travel"],
    );
    refused(
        format!("{HEAD}{BALL}").replace("25.0", "-25.0"),
        &["task.toml:8: key artefact.diameter_mm", "0.5 to 2000 mm"],
    );
    refused(
        format!("{HEAD}{BALL}").replace("diameter", "diametre"),
        &["task.toml:8: key artefact.diametre_mm", "needed diameter_mm: its diameter, mm"],
    );
    // Touches at Z −12 are within the travel; the path over the square is not.
    refused(
        format!("{HEAD}{tip}{over}").replace("-150.0", "-12.0"),
        &["task.toml:11: key artefact.place", "a way into and out of it at Z 21", "safe_z_mm of at least 21.000"],
    );
    let gauge = "[[artefact]]\nname = \"gauge\"\nkind = \"step gauge\"\nuncertainty_um = 1.0\nsteps_mm = [0.0, 20.0, 29.0]\n\
                 [[artefact.place]]\nat_mm = [100.0, 100.0, -150.0]\n";
    refused(format!("{HEAD}{gauge}"), &["task.toml:6: key artefact.steps_mm", "9 mm apart", "more than 9 mm"]);
    refused(
        format!("{HEAD}{gauge}").replace("um = 1.0", "um = 1.0\nuncertainty_ppm = -1.0"),
        &["task.toml:9: key artefact.uncertainty_ppm", "0.001 to 1000 ppm"],
    );
    refused(
        format!("{HEAD}{RING}{FLAT}").replace("points = 16", "uncertainty_ppm = 1.0"),
        &["task.toml:10: key artefact.uncertainty_ppm"],
    );
    refused(
        format!("{HEAD}{over}along = \"Z\"\nnormal = \"Y\"\n"),
        &["task.toml:14: key artefact.place.along", "\"X\" or \"Y\" where the square is turned over"],
    );
    refused(HEAD.into(), &["task.toml", "[[artefact]]"]);
    refused(whole_task().replace("\"linuxcnc\"", "\"fanuc\""), &["task.toml:2: key dialect", "\"grblhal\""]);
}
