//! The network of a task: its unknowns and their names, its touches on their surfaces.

use super::artefact::{Artefact, Kind};
use super::block::{ANGLES, Block};
use super::dial::{Dial, DialKind, Named};
use super::faces::{self, Sizes};
use super::grid::Grid;
use super::kinematics::Ideal;
use super::middles::{middle, middles, way};
use super::place::{Place, across};
use super::plan::{Plan, Planned};
use super::sheet::reading;
use super::stylus;
use super::task::Task;
use super::terms::{Pose, Terms, perfect};
use super::touches::{row, square_directions, unit};
use anyhow::Result;
use std::ops::Range;
use trueaxis::machine::AXES;
use trueaxis_metrology::calibration::{Network, Part, Surface, Touch, Unknown};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Cosine between the travel of a touch and the normal of its surface: within this of 1 it is touched at right angles, and
/// least one that counts.
const RIGHT: f64 = 1e-4;
const LEAST: f64 = 0.1;

/// A network with the meaning of its unknowns.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The network.
    pub network: Network,
    /// Index of the radius of every stylus' tip; that of the first is the network's.
    pub tips: Vec<usize>,
    /// The touch of the plan that each of the network belongs to: a plate's centre is that of two, the first of them.
    pub planned: Vec<usize>,
    /// The second touch of each centre.
    pub opposites: Vec<Option<usize>>,
    /// Name of every unknown.
    pub names: Vec<String>,
    /// The machine's terms.
    pub terms: Terms,
    /// Indices of every artefact's sizes: diameter, lengths, and angles as deviations from 90°, rad; empty for a step gauge.
    pub sizes: Vec<Vec<usize>>,
    /// Unknowns of artefacts that are angles, rad: among the sizes, and beside them slopes, turns and tapers of dials.
    pub angles: Vec<usize>,
    /// First of the tilts of the spindle about X and about Y, if dials show them.
    pub spindle: Option<usize>,
    /// Indices of the deviations of every artefact's balls (three each) or faces from its certificate, mm.
    pub deviations: Vec<Range<usize>>,
    /// Index of every artefact's overall length error; `None` if its uncertainty is not stated.
    pub lengths: Vec<Option<usize>>,
    /// First unknown of each place of every artefact; for a ball, the first coordinate of its centre.
    pub places: Vec<Vec<usize>>,
    /// Drift knots: time, s, and index of the first of three components; `None` for the first knot.
    pub knots: Vec<(f64, Option<usize>)>,
}

impl Observed {
    /// Whether an unknown is a term of the machine, the tip's radius or an artefact's size. The other unknowns are the
    /// positions of the artefacts, their deviations from their certificates, and the drift.
    pub(super) fn is_term_or_size(&self, index: usize) -> bool {
        let is_tilt = self.tilts().any(|tilt| tilt == index);
        is_tilt
            || index < self.network.terms
            || self.tips.contains(&index)
            || self.sizes.iter().any(|sizes| sizes.contains(&index))
    }
}

impl Observed {
    /// A quantity of the plan's touches, at those of the network: the mean of both touches of a centre.
    pub fn at_network(&self, of_touches: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let at = |touch: usize| of_touches.get(touch).copied().unwrap_or_default();
        let both = self.planned.iter().zip(&self.opposites);
        both.map(|(one, other)| other.map_or(at(*one), |other| middle(at(*one), at(other)))).collect()
    }

    /// The first touch of the plan that a touch of the network belongs to.
    pub(super) fn first(&self, touch: usize) -> usize {
        self.planned.get(touch).copied().unwrap_or(touch)
    }

    /// Numbers of the touches of the plan that a touch of the network belongs to, from 1.
    pub(super) fn numbers(&self, touch: usize) -> String {
        let number = self.first(touch) + 1;
        match self.opposites.get(touch).copied().flatten() {
            Some(opposite) => format!("{number} or {}", opposite + 1),
            None => number.to_string(),
        }
    }

    /// Indices of the tilts of the spindle, rad.
    pub fn tilts(&self) -> impl Iterator<Item = usize> + use<> {
        self.spindle.into_iter().flat_map(|first| [first, first + 1])
    }
}

struct Names {
    unknowns: Vec<Unknown>,
    names: Vec<String>,
}

impl Names {
    fn put(&mut self, name: String, start: f64, uncertainty: Option<f64>) -> usize {
        self.names.push(name);
        self.unknowns.push(Unknown { start, uncertainty });
        self.names.len() - 1
    }

    fn put_each(&mut self, all: Vec<Named>, named: impl Fn(String) -> String) {
        for (name, start, uncertainty) in all {
            self.put(named(name), start, uncertainty);
        }
    }

    fn put_all<const N: usize>(&mut self, names: [String; N], start: [f64; N], uncertainty: Option<f64>) -> usize {
        let first = self.names.len();
        names.into_iter().zip(start).for_each(|(name, start)| {
            self.put(name, start, uncertainty);
        });
        first
    }
}

/// Builds the network of a plan from the positions of its trips (X, Y, Z, A, B, C).
///
/// Tip positions include the errors in the machine's tables, unless the machine was compensated during probing: then they are
/// the commanded ones.
///
/// # Errors
/// A machine whose chain cannot be read.
pub fn observe(task: &Task, machine: &Machine, plan: &Plan, trips: &[[f64; AXES]]) -> Result<Observed> {
    observe_terms(task, machine, plan, trips, Terms::of(task, machine, plan.reach_mm(task)))
}

/// Like [`observe`], with terms other than those the task asks for.
///
/// # Errors
/// As [`observe`].
pub fn observe_terms(
    task: &Task,
    machine: &Machine,
    plan: &Plan,
    trips: &[[f64; AXES]],
    terms: Terms,
) -> Result<Observed> {
    let ideals = stylus::ideals(task, machine)?;
    let ideal = &ideals[0];
    let poses: Vec<Pose> = plan
        .touches
        .iter()
        .zip(trips)
        .map(|(touch, trip)| {
            let [x, y, z] = touch.reverse;
            Pose { position: ideal.ordered(trip), reverse: ideal.ordered(&[x, y, z, 0.0, 0.0, 0.0]) }
        })
        .collect();
    let known = if task.compensated { perfect(machine) } else { machine.clone() };
    let styli = task.stylus_lengths();
    let of_touch: Vec<usize> = plan.touches.iter().map(|touch| plan.stylus_of(task, touch)).collect();
    let mut tip_mm = vec![[0.0; 3]; poses.len()];
    let mut responses: Vec<Vec<[f64; 3]>> = vec![Vec::new(); poses.len()];
    for (index, stylus) in styli.iter().enumerate() {
        let own: Vec<usize> = (0..poses.len()).filter(|touch| of_touch[*touch] == index).collect();
        let own_poses: Vec<Pose> = own.iter().map(|touch| poses[*touch]).collect();
        let geometry = Geometry::new(&stylus::with_stylus(&known, *stylus), 0.0)?;
        let all = terms.responses(&stylus::with_stylus(machine, *stylus), &own_poses)?;
        for ((touch, pose), response) in own.into_iter().zip(&own_poses).zip(all) {
            tip_mm[touch] = geometry.actual_pose(&pose.position, &pose.reverse).tip_mm;
            responses[touch] = response;
        }
    }

    let mut names = Names { unknowns: Vec::new(), names: Vec::new() };
    for term in &terms.terms {
        names.put(term.name(), 0.0, term.range(&task.wanted));
    }
    let radius = task.probe.tip_radius_mm - task.probe.pre_travel_mm;
    let tip = names.put("radius of the tip".into(), radius, task.probe.tip_uncertainty_mm);
    let mut tips = vec![tip];
    for stylus in &styli[1..] {
        let name = format!("radius of the tip{}", stylus::words(*stylus));
        tips.push(names.put(name, radius, task.probe.tip_uncertainty_mm));
    }
    let artefacts = Artefacts::new(task, &ideals, &mut names);
    let knots = knots(task, plan, &mut names);
    let own_knots = |stylus: usize| knots.iter().filter(move |knot| knot.stylus == stylus);
    let knots_of: Vec<Vec<Knot>> = (0..styli.len()).map(|stylus| own_knots(stylus).copied().collect()).collect();
    let is_reference = |touch: &Planned| plan.visits.get(touch.visit).is_some_and(|visit| visit.reference);
    let nominal = plan.nominal(&task.probe);
    let unknowns = &names.unknowns;
    let touches = plan.touches.iter().zip(&nominal).zip(tip_mm).zip(responses).zip(&of_touch).map(
        |((((touch, nominal), tip_mm), response), &stylus)| {
            let surface = artefacts.surface(task, touch, is_reference(touch).then_some(stylus));
            let tip = |position: &[f64; AXES]| ideals[stylus].tip(position);
            let weight = along_travel(&surface, unknowns, tip(nominal), [&touch.start, &touch.end].map(tip));
            Touch {
                tip_mm: {
                    let contact = contact(task, touch);
                    std::array::from_fn(|k| tip_mm[k] + contact[k])
                },
                surface,
                response,
                drift: between(&knots_of[stylus], touch.time_s),
                own_tip: (stylus > 0).then(|| tips[stylus]),
                weight,
            }
        },
    );
    let (touches, planned, opposites) = middles(plan, touches.collect());
    let network = Network {
        touches,
        terms: terms.terms.len(),
        tip,
        repeatability_mm: task.probe.repeatability_mm,
        unknowns: names.unknowns,
    };
    let Artefacts { sizes, angles, own: deviations, lengths, places, spindle, .. } = artefacts;
    Ok(Observed {
        network,
        tips,
        planned,
        opposites,
        names: names.names,
        terms,
        sizes,
        angles,
        spindle,
        deviations,
        lengths,
        places,
        knots: knots.iter().map(|knot| (knot.time_s, knot.first)).collect(),
    })
}

/// Way along the travel of a planned touch for a way of 1 across the surface.
fn along_travel(surface: &Surface, unknowns: &[Unknown], at: [f64; 3], [from, to]: [[f64; 3]; 2]) -> f64 {
    let start = |index: usize| unknowns.get(index).map_or(0.0, |unknown| unknown.start);
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let normal: [f64; 3] = match surface {
        Surface::Ball { origin, offset, .. } => std::array::from_fn(|k| at[k] - start(origin + k) - offset[k]),
        Surface::Bore { centre, plane, .. } => {
            let from = [0, 1].map(|k| dot(at, plane[k]) - start(centre + k));
            std::array::from_fn(|k| from[0] * plane[0][k] + from[1] * plane[1][k])
        }
        Surface::Face { normal, .. } => *normal,
        Surface::Centre(_) => return 1.0,
    };
    let travel = std::array::from_fn(|k| to[k] - from[k]);
    let cosine = dot(normal, travel).abs() / (dot(normal, normal) * dot(travel, travel)).sqrt();
    // Exactly 1 at right angles, for a reading of a dial, which does not travel, too.
    if cosine < 1.0 - RIGHT { 1.0 / cosine.max(LEAST) } else { 1.0 }
}

/// A visit to the reference.
#[derive(Clone, Copy)]
struct Knot {
    time_s: f64,
    /// Index of the first of three components; `None` at the first visit with a stylus.
    first: Option<usize>,
    stylus: usize,
}

/// Drift knots, one in the middle of every visit to the reference. With every stylus the reference is at another place, so
/// that the drift counts from the first visit with it.
fn knots(task: &Task, plan: &Plan, names: &mut Names) -> Vec<Knot> {
    if task.reference.is_none() {
        return Vec::new();
    }
    let visits = plan.visits.iter().enumerate().filter(|(_, visit)| visit.reference);
    let times = visits.filter_map(|(index, _)| {
        let own = || plan.touches.iter().filter(|touch| touch.visit == index).map(|touch| touch.time_s);
        let count = own().count();
        (count > 0).then(|| (own().sum::<f64>() / count as f64, task.stylus_of(plan.visits[index].set_up)))
    });
    let mut seen: Vec<usize> = Vec::new();
    times
        .enumerate()
        .map(|(knot, (time_s, stylus))| {
            let name = |axis: char| format!("drift of {axis} at visit {} of the reference", knot + 1);
            let is_first = !seen.contains(&stylus);
            seen.push(stylus);
            let first = (!is_first).then(|| names.put_all(['X', 'Y', 'Z'].map(name), [0.0; 3], None));
            Knot { time_s, first, stylus }
        })
        .collect()
}

/// Interpolation weights of the knots at a time.
fn between(knots: &[Knot], time: f64) -> Vec<(usize, f64)> {
    let right = knots.partition_point(|knot| knot.time_s <= time);
    let at = |index: usize| knots.get(index).map(|knot| (knot.time_s, knot.first));
    let weighted = match (right.checked_sub(1).and_then(at), at(right)) {
        (Some((from, a)), Some((to, b))) => {
            let share = (time - from) / (to - from);
            [a.map(|index| (index, 1.0 - share)), b.map(|index| (index, share))]
        }
        (Some((_, edge)), None) | (None, Some((_, edge))) => [edge.map(|index| (index, 1.0)), None],
        (None, None) => [None, None],
    };
    weighted.into_iter().flatten().filter(|(_, weight)| *weight != 0.0).collect()
}

/// Indices of the artefacts' unknowns.
#[derive(Default)]
struct Artefacts {
    sizes: Vec<Vec<usize>>,
    angles: Vec<usize>,
    /// Unknowns of each artefact that is a block; empty for the others.
    blocks: Vec<Sizes>,
    /// First of the tilts of the spindle.
    spindle: Option<usize>,
    /// Deviations of a plate's balls (three each) or of a gauge's faces.
    own: Vec<Range<usize>>,
    /// Length error common to a whole plate or gauge, 1.
    lengths: Vec<Option<usize>>,
    /// First unknown of every place.
    places: Vec<Vec<usize>>,
    /// First coordinate of the reference with every stylus.
    reference: Vec<usize>,
}

impl Artefacts {
    fn new(task: &Task, ideals: &[Ideal], names: &mut Names) -> Artefacts {
        let styli = task.stylus_lengths();
        let mut all = Artefacts::default();
        if task.artefacts.iter().filter_map(Artefact::dial).any(Dial::shows_spindle) {
            let tilt = ["X", "Y"].map(|axis| format!("tilt of the spindle about {axis}"));
            all.spindle = Some(names.put_all(tilt, [0.0; 2], None));
        }
        for artefact in &task.artefacts {
            all.put_sizes(artefact, names);
            let mut places = Vec::new();
            if let Some(dial) = artefact.dial() {
                for placement in 0..dial.placements {
                    let first = names.names.len();
                    places.push(first);
                    all.angles.extend(dial.place_angles().map(|angle| first + angle));
                    let at = |what| format!("{what} of {}, placement {}", artefact.name, placement + 1);
                    names.put_each(dial.place_unknowns(placement), at);
                }
            }
            let ideal_of = |place: &Place| {
                let own = styli.iter().position(|stylus| *stylus == place.stylus_mm);
                &ideals[own.unwrap_or(0)]
            };
            let of_place =
                |(index, place): (usize, &Place)| put_place(task, ideal_of(place), artefact, (index, place), names);
            places.extend(artefact.places.iter().enumerate().filter_map(of_place));
            all.places.push(places);
        }
        if let Some(reference) = &task.reference {
            let (ball, own) = (&task.artefacts[reference.artefact], all.places[reference.artefact][0]);
            let start: [f64; 3] = std::array::from_fn(|k| names.unknowns[own + k].start);
            for stylus in &styli {
                let at = |axis: char| format!("centre {axis} of {}{}", ball.name, stylus::words(*stylus));
                let is_own = *stylus == ball.places[0].stylus_mm;
                all.reference.push(if is_own { own } else { names.put_all(['X', 'Y', 'Z'].map(at), start, None) });
            }
        }
        all
    }

    /// Puts the unknowns of an artefact itself.
    fn put_sizes(&mut self, artefact: &Artefact, names: &mut Names) {
        let (name, uncertainty) = (&artefact.name, artefact.uncertainty);
        let mut own = 0..0;
        let mut block = Sizes::default();
        let sizes = match &artefact.kind {
            Kind::Ring { diameter_mm, .. } | Kind::Ball { diameter_mm, .. } => {
                vec![names.put(format!("diameter of {name}"), *diameter_mm, uncertainty)]
            }
            Kind::Plate { diameter_mm, balls_mm, .. } => {
                let size = names.put(format!("diameter of the balls of {name}"), *diameter_mm, uncertainty);
                own = names.names.len()..names.names.len() + 3 * balls_mm.len();
                for ball in 1..=balls_mm.len() {
                    let of = |axis: u8| format!("place {axis} of ball {ball} of {name}");
                    names.put_all([1, 2, 3].map(of), [0.0; 3], uncertainty);
                }
                vec![size]
            }
            Kind::Gauge { steps_mm } => {
                own = names.names.len()..names.names.len() + steps_mm.len();
                for face in 1..=steps_mm.len() {
                    names.put(format!("face {face} of {name}"), 0.0, uncertainty);
                }
                vec![]
            }
            Kind::Square { angle_deg, .. } => {
                let away = (angle_deg - 90.0).to_radians();
                let angle = names.put(format!("angle of {name}"), away, uncertainty);
                self.angles.push(angle);
                vec![angle]
            }
            Kind::Block(of) => {
                block = block_sizes(of, artefact, &self.blocks, names);
                self.angles.extend(&block.angles);
                block.lengths.iter().chain(&block.angles).copied().collect()
            }
            Kind::Grid(grid) => put_places(grid, name, names),
            Kind::Dial(dial) => {
                let start = names.names.len();
                names.put_each(dial.own_unknowns(name), |what| what);
                if !matches!(dial.kind, DialKind::Straightness { .. }) {
                    self.angles.extend(start..names.names.len());
                }
                if let DialKind::Squareness { .. } = dial.kind {
                    vec![start]
                } else {
                    own = start..names.names.len();
                    vec![]
                }
            }
        };
        self.sizes.push(sizes);
        self.blocks.push(block);
        self.own.push(own);
        let what = if matches!(artefact.kind, Kind::Block(_)) { "elongation" } else { "length" };
        let longer = |uncertainty| names.put(format!("{what} of {name}"), 0.0, Some(uncertainty));
        self.lengths.push(match artefact.grid().map(Grid::elongation) {
            Some((start, uncertainty)) => Some(names.put(format!("length of {name}"), start, uncertainty)),
            None => artefact.length_uncertainty.map(longer),
        });
    }

    /// `reference`: the stylus that the reference is touched with.
    fn surface(&self, task: &Task, touch: &Planned, reference: Option<usize>) -> Surface {
        let Planned { artefact, place, feature, .. } = *touch;
        if let Some((dial, reading)) = reading(task, touch) {
            let own = self.sizes[artefact].first().copied().unwrap_or(self.own[artefact].start);
            let spindle = self.spindle.unwrap_or_default();
            return dial.surface(reading, own, (self.places[artefact][place], spindle));
        }
        let (of, at) = (&task.artefacts[artefact], &task.artefacts[artefact].places[place]);
        let of_reference = reference.and_then(|stylus| self.reference.get(stylus).copied());
        let first = of_reference.unwrap_or(self.places[artefact][place]);
        let (size, own) = (self.sizes[artefact].first().copied().unwrap_or_default(), self.own[artefact].start);
        match &of.kind {
            Kind::Ring { .. } => Surface::Bore { diameter: size, centre: first, plane: across(at.normal) },
            Kind::Ball { .. } => {
                Surface::Ball { diameter: size, origin: first, offset: [0.0; 3], turn: None, own: None, length: None }
            }
            Kind::Plate { balls_mm, .. } => {
                let [u, v] = across(at.normal);
                let normal = unit(at.normal);
                let [a, b, c] = balls_mm.get(feature).copied().unwrap_or_default();
                let offset = std::array::from_fn(|k| a * u[k] + b * v[k] + c * normal[k]);
                // A ball is off its place along the plate's directions, which lie along other axes when the plate stands.
                let along = |k: usize| [u, v, normal].iter().position(|direction| direction[k] != 0.0).unwrap_or(k);
                let own = Some([0, 1, 2].map(|k| own + 3 * feature + along(k)));
                let length = self.lengths[artefact];
                Surface::Ball { diameter: size, origin: first, offset, turn: Some(first + 3), own, length }
            }
            Kind::Gauge { steps_mm } => {
                let known_mm = steps_mm.get(feature).copied().unwrap_or_default();
                let part = |unknown, factor| Part { unknown, factor, along: None };
                let mut parts = vec![part(first, 1.0), part(own + feature, 1.0)];
                parts.extend(self.lengths[artefact].map(|length| part(length, known_mm)));
                Surface::Face { normal: row(at.along), outward: -1.0, known_mm, parts }
            }
            Kind::Square { .. } => {
                let [u, v, _] = square_directions(at);
                let sense = if at.reversed { -1.0 } else { 1.0 };
                let part = |unknown, factor, along| Part { unknown, factor, along };
                if feature == 0 {
                    let parts = vec![part(first, 1.0, None), part(first + 2, 1.0, Some(u))];
                    Surface::Face { normal: v, outward: -1.0, known_mm: 0.0, parts }
                } else {
                    let turned = part(first + 2, -1.0, Some(v));
                    let parts = vec![part(first + 1, 1.0, None), turned, part(size, -sense, Some(v))];
                    Surface::Face { normal: u, outward: -sense, known_mm: 0.0, parts }
                }
            }
            Kind::Grid(grid) => {
                let length = self.lengths[artefact].unwrap_or_default();
                grid.surface(at, feature, way(touch), [size, first, length])
            }
            // Returned above: it has no places.
            Kind::Dial(_) => Surface::Face { normal: [0.0; 3], outward: 1.0, known_mm: 0.0, parts: Vec::new() },
            Kind::Block(block) => {
                faces::surface(block, at, feature, &self.blocks[artefact], (first, self.lengths[artefact]))
            }
        }
    }
}

/// Puts the unknowns of a place of an artefact; the first of them.
fn put_place(
    task: &Task,
    ideal: &Ideal,
    artefact: &Artefact,
    (index, place): (usize, &Place),
    names: &mut Names,
) -> Option<usize> {
    let at = |what: &str| format!("{what} of {}, place {}", artefact.name, index + 1);
    let [x, y, z] = place.at_mm;
    let tip = ideal.tip(&[x, y, z, 0.0, 0.0, 0.0]);
    let along = |direction: [f64; 3]| (0..3).map(|k| direction[k] * tip[k]).sum::<f64>();
    Some(match &artefact.kind {
        Kind::Ring { .. } => {
            let centre = across(place.normal).map(along);
            names.put_all(["first centre", "second centre"].map(at), centre, None)
        }
        Kind::Ball { .. } => names.put_all(["centre X", "centre Y", "centre Z"].map(at), tip, None),
        Kind::Plate { .. } => {
            let first = names.put_all(["origin X", "origin Y", "origin Z"].map(at), tip, None);
            names.put_all(["turn about X", "turn about Y", "turn about Z"].map(at), [0.0; 3], None);
            first
        }
        Kind::Gauge { .. } => {
            let direction = row(place.along);
            names.put(at("origin"), along(direction) + task.probe.tip_radius_mm, None)
        }
        Kind::Square { .. } => {
            let [u, v, _] = square_directions(place);
            names.put_all(["first face", "second face", "turn"].map(at), [along(v), along(u), 0.0], None)
        }
        Kind::Block(block) => {
            let radius = task.probe.tip_radius_mm;
            let first = names.names.len();
            for (what, start) in faces::place_unknowns(block, place, tip, radius) {
                names.put(at(&what), start, None);
            }
            first
        }
        Kind::Grid(_) => {
            let [first, second] = Grid::origin(place, tip);
            names.put_all(["first coordinate", "second coordinate", "turn"].map(at), [first, second, 0.0], None)
        }
        Kind::Dial(_) => return None,
    })
}

/// Puts the deviations of a plate's balls or holes from their nominal places.
fn put_places(grid: &Grid, plate: &str, names: &mut Names) -> Vec<usize> {
    let mut all = Vec::new();
    for ball in grid.deviating() {
        for direction in ["columns", "rows"] {
            let what = format!("{} off its place along the {direction}", grid.name(ball, plate));
            all.push(names.put(what, 0.0, None));
        }
    }
    all
}

/// Contact of a dial relative to the tool.
fn contact(task: &Task, touch: &Planned) -> [f64; 3] {
    reading(task, touch).map_or([0.0; 3], |(dial, reading)| dial.contact(reading))
}

/// Puts the lengths and angles of a block; a block that is the same as another one has the other's lengths.
fn block_sizes(of: &Block, artefact: &Artefact, before: &[Sizes], names: &mut Names) -> Sizes {
    let name = &artefact.name;
    let mut sizes = Sizes::default();
    match of.like {
        Some((other, difference)) => {
            sizes.lengths.clone_from(&before[other].lengths);
            for index in 0..of.measured {
                let what = format!("difference of {}", of.length_name(index, name));
                sizes.differences.push(names.put(what, 0.0, Some(difference)));
            }
        }
        None => {
            for (index, mm) in of.size_mm.iter().enumerate().take(of.measured) {
                sizes.lengths.push(names.put(of.length_name(index, name), *mm, artefact.uncertainty));
            }
        }
    }
    if of.measured == 3 {
        for [i, j] in ANGLES {
            let what = format!("angle {}-{} of {name}", i + 1, j + 1);
            sizes.angles.push(names.put(what, 0.0, of.angles));
        }
    }
    sizes
}
