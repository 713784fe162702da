//! `trueaxis kinematics` as it is called.

use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// A trunnion machine, zero of the axes in the trunnion, A from −120 to 30 degrees.
const TRUNNION: &str = "\
name = \"trunnion\"
chain = \"w C' A' Y' b X Z t\"
tool_mm = [0.0, 0.0, 0.0]
[axis.X]
table = \"x.csv\"
travel_mm = [-250.0, 250.0]
[axis.Y]
[axis.Z]
[axis.A]
travel_deg = [-120.0, 30.0]
[axis.C]
";

fn folder(machine: &str, input: &str) -> Folder {
    let directory = Folder::new(TRUEAXIS);
    directory.write("m/machine.toml", machine);
    directory.write("m/x.csv", "X_mm,EXX_um\n-250,0\n250,0\n");
    directory.write("in.csv", input);
    directory
}

fn with<'a>(way: &'a str, arguments: &[&'a str]) -> Vec<&'a str> {
    [&["kinematics", way, "--machine", "m"], arguments].concat()
}

fn near(found: &[f64], truth: &[f64]) {
    assert_eq!(found.len(), truth.len());
    for (found_one, true_one) in found.iter().zip(truth) {
        assert!((found_one - true_one).abs() < 1e-10, "{found:?} for {truth:?}");
    }
}

#[test]
fn forward_says_where_the_tool_is() {
    // The workpiece sees the spindle lean towards its +y at A −90; C turns that towards −x.
    let directory = folder(TRUNNION, "# poses\nz_mm,a_deg,c_deg,x_mm\n10,0,0,1\n10,-90,0,1\n10,-90,90,0\n");
    let (header, rows) = directory.csv(&with("forward", &["in.csv"]));
    let expected = "z_mm,a_deg,c_deg,x_mm,tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k,singularity_margin_deg";
    assert_eq!(header, expected);
    near(&rows[0][4..], &[1.0, 0.0, 10.0, 0.0, 0.0, 1.0, 0.0]);
    near(&rows[1][4..], &[1.0, 10.0, 0.0, 0.0, 1.0, 0.0, 90.0]);
    near(&rows[2][4..], &[-10.0, 0.0, 0.0, -1.0, 0.0, 0.0, 90.0]);
    // A tool of 50 mm reaches 50 mm less far along its axis.
    let (_, rows) = directory.csv(&with("forward", &["in.csv", "--tool-length-mm", "50"]));
    near(&rows[1][4..7], &[1.0, -40.0, 0.0]);
    let (_, rows) = directory.csv(&with("forward", &["in.csv", "--tool-mm", "-1,0,-50"]));
    near(&rows[1][4..7], &[0.0, -40.0, 0.0]);
}

#[test]
fn the_inverse_takes_the_forwards_output_back() {
    let mut text = String::from("x_mm,y_mm,z_mm,a_deg,c_deg\n");
    for i in 0..100 {
        let i = f64::from(i);
        text.push_str(&format!("{},{},{},{},{}\n", i, 0.3 * i - 7.0, 40.0 - i, -1.0 - i, 11.7 * i));
    }
    let directory = folder(TRUNNION, &text);
    let tool = ["--tool-length-mm", "120.5"];
    let (_, poses) = directory.csv(&with("forward", &["in.csv", tool[0], tool[1]]));
    assert_eq!(directory.good(&with("forward", &["in.csv", "-o", "t.csv", tool[0], tool[1]])), "");
    let reported = directory.reported(&with("inverse", &["t.csv", tool[0], tool[1], "--max-step-deg", "12"]));
    assert!(reported.contains("x_mm, y_mm, z_mm, a_deg, c_deg"), "{reported}");
    let (header, rows) = directory.csv(&with("inverse", &["t.csv", tool[0], tool[1]]));
    let expected =
        "tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k,x_mm,y_mm,z_mm,a_deg,c_deg,branch,singularity_margin_deg";
    assert_eq!(header, expected);
    for (row, pose) in rows.iter().zip(&poses) {
        near(&row[6..11], &pose[..5]);
        near(&row[12..], &pose[11..]);
    }
    // C goes on beyond a turn, also from a start many turns away.
    let (_, rows) = directory.csv(&with("inverse", &["t.csv", tool[0], tool[1], "--start", "-1,-3600"]));
    near(&rows[99][9..11], &[-100.0, 11.7 * 99.0 - 3600.0]);
    let document = directory.json(&with("inverse", &["t.csv", "--json"]));
    assert_eq!(document["machine"], "trunnion");
    assert_eq!(document["rows"].as_array().unwrap().len(), 100);
    assert_eq!(document["rows"][5]["branch"], rows[5][11] as u64);
    assert!((document["rows"][5]["a_deg"].as_f64().unwrap() + 6.0).abs() < 1e-10);
}

#[test]
fn both_branches_and_the_one_asked_for() {
    let directory = folder(TRUNNION, "a_deg,c_deg\n20,10\n");
    directory.good(&with("forward", &["in.csv", "-o", "t.csv"]));
    let (_, rows) = directory.csv(&with("inverse", &["t.csv", "--both"]));
    assert_eq!(rows.len(), 2);
    near(&rows[0][9..], &[20.0, 10.0, 1.0, 20.0]);
    near(&rows[1][9..], &[-20.0, -170.0, 2.0, 20.0]);
    for (branch, row) in ["1", "2"].into_iter().zip(&rows) {
        assert_eq!(&directory.csv(&with("inverse", &["t.csv", "--branch", branch])).1[0], row);
    }
    assert_eq!(directory.csv(&with("inverse", &["t.csv"])).1[0], rows[0]);
}

/// Machine, way, input, more arguments, what the error names.
type Case<'a> = (&'a str, &'a str, &'a str, &'a [&'a str], &'a [&'a str]);

#[test]
fn what_cannot_be_is_refused_with_place_and_figures() {
    let head = "tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k\n";
    let four = "name = \"four\"\nchain = \"w X' b Y Z A t\"\n[axis.X]\ntable = \"x.csv\"\n";
    let two = "name = \"two\"\nchain = \"w X' b Z t\"\n[axis.X]\ntable = \"x.csv\"\n";
    let cases: [Case<'_>; 16] = [
        (TRUNNION, "inverse", "0,0,0,0,0,1\n", &[], &["in.csv:2", "tool_i", "0 degrees from the singular pose", "0.1"]),
        (TRUNNION, "inverse", "0,0,0,0,0.6,0.8\n0,0,0,0,0,2\n", &[], &["in.csv:3", "length 2", "1e-3"]),
        (TRUNNION, "inverse", "0,0,0,0,-0.6,0.8\n0,0,0,0.6,0,0.8\n", &["--max-step-deg", "5"], &["in.csv:3", "5"]),
        (TRUNNION, "inverse", "0,0,0,0,-0.6,0.8\n400,0,0,0,-0.6,0.8\n", &[], &["in.csv:3", "axis X", "-250 to 250"]),
        (
            TRUNNION,
            "inverse",
            "0,0,0,0,0.6,0.8\n",
            &["--branch", "1", "--start", "0,0"],
            &["axis A", "36.8", "-120 to 30"],
        ),
        (TRUNNION, "inverse", "0,0,nan,0,0.6,0.8\n", &[], &["in.csv:2", "tip_z_mm", "nan"]),
        (TRUNNION, "inverse", "0,0,0,0,0.6\n", &[], &["in.csv:2", "5 values"]),
        (TRUNNION, "inverse", "0,0,0,0,0.6,0.8\n", &["--start", "1,2,3"], &["--start", "3 angles", "AC"]),
        (TRUNNION, "inverse", "0,0,0,0,0.6,0.8\n", &["--singular-cone-deg", "50"], &["--singular-cone-deg", "50"]),
        (TRUNNION, "inverse", "0,0,0,0,0.6,0.8\n", &["--max-step-deg", "0"], &["--max-step-deg"]),
        (TRUNNION, "inverse", "0,0,0,0,0.6,0.8\n", &["--tool-mm", "1,2"], &["--tool-mm", "2 numbers"]),
        (TRUNNION, "forward", "x_mm,b_deg\n0,0\n", &[], &["in.csv", "b_deg", "trunnion"]),
        (TRUNNION, "forward", "x_mm,a_deg\n0,0\n0,31\n", &[], &["in.csv:3", "a_deg", "31", "-120 to 30"]),
        (TRUNNION, "forward", "x_mm,w_deg\n0,0\n", &[], &["in.csv:1", "w_deg"]),
        (four, "inverse", "0,0,0,0.6,0,0.8\n", &[], &["in.csv:2", "36.8", "beyond reach"]),
        (two, "inverse", "0,0,0,0.6,0,0.8\n", &[], &["m: ", "chain", "X, Y and Z"]),
    ];
    for (machine, way, text, more, parts) in cases {
        let text = if way == "inverse" { format!("{head}{text}") } else { text.to_owned() };
        let directory = folder(machine, &text);
        directory.bad(&with(way, &[&["in.csv", "-o", "out.csv"], more].concat()), parts);
    }
    let directory = folder(TRUNNION, "tip_x_mm,tip_y_mm\n0,0\n");
    directory.bad(&with("inverse", &["in.csv"]), &["in.csv:1", "tip_z_mm"]);
}
