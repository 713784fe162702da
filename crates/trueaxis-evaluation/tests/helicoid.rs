//! The tool on a flank and its errors on a machine, compared with other transformations and known errors.

use std::path::Path;
use trueaxis::Axis;
use trueaxis::machine::ErrorModel;
use trueaxis_evaluation::helicoid::{Job, Limits, Passes, Request, adapted, fit, flank};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::machine_files;

fn job(settings: &str) -> Job {
    let text = format!(
        r#"{{"base_radius_mm":36,"lead_parameter_mm_per_rad":130,"u_rad":"0.1:0.7:4","theta_rad":"-0.3:0.4:8"{settings}}}"#
    );
    Job::new(&serde_json::from_str::<Request>(&text).unwrap()).unwrap()
}

const UPRIGHT: &str = r#","form":"vertical","pivot_mm":150"#;

fn machine(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name)).unwrap()
}

const SET_UPS: [&str; 5] = [
    UPRIGHT,
    r#","form":"vertical","pivot_mm":212.5,"direction_a":-1,"work_offset_mm":[3,-4,50]"#,
    r#","pivot_mm":150"#,
    r#","pivot_mm":80,"direction_a":-1,"direction_c":-1,"work_offset_mm":[-10,20,5]"#,
    r#","form":"vertical","pivot_mm":0,"direction_c":-1"#,
];

/// The step's own forward transformation puts the tool where the published formula requires it, in every set-up.
#[test]
fn the_tool_is_on_the_flank_by_another_transformation() {
    for settings in SET_UPS {
        let job = job(settings);
        for (u, theta) in [(0.0, 0.0), (0.1, -0.3), (0.7, 0.4), (0.35, 9.0)] {
            let tool = job.tool(u, theta, &Limits::default()).unwrap();
            for pose in &tool.poses {
                assert!(pose.off_surface_um < 1e-8, "{settings}: {pose:?}");
                assert!(pose.off_normal_urad < 1e-8, "{settings}: {pose:?}");
            }
            // γ = atan(p/r_b) on both branches, over the whole flank.
            let tilt = 130f64.atan2(36.0).to_degrees();
            assert!((tool.singular.margin_deg - tilt).abs() < 1e-9 && !tool.singular.near, "{settings}");
        }
    }
}

#[test]
fn a_line_has_the_displacements_of_the_grid_on_both_branches() {
    for branch in [1, 2] {
        let job = job(&format!(r#"{UPRIGHT},"branch":{branch}"#));
        let points = job.points().unwrap();
        let curve = job.curve(Passes::Theta, 0.1, 8).unwrap();
        let column = |i: usize| &curve[8 * i..8 * (i + 1)];
        for (i, point) in points[..8].iter().enumerate() {
            let own = 1 + 5 * (branch - 1);
            let found = [0, own, own + 1, own + 2, own + 3, own + 4].map(|k| column(k)[i]);
            assert_eq!(found, [point.theta_rad, point.x_mm, point.y_mm, point.z_mm, point.a_deg, point.c_deg]);
        }
        assert!(job.curve(Passes::U, 0.0, 0).unwrap_err().to_string().contains("needed 1 to 10000"));
    }
}

#[test]
fn travel_is_that_of_the_points_and_counts_those_beyond() {
    let job = job(UPRIGHT);
    let points = job.points().unwrap();
    let median = 0.5 * (points[11].c_deg + points[12].c_deg);
    let limits = Limits { c: Some([median, 1e3]), y: Some([-1e3, -155.0]), ..Limits::default() };
    let [first, second] = job.reach(&limits).unwrap();
    let low = points.iter().map(|point| point.c_deg).fold(f64::INFINITY, f64::min);
    assert_eq!((first.axes[4].low, first.axes[4].axis, first.axes[4].unit), (low, 'C', "degrees"));
    assert_eq!(first.axes[4].beyond, points.iter().filter(|point| point.c_deg < median).count());
    assert_eq!(first.axes[1].beyond, points.iter().filter(|point| point.y_mm > -155.0).count());
    let either = points.iter().filter(|point| point.c_deg < median || point.y_mm > -155.0).count();
    assert!(first.beyond == either && either > 0 && either < points.len());
    // Branch 2 is half a turn further, with the head on the other side.
    assert!((second.axes[4].low - first.axes[4].low - 180.0).abs() < 1e-9 && second.axes[1].low > 0.0);
    let turned = Limits { a: Some([5.0, -5.0]), ..Limits::default() };
    assert_eq!(job.reach(&turned).unwrap_err().to_string(), "travel of A: found 5 to -5, needed the low end first");
}

#[test]
fn a_machine_fits_or_says_what_differs() {
    let turn = machine("mill-turn").settings;
    assert!(fit(&job(UPRIGHT), &turn).fits);
    for (settings, said) in [
        (r#","form":"vertical","pivot_mm":180"#, "pivot length: found 150 mm, needed 180 mm"),
        (r#","form":"vertical","pivot_mm":150,"direction_a":-1"#, "direction of A: found 1, needed -1"),
        (r#","form":"vertical","pivot_mm":150,"direction_c":-1"#, "direction of C: found 1, needed -1"),
        (r#","pivot_mm":150"#, "at A = 0: found the tool along [0, 0, 1], needed [0, 1, 0] (horizontal)"),
    ] {
        let found = fit(&job(settings), &turn);
        assert_eq!((found.fits, found.reasons), (false, vec![said.to_owned()]), "{settings}");
    }
    for (name, said, travels) in [
        ("mill-3axis", "found the axes X, Y, Z, needed X, Y, Z, A and C", false),
        ("head-5axis", "found C on the tool's side, needed a table C that turns the workpiece", true),
        ("mill-5axis", "found A on the workpiece's side, needed a head A that turns the tool", true),
    ] {
        let found = fit(&job(UPRIGHT), &machine(name).settings);
        assert_eq!((found.reasons, found.travel.is_some()), (vec![said.to_owned()], travels), "{name}");
    }
}

/// The sample adapted to any set-up fits it, reads back from its files, and has the same errors in the same pose.
#[test]
fn the_sample_is_made_into_any_set_up() {
    for settings in SET_UPS {
        let job = job(settings);
        let made = adapted(&job, machine("mill-turn")).unwrap();
        let files = Memory::new(machine_files(&made, "made"));
        let read = Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap();
        assert!(fit(&job, &read.settings).fits, "{settings}: {:?}", fit(&job, &read.settings).reasons);
        let found = flank(&job, &read, Passes::Theta, 0.3, 5).unwrap();
        assert!(
            found.fit.fits && found.before.largest[0] > 5.0 && found.after.largest[0] < 0.1,
            "{settings}: {found:?}"
        );
    }
    // Horizontal is the same machine with the head turned by 90 degrees: with perfect slides, the same joints are in the same
    // places and have the same errors.
    let mut sample = machine("mill-turn");
    let location = &mut sample.settings.location;
    (location.a0z, location.b0z, location.c0y) = (0.0, 0.0, 0.0);
    for (own, table) in sample.settings.axes.iter_mut().zip(&mut sample.tables) {
        if !own.axis.is_rotary() {
            (own.backlash, *table) = (0.0, None);
        }
    }
    let [upright, turned] = [job(UPRIGHT), job(r#","pivot_mm":150"#)];
    let [straight, found] = [&upright, &turned]
        .map(|job| flank(job, &adapted(job, sample.clone()).unwrap(), Passes::Theta, 0.3, 5).unwrap().before);
    for (one, other) in straight.tip_um.iter().zip(&found.tip_um) {
        assert!((one - other).abs() < 1e-6 && *one > 1.0, "{found:?} {straight:?}");
    }
    let error = adapted(&turned, machine("mill-5axis")).unwrap_err().to_string();
    assert!(error.contains("needed w C' b X Y Z A t"), "{error}");
}

/// Only X has an error, 10 µm everywhere: the tip is 10 µm off in X of the bed, which the table has turned by C.
#[test]
fn a_known_error_is_found_on_the_flank_and_taken_away() {
    let job = job(UPRIGHT);
    let mut machine = machine("mill-turn");
    machine.settings.location = Default::default();
    machine.settings.compensation.model = ErrorModel::Volumetric;
    for (own, table) in machine.settings.axes.iter_mut().zip(&mut machine.tables) {
        own.backlash = 0.0;
        for row in table.iter_mut().flat_map(|table| &mut table.rows) {
            let constant = if own.axis == Axis::X { [0.01, 0.0, 0.0, 0.0, 0.0, 0.0] } else { [0.0; 6] };
            (row.forward, row.reverse) = (constant, constant);
        }
    }
    let found = flank(&job, &machine, Passes::Theta, 0.3, 9).unwrap();
    for (i, theta) in found.parameter_rad.iter().enumerate() {
        assert!((found.before.tip_um[i] - 10.0).abs() < 1e-9);
        // In the bed the normal is [0, −sin γ, cos γ]: X is perpendicular to it.
        assert!(found.before.normal_um[i].abs() < 1e-9 && found.before.direction_urad[i] < 1e-7, "{theta}");
        assert!(found.after.tip_um[i] < 1e-3);
    }
    // An equal error along Y of the bed has the component −sin γ along the normal.
    for (own, table) in machine.settings.axes.iter().zip(&mut machine.tables) {
        for row in table.iter_mut().flat_map(|table| &mut table.rows) {
            let constant = if own.axis == Axis::Y { [0.0, 0.01, 0.0, 0.0, 0.0, 0.0] } else { [0.0; 6] };
            (row.forward, row.reverse) = (constant, constant);
        }
    }
    let found = flank(&job, &machine, Passes::U, 0.1, 9).unwrap();
    let sine = 130.0 / 130f64.hypot(36.0);
    assert!(found.before.normal_um.iter().all(|value| (value + 10.0 * sine).abs() < 1e-9), "{:?}", found.before);
    assert!(found.after.largest[0] < 1e-3);
}

/// A trunnion reaches the same poses at different positions; a machine of three axes cannot.
#[test]
fn other_machines_take_the_poses_by_their_own_transformation() {
    let raised = r#","form":"vertical","pivot_mm":150,"work_offset_mm":[0,0,20]"#;
    // The trunnion turns from -120 to 30 degrees: branch 1 would need γ = 74.5.
    let error = flank(&job(raised), &machine("mill-5axis"), Passes::Theta, 0.3, 21).unwrap_err().to_string();
    assert!(error.contains("axis A: found 74.5") && error.contains("-120 to 30"), "{error}");
    let job = job(&format!(r#"{raised},"branch":2"#));
    let found = flank(&job, &machine("mill-5axis"), Passes::Theta, 0.3, 21).unwrap();
    assert!(!found.fit.fits && found.before.largest[0] > 1.0 && found.after.largest[0] < 0.1 * found.before.largest[0]);
    let error = flank(&job, &machine("mill-3axis"), Passes::Theta, 0.3, 21).unwrap_err().to_string();
    assert!(error.starts_with("mill-3axis at u = 0.3 rad") && error.contains("beyond reach"), "{error}");
}
