//! Edge cases: a tool axis that hardly turns, ends of the travel, tied branches, and slides beyond rotary axes.

use super::*;
use trueaxis::kinematics::{Branch, BranchTracker, Choice, InverseError, Kinematics, Solution, Solutions, Tool};

const SLIDES_BEYOND_ROTARY_AXES: [&str; 5] =
    ["w b A X Y Z C t", "w b C A X Y Z t", "w b X C Y A Z t", "w Z' C' Y' b X A t", "w X' C' A' b Z Y t"];

#[test]
fn slides_beyond_rotary_axes_come_back() {
    for (seed, chain) in SLIDES_BEYOND_ROTARY_AXES.into_iter().enumerate() {
        let mut random = Noise::new(300 + seed as u64);
        let mut machine = machine(chain);
        disturb(&mut random, &mut machine);
        machine.kinematics.tool_axis = [0.3, 0.2, 1.0];
        let (kinematics, mut found) = (Kinematics::<f64>::new(&machine).unwrap(), 0);
        for _ in 0..300 {
            let mut pose = random_pose(&mut random, 170.0);
            pose[4] = 0.0;
            let tool = kinematics.forward(&pose);
            let (tip, axis) = by_transforms(&machine, &pose, machine.tool_mm);
            assert!(apart(tool.tip, tip) < 1e-10 && apart(tool.axis, axis) < 1e-12, "{chain}");
            let Ok(again) = kinematics.inverse(&tool, &pose) else { continue };
            found += 1;
            // The inverse takes the other branch if the slides hardly span space on this one.
            let back = kinematics.forward(&again.axes);
            let sharp = again.singularity_margin_deg.to_radians().sin();
            assert!((back.tip - tool.tip).length() * sharp < 1e-8, "{chain} {pose:?} {again:?}");
            assert!((back.axis - tool.axis).length() * sharp < 1e-10, "{chain} {pose:?} {again:?}");
        }
        assert!(found > 200, "{chain}: {found}");
    }
}

/// A tool axis 1e-10 rad off the axis that turns it still determines that axis' position: it does not count as
/// parallel.
#[test]
fn a_tool_axis_nearly_parallel_to_a_rotary_axis_is_followed() {
    for (off_axis, tolerance) in
        [([-1e-10, -3e-10], 1e-4), ([-3e-10, -1e-10], 1e-4), ([-0.2, -0.5], 1e-10), ([0.4, -0.1], 1e-10)]
    {
        for (chain, of) in [("w b X Y Z A t", 3), ("w B' b X Y Z t", 4), ("w C' X' b Y Z t", 5)] {
            let mut tool_axis = [0.0; 3];
            (tool_axis[(of - 2) % 3], tool_axis[(of - 1) % 3]) = (off_axis[0], off_axis[1]);
            tool_axis[of - 3] = 1.0;
            let mut machine = machine(chain);
            machine.kinematics.tool_axis = tool_axis;
            let kinematics = Kinematics::<f64>::new(&machine).unwrap();
            let mut pose = [0.0; AXES];
            pose[of] = 37.0;
            let found = kinematics.inverse(&kinematics.forward(&pose), &[0.0; AXES]).unwrap();
            assert!((found.axes[of] - 37.0).abs() < tolerance, "{chain} {off_axis:?}: {}", found.axes[of]);
        }
    }
    let open = Kinematics::<f64>::new(&machine("w C' A' Y' b X Z t")).unwrap().with_singular_cone_deg(0.0);
    let across = 1e-10 * DVec3::new(0.6, 0.8, 0.0);
    let tool = Tool { tip: DVec3::ZERO, axis: across + DVec3::Z };
    let found = open.inverse(&tool, &[0.0; AXES]).unwrap();
    assert!((open.forward(&found.axes).axis - tool.axis).length() < 1e-13, "{found:?}");
    assert!(found.axes[5].abs() > 1.0);
}

/// The second rotary axis carries a component of the tool axis: the tool stays off the first axis by asin of that
/// component.
#[test]
fn a_tool_axis_along_the_second_rotary_axis_keeps_off_the_first() {
    let mut machine = machine("w B' A' X' b Y Z t");
    let axis = DVec3::new(0.3, -0.1, 0.9).normalize();
    machine.kinematics.tool_axis = axis.to_array();
    let kinematics = Kinematics::<f64>::new(&machine).unwrap();
    let off = axis.x.asin().to_degrees();
    for (tilt, sign) in [(0.0_f64, 1.0), (5.0, 1.0), (5.0, -1.0), (12.0, 1.0), (17.0, -1.0)] {
        let (s, c) = tilt.to_radians().sin_cos();
        let tool = Tool { tip: DVec3::ZERO, axis: DVec3::new(0.6 * s, sign * c, 0.8 * s) };
        let error = kinematics.inverse(&tool, &[0.0; AXES]).unwrap_err();
        let InverseError::Unreachable { by_deg } = error else { panic!("{error}") };
        assert!((by_deg - (off - tilt)).abs() < 1e-10, "{tilt} {sign}: {by_deg}");
    }
}

/// A position beyond an end of the travel by rounding only counts as at the end; among several turns the nearest
/// counts.
#[test]
fn ends_of_the_travel_belong_to_it_whatever_rounding_says() {
    let mut random = Noise::new(310);
    for _ in 0..400 {
        let angle = 170.0 * random.signed();
        let turns = f64::from(random.below(5) as u32) - 2.0;
        let at_end = angle + 360.0 * turns;
        for high in [true, false] {
            let mut table = machine("w C' A' Y' b X Z t");
            // Wide enough for other turns.
            of(&mut table, Axis::C).travel = if high { [at_end - 1000.0, at_end] } else { [at_end, at_end + 1000.0] };
            let kinematics = Kinematics::<f64>::new(&table).unwrap();
            let axis = kinematics.direction(&[0.0, 0.0, 0.0, -40.0, 0.0, angle]);
            let tool = Tool { tip: DVec3::ZERO, axis };
            for beyond in [0.0, 360.0, 720.0] {
                let near = at_end + if high { beyond } else { -beyond };
                let solutions = kinematics.solutions(&tool, &[0.0, 0.0, 0.0, -40.0, 0.0, near]).unwrap();
                let found = [solutions.first, solutions.second]
                    .into_iter()
                    .find_map(|found| found.ok().filter(|found| (found.axes[3] + 40.0).abs() < 1e-6))
                    .unwrap_or_else(|| panic!("{angle} {turns} {high}: {solutions:?}"));
                assert!((found.axes[5] - at_end).abs() < 1e-9, "{at_end} {beyond} {high}: {}", found.axes[5]);
            }
            // Less than a turn beyond the end: the next turn inside, not the last.
            let near = if high { at_end + 310.0 } else { at_end - 310.0 };
            let axis = kinematics.direction(&[0.0, 0.0, 0.0, -40.0, 0.0, near]);
            let found =
                kinematics.inverse(&Tool { tip: DVec3::ZERO, axis }, &[0.0, 0.0, 0.0, -40.0, 0.0, near]).unwrap();
            let next = if high { near - 360.0 } else { near + 360.0 };
            assert!((found.axes[3] + 40.0).abs() > 1.0 || (found.axes[5] - next).abs() < 1e-9, "{found:?} {next}");
        }
    }
}

#[test]
fn of_two_equal_steps_branch_1_is_taken() {
    let of = |branch, step_deg| Solution {
        axes: [0.0; AXES],
        branch,
        singularity_margin_deg: 30.0,
        direction_error_deg: 0.0,
        step_deg,
    };
    for (second, chosen) in [(10.0, Branch::First), (10.1, Branch::First), (9.9, Branch::Second)] {
        let both = Solutions { first: Ok(of(Branch::First, 10.0)), second: Ok(of(Branch::Second, second)) };
        assert_eq!(both.choose(Choice::Nearest).unwrap().branch, chosen);
    }
}

#[test]
fn a_path_out_of_the_travel_says_that_the_other_branch_is_left() {
    let mut head = machine("w X' Y' b Z C A t");
    of(&mut head, Axis::A).travel = [-100.0, 30.0];
    let kinematics = Kinematics::<f64>::new(&head).unwrap();
    let start = [0.0, 0.0, 0.0, 29.5, 0.0, 0.0];
    let first = kinematics.inverse(&kinematics.forward(&start), &start).unwrap();
    let mut follow = BranchTracker::new(&first, 2.0);
    let axis = kinematics.direction(&[0.0, 0.0, 0.0, 31.0, 0.0, 0.0]);
    let error = follow.next(&kinematics, &Tool { tip: DVec3::ZERO, axis }).unwrap_err();
    assert_eq!(error, InverseError::BranchChange { from: first.branch, step_deg: f64::INFINITY, limit_deg: 2.0 });
    assert_eq!(*follow.axes(), first.axes);
    // No turn of C and no other branch fits: the error names the travel itself.
    of(&mut head, Axis::C).travel = [-10.0, 10.0];
    let narrow = Kinematics::<f64>::new(&head).unwrap();
    let error = follow.next(&narrow, &Tool { tip: DVec3::ZERO, axis }).unwrap_err();
    assert!(matches!(error, InverseError::OutsideTravel { axis: Axis::A, .. }), "{error}");
    let text = error.to_string();
    assert!(text.starts_with("axis A: found 3") && text.ends_with("needed the travel, -100 to 30"), "{text}");
}

#[test]
fn another_tool_moves_the_tip_by_what_it_is_longer() {
    let kinematics = Kinematics::<f64>::new(&machine("w X' Y' b Z C A t")).unwrap();
    let pose = [10.0, 20.0, 30.0, 90.0, 0.0, 0.0];
    let [short, long] = [[1.0, 2.0, -80.0], [1.0, 2.0, -120.0]].map(|tool| {
        let with = kinematics.with_tool(DVec3::from_array(tool));
        assert_eq!(with.tool_mm().to_array(), tool);
        with.forward(&pose).tip
    });
    // A at 90 degrees turns −Z to +Y.
    assert!((long - short - DVec3::new(0.0, 40.0, 0.0)).length() < 1e-12, "{short} {long}");
}
