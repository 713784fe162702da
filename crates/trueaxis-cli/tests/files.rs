//! Commands and files: no command overwrites an input, an edited machine keeps its text, and a refused command leaves no
//! files.

use std::fs;
use std::path::Path;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// A machine as its owner keeps it.
const MACHINE: &str = "\
# The mill in hall 2; do not touch the chain.
name = \"hall 2\"   # as on the plate
chain = \"w X' Y' b Z t\"

[axis.Y]            # Y first: it was measured first
travel_mm = [-200, 200]
table = 'y-2024.csv'    # laser, spring
interpolation = \"cubic\"
backlash_um = 2.5

[axis.X]
travel_mm = [-300.0, 300.0]
max_feed_mm_per_min = 15_000
[axis.X.thermal]
expansion_um_per_m_k = 11.5

# squareness from the ball bar
[location]
C0Y_urad = 20
";

const Y: &str = "Y_mm,EYY_um,EXY_um\n-200,1,0\n200,9,2\n";
const COMP: &str = "-100 -99.999 -99.998\n0 0.001 0.002\n100 100.003 100.004\n";

fn hall_2(directory: &Folder) {
    directory.write("m/machine.toml", MACHINE);
    directory.write("m/y-2024.csv", Y);
    directory.write("new.comp", COMP);
}

#[test]
fn an_import_adds_an_axis_and_leaves_the_rest_of_the_machine_as_it_is_written() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    let said = directory
        .reported(&["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "X", "-o", "m"]);
    for part in ["axis X: table added, 3 lines of EXX", "written m/x.csv", "written m/machine.toml"] {
        assert!(said.contains(part), "{said}");
    }
    let expected =
        MACHINE.replace("max_feed_mm_per_min = 15_000\n", "max_feed_mm_per_min = 15_000\ntable = \"x.csv\"\n");
    assert_eq!(directory.read("m/machine.toml"), expected);
    assert_eq!(directory.read("m/x.csv"), "X_mm,EXX_fwd_um,EXX_rev_um\n-100,1,2\n0,1,2\n100,3,4\n");
    assert_eq!(directory.read("m/y-2024.csv"), Y);
    // An axis in the chain without a section gets one.
    let said = directory
        .reported(&["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "Z", "-o", "m"]);
    assert!(said.contains("axis Z: table added"), "{said}");
    let with_z = directory.read("m/machine.toml");
    let section = "\n[axis.Z]\ntable = \"z.csv\"\ninterpolation = \"linear\"\ntravel_mm = [-100.0, 100.0]\n";
    assert!(with_z.contains(section), "{with_z}");
    assert_eq!(with_z.replace(section, ""), expected);
    directory.reported(&["tables", "check", "m"]);
}

#[test]
fn an_import_replaces_a_table_in_its_place_and_says_what_was_there() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    let said = directory
        .reported(&["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "Y", "-o", "m"]);
    for part in [
        "axis Y: table replaced, 3 lines of EYY instead of 2 lines of EXY EYY",
        "backlash_um set to 0, as both directions",
        "written m/y-2024.csv",
    ] {
        assert!(said.contains(part), "{said}");
    }
    assert_eq!(directory.read("m/machine.toml"), MACHINE.replace("backlash_um = 2.5", "backlash_um = 0.0"));
    assert!(directory.read("m/y-2024.csv").starts_with("Y_mm,EYY_fwd_um,EYY_rev_um\n"));
    // The same import again changes nothing in machine.toml.
    let once = directory.read("m/machine.toml");
    let said = directory
        .reported(&["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "Y", "-o", "m"]);
    assert!(said.contains("m/machine.toml stays as it is") && !said.contains("written m/machine.toml"), "{said}");
    assert_eq!(directory.read("m/machine.toml"), once);
}

/// A bed that rises by 0.2 mm: the import sets the limit that it needs and says so; if a limit clips corrections, the commands
/// that show them say by how much.
#[test]
fn clipped_corrections_are_reported() {
    let directory = Folder::new(TRUEAXIS);
    let row = "#*# \t0.0, 0.1, 0.2\n";
    directory.write(
        "printer.cfg",
        format!(
            "#*# [bed_mesh default]\n#*# points =\n{row}{row}#*# x_count = 3\n#*# y_count = 2\n#*# min_x = 20\n#*# max_x = 220\n\
             #*# min_y = 20\n#*# max_y = 180\n"
        ),
    );
    let said = directory.reported(&["tables", "import", "--from", "bed-mesh", "printer.cfg", "-o", "t"]);
    assert!(said.contains("limits.magnitude_um of axis Z set to 240, as the corrections reach 200"), "{said}");
    directory.write("p.csv", "x_mm,y_mm,z_mm\n20,100,0\n220,100,0\n");
    let compensate = ["compensate", "t", "p.csv"];
    assert_eq!(directory.reported(&compensate), "");
    assert!(directory.read("t/machine.toml").contains("[axis.Z.limits]\nmagnitude_um = 240"));
    directory.write("t/machine.toml", directory.read("t/machine.toml").replace("= 240", "= 100"));
    let note = "note: axis Z: the magnitude limit removes up to 100 µm of the correction in 1 position, most at X220 Y100 Z0; \
                [axis.Z.limits] magnitude_um is 100, 200 would pass all of it";
    assert_eq!(directory.reported(&compensate).trim(), note);
    let correct = ["correct", "t", "--at", "220,100,0"];
    assert_eq!(directory.reported(&correct).trim(), note);
    assert_eq!(directory.json(&[&correct[..], &["--json"]].concat())["clipped"], serde_json::json!(["Z"]));
}

/// A table of an instrument with its own names, a height map and a printed mesh become machines; options that do not belong to
/// the format are refused.
#[test]
fn files_of_instruments_and_printers_are_imported() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("t.csv", "No;Pos;Fwd;Rev\n1;0;0,4;1,9\n2;50;1;2,5\n3;100;-2,1;3,6\n");
    let columns = ["tables", "import", "--from", "columns", "t.csv", "--axis", "X", "--unit", "um", "--columns"];
    let said = directory.reported(&[&columns[..], &["position=Pos,forward=Fwd,reverse=Rev", "-o", "m"]].concat());
    assert!(
        said.contains("Pos in mm; Fwd and Rev in um are deviations, +E") && said.contains("not read: No"),
        "{said}"
    );
    assert_eq!(directory.read("m/x.csv"), "X_mm,EXX_fwd_um,EXX_rev_um\n0,0.4,1.9\n50,1,2.5\n100,-2.1,3.6\n");
    directory.bad(
        &[&columns[..], &["position=Pos,forward=Forw", "-o", "n"]].concat(),
        &["t.csv:1: found no column for --columns forward=Forw, needed one of No, Pos, Fwd, Rev"],
    );
    let map = "RepRapFirmware height map file v2\nxmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum\n\
               0,200,0,100,-1,100,100,3,2\n 0.000, 0.100, 0.176\n 0.000, 0.100, 0.176\n";
    directory.write("heightmap.csv", map);
    let said = directory.reported(&["tables", "import", "--from", "heightmap", "heightmap.csv", "-o", "p"]);
    assert!(said.contains("limits.magnitude_um of axis Z set to 220, as the corrections reach 176"), "{said}");
    directory.write("log.txt", "Bilinear Leveling Grid:\n 0 1 2\n0 +0.000 +0.100 +0.150\n1 +0.000 +0.100 +0.176\n\n");
    let marlin = ["tables", "import", "--from", "marlin", "log.txt", "-o", "p"];
    directory.bad(&marlin, &["log.txt:1: found a mesh of 3 by 2 points without an area", "--area X,Y,X,Y"]);
    let said = directory.reported(&[&marlin[..], &["--area", "-10,0,190,100"]].concat());
    assert!(said.contains("the grid \"grid.csv\" is replaced"), "{said}");
    assert!(directory.read("p/grid.csv").starts_with("X_mm,Y_mm,EZ_um\n-10,0,0\n-10,100,0\n90,0,-100\n"));
    for (more, words) in [
        (["--area", "0,0,1"], "--area: found \"0,0,1\", needed X,Y,X,Y"),
        (["--columns", "position=a,forward=b"], "--columns: found it with marlin, needed --from columns"),
        (["--mesh", "warm"], "--mesh: found it with marlin"),
    ] {
        directory.bad(&[&marlin[..], &more].concat(), &[words]);
    }
    directory.bad(&[&marlin[..], &["--area", "0,0,1,1", "--unit", "mm"]].concat(), &["--unit: found it with marlin"]);
    let grid = ["tables", "import", "--from", "grid", "p/grid.csv", "--area", "0,0,1,1", "-o", "q"];
    directory.bad(&grid, &["--area: found it with grid, needed --from marlin"]);
}

/// Errors stated in the settings need no table, and kinematics needs only the chain.
#[test]
fn a_machine_needs_no_table() {
    let directory = Folder::new(TRUEAXIS);
    let machine = |more: &str| {
        format!(
            "name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.Y]\ntravel_mm = [-200.0, 200.0]\nhysteresis_um = 1.0\n{more}\n"
        )
    };
    directory.write("a/machine.toml", machine("backlash_um = 20.0"));
    directory.write("b/machine.toml", machine("backlash_um = 20.0\ntable = \"y.csv\""));
    directory.write("b/y.csv", "Y_mm,EYY_um\n-200,0\n200,0\n");
    directory.write("p.csv", "x_mm,y_mm,z_mm\n0,0,0\n10,-30.1,5\n");
    for model in ["nine", "volumetric", "exact"] {
        for side in [&[][..], &["--reverse"], &["--in-order"]] {
            let [a, b] =
                ["a", "b"].map(|m| directory.csv(&[&["compensate", m, "p.csv", "--model", model], side].concat()));
            assert_eq!(a, b, "{model} {side:?}");
            let back = if side == ["--reverse"] { -0.02 } else { 0.0 };
            assert!((a.1[0][7] - back).abs() < 1e-9, "{model} {side:?}: {a:?}");
        }
    }
    assert!(!directory.reported(&["tables", "check", "a"]).contains("without a table"));
    directory.good(&["tables", "compile", "a", "-o", "a.tcomp"]);
    // Squareness only, 100 µrad over 200 mm.
    directory.write("s/machine.toml", machine("[location]\nC0Y_urad = 100.0"));
    directory.good(&["tables", "check", "s"]);
    directory.write("p.csv", "x_mm,y_mm,z_mm\n0,200,0\n");
    let (_, rows) = directory.csv(&["compensate", "s", "p.csv"]);
    assert!((rows[0][6] - 0.02).abs() < 1e-9, "{rows:?}");
    // Only a chain.
    directory.write("k/machine.toml", "name = \"m\"\nchain = \"w C' A' b X Y Z t\"\n");
    directory.write("joints.csv", "x_mm,y_mm,z_mm,a_deg,c_deg\n1,2,3,0,0\n");
    let (_, rows) = directory.csv(&["kinematics", "forward", "--machine", "k", "joints.csv"]);
    assert!((rows[0][5..8].iter().zip([1.0, 2.0, 3.0])).all(|(found, truth)| (found - truth).abs() < 1e-9), "{rows:?}");
    let printed = directory.both(&["tables", "check", "k"]).concat();
    assert!(printed.contains("no errors are stated"), "{printed}");
}

#[test]
fn windows_line_ends_and_inline_sections_stay() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    directory.write("m/machine.toml", format!("\u{feff}{}", MACHINE.replace('\n', "\r\n")));
    directory
        .reported(&["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "X", "-o", "m"]);
    let expected =
        MACHINE.replace("max_feed_mm_per_min = 15_000\n", "max_feed_mm_per_min = 15_000\ntable = \"x.csv\"\n");
    assert_eq!(directory.read("m/machine.toml"), format!("\u{feff}{}", expected.replace('\n', "\r\n")));

    let inline =
        "name = \"i\"\nchain = \"w b X Y t\"\naxis = { X = { table = \"a.csv\" }, Y = { backlash_um = 1 } } # both\n";
    directory.write("i/machine.toml", inline);
    directory.write("i/a.csv", "X_mm,EXX_um\n0,0\n1,0\n");
    directory
        .reported(&["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "X", "-o", "i"]);
    assert_eq!(directory.read("i/machine.toml"), inline);
    assert!(directory.read("i/a.csv").contains("100,3,4"));
}

/// Names from the ISG manual: Y0A without an axis A. No key of machine.toml is at fault.
#[test]
fn location_errors_of_an_absent_axis_name_the_chain() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    directory.write("names.csv", "Y0A\tZ0A\n0.1\t0.2\n#\nX\tEXX\n0\t0.002\n10\t0.001\n");
    let new = ["tables", "import", "--from", "isg", "names.csv", "-o", "new"];
    directory
        .bad(&new, &["names.csv: found location errors of axis A (EY0A EZ0A)", "// trueaxis chain: w b X Y Z A t"]);
    directory.bad(
        &["tables", "import", "--from", "isg", "names.csv", "-o", "m"],
        &["machine.toml", "chain", "axis A in the chain"],
    );
}

#[test]
fn an_import_into_a_machine_that_cannot_take_it_is_refused() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    let import = |format: &'static str, file: &'static str, axis: &'static str| {
        vec!["tables", "import", "--from", format, "--unit", "mm", file, "--axis", axis, "-o", "m"]
    };
    directory.bad(&import("linuxcnc", "new.comp", "A"), &["machine.toml:3", "chain", "axis A in the chain", "--new"]);
    let mut new = import("linuxcnc", "new.comp", "X");
    new.push("--new");
    directory.bad(&new, &["--new", "found m", "does not exist"]);
    // The owner's file x.csv is where the new table would be.
    directory.write("m/x.csv", "notes of the owner\n");
    directory.bad(&import("linuxcnc", "new.comp", "X"), &["x.csv beside it"]);
    fs::remove_file(directory.join("m/x.csv")).unwrap();
    // The controller would refuse the result: 0.9 mm of error on 0.5 mm.
    directory.write("steep.comp", "0 0 0\n0.5 1.4 1.4\n2 2 2\n");
    directory.bad(
        &[&import("linuxcnc", "steep.comp", "X")[..], &["--comp-file-type", "0"]].concat(),
        &["x.csv", "slope", "nothing is written"],
    );
    directory.write("m/machine.toml", MACHINE.replace("name", "nam"));
    directory.bad(&import("linuxcnc", "new.comp", "X"), &["machine.toml", "name"]);
    // A folder with a table but without a machine.
    directory.write("bare/x.csv", "notes of the owner\n");
    directory.bad(
        &["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "X", "-o", "bare"],
        &["bare/x.csv", "no machine.toml"],
    );
    // A refused new machine leaves no folder.
    directory.bad(
        &[
            "tables",
            "import",
            "--from",
            "linuxcnc",
            "--unit",
            "mm",
            "steep.comp",
            "--comp-file-type",
            "0",
            "--axis",
            "X",
            "-o",
            "new/deep",
        ],
        &["steep.comp", "slope"],
    );
}

#[test]
fn an_import_from_a_file_that_states_a_chain_needs_that_chain() {
    let directory = Folder::new(TRUEAXIS);
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/head-5axis");
    let head = head.to_str().unwrap();
    directory.reported(&["tables", "export", "--to", "isg", head, "-o", "head.csv"]);
    hall_2(&directory);
    directory.bad(
        &["tables", "import", "--from", "isg", "head.csv", "--axis", "X", "-o", "m"],
        &["machine.toml:3", "w X' b Y Z C A t", "--new"],
    );
    let folder = directory.join("copy");
    fs::create_dir(&folder).unwrap();
    for entry in fs::read_dir(head).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
    }
    let before = directory.read("copy/machine.toml");
    directory.reported(&["tables", "import", "--from", "isg", "head.csv", "-o", "copy"]);
    let after = directory.read("copy/machine.toml");
    // The volumetric CSV describes the same machine: only the decimals of the tables change.
    assert_eq!(after, before);
    assert_ne!(directory.read("copy/x.csv"), fs::read_to_string(Path::new(head).join("x.csv")).unwrap());
}

/// Every command that writes, with each of its inputs as its output, under three names.
#[test]
fn an_input_is_never_written() {
    let directory = Folder::new(TRUEAXIS);
    directory
        .write("m/machine.toml", "name = \"m\"\nchain = \"w b X Y Z C t\"\n[axis.X]\ntable = \"x.csv\"\n[axis.C]\n");
    directory.write("m/x.csv", "X_mm,EXX_um\n0,1\n100,3\n");
    directory.write("x.comp", COMP);
    directory.write("p.csv", "x_mm,y_mm,z_mm\n1,2,3\n");
    directory.write("path.json", r#"{"segments":[{"type":"line","start":[0,0,0],"end":[10,0,0]}]}"#);
    directory.write("actual.csv", "segment,u,x_mm,y_mm,z_mm\n0,0.5,5,0.001,0\n");
    let readings: String = (0..64).map(|i| format!("{},0,0\n", i % 7)).collect();
    directory.write("h.csv", format!("h1_um,h2_um,h3_um\n{readings}"));
    let mut balls = String::from("angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um\n");
    for angle in [0, 90, 180, 270, 360] {
        for (l, h) in [(100, 0), (200, 50), (100, 100)] {
            balls += &format!("{angle},{l},{h},{angle},0,0\n").replace("360,0,0\n", "0,0,0\n");
        }
    }
    directory.write("balls.csv", &balls);
    let machine = ["m/machine.toml", "m/x.csv"];
    let cases: [(&[&str], &[&str]); 9] = [
        (&["tables", "compile", "m", "-o"], &machine),
        (&["tables", "export", "--to", "linuxcnc", "m", "--drop", "-o"], &machine),
        (&["tables", "export", "--to", "iso230-2", "m", "--drop", "-o"], &machine),
        (&["compensate", "m", "p.csv", "-o"], &["m/machine.toml", "m/x.csv", "p.csv"]),
        (&["contour", "path.json", "actual.csv", "-o"], &["path.json", "actual.csv"]),
        (&["roundness", "h.csv", "--n", "64", "--p", "12", "--q", "41", "--harmonics", "2..5", "-o"], &["h.csv"]),
        (&["kinematics", "forward", "--machine", "m", "p.csv", "-o"], &["m/machine.toml", "m/x.csv", "p.csv"]),
        (&["identify", "balls.csv", "--axis", "C", "-o"], &["balls.csv"]),
        (&["identify", "balls.csv", "--axis", "C", "--machine", "m", "-o"], &["balls.csv", "m/x.csv"]),
    ];
    for (arguments, inputs) in cases {
        // The command works, so the refusal below is due to the output.
        let out = if arguments[0] == "identify" { "out.csv" } else { "out" };
        directory.reported(&[arguments, &[out]].concat());
        fs::remove_file(directory.join(out)).unwrap();
        for input in inputs {
            let path = directory.join(input);
            let [link, hard] = ["link", "hard"].map(|name| directory.join(name));
            #[cfg(unix)]
            std::os::unix::fs::symlink(&path, &link).unwrap();
            fs::hard_link(&path, &hard).unwrap();
            for name in [input, &*format!("./m/../{input}"), path.to_str().unwrap(), "link", "hard"] {
                if cfg!(unix) || name != "link" {
                    directory.bad(&[arguments, &[name]].concat(), &["input", "is never written"]);
                }
            }
            let _ = fs::remove_file(link);
            fs::remove_file(hard).unwrap();
        }
    }
    // Folders and pages that would overwrite an input.
    directory.write("new/machine.toml", directory.read("m/machine.toml"));
    fs::copy(directory.join("x.comp"), directory.join("new/x.csv")).unwrap();
    directory.bad(
        &["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new/x.csv", "--axis", "X", "-o", "new"],
        &["input", "is never written"],
    );
    for (arguments, page) in [
        (
            &["roundness", "pages/roundness.html", "--n", "64", "--p", "12", "--q", "41", "--harmonics", "2..5"][..],
            "h.csv",
        ),
        (&["circle", "pages/circle.html"], "round.csv"),
        (&["identify", "pages/identify.html", "--axis", "C"], "balls.csv"),
    ] {
        directory.write("round.csv", "x_mm,y_mm\n1,0\n0,1\n-1,0\n0,-1.1\n");
        directory.write(format!("pages/{}.html", arguments[0]), directory.read(page));
        directory.bad(&[arguments, &["--report", "pages"]].concat(), &["input", "is never written"]);
    }
}

#[test]
fn a_machine_that_somebody_wrote_is_not_collapsed_over() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    directory.write("other/machine.toml", "# mine\n");
    directory.bad(&["tables", "collapse", "m", "-o", "other", "--volume", ",,0:100"], &["other/machine.toml"]);
    for _ in 0..2 {
        directory.reported(&["tables", "collapse", "m", "-o", "nine", "--volume", ",,0:100"]);
    }
}

/// Two outputs in one file, a folder in place of a file, a path that does not exist: nothing is written.
#[test]
fn a_refused_command_leaves_nothing_behind() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    let helicoid = [
        "helicoid",
        "--base-radius-mm",
        "30",
        "--lead-parameter-mm-per-rad",
        "40",
        "--u-rad",
        "0.1:0.6:3",
        "--theta-rad",
        "0:0.2:3",
        "--form",
        "vertical",
        "--pivot-mm",
        "150",
    ];
    directory.bad(&[&helicoid[..], &["--gcode", "one", "-o", "./one"]].concat(), &["two outputs"]);
    directory.bad(&[&helicoid[..], &["--gcode", "one", "-o", "m"]].concat(), &["cannot write m", "folder"]);
    directory.bad(&[&helicoid[..], &["--report", "pages", "-o", "no/where"]].concat(), &["cannot write no/where"]);
    directory.bad(&["tables", "compile", "m", "-o", "no/where.tcomp"], &["cannot write no/where.tcomp"]);
}

/// Names that would act on a terminal are escaped in every message, as in a refusal.
#[cfg(unix)]
#[test]
fn names_do_not_act_on_a_terminal() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    let import =
        |output| ["tables", "import", "--from", "linuxcnc", "--unit", "mm", "new.comp", "--axis", "X", "-o", output];
    let acts = |text: &str| text.contains(['\u{1b}', '\u{202e}', '\u{2066}', '\r']);
    for (name, shown) in [("a\u{1b}[2Jb", "a\\u{1b}[2Jb"), ("a\u{202e}b", "a\\u{202e}b"), ("a\rb", "a\\rb")] {
        let said = directory.reported(&import(name));
        assert!(said.contains(&format!("written {shown}/machine.toml")) && !acts(&said), "{said:?}");
        let [out, said] = directory.both(&["tables", "check", name]);
        assert!(out.contains(shown) && !acts(&out) && !acts(&said), "{out:?} {said:?}");
        assert!(!acts(&directory.bad(&["tables", "check", &format!("{name}/none")], &[shown])));
    }
    directory.write("m/machine.toml", MACHINE.replace("hall 2\"   #", "hall \u{2066}2\"   #"));
    let out = directory.good(&["tables", "check", "m"]);
    assert!(out.contains("hall \\u{2066}2") && !acts(&out), "{out:?}");
    // Output for programs is unchanged.
    directory.write("m/machine.toml", MACHINE.replace("hall 2\"   #", "hall \u{202e}2\"   #"));
    assert!(directory.json(&["tables", "check", "m", "--json"]).to_string().contains("hall \u{202e}2"));
}

/// A link to a file that does not exist yet is followed; one that leads nowhere is refused.
#[cfg(unix)]
#[test]
fn a_link_stays_one_wherever_it_leads() {
    let directory = Folder::new(TRUEAXIS);
    hall_2(&directory);
    std::os::unix::fs::symlink("kept.tcomp", directory.join("link.tcomp")).unwrap();
    directory.reported(&["tables", "compile", "m", "-o", "link.tcomp"]);
    assert!(directory.join("link.tcomp").is_symlink() && directory.join("kept.tcomp").is_file());
    directory.write("q.csv", "x_mm,y_mm,z_mm\n1,2,3\n");
    for (link, to, part) in [("astray", "none/kept", "No such file"), ("round", "round", "leads nowhere")] {
        std::os::unix::fs::symlink(to, directory.join(link)).unwrap();
        for command in [["tables", "compile", "m", "-o", link], ["compensate", "m", "q.csv", "-o", link]] {
            let output = directory.run(&command);
            let said = String::from_utf8(output.stderr).unwrap();
            assert!(output.status.code() == Some(2) && said.contains(link) && said.contains(part), "{said}");
            assert!(directory.join(link).is_symlink());
        }
    }
    let through = directory.run(&["tables", "compile", "m", "-o", "/dev/stdout"]);
    assert_eq!(through.stdout, fs::read(directory.join("kept.tcomp")).unwrap());
}

/// Makes a machine of a LinuxCNC file for X in mm.
fn import_of_x(directory: &Folder, file: &str, machine: &str) {
    let from = ["tables", "import", "--from", "linuxcnc-0", "--unit", "mm"];
    directory.reported(&[&from[..], &[file, "--axis", "X", "-o", machine]].concat());
}

/// A figure is written with the digits that were read, and zero has no sign.
#[test]
fn figures_have_the_digits_that_they_came_with() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("new.comp", "-100 -100 -100\n10 10.016312 10.016312\n1000 999.9837 999.9837\n");
    import_of_x(&directory, "new.comp", "n");
    assert_eq!(directory.read("n/x.csv"), "X_mm,EXX_um\n-100,0\n10,16.312\n1000,-16.3\n");
    let mill = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-5axis");
    directory.reported(&["tables", "collapse", mill.to_str().unwrap(), "-o", "c"]);
    let machine = directory.read("c/machine.toml");
    assert!(machine.contains("encoder_resolution_urad = 0.21\n"), "{machine}");
    let mill = mill.with_file_name("mill-3axis");
    let document = directory.good(&["correct", mill.to_str().unwrap(), "--at", "0,0,0", "--json"]);
    assert!(document.contains(" 0.0") && !document.contains("-0.0,") && !document.contains("-0.0\n"), "{document}");
}

#[test]
fn notes_on_exported_files_name_the_files_that_were_written() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("x.comp", "-100 -99.999 -99.998\n10 10.0163 10.0163\n");
    import_of_x(&directory, "x.comp", "m");
    let export = |to| ["tables", "export", "--to", to, "m", "--drop", "-o", "screw.comp"];
    let said = directory.reported(&export("linuxcnc-0"));
    assert!(said.contains("note: COMP_FILE = screw.comp and"), "{said}");
    directory.bad(
        &export("gridd"),
        &["--to", "\"gridd\"", "needed linuxcnc, linuxcnc-0, linuxcnc-1, siemens, isg or iso230-2"],
    );
}
