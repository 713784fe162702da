//! Selects the points of an artefact to touch, and where to approach them from.

use super::artefact::{Artefact, Kind};
use super::faces;
use super::grid::Grid;
use super::kinematics::Ideal;
use super::place::{self, Place, across};
use super::target::{CLEAR_ABOVE, Target, clear_mm};
use super::task::Task;
use trueaxis::machine::Axis;

/// Points nearer than this to the stem of a ball are skipped, degrees from the stem.
const STEM_DEG: f64 = 50.0;

pub(super) fn unit(axis: Axis) -> [f64; 3] {
    place::unit(axis.index() % 3)
}

fn moved(point: [f64; 3], along: [f64; 3], by: f64) -> [f64; 3] {
    std::array::from_fn(|k| point[k] + by * along[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// Touches of a place; with `check_only`, only the few that show whether it has moved.
pub(super) fn of_place(task: &Task, ideal: &Ideal, of: &Artefact, at: &Place, check_only: bool) -> Vec<Target> {
    let radius = task.probe.tip_radius_mm - task.probe.pre_travel_mm;
    let backlash = task.wanted.backlash && !check_only;
    match &of.kind {
        Kind::Ring { diameter_mm, points, arc_deg } => {
            ring(task, at, 0.5 * diameter_mm - radius, *points, *arc_deg, backlash)
        }
        Kind::Ball { diameter_mm, few } => {
            let poses = if check_only { &at.rotary_deg[..1] } else { &at.rotary_deg[..] };
            let [x, y, z] = at.at_mm;
            let workpiece = ideal.tip(&[x, y, z, 0.0, 0.0, 0.0]);
            let mut targets = Vec::new();
            for (feature, &[a, b, c]) in poses.iter().enumerate() {
                let position = ideal.reach(&[x, y, z, a, b, c], workpiece);
                let stem = ideal.turned(&position, [0.0, 0.0, -1.0]);
                let tool = ideal.tool(&position);
                let centre = [position[0], position[1], position[2]];
                let ball = BallAt { feature, centre, stem, tool, pose: [a, b, c], reach: 0.5 * diameter_mm + radius };
                targets.extend(ball.targets(task, check_only || *few, backlash && feature == 0 && poses.len() == 1));
            }
            targets
        }
        Kind::Plate { diameter_mm, balls_mm, few } => {
            let [first, second] = across(at.normal);
            let normal = unit(at.normal);
            let mut targets = Vec::new();
            for (feature, [a, b, c]) in balls_mm.iter().enumerate() {
                let centre = moved(moved(moved(at.at_mm, first, *a), second, *b), normal, *c);
                let stem = normal.map(|part| -part);
                let ball =
                    BallAt { feature, centre, stem, tool: normal, pose: [0.0; 3], reach: 0.5 * diameter_mm + radius };
                targets.extend(ball.targets(task, *few, backlash && feature == 0));
            }
            targets
        }
        Kind::Gauge { steps_mm } => {
            let (along, lift) = (row(at.along), unit(at.normal));
            let face = |(feature, step): (usize, &f64)| {
                let point = moved(at.at_mm, along, *step);
                line_target(task, feature, point, along, lift)
            };
            steps_mm.iter().enumerate().map(face).collect()
        }
        Kind::Square { arms_mm, points, .. } => square(task, at, *arms_mm, *points, radius),
        Kind::Grid(grid) => plate(task, grid, at, radius),
        Kind::Block(block) => faces::targets(task, block, at, radius),
        Kind::Dial(_) => Vec::new(),
    }
}

fn line_target(task: &Task, feature: usize, point: [f64; 3], approach: [f64; 3], lift: [f64; 3]) -> Target {
    let home = moved(moved(point, approach, -task.probe.approach_mm), lift, clear_mm(task) + CLEAR_ABOVE);
    let from_above = [false; 3];
    Target { feature, point, approach, from_above, home, entry: home, lift: Some(lift), pose: [0.0; 3] }
}

fn ring(task: &Task, at: &Place, reach: f64, points: usize, [from, to]: [f64; 2], backlash: bool) -> Vec<Target> {
    let [u, v] = across(at.normal);
    let normal = unit(at.normal);
    let whole = to - from >= 360.0;
    let steps = if whole { points } else { points - 1 };
    let radial = |deg: f64| {
        let (sin, cos) = deg.to_radians().sin_cos();
        // Exact along the axes, so that the other axis does not move.
        let clean = |part: f64| if part.abs() < 1e-12 { 0.0 } else { part };
        std::array::from_fn::<f64, 3, _>(|k| clean(cos) * u[k] + clean(sin) * v[k])
    };
    let target = |approach: [f64; 3], direction: [f64; 3], from_above: [bool; 3]| Target {
        feature: 0,
        point: moved(at.at_mm, direction, reach),
        approach,
        from_above,
        home: at.at_mm,
        entry: moved(at.at_mm, normal, clear_mm(task) + CLEAR_ABOVE),
        lift: None,
        pose: [0.0; 3],
    };
    let mut targets: Vec<Target> = (0..points)
        .map(|i| {
            let direction = radial(from + (to - from) * i as f64 / steps.max(1) as f64);
            target(direction, direction, [false; 3])
        })
        .collect();
    if backlash {
        // Oblique to the surface: one axis probes, and the other arrives from either side.
        let inside = |deg: &f64| (from..=to).contains(deg) || (from..=to).contains(&(deg - 360.0));
        for deg in [45.0, 135.0, 225.0, 315.0_f64].into_iter().filter(inside) {
            let direction = radial(deg);
            for probes in [u, v] {
                let other = if probes == u { v } else { u };
                let sense = dot(direction, probes).signum();
                let side = |above: bool| std::array::from_fn(|k| above && other[k] != 0.0);
                let approach = probes.map(|part| sense * part);
                targets.extend([false, true].map(|above| target(approach, direction, side(above))));
            }
        }
    }
    targets
}

/// Four touches of every ball or hole along the machine's axes.
fn plate(task: &Task, grid: &Grid, at: &Place, radius: f64) -> Vec<Target> {
    let normal = unit(at.normal);
    // Not from below, where the bottom of a hole or the plate is near.
    let from_above = normal.map(|part| part > 0.0);
    let of_ball = |feature: usize| {
        let centre = grid.centre(at, feature);
        if grid.holes {
            let at = Place { at_mm: centre, ..at.clone() };
            let around = ring(task, &at, 0.5 * grid.diameter_mm - radius, 4, [0.0, 360.0], false);
            return around.into_iter().map(|target| Target { feature, from_above, ..target }).collect::<Vec<_>>();
        }
        let (stem, reach) = (normal.map(|part| -part), 0.5 * grid.diameter_mm + radius);
        let ball = BallAt { feature, centre, stem, tool: normal, pose: [0.0; 3], reach };
        let mut around = ball.targets(task, true, false);
        // The height of a ball is not measured.
        around.retain(|target| dot(target.approach, normal).abs() < 0.5);
        around.into_iter().map(|target| Target { from_above, ..target }).collect()
    };
    (0..grid.count()).flat_map(of_ball).collect()
}

/// A ball in a pose of the machine.
struct BallAt {
    feature: usize,
    centre: [f64; 3],
    stem: [f64; 3],
    tool: [f64; 3],
    pose: [f64; 3],
    /// Sum of the radii of ball and tip.
    reach: f64,
}

impl BallAt {
    fn targets(&self, task: &Task, check_only: bool, backlash: bool) -> Vec<Target> {
        // Directions across the tool, along the machine's axes where possible.
        let up = self.tool.map(|part| if part.abs() < 1e-9 { 0.0 } else { part });
        let first = if up[0].abs() < 0.9 { unit(Axis::X) } else { unit(Axis::Y) };
        let along = dot(first, up);
        let first = normalised(std::array::from_fn(|k| first[k] - along * up[k]));
        let second = cross(up, first);
        let direction = |azimuth: f64, height: f64| {
            let ((s, c), (sh, ch)) = (azimuth.to_radians().sin_cos(), height.to_radians().sin_cos());
            let clean = |part: f64| if part.abs() < 1e-12 { 0.0 } else { part };
            normalised(std::array::from_fn(|k| {
                clean(clean(ch * c) * first[k] + clean(ch * s) * second[k] + clean(sh) * up[k])
            }))
        };
        let mut normals: Vec<[f64; 3]> = Vec::new();
        let around: &[f64] =
            if check_only { &[0.0, 90.0, 180.0, 270.0] } else { &[0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0] };
        normals.extend(around.iter().map(|azimuth| direction(*azimuth, 0.0)));
        if !check_only {
            normals.extend([45.0, 135.0, 225.0, 315.0].map(|azimuth| direction(azimuth, 45.0)));
        }
        normals.push(direction(0.0, 90.0));
        let free = |normal: &[f64; 3]| dot(*normal, self.stem) < STEM_DEG.to_radians().cos();
        let radial = normals
            .iter()
            .filter(|normal| free(normal))
            .map(|normal| self.target(task, *normal, normal.map(|part| -part), [false; 3]));
        let mut targets: Vec<Target> = radial.collect();
        if backlash && up.iter().filter(|part| **part != 0.0).count() == 1 {
            let [x, y, z] = [first, second, up];
            for (normal, probes, other) in [
                (direction(45.0, 0.0), x, y),
                (direction(45.0, 0.0), y, x),
                (direction(225.0, 0.0), x, y),
                (direction(225.0, 0.0), y, x),
                (direction(0.0, 45.0), x, z),
                (direction(180.0, 45.0), x, z),
                (direction(90.0, 45.0), y, z),
                (direction(270.0, 45.0), y, z),
            ] {
                let sense = -dot(normal, probes).signum();
                for above in [false, true] {
                    let side = std::array::from_fn(|k| above && other[k] != 0.0);
                    targets.push(self.target(task, normal, probes.map(|part| sense * part), side));
                }
            }
        }
        targets
    }

    fn target(&self, task: &Task, normal: [f64; 3], approach: [f64; 3], from_above: [bool; 3]) -> Target {
        let height = self.reach + task.probe.approach_mm + clear_mm(task);
        let home = moved(self.centre, self.tool, height);
        Target {
            feature: self.feature,
            point: moved(self.centre, normal, self.reach),
            approach: approach.map(|part| if part == 0.0 { 0.0 } else { part }),
            from_above,
            home,
            entry: home,
            lift: Some(self.tool),
            pose: self.pose,
        }
    }
}

fn normalised(vector: [f64; 3]) -> [f64; 3] {
    let length = dot(vector, vector).sqrt();
    vector.map(|part| part / length)
}

/// Both arms are touched from outside: the first along `at.along`, the second across it. Turned over, the first arm points
/// back.
fn square(task: &Task, at: &Place, [first_mm, second_mm]: [f64; 2], points: usize, radius: f64) -> Vec<Target> {
    let [u, v, lift] = square_directions(at);
    let sense = if at.reversed { -1.0 } else { 1.0 };
    let share = |i: usize| 0.05 + 0.9 * i as f64 / (points.max(2) - 1) as f64;
    let mut targets = Vec::new();
    for i in 0..points {
        let point = moved(moved(at.at_mm, u, sense * share(i) * first_mm), v, -radius);
        targets.push(line_target(task, 0, point, v, lift));
    }
    for i in 0..points {
        let point = moved(moved(at.at_mm, v, share(i) * second_mm), u, -sense * radius);
        targets.push(line_target(task, 1, point, u.map(|part| sense * part), lift));
    }
    targets
}

/// Direction of a row of faces or of a first arm; an upright one starts at its top, where a probe reaches it.
pub(super) fn row(along: Axis) -> [f64; 3] {
    if along == Axis::Z { [0.0, 0.0, -1.0] } else { unit(along) }
}

/// Directions of a square's arms before it is turned over, and its normal; an upright arm points down from the corner.
pub(super) fn square_directions(at: &Place) -> [[f64; 3]; 3] {
    let (u, lift) = (row(at.along), unit(at.normal));
    let v = cross(lift, u);
    // Avoids −0, which programs would print.
    let v = v.map(|part| if part == 0.0 { 0.0 } else { part });
    [u, if v[2] > 0.5 { [0.0, 0.0, -1.0] } else { v }, lift]
}
