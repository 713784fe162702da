//! `roundness` and `probe-angles` as called, against readings computed from first principles.

use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn reference(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference").join(name)
}

/// Rows of a CSV without its comments and its header.
fn numbers(csv: &str) -> Vec<Vec<f64>> {
    let rows = csv.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

fn close(a: &Value, b: f64, tolerance: f64) {
    let a = a.as_f64().unwrap();
    assert!((a - b).abs() <= tolerance, "{a} {b}");
}

/// Stationary probes at angles in degrees; profile over θ, motion `[x, y]` over revolution and θ.
fn write_probes(
    directory: &Folder,
    points: usize,
    revolutions: usize,
    angles: [f64; 2],
    profile: impl Fn(f64) -> f64,
    motion: impl Fn(usize, f64) -> [f64; 2],
) {
    let mut text = String::from("h1_um,h2_um,h3_um\n");
    for row in 0..points * revolutions {
        let theta = TAU * (row % points) as f64 / points as f64;
        let [x, y] = motion(row / points, theta);
        let [h1, h2, h3] = [0.0, angles[0], angles[0] + angles[1]].map(|phi| {
            let (sin, cos) = phi.to_radians().sin_cos();
            profile(theta + phi.to_radians()) + y * cos + x * sin
        });
        writeln!(text, "{h1},{h2},{h3}").unwrap();
    }
    directory.write("probes.csv", text);
}

const BEST: [f64; 2] = [66.093_75, 234.492_187_5];

#[test]
fn agrees_with_the_reference_script() {
    let directory = Folder::new(TRUEAXIS);
    let probes = reference("separation_probes.csv");
    let arguments = [
        "roundness",
        probes.to_str().unwrap(),
        "--n=64",
        "--phi2-deg=66.1",
        "--phi3-deg=125.4",
        "--harmonics=2..12",
        "--arm=60,300,30",
    ];
    let csv = directory.good(&arguments);
    assert!(csv.starts_with("theta_deg,r_um,rx_um,ry_um\n0,"));
    let text = fs::read_to_string(reference("separation_truth.csv")).unwrap();
    let (found, truth) = (numbers(&csv), numbers(&text));
    assert_eq!((found.len(), truth.len()), (128, 128));
    for (found, truth) in found.iter().zip(&truth) {
        for (found, truth) in found.iter().zip(truth) {
            assert!((found - truth).abs() < 1e-9, "{found:?} {truth:?}");
        }
    }

    let json = directory.json(&[&arguments[..], &["--json", "-o", "out.csv"]].concat());
    assert_eq!(directory.read("out.csv"), csv);
    for line in text.lines().filter(|line| line.starts_with("# spindle")) {
        let mut cells = line.split(' ').skip(2);
        let direction = &json["spindle"][cells.next().unwrap()];
        let names = ["synchronous_um", "asynchronous_um", "total_um", "once_per_revolution_um"];
        for (name, truth) in names.into_iter().chain(["once_per_revolution_phase_deg"]).zip(cells) {
            close(&direction[name], truth.parse().unwrap(), 1e-9);
        }
    }
    let harmonics = json["harmonics"].as_array().unwrap();
    assert_eq!(harmonics.len(), 11);
    // The amplitudes of the script's profile.
    for (harmonic, truth) in harmonics.iter().zip([3.0, 1.75, 0.5, 2.25, 0.0, 1.0, 0.25, 0.75, 0.6, 0.3, 0.9]) {
        close(&harmonic["amplitude_um"], truth, 1e-9);
    }
    close(&harmonics[0]["phase_deg"], 0.3f64.to_degrees(), 1e-9);
    assert_eq!(json["n"], 64);
    assert_eq!(json["revolutions"], 2);
    assert_eq!(json["warnings"], Value::Array(Vec::new()));
}

#[test]
fn zones_of_four_lobes_and_what_the_filter_leaves() {
    let directory = Folder::new(TRUEAXIS);
    let shift = |revolution: usize, theta: f64| [0.25 * revolution as f64, 50.0 * theta.cos()];
    write_probes(&directory, 1024, 3, BEST, |theta| 3.0 * (4.0 * theta).cos() + 0.5 * (92.0 * theta).cos(), shift);
    let arguments = ["roundness", "probes.csv", "--n=1024", "--p=188", "--q=667", "--json"];
    let json = directory.json(&[&arguments[..], &["--upr=15"]].concat());
    // H(4) = 2^−(4/15)², H(92) < 2^−37. Crests at 0°, 90°, …, troughs at 45°, 135°, …: all four circles are concentric.
    let zone = 6.0 * 2f64.powf(-16.0 / 225.0);
    for circle in ["lsc", "mzc", "mic", "mcc"] {
        close(&json[format!("{circle}_um")], zone, 1e-6);
        let centre = &json["centres_um"][circle];
        assert!(centre[0].as_f64().unwrap().abs() < 1e-6 && centre[1].as_f64().unwrap().abs() < 1e-6);
    }
    assert_eq!(json["per_revolution"].as_array().unwrap().len(), 3);
    assert_eq!(json["per_revolution"][2]["revolution"], 3);
    close(&json["per_revolution"][2]["mzc_um"], zone, 1e-6);
    // X moves by 0.25 µm from one revolution to the next, Y not at all.
    let spindle = &json["spindle"];
    close(&spindle["x"]["asynchronous_um"], 0.5, 1e-9);
    close(&spindle["x"]["synchronous_um"], 0.0, 1e-9);
    close(&spindle["x"]["total_um"], 0.5, 1e-9);
    close(&spindle["y"]["once_per_revolution_um"], 50.0, 1e-9);
    close(&spindle["y"]["once_per_revolution_phase_deg"], 0.0, 1e-9);
    // The harmonics are listed before filtering.
    close(&json["harmonics"][90]["amplitude_um"], 0.5, 1e-9);

    // Without the filter both waves have crests and troughs there.
    let json = directory.json(&arguments);
    for circle in ["lsc", "mzc", "mic", "mcc"] {
        close(&json[format!("{circle}_um")], 7.0, 1e-9);
    }
    assert_eq!(json["upr"], Value::Null);
}

#[test]
fn one_revolution_has_no_asynchronous_motion() {
    let directory = Folder::new(TRUEAXIS);
    write_probes(&directory, 512, 1, [108.984_375, 120.9375], |theta| (4.0 * theta).cos(), |_, _| [0.0; 2]);
    let json = directory.json(&["roundness", "probes.csv", "--n=512", "--p=155", "--q=172", "--json"]);
    assert_eq!(json["spindle"]["x"]["asynchronous_um"], Value::Null);
    close(&json["mzc_um"], 2.0, 1e-9);
}

#[test]
fn doubtful_settings_are_warned_of() {
    let directory = Folder::new(TRUEAXIS);
    write_probes(&directory, 1024, 1, [90.0, 181.05], |theta| (2.0 * theta).cos(), |_, _| [0.0; 2]);
    let arguments =
        ["roundness", "probes.csv", "--n=1024", "--phi2-deg=90", "--phi3-deg=181.05", "--upr=150", "--json"];
    let output = directory.run(&[&arguments[..], &["--noise-gain-limit=10"]].concat());
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let warnings: Vec<&str> = json["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    let error = String::from_utf8(output.stderr).unwrap();
    let suppressed: Vec<u64> = json["harmonics"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|harmonic| harmonic["suppressed"] == true)
        .map(|harmonic| harmonic["k"].as_u64().unwrap())
        .collect();
    assert!(!suppressed.is_empty());
    for harmonic in json["harmonics"].as_array().unwrap() {
        assert_eq!(harmonic["suppressed"] == true, harmonic["noise_gain"].as_f64().unwrap() > 10.0);
    }
    let list = suppressed.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
    for part in [format!("harmonics {list} are omitted"), "at least 1050".into(), "ends at harmonic 100".into()] {
        assert!(warnings.iter().any(|warning| warning.contains(&part)), "{part}: {warnings:?}");
        assert!(error.contains(&part), "{error}");
    }
}

#[test]
fn a_bad_measurement_is_refused_with_its_place() {
    let directory = Folder::new(TRUEAXIS);
    let write = |text: &str| directory.write("probes.csv", text);
    let head = "h1_um,h2_um,h3_um\n";
    let roundness = |more: &[&'static str]| {
        let mut arguments = vec!["roundness", "probes.csv", "--n=64", "-o", "out.csv", "--report", "out"];
        arguments.extend(if more.iter().any(|m| m.starts_with("--p")) { &[][..] } else { &["--p=11", "--q=13"] });
        arguments.extend(more);
        arguments
    };
    write(&[head, &"1,2,3\n".repeat(100)].concat());
    let parts = ["probes.csv:101", "100 rows (1 revolution and 36 rows)", "whole revolutions of 64 rows"];
    directory.bad(&roundness(&[]), &parts);
    write(&[head, &"1,2,3\n".repeat(30), "1,inf,3\n", &"1,2,3\n".repeat(33)].concat());
    directory.bad(&roundness(&[]), &["probes.csv:32", "h2_um", "found \"inf\"", "needed a finite number"]);
    write(&[head, &"1,2,3\n".repeat(63), "1,2,nan\n"].concat());
    directory.bad(&roundness(&[]), &["probes.csv:65", "h3_um", "found \"nan\""]);
    write("h1_um,h2_um\n1,2\n");
    directory.bad(&roundness(&[]), &["probes.csv:1", "h3_um"]);
    write(head);
    directory.bad(&roundness(&[]), &["probes.csv", "no rows"]);

    write(&[head, &"1,2,3\n".repeat(64)].concat());
    directory.bad(&roundness(&["--arm=330,300,30"]), &["--arm R:", "found 330 mm", "cannot close"]);
    directory.bad(&roundness(&["--arm=30,300,0"]), &["--arm RW:", "found 0 mm"]);
    directory.bad(&roundness(&["--arm=30,300"]), &["--arm", "R,RS,RW"]);
    directory.bad(&roundness(&["--arm=-1,300,30"]), &["--arm R:", "found -1 mm"]);
    directory.bad(&roundness(&["--upr=60"]), &["--upr: found 60", "15, 50, 150 or 500"]);
    directory.bad(&roundness(&["--noise-gain-limit=0"]), &["--noise-gain-limit", "above 0"]);
    directory.bad(&roundness(&["--noise-gain-limit=nan"]), &["--noise-gain-limit", "NaN"]);
    directory.bad(&["roundness", "probes.csv", "--n=64"], &["no probe angles"]);
    let few = "--harmonics=2..10";
    let blind = roundness(&["--phi2-deg=120", "--phi3-deg=120", few]);
    directory.bad(&blind, &["--phi2-deg", "cannot see harmonics 2, 4, 5, 7, 8, 10,"]);
    assert!(!directory.has("out.csv") && !directory.has("out"));
}

#[test]
fn bad_angles_and_bands_are_refused() {
    let directory = Folder::new(TRUEAXIS);
    let angles = |more: &[&'static str]| [&["probe-angles", "--n=1024", "--harmonics=2..100"], more].concat();
    // 90° and 135°: all singular harmonics are 8 m ± 1.
    let all: Vec<String> = (2..=100).filter(|k| [1, 7].contains(&(k % 8))).map(|k: i32| k.to_string()).collect();
    directory.bad(&angles(&["--p=256", "--q=384"]), &["--p, --q", &format!("see harmonics {},", all.join(", "))]);
    directory.bad(&angles(&["--p=0", "--q=3"]), &["--p: found 0", "1 to 1023"]);
    directory.bad(&angles(&["--p=3", "--q=1024"]), &["--q: found 1024", "1 to 1023"]);
    directory.bad(&angles(&["--p=-3", "--q=3"]), &["--p: found -3"]);
    directory.bad(&angles(&["--p=1.5", "--q=3"]), &["--p", "1.5", "whole number"]);
    directory.bad(&angles(&["--p=512", "--q=3"]), &["--p: found 180", "180°"]);
    directory.bad(&angles(&["--p=3"]), &["--q"]);
    directory.bad(&angles(&["--p=3", "--q=4", "--phi2-deg=3", "--phi3-deg=4"]), &["--phi2-deg"]);
    directory.bad(&angles(&["--phi2-deg=nan", "--phi3-deg=4"]), &["--phi2-deg: found NaN"]);
    directory.bad(&angles(&["--count=0"]), &["--count: found 0"]);
    let band = |n: &'static str, band: &'static str| ["probe-angles", "--n", n, "--harmonics", band];
    directory.bad(&band("1024", "2..512"), &["--harmonics: found 2..512", "N/2 = 512"]);
    directory.bad(&band("1024", "1..9"), &["--harmonics: found 1..9", "2 or more"]);
    directory.bad(&band("1024", "9..8"), &["--harmonics: found 9..8"]);
    directory.bad(&band("1024", "2-9"), &["2-9", "2..100"]);
    for n in ["1000", "32", "8192", "0"] {
        directory.bad(&band(n, "2..9"), &[&format!("--n: found {n}"), "power of two from 64 to 4096"]);
    }
    directory.bad(&band("1e3", "2..9"), &["--n"]);
}

#[test]
fn the_best_pairs_are_found_and_a_given_one_is_compared() {
    let directory = Folder::new(TRUEAXIS);
    let arguments = ["probe-angles", "--n=1024", "--harmonics=2..100", "--json"];
    let json = directory.json(&arguments);
    assert_eq!(json["harmonics"], serde_json::json!([2, 100]));
    assert_eq!(json.get("pair"), None);
    let best = json["best"].as_array().unwrap();
    assert_eq!(best.len(), 20);
    assert_eq!((&best[0]["p"], &best[0]["q"]), (&Value::from(169), &Value::from(188)));
    close(&best[0]["worst_gain"], 0.319, 5e-4);
    close(&best[0]["phi2_deg"], 360.0 * 169.0 / 1024.0, 1e-12);
    let gain = |pair: &Value| pair["worst_gain"].as_f64().unwrap();
    let equals: Vec<&Value> = best.iter().filter(|pair| gain(pair) > gain(&best[0]) - 1e-9).collect();
    assert_eq!(equals.len(), 12);
    assert!(equals.iter().any(|pair| pair["p"] == 188 && pair["q"] == 667));

    for (angles, worst) in [(["90", "181.05"], 0.052), (["60.82", "240.12"], 0.053)] {
        let given = ["--phi2-deg", angles[0], "--phi3-deg", angles[1], "--count=1"];
        let pair = &directory.json(&[&arguments[..], &given].concat())["pair"];
        close(&pair["worst_gain"], worst, 5e-4);
        close(&pair["worst_noise_gain"], 1.0 / gain(pair), 1e-9);
        let noise_gains = pair["noise_gains"].as_array().unwrap();
        assert_eq!(noise_gains.len(), 99);
        let at_worst = noise_gains.iter().find(|entry| entry["k"] == pair["worst_harmonic"]).unwrap();
        assert_eq!(at_worst["noise_gain"], pair["worst_noise_gain"]);
        assert_eq!(pair.get("p"), None);
    }
    // The band excludes the harmonics that the pair cannot see; they are still named.
    let narrow = ["probe-angles", "--n=64", "--harmonics=2..6", "--p=16", "--q=24", "--json"];
    let pair = &directory.json(&narrow)["pair"];
    assert_eq!(pair["singular"], serde_json::json!([7, 9, 15, 17, 23, 25, 31]));
    let table = directory.good(&["probe-angles", "--n=512", "--count=1", "--p=155", "--q=172"]);
    assert!(
        table.contains("100.0 %") && table.lines().filter(|line| line.contains("108.98438")).count() == 2,
        "{table}"
    );
}

/// Checks that the page is well-formed XML with numbers as coordinates; returns its text and the number of figures.
fn read_page(page: &str) -> (String, usize) {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let parsed = roxmltree::Document::parse_with_options(page, options).unwrap();
    let mut svgs = 0;
    for svg in parsed.descendants().filter(|node| node.tag_name().name() == "svg") {
        assert_eq!(svg.tag_name().namespace(), Some("http://www.w3.org/2000/svg"));
        let number = |text: &str| text.parse::<f64>().unwrap_or_else(|_| panic!("{text} is not a number"));
        let size: Vec<f64> = svg.attribute("viewBox").unwrap().split(' ').map(number).collect();
        for shape in svg.descendants() {
            for point in shape.attribute("points").unwrap_or_default().split_whitespace() {
                let (x, y) = point.split_once(',').unwrap();
                assert!((-40.0..=size[2] + 40.0).contains(&number(x)), "{point} in {size:?}");
                assert!((-40.0..=size[3] + 40.0).contains(&number(y)), "{point} in {size:?}");
            }
            if shape.tag_name().name() == "text" && shape.attribute("transform").is_none() {
                // On average, no character of the fonts in the style is wider than this share of its height.
                let height = number(shape.attribute("font-size").unwrap());
                let width = 0.6 * height * shape.text().unwrap_or_default().trim().chars().count() as f64;
                let x = number(shape.attribute("x").unwrap());
                let left = match shape.attribute("text-anchor") {
                    Some("middle") => x - 0.5 * width,
                    Some("end") => x - width,
                    _ => x,
                };
                assert!(left >= 0.0 && left + width <= size[2], "cut: {shape:?} {:?}", shape.text());
            }
        }
        svgs += 1;
    }
    assert_eq!(svgs, page.matches("<svg").count());
    let text = parsed.descendants().filter(roxmltree::Node::is_text).filter_map(|node| node.text()).collect();
    (text, svgs)
}

#[test]
fn the_report_shows_circles_harmonics_and_orbits() {
    let directory = Folder::new(TRUEAXIS);
    let profile = |theta: f64| 1.5 * (2.0 * theta).cos() + (3.0 * theta + 0.4).cos() + 0.2 * (40.0 * theta).sin();
    let motion = |revolution: usize, theta: f64| {
        let wobble = 0.3 * (2.5 * theta + 2.0 * revolution as f64).sin();
        [20.0 * theta.cos() + wobble, (4.0 * theta).cos() - wobble]
    };
    write_probes(&directory, 1024, 5, [90.0, 181.05], profile, motion);
    fs::rename(directory.join("probes.csv"), directory.join("pin & \"x\".csv")).unwrap();
    let arguments = ["roundness", "pin & \"x\".csv", "--n=1024", "--phi2-deg=90", "--phi3-deg=181.05"];
    let more = ["--noise-gain-limit=10", "--upr=50", "--report=deep/er", "-o=out.csv"];
    assert_eq!(directory.good(&[&arguments[..], &more].concat()), "");
    let page = directory.read("deep/er/roundness.html");
    let (text, _) = read_page(&page);
    // One figure each for polar plot, profile, amplitudes, noise gains, orbit, motion over θ; two for the development.
    assert_eq!(page.matches("<figure").count(), 8);
    for part in
        ["LSC", "MZC", "MIC", "MCC", "Magnification 10000 : 1", "one division is", "suppressed: noise", "5 revolutions"]
    {
        assert!(text.contains(part), "{part}");
    }
    assert!(
        text.contains("limit 10") && page.contains("/></svg>limit</span>"),
        "a limit in the figure is in its legend"
    );
    assert!(text.contains("pin & \"x\".csv") && !page.contains("http-equiv") && !page.contains("<script"));

    // Only zeros and one revolution still give a page.
    directory.write("zero.csv", ["h1_um,h2_um,h3_um\n", &"0,0,0\n".repeat(64)].concat());
    let zero = ["roundness", "zero.csv", "--n=64", "--p=11", "--q=13", "--json", "--report=zero"];
    close(&directory.json(&zero)["mzc_um"], 0.0, 0.0);
    let (text, _) = read_page(&directory.read("zero/roundness.html"));
    assert!(text.contains("no development"));

    // A limit far above all gains would flatten them: it is reported, but neither drawn nor in a legend.
    let far =
        ["roundness", "zero.csv", "--n=64", "--p=11", "--q=13", "--noise-gain-limit=1e6", "--report=far", "-o=f.csv"];
    directory.good(&far);
    let page = directory.read("far/roundness.html");
    assert!(page.contains("limit 1000000") && !page.contains("/></svg>limit</span>"));
}

#[test]
fn the_report_of_points_shows_them_with_their_circles() {
    let directory = Folder::new(TRUEAXIS);
    let points = |count: i32, share: f64| {
        let mut text = String::from("x_mm,y_mm\n");
        for i in 0..count {
            let theta = TAU * share * f64::from(i) / f64::from(count);
            let radius = 20.0 + 3e-3 * (3.0 * theta).cos();
            writeln!(text, "{},{}", 100.0 + radius * theta.cos(), -50.0 + radius * theta.sin()).unwrap();
        }
        directory.write("points.csv", text);
    };
    points(72, 1.0);
    let json = directory.json(&["circle", "points.csv", "--json", "--report=out"]);
    close(&json["mzc"]["zone_um"], 6.0, 1e-6);
    let page = directory.read("out/circle.html");
    let (text, _) = read_page(&page);
    // 3 µm on either side: 21 mm on the page allow 5 mm/µm.
    for part in ["LSC, zone 6.00", "MZC", "MCC", "MIC", "Magnification 5000 : 1", "division is 2 µm", "points.csv"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // A part arc has no inscribed circle.
    points(40, 0.3);
    let json = directory.json(&["circle", "points.csv", "--json", "--report=out"]);
    assert_eq!(json["mic"], Value::Null);
    let (text, _) = read_page(&directory.read("out/circle.html"));
    assert!(text.contains("MCC, zone") && !text.contains("MIC, zone"));
    assert!(text.contains(&format!("none: {}", json["refused"]["mic"].as_str().unwrap())), "{text}");
}

/// 20 µm of eccentricity, motion in and out of step with the revolution, 10 nm of noise; each probe with a factor. The profile
/// is the sum of four waves, 3.4 µm peak to valley.
fn warned(directory: &Folder, revolutions: usize, factors: [f64; 3], eccentricity: f64) -> Vec<String> {
    let mut noise = trueaxis_testing::noise::Noise::new(11);
    let mut text = String::from("h1_um,h2_um,h3_um\n");
    for row in 0..1024 * revolutions {
        let theta = TAU * row as f64 / 1024.0;
        let profile = |t: f64| {
            (2.0 * t + 0.3).cos() + 0.5 * (3.0 * t).cos() + 0.3 * (7.0 * t + 1.0).cos() + 0.05 * (31.0 * t).cos()
        };
        let x = eccentricity * theta.cos() + 0.4 * (2.0 * theta).cos() + 0.2 * (5.37 * theta).sin();
        let y = eccentricity * theta.sin() + 0.3 * (3.0 * theta).sin() + 0.2 * (4.61 * theta).cos();
        let angles = [0.0, BEST[0], BEST[0] + BEST[1]].map(f64::to_radians);
        let readings: [f64; 3] = std::array::from_fn(|probe| {
            let phi = angles[probe];
            factors[probe] * (profile(theta + phi) + y * phi.cos() + x * phi.sin()) + 0.017 * noise.signed()
        });
        writeln!(text, "{},{},{}", readings[0], readings[1], readings[2]).unwrap();
    }
    directory.write("probes.csv", text);
    let arguments = ["roundness", "probes.csv", "--n=1024", "--p=188", "--q=667"];
    let json = directory.json(&[&arguments[..], &["--json", "-o", "out.csv"]].concat());
    let warnings: Vec<String> =
        json["warnings"].as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned()).collect();
    // The same warnings appear without --json.
    let [_, stderr] = directory.both(&[&arguments[..], &["-o", "out.csv"]].concat());
    assert!(warnings.iter().all(|warning| stderr.contains(&format!("warning: {warning}"))), "{stderr}");
    warnings
}

/// A probe of reversed polarity, or 3 % off, leaves part of the signal that the three have to cancel.
#[test]
fn contradictory_probes_are_reported() {
    let directory = Folder::new(TRUEAXIS);
    for revolutions in [1, 4] {
        assert_eq!(warned(&directory, revolutions, [1.0; 3], 20.0), [""; 0]);
        assert_eq!(warned(&directory, revolutions, [1.0; 3], 0.0), [""; 0]);
        for probe in 0..3 {
            let with = |factor: f64| std::array::from_fn(|own| if own == probe { factor } else { 1.0 });
            let reversed = warned(&directory, revolutions, with(-1.0), 20.0);
            let named = format!("probe {} has the other polarity", probe + 1);
            assert!(reversed[0].contains("once-per-revolution") && reversed[0].ends_with(&named), "{reversed:?}");
            assert_eq!(reversed.len(), revolutions.min(2), "{reversed:?}");
            let off = warned(&directory, revolutions, with(1.03), 20.0);
            assert!(off.len() == 1 && off[0].contains("the sensitivity or the angle of a probe"), "{off:?}");
        }
    }
    // Without eccentricity, the differences between revolutions reveal it.
    let centred = warned(&directory, 4, [1.0, -1.0, 1.0], 0.0);
    assert!(centred.last().unwrap().contains("differs from revolution to revolution by"), "{centred:?}");
}

#[test]
fn places_of_more_probes_are_found_within_limits() {
    let directory = Folder::new(TRUEAXIS);
    let common = ["probe-angles", "--n=128", "--harmonics=2..40", "--starts=60", "--count=2", "--json"];
    let found = |more: &[&'static str]| directory.json(&[&common[..], more].concat());
    let worst = |document: &Value| document["best"][0]["worst_noise_gain"].as_f64().unwrap();
    let by_count = ["--probes=3", "--probes=4", "--probes=5", "--probes=6"].map(|probes| worst(&found(&[probes])));
    assert!(by_count.windows(2).all(|two| two[1] < two[0]), "{by_count:?}");
    // Three probes: no better than the search over all pairs.
    let pairs = directory.json(&["probe-angles", "--n=128", "--harmonics=2..40", "--count=1", "--json"]);
    assert!(by_count[0] >= worst(&pairs) * (1.0 - 1e-9), "{by_count:?} {pairs}");

    let angles = |places: &Value| -> Vec<f64> {
        places["angles_deg"].as_array().unwrap().iter().map(|angle| angle.as_f64().unwrap()).collect()
    };
    let limited = found(&["--probes=4", "--apart-deg=25", "--within-deg=170", "--angles-deg=0,31,77,160"]);
    for places in limited["best"].as_array().unwrap() {
        let mut angles = angles(places);
        angles.push(angles[0] + 360.0);
        let gaps: Vec<f64> = angles.windows(2).map(|two| two[1] - two[0]).collect();
        assert!(gaps.iter().all(|gap| *gap >= 25.0) && gaps.iter().any(|gap| 360.0 - gap <= 170.0), "{gaps:?}");
    }
    let given = &limited["given"];
    assert_eq!(angles(given), [0.0, 31.0, 77.0, 160.0]);
    assert_eq!(given["noise_gains"].as_array().unwrap().len(), 39);
    close(&given["share_of_best"], worst(&limited) / given["worst_noise_gain"].as_f64().unwrap(), 1e-9);
    // Only three of the probes at 0, 31, 77, 160°: four arrangements, by the gain of pairs.
    let left = [["46", "83"], ["77", "83"], ["31", "129"], ["31", "46"]].map(|[phi2, phi3]| {
        let pair = ["--harmonics=2..40", "--count=1", "--json", "--phi2-deg", phi2, "--phi3-deg", phi3];
        directory.json(&[&["probe-angles", "--n=128"][..], &pair].concat())["pair"]["worst_noise_gain"]
            .as_f64()
            .unwrap()
    });
    close(&given["worst_without_one"], left.into_iter().fold(0.0, f64::max), 1e-9);
    let table = directory.good(&[
        "probe-angles",
        "--n=128",
        "--probes=4",
        "--starts=1",
        "--count=1",
        "--angles-deg=0,31,77,160",
    ]);
    assert!(table.contains("0.000, 31.000, 77.000, 160.000") && table.contains("% of the best gain"), "{table}");
}

#[test]
fn bad_places_of_probes_are_refused() {
    let directory = Folder::new(TRUEAXIS);
    let bad =
        |more: &[&'static str], words: &[&str]| directory.bad(&[&["probe-angles", "--n=128"], more].concat(), words);
    bad(&["--probes=2"], &["--probes: found 2", "3 to 6"]);
    bad(&["--probes=4", "--p=3", "--q=5"], &["--probes", "--p"]);
    bad(&["--probes=4", "--angles-deg=0,40,90"], &["--angles-deg: found 3 angles", "needed 4"]);
    bad(&["--angles-deg=0,40,40,90"], &["--angles-deg, probe 3: found 40", "a place of its own"]);
    bad(&["--angles-deg=0,nan,90"], &["--angles-deg, probe 2: found NaN"]);
    bad(&["--angles-deg=0,90,180,270"], &["cannot see harmonics 3, 5, 7"]);
    bad(&["--probes=4", "--apart-deg=91"], &["--apart-deg: found 91", "at most 90", "4 probes"]);
    bad(&["--probes=4", "--apart-deg=40", "--within-deg=100"], &["--apart-deg: found 40", "33.3333", "--within-deg"]);
    bad(&["--apart-deg=-3"], &["--apart-deg: found -3", "above 0"]);
    bad(&["--within-deg=361"], &["--within-deg: found 361"]);
    bad(&["--probes=4", "--starts=0"], &["--starts: found 0"]);
}

const FIVE: &str = "--angles-deg=0,39.2,101.3,158.9,243.3";

#[test]
fn five_probes_agree_with_least_squares_of_the_reference_script() {
    let directory = Folder::new(TRUEAXIS);
    let probes = reference("separation_five_probes.csv");
    let arguments = ["roundness", probes.to_str().unwrap(), "--n=64", FIVE, "--harmonics=2..12", "--arm=60,300,30"];
    let found = numbers(&directory.good(&arguments));
    let truth = numbers(&fs::read_to_string(reference("separation_five_truth.csv")).unwrap());
    assert_eq!((found.len(), truth.len()), (128, 128));
    for (found, truth) in found.iter().zip(&truth) {
        for (found, truth) in found.iter().zip(truth) {
            assert!((found - truth).abs() < 1e-9, "{found:?} {truth:?}");
        }
    }
    let json = directory.json(&[&arguments[..], &["--json", "--report", "report"]].concat());
    let agreement = &json["agreement"];
    // σ of numbers distributed uniformly over ±0.2 µm.
    close(&agreement["noise_um"], 0.2 / 3.0_f64.sqrt(), 0.02);
    assert!(agreement["disagreeing"].is_null() && json["warnings"].as_array().unwrap().is_empty(), "{json}");
    assert_eq!(agreement["probes"].as_array().unwrap().len(), 5);
    assert!(directory.read("report/roundness.html").contains("The probes against one another"));
}

/// Readings of stationary probes at angles in degrees, with noise of up to 0.05 µm.
fn probes_at(
    degrees: &[f64],
    theta: impl Fn(usize) -> f64,
    rows: usize,
    change: impl Fn(usize, usize, f64) -> f64,
) -> String {
    let mut noise = trueaxis_testing::noise::Noise::new(3);
    let mut text: String = (1..=degrees.len()).map(|probe| format!("h{probe}_um,")).collect();
    text += "theta_deg\n";
    for row in 0..rows {
        let theta = theta(row).to_radians();
        for (probe, degrees) in degrees.iter().enumerate() {
            let phi = degrees.to_radians();
            let waves = [(2.0, 3.0), (3.0, 1.0), (5.0, 2.0), (9.0, 1.0), (14.0, 0.5), (23.0, 0.4)];
            let profile: f64 = waves.iter().map(|(k, um)| um * (k * (theta + phi) + k).cos()).sum();
            let motion = 40.0 * (theta + 0.3).sin() * phi.cos() + 40.0 * theta.cos() * phi.sin();
            write!(text, "{},", change(probe, row, profile + motion + 0.05 * noise.signed())).unwrap();
        }
        writeln!(text, "{}", theta.to_degrees()).unwrap();
    }
    text
}

#[test]
fn a_probe_that_disagrees_is_named_from_five_probes_on() {
    let directory = Folder::new(TRUEAXIS);
    let wave =
        |probe: usize, row: usize, value: f64| if probe == 2 { value + 0.8 * (row as f64 * 0.7).sin() } else { value };
    let even = |row: usize| 360.0 * row as f64 / 256.0;
    for (degrees, named) in [([0.0, 39.2, 101.3, 158.9, 243.3].as_slice(), true), (&[0.0, 51.1, 123.4, 201.7], false)] {
        let angles: Vec<String> = degrees.iter().map(f64::to_string).collect();
        let angles = format!("--angles-deg={}", angles.join(","));
        directory.write("probes.csv", probes_at(degrees, even, 512, wave));
        let arguments = ["roundness", "probes.csv", "--n=256", &angles, "--harmonics=2..40", "--json"];
        let json = directory.json(&arguments);
        let warning = json["warnings"][0].as_str().unwrap();
        if named {
            assert_eq!(json["agreement"]["disagreeing"], 3);
            assert!(warning.starts_with("probe 3 disagrees with the others"), "{warning}");
        } else {
            assert!(json["agreement"]["disagreeing"].is_null());
            assert!(warning.ends_with("not as stated; four probes do not tell which"), "{warning}");
        }
        // Sound readings at other angles than the points, with a sensitivity 2 % too high.
        let scaled = |probe: usize, _: usize, value: f64| if probe == 1 { 1.02 * value } else { value };
        directory.write("probes.csv", probes_at(degrees, |row| 0.7 * row as f64, 1400, scaled));
        let probe = &directory.json(&arguments)["agreement"]["probes"][1];
        let [found, error] =
            ["sensitivity_error", "sensitivity_error_standard_error"].map(|key| probe[key].as_f64().unwrap());
        assert!((found - 0.02).abs() < 4.0 * error && error < 0.005, "{probe}");
    }
}

#[test]
fn places_that_do_not_suit_the_readings_are_refused() {
    let directory = Folder::new(TRUEAXIS);
    directory
        .write("probes.csv", probes_at(&[0.0, 51.1, 123.4, 201.7], |row| 360.0 * row as f64 / 64.0, 64, |_, _, h| h));
    for (angles, needed) in [
        (&["--angles-deg=0,51.1,123.4"][..], "probes.csv:1: found a column h4_um, needed the readings of 3 probes"),
        (
            &["--phi2-deg=51.1", "--phi3-deg=72.3"],
            "probes.csv:1: found a column h4_um, needed the readings of 3 probes",
        ),
        (&[FIVE], "probes.csv:1: found no column h5_um, needed the readings of 5 probes"),
        (&["--angles-deg=0,90,180,270"], "--angles-deg: found angles that cannot see harmonics 3, 5, 7"),
        (&["--angles-deg=0,90,181,450"], "--angles-deg, probe 4: found 450, needed angles from −360 to 360°"),
        (&["--angles-deg=0,90,181,-179"], "--angles-deg, probe 4: found -179, needed a place of its own"),
        (&["--angles-deg=0,90"], "--angles-deg: found 2, needed the angles of three to six probes"),
        (&[], "needed --p and --q, --phi2-deg and --phi3-deg, or --angles-deg"),
    ] {
        let arguments = [&["roundness", "probes.csv", "--n=64", "--harmonics=2..12"], angles].concat();
        directory.bad(&arguments, &[needed]);
    }
}
