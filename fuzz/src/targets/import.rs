//! Compensation files of other controls, one target per format.

use crate::execution::SLOWEST;
use crate::outcome::{accepted, refused, saw};
use crate::{Target, no_repair};
use std::path::Path;
use trueaxis::Axis;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::{ExportOptions, Format, Imported, Loss, export, import};
use trueaxis_tables::text::decode;

const DICTIONARY: &str = include_str!("../../dictionaries/import.dict");

/// A target for the file after a line with the letter of its axis, which may be empty.
const fn target(name: &'static str, about: &'static str, run: fn(&[u8]), seeds: fn() -> Vec<Vec<u8>>) -> Target {
    Target { name, about, run, seeds, repair: no_repair, dictionary: DICTIONARY, slowest: SLOWEST }
}

/// LinuxCNC's `COMP_FILE` of type 0.
pub const LINUXCNC_0: Target = target(
    "import_linuxcnc_0",
    "LinuxCNC COMP_FILE, type 0",
    |input| run(Format::LinuxCnc(CompFileType::Positions), input),
    || {
        vec![
            b"X\n-1.000 -1.005 -0.995\n0.000 0.002 -0.003 # home\r\n1.000 1.003 0.998\n\n".to_vec(),
            b"C\n0 0 0\n180 180.001 180.001\n360 360 360\n".to_vec(),
        ]
    },
);

/// LinuxCNC's `COMP_FILE` of type 1.
pub const LINUXCNC_1: Target = target(
    "import_linuxcnc_1",
    "LinuxCNC COMP_FILE, type 1",
    |input| run(Format::LinuxCnc(CompFileType::Trims), input),
    || {
        vec![
            b"Y\n-1.000 0.005 -0.005\n0.000 -0.002 0.003\n1.000 -0.003 0.002\n".to_vec(),
            b"A\n0 0 0\n180 -0.001 -0.0010\n360 0 0\n".to_vec(),
        ]
    },
);

/// `$AA_ENC_COMP` of Siemens.
pub const SIEMENS: Target = target(
    "import_siemens",
    "Siemens $AA_ENC_COMP",
    |input| run(Format::Siemens, input),
    || {
        let one = "\n%_N_AX_EEC_INI\nCHANDATA(1)\n$AA_ENC_COMP[0,0,X1]=0.012 ; point\nN20 $AA_ENC_COMP[0,1,X1]=-0.018\n\
            $AA_ENC_COMP[0,2,X1]=0.0035\n$AA_ENC_COMP_STEP[0,X1]=50.0\n$AA_ENC_COMP_MIN[0,X1]=0.0\n\
            $AA_ENC_COMP_MAX[0,X1]=100.0\n$AA_ENC_COMP_IS_MODULO[0,X1]=0\nM17\n";
        let round = "C\n$AA_ENC_COMP[1,0,AX4]=0\n$AA_ENC_COMP[1,1,AX4]=0.001\n$AA_ENC_COMP[1,2,AX4]=0\n$AA_ENC_COMP_STEP[1,AX4]=180\n\
            $AA_ENC_COMP_MIN[1,AX4]=0\n$AA_ENC_COMP_MAX[1,AX4]=360\n$AA_ENC_COMP_IS_MODULO[1,AX4]=1\n";
        vec![one.into(), round.into()]
    },
);

/// Volumetric CSV of ISG and Beckhoff.
pub const ISG: Target = target(
    "import_isg",
    "volumetric compensation of ISG and Beckhoff",
    |input| run(Format::Isg, input),
    || {
        let own = "\n// trueaxis chain: w C' X' b Z t\n// trueaxis model: volumetric\n// trueaxis tool_mm: 0 0 -250\n\
            // trueaxis axis X travel_mm: -500 500\n// trueaxis axis C direction: -1\n// trueaxis axis C offset_mm: 0 1 0\n\
            B0Z\tC0Y\tX0C\tB0C\n0.00002\t-0.000035\t0.012\t-0.000014\n#\nX\tEXX\tEYX\tECX\n0\t0.012\t0\t0\n\
            50\t-0.018\t0\t0\n100\t0.0035\t0.004\t-0.000007\n#\nC\tEXC\tECC\n0\t0\t0\n180\t0.002\t0.000017453\n360\t0\t0\n";
        let foreign = "\nA0Z B0Z C0Y\n2e-5, 0, 3e-5\n#\nY EXY EYY EZY EAY EBY ECY\n0 0.02 0.01 0.07 0 0.0042 0.003\n10;0;0;0;0;0;0\n";
        vec![own.into(), foreign.into()]
    },
);

/// Measured deviations in the layouts of ISO 230-2.
pub const ISO230_2: Target = target(
    "import_iso230_2",
    "measured deviations, ISO 230-2",
    |input| run(Format::Iso230_2, input),
    || {
        let list = "\n# laser\nC_deg,run,direction,deviation_urad\n0,1,+,0\n0,1,-,0\n180,1,+,17.453\n180,1,-,17.5\n360,1,+,0\n360,1,-,0\n";
        let matrix =
            "X\nposition_mm;fwd_1_um;rev_1_um;fwd_2_um;rev_2_um\n-10,5;1;2,5;1,25;2\n0;0;1;0;1\n10;-1;0,5;-1;0\n";
        vec![list.into(), matrix.into()]
    },
);

/// Positions or deviations in columns of any name.
pub const COLUMNS: Target = target(
    "import_columns",
    "readings in columns of any name",
    |input| run(Format::Columns, input),
    || {
        vec![
            b"X\nPosition (mm),Forward,Reverse\n0,0.4,1.9\n100,-2.1,3.6\n".to_vec(),
            b"\nC (deg);Reading [arcsec]\n180;-2,5\n0;1,25\n".to_vec(),
            b"Y\nnominal_mm\tmeasured_mm\n0\t0.0021\n100\t100.0034\n".to_vec(),
        ]
    },
);

/// Renishaw's linear measurements.
pub const RTL: Target = target(
    "import_rtl",
    "linear measurements of Renishaw's laser software",
    |input| run(Format::Rtl, input),
    || {
        vec![
            b"\nHEADER::\r\nFile type  : rtl\r\nTARGET DATA::\r\nTarget-count: 2\r\nTargets :\r\n0.0 100.0\r\nFlags: 0 0 2 0\r\n\
              USER-TEXT::\r\nAxis:X\r\nRUNS::\r\nRun-count:2\r\nDEVIATIONS::\r\nRun Target Data:\r\n1 1 0.1\r\n1 2 1.4\r\n\
              2 2 2.9\r\n2 1 0.8\r\nEOF::\r\n"
                .to_vec(),
        ]
    },
);

/// Height maps of RepRapFirmware.
pub const HEIGHTMAP: Target = target(
    "import_heightmap",
    "height maps of RepRapFirmware",
    |input| run(Format::HeightMap, input),
    || {
        vec![
            b"\nRepRapFirmware height map file v2\naxis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n\
              X,Y,20.00,220.00,20.00,120.00,-1.00,100.00,100.00,3,2\n  0.050,  0.040,      0\n  0.045, -0.010,  0.020\n"
                .to_vec(),
            b"\nRepRapFirmware height map file v1\nxmin,xmax,ymin,ymax,radius,spacing,xnum,ynum\n0,50,0,50,-1,50,2,2\n\
              0.1,0.2\n0.3,0.4\n"
                .to_vec(),
        ]
    },
);

/// Meshes that Marlin prints.
pub const MARLIN: Target = target(
    "import_marlin",
    "bed meshes in logs of Marlin",
    |input| run(Format::Marlin, input),
    || {
        vec![
            b"\nRecv:  ( 20,120) (220,120)\nRecv: 0 1 2\nRecv: 1 | +0.045  -0.010 [+0.020]\nRecv:   |\n\
              Recv: 0 | +0.050  +0.040   0.000\nRecv: ( 20, 20) (220, 20)\nRecv: echo:Fade Height 10.00\n"
                .to_vec(),
            b"\nBed X: 20.000 Y: 20.000 Z: 0.1\nBed X: 220.000 Y: 120.000 Z: 0.1\n21:29:13.047 : Bilinear Leveling Grid:\n\
              21:29:13.048 : 0 1\n21:29:13.048 : 0 +0.050 +0.040\n21:29:13.049 : 1 +0.045 -0.010\n\n"
                .to_vec(),
        ]
    },
);

/// Bed meshes of Klipper.
pub const BED_MESH: Target = target(
    "import_bed_mesh",
    "bed meshes of Klipper",
    |input| run(Format::BedMesh, input),
    || {
        vec![
            b"\n[bed_mesh]\nmesh_min: 20, 20\nmesh_max: 220, 120\nprobe_count: 3, 2\nmesh_pps: 1, 0\nalgorithm: lagrange\n\
              fade_start: 1\nfade_end: 10\nfade_target: 0.02\n#*# [bed_mesh default]\n#*# version = 1\n#*# points =\n\
              #*# \t0.0525, 0.0425, 0.0300\n#*# \t0.0475, 0.0325, 0.0200\n#*# x_count = 3\n#*# y_count = 2\n\
              #*# mesh_x_pps = 1\n#*# mesh_y_pps = 0\n#*# algo = lagrange\n#*# tension = 0.2\n#*# min_x = 20.0\n\
              #*# max_x = 220.0\n#*# min_y = 20.0\n#*# max_y = 120.0\n"
                .to_vec(),
            b"\n#*# [bed_mesh smooth]\n#*# version = 1\n#*# points =\n#*#   0.1, 0.2, 0.1, 0.0\n#*#   0.1, 0.0, 0.1, 0.2\n\
              #*#   0, 0, 0, 0\n#*#   0, 0.1, 0, 0\n#*# x_count = 4\n#*# y_count = 4\n#*# mesh_x_pps = 2\n#*# mesh_y_pps = 2\n\
              #*# algo = bicubic\n#*# tension = 0.2\n#*# min_x = 0\n#*# max_x = 90\n#*# min_y = 0\n#*# max_y = 90\n"
                .to_vec(),
        ]
    },
);

/// Grid tables.
pub const GRID: Target = target(
    "import_grid",
    "grid tables over two or three linear axes",
    |input| run(Format::Grid, input),
    || {
        vec![
            b"\nX_mm,Y_mm,EZ_um\n0,0,1.5\n0,100,-2\n50,0,0.25\n50,100,3\n".to_vec(),
            b"\nX_mm;Z_mm;EX_um;EB_urad\n0;-10;1,5;0\n0;0;2;-1\n20;-10;0;0,5\n20;0;1;1\n70;-10;0;0\n70;0;0;2\n"
                .to_vec(),
        ]
    },
);

fn run(format: Format, input: &[u8]) {
    let Some(end) = input.iter().position(|byte| *byte == b'\n') else { return refused("no line for the axis") };
    let (head, rest) = input.split_at(end);
    let axis = match head {
        [letter] => Axis::from_letter(char::from(*letter)),
        _ => None,
    };
    let file = Path::new("given");
    // Like the command line: comments of other programs may be in any encoding.
    let text = match decode(rest[1..].to_vec(), file, &['#', ';']) {
        Ok(text) => text,
        Err(error) => return refused(error),
    };
    match import(format, &text, file, axis) {
        Err(error) => refused(error),
        Ok(imported) => {
            accepted();
            used(format, axis, &imported);
        }
    }
}

/// The resulting machine is valid or is refused in words; exported in its format, it can be read again.
fn used(format: Format, axis: Option<Axis>, imported: &Imported) {
    for (axis, table) in &imported.tables {
        assert!(table.rows.len() >= 2 && table.given.contains(&true), "a table of {} without content", axis.letter());
        let numbers = table.rows.iter().flat_map(|row| row.forward.iter().chain(&row.reverse).chain([&row.position]));
        assert!(numbers.into_iter().all(|number| number.is_finite()));
        assert!(table.rows.windows(2).all(|rows| rows[0].position < rows[1].position));
    }
    for grid in &imported.grids {
        let source = grid.source();
        assert!(source.given.contains(&true) && source.values.iter().flatten().all(|value| value.is_finite()));
        let nodes = source.nodes.iter().filter(|nodes| !nodes.is_empty());
        assert_eq!(nodes.map(Vec::len).product::<usize>(), source.values.len());
        for nodes in &source.nodes {
            assert!(nodes.windows(2).all(|pair| pair[0] < pair[1]), "{nodes:?}");
        }
    }
    let files = Memory::new(imported.machine_files("imported"));
    let machine = match Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}) {
        Ok(machine) => machine,
        Err(error) => return refused(error),
    };
    saw("machine");
    assert_eq!(machine.grids.len(), imported.grids.len());
    for (read, grid) in machine.grids.iter().zip(&imported.grids) {
        let values = read.source().values.iter().flatten().zip(grid.source().values.iter().flatten());
        let off = values.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "written and read again a node is off by {off}");
    }
    for (axis, table) in &imported.tables {
        let rows = machine.rows(*axis).unwrap_or_else(|| panic!("the table of {} is lost", axis.letter()));
        assert_eq!(rows.len(), table.rows.len());
        for (read, row) in rows.iter().zip(&table.rows) {
            let pairs = read.forward.iter().zip(&row.forward).chain(read.reverse.iter().zip(&row.reverse));
            let off = pairs.map(|(a, b)| (a - b).abs()).fold((read.position - row.position).abs(), f64::max);
            assert!(off < 1e-9, "{axis:?}: written and read again a line is off by {off}");
        }
    }
    if !matches!(format, Format::LinuxCnc(_) | Format::Siemens | Format::Isg | Format::Iso230_2) {
        // The others are only read.
        return;
    }
    let axis = axis.filter(|_| matches!(format, Format::LinuxCnc(_) | Format::Iso230_2));
    let options = ExportOptions { loss: Loss::Drop, axis, ..ExportOptions::default() };
    match export(format, &machine, &options) {
        Err(error) => refused(error),
        Ok(exported) => {
            assert!(!exported.files.is_empty());
            for (name, text) in &exported.files {
                if let Err(error) = import(format, text, Path::new(name), axis) {
                    // The reader may refuse a grid finer than the digits of the format.
                    refused(error);
                }
            }
        }
    }
}
