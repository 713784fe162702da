//! NC programs with offsets and tools.

use crate::choice::one_in;
use crate::outcome::{accepted, refused, saw};
use crate::parts::{joined, split};
use crate::{Target, machines, no_repair};
use std::collections::BTreeSet;
use std::time::Duration;
use trueaxis_sim::program::limits::MOST_PIECES;
use trueaxis_sim::program::{Curve, Move, Offsets, Program, ReadOptions, Surface, ToolTable};

/// The program and, as further files, its offsets (`offsets.toml` or `offsets.var`), its tools (`tool.tbl`), what it
/// probes (`map.csv`, then `surface.toml`) and the switch for block delete.
pub const TARGET: Target = Target {
    name: "gcode",
    about: "NC programs with offsets, tools and canned cycles; one in 4096 as long as a program may be",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/gcode.dict"),
    slowest: READ,
};

/// One line of a canned cycle may contain all two million moves that a program may have.
const READ: Duration = Duration::from_secs(5);

/// Longer programs reach nothing new; a program may have two million pieces, in one line of a canned cycle.
const MOST_FEW: u64 = 512;
/// One input in so many may have all of them.
const MANY_ONE_IN: u64 = 4096;

const CYCLES: &str = "%\nO100 (cycles)\nG21 G90 G17 G54 F300\nT1 M6 G43 H1\nG0 X1 Y2 Z10\nG99 G81 X5 Y5 Z-3 R2\n\
    G98 G83 G91 X1 Y1 Z-6 R-2 Q1.5 L3\nG82 Z-1 R1 P0.5\nG73 Z-4 R1 Q1\nG85 Z-2 R1\nG89 Z-2 R1 P1\nG80 G90\n/G1 X0\nM30\n%\n";
const OFFSETS: &str = "active = \"G55\"\n[G54]\nx_mm = 10.0\nrotation_deg = 30.0\n[G55]\ny_mm = -5.0\nc_deg = 10.0\n\
    [G92]\nz_mm = 1.0\n[G28]\nz_mm = 100.0\n";
const TOOLS: &str = "T1 P1 X0 Y0 Z50.5 D6 ;mill\nT2 P2 Z-20\n";
const CURVES: &str = "G1 X10 F600\nG3 X0 Y10 I-10\nG2 X1 Y9 R5\nG18 G2 X5 Z0 I2 K0 P3\nG17 G91.1 G20\nG3 X0.2 Y0.1 R-0.5\nG21\n\
    G90.1 G2 X5.08 Y-2.54 I0 J0\nG91 G1 A10 B-5 C20\nG93 G1 X1 F2\nG94 F100\nG61.1 G1 Y-3\nG4 P1\nM2\n";
const NURBS: &str = "G0 X0 Y0\nF1000\nG5.2 P1 L3\nX0 Y1 P1\nX2 Y2 P2\nX2 Y0 P1\nX0 Y0 P2\nG5.3\nG43.4 H1\nG1 X5 A3 F200\nA0\nG49\n\
    G92 X0 Y0\nG92.1\nG52 X1\nG10 L2 P1 X3 R45\nG53 G0 Z0\nG28 Z5\nG30.1\nG30\nG59.3\nM30\n";
const LOOPS: &str = "#1=3 #<_g>=[2*#1 MOD 4]\no<s> sub\nG1 X#1 Y[sin[#2]] F100\no5 if [#1 GT 2]\no<s> return [1]\no5 elseif [#1]\n\
    o5 else\no5 endif\no<s> endsub\no1 while [#1 GT 0]\no<s> call [#1] [-#<_g>**2]\n#1=[#1-1]\no1 endwhile\no2 do\no3 repeat [2]\n\
    G91 G1 X1\no3 endrepeat\no2 while [#<_value> GT 1]\nM70\nG20\nM72\nG0 @3^45\nG5 X1 Y1 I0 J3 P0 Q-3\nG5.1 X2 I1 J1\nM98 P9 L2\n\
    M30\nO9\nG1 X[atan[1]/[2]]\nM99\n";
const PROBING: &str = "F100 G38.2 Z-20\nG91 G38.4 Z3\nG0 Z5\nG90 G10 L20 P1 Z#5063\nG38.3 X20 Y6.2\nG38.5 X-20\nG0 X0\nG38.2 X20 Z-9\n\
    o1 if [#5070 EQ 1]\nG1 X#5061\no1 endif\nM2\n";
const SURFACE: &str = "tip_diameter_mm = 2\nplane_z_mm = -12.5\n[height_map]\nfile = \"map.csv\"\nz_mm = -8\n[[box]]\n\
    from_mm = [10, -5, -20]\nto_mm = [30, 5, 6]\n[[ball]]\ncentre_mm = [-20, 0, 5]\ndiameter_mm = 12\n";
const MAP: &str = "RepRapFirmware height map file v2\nxmin,xmax,ymin,ymax,radius,spacing,xnum,ynum\n-9,9,-9,9,-1,9,3,3\n\
    0.1,1,0\n0.2,-1,0.0\n0.3,1.5,2\n";
const PARAMETERS: &str = "5161\t1.5\n5210\t1\n5211\t2\n5220\t3\n5261\t-4\n5270\t15.000\n5390 0\n";

fn seeds() -> Vec<Vec<u8>> {
    vec![
        joined(&[("offsets.toml", OFFSETS), ("tool.tbl", TOOLS), ("program.ngc", CYCLES)]),
        CURVES.into(),
        LOOPS.into(),
        joined(&[("map.csv", MAP), ("surface.toml", SURFACE), ("program.ngc", PROBING)]),
        joined(&[("program.ngc", NURBS), ("offsets.var", PARAMETERS), ("tool.tbl", TOOLS), ("block delete", "")]),
    ]
}

fn run(input: &[u8]) {
    let mut options = ReadOptions::default();
    let (mut program, mut map) = (Vec::new(), String::new());
    for (name, bytes) in split(input, "program.ngc") {
        let text = String::from_utf8_lossy(&bytes);
        match name {
            "offsets.toml" | "offsets.var" => match Offsets::parse(&text, name) {
                Ok(offsets) => {
                    written_and_read(&offsets);
                    options.offsets = Some(offsets);
                }
                Err(error) => return refused(error),
            },
            "tool.tbl" => match ToolTable::parse(&text, name) {
                Ok(tools) => options.tools = Some(tools),
                Err(error) => return refused(error),
            },
            "map.csv" => map = text.into_owned(),
            "surface.toml" => match Surface::parse(&text, name, |_| Ok(map.clone())) {
                Ok(surface) => options.surface = Some(surface),
                Err(error) => return refused(error),
            },
            "block delete" => options.block_delete = true,
            _ => program = bytes,
        }
    }
    let most_pieces = if one_in(MANY_ONE_IN, input) { MOST_PIECES } else { MOST_FEW };
    match Program::read_within("program", &program, "program.ngc", &options, most_pieces) {
        Err(error) => refused(error),
        Ok(program) => {
            accepted();
            sound(&program, most_pieces);
        }
    }
}

/// LinuxCNC's form of the offsets reads back with the same values.
fn written_and_read(offsets: &Offsets) {
    let again = Offsets::parse(&offsets.parameters(1.0), "again.var").unwrap_or_else(|error| panic!("{error}"));
    let numbers = |offsets: &Offsets| {
        let systems = offsets.systems.iter().flat_map(|system| system.offset.into_iter().chain([system.rotation_deg]));
        systems.chain(offsets.g92).chain(offsets.home.into_iter().flatten()).collect::<Vec<_>>()
    };
    for (one, other) in numbers(offsets).into_iter().zip(numbers(&again)) {
        assert!((one - other).abs() <= 1e-14 + 1e-15 * one.abs(), "{one} is read again as {other}");
    }
    assert_eq!((again.active, again.g92_active), (offsets.active, offsets.g92_active));
}

/// Checks that every position is finite, each move begins at the end of the last one, and the pieces stay within the
/// limit.
fn sound(program: &Program, most_pieces: u64) {
    let mut pieces = 0.0;
    // Not their sequence: an outcome for every number of moves would keep the longest programs.
    let mut kinds = BTreeSet::new();
    let mut last: Option<&Move> = None;
    for element in &program.moves {
        let (first, end) = element.curve.domain();
        assert!(first < end, "line {}: a curve from {first} to {end}", element.line);
        for u in [first, 0.5 * (first + end), end] {
            let at = element.curve.position(u);
            assert!(at.iter().chain(&element.rotary(u)).all(|x| x.is_finite()), "line {}: {at:?} at {u}", element.line);
            assert!(element.curve.speed(u).is_finite());
        }
        let length = element.length();
        assert!(length.is_finite() && length > 0.0, "line {}: a length of {length}", element.line);
        assert!(element.rapid || (element.planned_feed_per_min().is_finite() && element.feed_per_min > 0.0));
        pieces += (element.curve.length() / 8.0).max(element.turn.angle() / 5.0).max(1.0);
        if let Some(last) = last {
            joined_to(last, element);
        }
        kinds.insert((element.rapid, element.tool_center, matches!(element.curve, Curve::Nurbs { .. })));
        last = Some(element);
    }
    saw(kinds);
    assert!(pieces <= 1.01 * most_pieces as f64, "{pieces} pieces");
    assert!(program.length().is_finite());
    let machine = machines::five_axes();
    match program.check_axes(&machine).and_then(|()| {
        program.check_duration(1000.0, |m| if m.rapid { 100.0 } else { m.planned_feed_per_min() / 60.0 })
    }) {
        Ok(()) => saw("runs"),
        Err(error) => refused(error),
    }
    program.notes.iter().for_each(|note| assert!(!note.to_string().is_empty()));
}

fn joined_to(last: &Move, element: &Move) {
    if last.tool_center != element.tool_center {
        return;
    }
    let from = last.curve.position(last.curve.domain().1);
    let to = element.curve.position(element.curve.domain().0);
    let scale = from.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
    let gap = from.iter().zip(to).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(gap <= 1e-9 * scale, "line {} begins {gap} mm from where line {} ends", element.line, last.line);
    let turned = last.turn.end().iter().zip(element.turn.start).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(turned <= 1e-9 * scale.max(1e6), "line {} begins {turned} degrees off", element.line);
}
