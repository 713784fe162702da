//! Figures that are off by 30 %: the dynamic correction is never worse than none, in the simulator's own programs.

use std::path::Path;
use trueaxis::machine::FrictionSettings;
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Moment, Run, Sample};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// Factors by which the configured friction, gains and pre-sliding are off.
type Off = [f64; 3];

/// Lower than the default: loops have more dead time, and the runs take less.
const RATE_HZ: f64 = 4000.0;

/// The worst of the eight combinations of 30 %, and the opposite of the very worst.
const WRONG: [Off; 4] = [[0.7, 0.7, 0.7], [1.3, 0.7, 0.7], [1.3, 0.7, 1.3], [0.7, 1.3, 1.3]];

/// The sample mill, its drives configured with the simulator's figures, each `off` by a factor.
fn machine([friction, gains, presliding]: Off) -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables/mill-3axis");
    let mut machine = Machine::read(&folder).unwrap();
    for axis in &mut machine.settings.axes {
        let truth = DriveSettings::of(axis.axis);
        let drive = axis.servo.drive.as_mut().expect("drive figures of the sample mill");
        drive.position_gain_per_s = gains * truth.position_gain_per_s;
        drive.velocity_gain_per_s = gains * truth.velocity_gain_per_s;
        axis.servo.friction = Some(FrictionSettings {
            coulomb_per_s: friction * truth.coulomb_mm_per_s2 / truth.velocity_gain_per_s,
            stribeck_share: truth.stribeck_share,
            stribeck_velocity_per_s: truth.stribeck_velocity_mm_per_s,
            presliding: presliding * truth.presliding_mm,
            viscous: friction * truth.viscous_per_s / truth.velocity_gain_per_s,
            lead_s: 0.0,
            adapt: 0.0,
        });
    }
    machine
}

/// Contour error while cutting that is exceeded in one cycle of a thousand, µm.
fn envelope(program: &str, kind: Kind, off: Off) -> f32 {
    let program = Program::parse(program, &text(program), program).unwrap();
    let settings = Settings { rate_hz: RATE_HZ, ..Settings::default() };
    let scenario = Scenario::new(machine(off), program, settings).unwrap();
    let mut run = Run::of(scenario, &[kind]).unwrap();
    let mut errors = Vec::new();
    let mut sink = |moment: &Moment, machines: &[Option<&Sample>]| {
        if let ([Some(sample)], true) = (machines, moment.cutting) {
            errors.push(sample.error_um());
        }
    };
    while run.advance(10_000, &mut sink) {}
    let at = errors.len() - errors.len() / 1000;
    *errors.select_nth_unstable_by(at, f32::total_cmp).1
}

fn text(program: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/trueaxis-sim/programs");
    std::fs::read_to_string(folder.join(program)).unwrap()
}

/// With the true figures the envelope is far smaller than without correction; with wrong figures it is never larger.
fn never_worse(program: &str) {
    let without = envelope(program, Kind::Compensated, [1.0; 3]);
    let full = envelope(program, Kind::Full, [1.0; 3]);
    assert!(full < 0.4 * without, "{program}: {full} µm, without {without} µm");
    for wrong in WRONG {
        let full = envelope(program, Kind::Full, wrong);
        assert!(full < without, "{program} {wrong:?}: {full} µm, without {without} µm");
    }
}

#[test]
fn circle_diamond_square() {
    never_worse("circle-diamond-square.ngc");
}

#[test]
fn butterfly() {
    never_worse("butterfly.ngc");
}

#[test]
fn pocket() {
    never_worse("pocket-3d.ngc");
}
