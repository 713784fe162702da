//! Error terms of a machine that touches can determine.

use super::artefact::Kind;
use super::block::directions;
use super::dial::{Dial, DialKind, normal};
use super::shapes;
use super::task::{Task, Wanted};
use trueaxis::machine::{AXES, Axis, Row, Twist};
use trueaxis_tables::exact::{Geometry, GeometryError};
use trueaxis_tables::{Machine, Table};

/// An error term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// C0Y, B0Z, A0Z as 0, 1, 2; rad.
    Squareness(u8),
    /// A polynomial for an axis' error. In direction 0, 1 or 2 degree 1 is the scale (1), others mm; about direction 0, 1 or 2
    /// (component 3 to 5) every degree is rad.
    Curve {
        /// The axis.
        axis: Axis,
        /// Component of the error.
        component: u8,
        /// Degree.
        degree: u8,
    },
    /// Backlash, mm.
    Backlash(Axis),
    /// A location error of a rotary axis, component 0 to 5; mm or rad.
    Location(Axis, u8),
}

const SQUARENESS: [&str; 3] = ["C0Y", "B0Z", "A0Z"];
/// Normals of the planes, in the order of [`SQUARENESS`].
const PLANES: [Axis; 3] = [Axis::Z, Axis::Y, Axis::X];
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

impl Term {
    /// Name of the term in sentences.
    pub fn name(self) -> String {
        match self {
            Term::Squareness(which) => format!("squareness {}", SQUARENESS[usize::from(which) % 3]),
            Term::Curve { axis, component, degree: 1 } if usize::from(component) == axis.index() => {
                format!("scale of {}", axis.letter())
            }
            Term::Curve { axis, component, degree: 0 } if usize::from(component) == axis.index() => {
                format!("offset of {}", axis.letter())
            }
            Term::Curve { axis, component, degree } => {
                let direction = Axis::ALL[usize::from(component) % AXES].letter();
                format!("E{direction}{} of degree {degree}", axis.letter())
            }
            Term::Backlash(axis) => format!("backlash of {}", axis.letter()),
            Term::Location(axis, component) => {
                format!("E{}0{}", Axis::ALL[usize::from(component) % AXES].letter(), axis.letter())
            }
        }
    }

    /// Unit of the value in documents, and the factor that converts to it.
    pub fn unit(self) -> (&'static str, f64) {
        match self {
            Term::Squareness(_) => ("µrad", 1e6),
            Term::Curve { axis, component, degree: 1 } if usize::from(component) == axis.index() => ("ppm", 1e6),
            Term::Backlash(_) => ("µm", 1e3),
            Term::Curve { component, .. } | Term::Location(_, component) => {
                if component < 3 {
                    ("µm", 1e3)
                } else {
                    ("µrad", 1e6)
                }
            }
        }
    }

    /// Axis and component of a curve.
    pub(super) fn curve_of(self) -> Option<(Axis, u8)> {
        match self {
            Term::Curve { axis, component, .. } => Some((axis, component)),
            _ => None,
        }
    }

    /// Name of a curve of several degrees, `EYX`; `None` for a scale or an offset and what is no curve.
    pub(super) fn curve_name(self) -> Option<String> {
        match self {
            Term::Curve { axis, component, degree } if degree > 1 || usize::from(component) != axis.index() => {
                Some(format!("E{}{}", Axis::ALL[usize::from(component) % AXES].letter(), axis.letter()))
            }
            _ => None,
        }
    }

    /// Whether the term is an angular error of a linear axis.
    pub fn is_angle(self) -> bool {
        matches!(self, Term::Curve { component: 3.., .. })
    }

    /// Standard deviation of the term before anything is measured; `None` if it is free.
    pub(super) fn range(self, wanted: &Wanted) -> Option<f64> {
        match self {
            Term::Curve { component: 3.., .. } => Some(wanted.angle_range),
            Term::Curve { degree: 2.., .. } => wanted.curve_range,
            _ => None,
        }
    }

    /// Step of the term for computing its effect.
    fn step(self) -> f64 {
        match self {
            Term::Squareness(_) | Term::Curve { degree: 1, .. } | Term::Curve { component: 3.., .. } => 1e-5,
            Term::Curve { .. } | Term::Backlash(_) => 1e-3,
            Term::Location(_, component) => {
                if component < 3 {
                    1e-3
                } else {
                    1e-5
                }
            }
        }
    }
}

/// All terms of a task, and the range of each linear axis that it touches.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// The terms.
    pub terms: Vec<Term>,
    /// Lowest and highest positions touched on X, Y, Z, mm.
    pub reach_mm: [[f64; 2]; 3],
    /// Where the curves are zero: 0 if the travel contains it.
    pub zero_mm: [f64; 3],
    /// Travel, mm.
    pub travel_mm: [[f64; 2]; 3],
    /// Positions between which the curves of X, Y and Z of degree 2 and above are linear; empty for polynomials.
    pub knots_mm: [Vec<f64>; 3],
}

impl Terms {
    /// The terms that a task's artefacts determine on a machine. `reach_mm`: lowest and highest position of X, Y, Z touched.
    pub fn of(task: &Task, machine: &Machine, reach_mm: [[f64; 2]; 3]) -> Terms {
        let knots_mm = knots(task);
        Terms { knots_mm: knots_mm.clone(), ..Terms::named(spanned(task, machine, &knots_mm), machine, reach_mm) }
    }

    /// The given terms. `reach_mm`: lowest and highest position of X, Y, Z touched.
    pub fn named(terms: Vec<Term>, machine: &Machine, reach_mm: [[f64; 2]; 3]) -> Terms {
        let own = |axis: Axis| machine.settings.axis(axis);
        let travel_mm = LINEAR.map(|axis| own(axis).map_or([0.0; 2], |own| own.travel));
        let zero_mm = travel_mm.map(|[low, high]| 0.0_f64.clamp(low, high.max(low)));
        Terms { terms, reach_mm, zero_mm, travel_mm, knots_mm: Default::default() }
    }
    /// Value of a unit curve at a position, mm or rad (for the scale, mm per 1); degree 0 is constant.
    ///
    /// Legendre polynomials over the touched range, extended with their slope beyond it; with knots, piecewise linear shapes
    /// without their least-squares line, constant beyond the knots. Zero at [`Terms::zero_mm`].
    pub fn curve(&self, axis: Axis, component: u8, degree: u8, position: f64) -> f64 {
        let k = axis.index() % 3;
        if degree == 0 {
            return 1.0;
        }
        let is_angle = component >= 3;
        if degree == 1 && !is_angle {
            return position - self.zero_mm[k];
        }
        let knots = &self.knots_mm[k];
        if !knots.is_empty() && !is_angle {
            let values = shapes::shape(knots, usize::from(degree));
            return shapes::at(knots, &values, position) - shapes::at(knots, &values, self.zero_mm[k]);
        }
        let [low, high] = self.reach_mm[k];
        let half = (0.5 * (high - low)).max(1e-3);
        let value = |q: f64| {
            let t = (q - 0.5 * (low + high)) / half;
            let inside = t.clamp(-1.0, 1.0);
            let [p, slope] = legendre(degree, inside);
            p + slope * (t - inside)
        };
        value(position) - value(self.zero_mm[k])
    }

    /// Errors of an axis from its curves and the values of all terms: EX to EC, mm and rad.
    pub fn error(&self, values: &[f64], axis: Axis, position: f64) -> Twist {
        let mut error = [0.0; 6];
        for (term, value) in self.terms.iter().zip(values) {
            if let Term::Curve { axis: of, component, degree } = *term
                && of == axis
                && let Some(error) = error.get_mut(usize::from(component))
            {
                *error += value * self.curve(axis, component, degree, position);
            }
        }
        error
    }

    /// Positions at which the curves of an axis are tabulated: `count` equal steps, or the knots and the ends of the travel.
    pub fn grid(&self, axis: Axis, count: usize) -> Vec<f64> {
        let [low, high] = self.travel_mm[axis.index() % 3];
        let knots = &self.knots_mm[axis.index() % 3];
        let all: Vec<f64> = if knots.is_empty() {
            (0..=count).map(|i| low + (high - low) * i as f64 / count as f64).collect()
        } else {
            [low].into_iter().chain(knots.iter().copied().filter(|q| (low..=high).contains(q))).chain([high]).collect()
        };
        // Rounded to a micrometre to keep the table readable.
        let mut all: Vec<f64> = all.into_iter().map(|q| (q * 1e3).round() / 1e3).collect();
        all.dedup();
        all
    }

    /// Tip displacement per unit of every term, in workpiece coordinates, for poses of the axes (in the machine's order) with
    /// their directions of travel.
    ///
    /// Computed by exact transforms of a machine without other errors.
    ///
    /// # Errors
    /// A machine whose chain cannot be read.
    pub fn responses(&self, machine: &Machine, poses: &[Pose]) -> Result<Vec<Vec<[f64; 3]>>, GeometryError> {
        let perfect = perfect(machine);
        let base = Geometry::new(&perfect, 0.0)?;
        let at = |geometry: &Geometry, pose: &Pose| geometry.actual_pose(&pose.position, &pose.reverse).tip_mm;
        let ideal: Vec<[f64; 3]> = poses.iter().map(|pose| at(&base, pose)).collect();
        let mut responses = vec![Vec::with_capacity(self.terms.len()); poses.len()];
        for term in &self.terms {
            let step = term.step();
            let geometry = Geometry::new(&self.with(&perfect, *term, step), 0.0)?;
            for ((pose, ideal), response) in poses.iter().zip(&ideal).zip(&mut responses) {
                let moved = at(&geometry, pose);
                response.push(std::array::from_fn(|k| (moved[k] - ideal[k]) / step));
            }
        }
        Ok(responses)
    }

    /// The machine with one term of the given size added.
    fn with(&self, machine: &Machine, term: Term, size: f64) -> Machine {
        let mut machine = machine.clone();
        match term {
            Term::Squareness(0) => machine.settings.location.c0y += size,
            Term::Squareness(1) => machine.settings.location.b0z += size,
            Term::Squareness(_) => machine.settings.location.a0z += size,
            Term::Location(axis, component) => {
                let rotary = &mut machine.settings.location.rotary;
                if let Some(error) = rotary[axis.index() % 3].get_mut(usize::from(component)) {
                    *error += size;
                }
            }
            Term::Backlash(axis) => {
                if let Some(own) = machine.settings.axes.iter_mut().find(|own| own.axis == axis) {
                    own.backlash += size;
                }
            }
            Term::Curve { axis, component, degree } => {
                let rows: Vec<Row> = self
                    .grid(axis, 256)
                    .into_iter()
                    .map(|position| {
                        let mut errors = [0.0; 6];
                        errors[usize::from(component) % AXES] = size * self.curve(axis, component, degree, position);
                        Row { position, forward: errors, reverse: errors }
                    })
                    .collect();
                let table = Table { given: [true; 6], bidirectional: false, rows };
                let slot = machine.settings.axes.iter().position(|own| own.axis == axis);
                if let Some(to) = slot.and_then(|slot| machine.tables.get_mut(slot)) {
                    *to = Some(table);
                }
            }
        }
        machine
    }
}

/// Positions along X, Y and Z of the balls of a plate of unknown places; empty without one.
fn knots(task: &Task) -> [Vec<f64>; 3] {
    let plate = task.plate();
    let lines = |axis: usize| plate.and_then(|plate| Some(plate.grid()?.lines(&plate.places, axis)));
    std::array::from_fn(|axis| lines(axis).unwrap_or_default())
}

/// The terms that a task's artefacts determine on a machine.
fn spanned(task: &Task, machine: &Machine, knots: &[Vec<f64>; 3]) -> Vec<Term> {
    let wanted = task.wanted;
    // As many shapes as there are knots, with constant and line.
    let most = |axis: Axis, degree: usize| {
        let knots = &knots[axis.index() % 3];
        if knots.is_empty() { degree } else { degree.min(knots.len() - 1) }
    };
    let has = |axis: Axis| machine.settings.axes.iter().any(|own| own.axis == axis);
    // Sides: faces that are touched from both sides.
    let (mut planes, mut lines, mut sides) = ([false; 3], [false; 3], [false; 3]);
    for artefact in &task.artefacts {
        for place in &artefact.places {
            match artefact.kind {
                Kind::Ring { .. } | Kind::Plate { .. } | Kind::Square { .. } | Kind::Grid(_) => {
                    planes[place.normal.index() % 3] = true;
                }
                Kind::Gauge { .. } => lines[place.along.index() % 3] = true,
                Kind::Block(ref block) => {
                    let [axes, _] = directions(place);
                    for (pair, axis) in axes.into_iter().enumerate() {
                        let axis = axis as usize;
                        lines[axis] |= block.measures(place, pair);
                        sides[axis] |= pair < block.measured && axis != place.normal.index() % 3;
                        planes[axis] |= block.measured == 3;
                    }
                }
                Kind::Ball { .. } | Kind::Dial(_) => {}
            }
        }
    }
    let dials: Vec<&Dial> = task.artefacts.iter().filter_map(|artefact| artefact.dial()).collect();
    let mut squares = planes;
    for dial in &dials {
        if let DialKind::Squareness { arms, .. } = dial.kind {
            squares[normal(arms).index() % 3] = true;
        }
    }
    // The spindle's tilt to the table from its tram, and to Z from its test bar.
    let is_tram = |dial: &&Dial| matches!(dial.kind, DialKind::Tram { .. });
    if dials.iter().any(is_tram) && dials.iter().any(|dial| matches!(dial.kind, DialKind::Bar { .. })) {
        (squares[0], squares[1]) = (true, true);
    }
    let sized = |kind: &Kind| matches!(kind, Kind::Ring { .. } | Kind::Plate { .. } | Kind::Grid(_));
    // Whether a size along the axis is known.
    let spanned = |axis: Axis| {
        task.artefacts
            .iter()
            .any(|artefact| sized(&artefact.kind) && artefact.places.iter().any(|place| place.normal != axis))
    };
    let measured = |axis: Axis| has(axis) && (spanned(axis) || lines[axis.index() % 3]);
    let mut terms = Vec::new();
    if wanted.squareness {
        let spanned = PLANES.iter().enumerate().filter(|(_, normal)| squares[normal.index()]);
        terms.extend(spanned.map(|(which, _)| Term::Squareness(which as u8)));
    }
    for axis in LINEAR.into_iter().filter(|axis| measured(*axis)) {
        let degrees = usize::from(!wanted.scale) + 1..=most(axis, wanted.positioning);
        let component = axis.index() as u8;
        terms.extend(degrees.map(|degree| Term::Curve { axis, component, degree: degree as u8 }));
    }
    for axis in LINEAR {
        for other in LINEAR.into_iter().filter(|other| *other != axis) {
            let normal = LINEAR.into_iter().find(|normal| *normal != axis && *normal != other);
            let is_read = dials.iter().any(|dial| dial.reads_curve(axis.index(), other.index()));
            if is_read || normal.is_some_and(|normal| planes[normal.index()]) {
                let component = other.index() as u8;
                let degrees = 2..=most(axis, wanted.straightness);
                terms.extend(degrees.map(|degree| Term::Curve { axis, component, degree: degree as u8 }));
            }
        }
    }
    for axis in LINEAR.into_iter().filter(|axis| has(*axis)) {
        let all = (3..6).flat_map(|component| (1..=wanted.angle).map(move |degree| (component, degree)));
        terms.extend(all.map(|(component, degree)| Term::Curve { axis, component, degree: degree as u8 }));
    }
    if wanted.backlash {
        let round = task.artefacts.iter().any(|artefact| matches!(artefact.kind, Kind::Ball { .. }));
        let touched = |axis: &Axis| has(*axis) && (round || spanned(*axis) || sides[axis.index() % 3]);
        terms.extend(LINEAR.into_iter().filter(touched).map(Term::Backlash));
    }
    if wanted.rotary {
        let poses = || task.artefacts.iter().flat_map(|artefact| &artefact.places).flat_map(|place| &place.rotary_deg);
        for (index, axis) in [Axis::A, Axis::B, Axis::C].into_iter().enumerate() {
            let first = poses().next().map_or(0.0, |pose| pose[index]);
            if has(axis) && poses().any(|pose| pose[index] != first) {
                let across = (0..6).filter(|component| component % 3 != index as u8);
                terms.extend(across.map(|component| Term::Location(axis, component)));
            }
        }
    }
    terms
}

/// Positions of the machine's axes and their directions of travel (1: negative), in the machine's order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// mm and degrees.
    pub position: [f64; AXES],
    /// 0 or 1.
    pub reverse: [f64; AXES],
}

/// The machine without errors.
pub fn perfect(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    machine.settings.location = Default::default();
    machine.settings.periodic.clear();
    machine.tables.iter_mut().for_each(|table| *table = None);
    machine.grids.clear();
    for own in &mut machine.settings.axes {
        own.backlash = 0.0;
        own.thermal = Default::default();
    }
    machine
}

/// A Legendre polynomial and its derivative.
fn legendre(degree: u8, t: f64) -> [f64; 2] {
    let (mut before, mut now) = ([1.0, 0.0], [t, 1.0]);
    for n in 1..degree {
        let n = f64::from(n);
        let next = ((2.0 * n + 1.0) * t * now[0] - n * before[0]) / (n + 1.0);
        let slope = before[1] + (2.0 * n + 1.0) * now[0];
        (before, now) = (now, [next, slope]);
    }
    now
}
