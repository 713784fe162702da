use super::*;
use trueaxis::machine::MachineSettings;
use trueaxis_tables::Table;

fn machine(chain: &str, errors: impl Fn(Axis, f64) -> [f64; 6]) -> Machine {
    let mut settings = MachineSettings {
        name: heapless::String::try_from("test").unwrap(),
        chain: heapless::String::try_from(chain).unwrap(),
        tool_mm: [20.0, -35.0, -150.0],
        reference_temperature_c: 20.0,
        location: LocationErrors::default(),
        faults: Default::default(),
        contour: Default::default(),
        axes: heapless::Vec::new(),
    };
    let mut tables = Vec::new();
    for axis in Axis::ALL {
        let Some(at) = chain.find(axis.letter()) else { continue };
        let workpiece = chain[at + 1..].starts_with('\'');
        settings.axes.push(AxisSettings::with_defaults(axis, workpiece)).unwrap();
        let (start, cell) = if axis.is_rotary() { (0.0, 30.0) } else { (-300.0, 50.0) };
        let grid = (0..=12).map(|i| start + cell * f64::from(i));
        let rows = grid
            .map(|position| Row { position, forward: errors(axis, position), reverse: errors(axis, position) })
            .collect();
        tables.push(Some(Table { given: [true; 6], bidirectional: false, rows }));
    }
    Machine { settings, tables }
}

/// Positions in the order X Y Z, rotary.
fn error(machine: &Machine, q: [f64; 5]) -> DVec3 {
    Geometry::new(machine).tip_error(&q, &[0.0; 5])
}

#[test]
fn a_translation_reads_the_same_on_either_side() {
    for chain in ["w X' Y' b Z t", "w b X Y Z t", "w X' b Y Z t"] {
        let machine =
            machine(chain, |axis, _| if axis == Axis::X { [0.01, 0.02, 0.03, 0.0, 0.0, 0.0] } else { [0.0; 6] });
        let d = error(&machine, [100.0, 50.0, -20.0, 0.0, 0.0]);
        assert!((d - DVec3::new(0.01, 0.02, 0.03)).length() < 1e-12, "{chain}: {d}");
    }
}

#[test]
fn roll_acts_on_the_lever_from_where_it_was_measured() {
    // EAX with X outermost from the bed on the tool side: lever (0, y, z) + tool.
    let roll = 20e-6;
    let mut machine =
        machine("w b X Y Z t", |axis, _| if axis == Axis::X { [0.0, 0.0, 0.0, roll, 0.0, 0.0] } else { [0.0; 6] });
    machine.settings.axes[0].measured_at_mm = [0.0, 100.0, -50.0];
    let d = error(&machine, [70.0, 100.0, -50.0, 0.0, 0.0]);
    assert!(d.length() < 2e-7, "{d}");
    let d = error(&machine, [70.0, 100.0, -350.0, 0.0, 0.0]);
    // w × (0, 0, −300) = (0, +300 w, 0)
    assert!((d - DVec3::new(0.0, 300.0 * roll, 0.0)).length() < 2e-7, "{d}");
}

#[test]
fn squareness_tilts_the_travel_and_nothing_else() {
    let mut machine = machine("w X' Y' b Z t", |_, _| [0.0; 6]);
    machine.settings.location = LocationErrors { a0z: 1e-5, b0z: 2e-5, c0y: 3e-5, ..Default::default() };
    let d = error(&machine, [10.0, 100.0, -200.0, 0.0, 0.0]);
    assert!((d - DVec3::new(-3e-5 * 100.0 - 2e-5 * 200.0, 1e-5 * 200.0, 0.0)).length() < 1e-12, "{d}");
}

#[test]
fn angular_error_of_a_table_moves_the_tip_round_it() {
    // ECC: the tool is turned by +w about the table's axis, relative to the workpiece.
    let w = 1e-5;
    let mut machine =
        machine("w C' b X Y Z t", |axis, _| if axis == Axis::C { [0.0, 0.0, 0.0, 0.0, 0.0, w] } else { [0.0; 6] });
    machine.settings.tool_mm = [0.0; 3];
    let d = error(&machine, [100.0, 0.0, 0.0, 40.0, 0.0]);
    assert!((d - DVec3::new(0.0, 100.0 * w, 0.0)).length() < 1e-8, "{d}");
}

/// `d = Σ R_i e_i + (R_i w_i) × (p_tip − o_i)`, written out for chains where every linear axis lies below the rotary ones.
fn first_order(chain: &str, q: &[f64; 5], tool: DVec3, errors: &impl Fn(Axis, f64) -> [f64; 6]) -> DVec3 {
    let rotary: Vec<Axis> = Axis::ALL.into_iter().filter(|a| a.is_rotary() && chain.contains(a.letter())).collect();
    let at = |axis: Axis| match rotary.iter().position(|a| *a == axis) {
        Some(place) => q[3 + place],
        None => q[axis.index()],
    };
    let (workpiece, tool_side) = chain.split_once('b').unwrap();
    let letters = |s: &str| s.chars().filter_map(Axis::from_letter).collect::<Vec<_>>();
    let mut w_side = letters(workpiece);
    w_side.reverse();
    let t_side = letters(tool_side);
    let walk = |side: &[Axis], sign: f64| {
        let (mut r, mut o) = (DQuat::IDENTITY, DVec3::ZERO);
        let mut frames = Vec::new();
        for axis in side {
            let carrier = r;
            if axis.is_rotary() {
                r *= DQuat::from_axis_angle(unit(*axis), sign * at(*axis).to_radians());
            } else {
                o += r * (sign * at(*axis) * unit(*axis));
            }
            frames.push((*axis, carrier, o));
        }
        (frames, r, o)
    };
    let (w_frames, _, _) = walk(&w_side, -1.0);
    let (t_frames, r_t, o_t) = walk(&t_side, 1.0);
    let tip = o_t + r_t * tool;
    w_frames
        .into_iter()
        .chain(t_frames)
        .map(|(axis, r, o)| {
            let [ex, ey, ez, wx, wy, wz] = errors(axis, at(axis));
            let (e, w) = (r * DVec3::new(ex, ey, ez), r * DVec3::new(wx, wy, wz));
            e + w.cross(tip - o)
        })
        .sum()
}

#[test]
fn agrees_with_the_first_order_twists_to_second_order() {
    for chain in [
        "w X' Y' b Z t",
        "w b X Y Z t",
        "w C' A' X' b Y Z t",
        "w X' b Z C A t",
        "w B' b X Y Z A t",
        "w C' Y' b X Z B t",
    ] {
        let mut last = None::<f64>;
        for scale in [1.0, 0.1] {
            // Constant over the travel, so that the levers of the tables' measurement stay out of the comparison.
            let errors = |axis: Axis, _: f64| -> [f64; 6] {
                let k = axis.index() as f64 + 1.0;
                std::array::from_fn(|i| {
                    scale * 60e-6 * (if i < 3 { 1e3 } else { 1.0 }) * (k * 2.3 + 1.7 * i as f64).sin()
                })
            };
            let mut machine = machine(chain, errors);
            // Levers then and now the same: translations given at the frame itself.
            let geometry = {
                let mut g = Geometry::new(&machine);
                let side = |links: &mut Vec<Link>| links.iter_mut().for_each(|l| l.measured_at = [0.0; 3]);
                side(&mut g.workpiece);
                side(&mut g.tool);
                g
            };
            machine.settings.name.clear();
            let q = [120.0, -75.0, 60.0, 37.0, -64.0];
            let exact = geometry.tip_error(&q, &[0.0; 5]);
            // The exact form refers e to the line of measurement: bring the first order there too.
            let referred = |axis: Axis, at: f64| {
                let mut e = errors(axis, at);
                let on_workpiece = geometry.workpiece.iter().any(|l| l.axis == axis);
                let link = geometry.workpiece.iter().chain(&geometry.tool).find(|l| l.axis == axis).unwrap();
                let lever = geometry.lever_when_measured(link, at, on_workpiece);
                let shift = DVec3::new(e[3], e[4], e[5]).cross(lever);
                for k in 0..3 {
                    e[k] -= shift[k];
                }
                e
            };
            let first = first_order(chain, &q, DVec3::from_array(machine.settings.tool_mm), &referred);
            let difference = (exact - first).length();
            assert!(difference < 5e-3 * exact.length(), "{chain}: {exact} {first}");
            if let Some(last) = last {
                assert!((60.0..150.0).contains(&(last / difference)), "{chain}: {last:e} to {difference:e}");
            }
            last = Some(difference);
        }
    }
}

#[test]
fn tables_wrap_hold_their_edges_and_pass_their_points() {
    let machine = machine("w C' b X Y Z t", |axis, q| match axis {
        Axis::C => [1e-3 * (2.0 * q.to_radians()).sin(), 0.0, 0.0, 0.0, 0.0, 0.0],
        Axis::X => [1e-5 * q, 0.0, 0.0, 0.0, 0.0, 0.0],
        _ => [0.0; 6],
    });
    let geometry = Geometry::new(&machine);
    let c = &geometry.workpiece[0];
    assert!((interpolate(c, 360.0 * 7.0 + 45.0, 0.0)[0] - interpolate(c, 45.0, 0.0)[0]).abs() < 1e-15);
    assert!((interpolate(c, 30.0, 0.0)[0] - 1e-3 * 60_f64.to_radians().sin()).abs() < 1e-15);
    let x = geometry.tool.iter().find(|l| l.axis == Axis::X).unwrap();
    assert_eq!(interpolate(x, 1000.0, 0.0)[0], 3e-3);
    assert_eq!(interpolate(x, -1000.0, 0.0)[0], -3e-3);
}
