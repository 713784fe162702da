//! The placements to choose from, with what each tells and how long it takes.

use super::room::{Extent, Range, is_beside, lacking, positions};
use super::turns::{patterns, turning};
use crate::calibrate::artefact::{Artefact, Kind};
use crate::calibrate::foreseen::planned;
use crate::calibrate::kinematics::Ideal;
use crate::calibrate::observed::observe_terms;
use crate::calibrate::place::Place;
use crate::calibrate::plan::Plan;
use crate::calibrate::stylus::{Stylus, moved, tool_mm, with_stylus};
use crate::calibrate::task::Task;
use crate::calibrate::terms::{Term, Terms, perfect};
use anyhow::Result;
use trueaxis::machine::{Axis, MachineSettings};
use trueaxis_metrology::calibration::Information;
use trueaxis_metrology::cores::*;
use trueaxis_tables::Machine;

/// Most placements that are compared.
const MOST: usize = 500;
/// Touches of the reference at a visit, and the share of its way by which a visit takes longer than a touch of its own.
const REFERENCE: f64 = 5.0;
const WAY: f64 = 1.2;
/// Ranges of a tip, mm, and of a size or an angle that are stated nowhere, mm or rad.
const TIP: f64 = 0.05;
const SIZE: f64 = 0.05;
/// Candidates worked on at once, between two reports of progress.
const PART: usize = 16;

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// A placement.
pub(super) struct Candidate {
    /// Index of the artefact.
    pub(super) artefact: usize,
    pub(super) place: Place,
    /// With setting up and the visits to the reference.
    pub(super) minutes: f64,
    /// About the terms, the tips and the sizes of all artefacts.
    pub(super) information: Information,
    /// For each term, whether a task with this placement has it among its unknowns.
    pub(super) spans: Vec<bool>,
}

impl Candidate {
    /// Direction in words.
    pub(super) fn facing(&self, task: &Task) -> String {
        let normal = self.place.normal.letter();
        match task.artefacts[self.artefact].kind {
            Kind::Ball { .. } if self.place.rotary_deg.len() > 1 => self.turns(),
            Kind::Ball { .. } => String::from("-"),
            Kind::Gauge { .. } => format!("{}, facing {normal}", self.place.along.letter()),
            Kind::Square { .. } => {
                let over = if self.place.reversed { ", turned over" } else { "" };
                format!("{}, facing {normal}{over}", self.place.along.letter())
            }
            _ => normal.to_string(),
        }
    }

    /// The poses of a ball in words.
    fn turns(&self) -> String {
        let poses = &self.place.rotary_deg;
        let does_turn = |k: &usize| poses.iter().any(|pose| pose[*k] != 0.0);
        let axes: String = (0..3).filter(does_turn).map(|k| ['A', 'B', 'C'][k]).collect();
        format!("{axes}, {} poses", poses.len())
    }
}

/// What is to be known.
pub(super) struct Known {
    pub(super) terms: Terms,
    pub(super) styli: Vec<Stylus>,
}

impl Known {
    /// All terms that the task asks for, over the whole travels.
    pub(super) fn new(task: &Task, machine: &Machine) -> Result<Known> {
        let mut styli: Vec<Stylus> = task.wishes.styli_mm.iter().copied().map(Some).collect();
        let of_places = task.artefacts.iter().flat_map(|of| &of.places).map(|place| place.stylus_mm);
        for stylus in of_places.chain(styli.is_empty().then_some(None)) {
            if !styli.contains(&stylus) {
                styli.push(stylus);
            }
        }
        let wanted = task.wanted;
        let mut terms: Vec<Term> = Vec::new();
        if wanted.squareness {
            terms.extend((0..3).map(Term::Squareness));
        }
        for axis in LINEAR {
            let own = axis.index() as u8;
            for component in 0..6_u8 {
                let degrees = match component {
                    3.. => 1..=wanted.angle,
                    _ if component == own => usize::from(!wanted.scale) + 1..=wanted.positioning,
                    _ => 2..=wanted.straightness,
                };
                terms.extend(degrees.map(|degree| Term::Curve { axis, component, degree: degree as u8 }));
            }
            if wanted.backlash {
                terms.push(Term::Backlash(axis));
            }
        }
        let travel = LINEAR.map(|axis| machine.settings.axis(axis).map_or([0.0; 2], |own| own.travel));
        let of_balls = Terms::of(task, machine, travel).terms;
        terms.extend(of_balls.into_iter().filter(|term| matches!(term, Term::Location(..))));
        for axis in turning(task, machine) {
            let across = (0..6).filter(|component| component % 3 != axis.index() as u8 % 3);
            let more: Vec<Term> = across.map(|component| Term::Location(axis, component)).collect();
            terms.extend(more.into_iter().filter(|term| !terms.contains(term)).collect::<Vec<_>>());
        }
        Ok(Known { terms: Terms::named(terms, machine, travel), styli })
    }

    /// The shortest of the styli, with which the free room is stated.
    pub(super) fn shortest(&self, settings: &MachineSettings) -> Stylus {
        let length = |stylus: &Stylus| tool_mm(settings, *stylus).map(|q| q * q).iter().sum::<f64>();
        self.styli.iter().copied().min_by(|one, other| length(one).total_cmp(&length(other))).flatten()
    }

    /// Standard deviation of a term before anything is measured.
    pub(super) fn range(&self, task: &Task, term: Term) -> f64 {
        let [squareness, scale, straightness, backlash] = task.wishes.ranges;
        match term {
            Term::Squareness(_) => squareness,
            Term::Curve { component: 3.., .. } => task.wanted.angle_range,
            Term::Curve { degree: 1, .. } => scale,
            Term::Curve { .. } => task.wanted.curve_range.unwrap_or(straightness),
            Term::Backlash(_) => backlash,
            Term::Location(_, 0..3) => 0.05,
            Term::Location(..) => 1e-4,
        }
    }
}

/// All placements.
pub(super) struct All {
    /// Those that the task states.
    pub(super) fixed: Vec<Candidate>,
    pub(super) fixed_minutes: f64,
    /// Those to choose from.
    pub(super) open: Vec<Candidate>,
    /// What is known before anything is measured.
    pub(super) prior: Information,
}

/// What a placement tells, before the tips and sizes have their places in the whole.
struct Told {
    artefact: usize,
    place: Place,
    minutes: f64,
    local: Information,
    spans: Vec<bool>,
    /// Ranges of the sizes, which follow the terms and the tip.
    sizes: Vec<f64>,
}

/// # Errors
/// An artefact that fits nowhere, or of a kind that is not placed.
pub(super) fn candidates(task: &Task, machine: &Machine, known: &Known, progress: &mut dyn FnMut(f64)) -> Result<All> {
    let nominal = perfect(machine);
    let work = Work { task, machine: &nominal, known, reference_minutes: 0.0 };
    let reference = task.reference.as_ref().map(|reference| {
        let place = &task.artefacts[reference.artefact].places[0];
        let plan = Plan::new(&work.alone(reference.artefact, place), &nominal)?;
        Ok::<_, anyhow::Error>(
            WAY * plan.minutes() * (REFERENCE * task.probe.repeats as f64 / plan.touches.len() as f64).min(1.0),
        )
    });
    let work = Work { reference_minutes: reference.transpose()?.unwrap_or(0.0), ..work };
    let mut fixed = Vec::new();
    for (artefact, of) in task.artefacts.iter().enumerate() {
        for place in &of.places {
            fixed.push(work.told(artefact, place)?);
        }
    }
    let places = work.places()?;
    let mut open: Vec<Told> = Vec::new();
    let mut refused = None;
    for (part, some) in places.chunks(PART).enumerate() {
        progress((part * PART) as f64 / places.len() as f64);
        let all: Vec<Result<Told>> = some.par_iter().map(|(artefact, place)| work.told(*artefact, place)).collect();
        for one in all {
            match one {
                Ok(told) => open.push(told),
                Err(why) => refused = Some(why),
            }
        }
    }
    if let (true, Some(why)) = (open.is_empty(), refused) {
        return Err(why);
    }
    // Terms, the tips, then the sizes of every artefact.
    let mut ranges: Vec<f64> = known.terms.terms.iter().map(|term| known.range(task, *term)).collect();
    let tips = ranges.len();
    ranges.extend(known.styli.iter().map(|_| task.probe.tip_uncertainty_mm.unwrap_or(TIP)));
    let mut sizes = Vec::new();
    for artefact in 0..task.artefacts.len() {
        sizes.push(ranges.len());
        let own = fixed.iter().chain(&open).find(|told| told.artefact == artefact);
        ranges.extend(own.into_iter().flat_map(|told| told.sizes.iter().copied()));
    }
    let whole = |told: Told| {
        let stylus = known.styli.iter().position(|stylus| *stylus == told.place.stylus_mm).unwrap_or(0);
        let own = sizes[told.artefact];
        let to: Vec<usize> = (0..tips).chain([tips + stylus]).chain(own..own + told.sizes.len()).collect();
        let information = told.local.spread(&to, ranges.len());
        let Told { artefact, place, minutes, spans, .. } = told;
        Candidate { artefact, place, minutes, information, spans }
    };
    let fixed: Vec<Candidate> = fixed.into_iter().map(whole).collect();
    let fixed_minutes = fixed.iter().map(|one| one.minutes).sum();
    Ok(All {
        fixed,
        fixed_minutes,
        open: open.into_iter().map(whole).collect(),
        prior: Information::of_ranges(&ranges),
    })
}

struct Work<'w> {
    task: &'w Task,
    machine: &'w Machine,
    known: &'w Known,
    /// Of a visit to the reference.
    reference_minutes: f64,
}

impl Work<'_> {
    /// The task with one place alone.
    fn alone(&self, artefact: usize, place: &Place) -> Task {
        let mut task = Task { reference: None, compensated: true, ..self.task.clone() };
        task.artefacts.iter_mut().for_each(|of| of.places.clear());
        task.artefacts[artefact].places.push(place.clone());
        task
    }

    fn told(&self, artefact: usize, place: &Place) -> Result<Told> {
        let task = self.alone(artefact, place);
        let plan = Plan::new(&task, self.machine)?;
        let observed = observe_terms(&task, self.machine, &plan, &planned(&task, &plan), self.known.terms.clone())?;
        let sizes = observed.sizes[artefact].iter().copied().chain(observed.lengths[artefact]);
        let sizes: Vec<usize> = sizes.collect();
        let keep: Vec<usize> = (0..=observed.network.tip).chain(sizes.iter().copied()).collect();
        let every = self.task.reference.as_ref().map_or(usize::MAX, |reference| reference.every.max(5));
        let count = plan.touches.len() / self.task.probe.repeats.max(1);
        let visits = 1.0 + count.div_ceil(every) as f64;
        let spanned = Terms::of(&task, self.machine, plan.reach_mm(&task)).terms;
        Ok(Told {
            artefact,
            spans: self.known.terms.terms.iter().map(|term| spanned.contains(term)).collect(),
            place: place.clone(),
            minutes: plan.minutes() + visits * self.reference_minutes + self.task.wishes.set_up_minutes,
            local: observed.network.information(&keep),
            sizes: sizes.iter().map(|index| observed.network.unknowns[*index].uncertainty.unwrap_or(SIZE)).collect(),
        })
    }

    /// Places of all artefacts without any.
    fn places(&self) -> Result<Vec<(usize, Place)>> {
        for most in [3, 2, 1] {
            let mut all = Vec::new();
            for (artefact, of) in self.task.artefacts.iter().enumerate().filter(|(_, of)| of.places.is_empty()) {
                let own = self.of_artefact(of, most)?;
                all.extend(own.into_iter().map(|place| (artefact, place)));
            }
            if all.len() <= MOST || most == 1 {
                all.truncate(MOST);
                return Ok(all);
            }
        }
        Ok(Vec::new())
    }

    fn of_artefact(&self, of: &Artefact, most: usize) -> Result<Vec<Place>> {
        let refuse =
            |found: String, needed: &str| super::error(self.task, of.line, "artefact.place", found, needed.into());
        let settings = &self.machine.settings;
        let mut travel: Range = LINEAR.map(|axis| settings.axis(axis).map_or([0.0; 2], |own| own.travel));
        if let Some(safe_z) = self.task.probe.safe_z_mm {
            travel[2][1] = travel[2][1].min(safe_z);
        }
        let mut all = Vec::new();
        let mut least: Option<String> = None;
        let orientations = self.orientations(of).map_err(|(found, needed)| refuse(found, needed))?;
        for stylus in &self.known.styli {
            let ideal = Ideal::new(&with_stylus(self.machine, *stylus))?;
            let [shortest, own] = [self.known.shortest(settings), *stylus].map(|stylus| tool_mm(settings, stylus));
            let stated = self.task.wishes.free_mm.unwrap_or(travel);
            let free: Range = std::array::from_fn(|k| stated[k].map(|q| q + shortest[k] - own[k]));
            let fixed = self.fixed(&ideal, *stylus);
            for place in &orientations {
                let place = Place { stylus_mm: *stylus, ..place.clone() };
                let still = Place { rotary_deg: vec![[0.0; 3]], ..place.clone() };
                let extent = Extent::new(self.task, &ideal, of, &still);
                let found = positions(&extent.room(&travel, &free), most);
                if found.is_empty() && least.is_none() {
                    least = Some(lacking(self.task, &extent, &travel, &free));
                }
                let is_free = |at: &[f64; 3]| {
                    fixed.iter().all(|(other, there)| is_beside(self.task, (&extent, *at), (other, *there)))
                };
                let at = found.into_iter().filter(is_free).map(|at_mm| Place { at_mm, ..place.clone() });
                all.extend(at.filter_map(|place| self.within_reach(&ideal, of, &travel, place)));
            }
        }
        if all.is_empty() {
            let needed = least.unwrap_or_else(|| "room beside the reference, which stays where it is".into());
            return Err(refuse(format!("{}, which fits nowhere", of.name), &needed));
        }
        Ok(all)
    }

    /// A place with those of its poses that the machine reaches; `None` if it turns nothing.
    fn within_reach(&self, ideal: &Ideal, of: &Artefact, travel: &Range, place: Place) -> Option<Place> {
        if place.rotary_deg.len() == 1 {
            return Some(place);
        }
        let is_reached = |pose: &[f64; 3]| {
            let still = Place { rotary_deg: vec![*pose], ..place.clone() };
            let ways = Extent::new(self.task, ideal, of, &still).ways;
            (0..3).all(|k| ways[k][0] + place.at_mm[k] >= travel[k][0] && ways[k][1] + place.at_mm[k] <= travel[k][1])
        };
        let rotary_deg: Vec<[f64; 3]> = place.rotary_deg.iter().copied().filter(is_reached).collect();
        (rotary_deg.len() > 1 && rotary_deg[0] == [0.0; 3]).then_some(Place { rotary_deg, ..place })
    }

    /// What stands on the table all the time.
    fn fixed(&self, ideal: &Ideal, stylus: Stylus) -> Vec<(Extent, [f64; 3])> {
        let reference = self.task.reference.iter().map(|reference| &self.task.artefacts[reference.artefact]);
        reference
            .map(|of| {
                let place = moved(&self.machine.settings, &of.places[0], stylus);
                (Extent::new(self.task, ideal, of, &place), place.at_mm)
            })
            .collect()
    }

    /// Places at the origin in every direction.
    fn orientations(&self, of: &Artefact) -> Result<Vec<Place>, (String, &'static str)> {
        let place = |normal: Axis, along: Axis, reversed: bool| Place {
            at_mm: [0.0; 3],
            normal,
            along,
            across: Axis::Y,
            reversed,
            base: false,
            turn: 0,
            rotary_deg: vec![[0.0; 3]],
            stylus_mm: None,
            line: of.line,
        };
        let normals = &self.task.wishes.normals;
        let rows = || {
            let of_normal =
                |normal: Axis| LINEAR.into_iter().filter(move |along| *along != normal).map(move |a| (normal, a));
            normals.iter().flat_map(move |normal| of_normal(*normal))
        };
        Ok(match of.kind {
            Kind::Ball { .. } => {
                let turned = |rotary_deg| Place { rotary_deg, ..place(Axis::Z, Axis::X, false) };
                patterns(self.task, self.machine).into_iter().map(turned).collect()
            }
            Kind::Ring { .. } | Kind::Plate { .. } => normals.iter().map(|n| place(*n, Axis::X, false)).collect(),
            Kind::Gauge { .. } => rows().map(|(normal, along)| place(normal, along, false)).collect(),
            Kind::Square { .. } => rows()
                .flat_map(|(normal, along)| [false, true].map(|over| (normal, along, over)))
                .filter(|(_, along, over)| !over || *along != Axis::Z)
                .map(|(normal, along, over)| place(normal, along, over))
                .collect(),
            _ => {
                let needed = "its [[artefact.place]]: balls, rings, ball plates, step gauges and squares are placed";
                return Err((format!("{} without places", of.name), needed));
            }
        })
    }
}
