use super::*;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

type Matrix = [[f64; 3]; 3];

/// Rodrigues' formula about any unit vector, so that the tests' rotations are written differently from those under test.
fn turn(axis: [f64; 3], angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    let k = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let square: f64 = (0..3).map(|m| k[i][m] * k[m][j]).sum();
            f64::from(i == j) + s * k[i][j] + (1.0 - c) * square
        })
    })
}

fn apply(m: Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| dot(row, v))
}

/// Distance along the base circle's tangent between a point and the involute helicoid, from the surface's equation in cylinder
/// coordinates: atan2(y, x) − z/p = ±(√(R²/r_b² − 1) − arccos(r_b/R)).
fn residual(point: [f64; 3], rb: f64, p: f64, right: bool) -> f64 {
    let radius = point[0].hypot(point[1]);
    let roll = ((radius - rb) * (radius + rb)).max(0.0).sqrt() / rb;
    let involute = roll - roll.atan();
    let gap = point[1].atan2(point[0]) - point[2] / p - if right { involute } else { -involute };
    rb * (gap - TAU * (gap / TAU).round())
}

fn machine(form: Form, pivot_mm: f64, a: i8, c: i8, work_offset_mm: [f64; 3]) -> HeadTable {
    HeadTable::new(&MachineSettings { form, pivot_mm, direction_a: a, direction_c: c, work_offset_mm }).unwrap()
}

#[derive(Clone, Copy, Debug)]
struct Case {
    rb: f64,
    p: f64,
    /// Magnitude of u.
    roll: f64,
    theta: f64,
    left: bool,
    vertical: bool,
    second: bool,
    a: i8,
    c: i8,
    pivot: f64,
    w: [f64; 3],
}

impl Case {
    fn surface(&self) -> Helicoid {
        let (p, flank) = if self.left { (-self.p, Flank::Left) } else { (self.p, Flank::Right) };
        Helicoid::new(self.rb, p, flank).unwrap()
    }

    fn u(&self) -> f64 {
        if self.left { -self.roll } else { self.roll }
    }

    fn form(&self) -> Form {
        if self.vertical { Form::Vertical } else { Form::Horizontal }
    }

    fn branch(&self) -> Branch {
        if self.second { Branch::Second } else { Branch::First }
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let surface = (5.0..150.0, 5.0..600.0, 0.05..3.0, -6.0..6.0, any::<bool>());
    let sense = || prop_oneof![Just(1i8), Just(-1i8)];
    let machine = (any::<bool>(), any::<bool>(), sense(), sense(), 0.0..400.0, prop::array::uniform3(-200.0..200.0));
    (surface, machine).prop_map(|((rb, p, roll, theta, left), (vertical, second, a, c, pivot, w))| Case {
        rb,
        p,
        roll,
        theta,
        left,
        vertical,
        second,
        a,
        c,
        pivot,
        w,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

    /// The machine's joints, composed here from Rodrigues rotations about x and z, bring the tip onto the surface and the
    /// spindle along its normal.
    #[test]
    fn the_tip_is_on_the_surface_and_the_tool_on_its_normal(case in cases()) {
        let (surface, u) = (case.surface(), case.u());
        let table = machine(case.form(), case.pivot, case.a, case.c, case.w);
        let axes = table.place(&surface, u, case.theta, case.branch()).unwrap();
        let head = turn([1.0, 0.0, 0.0], (f64::from(case.a) * axes.a_deg).to_radians());
        let back = turn([0.0, 0.0, -1.0], (f64::from(case.c) * axes.c_deg).to_radians());
        let rest = if case.vertical { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let spindle = apply(head, rest);
        let tip: [f64; 3] =
            std::array::from_fn(|i| axes.linear_mm[i] + case.pivot * rest[i] - case.pivot * spindle[i]);
        let tip = minus(apply(back, tip), case.w);
        let axis = apply(back, spindle);

        let p = surface.lead_parameter();
        prop_assert!(residual(tip, case.rb, p, !case.left).abs() < 1e-9, "{}", residual(tip, case.rb, p, !case.left));
        prop_assert!((tip[2] - p * case.theta).abs() < 1e-9);
        prop_assert!((tip[0].hypot(tip[1]) - case.rb * u.hypot(1.0)).abs() < 1e-9);
        prop_assert!(norm(minus(tip, surface.point(u, case.theta))) < 1e-9);

        // The exact derivatives of the surface, and the outward side: away from the axis and up.
        let (sin, cos) = (u + case.theta).sin_cos();
        let along_u = [cos, sin, 0.0];
        let along_theta = [case.rb * (u * cos - sin), case.rb * (cos + u * sin), p];
        prop_assert!(dot(axis, along_u).abs() < 1e-12);
        prop_assert!(dot(axis, along_theta).abs() < 1e-12 * norm(along_theta));
        prop_assert!((norm(axis) - 1.0).abs() < 1e-12);
        prop_assert!(axis[2] > 0.0 && axis[0] * tip[0] + axis[1] * tip[1] > 0.0);
        prop_assert!(norm(minus(axis, surface.normal(u, case.theta))) < 1e-12);

        let tool = table.tool(&axes);
        prop_assert!(norm(minus(tool.tip_mm, tip)) < 1e-9 && norm(minus(tool.axis, axis)) < 1e-12);
    }

    #[test]
    fn the_normal_is_the_cross_product_of_differences(case in cases()) {
        let (surface, u, h) = (case.surface(), case.u(), 1e-5);
        let du = minus(surface.point(u + h, case.theta), surface.point(u - h, case.theta));
        let dt = minus(surface.point(u, case.theta + h), surface.point(u, case.theta - h));
        let n = cross(du, dt);
        // Their cross product changes sign with u (length r_b u), the normal does not.
        let n = n.map(|x| case.u().signum() * x / norm(n));
        let off = norm(minus(n, surface.normal(u, case.theta)));
        prop_assert!(off < 1e-7, "{off}");
    }

    /// Both branches and both forms give the same tool pose.
    #[test]
    fn branches_and_forms_give_one_pose(case in cases()) {
        let surface = case.surface();
        let pose = |form, branch| {
            let table = machine(form, case.pivot, case.a, case.c, case.w);
            table.tool(&table.place(&surface, case.u(), case.theta, branch).unwrap())
        };
        let first = pose(Form::Vertical, Branch::First);
        for (form, branch) in
            [(Form::Vertical, Branch::Second), (Form::Horizontal, Branch::First), (Form::Horizontal, Branch::Second)]
        {
            let other = pose(form, branch);
            prop_assert!(norm(minus(first.tip_mm, other.tip_mm)) < 1e-9);
            prop_assert!(norm(minus(first.axis, other.axis)) < 1e-12);
        }
    }
}

/// Values that can be calculated by hand: φ = π/2, p = r_b, so γ = 45°.
#[test]
fn a_placement_by_hand() {
    let surface = Helicoid::new(10.0, 10.0, Flank::Right).unwrap();
    let (u, theta) = (1.0, FRAC_PI_2 - 1.0);
    // F = [10 u, 10, 10 θ]; C = −90° moves it to [10, −10 u, 10 θ]; the tool tilts towards −y by 45°.
    let half = 100.0 * 0.5_f64.sqrt();
    for (form, branch, linear, a, c) in [
        (Form::Vertical, Branch::First, [10.0, -10.0 - half, 10.0 * theta + half - 100.0], 45.0, -90.0),
        (Form::Vertical, Branch::Second, [-10.0, 10.0 + half, 10.0 * theta + half - 100.0], -45.0, 90.0),
        (Form::Horizontal, Branch::First, [10.0, -10.0 - half - 100.0, 10.0 * theta + half], 135.0, -90.0),
        (Form::Horizontal, Branch::Second, [-10.0, 10.0 + half - 100.0, 10.0 * theta + half], 45.0, 90.0),
    ] {
        let axes = machine(form, 100.0, 1, 1, [0.0; 3]).place(&surface, u, theta, branch).unwrap();
        assert!(norm(minus(axes.linear_mm, linear)) < 1e-12, "{axes:?} for {linear:?}");
        assert!((axes.a_deg - a).abs() < 1e-12 && (axes.c_deg - c).abs() < 1e-12, "{axes:?} for {a} {c}");
        let other = machine(form, 100.0, -1, -1, [0.0; 3]).place(&surface, u, theta, branch).unwrap();
        assert!((other.a_deg + a).abs() < 1e-12 && (other.c_deg + c).abs() < 1e-12, "{other:?}");
    }
}

/// KHK, Gear Technical Reference, normal system helical gear: m_n = 3, α_n = 20°, β = 30°, z = 12 and 60.
#[test]
fn a_published_gear() {
    for (teeth, diameter, base_diameter) in [(12, 41.569, 38.322), (60, 207.846, 191.611)] {
        let gear = Gear { module_mm: 3.0, teeth, pressure_angle_deg: 20.0, helix_angle_deg: 30.0 };
        let data = gear.data().unwrap();
        assert!((data.transverse_pressure_angle_deg - 22.79588).abs() < 5e-6, "{data:?}");
        assert!((2.0 * data.reference_radius_mm - diameter).abs() < 5.1e-4, "{data:?}");
        assert!((2.0 * data.base_radius_mm - base_diameter).abs() < 5.1e-4, "{data:?}");
    }
}

/// Relations of ISO 21771 that the code does not use: sin β_b = sin β cos α_n, cos α_n sin α_t = …, lead = z m_n π/sin β.
#[test]
fn the_relations_of_a_helical_gear() {
    for (module_mm, teeth, alpha, beta) in
        [(3.0, 24, 20.0, 15.0_f64), (1.25, 17, 14.5, 40.0), (8.0, 90, 25.0, 5.0), (3.0, 24, 20.0, -15.0)]
    {
        let gear = Gear { module_mm, teeth, pressure_angle_deg: alpha, helix_angle_deg: beta };
        let data = gear.data().unwrap();
        let (alpha, beta, z) = (alpha.to_radians(), beta.to_radians(), f64::from(teeth));
        let near = |value: f64, truth: f64| assert!((value / truth - 1.0).abs() < 1e-13, "{value} for {truth}");
        near(data.lead_mm, z * module_mm * std::f64::consts::PI / beta.sin());
        near(data.base_helix_angle_deg.to_radians(), (beta.sin() * alpha.cos()).asin());
        near(data.base_radius_mm, data.lead_parameter_mm_per_rad * data.base_helix_angle_deg.to_radians().tan());
        // The base pitch in the normal section equals that of the basic rack.
        let base_pitch = TAU * data.base_radius_mm / z * data.base_helix_angle_deg.to_radians().cos();
        near(base_pitch, std::f64::consts::PI * module_mm * alpha.cos());
        let flank = if beta > 0.0 { Flank::Right } else { Flank::Left };
        let surface = gear.helicoid(flank).unwrap();
        near(surface.tilt().abs(), FRAC_PI_2 - data.base_helix_angle_deg.to_radians().abs());
        // At the reference cylinder the flank is inclined by β to the axis: tan β = r/p.
        let point = surface.point(flank.sign() * data.reference_roll_angle_rad, 0.3);
        near(point[0].hypot(point[1]), data.reference_radius_mm);
        // Angle between the normal and the tangent of the reference cylinder's circle, in the transverse plane: α_t.
        let n = surface.normal(flank.sign() * data.reference_roll_angle_rad, 0.3);
        let radial = (n[0] * point[0] + n[1] * point[1]) / data.reference_radius_mm / n[0].hypot(n[1]);
        near(radial.asin().to_degrees(), data.transverse_pressure_angle_deg);
    }
}

#[test]
fn a_pivot_length_from_an_edge_finder() {
    assert_eq!(pivot_length(142.5, 5.0), Ok(147.5));
    assert_eq!(pivot_length(f64::NAN, 5.0).unwrap_err().quantity, Quantity::EdgeFinder);
    assert_eq!(pivot_length(142.5, 0.0).unwrap_err().quantity, Quantity::EdgeFinderRadius);
    assert_eq!(pivot_length(-20.0, 5.0).unwrap_err().quantity, Quantity::Pivot);
}

#[test]
fn invalid_helicoids_and_points_are_refused() {
    let field = |rb, p, flank| Helicoid::new(rb, p, flank).unwrap_err().quantity;
    for rb in [0.0, -1.0, f64::NAN, f64::INFINITY, 2e6] {
        assert_eq!(field(rb, 20.0, Flank::Right), Quantity::BaseRadius);
    }
    for p in [0.0, f64::NAN, f64::NEG_INFINITY, 2e6] {
        assert_eq!(field(10.0, p, Flank::Right), Quantity::LeadParameter);
    }
    assert_eq!(field(10.0, -20.0, Flank::Right), Quantity::Flank);
    assert_eq!(field(10.0, 20.0, Flank::Left), Quantity::Flank);

    let (right, left) =
        (Helicoid::new(10.0, 20.0, Flank::Right).unwrap(), Helicoid::new(10.0, -20.0, Flank::Left).unwrap());
    let table = machine(Form::Horizontal, 100.0, 1, 1, [0.0; 3]);
    let refused = |surface: &Helicoid, u, theta| table.place(surface, u, theta, Branch::First).unwrap_err().quantity;
    assert_eq!(refused(&right, -0.1, 0.0), Quantity::RollAngle);
    assert_eq!(refused(&left, 0.1, 0.0), Quantity::RollAngle);
    assert_eq!(refused(&right, f64::NAN, 0.0), Quantity::RollAngle);
    assert_eq!(refused(&right, 0.1, f64::INFINITY), Quantity::LeadAngle);
    assert!(table.place(&right, 0.0, 0.0, Branch::First).is_ok() && right.contains(0.0, -1.0).is_ok());
}

#[test]
fn a_gear_or_machine_that_cannot_be_is_refused() {
    let sound = Gear { module_mm: 3.0, teeth: 24, pressure_angle_deg: 20.0, helix_angle_deg: 15.0 };
    let field = |gear: Gear| gear.data().unwrap_err().quantity;
    for module_mm in [0.0, -3.0, f64::NAN] {
        assert_eq!(field(Gear { module_mm, ..sound }), Quantity::GearModule);
    }
    assert_eq!(field(Gear { teeth: 0, ..sound }), Quantity::Teeth);
    for pressure_angle_deg in [0.0, 90.0, f64::NAN] {
        assert_eq!(field(Gear { pressure_angle_deg, ..sound }), Quantity::PressureAngle);
    }
    for helix_angle_deg in [0.0, -0.0, 90.0, -90.0, f64::NAN] {
        assert_eq!(field(Gear { helix_angle_deg, ..sound }), Quantity::HelixAngle);
    }
    let settings = MachineSettings {
        form: Form::Vertical,
        pivot_mm: 100.0,
        direction_a: 1,
        direction_c: 1,
        work_offset_mm: [0.0; 3],
    };
    let field = |settings: MachineSettings| HeadTable::new(&settings).unwrap_err().quantity;
    for pivot_mm in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(field(MachineSettings { pivot_mm, ..settings }), Quantity::Pivot);
    }
    let error = HeadTable::new(&MachineSettings { direction_c: 0, ..settings }).unwrap_err();
    assert_eq!((error.quantity, error.axis), (Quantity::Direction, Some(trueaxis::Axis::C)));
    assert_eq!(field(MachineSettings { direction_a: 2, ..settings }), Quantity::Direction);
    let error = HeadTable::new(&MachineSettings { work_offset_mm: [0.0, f64::NAN, 0.0], ..settings }).unwrap_err();
    assert_eq!((error.quantity, error.index), (Quantity::WorkOffset, Some(1)));
}
