//! What `--advise` foresees, against machines that are measured: the probe by the simulated calibration and what `calibrate
//! solve` writes, a ballbar by the plant and a least-squares fit of its own. The parts are cut by the plant.

use super::plant::{Errors, Known, V, approaches, cut, program, run};
use super::{AT, COUNT, TOLERANCES, measure, part, plate};
use std::f64::consts::TAU;
use std::path::Path;
use trueaxis_evaluation::calibrate::{Task, solved};
use trueaxis_evaluation::predict::{Advice, Options, Part, advise, predict};
use trueaxis_evaluation::simulated::rehearsal::{Conditions, Drift, calibrate};
use trueaxis_metrology::linear_fit::LinearFit;
use trueaxis_sim::program::Program;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::{Correlation, Uncertainties};
use trueaxis_tables::{Additions, Machine};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;

/// Machines measured.
const MACHINES: usize = 150;
/// What a new installation may have: squareness and scales that nobody has measured.
const KNOWN: Known =
    Known { shift: 0.1e-3, turn: 0.5e-6, square: [3e-6, 3e-6, 40e-6], scale: 25e-6, play: 0.0, approach: 0.05e-3 };
/// Tolerances without a zone: the bore's size, the holes' distances.
const LINEAR: [usize; 3] = [3, 7, 9];

/// The stated machine, and the advice for the plate with tolerances that need a measurement.
fn advised(known: &Known, instruments: &str) -> (Vec<(String, String)>, Machine, Advice) {
    let (steps, lines) = plate();
    let files = Errors::stated().files(Some(known));
    let memory = Memory::new(files.clone());
    let machine = Machine::read_from(&memory, Path::new("machine.toml"), &mut |_| {}).unwrap();
    let stated = Uncertainties::read_from(&memory, Path::new("machine.toml")).unwrap();
    let program = Program::parse("plate", &program(&steps), "plate.ngc").unwrap();
    let part = Part::read(&format!("{}{instruments}", part(&lines)), Path::new("part.toml")).unwrap();
    let predicted = predict(&machine, &stated, &program, &part, Options { trials: 500, seed: 5 }).unwrap();
    let none = |_: &str| -> anyhow::Result<Task> { unreachable!() };
    let advice = advise(&machine, &stated, &program, &part, &predicted, &none).unwrap();
    (files, machine, advice)
}

/// A machine without scale and play of its own as the product reads it: the scale is in the table.
fn machine_of(errors: &Errors) -> Machine {
    let mut errors = errors.clone();
    for axis in 0..3 {
        for row in 0..11 {
            errors.table[axis][axis][row] += errors.scale[axis] * (40.0 * row as f64 - 200.0);
        }
    }
    Machine::read_from(&Memory::new(errors.files(None)), Path::new("machine.toml"), &mut |_| {}).unwrap()
}

/// The errors in the files of a machine.
fn errors_of(machine: &Machine) -> Errors {
    let mut errors = Errors::stated();
    for (axis, table) in machine.tables.iter().enumerate() {
        // A finding may add points between those of the plant's table.
        for (row, q) in (0..11).map(|row| (row, 40.0 * row as f64 - 200.0)) {
            let own = table.as_ref().unwrap().rows.iter().find(|own| (own.position - q).abs() < 1e-6).unwrap();
            (0..6).for_each(|component| errors.table[axis][component][row] = own.forward[component]);
        }
    }
    let location = &machine.settings.location;
    errors.square = [location.a0z, location.b0z, location.c0y];
    errors
}

/// Compares deviations, µm, on measured machines with the advice: their scatter about zero, and zones above their interval.
fn compare(advice: &Advice, values: &[Vec<f64>]) {
    let count = values.len() as f64;
    for (index, of) in advice.features.iter().enumerate() {
        let column = || values.iter().map(|values| values[index]);
        let above = column().filter(|value| *value > of.interval_um.high).count();
        let rms = (column().map(|value| value * value).sum::<f64>() / count).sqrt();
        let (before, after) = (of.before_um / 1.96, of.after_um / 1.96);
        println!("{} {}: before {before:.3}, foreseen {after:.3}, found {rms:.3}, {above} above", of.feature, of.kind);
        if LINEAR.contains(&index) {
            assert!((rms / after - 1.0).abs() < 0.15, "{} {}: {rms} for {after}", of.feature, of.kind);
        }
        assert!((above as f64) < 0.025 * count + 3.5 * (0.025 * count).sqrt(), "{} {}", of.feature, of.kind);
    }
}

/// Ball and ring, carried out: simulated, solved, written into the machine, and the plate cut with its new correction.
#[test]
fn the_foreseen_uncertainty_is_that_after_a_simulated_calibration() {
    let instruments = "[[instrument]]\nkind = \"ball\"\n[[instrument]]\nkind = \"ring\"\n";
    let (files, machine, advice) = advised(&KNOWN, instruments);
    let names: Vec<&str> = advice.measurements.iter().map(|of| of.name.as_str()).collect();
    assert_eq!(names, ["ball", "ring"]);
    // More than half of each is gone: otherwise the comparison would show little.
    assert!(LINEAR.iter().all(|index| advice.features[*index].after_um < 0.5 * advice.features[*index].before_um));
    let task = Task::read(&advice.task.as_ref().unwrap().text("mill"), Path::new("task.toml")).unwrap();
    let (steps, _) = plate();
    let (mut deviations, mut stated) = (Vec::new(), Vec::new());
    let values = (0..MACHINES).map(|number| {
        let mut noise = Noise::new(9000 + number as u64);
        let drawn = Errors::stated().drawn(&KNOWN, &mut noise);
        let seed = number as u64;
        let conditions = Conditions { noise_um: None, drift: Drift::Size(0.0), seed, set_up: seed };
        let log = calibrate(&task, &machine, &machine_of(&drawn), &conditions).unwrap();
        let (_, found) = solved(&task, &machine, &log, Path::new("probe.log"), |_| {}).unwrap();
        let memory = Memory::new(files.clone());
        let additions = found.additions(&task);
        deviations.push(deviations_of(&additions, &drawn));
        stated.push(additions.correlations.clone());
        let edited = additions.edit(&memory, Path::new("machine.toml")).unwrap();
        let mut after = files.clone();
        for (name, text) in edited.files {
            let name = name.display().to_string();
            after.retain(|(own, _)| *own != name);
            after.push((name, text));
        }
        let after = Machine::read_from(&Memory::new(after), Path::new("machine.toml"), &mut |_| {}).unwrap();
        let places = run(&steps, AT, &errors_of(&after), true);
        measure(&cut(&places, AT, &drawn, &approaches(COUNT, &KNOWN, &mut noise)))
    });
    let values: Vec<Vec<f64>> = values.collect();
    compare(&advice, &values);
    compare_coefficients(&deviations, &stated);
}

/// Found less true: scales of X and Y, squareness of X and Y, in units of 1e-6.
fn deviations_of(additions: &Additions, drawn: &Errors) -> V {
    let found = |key: &str| additions.findings.iter().find(|own| own.key == key).unwrap().found.value;
    let c0y = 1e6 * (drawn.square[2] - Errors::stated().square[2]);
    let [x, y] = [0, 1].map(|axis| 1e6 * drawn.scale[axis]);
    [found("axis.X.scale_ppm") - x, found("axis.Y.scale_ppm") - y, found("location.C0Y_urad") - c0y]
}

/// Coefficients that `calibrate solve` writes against those of its deviations over all machines.
fn compare_coefficients(deviations: &[V], stated: &[Vec<Correlation>]) {
    let keys = ["axis.X.scale_ppm", "axis.Y.scale_ppm", "location.C0Y_urad"];
    let mean = |part: &dyn Fn(&V) -> f64| deviations.iter().map(part).sum::<f64>() / deviations.len() as f64;
    let means: V = std::array::from_fn(|i| mean(&|of| of[i]));
    let covariance = |i: usize, j: usize| mean(&|of| (of[i] - means[i]) * (of[j] - means[j]));
    for [i, j] in [[0, 1], [0, 2], [1, 2]] {
        let own = |own: &&Correlation| own.between.contains(&keys[i].into()) && own.between.contains(&keys[j].into());
        let of = |all: &Vec<Correlation>| all.iter().find(own).unwrap().coefficient;
        let stated = stated.iter().map(of).sum::<f64>() / stated.len() as f64;
        let found = covariance(i, j) / (covariance(i, i) * covariance(j, j)).sqrt();
        println!("{} and {}: written {stated:.3}, scatter {found:.3}", keys[i], keys[j]);
        assert!((stated - found).abs() < 0.25, "{} and {}: {stated} for {found}", keys[i], keys[j]);
    }
}

/// Readings of the plant around a circle, and the squareness and scales that a fit finds in them, beside what is known.
fn circular_test(drawn: &Errors, corrected: &Errors, centre: V, noise: &mut Noise) -> V {
    let radius = 100.0;
    let (off, length) = ([0; 2].map(|_| 0.02 * normal(noise)), 1e-3 * normal(noise));
    // Centre, length, scales of X and Y, squareness.
    let mut fit = LinearFit::new(6);
    for known in [[1e3, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1e3, 0.0, 0.0, 0.0, 0.0]] {
        fit.add(&known, 0.0, 1e-5);
    }
    for (k, u) in [(2, 1.0), (3, KNOWN_BAR.scale), (4, KNOWN_BAR.scale), (5, KNOWN_BAR.square[2])] {
        let mut row = [0.0; 6];
        row[k] = 1.0;
        fit.add(&row, 0.0, 1.0 / u);
    }
    for step in 0..72 {
        let (sine, cosine) = (TAU * (f64::from(step) + 0.5) / 72.0).sin_cos();
        let [x, y] = [radius * cosine, radius * sine];
        let to = [centre[0] + x, centre[1] + y, centre[2]];
        let tip = drawn.tip(corrected.corrected(to), [false; 3], [0.0; 3]);
        let scatter = 0.3e-3_f64.hypot(KNOWN_BAR.approach);
        let read = (tip[0] - to[0] - off[0]) * cosine + (tip[1] - to[1] - off[1]) * sine - length;
        let row = [cosine, sine, 1.0, to[0] * cosine, to[1] * sine, -to[1] * cosine];
        fit.add(&row, read + scatter * normal(noise), 1.0 / scatter);
    }
    let found = fit.solve().values;
    [found[3], found[4], found[5]]
}

/// Scales are known better: a bar shows only their difference.
const KNOWN_BAR: Known = Known { scale: 3e-6, ..KNOWN };

#[test]
fn the_foreseen_uncertainty_is_that_after_a_circular_test() {
    let instruments = "[[instrument]]\nkind = \"ballbar\"\nplanes = [\"XY\"]\nat_mm = [0.0, 0.0, -40.0]\n";
    let (_, _, advice) = advised(&KNOWN_BAR, instruments);
    assert_eq!(advice.measurements.len(), 1, "{advice:?}");
    let (steps, _) = plate();
    let values = (0..MACHINES).map(|number| {
        let mut noise = Noise::new(500 + number as u64);
        let drawn = Errors::stated().drawn(&KNOWN_BAR, &mut noise);
        let [x, y, c0y] = circular_test(&drawn, &Errors::stated(), [0.0, 0.0, -40.0], &mut noise);
        let mut corrected = Errors::stated();
        corrected.square[2] += c0y;
        corrected.scale = [x, y, 0.0];
        let places = run(&steps, AT, &corrected, true);
        measure(&cut(&places, AT, &drawn, &approaches(COUNT, &KNOWN_BAR, &mut noise)))
    });
    compare(&advice, &values.collect::<Vec<_>>());
    assert_eq!(TOLERANCES.len(), advice.features.len());
}
