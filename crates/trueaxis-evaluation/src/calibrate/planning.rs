//! Builds the plan of a task.

use super::artefact::{Artefact, Kind};
use super::dial::pose;
use super::faces;
use super::kinematics::Ideal;
use super::place::{Place, printed};
use super::plan::{Plan, Planned, Step, Visit};
use super::reach::{check_safe_z, check_steps, check_travel, check_ways, key_of};
use super::sheet;
use super::stylus;
use super::target::Target;
use super::task::Task;
use super::touches::of_place;
use anyhow::{Result, anyhow};
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// Speed of rapid moves for the estimate of time, mm/min.
const RAPID: f64 = 6000.0;
/// Time for a reading of a dial, s.
const READING_S: f64 = 20.0;

impl Plan {
    /// Plans a task on a machine; the machine's tables are not used.
    ///
    /// # Errors
    /// With the line of the task: a place outside the machine's travel, an axis that the machine lacks.
    pub fn new(task: &Task, machine: &Machine) -> Result<Plan> {
        if task.is_read() {
            return of_readings(task, machine);
        }
        let ideals = stylus::ideals(task, machine)?;
        let safe_z = safe_z(task, machine)?;
        check_steps(task)?;
        let mut plan = Plan { steps: Vec::new(), touches: Vec::new(), visits: Vec::new(), identity: 0 };
        let mut way = Way { task, machine, ideals: &ideals, safe_z, at: [0.0; AXES], time_s: 0.0, plan: &mut plan };
        let mut set_up = 0;
        for (index, artefact) in task.artefacts.iter().enumerate() {
            for (place, at) in artefact.places.iter().enumerate() {
                let text = set_up_text(task, artefact, at, place);
                way.plan.steps.push(Step::Pause(text));
                way.set_up(index, place, set_up)?;
                set_up += 1;
            }
        }
        check_travel(task, machine, &plan)?;
        check_ways(task, machine, &plan)?;
        plan.identity = identity(&plan, &[]);
        Ok(plan)
    }
}

/// The readings of a task's dials: every reading is a touch without a move.
fn of_readings(task: &Task, machine: &Machine) -> Result<Plan> {
    let mut plan = Plan { steps: Vec::new(), touches: Vec::new(), visits: Vec::new(), identity: 0 };
    for (artefact, of) in task.artefacts.iter().enumerate() {
        let Kind::Dial(dial) = &of.kind else { continue };
        for (feature, reading) in dial.readings.iter().enumerate() {
            let place = reading.placement;
            if plan.visits.last().is_none_or(|last| (last.artefact, last.place) != (artefact, place)) {
                let set_up = plan.visits.len();
                plan.visits.push(Visit { artefact, place, reference: false, set_up });
            }
            let start = pose(reading);
            plan.touches.push(Planned {
                artefact,
                place,
                feature,
                start,
                end: start,
                take_up: reading.at_mm,
                reverse: [0.0; 3],
                time_s: READING_S * (plan.touches.len() + 1) as f64,
                visit: plan.visits.len() - 1,
            });
        }
    }
    check_travel(task, machine, &plan)?;
    let readings = plan.touches.iter().filter_map(|touch| sheet::reading(task, touch));
    let more: Vec<f64> = readings
        .flat_map(|(dial, reading)| {
            let [x, y, _] = dial.contact(reading);
            [x, y, reading.spindle_deg, reading.side, reading.reads as f64]
        })
        .collect();
    plan.identity = identity(&plan, &more);
    Ok(plan)
}

fn safe_z(task: &Task, machine: &Machine) -> Result<f64> {
    let z = machine
        .settings
        .axis(Axis::Z)
        .ok_or_else(|| anyhow!("{}: found a machine without Z, needed one", task.file.display()))?;
    Ok(task.probe.safe_z_mm.unwrap_or(z.travel[1]))
}

fn set_up_text(task: &Task, artefact: &Artefact, place: &Place, index: usize) -> String {
    let [x, y, z] = place.at_mm;
    let normal = place.normal.letter();
    let how = match artefact.kind {
        Kind::Ring { .. } => format!("ring {}, its axis along {normal}", artefact.name),
        Kind::Ball { .. } => format!("ball {}", artefact.name),
        Kind::Plate { .. } => format!("ball plate {}, facing {normal}", artefact.name),
        Kind::Gauge { .. } => format!("step gauge {} along {}", artefact.name, place.along.letter()),
        Kind::Square { .. } => {
            let over = if place.reversed { ", turned over" } else { "" };
            format!("square {}, first arm along {}{over}", artefact.name, place.along.letter())
        }
        Kind::Block(ref block) => faces::set_up_text(artefact, block, place, &task.probe),
        Kind::Grid(ref grid) => {
            let how = grid.set_up_text(&artefact.name, place);
            return format!("set up {how}, place {}: its middle at X{x} Y{y} Z{z}", index + 1);
        }
        Kind::Dial(_) => artefact.name.clone(),
    };
    format!("set up {how}, place {}: X{x} Y{y} Z{z}{}", index + 1, stylus::words(place.stylus_mm))
}

/// State of the probe while a plan is built.
struct Way<'t> {
    task: &'t Task,
    machine: &'t Machine,
    /// With each stylus.
    ideals: &'t [Ideal],
    safe_z: f64,
    at: [f64; AXES],
    time_s: f64,
    plan: &'t mut Plan,
}

impl Way<'_> {
    /// Adds all touches of a place, with visits to the reference before, between and after.
    fn set_up(&mut self, artefact: usize, place: usize, set_up: usize) -> Result<()> {
        let of = &self.task.artefacts[artefact];
        let at = &of.places[place];
        let ideal = &self.ideals[self.task.stylus_of(set_up)];
        let targets = of_place(self.task, ideal, of, at, false);
        check_safe_z(self.task, &of.places[place], key_of(of), self.safe_z, &targets)?;
        let Some(reference) = self.task.reference.as_ref() else {
            return self.visit(artefact, place, set_up, false, &targets);
        };
        let every = reference.every.max(5);
        let ball = &self.task.artefacts[reference.artefact];
        let ball_at = stylus::moved(&self.machine.settings, &ball.places[0], at.stylus_mm);
        let check_touches = of_place(self.task, ideal, ball, &ball_at, true);
        check_safe_z(self.task, &ball_at, key_of(ball), self.safe_z, &check_touches)?;
        self.visit(reference.artefact, 0, set_up, true, &check_touches)?;
        for part in targets.chunks(every) {
            self.visit(artefact, place, set_up, false, part)?;
            self.visit(reference.artefact, 0, set_up, true, &check_touches)?;
        }
        Ok(())
    }

    fn visit(
        &mut self,
        artefact: usize,
        place: usize,
        set_up: usize,
        reference: bool,
        targets: &[Target],
    ) -> Result<()> {
        let name = self.task.artefacts[artefact].name.clone();
        let what = if reference { format!("reference {name}") } else { format!("{name}, place {}", place + 1) };
        self.plan.steps.push(Step::Remark(what));
        self.plan.visits.push(Visit { artefact, place, reference, set_up });
        let mut last: Option<&Target> = None;
        for target in targets {
            let above = |last: &Target| last.lift.is_some() && last.lift == target.lift;
            let stays = |last: &Target| last.pose == target.pose && (last.home == target.home || above(last));
            if !last.is_some_and(stays) {
                self.leave(last);
                self.enter(target);
            }
            self.touch(artefact, place, target);
            last = Some(target);
        }
        self.leave(last);
        Ok(())
    }

    /// Leaves and moves up.
    fn leave(&mut self, last: Option<&Target>) {
        if let Some(last) = last {
            self.feed(last.entry);
        }
        let mut up = [None; AXES];
        up[2] = Some(self.safe_z);
        self.rapid(up);
    }

    /// Moves over the artefact and down to it.
    fn enter(&mut self, target: &Target) {
        let [a, b, c] = target.pose;
        let turned = [a, b, c].into_iter().zip(&self.at[3..]).any(|(to, at)| to != *at);
        if turned {
            self.rapid([None, None, None, Some(a), Some(b), Some(c)]);
        }
        let [x, y, _] = target.entry;
        self.rapid([Some(x), Some(y), None, None, None, None]);
        self.feed(target.entry);
        self.feed(target.home);
    }

    fn touch(&mut self, artefact: usize, place: usize, target: &Target) {
        let probe = &self.task.probe;
        let lifted = |point: [f64; 3]| -> [f64; 3] {
            let height = target.lift.map_or(0.0, |lift| (0..3).map(|k| lift[k] * (target.home[k] - point[k])).sum());
            std::array::from_fn(|k| point[k] + height * target.lift.map_or(0.0, |lift| lift[k]))
        };
        let start: [f64; 3] = std::array::from_fn(|k| target.point[k] - probe.approach_mm * target.approach[k]);
        let end: [f64; 3] = std::array::from_fn(|k| target.point[k] + probe.overtravel_mm * target.approach[k]);
        let mut before = start;
        let mut reverse = [0.0; 3];
        for axis in 0..3 {
            let along = target.approach[axis];
            if along.abs() > 1e-6 {
                reverse[axis] = f64::from(u8::from(along < 0.0));
            } else {
                // An axis that does not move while probing arrives from one side.
                let from = if target.from_above[axis] { 1.0 } else { -1.0 };
                before[axis] += from * probe.take_up_mm;
                reverse[axis] = f64::from(u8::from(target.from_above[axis]));
            }
        }
        for _ in 0..probe.repeats {
            self.feed(lifted(before));
            self.feed(before);
            self.feed(start);
            let [a, b, c] = target.pose;
            let whole = |[x, y, z]: [f64; 3]| [x, y, z, a, b, c];
            self.time_s += 60.0 * probe.approach_mm / probe.probe_feed_mm_per_min;
            self.plan.steps.push(Step::Probe(self.plan.touches.len()));
            self.plan.touches.push(Planned {
                artefact,
                place,
                feature: target.feature,
                start: whole(start).map(printed),
                end: whole(end).map(printed),
                take_up: before,
                reverse,
                time_s: self.time_s,
                visit: self.plan.visits.len() - 1,
            });
            // Wherever the trip stopped it, the probe returns to the start.
            (0..3).for_each(|k| self.at[k] = end[k]);
            self.feed(start);
            self.feed(lifted(start));
        }
        self.feed(target.home);
    }

    fn feed(&mut self, to: [f64; 3]) {
        let to = to.map(printed);
        let far: f64 = (0..3).map(|k| (to[k] - self.at[k]).powi(2)).sum::<f64>().sqrt();
        if far < 1e-6 && self.plan.steps.len() > 1 {
            return;
        }
        self.time_s += 60.0 * far / self.task.probe.feed_mm_per_min;
        (0..3).for_each(|k| self.at[k] = to[k]);
        self.plan.steps.push(Step::Feed(to));
    }

    fn rapid(&mut self, to: [Option<f64>; AXES]) {
        let to = to.map(|value| value.map(printed));
        let far: f64 = (0..3).map(|k| (to[k].unwrap_or(self.at[k]) - self.at[k]).powi(2)).sum::<f64>().sqrt();
        self.time_s += 60.0 * far / RAPID;
        (0..AXES).for_each(|k| self.at[k] = to[k].unwrap_or(self.at[k]));
        self.plan.steps.push(Step::Rapid(to));
    }
}

/// Checksum of the touch positions and of what else tells two plans apart.
fn identity(plan: &Plan, more: &[f64]) -> u32 {
    let mut bytes = Vec::new();
    for touch in &plan.touches {
        touch.start.iter().chain(&touch.end).for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
    }
    more.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
    trueaxis::tcomp::checksum(&bytes)
}
