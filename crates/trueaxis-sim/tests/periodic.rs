//! A screw whose error repeats every turn, corrected at speed.

use std::path::Path;
use trueaxis::machine::{Axis, PeriodicSettings};
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Moment, Run, Sample};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// At 45 degrees, X moves at 6 m/min.
const DIAGONAL: &str = "G21 G90\nG0 X-100 Y-100\nG1 X100 Y100 F8485.3\n";

/// The sample mill whose only error is that of its X screw.
fn screw(amplitude_um: f64) -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
    let mut machine = Machine::read(&folder).unwrap();
    machine.tables.iter_mut().for_each(|table| *table = None);
    machine.settings.location = Default::default();
    machine.settings.axes.iter_mut().for_each(|axis| axis.backlash = 0.0);
    let first = [0.6e-3 * amplitude_um, 0.8e-3 * amplitude_um];
    let harmonics = [first, [0.0, 0.3e-3 * amplitude_um]].into_iter().collect();
    let screw = PeriodicSettings { axis: Axis::X, period: 5.0, harmonics, reverse: Default::default() };
    machine.settings.periodic.push(screw).unwrap();
    machine
}

#[test]
fn of_a_screw_of_3_um_at_most_5_percent_are_left_at_10_khz_and_6_m_per_min() {
    let program = Program::parse("diagonal", DIAGONAL, "diagonal.ngc").unwrap();
    let settings = Settings { rate_hz: 10_000.0, ..Settings::default() };
    let scenario = Scenario::new(screw(3.0), program, settings).unwrap();
    let mut run = Run::of(scenario, &Kind::BASIC).unwrap();
    // Squares of the contour error that the screw causes beyond the servo's, without and with its correction.
    let (mut squares, mut cycles) = ([0.0; 2], 0);
    let mut sink = |moment: &Moment, machines: &[Option<&Sample>]| {
        let [Some(without), Some(with), Some(servo)] = machines else { panic!("three machines") };
        let [x, y, _] = moment.nominal_mm;
        // In steady motion.
        if moment.cutting && (x - y).abs() < 1e-6 && x.abs() < 80.0 {
            cycles += 1;
            for (sum, machine) in squares.iter_mut().zip([without, with]) {
                let off: f64 = (0..3).map(|i| f64::from(machine.deviation_um[i] - servo.deviation_um[i]).powi(2)).sum();
                *sum += off;
            }
        }
    };
    while run.advance(u64::MAX, &mut sink) {}
    let [without, with] = squares.map(|sum| (sum / f64::from(cycles)).sqrt());
    // Half of the screw's error is across the path: 3 um, and 0.9 um of the second harmonic, by a root of four.
    let expected = 3.0 * (1.0_f64 + 0.09).sqrt() / 2.0;
    assert!((without - expected).abs() < 0.02 * expected, "{without} um, needed {expected} um");
    assert!(with <= 0.05 * without, "{with} um of {without} um are left");
}
