use super::sample::{machine, set_constant, set_table, slot};
use super::*;
use crate::Table;
use trueaxis::machine::{Axis, Interpolation, Row, Twist};
use trueaxis_testing::noise::Noise;

const FORWARD: [f64; AXES] = [0.0; AXES];

fn tip(machine: &Machine, position: &[f64]) -> [f64; 3] {
    let mut all = [0.0; AXES];
    all[..position.len()].copy_from_slice(position);
    Geometry::new(machine, 0.0).unwrap().tip_error(&all, &FORWARD)
}

#[track_caller]
fn assert_near(found: [f64; 3], wanted: [f64; 3], tolerance: f64) {
    for i in 0..3 {
        assert!((found[i] - wanted[i]).abs() <= tolerance, "found {found:?}, wanted {wanted:?}");
    }
}

#[test]
fn squareness_tilts_the_direction_of_travel_whichever_side_moves() {
    for chain in ["w X' b Y Z t", "w Y' X' b Z t", "wX'Y'Z'bt", "w b X Y Z t"] {
        let mut m = machine(chain);
        m.settings.location.c0y = 20e-6;
        assert_near(tip(&m, &[50.0, 300.0, -200.0]), [-6e-3, 0.0, 0.0], 1e-12);
        m.settings.location.b0z = 10e-6;
        m.settings.location.a0z = -30e-6;
        assert_near(tip(&m, &[50.0, 300.0, -200.0]), [-6e-3 - 2e-3, -6e-3, 0.0], 1e-12);
    }
}

#[test]
fn roll_of_a_tool_side_axis_turns_the_lever_from_its_carriage_to_the_tip() {
    let w: f64 = 20e-6;
    let mut m = machine("w Y' b X Z t");
    set_constant(&mut m, Axis::X, [0.0, 0.0, 0.0, w, 0.0, 0.0]);
    m.settings.tool_mm = [0.0, 0.0, -100.0];
    // Lever: Z travel and tool, but not Y, which is on the other side of the bed.
    let z = 300.0 - 100.0;
    assert_near(tip(&m, &[150.0, 250.0, 300.0]), [0.0, -w.sin() * z, (w.cos() - 1.0) * z], 1e-12);
}

#[test]
fn a_workpiece_carriage_moves_and_errs_the_other_way_round() {
    // A positioning error has the same effect on either side.
    for chain in ["w X' b Y Z t", "w Y' Z' b X t"] {
        let mut m = machine(chain);
        set_constant(&mut m, Axis::X, [5e-3, 1e-3, -2e-3, 0.0, 0.0, 0.0]);
        assert_near(tip(&m, &[100.0, 200.0, 300.0]), [5e-3, 1e-3, -2e-3], 1e-12);
    }
    // The yaw acts on the whole distance from workpiece carriage to tip, p_w = R(w) ((x, y, z) + e); its effect along the line
    // of the measurement, w × (x, 0, 0), is already in the table's straightness: e = (0, −w x, 0).
    let w: f64 = 50e-6;
    let mut m = machine("w X' b Y Z t");
    set_constant(&mut m, Axis::X, [0.0, 0.0, 0.0, 0.0, 0.0, w]);
    // A line through Y 0, Z 0; the position of X on it does not matter.
    m.settings.axes[0].measured_at_mm = [1.0, 0.0, 0.0];
    let (x, y, z) = (100.0, 200.0, 300.0);
    let reach = y - w * x;
    let turned = [w.cos() * x - w.sin() * reach - x, w.sin() * x + w.cos() * reach - y, 0.0];
    assert_near(tip(&m, &[x, y, z]), turned, 1e-12);
    // On the tool side only the axes between it and the tool count.
    let mut m = machine("w X' b Y Z t");
    set_constant(&mut m, Axis::Y, [0.0, 0.0, 0.0, w, 0.0, 0.0]);
    assert_near(tip(&m, &[x, y, z]), [0.0, -w.sin() * z, (w.cos() - 1.0) * z], 1e-12);
}

#[test]
fn errors_of_a_rotary_table_stay_in_its_carriers_directions() {
    for angle in [0.0, 30.0, 90.0, -200.0] {
        let mut m = machine("w C' X' Y' b Z t");
        set_constant(&mut m, Axis::C, [5e-3, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_near(tip(&m, &[120.0, 80.0, 0.0, angle]), [5e-3, 0.0, 0.0], 1e-12);

        let mut m = machine("w C' X' Y' b Z t");
        m.settings.location.rotary[2] = [5e-3, -4e-3, 0.0, 0.0, 0.0, 0.0];
        assert_near(tip(&m, &[120.0, 80.0, 0.0, angle]), [5e-3, -4e-3, 0.0], 1e-12);

        // ECC turns the tip about the table's centre, with the tip at (x, y) from it.
        let w: f64 = 40e-6;
        let mut m = machine("w C' X' Y' b Z t");
        set_constant(&mut m, Axis::C, [0.0, 0.0, 0.0, 0.0, 0.0, w]);
        let (x, y) = (120.0, 80.0);
        let turned = [w.cos() * x - w.sin() * y - x, w.sin() * x + w.cos() * y - y, 0.0];
        assert_near(tip(&m, &[x, y, 0.0, angle]), turned, 1e-12);
    }
}

#[test]
fn a_swivelling_head_carries_the_tool_before_the_error_of_c_turns_it() {
    let w: f64 = 30e-6;
    let mut m = machine("w X' Y' b Z C A t");
    m.settings.tool_mm = [0.0, 0.0, -200.0];
    set_constant(&mut m, Axis::C, [0.0, 0.0, 0.0, 0.0, 0.0, w]);
    // A = 90° turns the tool along −y of the tip: R_x(90°) (0, 0, −200) = (0, 200, 0).
    assert_near(tip(&m, &[10.0, 20.0, 30.0, 90.0, 0.0]), [-w.sin() * 200.0, (w.cos() - 1.0) * 200.0, 0.0], 1e-11);
    let error = Geometry::new(&m, 0.0).unwrap().pose_error(&[10.0, 20.0, 30.0, 90.0, 0.0, 0.0], &FORWARD);
    // Tool direction R_x(90°) z = −y, turned by w about z: + sin w x.
    assert_near(error.direction, [w.sin(), 1.0 - w.cos(), 0.0], 1e-12);
}

#[test]
fn direction_sets_the_sense_of_a_rotary_axis() {
    let mut m = machine("w C' X' Y' b Z t");
    let at = [70.0, 0.0, 5.0, 90.0, 0.0, 0.0];
    // Default: the table turns by −90°, so the tip moves by +90° relative to it.
    assert_near(Geometry::new(&m, 0.0).unwrap().ideal_pose(&at).tip_mm, [0.0, 70.0, 5.0], 1e-12);
    let c = slot(&m, Axis::C);
    m.settings.axes[c].direction = 1;
    assert_near(Geometry::new(&m, 0.0).unwrap().ideal_pose(&at).tip_mm, [0.0, -70.0, 5.0], 1e-12);
}

#[test]
fn a_table_reads_itself_along_the_line_of_its_measurement() {
    let errors = [3e-3, -2e-3, 4e-3, 20e-6, -35e-6, 25e-6];
    let at = [150.0, -80.0, 220.0];
    for chain in ["w X' b Y Z t", "w Y' X' b Z t", "w b Z Y X t", "w C' A' X' b Y Z t", "w X' Y' b Z C A t"] {
        for axis in Axis::ALL.into_iter().filter(|axis| chain.contains(axis.letter())) {
            let mut m = machine(chain);
            set_constant(&mut m, axis, errors);
            let i = slot(&m, axis);
            m.settings.axes[i].measured_at_mm = at;
            let mut position = at;
            if !axis.is_rotary() {
                position[i] = 333.0;
            }
            // The rest is second order: |w|² · lever / 2 = 1e-6.
            assert_near(tip(&m, &position), [errors[0], errors[1], errors[2]], 2e-6);
        }
    }
    // Calculated by hand: 20 µrad of pitch over 300 mm are 6 µm.
    let mut m = machine("w Y' b X Z t");
    set_constant(&mut m, Axis::X, [0.0, 0.0, 0.0, 0.0, 20e-6, 0.0]);
    m.settings.axes[0].measured_at_mm = [0.0, 0.0, -300.0];
    assert_near(tip(&m, &[0.0, 0.0, -300.0]), [0.0, 0.0, 0.0], 1e-7);
    assert_near(tip(&m, &[0.0, 0.0, 0.0]), [6e-3, 0.0, 0.0], 1e-12);
}

#[test]
fn a_table_without_a_line_is_that_of_the_moved_frame() {
    let mut m = machine("w X' b Y Z t");
    set_constant(&mut m, Axis::X, [0.0, 0.0, 0.0, 10e-6, 20e-6, 30e-6]);
    // The tip is at (0, 50, -30), the origin of X's frame at (-100, 0, 0).
    assert_near(tip(&m, &[100.0, 50.0, -30.0]), [-2.1e-3, 3.3e-3, -1.5e-3], 1e-7);
}

/// Nominal pose of every frame by hand: rotation and origin, from the bed outwards, for the cross-check below.
fn nominal(axes: &[(Axis, f64, f64)]) -> Vec<(DMat3, DMat3, DVec3)> {
    let (mut carrier, mut origin, mut frames) = (DMat3::IDENTITY, DVec3::ZERO, Vec::new());
    for &(axis, sense, q) in axes {
        let before = carrier;
        let angle = (sense * q).to_radians();
        match axis {
            Axis::X => origin += carrier.x_axis * sense * q,
            Axis::Y => origin += carrier.y_axis * sense * q,
            Axis::Z => origin += carrier.z_axis * sense * q,
            Axis::A => carrier *= DMat3::from_rotation_x(angle),
            Axis::B => carrier *= DMat3::from_rotation_y(angle),
            Axis::C => carrier *= DMat3::from_rotation_z(angle),
        }
        frames.push((before, carrier, origin));
    }
    frames
}

/// d = Σ R_i e_i + (R_i w_i) × (p_tip − o_i) and Σ R_i w_i × t, with the twists at the frames' origins.
fn first_order(
    workpiece: &[(Axis, f64, f64)],
    tool: &[(Axis, f64, f64)],
    tool_mm: [f64; 3],
    twists: impl Fn(Axis) -> Twist,
) -> (DVec3, DVec3) {
    let (on_workpiece, on_tool) = (nominal(workpiece), nominal(tool));
    let (turned, end) = on_tool.last().map_or((DMat3::IDENTITY, DVec3::ZERO), |frame| (frame.1, frame.2));
    let p = end + turned * DVec3::from_array(tool_mm);
    let (mut d, mut orientation) = (DVec3::ZERO, DVec3::ZERO);
    let both = workpiece.iter().zip(&on_workpiece).chain(tool.iter().zip(&on_tool));
    for (&(axis, ..), &(carrier, _, origin)) in both {
        let [ex, ey, ez, ea, eb, ec] = twists(axis);
        let w = carrier * DVec3::new(ea, eb, ec);
        d += carrier * DVec3::new(ex, ey, ez) + w.cross(p - origin);
        orientation += w;
    }
    (d, orientation.cross(turned.z_axis))
}

#[test]
fn agrees_with_the_sum_of_twists_to_second_order() {
    use Axis::{A, B, C, X, Y, Z};
    let chains: [(&str, &[Axis], &[Axis]); 7] = [
        ("w X' b Y Z t", &[X], &[Y, Z]),
        ("w Y' X' b Z t", &[X, Y], &[Z]),
        ("w b Z Y X t", &[], &[Z, Y, X]),
        ("w C' A' X' b Y Z t", &[X, A, C], &[Y, Z]),
        ("w X' b Z C A t", &[X], &[Z, C, A]),
        ("w X' Y' b Z C A t", &[Y, X], &[Z, C, A]),
        ("w C' Z' b X B Y A t", &[Z, C], &[X, B, Y, A]),
    ];
    let mut noise = Noise::new(5);
    let mut uniform = move |size: f64| size * noise.signed();
    for (chain, workpiece, tool) in chains {
        let (mut worst, mut largest, mut ratios) = (0f64, 0f64, Vec::new());
        for _ in 0..40 {
            let twists: Vec<Twist> =
                (0..6).map(|_| std::array::from_fn(|i| uniform(if i < 3 { 0.02 } else { 1e-4 }))).collect();
            let offsets: Twist = std::array::from_fn(|i| uniform(if i < 3 { 0.02 } else { 1e-4 }));
            let square: [f64; 3] = std::array::from_fn(|_| uniform(1e-4));
            let q: [f64; 6] = std::array::from_fn(|i| uniform(if i < 3 { 300.0 } else { 180.0 }));
            let tool_mm: [f64; 3] = std::array::from_fn(|_| uniform(150.0));
            let mut deviation = [0.0; 2];
            for (scale, found) in [1.0, 0.1].into_iter().zip(&mut deviation) {
                let mut m = machine(chain);
                m.settings.tool_mm = tool_mm;
                m.settings.location.c0y = scale * square[0];
                m.settings.location.b0z = scale * square[1];
                m.settings.location.a0z = scale * square[2];
                for r in &mut m.settings.location.rotary {
                    *r = offsets.map(|value| scale * value);
                }
                for own in m.settings.axes.clone() {
                    let constant = twists[own.axis.index()].map(|value| scale * value);
                    set_constant(&mut m, own.axis, constant);
                }
                let mut position = [0.0; AXES];
                for (value, own) in position.iter_mut().zip(&m.settings.axes) {
                    *value = q[own.axis.index()];
                }
                let exact = Geometry::new(&m, 0.0).unwrap().pose_error(&position, &FORWARD);
                let pose = |axes: &[Axis], primed: bool| -> Vec<(Axis, f64, f64)> {
                    axes.iter().map(|&axis| (axis, if primed { -1.0 } else { 1.0 }, q[axis.index()])).collect()
                };
                let own_twist = |axis: Axis| {
                    let mut twist = twists[axis.index()];
                    match axis {
                        Y => twist[0] -= square[0] * q[1],
                        Z => {
                            twist[0] += square[1] * q[2];
                            twist[1] -= square[2] * q[2];
                        }
                        A | B | C => (0..6).for_each(|i| twist[i] += offsets[i]),
                        X => {}
                    }
                    twist.map(|value| scale * value)
                };
                let (d, direction) = first_order(&pose(workpiece, true), &pose(tool, false), tool_mm, own_twist);
                let tip_off = (DVec3::from_array(exact.tip_mm) - d).length();
                let direction_off = (DVec3::from_array(exact.direction) - direction).length();
                if scale == 1.0 {
                    largest = largest.max(tip_off / d.length());
                }
                *found = tip_off + 100.0 * direction_off;
            }
            worst = worst.max(deviation[0]);
            ratios.push(deviation[0] / deviation[1]);
        }
        let low = ratios.iter().copied().fold(f64::MAX, f64::min);
        let high = ratios.iter().copied().fold(0.0, f64::max);
        println!("{chain}: second order {worst:.1e} mm, {largest:.1e} relative, ratio {low:.2} to {high:.2}");
        assert!(low > 97.0 && high < 103.0, "{chain}: ratio {low} to {high}");
        assert!(worst < 1e-3, "{chain}: {worst}");
    }
}

#[test]
fn large_rotations_use_the_same_formula_as_small_ones() {
    for size in [0.0099, 0.0101, 1.0] {
        let w = DVec3::new(0.6, -0.48, 0.64) * size;
        let wanted = DMat3::from_axis_angle(w / w.length(), w.length());
        assert!((rotation(w) - wanted).to_cols_array().into_iter().all(|value| value.abs() < 3e-16), "{size}");
    }
}

#[test]
fn direction_of_travel_chooses_the_column_and_adds_the_backlash() {
    let mut m = machine("w X' b Y Z t");
    set_constant(&mut m, Axis::Y, [1e-3, 2e-3, 0.0, 0.0, 0.0, 0.0]);
    for row in &mut m.tables[1].as_mut().unwrap().rows {
        row.reverse = [3e-3, -2e-3, 0.0, 0.0, 0.0, 0.0];
    }
    m.settings.axes[1].backlash = 7e-3;
    let geometry = Geometry::new(&m, 0.0).unwrap();
    let at = [0.0; AXES];
    let mut reverse = [0.0; AXES];
    assert_near(geometry.tip_error(&at, &reverse), [1e-3, 2e-3, 0.0], 1e-12);
    reverse[1] = 1.0;
    assert_near(geometry.tip_error(&at, &reverse), [3e-3, -2e-3 + 7e-3, 0.0], 1e-12);
    reverse[1] = 0.5;
    assert_near(geometry.tip_error(&at, &reverse), [2e-3, 3.5e-3, 0.0], 1e-12);
}

#[test]
fn thermal_growth_starts_at_its_datum() {
    let mut m = machine("w X' b Y Z t");
    m.settings.axes[2].thermal.offset_per_k = 1e-3;
    m.settings.axes[2].thermal.expansion_per_k = 11e-6;
    m.settings.axes[2].thermal.datum = 100.0;
    let at = [0.0, 0.0, 500.0, 0.0, 0.0, 0.0];
    let error = Geometry::new(&m, 5.0).unwrap().tip_error(&at, &FORWARD);
    assert_near(error, [0.0, 0.0, 5.0 * (1e-3 + 11e-6 * 400.0)], 1e-12);
}

#[test]
fn cubic_tables_are_scipys_pchip() {
    let x = [0.0, 10.0, 25.0, 45.0, 60.0, 100.0];
    let y = [0.0, 3.0, 4.0, -2.0, -2.5, 7.0];
    // scipy 1.x: PchipInterpolator(x, y)(q).
    let wanted = [
        (3.0, 1.154427848101266),
        (10.0, 3.0),
        (17.5, 3.713607594936709),
        (24.0, 3.994347866854196),
        (30.0, 3.116685779816514),
        (50.0, -2.258069996602107),
        (59.0, -2.497225959904859),
        (75.0, -1.021573153409091),
        (98.0, 6.146907196969697),
        (-5.0, 0.0),
        (130.0, 7.0),
    ];
    let mut m = machine("w b X Y Z t");
    let rows: Vec<(f64, Twist)> = x.iter().zip(y).map(|(&x, y)| (x, [0.0, y, 0.0, 0.0, 0.0, 0.0])).collect();
    set_table(&mut m, Axis::X, &rows);
    m.settings.axes[0].interpolation = Interpolation::Cubic;
    for (q, value) in wanted {
        assert_near(tip(&m, &[q]), [0.0, value, 0.0], 1e-13);
    }
    m.settings.axes[0].interpolation = Interpolation::Linear;
    for (q, value) in [(-1.0, 0.0), (5.0, 1.5), (10.0, 3.0), (35.0, 1.0), (80.0, 2.25), (101.0, 7.0)] {
        assert_near(tip(&m, &[q]), [0.0, value, 0.0], 1e-13);
    }
}

#[test]
fn a_full_turn_repeats_with_a_continuous_slope() {
    let mut m = machine("w C' X' Y' b Z t");
    let rows: Vec<Row> = [(0.0, 1e-3), (90.0, 4e-3), (200.0, -3e-3), (300.0, -1e-3), (360.0, 1e-3)]
        .map(|(position, exc)| Row {
            position,
            forward: [exc, 0.0, 0.0, 0.0, 0.0, 0.0],
            reverse: [exc, 0.0, 0.0, 0.0, 0.0, 0.0],
        })
        .to_vec();
    let c = slot(&m, Axis::C);
    m.tables[c] = Some(Table { given: [true; 6], bidirectional: false, rows });
    m.settings.axes[c].interpolation = Interpolation::Cubic;
    let at = |angle: f64| tip(&m, &[0.0, 0.0, 0.0, angle])[0];
    for angle in [0.0, 33.0, 215.0, 359.0] {
        for turns in [-2.0, 1.0, 2777.0] {
            assert!((at(angle) - at(angle + 360.0 * turns)).abs() < 1e-12, "{angle} + {turns} turns");
        }
    }
    let h = 1e-3;
    let (left, right) = ((at(360.0) - at(360.0 - h)) / h, (at(h) - at(0.0)) / h);
    assert!((left - right).abs() < 1e-7 && left > 1e-5, "{left} {right}");
}

#[test]
fn bad_structural_codes_say_what_is_needed() {
    for (chain, found) in [
        ("X' b Y t", "'X'"),
        ("w X b Y Z t", "'X'"),
        ("w X' b Y' Z t", "'Y'"),
        ("w X' b Q t", "'Q'"),
        ("w X' b Y", "the end"),
        ("w X' b Y t Z", "'Z'"),
        ("", "the end"),
        ("w X' t", "'t'"),
    ] {
        match Geometry::new(&machine(chain), 0.0) {
            Err(GeometryError::Chain { found: reported, .. }) => assert_eq!(reported, found, "{chain}"),
            other => panic!("{chain}: {other:?}"),
        }
    }
    let wrong_axis = |m: &Machine| Geometry::new(m, 0.0).unwrap_err();
    assert!(matches!(wrong_axis(&machine("w X' b X Z t")), GeometryError::Axis { axis: 'X', .. }));
    let mut m = machine("w X' b Y Z t");
    m.settings.axes.pop();
    assert!(matches!(wrong_axis(&m), GeometryError::Axis { axis: 'Z', .. }));
}

#[test]
fn offsets_move_the_axes_of_rotation_and_nothing_else_when_they_are_at_zero() {
    // A trunnion A at (0, 20, 50) from the bed carries C at (0, 0, 30): the workpiece is on C.
    let mut m = machine("w C' A' b X Y Z t");
    let (a, c) = (slot(&m, Axis::A), slot(&m, Axis::C));
    m.settings.axes[a].offset_mm = [0.0, 20.0, 50.0];
    m.settings.axes[c].offset_mm = [0.0, 0.0, 30.0];
    m.settings.tool_mm = [0.0, 0.0, -100.0];
    let geometry = Geometry::new(&m, 0.0).unwrap();
    let at = |a: f64, c: f64| [7.0, 20.0, 250.0, a, c, 0.0];
    // Tip from A's axis: (7, 0, 100); from C's frame (7, 0, 70) at zero.
    assert_near(geometry.ideal_pose(&at(0.0, 0.0)).tip_mm, [7.0, 0.0, 70.0], 1e-12);
    // A at 90° turns the table by −90° about x: the former z direction is the table's y.
    assert_near(geometry.ideal_pose(&at(90.0, 0.0)).tip_mm, [7.0, -100.0, -30.0], 1e-12);
    // The error of A acts about A's axis: w × (7, 0, 100); C's error acts about C's axis.
    let w: f64 = 1e-9;
    set_constant(&mut m, Axis::A, [0.0, 0.0, 0.0, w, 0.0, 0.0]);
    assert_near(tip(&m, &at(0.0, 0.0)), [0.0, -w * 100.0, 0.0], 1e-13);
    set_constant(&mut m, Axis::A, [0.0; 6]);
    set_constant(&mut m, Axis::C, [0.0, 0.0, 0.0, 0.0, w, 0.0]);
    assert_near(tip(&m, &at(0.0, 0.0)), [w * 70.0, 0.0, -w * 7.0], 1e-13);
    // A table reproduces its values on the line of its measurement, wherever the frame's origin is.
    let mut m = machine("w Y' b X Z t");
    m.settings.axes[0].offset_mm = [100.0, 200.0, 300.0];
    m.settings.axes[0].measured_at_mm = [0.0, 0.0, -300.0];
    set_constant(&mut m, Axis::X, [1e-3, 0.0, 0.0, 0.0, 20e-6, 0.0]);
    assert_near(tip(&m, &[0.0, 0.0, -300.0]), [1e-3, 0.0, 0.0], 1e-7);
}

#[test]
fn the_tool_axis_of_the_machine_is_the_direction_that_errs() {
    let mut m = machine("w b Z A t");
    let w: f64 = 30e-6;
    set_constant(&mut m, Axis::A, [0.0, 0.0, 0.0, 0.0, w, 0.0]);
    let direction = |m: &Machine| {
        let error = Geometry::new(m, 0.0).unwrap().pose_error(&[0.0; AXES], &FORWARD);
        assert_near(error.orientation, [0.0, w, 0.0], 1e-15);
        error.direction
    };
    assert_near(direction(&m), [w.sin(), 0.0, w.cos() - 1.0], 1e-15);
    // The vector's length does not matter; an error about the tool axis has no effect.
    m.settings.kinematics.tool_axis = [0.0, 2.0, 0.0];
    assert_near(direction(&m), [0.0; 3], 1e-15);
    m.settings.kinematics.tool_axis = [-0.5, 0.0, 0.0];
    assert_near(direction(&m), [1.0 - w.cos(), 0.0, w.sin()], 1e-15);
    let pose = Geometry::new(&m, 0.0).unwrap().ideal_pose(&[0.0; AXES]);
    assert_near(pose.direction, [-1.0, 0.0, 0.0], 0.0);
}

#[test]
fn orientation_is_in_bed_directions_whatever_the_workpieces_pose() {
    let w: f64 = 50e-6;
    for angle in [0.0, 30.0, 90.0, -135.0] {
        let mut m = machine("w C' Y' b X Z B t");
        // Tool side: the carrier of B never turns. Workpiece side: tables state the tool relative to the workpiece.
        set_constant(&mut m, Axis::B, [0.0, 0.0, 0.0, w, 0.0, 0.0]);
        let turned = |m: &Machine| {
            let at = [1.0, 2.0, 3.0, angle, -2.0 * angle, 0.0];
            Geometry::new(m, 0.0).unwrap().pose_error(&at, &FORWARD).orientation
        };
        assert_near(turned(&m), [w, 0.0, 0.0], 1e-15);
        set_constant(&mut m, Axis::B, [0.0; 6]);
        set_constant(&mut m, Axis::C, [0.0, 0.0, 0.0, 0.0, w, 0.0]);
        assert_near(turned(&m), [0.0, w, 0.0], 1e-15);
        // A rotation of one radian is not small; its rotation vector is still recovered.
        set_constant(&mut m, Axis::C, [0.0, 0.0, 0.0, 0.3, -0.4, 0.8]);
        assert_near(turned(&m), [0.3, -0.4, 0.8], 1e-14);
    }
}

/// Gives every axis errors of every kind, mm and rad.
fn spoil(m: &mut Machine, random: &mut impl FnMut(f64) -> f64) {
    for own in m.settings.axes.clone() {
        let reach = if own.axis.is_rotary() { 180.0 } else { 400.0 };
        let rows: Vec<(f64, Twist)> = (0..9)
            .map(|k| {
                let position = reach * (f64::from(k) / 4.0 - 1.0);
                (position, std::array::from_fn(|i| random(if i < 3 { 0.02 } else { 1e-4 })))
            })
            .collect();
        set_table(m, own.axis, &rows);
    }
    m.settings.location.c0y = random(1e-4);
    m.settings.location.rotary[0] = std::array::from_fn(|i| random(if i < 3 { 0.02 } else { 1e-4 }));
}

#[test]
fn a_corrected_command_puts_the_tool_where_it_belongs() {
    let mut noise = Noise::new(11);
    let mut random = move |size: f64| size * noise.signed();
    for chain in ["w X' Y' b Z t", "w C' A' Y' b X Z t", "w X' b Y Z C A t", "w b C X Y Z B t", "w C' b Z X t"] {
        let mut m = machine(chain);
        m.settings.tool_mm = [5.0, -3.0, -120.0];
        spoil(&mut m, &mut random);
        let geometry = Geometry::new(&m, 0.0).unwrap();
        let mut worst = (0f64, 0f64);
        for _ in 0..100 {
            let mut at = [0.0; AXES];
            for (q, own) in at.iter_mut().zip(&m.settings.axes) {
                *q = random(if own.axis.is_rotary() { 170.0 } else { 350.0 });
            }
            for fade_deg in [None, Some(5.0)] {
                let settings = CorrectionSettings { passes: None, fade_deg };
                let correction = geometry.correction(&at, &FORWARD, settings).unwrap();
                let sent: [f64; AXES] = std::array::from_fn(|slot| at[slot] + correction[slot]);
                let (ideal, actual) = (geometry.ideal_pose(&at), geometry.actual_pose(&sent, &FORWARD));
                let y_is_there = chain.contains('Y');
                let off = |a: [f64; 3], b: [f64; 3]| (DVec3::from_array(a) - DVec3::from_array(b)).length();
                let (tip, direction) = (off(ideal.tip_mm, actual.tip_mm), off(ideal.direction, actual.direction));
                if y_is_there {
                    worst.0 = worst.0.max(tip);
                }
                for (own, correction) in m.settings.axes.iter().zip(correction) {
                    assert!(fade_deg.is_some() || !own.axis.is_rotary() || correction == 0.0);
                }
                // Away from the singular pose, two rotary axes remove the direction error completely.
                let tilt = m.settings.axes.iter().zip(at).find(|(own, _)| matches!(own.axis, Axis::A | Axis::B));
                if fade_deg.is_some() && tilt.is_some_and(|(_, q)| q.to_radians().sin().abs() > 0.09) {
                    worst.1 = worst.1.max(direction);
                }
            }
        }
        println!("{chain}: tip {:.1e} mm, direction {:.1e}", worst.0, worst.1);
        assert!(worst.0 < 3e-12 && worst.1 < 1e-14, "{chain}: {worst:?}");
    }
}

#[test]
fn a_count_of_passes_is_kept() {
    // The error of X has a slope of 1e-2: q + r with r ← −1e-2 (q + r) from 0.
    let mut m = machine("w b X Y Z t");
    set_table(&mut m, Axis::X, &[(0.0, [0.0; 6]), (100.0, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])]);
    let geometry = Geometry::new(&m, 0.0).unwrap();
    let at = [50.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut expected = 0.0;
    for passes in 1..=4 {
        expected = -1e-2 * (50.0 + expected);
        let found = geometry.correction(&at, &FORWARD, CorrectionSettings { passes: Some(passes), fade_deg: None });
        assert_near(found.unwrap()[..3].try_into().unwrap(), [expected, 0.0, 0.0], 1e-13);
    }
    // Parallel linear axes cannot take up an error: B at 90° turns X into Z.
    let mut m = machine("w Z' b B X Y t");
    set_constant(&mut m, Axis::X, [1e-3; 6]);
    let b = slot(&m, Axis::B);
    let mut at = [0.0; AXES];
    at[b] = 90.0;
    assert_eq!(Geometry::new(&m, 0.0).unwrap().correction(&at, &FORWARD, CorrectionSettings::default()), None);
}
