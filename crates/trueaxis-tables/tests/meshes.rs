//! Import of height maps of RepRapFirmware and of meshes that Marlin prints.

use std::path::Path;
use trueaxis_tables::error::FileError;
use trueaxis_tables::formats::{Format, Imported, import, marlin};

const MAP: &str = "RepRapFirmware height map file v2 generated at 2025-01-31 10:00, min error -0.050, max error 0.100, mean 0.020, \
                   deviation 0.050\naxis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n\
                   X,Y,20.00,220.00,20.00,120.00,-1.00,100.00,50.00,3,3\n  0.050,  0.040,  0.000\n  0.045, -0.010,  0.020\n\
                   \x20 0.000, -0.050,  0.100\n";

fn map(text: &str) -> Result<Imported, FileError> {
    import(Format::HeightMap, text, Path::new("heightmap.csv"), None)
}

fn log(text: &str, area: Option<marlin::Area>) -> Result<Imported, FileError> {
    marlin::import(text, Path::new("log.txt"), area)
}

/// The heights of a grid as rows of constant Y, µm.
fn heights(imported: &Imported) -> Vec<Vec<f64>> {
    let source = imported.grids[0].source();
    assert_eq!(source.given, [false, false, true, false, false, false]);
    let [columns, rows] = [source.nodes[0].len(), source.nodes[1].len()];
    let of = |x: usize, y: usize| (source.values[x * rows + y][2] * -1e6).round() / 1e3 + 0.0;
    (0..rows).map(|y| (0..columns).map(|x| of(x, y)).collect()).collect()
}

fn nodes(imported: &Imported) -> [Vec<f64>; 2] {
    let [x, y, _] = imported.grids[0].source().nodes.clone();
    [x, y]
}

const HEIGHTS: [[f64; 3]; 3] = [[50.0, 40.0, 0.0], [45.0, -10.0, 20.0], [0.0, -50.0, 100.0]];

#[test]
fn a_height_map_becomes_a_surface() {
    let imported = map(MAP).unwrap();
    assert_eq!(heights(&imported), HEIGHTS);
    assert_eq!(nodes(&imported), [vec![20.0, 120.0, 220.0], vec![20.0, 70.0, 120.0]]);
    assert!(imported.replaces_grids);
    assert_eq!(imported.notes, ["EZ = −height; bilinear between the 9 points"]);
    // The older headers, and line ends of Windows.
    let labels = "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\nX,Y,";
    let two = MAP.replace(labels, "xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum\n");
    let one =
        two.replace("file v2", "file v1").replace("xspacing,yspacing", "spacing").replace("100.00,50.00", "50.00");
    let one = one.replace("220.00", "120.10").replace("120.00,-1.00", "120.10,85.00");
    for (text, x) in [(two.replace('\n', "\r\n"), [20.0, 120.0, 220.0]), (one, [20.0, 70.0, 120.0])] {
        let imported = map(&text).unwrap();
        assert_eq!(
            (heights(&imported), nodes(&imported)),
            (HEIGHTS.map(Vec::from).to_vec(), [x.to_vec(), vec![20.0, 70.0, 120.0]])
        );
    }
    // A spacing rounded to 0.01 mm.
    let thirds = MAP.replace("120.00,-1.00,100.00,50.00", "120.25,-1.00,100.00,50.12");
    assert_eq!(nodes(&map(&thirds).unwrap())[1], [20.0, 70.125, 120.25]);
}

/// The points that were not probed are in the plane of the others: known where the others are in one, and else by the normal
/// equations of the fit.
#[test]
fn a_point_that_was_not_probed_is_no_height() {
    let plane = |x: f64, y: f64| 0.3 + 0.001 * x - 0.002 * y;
    let row = |y: f64, hole: Option<usize>| {
        let of = |k: usize| {
            if Some(k) == hole { String::from("      0") } else { format!("{:7.3}", plane(20.0 + 100.0 * k as f64, y)) }
        };
        [of(0), of(1), of(2)].join(",")
    };
    let head = MAP.split_inclusive('\n').take(3).collect::<String>();
    let whole = map(&format!("{head}{}\n{}\n{}\n", row(20.0, None), row(70.0, None), row(120.0, None))).unwrap();
    let holes = map(&format!("{head}{}\n{}\n{}\n", row(20.0, Some(2)), row(70.0, None), row(120.0, Some(0)))).unwrap();
    assert_eq!(heights(&holes), heights(&whole));
    assert!(holes.notes[1].starts_with("2 of the points were not probed"), "{:?}", holes.notes);
    // Heights off a plane: the residuals have no mean and no slope.
    let text = MAP.replace("  0.040,  0.000\n", "  0.040,      0\n");
    let filled = heights(&map(&text).unwrap())[0][2];
    let mut sums = [0.0; 3];
    let known: Vec<[f64; 3]> = (0..9)
        .filter(|k| *k != 2)
        .map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, HEIGHTS[k as usize / 3][k as usize % 3]])
        .collect();
    // The plane through the filled corner with the slopes that the normal equations give.
    let (n, sx, sy): (f64, f64, f64) = known.iter().fold((0.0, 0.0, 0.0), |(n, x, y), p| (n + 1.0, x + p[0], y + p[1]));
    let moment = |a: usize, b: usize| known.iter().map(|p| p[a] * p[b]).sum::<f64>();
    let matrix =
        glam::DMat3::from_cols_array(&[n, sx, sy, sx, moment(0, 0), moment(0, 1), sy, moment(0, 1), moment(1, 1)]);
    let right = glam::DVec3::new(known.iter().map(|p| p[2]).sum(), moment(0, 2), moment(1, 2));
    let fit = matrix.inverse() * right;
    let expected = fit.x + fit.y - fit.z;
    assert!((filled - expected).abs() < 1e-3, "{filled}, {expected}");
    for p in &known {
        let left = p[2] - (fit.x + fit.y * p[0] + fit.z * p[1]);
        sums[0] += left;
        sums[1] += left * p[0];
        sums[2] += left * p[1];
    }
    assert!(sums.iter().all(|sum| sum.abs() < 1e-9));
}

#[test]
fn damaged_height_maps_are_refused_with_their_line() {
    for (from, to, place, words) in [
        ("file v2", "file v3", "heightmap.csv:1:", "file v1 or v2"),
        ("height map", "probe points", "heightmap.csv:1:", "file v1 or v2"),
        ("axis0,axis1,min0", "axis0,axis1,low0", "heightmap.csv:2:", "axis0,axis1,min0"),
        ("X,Y,20", "X,Z,20", "heightmap.csv:3: column axis1: found \"Z\"", "a map over X and Y"),
        ("X,Y,20.00,", "X,Y,", "heightmap.csv:3:", "11 as in the line above"),
        (",3,3\n", ",3.5,3\n", "heightmap.csv:3: column num0", "a whole number from 2"),
        (",3,3\n", ",3,1\n", "heightmap.csv:3: column num1", "a whole number from 2"),
        (",3,3\n", ",9,3\n", "heightmap.csv:3: column spacing0", "9 points from 20 to max0 = 220"),
        ("100.00,50.00", "nan,50.00", "heightmap.csv:3: column spacing0", "a finite number"),
        ("220.00", "20.00", "heightmap.csv:3: column spacing0", "3 points from 20"),
        (",3,3\n", ",3,4\n", "heightmap.csv:3: column spacing1", "4 points from 20 to max1 = 120"),
        ("  0.000, -0.050,  0.100\n", "", "heightmap.csv: found 2 lines of heights", "3, as num1 says"),
        ("  0.020\n", "  0.020,  0.1\n", "heightmap.csv:5:", "3, as num0 says"),
        ("  0.020\n", "  deep\n", "heightmap.csv:5:", "a number"),
        ("  0.020\n", "  nan\n", "heightmap.csv:5:", "a finite number"),
        ("  0.020\n", "  20.0\n", "heightmap.csv:5:", "-10000 to 10000 um"),
        ("0.100\n", "0.100\n 0,0,0\n", "heightmap.csv:7:", "the end after 3 lines"),
    ] {
        assert!(MAP.contains(from));
        let error = map(&MAP.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(place) && error.contains(words), "{error}");
    }
    // Three probed points on a line.
    let head = MAP.split_inclusive('\n').take(3).collect::<String>();
    let error = map(&format!("{head}0.1,0.2,0.3\n0,0,0\n0,0,0\n")).unwrap_err().to_string();
    assert!(error.contains("three probed points that are not on a line"), "{error}");
    damaged(MAP, |text| drop(map(text)));
}

/// Cuts a text short everywhere and exchanges each of its bytes.
fn damaged(text: &str, read: impl Fn(&str)) {
    for end in 0..text.len() {
        read(&String::from_utf8_lossy(&text.as_bytes()[..end]));
    }
    for place in 0..text.len() {
        for damage in [b' ', b'-', b'0', b',', b'\n', b'(', b'|', b'9', 0xff] {
            let mut bytes = text.as_bytes().to_vec();
            bytes[place] = damage;
            read(&String::from_utf8_lossy(&bytes));
        }
    }
}

const UNIFIED: &str = "Send: G29 T\nRecv:\nRecv: Bed Topography Report:\nRecv:\nRecv:     ( 20,120)               (220,120)\n\
    Recv:        0       1       2\nRecv:  2 |  0.000  -0.050  +0.100\nRecv:    |\nRecv:  1 | +0.045  -0.010 [+0.020]\n\
    Recv: echo:busy: processing\nRecv:    |\nRecv:  0 | +0.050  +0.040   0.000\nRecv:        0       1       2\n\
    Recv:     ( 20, 20)               (220, 20)\nRecv:\nRecv: ok\n";

const BILINEAR: &str = "21:29:13.047 : Bilinear Leveling Grid:\n21:29:13.048 :       0      1      2\n\
    21:29:13.048 :  0 +0.050 +0.040 +0.000\n21:29:13.049 :  1 +0.045 -0.010 +0.020\n21:29:13.049 :  2 +0.000 -0.050 +0.100\n\
    21:29:13.050 :\n21:29:13.051 : echo:Bed Leveling On\n21:29:13.051 : echo:Fade Height 10.00\n";

/// The lines that `G29 V4` prints, in the order of its path.
fn touches() -> String {
    [
        (20.0, 20.0),
        (120.0, 20.0),
        (220.0, 20.0),
        (220.0, 70.0),
        (120.0, 70.0),
        (20.0, 70.0),
        (20.0, 120.0),
        (120.0, 120.0),
        (220.0, 120.0),
    ]
    .map(|(x, y)| format!("<- Bed X: {x:.3} Y: {y:.3} Z: 0.123\n"))
    .concat()
}

const AREA: marlin::Area = [20.0, 20.0, 220.0, 120.0];

#[test]
fn printed_meshes_become_surfaces() {
    let older = "Bed Topography Report:\n\n(0,2)                (2,2)\n(20,120)           (220,120)\n\
        0.000   -0.050    0.100\n \n0.045   -0.010    0.020\n \n[ 0.050]   0.040    0.000\n(20,20)            (220,20)\n(0,0)                (2,0)\nok\n";
    let csv = "Bed Topography Report for CSV:\n\n0.000\t-0.050\t0.100\n0.045\t-0.010\t0.020\n0.050\t0.040\t0.000\n";
    let bilinear = BILINEAR
        .replace("21:29:13.047 : ", "")
        .replace("21:29:13.048 :", "READ:")
        .replace("21:29:13.049 :", "[21:29:13]");
    let bilinear = bilinear.replace("21:29:13.05", "2025-10-09 21:29:13,05");
    let touched = format!("{}{BILINEAR}", touches());
    for (text, area) in [
        (UNIFIED, None),
        (UNIFIED, Some([20.2, 19.9, 220.4, 120.0])),
        (older, None),
        (csv, Some(AREA)),
        (BILINEAR, Some(AREA)),
        (&bilinear, Some(AREA)),
        (&touched, None),
        // The same mesh twice.
        (&format!("{UNIFIED}{UNIFIED}"), None),
    ] {
        let imported = log(text, area).unwrap();
        assert_eq!(heights(&imported), HEIGHTS, "{text}");
        let [[low_x, low_y, high_x, high_y]] = [area.unwrap_or(AREA)];
        let [x, y] = nodes(&imported);
        assert_eq!((x[0], x[2], y[0], y[2]), (low_x, high_x, low_y, high_y), "{text}");
        assert!((x[1] - 0.5 * (low_x + high_x)).abs() < 1e-6 && (y[1] - 0.5 * (low_y + high_y)).abs() < 1e-6);
    }
    assert!(log(UNIFIED, None).unwrap().notes.iter().any(|note| note.contains("corners in whole mm")));
}

/// Marlin: correction = height · (1 − z/10) at the commanded height z, so the axis is at z + correction.
#[test]
fn the_fade_of_the_log_is_marlin_s() {
    let tall = BILINEAR.replace("+0.0", "+1.0").replace("-0.0", "+1.0").replace("+0.100", "+1.100");
    let source = log(&tall, Some(AREA)).unwrap();
    let mean = source.grids[0].source().values.iter().map(|value| -value[2]).sum::<f64>() / 9.0;
    let fade = source.grids[0].source().fade_mm.unwrap();
    assert!((fade[0] - mean).abs() < 0.006 && fade[1] == 10.0, "{fade:?}, {mean}");
    assert_eq!(
        log(&BILINEAR.replace("Height 10.00", "Height Off"), Some(AREA)).unwrap().grids[0].source().fade_mm,
        None
    );
    assert_eq!(
        log(&BILINEAR.replace("Height 10.00", "Height 0.00"), Some(AREA)).unwrap().grids[0].source().fade_mm,
        None
    );
}

/// The subdivided grid takes the place of the one that it refines.
#[test]
fn a_subdivided_grid_is_the_surface() {
    let fine = "Subdivided with CATMULL ROM Leveling Grid:\n        0        1        2        3        4\n\
         0 +0.05000 +0.04812 +0.04000 +0.02250 +0.00000\n 1 +0.05000 +0.02000 +0.01500 +0.01000 +0.01000\n\
         2 +0.04500 +0.01000 -0.01000 -0.00500 +0.02000\n 3 +0.02000 +0.00000 -0.03000 +0.02000 +0.06000\n\
         4 +0.00000 -0.03000 -0.05000 +0.03000 +0.10000\n\n";
    let imported =
        log(&format!("{}{}\n{fine}", touches(), BILINEAR.split("21:29:13.050").next().unwrap()), None).unwrap();
    assert_eq!(nodes(&imported), [vec![20.0, 70.0, 120.0, 170.0, 220.0], vec![20.0, 45.0, 70.0, 95.0, 120.0]]);
    assert_eq!(heights(&imported)[3], [20.0, 0.0, -30.0, 20.0, 60.0]);
}

#[test]
fn incomplete_meshes_are_refused_with_their_line() {
    let half = touches().lines().take(6).map(|line| format!("{line}\n")).collect::<String>();
    let differs = format!("{UNIFIED}{}", UNIFIED.replace("-0.010", "-0.011"));
    for (text, area, place, words) in [
        (UNIFIED.replace("-0.010", " .    "), None, "log.txt:9: found \".\"", "every point measured"),
        (BILINEAR.replace("-0.010", " ====="), Some(AREA), "log.txt:4: found \"=====\"", "every point measured"),
        (UNIFIED.replace("-0.010", "-0.01"), None, "log.txt:9: found \"-0.01\"", "3 decimals"),
        (UNIFIED.replace("-0.010 ", ""), None, "log.txt:9: found 2 heights", "3, as in the other rows"),
        (UNIFIED.replace("+0.045  ", "+0.045  soft "), None, "log.txt:9:", "a row of the map"),
        (UNIFIED.replace("1 | ", "3 | "), None, "log.txt:5: found rows 2 3 0", "2 to 0"),
        (UNIFIED.replace("( 20, 20)", "( 30, 20)"), None, "log.txt:5:", "the four corners of a rectangle"),
        (UNIFIED.split("Recv:     ( 20, 20)").next().unwrap().to_owned(), None, "log.txt:5:", "the map to its end"),
        (UNIFIED.to_owned(), Some([20.0, 20.0, 250.0, 120.0]), "log.txt:5: found the area X 20 to 250", "X 20 to 220"),
        (BILINEAR.to_owned(), None, "log.txt:1: found a mesh of 3 by 3 points without an area", "--area X,Y,X,Y"),
        (format!("{half}{BILINEAR}"), None, "log.txt:7: found a mesh of 3 by 3", "the log of G29 V4"),
        (BILINEAR.to_owned(), Some([20.0, 20.0, 20.0, 120.0]), "log.txt:1: column X", "an end above the start"),
        (BILINEAR.replace("+0.100", "+11.10"), Some(AREA), "log.txt:5: found 11.1 mm", "-10000 to 10000 um"),
        (differs, None, "log.txt:21: found a mesh that differs from that on line 5", "one mesh"),
        (String::from("ok\n"), None, "log.txt: found no mesh", "M420 V"),
    ] {
        let error = log(&text, area).unwrap_err().to_string();
        assert!(error.contains(place) && error.contains(words), "{error}");
    }
    for text in [UNIFIED, BILINEAR] {
        damaged(text, |text| drop(log(text, Some(AREA))));
    }
}
