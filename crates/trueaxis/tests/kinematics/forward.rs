use super::*;
use trueaxis::error::Field;
use trueaxis::kinematics::Kinematics;

const CHAINS: [&str; 16] = [
    "w X' Y' b Z C A t",
    "w b X Y Z C B t",
    "w b Z Y X A C t",
    "w Y' b X Z B A t",
    "w C' X' b Y Z A t",
    "w C' Y' b X Z B t",
    "w A' X' b Y Z B t",
    "w C' A' Y' b X Z t",
    "w C' B' X' b Y Z t",
    "w C' A' b X Y Z t",
    "w A' B' b X Y Z t",
    "w X' C' Y' b A Z t",
    "w X' A' Y' b Z C t",
    "w B' X' b Y Z t",
    "w b X Y Z t",
    "w X' Y' Z' b t",
];

#[test]
fn agrees_with_products_of_homogeneous_transforms() {
    let mut random = Noise::new(1);
    let mut worst = 0.0_f64;
    for chain in CHAINS {
        for _ in 0..300 {
            let mut machine = machine(chain);
            disturb(&mut random, &mut machine);
            machine.kinematics.tool_axis = [random.signed(), random.signed(), 1.2 + random.signed()];
            let kinematics = Kinematics::<f64>::new(&machine).unwrap();
            let pose = random_pose(&mut random, 400.0);
            let (tip, axis) = by_transforms(&machine, &pose, machine.tool_mm);
            let found = kinematics.forward(&pose);
            assert!(apart(found.axis, axis) < 1e-14, "{chain} {pose:?}");
            assert_eq!(kinematics.direction(&pose), found.axis);
            worst = worst.max(apart(found.tip, tip));
        }
    }
    assert!(worst < 2e-12, "{worst:e}");
}

#[test]
fn single_precision_keeps_its_digits() {
    let mut random = Noise::new(2);
    for chain in CHAINS {
        let mut machine = machine(chain);
        disturb(&mut random, &mut machine);
        machine.kinematics.tool_axis = [0.0, 0.6, 0.8];
        let (fine, coarse) = (Kinematics::<f64>::new(&machine).unwrap(), Kinematics::<f32>::new(&machine).unwrap());
        for _ in 0..100 {
            let pose = random_pose(&mut random, 180.0).map(|q| q as f32);
            let (exact, found) = (fine.forward(&pose.map(f64::from)), coarse.forward(&pose));
            let wide = |v: glam::Vec3| v.as_dvec3();
            assert!((wide(found.tip) - exact.tip).length() < 1e-3, "{chain} {pose:?}");
            assert!((wide(found.axis) - exact.axis).length() < 5e-7, "{chain} {pose:?}");
        }
    }
}

#[test]
fn bed_directions_turn_with_the_workpiece() {
    // Table turned by +90 degrees, seen from above clockwise on the default side: the bed's x is the table's …
    let kinematics = Kinematics::<f64>::new(&machine("w C' X' b Y Z A t")).unwrap();
    let turned = kinematics.to_workpiece(&[0.0, 0.0, 0.0, 55.0, 0.0, 90.0], DVec3::new(1.0, 0.0, 0.0));
    assert_eq!(turned, DVec3::new(0.0, 1.0, 0.0));
    // … and a head does not turn them.
    let kinematics = Kinematics::<f64>::new(&machine("w X' Y' b Z C A t")).unwrap();
    let v = DVec3::new(0.1, 0.2, 0.3);
    assert_eq!(kinematics.to_workpiece(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], v), v);
}

#[test]
fn a_longer_tool_reaches_further_along_its_axis() {
    let kinematics = Kinematics::<f64>::new(&machine("w X' Y' b Z C A t")).unwrap();
    let pose = [10.0, 20.0, 30.0, 40.0, 0.0, 50.0];
    let (short, long) = (kinematics.with_tool_length(100.0), kinematics.with_tool_length(130.0));
    let (short, long) = (short.forward(&pose), long.forward(&pose));
    assert!((short.tip - long.tip - short.axis * 30.0).length() < 1e-12);
}

#[test]
fn machines_that_it_cannot_transform_are_refused() {
    let refused = |machine: &MachineSettings| Kinematics::<f64>::new(machine).unwrap_err();
    let error = refused(&machine("w X' b Z C A t"));
    assert_eq!((error.field, error.found), (Field::Chain, 2.0));
    let error = refused(&machine("w C' B' X' b Y Z A t"));
    assert_eq!((error.field, error.axis), (Field::Chain, Some(Axis::A)));
    // C next to a spindle along z does not turn it.
    let error = refused(&machine("w A' X' b Y Z C t"));
    assert_eq!((error.field, error.axis), (Field::ToolAxis, Some(Axis::C)));
    let mut twice = machine("w X' b Y Z t");
    twice.chain = heapless::String::try_from("w X' b Y Z Y t").unwrap();
    assert_eq!(refused(&twice).field, Field::Chain);
    twice.chain = heapless::String::try_from("w C' X' b Y Z t").unwrap();
    assert_eq!(refused(&twice).axis, Some(Axis::C));
    let mut odd = machine("w X' b Y Z t");
    odd.kinematics.tool_axis = [f64::NAN, 0.0, 1.0];
    assert_eq!(refused(&odd).field, Field::ToolAxis);
    odd.kinematics.tool_axis = [0.0; 3];
    assert_eq!(refused(&odd).field, Field::ToolAxis);
    let mut odd = machine("w X' b Y Z t");
    of(&mut odd, Axis::Y).offset_mm[1] = f64::INFINITY;
    assert_eq!(refused(&odd).axis, Some(Axis::Y));
}
