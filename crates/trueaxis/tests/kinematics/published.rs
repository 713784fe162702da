//! Formulas published for single machines.

use super::*;
use glam::DMat3;
use trueaxis::kinematics::{Choice, Kinematics, Tool};

fn random_angles(random: &mut Noise) -> (f64, f64) {
    (179.0 * random.signed(), 179.0 * random.signed())
}

/// LinuxCNC documentation, "5-Axis Kinematics", table tilting and rotating (xyzac-trt), rotation point at zero: with
/// the offsets Dy, Dz of A from C
///
/// ```text
/// x = cC X + sC cA (Y − Dy) + sC sA (Z − Dz) + sC Dy
/// y = −sC X + cC cA (Y − Dy) + cC sA (Z − Dz) + cC Dy
/// z = −sA (Y − Dy) + cA (Z − Dz) + Dz
/// ```
///
/// There a positive command turns the table by +A, +C.
#[test]
fn linuxcnc_tilting_and_rotating_table() {
    let mut random = Noise::new(11);
    for _ in 0..1000 {
        let (dy, dz) = (60.0 * random.signed(), 60.0 * random.signed());
        let mut machine = machine("w C' A' b X Y Z t");
        of(&mut machine, Axis::A).direction = 1;
        of(&mut machine, Axis::C).direction = 1;
        of(&mut machine, Axis::A).offset_mm = [0.0, dy, dz];
        of(&mut machine, Axis::C).offset_mm = [0.0, -dy, -dz];
        let (a, c) = random_angles(&mut random);
        let [x, y, z, ..] = random_pose(&mut random, 0.0);
        let ((sa, ca), (sc, cc)) = (a.to_radians().sin_cos(), c.to_radians().sin_cos());
        let published = DVec3::new(
            cc * x + sc * ca * (y - dy) + sc * sa * (z - dz) + sc * dy,
            -sc * x + cc * ca * (y - dy) + cc * sa * (z - dz) + cc * dy,
            -sa * (y - dy) + ca * (z - dz) + dz,
        );
        let found = Kinematics::<f64>::new(&machine).unwrap().forward(&[x, y, z, a, 0.0, c]);
        assert!(apart(found.tip, published) < 1e-12);
        // Its tool vector: (sC sA, cC sA, cA).
        assert!(apart(found.axis, DVec3::new(sc * sa, cc * sa, ca)) < 1e-15 * 4.0);
    }
}

/// LinuxCNC, bridge mill with a head B on C (5axiskins), pivot length L:
///
/// ```text
/// x = X + L sin B cos C,   y = Y + L sin B sin C,   z = Z − L cos B + L
/// ```
#[test]
fn linuxcnc_bridge_mill() {
    let mut random = Noise::new(12);
    let mut machine = machine("w b X Y Z C B t");
    let pivot = 250.0;
    of(&mut machine, Axis::B).direction = -1;
    of(&mut machine, Axis::B).offset_mm = [0.0, 0.0, pivot];
    let kinematics = Kinematics::<f64>::new(&machine).unwrap().with_tool_length(pivot);
    for _ in 0..1000 {
        let (b, c) = random_angles(&mut random);
        let [x, y, z, ..] = random_pose(&mut random, 0.0);
        let ((sb, cb), (sc, cc)) = (b.to_radians().sin_cos(), c.to_radians().sin_cos());
        let published = DVec3::new(x + pivot * sb * cc, y + pivot * sb * sc, z - pivot * cb + pivot);
        assert!(apart(kinematics.forward(&[x, y, z, 0.0, b, c]).tip, published) < 1e-12);
    }
}

/// Involute helicoid milled along its normals on a table C and a head A, both turning right-handed:
/// `[X, Y, Z] = Rz(C)(F + w) + L (Rx(A) t0 − t0)`, branch 1: C = −φ, A = γ (vertical) or 90° + γ (horizontal), branch 2:
/// C = 180° − φ, A = −γ or 90° − γ.
#[test]
fn helicoid_on_a_head_table_machine() {
    let (base_radius, lead, pivot, work) = (30.0, 20.0, 180.0, DVec3::new(3.0, -4.0, 50.0));
    let gamma = f64::atan2(lead, base_radius).to_degrees();
    let norm = f64::hypot(lead, base_radius);
    for (t0, upright) in [(DVec3::Z, 0.0), (DVec3::Y, 90.0)] {
        let mut machine = machine("w C' X' b Y Z A t");
        of(&mut machine, Axis::C).direction = 1;
        of(&mut machine, Axis::A).offset_mm = (t0 * pivot).to_array();
        machine.kinematics.tool_axis = t0.to_array();
        let kinematics = Kinematics::<f64>::new(&machine).unwrap().with_tool_length(pivot);
        for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
            let (u, theta) = (0.1 * f64::from(i), 0.15 * f64::from(j) - 1.5);
            let phi = u + theta;
            let (s, c) = phi.sin_cos();
            let surface = DVec3::new(base_radius * (c + u * s), base_radius * (s - u * c), lead * theta);
            let normal = DVec3::new(lead * s, -lead * c, base_radius) / norm;
            let tool = Tool { tip: surface + work, axis: normal };
            let solutions = kinematics.solutions(&tool, &[0.0; AXES]).unwrap();
            for (choice, turn, a) in [(Choice::First, 0.0, upright + gamma), (Choice::Second, 180.0, upright - gamma)] {
                let table = turn - phi.to_degrees();
                let found = solutions.choose(choice).unwrap().axes;
                let place = DMat3::from_rotation_z(table.to_radians()) * (surface + work)
                    + (DMat3::from_rotation_x(a.to_radians()) * t0 - t0) * pivot;
                assert!(apart(DVec3::new(found[0], found[1], found[2]), place) < 1e-11, "{t0} {u} {theta}");
                assert!((found[3] - a).abs() < 1e-11, "{} {a}", found[3]);
                let off = (found[5] - table).rem_euclid(360.0);
                assert!(off.min(360.0 - off) < 1e-11, "{} {table}", found[5]);
            }
        }
    }
}
