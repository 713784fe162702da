//! Lost motion: refusals and warnings.

use std::fs;
use std::path::Path;
use tempfile::TempDir;
use trueaxis::Axis;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::{Format, Imported, import};
use trueaxis_tables::{Edited, Machine, Warning, check, lost_motion};
use trueaxis_testing::noise::Noise;

/// `w b X C t`, X with the keys and the table given.
fn written(keys: &str, table: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let toml = format!(
        "name = \"m\"\nchain = \"w C' b X t\"\n[axis.X]\ntable = \"x.csv\"\n{keys}\n[axis.C]\ntable = \"c.csv\"\nbacklash_urad = 12\n"
    );
    fs::write(folder.path().join("machine.toml"), toml).unwrap();
    fs::write(folder.path().join("x.csv"), table).unwrap();
    fs::write(folder.path().join("c.csv"), "C_deg,ECC_urad\n0,0\n360,0\n").unwrap();
    folder
}

const PLAIN: &str = "X_mm,EXX_um\n0,0\n100,5\n";

fn refusal(keys: &str, table: &str) -> String {
    let folder = written(keys, table);
    let error = Machine::read(folder.path()).unwrap_err().to_string();
    let name = folder.path().join("machine.toml");
    error.replace(&name.display().to_string(), Path::new("machine.toml").to_str().unwrap())
}

#[test]
fn a_hysteresis_that_a_reversal_crosses_is_refused_with_the_figure() {
    let against = "needed more than its correction steps against the travel at a reversal: ";
    let message = refusal("backlash_um = -1.25\nhysteresis_um = 0.5", PLAIN);
    assert!(
        message.starts_with("machine.toml:6: key axis.X.hysteresis_um: found 0.5, ") && message.contains(against),
        "{message}"
    );
    // 1.25 µm, plus a contribution of the table's slope: thousandths, rounded up.
    let bound: f64 = message.rsplit(": ").next().unwrap().trim_end_matches(" um").parse().unwrap();
    assert!((1.25..1.252).contains(&bound), "{message}");
    let folder = written(&format!("backlash_um = -1.25\nhysteresis_um = {bound}"), PLAIN);
    assert!(Machine::read(folder.path()).is_ok());

    let message = refusal("", "X_mm,EXX_fwd_um,EXX_rev_um\n0,0,1\n50,2,1.5\n100,0,1\n");
    assert!(
        message.starts_with("machine.toml:3: key axis.X.hysteresis_um: found 0.3, the default, ")
            && message.contains(against),
        "{message}"
    );
}

#[test]
fn the_encoder_bounds_the_hysteresis_of_an_axis_with_lost_motion() {
    let message = refusal("backlash_um = 2\nencoder_resolution_um = 0.2", PLAIN);
    assert!(message.ends_with("needed at least three steps of the encoder: 0.6 um"), "{message}");
    for keys in [
        "backlash_um = 2\nencoder_resolution_um = 0.1",
        "backlash_um = 2\nencoder_resolution_um = 0.2\nhysteresis_um = 0.6",
        "encoder_resolution_um = 1",
    ] {
        let machine = Machine::read(written(keys, PLAIN).path()).unwrap();
        assert!(machine.settings.axes[0].encoder_resolution.is_some());
        let files = trueaxis_tables::formats::machine_files(&machine, "");
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        assert_eq!(Machine::read(folder.path()).unwrap(), machine);
    }
    let message = refusal("encoder_resolution_um = 0", PLAIN);
    assert!(
        message.starts_with("machine.toml:5: key axis.X.encoder_resolution_um: found 0, needed 0.00001 to 1000 um"),
        "{message}"
    );
}

#[test]
fn the_distance_affected_by_lost_motion_is_reported() {
    // EXX from 1 to 2.5 µm more in negative travel, 0.5 µm of backlash on top.
    let table = "X_mm,EXX_fwd_um,EXX_rev_um\n0,0,1\n50,2,4.5\n100,0,1\n";
    let machine = Machine::read(written("backlash_um = 0.5\nmax_feed_mm_per_min = 12000", table).path()).unwrap();
    let [x, c] = lost_motion(&machine)[..] else { panic!() };
    // Up at 5 m/s² and down at 4 m/s²: t = √(2 B (1/5000 + 1/4000)).
    let seconds = (2.0_f64 * 0.003 * (1.0 / 5000.0 + 1.0 / 4000.0)).sqrt();
    assert!(
        (x.play - 0.003).abs() < 1e-15
            && (x.ramp_in_s - seconds).abs() < 1e-12
            && (x.way - 200.0 * seconds).abs() < 1e-9
    );
    assert_eq!(
        x.to_string(),
        "axis X: lost motion of up to 3.0 µm is corrected within 1.6 ms of a reversal, 0.33 mm at 200 mm/s"
    );
    assert!((c.play.to_radians() - 12e-6).abs() < 1e-15 && c.to_string().contains("12.0 µrad"), "{c}");
    let slow = |machine: &Machine| check(machine, 1e4).into_iter().find(|w| matches!(w, Warning::SlowRampIn(_)));
    assert_eq!(slow(&machine), None);

    let keys = "backlash_um = 0.5\nlimits = { slope_mm_per_s = 1, acceleration_mm_per_s2 = 200 }";
    let slowed = Machine::read(written(keys, table).path()).unwrap();
    let warning = slow(&slowed).unwrap().to_string();
    assert!(warning.contains("within 8.2 ms of a reversal"), "{warning}");
}

/// A new machine from the import.
fn made(imported: &Imported) -> (Machine, Edited) {
    let made = imported.new_machine("m");
    let files = made.files.iter().map(|(name, text)| (name, text.as_str()));
    let machine = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {});
    (machine.unwrap_or_else(|error| panic!("{error}")), made)
}

/// 21 targets, five runs in both directions, every approach off by 0.02 µm/mm, plus the lost motion in negative travel, plus
/// scatter (one sigma).
fn measured(noise: &mut Noise, scatter_um: f64, lost_um: f64) -> String {
    let mut text = String::from("X_mm,run,direction,deviation_um\n");
    for (run, target, (direction, lost)) in (1..=5).flat_map(|run| {
        (1..=21).flat_map(move |target| [("+", 0.0), ("-", lost_um)].map(|way| (run, 20.0 * f64::from(target), way)))
    }) {
        let normal = (0..12).map(|_| noise.unit()).sum::<f64>() - 6.0;
        let deviation = 0.02 * target + lost + scatter_um * normal;
        text += &format!("{target},{run},{direction},{deviation:.3}\n");
    }
    text
}

/// Columns that cross only because of scatter become one column; if the machine has lost motion both stay, and its hysteresis
/// is set as they need.
#[test]
fn every_measurement_of_both_directions_is_imported() {
    let mut noise = Noise::new(3);
    for scatter in [0.1, 0.2, 0.3, 0.5, 1.0] {
        let mut means = 0;
        for _ in 0..20 {
            let imported =
                import(Format::Iso230_2, &measured(&mut noise, scatter, 0.0), Path::new("x.csv"), None).unwrap();
            let (machine, _) = made(&imported);
            let table = machine.tables[0].as_ref().unwrap();
            if !table.bidirectional {
                means += 1;
                assert!(imported.notes[0].starts_with("the table is the mean of both directions"), "{imported:?}");
                assert_eq!(machine.settings.axes[0].hysteresis, 0.3e-3);
                // Ten approaches per target: the mean is within five standard errors.
                for row in &table.rows {
                    let truth = 0.02e-3 * row.position;
                    assert!((row.forward[0] - truth).abs() < 5.0e-3 * scatter / 10f64.sqrt() + 1e-6, "{row:?}");
                }
                // A measurement in both directions without lost motion also replaces a backlash setting.
                let toml = "name = \"m\"\nchain = \"w b X t\"\n[axis.X]\nbacklash_um = 4\n";
                let edited = imported.edit(&Memory::new([("machine.toml", toml)]), Path::new("machine.toml")).unwrap();
                assert!(edited.files.last().unwrap().1.contains("backlash_um = 0.0"), "{edited:?}");
            }
            let lost = measured(&mut noise, scatter, 2.0 * scatter);
            let imported = import(Format::Iso230_2, &lost, Path::new("x.csv"), None).unwrap();
            assert!(
                made(&imported).0.tables[0].as_ref().unwrap().bidirectional && imported.notes.is_empty(),
                "{scatter}"
            );
        }
        // Of two tests at two standard deviations, about one in eleven gives a false positive.
        assert!(means >= 14, "{scatter}: {means} of 20");
    }
}

#[test]
fn columns_that_cross_bring_the_hysteresis_that_they_need() {
    // At 100 mm the reverse column is 10 µm below the forward one.
    let file = "0 0 0.02\n50 50.01 50.03\n100 100.02 100.01\n150 150.02 150.04\n200 200.03 200.05\n";
    let format = Format::LinuxCnc(CompFileType::Positions);
    let imported = import(format, file, Path::new("x.comp"), Some(Axis::X)).unwrap();
    let (machine, edited) = made(&imported);
    let hysteresis_um = machine.settings.axes[0].hysteresis * 1e3;
    // Plus a contribution of the table's slope.
    assert!((10.0..10.02).contains(&hysteresis_um), "{hysteresis_um}");
    let said = format!(
        "hysteresis_um of axis X set to {hysteresis_um:.3}, as it has to be more than its correction steps against the travel at a \
         reversal; the default is 0.3"
    );
    assert!(edited.notes.iter().any(|note| note.starts_with(&said)), "{said}: {:?}", edited.notes);
    let into = |hysteresis: &str| {
        let toml = format!("name = \"m\"\nchain = \"w b X t\"\n[axis.X] # long\n{hysteresis}");
        imported.edit(&Memory::new([("machine.toml", toml)]), Path::new("machine.toml"))
    };
    let text = |edited: &Edited| edited.files.last().unwrap().1.clone();
    let added = into("").unwrap();
    assert!(text(&added).contains("[axis.X] # long") && text(&added).contains("hysteresis_um = 10.0"), "{added:?}");
    // A stated value stays: it is sufficient, or the import is refused.
    let stated = into("hysteresis_um = 12\n").unwrap();
    assert!(
        text(&stated).contains("hysteresis_um = 12\n") && !stated.notes.iter().any(|note| note.contains("hysteresis"))
    );
    let refused = into("hysteresis_um = 1\n").unwrap_err().to_string();
    assert!(refused.contains("hysteresis_um: found 1, needed more than its correction steps against"), "{refused}");
    // Three steps of the encoder are also needed.
    let encoder = into("encoder_resolution_um = 5\n").unwrap();
    assert!(text(&encoder).contains("hysteresis_um = 15"), "{encoder:?}");
}
