use super::*;
use trueaxis::kinematics::{Branch, BranchTracker, Choice, InverseError, Kinematics, Tool};
use trueaxis_testing::share::share;

/// Structural code and tool axis of each kind.
const KINDS: [(&str, [f64; 3]); 12] = [
    ("w X' Y' b Z C A t", [0.0, 0.0, 1.0]),
    ("w b X Y Z C B t", [0.0, 0.0, 1.0]),
    ("w b X Y Z A B t", [0.0, 0.0, 1.0]),
    ("w Y' b X Z A C t", [0.0, 1.0, 0.0]),
    ("w C' X' b Y Z A t", [0.0, 0.0, 1.0]),
    ("w C' X' b Y Z A t", [0.0, 1.0, 0.0]),
    ("w C' Y' b X Z B t", [0.0, 0.0, 1.0]),
    ("w A' X' b Y Z B t", [0.0, 0.0, 1.0]),
    ("w C' A' Y' b X Z t", [0.0, 0.0, 1.0]),
    ("w C' B' X' b Y Z t", [0.0, 0.0, 1.0]),
    ("w C' A' b X Y Z t", [0.0, 0.3, 1.0]),
    ("w B' A' X' b Y Z t", [0.2, -0.1, 1.0]),
];
const POSES: usize = 1_000_000;

struct Worst {
    tip: f64,
    direction: f64,
    rotary: f64,
    linear: f64,
}

/// Inverts the forward transformation of random poses of one kind; errors of the positions are multiplied by
/// sin(margin).
fn round_trip(kind: usize, poses: usize) -> Worst {
    let (chain, tool_axis) = KINDS[kind];
    let mut random = Noise::new(77 + kind as u64);
    let mut worst = Worst { tip: 0.0, direction: 0.0, rotary: 0.0, linear: 0.0 };
    let mut in_cone = 0;
    for _ in 0..poses.div_ceil(1000) {
        let mut machine = machine(chain);
        disturb(&mut random, &mut machine);
        machine.kinematics.tool_axis = tool_axis;
        let kinematics = Kinematics::<f64>::new(&machine).unwrap();
        for _ in 0..poses.min(1000) {
            let mut pose = random_pose(&mut random, 400.0);
            for axis in Axis::ALL.into_iter().filter(|axis| !kinematics.has(*axis)) {
                pose[axis.index()] = 0.0;
            }
            let tool = kinematics.forward(&pose);
            let margin = kinematics.singularity_margin_deg(&pose);
            let solutions = kinematics.solutions(&tool, &pose).unwrap();
            let nearest = solutions.choose(Choice::Nearest).unwrap();
            if nearest.singularity_margin_deg < 0.1 {
                // Covered by tests/kinematics/singular.rs.
                assert!(margin < 0.1001, "{pose:?}");
                in_cone += 1;
                continue;
            }
            assert_eq!(nearest.direction_error_deg, 0.0);
            assert!((nearest.singularity_margin_deg - margin).abs() < 1e-10 / margin.to_radians().sin());
            let sharp = margin.to_radians().sin();
            for (i, (found, true_q)) in nearest.axes.into_iter().zip(pose).enumerate() {
                let error = (found - true_q).abs() * sharp;
                let to = if i < 3 { &mut worst.linear } else { &mut worst.rotary };
                *to = to.max(if i < 3 { error } else { error.to_radians() });
            }
            for solution in [solutions.first.unwrap(), solutions.second.unwrap()] {
                let again = kinematics.forward(&solution.axes);
                worst.tip = worst.tip.max((again.tip - tool.tip).length());
                worst.direction = worst.direction.max((again.axis - tool.axis).length() * sharp);
            }
        }
    }
    assert!(in_cone <= poses / 100, "{chain}");
    worst
}

/// A few poses of each kind, for a quick run.
#[test]
fn inverse_of_forward_over_a_few_poses_of_each_kind() {
    for kind in 0..KINDS.len() {
        let Worst { tip, direction, rotary, linear } = round_trip(kind, 200);
        assert!(tip < 1e-10 && direction < 1e-10 && linear < 1e-10 && rotary < 1e-10, "{}", KINDS[kind].0);
    }
}

#[test]
fn inverse_of_forward_over_many_poses_of_each_kind() {
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let kind = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    let Some((chain, _)) = KINDS.get(kind) else { break };
                    let Worst { tip, direction, rotary, linear } = round_trip(kind, share(POSES));
                    println!("{chain}: tip {tip:.1e} axis {direction:.1e} rotary {rotary:.1e} linear {linear:.1e}");
                    assert!(tip < 1e-10 && direction < 1e-10, "{chain}: {tip:e} mm, {direction:e}");
                    assert!(linear < 1e-10 && rotary < 1e-10, "{chain}: {linear:e} mm, {rotary:e} rad");
                }
            });
        }
    });
}

#[test]
fn single_precision_comes_back() {
    let mut random = Noise::new(5);
    let kinematics = Kinematics::<f32>::new(&machine("w C' A' Y' b X Z t")).unwrap().with_singular_cone_deg(5.0);
    for _ in 0..20_000 {
        let mut pose = random_pose(&mut random, 170.0).map(|q| q as f32);
        pose[4] = 0.0;
        let Ok(found) = kinematics.inverse(&kinematics.forward(&pose), &pose) else {
            assert!(kinematics.singularity_margin_deg(&pose) < 5.001);
            continue;
        };
        for (found, pose) in found.axes.into_iter().zip(pose) {
            assert!((found - pose).abs() < 5e-3, "{found} {pose}");
        }
    }
}

#[test]
fn linear_axes_carried_by_rotary_ones() {
    let kinematics = Kinematics::<f64>::new(&machine("w b X C Y Z A t")).unwrap();
    let pose = [30.0, 40.0, 50.0, 25.0, 0.0, 35.0];
    let found = kinematics.inverse(&kinematics.forward(&pose), &pose).unwrap();
    for (found, pose) in found.axes.into_iter().zip(pose) {
        assert!((found - pose).abs() < 1e-11);
    }
    // With C at 90 degrees Y moves along X.
    let along = kinematics.forward(&[30.0, 40.0, 50.0, 25.0, 0.0, 90.0]);
    assert!(
        matches!(kinematics.inverse(&along, &pose).unwrap_err(), InverseError::LinearAxes { volume } if volume < 1e-9)
    );
}

#[test]
fn turns_are_unwound_towards_the_last_position_within_the_travel() {
    let mut trunnion = machine("w C' A' Y' b X Z t");
    of(&mut trunnion, Axis::A).travel = [-120.0, 30.0];
    let kinematics = Kinematics::<f64>::new(&trunnion).unwrap();
    let tool = kinematics.forward(&[0.0, 0.0, 0.0, -40.0, 0.0, 10.0]);
    let near = |c: f64| [0.0, 0.0, 0.0, -40.0, 0.0, c];
    for (from, to) in [(0.0, 10.0), (355.0, 370.0), (-3500.0, -3590.0), (36_000.0, 36_010.0)] {
        let found = kinematics.inverse(&tool, &near(from)).unwrap();
        assert!((found.axes[5] - to).abs() < 1e-9, "{from}: {}", found.axes[5]);
    }
    // The other branch needs A = +40, beyond the end of the travel.
    let solutions = kinematics.solutions(&tool, &near(190.0)).unwrap();
    let good = solutions.choose(Choice::Nearest).unwrap();
    assert!((good.axes[3] + 40.0).abs() < 1e-9);
    let bad = if good.branch == Branch::First { solutions.second } else { solutions.first };
    let Err(InverseError::OutsideTravel { axis: Axis::A, found, high, .. }) = bad else { panic!("{bad:?}") };
    assert!((found - 40.0).abs() < 1e-9 && high == 30.0);
    of(&mut trunnion, Axis::C).travel = [-180.0, 360.0];
    let kinematics = Kinematics::<f64>::new(&trunnion).unwrap();
    let found = kinematics.inverse(&tool, &near(355.0)).unwrap();
    assert!((found.axes[5] - 10.0).abs() < 1e-9);
    of(&mut trunnion, Axis::C).travel = [20.0, 300.0];
    of(&mut trunnion, Axis::X).travel = [-1.0, 1.0];
    let kinematics = Kinematics::<f64>::new(&trunnion).unwrap();
    let error = kinematics.inverse(&tool, &near(0.0)).unwrap_err();
    assert!(matches!(error, InverseError::OutsideTravel { .. }), "{error}");
    let tool = kinematics.forward(&[1.5, 0.0, 0.0, -40.0, 0.0, 100.0]);
    let error = kinematics.inverse(&tool, &near(100.0)).unwrap_err();
    let InverseError::OutsideTravel { axis: Axis::X, found, low, high } = error else { panic!("{error}") };
    assert!((found - 1.5).abs() < 1e-12 && [low, high] == [-1.0, 1.0]);
}

#[test]
fn at_the_singular_pose_the_table_stays() {
    let kinematics = Kinematics::<f64>::new(&machine("w C' A' Y' b X Z t")).unwrap();
    let up = kinematics.forward(&[1.0, 2.0, 3.0, 0.0, 0.0, 33.0]);
    let near = [0.0, 0.0, 0.0, 0.0, 0.0, 12.0];
    for kinematics in [kinematics, kinematics.with_singular_cone_deg(0.0)] {
        let found = kinematics.inverse(&up, &near).unwrap();
        assert_eq!((found.axes[5], found.singularity_margin_deg, found.direction_error_deg), (12.0, 0.0, 0.0));
        assert!((kinematics.forward(&found.axes).tip - up.tip).length() < 1e-12);
    }
    // Just outside the cone, just inside, at half of it: C deviates by 0, 90 (1 − 0.0999/0.1) 2, 21 degrees.
    for (a, off) in [(0.1001, 0.0), (0.0999, 0.18), (0.05, 21.0), (0.01, 21.0)] {
        let found = kinematics.inverse(&kinematics.forward(&[0.0, 0.0, 0.0, a, 0.0, 33.0]), &near).unwrap();
        assert!((found.singularity_margin_deg - a).abs() < 1e-10);
        assert!((33.0 - found.axes[5] - off).abs() < 1e-4, "{found:?}");
        let left = (a.to_radians().sin() * f64::to_radians(off).sin()).asin().to_degrees();
        assert!((found.direction_error_deg - left).abs() < 1e-8, "{found:?}");
    }
}

#[test]
fn unreachable_directions_are_refused_with_their_angle() {
    let tool = |axis: [f64; 3]| Tool { tip: DVec3::ZERO, axis: DVec3::from_array(axis) };
    let (s, c) = 1f64.to_radians().sin_cos();
    let still = [0.0; AXES];
    let by = |chain: &str, tool_axis: [f64; 3], axis: [f64; 3]| {
        let mut machine = machine(chain);
        machine.kinematics.tool_axis = tool_axis;
        match Kinematics::<f64>::new(&machine).unwrap().inverse(&tool(axis), &still) {
            Err(InverseError::Unreachable { by_deg }) => by_deg,
            other => panic!("{other:?}"),
        }
    };
    let up = [0.0, 0.0, 1.0];
    assert!((by("w X' b Y Z t", up, [s, 0.0, c]) - 1.0).abs() < 1e-12);
    assert!((by("w b X Y Z A t", up, [s, 0.0, c]) - 1.0).abs() < 1e-12);
    assert!((by("w C' X' b Y Z t", up, [s, 0.0, c]) - 1.0).abs() < 1e-12);
    // A carries b = sin 1° of the tool axis, so the tool never comes nearer to C than 1 degree.
    assert!((by("w C' A' b X Y Z t", [s, 0.0, c], up) - 1.0).abs() < 1e-12);
    let one = Kinematics::<f64>::new(&machine("w b X Y Z A t")).unwrap();
    let pose = [1.0, 2.0, 3.0, 77.0, 0.0, 0.0];
    let found = one.solutions(&one.forward(&pose), &pose).unwrap();
    assert!((found.first.unwrap().axes[3] - 77.0).abs() < 1e-11);
    assert_eq!(found.second, Err(InverseError::OneBranch));
    // A table that turns about the direction of the spindle does not change the tool's direction: it stays.
    let table = Kinematics::<f64>::new(&machine("w C' X' b Y Z t")).unwrap();
    let found =
        table.inverse(&table.forward(&[5.0, 6.0, 7.0, 0.0, 0.0, 40.0]), &[0.0, 0.0, 0.0, 0.0, 0.0, 40.0]).unwrap();
    assert!((found.axes[0] - 5.0).abs() < 1e-12 && found.axes[5] == 40.0);
    for bad in [[0.0, 0.0, 1.01], [0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
        assert!(matches!(one.inverse(&tool(bad), &still), Err(InverseError::NotADirection { .. })));
    }
    let not_finite = Tool { tip: DVec3::new(0.0, f64::NAN, 0.0), axis: DVec3::new(0.0, 0.0, 1.0) };
    assert_eq!(one.inverse(&not_finite, &still), Err(InverseError::TipNotFinite));
}

#[test]
fn a_path_is_followed_without_a_jump_or_refused() {
    let kinematics = Kinematics::<f64>::new(&machine("w X' Y' b Z C A t")).unwrap().with_tool_length(200.0);
    let start = [0.0, 0.0, 0.0, 30.0, 0.0, 0.0];
    let first = kinematics.inverse(&kinematics.forward(&start), &start).unwrap();
    let mut follow = BranchTracker::new(&first, 2.0);
    // Two turns: C winds up to 720 degrees, the tip stays.
    let tip = kinematics.forward(&start).tip;
    for i in 1..=720 {
        let axis = kinematics.direction(&[0.0, 0.0, 0.0, 30.0, 0.0, f64::from(i)]);
        let found = follow.next(&kinematics, &Tool { tip, axis }).unwrap();
        assert!((found.axes[5] - f64::from(i)).abs() < 1e-9);
        assert!((kinematics.forward(&found.axes).tip - tip).length() < 1e-11);
        assert_eq!(found.branch, first.branch);
    }
    // Straight through the pole: A continues through zero on the other branch, and back.
    let open = kinematics.with_singular_cone_deg(0.0);
    let tilt = |a: f64| Tool { tip, axis: kinematics.direction(&[0.0, 0.0, 0.0, a, 0.0, 0.0]) };
    for a in (1..=30).rev().chain([-1]) {
        let found = follow.next(&open, &tilt(f64::from(a))).unwrap();
        assert!((found.axes[5] - 720.0).abs() < 1e-9 && (found.axes[3] - f64::from(a)).abs() < 1e-9);
        assert_eq!((found.branch == first.branch, found.direction_error_deg), (a > 0, 0.0));
    }
    follow.next(&open, &tilt(1.0)).unwrap();
    let before = *follow.axes();
    // Not in steps of more than 5 degrees, whatever the limit.
    let mut wide = BranchTracker::new(&open.inverse(&tilt(4.0), &before).unwrap(), 20.0);
    let error = wide.next(&open, &tilt(-4.0)).unwrap_err();
    let InverseError::BranchChange { from, step_deg, .. } = error else { panic!("{error}") };
    assert!(from == first.branch && (step_deg - 180.0).abs() < 1e-9, "{error}");
    let error = follow.next(&open, &tilt(60.0)).unwrap_err();
    let InverseError::TooFast { axis: Axis::A, step_deg, limit_deg } = error else { panic!("{error}") };
    assert!((step_deg - 59.0).abs() < 1e-9 && limit_deg == 2.0);
    assert_eq!(*follow.axes(), before);
}
