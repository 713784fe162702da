//! Grids over two or three axes: read, rounded, compiled, looked up and imported.

use std::fs;
use std::path::Path;
use tempfile::TempDir;
use trueaxis::compensation::{Compensation, Direction, Query, ThermalLine, requirement};
use trueaxis::machine::{AXES, Axis, ErrorModel, Row};
use trueaxis::tcomp::{HEADER_BYTES, Stored, Tcomp, TcompError, checksum};
use trueaxis::{Conditions, Nanometres, Position, Real, ServoLoop};
use trueaxis_tables::collapse::{CollapseOptions, collapse};
use trueaxis_tables::error::FileError;
use trueaxis_tables::exact::{CorrectionSettings, Geometry};
use trueaxis_tables::files::{Folder, Memory};
use trueaxis_tables::formats::{Format, import, machine_files};
use trueaxis_tables::{Grid, GridSource, Machine, Table, Warning, check, compile, summary};
use trueaxis_testing::noise::Noise;

const TOML: &str = "name = \"m\"\nchain = \"w b Y X Z t\"\ntool_mm = [12.0, -7.0, -90.0]\n\
    [axis.X]\ntravel_mm = [-200.0, 200.0]\n[axis.Y]\ntravel_mm = [-100.0, 100.0]\n[axis.Z]\ntravel_mm = [-150.0, 0.0]\n";
const GRID: &str = "[[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"grid.csv\"\n";
const CSV: &str = "X_mm,Y_mm,EZ_um,EX_um\n100,-50,4,1.5\n-100,-50,1,0\n-100,50,2,0\n100,50,3,-0.001\n";

fn folder(toml: &str, csv: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("machine.toml"), toml).unwrap();
    fs::write(folder.path().join("grid.csv"), csv).unwrap();
    folder
}

fn read(toml: &str, csv: &str) -> Result<Machine, FileError> {
    Machine::read(folder(toml, csv).path())
}

fn small() -> Machine {
    read(&format!("{TOML}{GRID}"), CSV).unwrap()
}

/// A machine of this model and chain with rotations, three axes and free nodes.
fn random(noise: &mut Noise, chain: &str, model: &str, over: &[char], turns: f64) -> Machine {
    let mut csv: String = over.iter().map(|axis| format!("{axis}_mm,")).collect();
    csv += "EX_um,EY_um,EZ_um,EA_urad,EB_urad,EC_urad\n";
    let mut places = vec![String::new()];
    for _ in over {
        let nodes: Vec<f64> =
            (0..4).map(|i| (-180.0 + 120.0 * f64::from(i) + noise.range(-30.0, 30.0)).round()).collect();
        places = places.iter().flat_map(|at| nodes.iter().map(move |node| format!("{at}{node},"))).collect();
    }
    for at in places {
        let ([x, y, z], [a, b, c]) = (noise.vector(20.0), noise.vector(turns));
        csv += &format!("{at}{x:.3},{y:.3},{z:.3},{a:.3},{b:.3},{c:.3}\n");
    }
    let letters: Vec<String> = over.iter().map(|axis| format!("\"{axis}\"")).collect();
    let measured: Vec<&str> =
        ['X', 'Y', 'Z'].iter().map(|axis| if over.contains(axis) { "0" } else { "-40.0" }).collect();
    let toml = format!(
        "name = \"m\"\nchain = \"{chain}\"\ntool_mm = [12.0, -7.0, -90.0]\n[compensation]\nmodel = \"{model}\"\n\
         [[grid]]\naxes = [{}]\ntable = \"grid.csv\"\nmeasured_at_mm = [{}]\n",
        letters.join(", "),
        measured.join(", ")
    );
    read(&toml, &csv).unwrap()
}

#[test]
fn lines_may_be_in_any_order() {
    let machine = small();
    let source = machine.grids[0].source();
    assert_eq!(source.nodes, [vec![-100.0, 100.0], vec![-50.0, 50.0], vec![]]);
    let ez: Vec<f64> = source.values.iter().map(|value| value[2] * 1e3).collect();
    assert_eq!(ez, [1.0, 2.0, 4.0, 3.0]);
    assert_eq!(machine.grids[0].data().node([1, 1, 0]).unwrap(), [-1e-6, 0.0, 3e-3, 0.0, 0.0, 0.0]);
    // The written files are read back as the same machine.
    let again = TempDir::new().unwrap();
    for (name, text) in machine_files(&machine, "again") {
        fs::write(again.path().join(name), text).unwrap();
    }
    assert_eq!(Machine::read(again.path()).unwrap(), machine);
}

#[test]
fn bad_grids_are_refused_with_their_place() {
    let refused = |toml: &str, csv: &str| read(&format!("{TOML}{toml}"), csv).unwrap_err().to_string();
    let line = |csv: &str, place: &str, words: &str| {
        let error = refused(GRID, csv);
        assert!(error.contains(place) && error.contains(words), "{error}");
    };
    line("X_mm,Y_mm,EZ\n", "grid.csv:1: column EZ:", "needed EZ_um (the unit is part of the name)");
    line("X_mm,Y_mm,EZ_mm\n", "grid.csv:1: column EZ_mm:", "needed EZ_um");
    line("X_mm,Y_mm,Z_mm,EZ_um\n", "grid.csv:1: column Z_mm:", "X and Y only");
    line("X_mm,EZ_um\n", "grid.csv:1:", "needed a column Y_mm");
    line("X_mm,Y_mm\n", "grid.csv:1:", "at least one, like EZ_um");
    line("X_mm,Y_mm,EZ_um,EZ_um\n", "grid.csv:1: column EZ_um:", "every column once");
    line(&format!("{CSV}100,50,7,0\n"), "grid.csv:6:", "line 5 already has it");
    line(&CSV.replace("100,50,3,-0.001\n", ""), "grid.csv:", "found 3 of 4 nodes, none at X 100, Y 50");
    line(&CSV.replace("100,50,3", "100.0005,50,3"), "grid.csv:5: column X_mm:", "a node at least 0.001 mm from it");
    line(&CSV.replace("100,-50,4", "100,-50,10000.1"), "grid.csv:2: column EZ_um:", "-10000 to 10000 um");
    line(&CSV.replace("100,-50,4", "1e7,-50,4"), "grid.csv:2: column X_mm:", "-1e6 to 1e6 mm");
    line(&CSV.replace("100,-50,4", "100,-50,x"), "grid.csv:2: column EZ_um:", "a number");
    line("X_mm,Y_mm,EZ_um\n0,0,1\n0,9,1\n", "grid.csv: column X_mm:", "2 to 1000 nodes");
    let error = refused(&format!("{GRID}resolution_um = 0.0001\n"), CSV);
    assert!(
        error.contains("column EZ_um") && error.contains("up to 4 um") && error.contains("resolution_um"),
        "{error}"
    );
    for (toml, place, words) in [
        ("[[grid]]\ntable = \"grid.csv\"\n", "machine.toml:11: key grid.axes", "two or three linear axes"),
        ("[[grid]]\naxes = [\"X\"]\ntable = \"grid.csv\"\n", "machine.toml:11: key grid.axes", "two or three"),
        ("[[grid]]\naxes = [\"X\", \"C\"]\ntable = \"grid.csv\"\n", "machine.toml:11: key grid.axes", "two or three"),
        ("[[grid]]\naxes = \"XY\"\ntable = \"grid.csv\"\n", "machine.toml:11: key grid.axes", "a list of axes"),
        ("[[grid]]\naxes = [\"X\", \"Y\"]\n", "machine.toml:11: key grid.table", "the CSV of the grid"),
        ("[[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"no.csv\"\n", "machine.toml:12: key grid.table", "no file"),
        (
            "[[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"grid.csv\"\nfade = 1\n",
            "machine.toml:13: key grid.fade",
            "fade_mm",
        ),
        (
            "[[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"grid.csv\"\nfade_mm = [9, 2]\n",
            "machine.toml:13: key grid.fade_mm",
            "above",
        ),
        (
            "[[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"grid.csv\"\nmeasured_at_mm = [1, 0, 0]\n",
            "machine.toml:13: key grid.measured_at_mm",
            "0 for an axis",
        ),
        (&format!("{}{}{}{}{}", GRID, GRID, GRID, GRID, GRID), "machine.toml:", "at most 4"),
    ] {
        let error = refused(toml, CSV);
        assert!(error.contains(place) && error.contains(words), "{error}");
    }
    // Too steep: one millimetre per millimetre.
    let steep = "X_mm,Y_mm,EZ_um\n0,0,-400\n0,1,400\n1,0,-400\n1,1,400\n";
    assert!(refused(GRID, steep).contains("a norm of 0.8"), "{}", refused(GRID, steep));
}

/// Every stored error is within half of the resolution, whatever the resolution.
#[test]
fn rounding_keeps_its_bound() {
    let mut noise = Noise::new(3);
    for case in 0..300 {
        let size = 10f64.powf(noise.range(-7.0, 0.0));
        let values = (0..6).map(|_| core::array::from_fn(|k| size * noise.signed() * if k < 3 { 1.0 } else { 1e-2 }));
        let nodes = [vec![0.0, 7.0], vec![1.0, 2.0, 4.0], vec![]];
        let source = GridSource { nodes, given: [true; 6], values: values.collect(), ..GridSource::default() };
        let grid = Grid::new(source.clone()).unwrap();
        let (data, scales) = (grid.data(), grid.header().scales);
        for (index, value) in data.indices().zip(&source.values) {
            let stored = data.node(index).unwrap();
            for k in 0..6 {
                assert!((stored[k] - value[k]).abs() <= 0.5000001 * scales[k], "{case} {k}");
            }
        }
        // No coarser than needed: the next finer step of 1, 2, 5 could not store it.
        for k in 0..6 {
            let most = source.values.iter().fold(0.0f64, |most, value| most.max(value[k].abs()));
            let floor = if k < 3 { 1e-6 } else { 1e-9 };
            assert!(scales[k] <= floor * 1.0000001 || most > scales[k] / 2.5 * 32_767.0 * 0.999_999, "{case} {k}");
        }
    }
}

#[test]
fn ten_thousand_nodes_are_sixty_thousand_bytes() {
    let nodes = [(0..100).map(f64::from).collect(), (0..100).map(f64::from).collect(), vec![]];
    let given = [true, true, true, false, false, false];
    let values = (0..10_000).map(|i| [1e-6 * f64::from(i % 7), 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
    let mut machine = small();
    let without = Machine { grids: Vec::new(), ..machine.clone() };
    machine.grids = vec![Grid::new(GridSource { nodes, given, values, ..GridSource::default() }).unwrap()];
    let bytes = compile(&machine).unwrap();
    assert_eq!(machine.grids[0].data().size(), 60_000);
    let table = Machine { grids: vec![small().grids[0].clone()], ..without };
    let smallest = compile(&table).unwrap().len() - small().grids[0].data().size();
    assert!(bytes.len() - smallest == 60_000 && bytes.len() - 60_000 < 1500, "{}", bytes.len());
    let file = Tcomp::parse(&bytes).unwrap();
    assert_eq!((file.requirement(), file.grids().len()), (0, 1));
}

#[test]
fn a_compiled_grid_comes_back_and_no_damage_passes() {
    let machine = small();
    let good = compile(&machine).unwrap();
    assert_eq!(good[8..10], [5, 0]);
    let file = Tcomp::parse(&good).unwrap();
    assert_eq!(compile(&Machine::from_tcomp(&file)).unwrap(), good);
    let mut bytes = good.clone();
    for place in 0..bytes.len() {
        for bit in 0..8 {
            bytes[place] ^= 1 << bit;
            assert!(Tcomp::parse(&bytes).is_err(), "{place} {bit}");
            bytes[place] ^= 1 << bit;
        }
    }
    for length in 0..good.len() {
        assert!(Tcomp::parse(&good[..length]).is_err(), "{length}");
    }
    // With a valid checksum: the number of grids, a truncated grid or one with trailing bytes, an invalid header.
    let payload = &good[HEADER_BYTES..good.len() - 4];
    let forged = |payload: &[u8]| {
        let mut bytes = good[..14].to_vec();
        bytes.extend((payload.len() as u32).to_le_bytes());
        bytes.extend(payload);
        bytes.extend(checksum(&bytes).to_le_bytes());
        Tcomp::parse(&bytes).map(|_| ()).err()
    };
    assert_eq!(forged(payload), None);
    let grids = payload.len() - 1 - postcard::to_stdvec(&Stored(machine.grids[0].header())).unwrap().len() - 16;
    let with_count = |count: u8| [&payload[..grids], &[count], &payload[grids + 1..]].concat();
    assert_eq!(forged(&with_count(0)), Some(TcompError::GridHeader));
    assert_eq!(forged(&with_count(2)), Some(TcompError::GridHeader));
    assert_eq!(forged(&payload[..payload.len() - 1]), Some(TcompError::GridTooLong));
    assert_eq!(forged(&payload[..grids]), Some(TcompError::GridHeader));
    assert_eq!(forged(&[payload, &[0]].concat()), Some(TcompError::PayloadTooLong));
    let five: Vec<u8> = payload[grids + 1..].repeat(5);
    assert_eq!(forged(&[&payload[..grids], &[5], &five].concat()), Some(TcompError::GridHeader));
    for place in grids + 1..payload.len() {
        for value in [0, 1, 0x7f, 0x80, 0xff] {
            let mut other = payload.to_vec();
            other[place] = value;
            if forged(&other).is_none() {
                // Whatever is accepted must be a valid grid.
                let mut bytes = good[..14].to_vec();
                bytes.extend((other.len() as u32).to_le_bytes());
                bytes.extend(&other);
                bytes.extend(checksum(&bytes).to_le_bytes());
                let file = Tcomp::parse(&bytes).unwrap();
                assert!(trueaxis::check::grids(file.settings(), file.grids()).is_ok(), "{place} {value}");
            }
        }
    }
    // Files without grids are unchanged: version 4. With encoder steps it is 6, with or without grids; with resonances 7.
    let sample = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../compensation-tables/mill-3axis"));
    let mut table = Machine::read(sample).unwrap();
    assert_eq!(compile(&table).unwrap()[8..10], [7, 0]);
    table.settings.contour.feedback = None;
    table.settings.axes.iter_mut().for_each(|axis| axis.servo.drive.as_mut().unwrap().lowest_resonance_hz = 0.0);
    assert_eq!(compile(&table).unwrap()[8..10], [6, 0]);
    table.settings.axes.iter_mut().for_each(|axis| axis.encoder_resolution = None);
    assert_eq!(compile(&table).unwrap()[8..10], [4, 0]);
    let mut machine = small();
    for (steps, version) in [([None; 3], 5), ([None, Some(1e-4), None], 6)] {
        for (axis, step) in machine.settings.axes.iter_mut().zip(steps) {
            axis.encoder_resolution = step;
        }
        let bytes = compile(&machine).unwrap();
        assert_eq!(bytes[8..10], [version, 0]);
        let file = Tcomp::parse(&bytes).unwrap();
        assert_eq!((file.settings(), file.grids().len()), (&machine.settings, machine.grids.len()));
    }
}

/// Error of the tip according to the step's model.
fn modelled<const N: usize>(machine: &Machine, position: [f64; N]) -> ([f64; N], [f64; 3], [f64; 3]) {
    let rows = |axis: Axis| machine.rows(axis);
    let mut memory = vec![0.0; requirement(&machine.settings, rows)];
    let grids = machine.grids();
    let passes = trueaxis::check::machine(&machine.settings, rows, &grids).unwrap();
    let model = Compensation::<f64, f64, N>::build(&machine.settings, rows, &grids, passes, &mut memory).unwrap();
    let (directions, thermal) = ([Direction::POSITIVE; N], [ThermalLine::default(); N]);
    let at = model.coordinates(&position);
    let query = Query::at(&at, &directions, &thermal);
    let pose = model.pose_error(&query, &mut 0);
    (model.correction(&query, &mut 0), pose.tip.into(), pose.orientation.into())
}

fn all<const N: usize>(position: [f64; N]) -> [f64; AXES] {
    let mut all = [0.0; AXES];
    all[..N].copy_from_slice(&position);
    all
}

/// Compares the core's look-up of rounded nodes with the plant's look-up of the given ones, translations only.
#[test]
fn the_nine_terms_and_the_plant_agree_on_a_grid() {
    let mut noise = Noise::new(5);
    for over in [&['X', 'Y'][..], &['X', 'Z'], &['Y', 'Z'], &['X', 'Y', 'Z']] {
        for chain in ["w b Y X Z t", "w X' Y' b Z t", "w X' b Y Z t"] {
            let machine = random(&mut noise, chain, "nine", over, 0.0);
            let geometry = Geometry::new(&machine, 0.0).unwrap();
            for _ in 0..200 {
                let at = noise.vector(250.0);
                let (_, tip, _) = modelled::<3>(&machine, at);
                let exact = geometry.tip_error(&all(at), &[0.0; AXES]);
                for k in 0..3 {
                    // Values with three decimals of µm are stored exactly.
                    assert!((tip[k] - exact[k]).abs() < 1e-12, "{chain} {over:?} {at:?}: {tip:?} {exact:?}");
                }
            }
        }
    }
}

/// Rotations, with their levers on slides and on a head, to first order: the products of transforms differ by |w|² times the
/// lever.
#[test]
fn the_volumetric_rotations_are_those_of_the_transforms() {
    let mut noise = Noise::new(6);
    let urad = 10.0;
    for over in [&['X', 'Y'][..], &['X', 'Z'], &['X', 'Y', 'Z']] {
        for chain in ["w b Y X Z t", "w X' Y' b Z t"] {
            check_rotations::<3>(&random(&mut noise, chain, "volumetric", over, urad), &mut noise);
        }
        for chain in ["w C' A' Y' b X Z t", "w X' b Y Z C A t", "w C' b X Y Z A t"] {
            let mut machine = random(&mut noise, chain, "volumetric", over, urad);
            machine.settings.axes[3].offset_mm = [3.0, 40.0, -20.0];
            machine.settings.axes[4].offset_mm = [-5.0, 0.0, 30.0];
            check_rotations::<5>(&machine, &mut noise);
        }
    }
}

fn check_rotations<const N: usize>(machine: &Machine, noise: &mut Noise) {
    assert_eq!(machine.settings.compensation.model, ErrorModel::Volumetric);
    let geometry = Geometry::new(machine, 0.0).unwrap();
    for _ in 0..100 {
        let at: [f64; N] = core::array::from_fn(|k| noise.range(-200.0, 200.0) * if k < 3 { 1.0 } else { 0.4 });
        let (correction, tip, turn) = modelled::<N>(machine, at);
        let exact = geometry.pose_error(&all(at), &[0.0; AXES]);
        for k in 0..3 {
            let chain = &machine.settings.chain;
            assert!((tip[k] - exact.tip_mm[k]).abs() < 2e-7, "{chain} {at:?}: {tip:?} {:?}", exact.tip_mm);
            assert!((turn[k] - exact.orientation[k]).abs() < 1e-9, "{chain} {at:?}: {turn:?} {:?}", exact.orientation);
        }
        // With the correction, the tip is where it was commanded.
        let sent: [f64; N] = core::array::from_fn(|k| at[k] + correction[k]);
        let (ideal, actual) = (geometry.ideal_pose(&all(at)), geometry.actual_pose(&all(sent), &[0.0; AXES]));
        let left: f64 = (0..3).map(|k| (ideal.tip_mm[k] - actual.tip_mm[k]).powi(2)).sum::<f64>().sqrt();
        assert!(left < 1.5e-6, "{left}");
    }
}

/// The exact inverse includes the grids: at the corrected command, the tool is where it was commanded.
#[test]
fn a_command_corrected_by_exact_transforms_leaves_nothing_of_the_grids() {
    let mut noise = Noise::new(8);
    for chain in ["w b Y X Z t", "w X' Y' b Z t", "w C' A' Y' b X Z t", "w X' b Y Z C A t"] {
        let machine = random(&mut noise, chain, "volumetric", &['X', 'Y', 'Z'], 100.0);
        let (geometry, axes) = (Geometry::new(&machine, 0.0).unwrap(), machine.settings.axes.len());
        for fade_deg in [None, Some(5.0)] {
            for _ in 0..100 {
                // Away from the pose in which A does not tilt the tool.
                let mut at = all(noise.vector(200.0));
                (axes > 3).then(|| (at[3], at[4]) = (noise.range(20.0, 90.0), noise.range(-170.0, 170.0)));
                let settings = CorrectionSettings { passes: None, fade_deg };
                let correction = geometry.correction(&at, &[0.0; AXES], settings).unwrap();
                let sent: [f64; AXES] = core::array::from_fn(|slot| at[slot] + correction[slot]);
                let (ideal, actual) = (geometry.ideal_pose(&at), geometry.actual_pose(&sent, &[0.0; AXES]));
                for k in 0..3 {
                    assert!((ideal.tip_mm[k] - actual.tip_mm[k]).abs() < 3e-12, "{chain} {at:?}: {ideal:?} {actual:?}");
                    let turned = fade_deg.is_some() && axes > 3;
                    assert!(!turned || (ideal.direction[k] - actual.direction[k]).abs() < 1e-14, "{chain} {at:?}");
                }
            }
        }
    }
}

/// Moves through the cells of a machine's grids with occasional stops, where the step's correction must equal the stateless
/// one.
fn walk<R: Real, P: Position, const N: usize>(machine: &Machine, noise: &mut Noise, tolerance: f64) {
    let bytes = compile(machine).unwrap();
    let file = Tcomp::parse(&bytes).unwrap();
    let mut memory = vec![R::ZERO; file.requirement()];
    let servo = ServoLoop::<R, P, N>::load(&file, 1_000_000, &mut memory).unwrap();
    let mut state = servo.start();
    let mut at = [0.0f64; N];
    let mut drive = at.map(P::of);
    for leg in 0..60 {
        let step: [f64; N] = core::array::from_fn(|k| if k < 3 { 0.2 } else { 0.02 } * noise.signed());
        for cycle in 0..400 {
            if cycle < 340 {
                at = core::array::from_fn(|k| (at[k] + step[k]).clamp(-230.0, 230.0));
            }
            let input = servo.input(at.map(P::of), drive);
            let output = servo.step(&mut state, &input, (), ());
            assert!(output.has_drive() && !output.stop_requested(), "{:?}", output.record.fault);
            drive = output.drive;
            if cycle == 399 {
                let command = at.map(P::of);
                let wanted = servo.correction_at(&command, &Conditions::default()).unwrap();
                for k in 0..N {
                    let off = (output.record.correction[k].to_f64() - wanted[k].to_f64()).abs();
                    assert!(off < tolerance, "{} leg {leg} axis {k}: {off:e} at {at:?}", machine.settings.chain);
                }
            }
        }
    }
}

#[test]
fn the_step_finds_its_way_from_cell_to_cell() {
    let mut noise = Noise::new(8);
    for over in [&['X', 'Y'][..], &['X', 'Z'], &['X', 'Y', 'Z']] {
        for (chain, model, turns) in
            [("w b Y X Z t", "nine", 0.0), ("w X' Y' b Z t", "volumetric", 10.0), ("w b Y X Z t", "volumetric", 10.0)]
        {
            let mut machine = random(&mut noise, chain, model, over, turns);
            // A second grid and a table in addition, so that the cells of tables are cached too.
            machine.grids.push(small().grids[0].clone());
            let row = |position: f64| {
                let errors = [1e-5 * position, 0.0, 2e-5 * position, 0.0, 0.0, 0.0];
                Row { position, forward: errors, reverse: errors }
            };
            let given = [true, false, true, false, false, false];
            machine.tables[0] =
                Some(Table { given, bidirectional: false, rows: [-300.0, 11.0, 300.0].map(row).to_vec() });
            walk::<f64, f64, 3>(&machine, &mut noise, 1.2e-6);
            walk::<f32, Nanometres, 3>(&machine, &mut noise, 3e-6);
        }
        let mut machine = random(&mut noise, "w C' A' Y' b X Z t", "volumetric", over, 10.0);
        walk::<f64, f64, 5>(&machine, &mut noise, 1.2e-6);
        machine.settings.chain = "w X' b Y Z C A t".parse().unwrap();
        walk::<f64, f64, 5>(&machine, &mut noise, 1.2e-6);
    }
}

#[test]
fn the_sample_router_is_described_and_warned_of() {
    let router =
        Machine::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../compensation-tables/router"))).unwrap();
    let bytes = compile(&router).unwrap();
    let summary = summary(&Tcomp::parse(&bytes).unwrap());
    let [rail, surface] = &summary.grids[..] else { panic!("{summary:?}") };
    assert_eq!((rail.nodes, rail.bytes, rail.axes[1].nodes), (17 * 13, 17 * 13 * 6, 13));
    assert_eq!(
        (surface.bytes, surface.fade_mm, &surface.errors[0].name[..]),
        (11 * 9 * 2, Some([-210.0, -150.0]), "EZ")
    );
    let text = summary.to_string();
    assert!(text.contains("Grid over X Y   17 × 13 nodes, 1.3 KiB in flash"), "{text}");
    assert!(text.contains("fades      from Z -210 to nothing at Z -150 mm"), "{text}");
    let warnings = check(&router, 1000.0);
    let steps = |w: &&Warning| matches!(w, Warning::GridVelocitySteps { grid: 0, component: 2, .. });
    assert!(warnings.iter().any(|w| steps(&w)), "{warnings:?}");
}

/// Remaining error of the router with corrected drives, largest and RMS over its volume, µm: without correction, with its
/// tables alone, with tables and grids.
#[test]
fn the_sample_router_is_true_with_its_grids() {
    let router =
        Machine::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../compensation-tables/router"))).unwrap();
    let tables = Machine { grids: Vec::new(), ..router.clone() };
    let geometry = Geometry::new(&router, 0.0).unwrap();
    let mut noise = Noise::new(9);
    let mut left = [[0.0f64; 2]; 3];
    for _ in 0..400 {
        let at = [noise.range(-400.0, 400.0), noise.range(-300.0, 300.0), noise.range(-400.0, 0.0)];
        let corrections = [[0.0; 3], modelled::<3>(&tables, at).0, modelled::<3>(&router, at).0];
        for (left, correction) in left.iter_mut().zip(corrections) {
            let sent: [f64; 3] = core::array::from_fn(|k| at[k] + correction[k]);
            let d = geometry.pose_error_of(&geometry.commanded(&all(at)), &all(sent), &[0.0; AXES]).tip_mm;
            let length = d.iter().map(|x| x * x).sum::<f64>().sqrt() * 1e3;
            *left = [left[0].max(length), left[1] + length * length / 400.0];
        }
    }
    let [nothing, tables, grids] = left.map(|[most, square]| [most, square.sqrt()]);
    println!("router, largest and RMS, um: {nothing:.3?} without, {tables:.3?} tables, {grids:.6?} with grids");
    assert!(nothing[1] > 60.0 && tables[1] > 40.0, "{left:?}");
    assert!(grids[0] < 0.06, "{left:?}");
}

/// 1, 2, 4, 3 µm: along X the slope of EZ is 3/200 and 1/200 mm/m, along Y 1/100 and −1/100.
#[test]
fn slopes_of_a_grid_are_in_the_rates() {
    let machine = small();
    let rates = trueaxis_tables::rates(&machine, Some(100.0));
    let z = rates.iter().find(|drive| drive.axis == Axis::Z).unwrap();
    assert!((z.rate - 100.0 * (3e-3 / 200.0 + 1e-3 / 100.0)).abs() < 1e-9, "{z:?}");
    assert_eq!(z.acceleration, None);
}

const MESH: &str = "[bed_mesh]\nspeed: 100\nfade_start: 0.5\nfade_end = 8 # mm\n\n[printer]\nkinematics: cartesian\n\
#*# <---------------------- SAVE_CONFIG ---------------------->\n#*# [bed_mesh default]\n#*# version = 1\n#*# points =\n\
#*# \t  0.100000, 0.000000, -0.050000\n#*# \t  0.200000, 0.030000, 0.000000\n#*# x_count = 3\n#*# y_count = 2\n\
#*# mesh_x_pps = 2\n#*# algo = lagrange\n#*# tension = 0.2\n#*# min_x = 20.0\n#*# max_x = 220.0\n#*# min_y = 30.0\n#*# max_y = 130.0\n";

fn mesh(text: &str) -> Result<trueaxis_tables::formats::Imported, FileError> {
    import(Format::BedMesh, text, Path::new("printer.cfg"), None)
}

/// Where the bed is high the nozzle is too low relative to it: EZ = −height, and the correction lifts it.
#[test]
fn a_bed_mesh_becomes_a_surface() {
    let imported = mesh(&MESH.replace("speed: 100", "fade_target: 0")).unwrap();
    assert_eq!(imported.grids.len(), 1);
    let source = imported.grids[0].source();
    let third = 100.0 / 3.0;
    let x: Vec<f64> = (0..7).map(|k| 20.0 + third * f64::from(k)).collect();
    let y = [30.0, 30.0 + third, 30.0 + 2.0 * third, 130.0];
    // To a nanometre.
    let near = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 6e-7);
    assert!(near(&source.nodes[0], &x) && near(&source.nodes[1], &y), "{:?}", source.nodes);
    for (number, value) in source.values.iter().enumerate() {
        // Parabolas through three points along X, straight lines along Y.
        let (t, s) = ((number / 4) as f64 / 3.0, (number % 4) as f64 / 3.0);
        let parabola =
            |a: f64, b: f64, c: f64| 0.5 * (t - 1.0) * (t - 2.0) * a - t * (t - 2.0) * b + 0.5 * t * (t - 1.0) * c;
        let height = (1.0 - s) * parabola(0.1, 0.0, -0.05) + s * parabola(0.2, 0.03, 0.0);
        assert!((value[2] + height).abs() < 6e-7, "{number}: {value:?}, not {height}");
    }
    // Raised by the rounded mean of Klipper's mesh, 0.036 mm.
    assert_eq!(source.fade_mm, Some([0.54, 8.0]));
    // As a separate machine.
    let alone = TempDir::new().unwrap();
    for (name, text) in imported.machine_files("printer") {
        fs::write(alone.path().join(name), text).unwrap();
    }
    let machine = Machine::read(alone.path()).unwrap();
    let (correction, ..) = modelled::<3>(&machine, [20.0, 130.0, 0.0]);
    assert!((correction[2] - 0.2).abs() < 1e-5, "{correction:?}");
    // Into an existing machine: added once, and never over another grid.
    let there = folder(&format!("# mine\n{TOML}"), CSV);
    let current = Folder::new(there.path());
    let edited = imported.edit(&current, Path::new("machine.toml")).unwrap();
    // grid.csv already exists, although no file names it.
    assert_eq!(edited.files[0].0, Path::new("grid-2.csv"));
    for (name, text) in &edited.files {
        fs::write(there.path().join(name), text).unwrap();
    }
    let text = fs::read_to_string(there.path().join("machine.toml")).unwrap();
    assert!(text.starts_with("# mine\n") && text.contains("[[grid]]\naxes = [\"X\", \"Y\"]\n"), "{text}");
    assert_eq!(Machine::read(there.path()).unwrap().grids[0].source(), source);
    // A second grid over the same axes would add up.
    let grid = import(Format::Grid, "X_mm,Y_mm,EZ_um\n0,0,1\n0,9,1\n9,0,1\n9,9,1\n", Path::new("g.csv"), None).unwrap();
    let error = grid.edit(&Folder::new(there.path()), Path::new("machine.toml")).unwrap_err();
    assert!(error.to_string().contains("remove the old one"), "{error}");
}

/// A re-probed mesh replaces the previous one and reuses its files; a grid with other errors stays.
#[test]
fn a_mesh_that_is_probed_again_replaces_the_old_one() {
    let name = Path::new("machine.toml");
    let mut files = std::collections::BTreeMap::from([(
        "machine.toml".to_owned(),
        "name = \"m\"\nchain = \"w b X Y Z t\"\n".to_owned(),
    )]);
    let mut take = |imported: &trueaxis_tables::formats::Imported| {
        let edited = imported.edit(&Memory::new(files.clone()), name)?;
        files.extend(edited.files.into_iter().map(|(name, text)| (name.to_string_lossy().into_owned(), text)));
        Ok::<_, FileError>((
            Machine::read_from(&Memory::new(files.clone()), name, &mut |_| {}).unwrap(),
            edited.notes,
            files.len(),
        ))
    };
    let fading = columns([0.1, 0.2, 0.3], "fade_end: 10");
    let (machine, _, count) = take(&mesh(&fading).unwrap()).unwrap();
    assert_eq!((machine.grids.len(), count), (2, 3));
    let (machine, notes, count) = take(&mesh(&columns([0.5, 0.6, 0.7], "fade_end: 10")).unwrap()).unwrap();
    assert_eq!((machine.grids.len(), count), (2, 3));
    assert!(notes.iter().any(|note| note == "the grid \"grid.csv\" is replaced"), "{notes:?}");
    assert!((modelled::<3>(&machine, [20.0, 100.0, 0.2]).0[2] - 0.5).abs() < 5e-5);
    // A mesh without a fade needs only one grid.
    let (machine, ..) = take(&mesh(&columns([0.5, 0.6, 0.7], "")).unwrap()).unwrap();
    assert_eq!(machine.grids.len(), 1);
    let other =
        import(Format::Grid, "X_mm,Z_mm,EX_um\n0,0,1\n0,9,1\n9,0,1\n9,9,1\n", Path::new("g.csv"), None).unwrap();
    take(&other).unwrap();
    let (machine, ..) = take(&mesh(&fading).unwrap()).unwrap();
    assert_eq!(machine.grids.len(), 3);
}

/// With several meshes, `default` or the named one is used.
#[test]
fn one_of_several_meshes_is_named() {
    use trueaxis_tables::formats::bed_mesh;
    let other = columns([0.5, 0.6, 0.7], "").replace("[bed_mesh]\n\n", "").replace("default", "cold bed");
    let both = format!("{MESH}{other}");
    let at = |name| {
        let imported = bed_mesh::import(&both, Path::new("printer.cfg"), name).unwrap();
        -imported.grids[0].source().values[0][2]
    };
    assert!((at(None) - at(Some("default"))).abs() < 1e-12);
    // The mesh fades to the mean.
    assert!((at(Some("cold bed")) - (0.5 - 0.6)).abs() < 1e-6, "{}", at(Some("cold bed")));
    let refused = |text: &str, name| bed_mesh::import(text, Path::new("printer.cfg"), name).unwrap_err().to_string();
    let error = refused(&both, Some("hot"));
    assert!(error.contains("no [bed_mesh hot]") && error.contains("default, cold bed"), "{error}");
    let error = refused(&both.replace("default", "warm"), None);
    assert!(
        error.contains("[bed_mesh cold bed] beside [bed_mesh warm]") && error.contains("warm, cold bed"),
        "{error}"
    );
}

/// Points between the probed ones by a cardinal spline, compared with its Hermite form.
#[test]
fn a_bicubic_mesh_is_read_as_klipper_lays_it() {
    let heights = [0.1, -0.05, 0.2, 0.0, 0.07];
    let row: Vec<String> = heights.iter().map(f64::to_string).collect();
    let rows = format!("#*# \t{}\n", row.join(", ")).repeat(4);
    let text = format!(
        "#*# [bed_mesh default]\n#*# points =\n{rows}#*# x_count = 5\n#*# y_count = 4\n#*# mesh_x_pps = 3\n#*# mesh_y_pps = 0\n\
         #*# algo = bicubic\n#*# tension = 0.3\n#*# min_x = 0\n#*# max_x = 80\n#*# min_y = 0\n#*# max_y = 60\n"
    );
    let imported = mesh(&text).unwrap();
    let source = imported.grids[0].source();
    assert_eq!((source.nodes[0].len(), source.nodes[1].len()), (17, 4));
    for (number, value) in source.values.iter().enumerate().step_by(4) {
        let (index, t) = ((number / 16).min(3), (number / 4) as f64 / 4.0 - (number / 16).min(3) as f64);
        let of = |k: isize| heights[(index as isize + k).clamp(0, 4) as usize];
        let (p0, p1, slope0, slope1) = (of(0), of(1), 0.3 * (of(1) - of(-1)), 0.3 * (of(2) - of(0)));
        let hermite = (2.0 * t * t * t - 3.0 * t * t + 1.0) * p0
            + (t * t * t - 2.0 * t * t + t) * slope0
            + (3.0 * t * t - 2.0 * t * t * t) * p1
            + (t * t * t - t * t) * slope1;
        assert!((value[2] + hermite).abs() < 6e-7, "{number}: {value:?}, not {hermite}");
    }
    for (from, to) in [
        ("mesh_x_pps = 3", "mesh_x_pps = -1"),
        ("mesh_x_pps = 3", "mesh_x_pps = 1e9"),
        ("mesh_x_pps = 3", "mesh_x_pps = 1.5"),
    ] {
        let error = mesh(&text.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains("column mesh_x_pps") && error.contains("a whole number from 0 to 248"), "{error}");
    }
    for stated in ["-0.1", "2.1", "-1e308"] {
        let error = mesh(&text.replace("tension = 0.3", &format!("tension = {stated}"))).unwrap_err().to_string();
        assert!(error.contains("column tension") && error.contains("0 to 2, as Klipper accepts"), "{error}");
    }
}

/// A machine that uses the import, with the notes about it.
fn alone(imported: &trueaxis_tables::formats::Imported) -> (Machine, Vec<String>) {
    let made = imported.new_machine("printer");
    let files = made.files.iter().map(|(name, text)| (name, text.as_str()));
    (Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap(), made.notes)
}

/// 3 by 3 points over 200 × 160 mm, columns of equal height.
fn columns(heights: [f64; 3], section: &str) -> String {
    let row = format!("#*# \t{}, {}, {}\n", heights[0], heights[1], heights[2]);
    format!(
        "[bed_mesh]\n{section}\n#*# [bed_mesh default]\n#*# points =\n{row}{row}{row}#*# x_count = 3\n#*# y_count = 3\n#*# \
         mesh_x_pps = 2\n#*# mesh_y_pps = 2\n#*# algo = lagrange\n#*# min_x = 20.0\n#*# max_x = 220.0\n#*# min_y = 20.0\n\
         #*# max_y = 180.0\n"
    )
}

/// Klipper (bed_mesh.py, `set_mesh`, `move`): below the fade Z moves by the height of the mesh, above it by fade_target, by
/// default the mean of the interpolated mesh, rounded to 0.01 mm.
#[test]
fn a_mesh_fades_to_its_mean() {
    let fade = "fade_start: 1\nfade_end: 10";
    for (heights, section, target) in [
        ([0.7, 0.8, 0.9], fade.to_owned(), 0.8),
        ([0.7, 0.8, 0.9], format!("{fade}\nfade_target: 0"), 0.0),
        ([0.7, 0.8, 0.9], format!("{fade}\nfade_target = 0.75"), 0.75),
        ([0.7, 0.8, 0.9], String::new(), f64::NAN),
        // Lagrange's parabola through 0, 0.3, 0 at seven points: (0, 5, 8, 9, 8, 5, 0) / 30, mean 35/210.
        ([0.0, 0.3, 0.0], fade.to_owned(), 0.17),
    ] {
        let (machine, _) = alone(&mesh(&columns(heights, &section)).unwrap());
        for (x, height) in [(20.0, heights[0]), (120.0, heights[1]), (220.0, heights[2])] {
            for z in [0.2, 20.0] {
                let wanted = if z < 1.0 || target.is_nan() { height } else { target };
                let found = modelled::<3>(&machine, [x, 100.0, z]).0[2];
                assert!((found - wanted).abs() < 2e-5, "{heights:?} {section} {x} {z}: {found}, not {wanted}");
            }
            // Half of it half-way, apart from the height's difference from the mean.
            if !target.is_nan() {
                let found = modelled::<3>(&machine, [x, 100.0, 5.5]).0[2];
                let wanted = target + 0.5 * (height - target);
                assert!((found - wanted).abs() < 0.04 * (height - target).abs() + 2e-5, "{found}, not {wanted}");
            }
        }
    }
}

/// An import passes its own limits; a stated limit stays, and the note says how much it takes away.
#[test]
fn limits_let_an_import_pass() {
    let above = |machine: &Machine| {
        let above = |warning: &Warning| {
            matches!(warning, Warning::MagnitudeAboveLimit { .. } | Warning::SlopeAboveLimit { .. })
        };
        check(machine, 1000.0).iter().any(above)
    };
    let (machine, notes) = alone(&mesh(&columns([0.0, 0.1, 0.2], "fade_start: 1\nfade_end: 10")).unwrap());
    assert!(!above(&machine));
    assert_eq!(machine.settings.axis(Axis::Z).unwrap().limits.magnitude, 0.24);
    let said = [
        "limits.magnitude_um of axis Z set to 240, as the corrections reach 200; the default is 100",
        // The fade at 500 mm/s, 0.1 mm over 9 mm, and 1 µm/mm along X.
        "limits.slope_mm_per_s of axis Z set to 7.3, as the corrections reach 6.056; the default is 5",
    ];
    assert_eq!(notes, said);
    // 2 mm of offset, 0.1 mm of shape: with steep flanks the slope too, 0.4 mm over 5 mm at 500 mm/s.
    let (machine, _) = alone(&mesh(&columns([1.9, 2.0, 2.1], "fade_start: 1\nfade_end: 10")).unwrap());
    assert!(!above(&machine));
    let steep = "X_mm,Y_mm,EZ_um\n0,0,0\n0,100,0\n5,0,400\n5,100,400\n";
    let (machine, notes) = alone(&import(Format::Grid, steep, Path::new("g.csv"), None).unwrap());
    assert!(!above(&machine));
    assert!(notes.iter().any(|note| note.starts_with("limits.slope_mm_per_s of axis Z set to 48,")), "{notes:?}");
    // A rack.
    let rack = "-300 -300.400 -300.380\n0 0.000 0.02\n300 300.300 300.320\n";
    let rack = import(Format::from_name("linuxcnc-0").unwrap(), rack, Path::new("x.comp"), Some(Axis::X)).unwrap();
    let (machine, notes) = alone(&rack);
    assert!(!above(&machine) && notes[0].starts_with("limits.magnitude_um of axis X set to 480,"), "{notes:?}");
    // Into existing machines: one with the default, one that states its limit, one whose joint has no room left.
    let short = "-300 -299.6 -299.6\n0 0 0\n300 299.7 299.7\n";
    let rack = import(Format::from_name("linuxcnc-0").unwrap(), short, Path::new("x.comp"), Some(Axis::X)).unwrap();
    for (more, said, limit) in [
        ("", "limits.magnitude_um of axis X set to 480, as the corrections reach 400; the default is 100", 0.48),
        (
            "limits = { magnitude_um = 50.0 }",
            "limits.magnitude_um of axis X stays at 50, as it is stated, though the corrections reach 400: raise it to 480",
            0.05,
        ),
        ("joint_mm = [-300.2, 300.2]", "limits are unchanged, as with higher ones", 0.1),
    ] {
        let toml = format!("name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntravel_mm = [-300.0, 300.0]\n{more}\n");
        let current = Memory::new([("machine.toml", toml)]);
        let edited = rack.edit(&current, Path::new("machine.toml")).unwrap();
        assert!(edited.notes.iter().any(|note| note.starts_with(said)), "{:?}", edited.notes);
        let files = edited.files.iter().map(|(name, text)| (name, text.as_str()));
        let machine = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap();
        assert_eq!(machine.settings.axis(Axis::X).unwrap().limits.magnitude, limit, "{more}");
    }
}

/// A bed that is 2 mm off including its probe offset is imported, and a note reports the offset.
#[test]
fn a_mesh_above_a_millimetre_is_imported() {
    let imported = mesh(&columns([1.9, 2.0, 2.1], "")).unwrap();
    let note =
        "the heights are 2 mm on average: with that in the Z offset of the machine, 0.1 mm remain to be corrected";
    assert!(imported.notes.iter().any(|own| own == note), "{:?}", imported.notes);
    let (machine, _) = alone(&imported);
    assert!((modelled::<3>(&machine, [220.0, 100.0, 0.2]).0[2] - 2.1).abs() < 5e-5);
    let bytes = compile(&machine).unwrap();
    let tables = Tcomp::parse(&bytes).unwrap();
    let mut memory = vec![0.0_f32; tables.requirement()];
    let servo = ServoLoop::<f32, Nanometres, 3>::load(&tables, 1_000_000, &mut memory).unwrap();
    let at = [220.0, 100.0, 0.2].map(<Nanometres as Position>::of);
    let correction = servo.correction_at(&at, &Conditions::default()).unwrap();
    assert!((correction[2] - 2.1).abs() < 5e-5, "{correction:?}");
}

#[test]
fn damaged_meshes_are_refused_with_their_line() {
    for (from, to, place, words) in [
        ("[bed_mesh default]", "[probe]", "printer.cfg:", "no [bed_mesh NAME]"),
        ("x_count = 3", "x_count = 4", "printer.cfg:12: column points", "4, as x_count says"),
        ("y_count = 2", "y_count = 3", "printer.cfg:11: column points", "3, as y_count says"),
        ("x_count = 3", "x_count = 2.5", "printer.cfg:14: column x_count", "a whole number"),
        ("x_count = 3", "x_count = 1e9", "printer.cfg:14: column x_count", "a whole number"),
        ("0.030000", "soft", "printer.cfg:13: column points", "a number"),
        ("0.030000", "30.0", "printer.cfg:13: column points", "-10000 to 10000 um"),
        ("max_x = 220.0", "max_x = 20.0", "printer.cfg:20: column max_x", "more than min_x"),
        ("#*# min_y = 30.0\n", "", "printer.cfg:9: column min_y", "a number in the section"),
        ("fade_end = 8", "fade_end = 0.2", "printer.cfg:4: column fade_end", "more than fade_start"),
        (
            "speed: 100",
            "fade_target: 0.3",
            "printer.cfg:2: column fade_target",
            "a height of the mesh, -0.05 to 0.2, or 0",
        ),
    ] {
        assert!(MESH.contains(from));
        let error = mesh(&MESH.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(place) && error.contains(words), "{error}");
    }
    for end in 0..MESH.len() {
        let _ = mesh(&MESH[..end]);
    }
}

#[test]
fn a_grid_csv_is_imported() {
    let imported = import(Format::Grid, CSV, Path::new("g.csv"), None).unwrap();
    assert_eq!(imported.grids[0].source(), small().grids[0].source());
    let error = import(Format::Grid, "X_mm,EX_um\n0,1\n", Path::new("g.csv"), None).unwrap_err();
    assert!(error.to_string().contains("two or three of X_mm Y_mm Z_mm"), "{error}");
}

#[test]
fn a_collapse_reports_whether_a_grid_is_needed() {
    let pitch = |tail: &str| {
        let folder = folder(
            &format!(
                "{}[axis.X]\ntable = \"x.csv\"\ntravel_mm = [-200, 200]\n{tail}",
                &TOML[..TOML.find("[axis.X]").unwrap()]
            ),
            CSV,
        );
        fs::write(folder.path().join("x.csv"), "X_mm,EBX_urad,EXX_um\n-200,-200,1\n200,200,3\n").unwrap();
        let rest = "[axis.Y]\ntravel_mm = [-100, 100]\n[axis.Z]\ntravel_mm = [0, 300]\n";
        let text = fs::read_to_string(folder.path().join("machine.toml")).unwrap();
        fs::write(folder.path().join("machine.toml"), format!("{text}{rest}")).unwrap();
        Machine::read(folder.path()).unwrap()
    };
    let machine = pitch("");
    let collapsed = collapse(&machine, &CollapseOptions::default()).unwrap();
    let grid = collapsed.grid.unwrap();
    // k x z is bilinear: the grid represents it except for rounding.
    assert!(grid.needed && grid.left.max_mm < 0.02 * collapsed.after.max_mm, "{grid:?} {:?}", collapsed.after);
    assert_eq!((grid.nodes, grid.bytes), ([5, 5, 5], 750));
    let options = CollapseOptions { grid: Some([2, 0, 2]), ..CollapseOptions::default() };
    assert_eq!(collapse(&machine, &options).unwrap().grid.map(|grid| (grid.bytes, grid.needed)), Some((24, true)));
    let options = CollapseOptions { grid: Some([2, 0, 0]), ..CollapseOptions::default() };
    assert_eq!(collapse(&machine, &options).unwrap().grid, None);
    // Tables alone suffice for errors that they can express.
    let mut straight = machine.clone();
    straight.tables.iter_mut().flatten().flat_map(|table| &mut table.rows).for_each(|row| {
        row.forward[4] = 0.0;
        row.reverse[4] = 0.0;
    });
    assert!(!collapse(&straight, &CollapseOptions::default()).unwrap().grid.unwrap().needed);
    // A machine's existing grid stays, and its errors are not fitted twice.
    let mut with = straight;
    with.grids = small().grids;
    let collapsed = collapse(&with, &CollapseOptions::default()).unwrap();
    assert_eq!(collapsed.machine.grids, with.grids);
    assert!(collapsed.after.max_mm < 1e-7, "{:?}", collapsed.after);
}
