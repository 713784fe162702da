//! `trueaxis kinematics` as called.

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

/// A machine whose A begins 0.05 degrees beyond the vertical.
const BEGINNING: &str = "\
name = \"beginning\"
chain = \"w C' A' Y' b X Z t\"
[axis.X]
table = \"x.csv\"
[axis.Y]
[axis.Z]
[axis.A]
travel_deg = [0.05, 90.0]
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
fn at_all_axes_zero_the_tip_is_the_tool_plus_and_minus_the_offsets() {
    let directory = folder(
        "\
name = \"offsets, no table\"
chain = \"w C' A' Y' b X Z t\"
tool_mm = [5.0, 6.0, -250.0]
[axis.X]
offset_mm = [10.0, 0.0, 0.0]
[axis.Y]
[axis.Z]
[axis.A]
offset_mm = [0.0, 0.0, 150.0]
[axis.C]
offset_mm = [1.0, 2.0, 3.0]
",
        "x_mm\n0\n",
    );
    let (_, rows) = directory.csv(&with("forward", &["in.csv"]));
    near(&rows[0][1..4], &[14.0, 4.0, -403.0]);
}

#[test]
fn forward_says_where_the_tool_is() {
    // Seen from the workpiece, the spindle leans towards its +y at A −90; C turns that towards −x.
    let directory = folder(TRUNNION, "# poses\nz_mm,a_deg,c_deg,x_mm\n10,0,0,1\n10,-90,0,1\n10,-90,90,0\n");
    let (header, rows) = directory.csv(&with("forward", &["in.csv"]));
    let expected = "z_mm,a_deg,c_deg,x_mm,tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k,singularity_margin_deg";
    assert_eq!(header, expected);
    near(&rows[0][4..], &[1.0, 0.0, 10.0, 0.0, 0.0, 1.0, 0.0]);
    near(&rows[1][4..], &[1.0, 10.0, 0.0, 0.0, 1.0, 0.0, 90.0]);
    near(&rows[2][4..], &[-10.0, 0.0, 0.0, -1.0, 0.0, 0.0, 90.0]);
    // A tool of 50 mm reaches 50 mm less far along the tool axis.
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
    let expected = "tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k,x_mm,y_mm,z_mm,a_deg,c_deg,branch,singularity_margin_deg,\
                    direction_error_deg";
    assert_eq!(header, expected);
    for (row, pose) in rows.iter().zip(&poses) {
        near(&row[6..11], &pose[..5]);
        near(&row[12..13], &pose[11..]);
        assert_eq!(row[13], 0.0);
    }
    // C continues beyond a full turn, also from a start many turns away.
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
    near(&rows[0][9..], &[20.0, 10.0, 1.0, 20.0, 0.0]);
    near(&rows[1][9..], &[-20.0, -170.0, 2.0, 20.0, 0.0]);
    for (branch, row) in ["1", "2"].into_iter().zip(&rows) {
        assert_eq!(&directory.csv(&with("inverse", &["t.csv", "--branch", branch])).1[0], row);
    }
    assert_eq!(directory.csv(&with("inverse", &["t.csv"])).1[0], rows[0]);
}

/// Vectors through the vertical, rounded as a post writes them: C moves only as the noise requires outside the cone, the tip
/// is exact, and the direction is off by the reported amount. In closed form: tip = Rz(C) Rx(A) (x, y, z), direction =
/// Rz(C) Rx(A) (0, 0, 1).
#[test]
fn vectors_through_the_vertical_leave_the_table_where_it_is() {
    let mut text = String::from("tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k\n");
    let noise = [[1, 1], [-1, 1], [0, -1], [-1, 0], [1, -1], [0, 0]];
    for i in -200..=200_i32 {
        let (s, c) = (f64::from(i) * 0.01).to_radians().sin_cos();
        let [u, v] = noise[i.rem_euclid(6) as usize].map(|unit| 1e-6 * f64::from(unit));
        text.push_str(&format!("100,0,20,{:.6},{:.6},{c:.6}\n", s + u, v));
    }
    let directory = folder(TRUNNION, &text);
    let start = ["in.csv", "--start", "0,90"];
    for more in [&[][..], &["--singular-cone-deg", "0.01"], &["--max-step-deg", "0.5"], &["--max-step-deg", "2"]] {
        let (_, rows) = directory.csv(&with("inverse", &[&start[..], more].concat()));
        let mut off = 0.0_f64;
        for row in &rows {
            let [i, j, k] = [row[3], row[4], row[5]].map(|x| x / row[3].hypot(row[4]).hypot(row[5]));
            let ((sa, ca), (sc, cc)) = (row[9].to_radians().sin_cos(), row[10].to_radians().sin_cos());
            let turned = |x: f64, y: f64, z: f64| {
                let (y, z) = (ca * y - sa * z, sa * y + ca * z);
                [cc * x - sc * y, sc * x + cc * y, z]
            };
            near(&turned(row[6], row[7], row[8]), &[100.0, 0.0, 20.0]);
            let [x, y, z] = turned(0.0, 0.0, 1.0);
            let left = (j * z - k * y).hypot(k * x - i * z).hypot(i * y - j * x).asin().to_degrees();
            assert!((left - row[13]).abs() < 1e-9 && left < 2e-4, "{more:?} {row:?}");
            // 1.4e-6 divided by the sine of half the cone.
            let half = if more.contains(&"0.01") { 0.005 } else { 0.05_f64 };
            assert!((row[10] - 90.0).abs() < (1.5e-6 / half.to_radians().sin()).to_degrees(), "{more:?} {row:?}");
            off = off.max(left);
        }
        assert!(rows.len() == 401 && off > 1e-5, "{more:?} {off}");
        assert!((rows[0][9] + rows[400][9]).abs() < 1e-3 && (rows[0][9].abs() - 2.0).abs() < 1e-3);
    }
    // Without a cone every vector is followed.
    let (_, rows) = directory.csv(&with("inverse", &[&start[..], &["--singular-cone-deg", "0"]].concat()));
    assert!(rows.iter().any(|row| (row[10] - 90.0).abs() > 20.0) && rows.iter().all(|row| row[13] == 0.0));
}

/// Machine, direction, input, more arguments, parts of the error.
type Case<'a> = (&'a str, &'a str, &'a str, &'a [&'a str], &'a [&'a str]);

#[test]
fn impossible_inputs_are_refused_with_place_and_figures() {
    let head = "tip_x_mm,tip_y_mm,tip_z_mm,tool_i,tool_j,tool_k\n";
    let four = "name = \"four\"\nchain = \"w X' b Y Z A t\"\n[axis.X]\ntable = \"x.csv\"\n";
    let two = "name = \"two\"\nchain = \"w X' b Z t\"\n[axis.X]\ntable = \"x.csv\"\n";
    let cases: [Case<'_>; 16] = [
        (
            BEGINNING,
            "inverse",
            "0,0,0,0,0.001047,0.9999995\n",
            &["--start", "0.06,0"],
            &["in.csv:2", "tool_i", "0.05998", "from the singular pose", "cone of 0.1"],
        ),
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
