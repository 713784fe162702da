//! Probing moves on a surface: trips worked out by hand, refusals as in LinuxCNC, and ways that a fine search follows.

use trueaxis_sim::program::{Program, ProgramError, ReadOptions, Surface};
use trueaxis_testing::noise::Noise;

const SADDLE: &str = "RepRapFirmware height map file v2 generated at 2025-01-31 10:00
axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1
X,Y,0.00,10.00,0.00,10.00,-1.00,10.00,10.00,2,2
0.000, 1.000
1.000, 0.000
";

const PLANE: &str = "plane_z_mm = -5";
/// A ball of 2 mm radius beside two boxes that meet at X 20.
const BOXES: &str = "tip_diameter_mm = 4
[[box]]
from_mm = [10, -5, -20]
to_mm = [20, 5, 0]
[[box]]
from_mm = [20, -5, -20]
to_mm = [30, 5, 0]
";
const BALL: &str = "tip_diameter_mm = 2\n[[ball]]\ncentre_mm = [20, 0, 0]\ndiameter_mm = 20\n";
const MAP: &str = "[height_map]\nfile = \"heightmap.csv\"\nz_mm = -30\n";

fn surface(text: &str) -> Result<Surface, ProgramError> {
    let read = |name: &str| match name {
        "heightmap.csv" => Ok(SADDLE.to_owned()),
        _ => Err(std::io::ErrorKind::NotFound.into()),
    };
    Surface::parse(text, "surface.toml", read)
}

fn parse(on: &str, text: &str) -> Result<Program, ProgramError> {
    let options = ReadOptions { surface: Some(surface(on).unwrap()), ..ReadOptions::default() };
    Program::read("test", text.as_bytes(), "part.ngc", &options)
}

/// #5061 to #5063 and #5070 after a program.
fn probed(on: &str, text: &str) -> [f64; 4] {
    let read = "#1=#5061 #2=#5062 #3=#5063 #4=#5070\nG21 G90 G49\nG53 G0 X999\nG53 G0 X#1 Y#2 Z#3\nG53 G0 X[#4+2000]\n";
    let program = parse(on, &format!("{text}\n{read}")).unwrap_or_else(|error| panic!("{text}: {error}"));
    let [.., place, last] = program.moves.as_slice() else { panic!("{text}") };
    let [x, y, z] = place.curve.position(1.0);
    [x, y, z, last.curve.position(1.0)[0] - 2000.0]
}

#[test]
fn the_probe_trips_where_the_ball_meets_the_surface() {
    let root = 60.0_f64.sqrt();
    let cases: [(&str, &str, [f64; 4]); 21] = [
        (PLANE, "G38.2 Z-10", [0.0, 0.0, -5.0, 1.0]),
        (PLANE, "G38.2 X10 Z-10", [5.0, 0.0, -5.0, 1.0]),
        (PLANE, "G38.2 Z-5", [0.0, 0.0, -5.0, 1.0]),
        (PLANE, "G38.3 Z-4", [0.0, 0.0, -4.0, 0.0]),
        // The face, 2 mm before it; past the edge, √(4 − 1.2²) before it.
        (BOXES, "G0 Z-5\nG38.2 X20", [8.0, 0.0, -5.0, 1.0]),
        (BOXES, "G0 Y6.2 Z-5\nG38.2 X20", [8.4, 6.2, -5.0, 1.0]),
        (BOXES, "G0 Y7.1 Z-5\nG38.3 X40", [40.0, 7.1, -5.0, 0.0]),
        (BOXES, "G0 X15 Z9\nG38.2 Z-5", [15.0, 0.0, 2.0, 1.0]),
        // √(11² − 6.6²) before the centre, and beside it.
        (BALL, "G0 Y6.6\nG38.2 X20", [11.2, 6.6, 0.0, 1.0]),
        (BALL, "G0 Y-11.1\nG38.3 X40", [40.0, -11.1, 0.0, 0.0]),
        // x/10 + y/10 − xy/50 above Z −30: 0.375 at 2.5, 2.5; along the diagonal (10 t − t²)/50 meets 1 − t/10 at 5.
        (MAP, "G0 X2.5 Y2.5\nG38.2 Z-40", [2.5, 2.5, -29.625, 1.0]),
        (MAP, "G0 Z-29\nG38.2 X10 Y10 Z-30", [5.0, 5.0, -29.5, 1.0]),
        (MAP, "G0 X-5 Y5 Z-31\nG38.2 X5", [0.0, 5.0, -31.0, 1.0]),
        (MAP, "G0 X-5 Y5\nG38.3 Z-50", [-5.0, 5.0, -50.0, 0.0]),
        // Away: out of the face, through the second box, off the map where t² − 10 t + 10 = 0, and beside it.
        (BOXES, "G0 X9 Z-5\nG38.4 X0", [8.0, 0.0, -5.0, 1.0]),
        (BOXES, "G0 X15 Z-5\nG38.4 X40", [32.0, 0.0, -5.0, 1.0]),
        (BOXES, "G0 X15 Z-5\nG38.5 X16", [16.0, 0.0, -5.0, 0.0]),
        (MAP, "G0 X5 Y5 Z-29.8\nG38.4 X10 Y10", [5.0 + 0.5 * root, 5.0 + 0.5 * root, -29.8, 1.0]),
        (MAP, "G0 X5 Y5 Z-31\nG38.4 X-10", [0.0, 5.0, -31.0, 1.0]),
        // At once, where the state sought is there at the start.
        (PLANE, "G0 Z-6\nG38.3 Z-10", [0.0, 0.0, -6.0, 1.0]),
        (PLANE, "G0 Z6\nG38.5 Z10", [0.0, 0.0, 6.0, 1.0]),
    ];
    for (on, text, expected) in cases {
        let found = probed(on, &format!("F100\n{text}"));
        assert!((0..4).all(|k| (found[k] - expected[k]).abs() < 1e-8), "{text}: {found:?} instead of {expected:?}");
    }
}

#[test]
fn a_trip_is_in_the_coordinates_in_force() {
    let near = |text: &str, expected: [f64; 3]| {
        let found = probed(PLANE, &format!("F100\n{text}"));
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-9) && found[3] == 1.0, "{text}: {found:?}");
    };
    // Z −5 of the machine is −7 of G54 at 2, −6 where G92 calls machine zero −1; turned by 90°, machine X 4 is program Y −4.
    near("G10 L2 P1 Z2\nG38.2 Z-9", [0.0, 0.0, -7.0]);
    near("G10 L2 P1 Z2\nG92 Z-1\nG38.2 Z-19", [0.0, 0.0, -6.0]);
    near("G10 L2 P1 R90\nG53 G0 X4\nG38.2 Z-9", [0.0, -4.0, -5.0]);
    near("G20 F9\nG38.2 Z-9", [0.0, 0.0, -5.0 / 25.4]);
    // The tip is at the end of the tool whose length is in force.
    near("G0 Z40\nG43.1 Z30\nG38.2 Z-9", [0.0, 0.0, -5.0]);
    let program = parse(PLANE, "F100 G0 Z40\nG43.1 Z30\nG38.2 Z-9\nG91 G38.4 Z1\nG38.3 Z-1\nG1 Z3").unwrap();
    let ends: Vec<f64> = program.moves.iter().map(|m| m.curve.position(1.0)[2]).collect();
    assert_eq!(ends, [40.0, 25.0, 28.0]);
    assert!(program.moves[1].probe && program.moves[1].stop && !program.moves[2].probe);
    assert!(program.notes.is_empty(), "{:?}", program.notes);
    // Without a surface there is nothing to touch.
    let program = Program::parse("test", "F100 G38.2 Z-9\nG1 X#5070 Z[#5063+1]", "part.ngc").unwrap();
    assert_eq!(program.moves[1].curve.position(1.0), [0.0, 0.0, -8.0]);
}

#[test]
fn a_probe_that_does_not_trip_is_refused_where_linuxcnc_refuses_it() {
    let cases = [
        ("G0 X1\nG38.2 Z-4", 3, "G38.2 that touches nothing"),
        ("G0 Z-6\nG38.2 Z-9", 3, "G38.2 that begins in contact"),
        ("G38.4 Z9", 2, "G38.4 that begins out of contact"),
        ("G0 Z-6\nG38.4 Z-5.5", 3, "G38.4 that stays in contact"),
        ("G38.2 Z-9\nG38.2 Z-9", 3, "G38.2 that begins in contact"),
    ];
    for (text, line, found) in cases {
        let error = parse(PLANE, &format!("F100\n{text}")).unwrap_err();
        assert_eq!((error.line, error.found.as_str()), (line, found), "{text}: {error}");
    }
}

#[test]
fn a_surface_that_is_not_understood_is_refused_with_its_line() {
    let cases = [
        ("", 1, "nothing to touch"),
        ("tip_diameter_mm = -1\nplane_z_mm = 0", 1, "-1"),
        ("\nplane_z_mm = nan", 2, "NaN"),
        ("plane_z = 0", 1, "unknown field"),
        ("[[box]]\nfrom_mm = [0, 0, 0]\nto_mm = [1, 0, 1]", 3, "a box from"),
        ("[[box]]\nfrom_mm = [0, 0, inf]\nto_mm = [1, 1, 1]", 2, "inf"),
        ("[[ball]]\ncentre_mm = [0, 0]\ndiameter_mm = 1", 2, "length 2"),
        ("[height_map]\nfile = \"none.csv\"", 2, "none.csv, which cannot be read"),
    ];
    for (text, line, found) in cases {
        let error = surface(text).unwrap_err();
        assert!(error.line == line && error.found.contains(found), "{text}: {error}");
    }
    let bad = Surface::parse(MAP, "surface.toml", |_| Ok(SADDLE.replace("0.000, 1.000", "0.000")));
    assert_eq!(bad.unwrap_err().to_string().split(';').next(), Some("heightmap.csv:4: found 1 heights"));
}

/// Distance of a ball of 2 mm radius from the boxes and from the ball beside them, by their own formulas.
fn gap([x, y, z]: [f64; 3]) -> f64 {
    let beyond = |at: f64, low: f64, high: f64| (low - at).max(at - high);
    let (a, b, c) = (beyond(x, 10.0, 30.0), beyond(y, -5.0, 5.0), beyond(z, -20.0, 0.0));
    let outside = [a, b, c].iter().map(|part| part.max(0.0).powi(2)).sum::<f64>().sqrt();
    let boxes = if outside > 0.0 { outside } else { a.max(b).max(c) };
    let ball = (x.powi(2) + (y - 20.0).powi(2) + z.powi(2)).sqrt() - 6.0;
    boxes.min(ball) - 2.0
}

#[test]
fn random_ways_trip_where_a_fine_search_finds_the_first_contact() {
    let on = format!("{BOXES}[[ball]]\ncentre_mm = [0, 20, 0]\ndiameter_mm = 12\n");
    let mut noise = Noise::new(1);
    let (mut toward, mut away) = (0, 0);
    for _ in 0..400 {
        let mut place = || [noise.range(-20.0, 50.0), noise.range(-20.0, 40.0), noise.range(-40.0, 20.0)];
        let (start, end) = (place(), place());
        let way = |share: f64| std::array::from_fn::<f64, 3, _>(|k| start[k] + share * (end[k] - start[k]));
        let is_away = gap(start) < 0.0;
        let word = if is_away { "G38.5" } else { "G38.3" };
        let [x, y, z] = start;
        let text = format!("F100 G0 X{x} Y{y} Z{z}\n{word} X{} Y{} Z{}", end[0], end[1], end[2]);
        let found = probed(&on, &text);
        let mut shares = (0..=4000).map(|step| f64::from(step) / 4000.0);
        let first = shares.find(|share| (gap(way(*share)) <= 0.0) != is_away);
        let tripped = found[3] == 1.0;
        // The search may step over a way that grazes.
        assert!(tripped || first.is_none(), "{text}: {found:?}, {first:?}");
        if tripped {
            assert!(gap([found[0], found[1], found[2]]).abs() < 1e-6, "{text}: {found:?}");
            let share = (0..3).map(|k| (found[k] - start[k]) / (end[k] - start[k])).sum::<f64>() / 3.0;
            // Between the step that finds the contact and the one before it.
            let within = |first: f64| (first - 1.0 / 4000.0 - 1e-6..=first + 1e-6).contains(&share);
            assert!(first.is_none_or(within), "{text}: {share} {first:?}");
            *(if is_away { &mut away } else { &mut toward }) += 1;
        }
    }
    assert!(toward > 60 && away > 15, "{toward} {away}");
}

/// Where a probe has stopped on a plane, it comes free at once, however the trip was rounded.
#[test]
fn a_probe_that_has_touched_comes_free() {
    for height in (1..400).map(|k| -0.01 * f64::from(k) - 0.003) {
        let on = format!("plane_z_mm = {height}");
        let [.., z, tripped] = probed(&on, "F100 G0 Z5\nG38.2 Z-20\nG91 G38.4 Z2\nG90");
        assert!(tripped == 1.0 && (z - height).abs() < 1e-6, "{height}: {z}");
    }
}
