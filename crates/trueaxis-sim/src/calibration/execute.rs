//! Execution of a probing program.

use super::artefact::Artefact;
use super::correction::{Sent, with_correction};
use crate::error::{Result, SimError};
use crate::program::{Program, ReadOptions};
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::fmt::Write;
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Speed of rapid moves, mm/min.
const RAPID: f64 = 6000.0;
/// Most iterations of a probing move towards the surface.
const STEPS: usize = 400;
/// A gap up to this counts as contact, mm.
const CLOSED: f64 = 1e-9;

/// The control that executes the program; it determines the format of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Host {
    /// `(LOG,…)` with parameters #5061 to #5070.
    LinuxCnc,
    /// `[MSG:…]` and `[PRB:…]` on the console.
    GrblHal,
    /// `// trueaxis touch 17 X:… Y:… Z:… tripped:1` on the console; executes the program of LinuxCNC, in which every touch is
    /// the same.
    Klipper,
}

/// Movement of the workpiece's frame relative to the tool: a constant rate, and a part that settles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drift {
    /// mm per hour.
    pub rate: DVec3,
    /// Final value of the settling part, mm.
    pub settles: DVec3,
    /// Time in which it reaches 63 % of that, s.
    pub lag_s: f64,
}

impl Drift {
    pub(crate) fn at(&self, time_s: f64) -> DVec3 {
        let share = if self.lag_s > 0.0 { 1.0 - libm::exp(-time_s / self.lag_s) } else { 0.0 };
        self.rate * (time_s / 3600.0) + self.settles * share
    }
}

/// The set-up on the machine, and the probe.
#[derive(Clone, Debug)]
pub struct Probing {
    /// The machine with its true errors.
    pub machine: Machine,
    /// The machine whose tables correct it during the program; `None` if it is not corrected.
    pub known: Option<Machine>,
    /// Artefacts from the first pause on, from the second on, ….
    pub set_ups: Vec<Vec<Artefact>>,
    /// Tip from the last tool-side frame from the first pause on, from the second on, …, mm; the machine's where there is none.
    pub tools_mm: Vec<[f64; 3]>,
    /// Radius of the tip, mm.
    pub tip_radius_mm: f64,
    /// Deflection before the trip, mm.
    pub pre_travel_mm: f64,
    /// Amplitude of its variation around the tip, with three lobes, mm.
    pub lobes_mm: f64,
    /// Standard deviation of a touch, mm.
    pub noise_mm: f64,
    /// The drift.
    pub drift: Drift,
    /// Duration of every pause, s.
    pub pause_s: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// The control.
    pub host: Host,
}

/// Executes a program and returns the log.
///
/// # Errors
/// A program that cannot be read; a probing move that touches nothing, or a move that ends inside an artefact, with its line.
pub fn execute(probing: &Probing, program: &str) -> Result<String> {
    match &probing.known {
        None => executed(probing, program, &|position, _| *position),
        Some(known) => with_correction(&probing.machine.settings, known, |sent| executed(probing, program, sent)),
    }
}

fn executed(probing: &Probing, program: &str, sent: &Sent<'_>) -> Result<String> {
    let options = ReadOptions { offsets: Some(Default::default()), ..ReadOptions::default() };
    let read = Program::read("probing", program.as_bytes(), "probe.ngc", &options)?;
    let mut bench = Bench {
        geometry: Geometry::new(&probing.machine, 0.0)?,
        probing,
        sent,
        slots: slots(&probing.machine),
        plays: plays(&probing.machine),
        at: [0.0; AXES],
        behind: [0.0; AXES],
        time_s: 0.0,
        set_up: None,
        trip: [0.0; AXES],
        noise: ChaCha8Rng::seed_from_u64(probing.seed),
        log: String::new(),
        line: 0,
    };
    let mut moves = read.moves.iter().peekable();
    for (line, text) in (1..).zip(program.lines()) {
        bench.line = line;
        let mut probed = false;
        while let Some(next) = moves.next_if(|next| next.line == line) {
            let (_, last) = next.curve.domain();
            let [x, y, z] = next.curve.position(last);
            let [a, b, c] = next.turn.end();
            let end = [x, y, z, a, b, c];
            let feed = if next.rapid { RAPID } else { next.feed_per_min };
            if next.probe {
                bench.probe(end, feed)?;
                probed = true;
            } else {
                bench.go(end, feed)?;
            }
        }
        bench.listen(text, probed)?;
    }
    Ok(bench.log)
}

fn slots(machine: &Machine) -> [Option<usize>; AXES] {
    let mut slots = [None; AXES];
    for (slot, own) in machine.settings.axes.iter().enumerate() {
        slots[own.axis.index()] = Some(slot);
    }
    slots
}

fn plays(machine: &Machine) -> [f64; AXES] {
    let mut plays = [0.0; AXES];
    machine.settings.axes.iter().for_each(|own| plays[own.axis.index()] = own.backlash.abs());
    plays
}

struct Bench<'p> {
    probing: &'p Probing,
    sent: &'p Sent<'p>,
    geometry: Geometry,
    slots: [Option<usize>; AXES],
    plays: [f64; AXES],
    /// X, Y, Z, A, B, C.
    at: [f64; AXES],
    /// Share of its play by which each axis lags: 0 after positive, 1 after negative travel.
    behind: [f64; AXES],
    time_s: f64,
    set_up: Option<usize>,
    trip: [f64; AXES],
    noise: ChaCha8Rng,
    log: String,
    line: u32,
}

impl Bench<'_> {
    /// The position part of the way to `end`, and the state of the plays there.
    fn on_the_way(&self, end: &[f64; AXES], share: f64) -> ([f64; AXES], [f64; AXES]) {
        let at = std::array::from_fn(|k| self.at[k] + share * (end[k] - self.at[k]));
        let behind = std::array::from_fn(|k| {
            let by = share * (end[k] - self.at[k]);
            let play = self.plays[k].max(1e-6);
            (self.behind[k] - by / play).clamp(0.0, 1.0)
        });
        (at, behind)
    }

    fn ordered(&self, by_letter: &[f64; AXES]) -> [f64; AXES] {
        let mut ordered = [0.0; AXES];
        for (slot, value) in self.slots.iter().zip(by_letter) {
            if let Some(to) = slot.and_then(|slot| ordered.get_mut(slot)) {
                *to = *value;
            }
        }
        ordered
    }

    fn tip(&self, at: &[f64; AXES], behind: &[f64; AXES], time_s: f64) -> DVec3 {
        let reverse = self.ordered(behind);
        let tip = self.geometry.actual_pose(&(self.sent)(&self.ordered(at), &reverse), &reverse).tip_mm;
        DVec3::from(tip) + self.probing.drift.at(time_s)
    }

    /// The nearest surface: its gap and normal.
    fn nearest(&self, tip: DVec3) -> (f64, DVec3) {
        let surfaces = self.set_up.and_then(|set_up| self.probing.set_ups.get(set_up)).into_iter().flatten();
        surfaces
            .map(|surface| {
                let (_, normal) = surface.gap(tip, self.probing.tip_radius_mm);
                let turn = 3.0 * libm::atan2(normal.y, normal.x);
                let given = self.probing.pre_travel_mm + self.probing.lobes_mm * libm::cos(turn);
                surface.gap(tip, self.probing.tip_radius_mm - given)
            })
            .fold((f64::INFINITY, DVec3::ZERO), |near, one| if one.0 < near.0 { one } else { near })
    }

    fn length(&self, end: &[f64; AXES]) -> f64 {
        let linear: f64 = (0..3).map(|k| (end[k] - self.at[k]).powi(2)).sum();
        linear.sqrt()
    }

    fn error(&self, found: String, needed: &str) -> SimError {
        let found = format!("found {found}");
        SimError::Line { program: "probing".into(), line: self.line, found, needed: needed.into() }
    }

    fn go(&mut self, end: [f64; AXES], feed: f64) -> Result<()> {
        let length = self.length(&end);
        self.time_s += 60.0 * length / feed.max(1.0);
        let (at, behind) = self.on_the_way(&end, 1.0);
        (self.at, self.behind) = (at, behind);
        let (gap, _) = self.nearest(self.tip(&at, &behind, self.time_s));
        if gap < -0.01 {
            return Err(self.error(format!("a move that ends {:.3} mm inside an artefact", -gap), "a free way"));
        }
        Ok(())
    }

    fn probe(&mut self, end: [f64; AXES], feed: f64) -> Result<()> {
        let length = self.length(&end).max(1e-9);
        let started = self.time_s;
        let noise: f64 = StandardNormal.sample(&mut self.noise);
        let mut share = 0.0;
        for _ in 0..STEPS {
            let (at, behind) = self.on_the_way(&end, share);
            self.time_s = started + 60.0 * share * length / feed.max(1.0);
            let (gap, _) = self.nearest(self.tip(&at, &behind, self.time_s));
            // A tip behind the surface steps back: an axis whose scale is too long overshoots by the remaining distance times
            // its scale error.
            if gap.abs() <= CLOSED || (gap < 0.0 && share <= 0.0) {
                // The probe's scatter lies along its travel.
                let (at, _) = self.on_the_way(&end, share + self.probing.noise_mm * noise / length);
                self.trip = at;
                (self.at, self.behind) = (at, behind);
                return Ok(());
            }
            if share >= 1.0 && gap > 0.0 {
                break;
            }
            share = (share + gap / length).clamp(0.0, 1.0);
        }
        Err(self.error("a probing move that touches nothing".into(), "an artefact on its way"))
    }

    /// Handles comments that the control acts on, and pauses.
    fn listen(&mut self, text: &str, probed: bool) -> Result<()> {
        if probed && self.probing.host == Host::GrblHal {
            let axes = self.probing.machine.settings.axes.iter().map(|own| own.axis.index());
            let count = axes.max().map_or(3, |last| last + 1).max(3);
            let values: Vec<String> = self.trip.iter().take(count).map(|value| format!("{value:.4}")).collect();
            let _ = write!(self.log, "[PRB:{}:1]\nok\n", values.join(","));
        }
        let comment = |name: &str| {
            let (_, rest) = text.split_once(name)?;
            rest.split(')').next()
        };
        match self.probing.host {
            Host::LinuxCnc | Host::Klipper => {
                if let Some(text) = comment("(LOG,") {
                    let expanded = self.expanded(text);
                    let line = if self.probing.host == Host::Klipper { of_klipper(&expanded) } else { expanded };
                    let _ = writeln!(self.log, "{line}");
                }
            }
            Host::GrblHal => {
                if let Some(text) = comment("(MSG,") {
                    let _ = writeln!(self.log, "[MSG:{text}]");
                }
            }
        }
        if text.trim() == "M0" {
            self.time_s += self.probing.pause_s;
            let set_up = self.set_up.map_or(0, |set_up| set_up + 1);
            self.set_up = Some(set_up);
            if let Some(tool_mm) = self.probing.tools_mm.get(set_up) {
                let mut machine = self.probing.machine.clone();
                machine.settings.tool_mm = *tool_mm;
                self.geometry = Geometry::new(&machine, 0.0)?;
            }
        }
        Ok(())
    }

    /// Replaces parameters: #5061 to #5066 are the trip, #5070 whether there was one.
    fn expanded(&self, text: &str) -> String {
        let mut out = String::new();
        for word in text.split(' ') {
            if !out.is_empty() {
                out.push(' ');
            }
            match word.strip_prefix('#').and_then(|number| number.parse::<usize>().ok()) {
                Some(5070) => out.push_str("1.000000"),
                Some(number) => {
                    let value = number.checked_sub(5061).and_then(|k| self.trip.get(k)).copied().unwrap_or_default();
                    let _ = write!(out, "{value:.6}");
                }
                None => out.push_str(word),
            }
        }
        out
    }
}

/// A line of LinuxCNC's log as the macro of integrations/klipper prints it.
fn of_klipper(line: &str) -> String {
    let words: Vec<&str> = line.split(' ').collect();
    match words.as_slice() {
        ["touch", id, x, y, z, ..] => format!("// trueaxis touch {id} X:{x} Y:{y} Z:{z} tripped:1"),
        _ => format!("// {line}"),
    }
}
